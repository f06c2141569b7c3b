//! The algorithm's entry: its settings, what it draws, how near to the truth.

use tetrascope_core::{
    Appearance, Entry, Error, OpticalModel, Promise, Setting, Settings, Volume, VolumeKind,
};

use crate::options::RaycastCpuOptions;
use crate::{ABILITIES, NAME};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "ray casting from cell to cell on the CPU, in SIMD",
    paper: "M. Garrity, \"Raytracing Irregular Volume Data\", Computer Graphics 24(5), 1990, \
            pp. 35-40, doi:10.1145/99308.99316",
    draws: "any mesh, in memory or in clusters, and any regular grid in memory, in every optical model, without a graphics \
            adapter; where cells of a mesh overlap, in the order in which they are connected",
    settings: &[
        Setting::number("stop-opacity", [0.5, 1.0], "1")
            .about("the opacity at which a ray stops; 1 is exact"),
        Setting::number("tolerance", [1e-7, 0.1], "1e-6")
            .about("how far one segment's light may be off, relative to the greatest; grids only")
            .only(VolumeKind::Grid),
        Setting::integer("memory", [16, 1_000_000], "2000")
            .about("memory for clusters and what rays gather in them, MB; meshes in clusters only")
            .only(VolumeKind::Clusters),
    ],
    sweep,
    promise,
    sources: &[],
    figures: None,
    counters: crate::counters::ALL,
    supports: |volume, appearance, _, _| supports(volume, appearance),
};

fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::EmissionAbsorption => &[
            "",
            "stop-opacity=0.999",
            "stop-opacity=0.95",
            "tolerance=0.1,stop-opacity=0.95",
        ],
        _ => &[""],
    }
}

/// How far segments' errors add up to depends on the grid; meshes are exact all the same.
fn promise(settings: &Settings) -> Promise {
    let left_out = 1.0 - settings.number("stop-opacity");
    match settings.number("tolerance") <= 1e-6 {
        true if left_out == 0.0 => Promise::Exact,
        true => Promise::Within(left_out),
        false => Promise::Open,
    }
}

impl RaycastCpuOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> RaycastCpuOptions {
        RaycastCpuOptions {
            stop_opacity: settings.number("stop-opacity") as f32,
            tolerance: settings.number("tolerance"),
            domain: None,
            memory: 1_000_000 * settings.integer("memory") as u64,
            threads: None,
        }
    }
}

/// Refuses what is not drawn: parts of an appearance, and a grid that stays in its file.
///
/// # Errors
/// [`Error::Unsupported`] with the reason, and what
/// [`Appearance::validate_in`](tetrascope_core::Appearance::validate_in) refuses.
pub fn supports(volume: &Volume, appearance: &Appearance) -> Result<(), Error> {
    match volume {
        Volume::Mesh(_) | Volume::Grid(_) | Volume::Clusters(_) => {
            ABILITIES.check(NAME, appearance, &volume.bounds())
        }
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "a grid that stays in its file".into(),
            reason: "its rays need all samples in memory".into(),
        }),
    }
}
