//! How much longer the ground truth takes for a case than for a benign mesh of as many cells, for each
//! cell that rays cross: a ray along a row of 200 cells crosses more of them than one through a cube.

use std::collections::BTreeMap;

use tetrascope::core::{Appearance, Error};

use super::case::{Case, Expected, Shot};
use super::judge::Truth;
use super::scenes::{Pieces, plain, waves, whole};

/// No case may take it longer than this many times.
pub(super) const MOST: f64 = 20.0;

/// Pictures of which the quickest counts: a machine has other things to do.
const TRIES: u32 = 3;

/// More knots than this are most of a ray's pieces, on any mesh.
const MANY_KNOTS: usize = 16;

/// A case's time over that of the benign mesh, a crossed cell each; of several pictures the greatest. The
/// worst first.
pub(super) fn ratios(cases: &[Case]) -> Result<Vec<(String, f64)>, Error> {
    let mut benign = BTreeMap::new();
    let mut ratios = Vec::new();
    for case in cases {
        let mut greatest: f64 = 0.0;
        for shot in &case.shots {
            let n = cubes(shot.volume.cell_count());
            let knots = shot.appearance.transfer_function.knots().len();
            let look = if knots > MANY_KNOTS {
                shot.appearance.clone()
            } else {
                plain()
            };
            let kind = (n, look.transfer_function.knots().len());
            let time = match benign.get(&kind) {
                Some(time) => *time,
                None => {
                    let time = a_crossing(&benign_shot(n, look))?;
                    benign.insert(kind, time);
                    time
                }
            };
            greatest = greatest.max(a_crossing(shot)? / time);
        }
        ratios.push((format!("{case:?}"), greatest));
    }
    ratios.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(ratios)
}

/// The three worst, in a sentence.
pub(super) fn sentence(ratios: &[(String, f64)]) -> String {
    let worst = ratios.iter().take(3);
    let worst: Vec<String> = worst
        .map(|(case, ratio)| format!("{ratio:.1} ({case})"))
        .collect();
    format!(
        "For each cell that rays cross, the ground truth took at most so many times as long as for a benign mesh of \
         as many cells: {}.",
        worst.join(", ")
    )
}

/// Cubes along a side of a mesh of about so many cells.
fn cubes(cells: usize) -> usize {
    ((cells as f64 / 6.0).cbrt().round() as usize).max(1)
}

fn benign_shot(n: usize, look: Appearance) -> Shot {
    let volume = Pieces::cube(n, 0.2, waves).volume();
    let view = whole(&volume);
    Shot::new(volume, look, view)
}

/// Seconds a crossed cell; a ray that crosses none is one.
fn a_crossing(shot: &Shot) -> Result<f64, Error> {
    let mut least = f64::INFINITY;
    for _ in 0..TRIES {
        let truth = Truth::of(shot, &Expected::Truth)?;
        let pixels = u64::from(shot.view.width) * u64::from(shot.view.height);
        // Hundreds of rays, so that starting threads is not all that is measured.
        let crossings = truth.visits() + pixels.max(256);
        least = least.min(truth.time.as_secs_f64() / crossings as f64);
    }
    Ok(least)
}
