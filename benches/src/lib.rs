//! The scenes that the benchmarks share, where their device is, where their [`results`] are, and what
//! the [`papers`] print of theirs.

pub mod papers;
pub mod results;

use tetrascope::core::Volume;
use tetrascope::gpu::Gpu;
use tetrascope::scene::Scene;
use tetrascope::{Context, volumes};

/// The device, or why there is none.
pub fn gpu<'a>(context: &'a Context, bench: &str) -> Option<&'a Gpu> {
    let skipped = |error: &_| eprintln!("skipped: {bench}: {error}");
    context.gpu().inspect_err(skipped).ok()
}

/// A volume and its scene.
pub struct Case {
    /// "sphere/149k cells".
    pub name: String,
    /// The volume that is drawn.
    pub volume: Volume,
    /// How and from where.
    pub scene: Scene,
}

/// Pixels per side.
const SIDE: u32 = 256;

/// The data sets of the papers, at the papers' sizes.
///
/// Panics where a data set does not load: there is nothing to measure then.
pub fn cases() -> Vec<Case> {
    ["sphere", "heat-sink"].into_iter().map(case).collect()
}

fn case(dataset: &str) -> Case {
    let mut file = volumes::scene(tetrascope::datasets::find(dataset).expect("listed"));
    (file.image.width, file.image.height) = (Some(SIDE), Some(SIDE));
    let volume = volumes::load(&file.volume).expect("data sets load").volume;
    let scene = file.resolve(&volume).expect("data sets have valid scenes");
    let thousands = (volume.cell_count() + 500) / 1000;
    Case {
        name: format!("{dataset}/{thousands}k cells"),
        volume,
        scene,
    }
}
