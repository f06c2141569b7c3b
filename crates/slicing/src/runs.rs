//! How many slabs of a ray one fragment takes (`rays.wgsl`), by what their loops may come to.

use tetrascope_core::OpticalModel;
use tetrascope_shaders::loops::RUN_PASSES;

/// The numbers on which the loops of a slab depend.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    pub(crate) model: OpticalModel,
    /// Intervals of the transfer function.
    pub(crate) intervals: usize,
    pub(crate) surfaces: usize,
    /// Whether pieces of slabs may be taken in parts.
    pub(crate) in_parts: bool,
    /// Whether slabs are looked at cell by cell.
    pub(crate) by_cells: bool,
}

/// Cells that a slab crosses, as in `slab.wgsl`, each with the search for the next plane and the
/// layers of its corners.
const MOST_CELLS: u64 = 13;
const NEXT_PLANE: u64 = 4;
const LAYERS: u64 = 3;

/// Passes of a slab: two ends, for each of which boxes are sought, and what a branch around a loop takes.
const ENDS: u64 = 16;

/// Passes of a run: eight neighbors with parts beyond the first of each piece. Each has an optical depth
/// of 1, and a ray ends at the opaque depth, so they are 48 at most, as `LOOPS` has them for a slab;
/// or with what is met of a surface, which ends a run, 24 halvings.
const ONCE: u64 = 8 * 64;

/// Slabs of a fragment at most, and at least 1.
///
/// Eight neighbors count together, and what one does in a pass of the loop over ends of slabs the
/// others wait for. So the work of n slabs, which have two ends each, counts 2 n − 1 times, as
/// nothing is done at the first.
pub(crate) fn slabs_per_run(work: Work) -> u32 {
    let slab = passes_of_slab(work);
    let slabs = (u64::from(RUN_PASSES) - ONCE + slab) / (2 * slab + ENDS);
    u32::try_from(slabs).expect("fewer than passes").max(1)
}

/// Passes of all loops of a slab that eight neighbors take at most.
fn passes_of_slab(work: Work) -> u64 {
    // A loop of n passes counts n + 1.
    let search = |n: usize| 2 + u64::from(n.max(1).ilog2());
    let cells = match work.by_cells {
        true => MOST_CELLS * (1 + NEXT_PLANE + LAYERS) + 1,
        false => 0,
    };
    if work.model == OpticalModel::Isosurfaces {
        let between = search(work.surfaces);
        // The joint, the extremes and three parts.
        let cubic = 2 * between + 3 * (1 + between) + 1;
        return cells + MOST_CELLS.min(1 + cells) * cubic;
    }
    // A pass for each interval, and one and a test for its parts.
    let each = if work.in_parts { 3 } else { 1 };
    cells + MOST_CELLS.min(1 + cells) * search(work.intervals) + each * work.intervals as u64
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::loops::MOST_KNOTS;

    use super::*;

    /// One slab never takes more than there is, and usual ones leave room for hundreds.
    #[test]
    fn a_run_has_as_many_slabs_as_loops_may_take() {
        for model in OpticalModel::ALL {
            for (in_parts, by_cells) in [(false, false), (true, false), (false, true), (true, true)]
            {
                for count in [1, 3, 100, MOST_KNOTS + 1] {
                    let work = Work {
                        model,
                        intervals: count,
                        surfaces: count,
                        in_parts,
                        by_cells,
                    };
                    let slabs = u64::from(slabs_per_run(work));
                    let taken = (2 * slabs - 1) * passes_of_slab(work) + slabs * ENDS + ONCE;
                    assert!(
                        slabs > 0 && taken <= u64::from(RUN_PASSES),
                        "{work:?}: {taken}"
                    );
                    assert!(slabs >= 40 || count > 3, "{work:?}: {slabs}");
                }
            }
        }
    }
}
