//! Every loop of every program: what bounds it, and the greatest number of its passes.
//!
//! Devices end loops that take too long. Some say so (a watchdog, and the device is lost);
//! others do not: Mesa's llvmpipe gives eight neighboring invocations together
//! [`MOST_PASSES`] passes of all their loops in one dispatch or draw, then ends the loop
//! that they are in and goes on behind it as if it were done. So no program may rely on a
//! loop that grows with the scene: its passes are bounded by a constant, by a limit that
//! its crate refuses to exceed, or by a budget for one dispatch, after which another one
//! goes on from what this one has stored.
//!
//! [`LOOPS`] says which. A test holds it to the files, and adds up for every entry point
//! what its loops, nested as they are, come to at most.

/// The passes of all loops that eight neighboring invocations together may take in one
/// dispatch or draw.
///
/// On llvmpipe (Mesa 22.3 to 25; `LP_MAX_TGSI_LOOP_ITERATIONS`) a pass counts while any of
/// the eight is in it, and so does the last test, which fails: n passes count n + 1.
pub const MOST_PASSES: u64 = 65_535;

/// One loop of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loop {
    /// The file in `wgsl/`.
    pub file: &'static str,
    /// The function; its loops are listed in the order in which they begin.
    pub function: &'static str,
    /// How often it is passed each time that it is come to.
    pub passes: Passes,
    /// The number that bounds it.
    pub bound: &'static str,
}

/// How often eight neighbors together pass a loop each time that they come to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// At most so often; each pass also costs what the loops inside of it do.
    AtMost(u64),
    /// At most so often with the loops inside of it, which are [`Passes::Counted`]: their
    /// passes are few in sum, though each may have many.
    InAll(u64),
    /// In a loop around it, in this function or in one that calls it, which is
    /// [`Passes::InAll`].
    Counted,
}

use Passes::{AtMost, Counted, InAll};

/// The most intervals of a transfer function on the device: one more than
/// [`MOST_KNOTS`], as the first and the last reach beyond the knots.
const MOST_INTERVALS: u64 = MOST_KNOTS as u64 + 1;

/// The most knots of a transfer function on the device; `tetrascope-gpu` refuses more.
///
/// A segment that spans all of its intervals takes three passes for each: one of the loop
/// over them, and one and a test of the loop over parts of an optical depth of 1.
pub const MOST_KNOTS: usize = 1 << 14;

/// The most passes of one dispatch of ray casting, to which the budget of
/// `tetrascope-raycast-peel` holds itself: [`MOST_PASSES`] with room for what is before it.
pub const MARCH_PASSES: u32 = 60_000;

/// The most passes of one run of a ray's slabs, for which `tetrascope-slicing` chooses how many
/// those are: [`MOST_PASSES`] with room for what is before it.
pub const RUN_PASSES: u32 = 60_000;

/// The most passes of one invocation for the columns of a cell of its own, `columns` of
/// `tetrascope-gpu`.
pub const COLUMN_CELL_PASSES: u32 = 4096;

/// The most samples along each axis of the part of a grid whose columns are filled in one dispatch.
pub const COLUMN_SIDE: u32 = 2048;

/// The most lights of an appearance, as `tetrascope-core` has it.
pub const MOST_LIGHTS: usize = 256;

const fn of(
    file: &'static str,
    function: &'static str,
    passes: Passes,
    bound: &'static str,
) -> Loop {
    Loop {
        file,
        function,
        passes,
        bound,
    }
}

