//! How the time of a frame grows with cells and with pixels: each algorithm with its defaults, one size
//! after the other.

use indicatif::ProgressBar;
use tetrascope::core::{Error, OpticalModel};
use tetrascope::{Context, volumes};

use super::contender::Contender;
use super::plan::Plan;
use crate::output::phase;
use crate::report::{Outcome, Scaling};

/// A mesh and a grid, each with its sizes in cells: a factor of four each, which doubles resolution in
/// two of three axes.
const VOLUMES: [(&str, [u64; 4]); 2] = [
    ("sphere", [10_000, 40_000, 160_000, 640_000]),
    ("angiography", [40_000, 160_000, 640_000, 2_560_000]),
];

/// Pixels per side.
const SIDES: [u32; 4] = [64, 128, 256, 512];

/// The sizes that stay while the other changes: cells of the second size, and pixels of the third.
const FIXED: (usize, u32) = (1, 256);

/// Measures every algorithm that draws one of the two.
pub(super) fn measure(
    context: &Context,
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<Vec<Scaling>, Error> {
    let mut all = Vec::new();
    for (dataset, sizes) in VOLUMES {
        let cells = sizes.map(|cells| (cells, FIXED.1));
        let pixels = SIDES.map(|side| (sizes[FIXED.0], side));
        let mut found: Vec<Scaling> = plan
            .algorithms
            .iter()
            .map(|algorithm| Scaling::new(algorithm.name, dataset))
            .collect();
        for (cells, side) in cells {
            phase(progress, &format!("scaling: {dataset} of {cells} cells"));
            step(context, plan, (dataset, cells, side), |i, times| {
                found[i].cells.push(times);
            })?;
        }
        for (cells, side) in pixels {
            phase(progress, &format!("scaling: {dataset} at {side}x{side}"));
            step(context, plan, (dataset, cells, side), |i, (_, ms)| {
                found[i].pixels.push((f64::from(side * side), ms));
            })?;
        }
        all.extend(found.into_iter().filter_map(Scaling::fitted));
    }
    Ok(all)
}

/// Draws one size with every algorithm; `take` gets its number, the cells that there are and the
/// median time in milliseconds.
fn step(
    context: &Context,
    plan: &Plan,
    (dataset, cells, side): (&str, u64, u32),
    mut take: impl FnMut(usize, (f64, f64)),
) -> Result<(), Error> {
    let mut file = volumes::scene(tetrascope::datasets::find(dataset)?);
    file.volume.cells = Some(cells);
    (file.image.width, file.image.height) = (Some(side), Some(side));
    let volume = volumes::load(&file.volume)?.volume;
    let scene = super::resolve(&file, OpticalModel::EmissionAbsorption, &volume)?;
    let mut contenders = Vec::new();
    for &algorithm in &plan.algorithms {
        let mut contender = Contender::new(context, (algorithm, ""), &volume, &scene)?;
        contender.draw(&scene, 0);
        contenders.push(contender);
    }
    for round in 1..=plan.repeat {
        for contender in &mut contenders {
            contender.draw(&scene, round);
        }
    }
    for (i, contender) in contenders.iter().enumerate() {
        if let Outcome::Drawn(drawn) = contender.outcome(None) {
            take(i, (volume.cell_count() as f64, drawn.frame_ms));
        }
    }
    Ok(())
}
