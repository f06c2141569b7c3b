//! How far one dispatch goes, so that no device ends it.
//!
//! Mesa's llvmpipe (22.3.6) lets all loops of 8 neighboring invocations together make 65 535
//! passes; then it ends them and goes on behind them, in silence. A loop of n passes takes
//! n + 1, once more where a branch around it is not taken, and of 8 invocations the longest
//! counts: in a loop within a loop, the longest in each pass of the outer one. Other devices are
//! reset when a dispatch takes seconds. So `march.wgsl` bounds what 8 rays can take whatever
//! each of them does:
//!
//! - The loop that follows a path is the only one in which cells and intervals are passed. A
//!   pass takes [`Budget::passes_per_cell`]: itself and the loops in it, each with one pass that
//!   fails. Loops over the parts of a deep piece (`optics.wgsl`, `cue.wgsl`) take
//!   more than that one time for each unit of optical depth. A ray stops behind 100, and the
//!   last piece has at most 24 parts; so 8 rays take at most [`PARTS`] more.
//! - It ends after `cells` passes, and one more on a step of the transfer function: a round.
//! - A batch is a search of at most `entries` passes and [`ROUNDS`] rounds, for all rays of a
//!   tile at the same time. So batches add up, and their number is the same for all rays.

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_shaders::loops::MARCH_PASSES;

/// Rounds of a batch, as in `march.wgsl`.
const ROUNDS: u32 = 8;

/// The passes that the parts of deep pieces take: see above.
const PARTS: u32 = 8 * (100 + 24);

/// Clip planes and peeled layers, 16 each, before a ray begins, with some room.
const BEFORE: u32 = 100;

/// Most isosurfaces, and most lights: each takes a pass in each cell, or once in each ray.
const MOST_ITEMS: usize = 1000;

/// How far one dispatch goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Budget {
    /// Entries of a tile's list that the first search looks at.
    pub(crate) first_entries: u32,
    /// Passes of each of the first eight rounds: most rays have one path or a few long ones.
    pub(crate) first_cells: u32,
    /// Entries of a tree that a later search looks at; a later search of a list looks at all.
    pub(crate) entries: u32,
    /// Passes of later rounds: rays with many paths have short ones.
    pub(crate) cells: u32,
    /// Passes of all later batches.
    pub(crate) later: u32,
    /// Passes of loops within one pass of the loop that follows paths.
    pub(crate) passes_per_cell: u32,
}

impl Budget {
    /// A budget for pictures of `appearance`.
    ///
    /// # Errors
    /// More isosurfaces or lights than a dispatch looks at in one cell.
    pub(crate) fn new(appearance: &Appearance) -> Result<Budget, Error> {
        let is_surfaces = appearance.optical_model == OpticalModel::Isosurfaces;
        let items = |what: &str, count: usize| match count {
            0..=MOST_ITEMS => Ok(count as u32),
            _ => Err(Error::TooLarge {
                what: what.into(),
                needed: count as u64,
                limit: MOST_ITEMS as u64,
                unit: "in one picture",
            }),
        };
        let (surfaces, lights) = match is_surfaces {
            true => (
                items("isosurfaces", appearance.isosurfaces.len())?,
                items("lights", appearance.lighting.lights.len())?,
            ),
            false => (0, 0),
        };
        // Itself, the loop over surfaces or parts, and that over lights.
        let passes_per_cell = 1 + (surfaces + 1) + 1;
        // Eight rays meet a surface once each.
        let once = BEFORE + PARTS + 8 * (lights + 2);
        let first_cells = (24_000 / ROUNDS / passes_per_cell).max(2) - 1;
        let mut budget = Budget {
            first_entries: 1 << 14,
            first_cells,
            entries: 128,
            cells: (48 / passes_per_cell).max(1),
            later: 0,
            passes_per_cell,
        };
        let first = budget.first_entries + 2 + budget.rounds(first_cells);
        budget.later = MARCH_PASSES.saturating_sub(once + first);
        Ok(budget)
    }

    /// The passes of a batch's rounds.
    fn rounds(&self, cells: u32) -> u32 {
        // The round itself, the loop's last test, and one pass more on a step.
        ROUNDS * (2 + (cells + 1) * self.passes_per_cell) + 1
    }

    /// The constants of `march.wgsl`.
    pub(crate) fn constants(&self) -> [(&'static str, f64); 6] {
        [
            ("FIRST_ENTRIES", f64::from(self.first_entries)),
            ("FIRST_CELLS", f64::from(self.first_cells)),
            ("ENTRIES", f64::from(self.entries)),
            ("CELLS", f64::from(self.cells)),
            // A batch, its search's last test, and its rounds.
            ("BATCH", f64::from(2 + self.rounds(self.cells))),
            ("LATER", f64::from(self.later)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::{Isosurface, Knot, TransferFunction};

    use super::*;

    /// Whatever is drawn, a dispatch ends before the device ends it, and goes on.
    #[test]
    fn budgets_are_below_the_cap() {
        let knot = |scalar| Knot {
            scalar,
            color: tetrascope_core::glam::DVec3::ONE,
            extinction: 1.0,
        };
        let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid knots");
        for (model, surfaces) in [
            (OpticalModel::EmissionAbsorption, 0),
            (OpticalModel::Isosurfaces, 1),
            (OpticalModel::Isosurfaces, 3),
            (OpticalModel::Isosurfaces, 100),
            (OpticalModel::Isosurfaces, MOST_ITEMS),
        ] {
            let mut appearance = Appearance::new(function.clone(), model);
            let surface = Isosurface {
                value: 0.5,
                color: tetrascope_core::glam::DVec3::ONE,
            };
            appearance.isosurfaces = vec![surface; surfaces];
            let budget = Budget::new(&appearance).expect("few");
            assert!(budget.first_cells >= 1 && budget.cells >= 1);
            let first = budget.first_entries + 2 + budget.rounds(budget.first_cells);
            let all = first + budget.later + PARTS + BEFORE;
            assert!(all <= MARCH_PASSES, "{surfaces}: {all}");
            appearance.isosurfaces = vec![surface; MOST_ITEMS + 1];
            let refused = Budget::new(&appearance);
            assert_eq!(refused.is_err(), model == OpticalModel::Isosurfaces);
        }
    }
}