/// All loops, file by file.
#[rustfmt::skip]
pub const LOOPS: &[Loop] = &[
    of("common/cue.wgsl", "integrate_cued_from", InAll(3 * MOST_INTERVALS + 8 * 50), "knots; ends at the opaque depth, so that all parts beyond the first of each piece are 48"),
    of("common/cue.wgsl", "add_cued_parts", Counted, "24 parts of a piece, in integrate_cued_from"),
    of("common/look.wgsl", "clip_ray", AtMost(16), "clip planes, MAX_CLIP_PLANES"),
    of("common/optics.wgsl", "integrate_from", InAll(3 * MOST_INTERVALS + 8 * 20), "knots; ends at the opaque depth, so that all parts beyond the first of each piece are 18"),
    of("common/optics.wgsl", "attenuated_light", Counted, "18 parts of a piece, in integrate_from"),
    of("common/sides.wgsl", "sides", AtMost(6), "edges of a cell"),
    of("common/surfaces.wgsl", "first_between", AtMost(32), "bisection"),
    of("common/surfaces.wgsl", "shade", AtMost(MOST_LIGHTS as u64), "lights, MOST_LIGHTS of tetrascope-core"),
    of("common/transfer_function.wgsl", "find_interval", AtMost(32), "bisection"),

    of("preintegration/fill_lengths.wgsl", "cs_fill_lengths", AtMost(16), "lengths"),
    of("preintegration/fill_lengths.wgsl", "cs_fill_lengths", InAll(3 * MOST_INTERVALS + 8 * 56), "knots; ends where the shortest is opaque, so that all parts beyond the first of each piece are 3 times 18 and one"),
    of("preintegration/fill_lengths.wgsl", "cs_fill_lengths", Counted, "parts of a piece, in the loop around it"),

    of("slicing/box_plane.wgsl", "vs_slice", AtMost(4), "edges of a path"),
    of("slicing/cull.wgsl", "cs_scan", AtMost(32), "blocks of 256 boxes of the deepest level, 2²¹, for each of 256 threads"),
    of("slicing/cull.wgsl", "cs_scan", AtMost(32), "the same"),
    of("slicing/cull.wgsl", "place_of", AtMost(7), "levels of the octree, MAX_LEVEL"),
    of("slicing/cull.wgsl", "place_of", AtMost(3), "axes"),
    of("slicing/cull.wgsl", "shows", AtMost(21), "five planes of the frustum and the clip planes"),
    of("slicing/cull.wgsl", "sum_before", AtMost(8), "halvings of a workgroup"),
    of("slicing/ranges.wgsl", "cs_leaf", AtMost(277), "rows of a box for each of 64 threads: 2¹⁴ samples an axis, as many as textures have, in 2⁷ boxes, with two beyond on each side: 133²"),
    of("slicing/ranges.wgsl", "cs_leaf", AtMost(133), "samples of such a row"),
    of("slicing/ranges.wgsl", "cs_leaf", AtMost(6), "halvings of a workgroup"),
    of("slicing/ranges.wgsl", "cs_gather", AtMost(8), "boxes of the level below"),
    of("slicing/rays.wgsl", "seek", Counted, "boxes that a run of slabs passes, in the loop around it"),
    of("slicing/rays.wgsl", "fs_run", InAll(RUN_PASSES as u64), "ends of slabs of a run; `slabs_per_run` of tetrascope-slicing says how many that are"),
    of("slicing/rays.wgsl", "fs_run_surface", InAll(RUN_PASSES as u64), "slabs of a run, the same"),
    of("slicing/corners.wgsl", "corners", AtMost(2), "layers of a cell"),
    of("slicing/slab.wgsl", "in_volume", AtMost(3), "axes"),
    of("slicing/slab.wgsl", "gradient_at", AtMost(3), "axes"),
    of("slicing/slab.wgsl", "next_plane", AtMost(3), "axes"),
    of("slicing/slab.wgsl", "without_gaps", AtMost(13), "cells that a slab crosses, MOST_CELLS"),
    of("slicing/slice.wgsl", "cell_by_cell", InAll(13 * 40 + 8 * 64), "cells that a slab crosses, MOST_CELLS, with a bisection and a next plane each; ends at the opaque depth, so that all parts beyond the first of each are 48"),
    of("slicing/surface.wgsl", "first_in_cells", AtMost(13), "cells that a slab crosses, MOST_CELLS"),
    of("slicing/surface.wgsl", "first_on_cubic", AtMost(3), "parts of a cubic"),
    of("slicing/surface.wgsl", "place_between", AtMost(24), "halvings of a bracket"),
    of("slicing/surface.wgsl", "corrected", AtMost(8), "CORRECTIONS"),

    of("sort/count.wgsl", "cs_count", AtMost(16), "items of a thread"),
    of("sort/scan.wgsl", "cs_scan", AtMost(4096), "digits of 65 536 blocks, MOST_BLOCKS of tetrascope-gpu, for each of 256 threads"),
    of("sort/scan.wgsl", "cs_scan", AtMost(8), "halvings of a workgroup"),
    of("sort/scan.wgsl", "cs_scan", AtMost(4096), "the same"),
    of("sort/scatter.wgsl", "cs_scatter", AtMost(16), "items of a thread"),
    of("sort/scatter.wgsl", "cs_scatter", AtMost(8), "words of a thread"),
    of("sort/scatter.wgsl", "cs_scatter", AtMost(8), "halvings of a workgroup"),
    of("sort/scatter.wgsl", "cs_scatter", AtMost(8), "words of a thread"),
    of("sort/scatter.wgsl", "cs_scatter", AtMost(16), "items of a thread"),

    of("projection/composite.wgsl", "fs_composite", AtMost(1 << 14), "PASSES of a turn; the next goes on from what it stored"),
    of("projection/pieces.wgsl", "choose_piece", AtMost(32), "bisection"),
    of("projection/segment.wgsl", "integrate_within", InAll(3 * MOST_INTERVALS + 8 * 20), "knots; as integrate of common/optics.wgsl"),

    of("mesh_slices/mesh_slice.wgsl", "shaded_center", AtMost(4), "corners of a cell"),

    of("stacks/frame.wgsl", "within", AtMost(3), "axes"),
    of("stacks/rectangle.wgsl", "part_of_image", AtMost(8), "corners of a slab"),

    of("columns/fill.wgsl", "fill_columns", InAll(16 * (COLUMN_SIDE as u64 + 10) + 1), "columns and samples of a cell: COLUMN_CELL_PASSES of each of eight neighbors, which add up, in cs_small; in cs_large 16 columns of each, side by side, of COLUMN_SIDE samples"),
    of("resample/column.wgsl", "fill_column", Counted, "samples of a column in a cell, in fill_columns"),
    of("voxel_hw/polyhedra.wgsl", "cell_of", AtMost(20), "triangles of a cell; those of a hexagonal prism"),
    of("voxel_hw/polyhedra.wgsl", "meet", Counted, "triangles of a cell, in fill_columns"),
    of("voxel_hw/tetrahedra_float.wgsl", "fill_column", Counted, "voxels of a column in a cell, in fill_columns"),
    of("voxel_hw/column.wgsl", "fill_between", Counted, "voxels of a column in a cell, in fill_columns"),

    of("raycast_peel/crossings.wgsl", "peeled_faces", AtMost(16), "layers, MOST_LAYERS"),
    of("raycast_peel/crossings.wgsl", "search", Counted, "entries of a list or tree, in trace"),
    of("raycast_peel/follow.wgsl", "follow", Counted, "cells and intervals of a round, in trace"),
    of("raycast_peel/march.wgsl", "trace", InAll(MARCH_PASSES as u64), "`Budget` of tetrascope-raycast-peel; what is not done is saved for the next dispatch"),
    of("raycast_peel/march.wgsl", "trace", Counted, "ROUNDS, in the loop around it"),
];

#[cfg(test)]
mod tests;
