//! Every WGSL program of Tetrascope, as lists of parts.
//!
//! A program is a `pub const` that joins files of `wgsl/`: those in `common` have no
//! entry points, and each other folder belongs to the crate or module of its name.
//! WGSL takes declarations in any order, so parts need no import mechanism. Variants
//! are `override` constants, set when a pipeline is made.
//!
//! One test parses and validates every program; [`loops`] has what bounds each loop. With the feature `layout`,
//! `assert_layout!` compares the structs on both sides.
//!
//! ```
//! use tetrascope_shaders::{PROGRAMS, raycast_peel};
//!
//! // A program is complete: any tool for WGSL takes it.
//! let module = naga::front::wgsl::parse_str(raycast_peel::MARCH)?;
//! let names: Vec<_> = module.entry_points.iter().map(|entry| &*entry.name).collect();
//! assert!(names.contains(&"cs_cast"), "{names:?}");
//! // The name of each is that of its constant.
//! assert!(PROGRAMS.contains(&("raycast_peel::MARCH", raycast_peel::MARCH)));
//! # Ok::<(), naga::front::wgsl::ParseError>(())
//! ```

#[cfg(feature = "layout")]
pub mod layout;
pub mod loops;

/// Joins parts of `wgsl/` into a program.
macro_rules! program {
    ($($part:literal),+ $(,)?) => {
        concat!($(include_str!(concat!("../wgsl/", $part))),+)
    };
}

/// A program that slices grids; `$part` is how it reads samples.
macro_rules! slice_program {
    ($($part:literal),+) => {
        program!(
            "slicing/box.wgsl",
            "slicing/frame.wgsl",
            "slicing/box_plane.wgsl",
            $($part,)+
            "slicing/corners.wgsl",
            "common/look.wgsl",
            "common/ends.wgsl",
            "slicing/slab.wgsl",
            "common/optics_model.wgsl",
            "common/transfer_function.wgsl",
            "common/optics.wgsl",
            "common/cue.wgsl",
            "slicing/slice.wgsl",
            "common/surfaces.wgsl",
            "slicing/surface.wgsl",
            "slicing/rays.wgsl",
        )
    };
}

/// A program that draws cells; `$part` is what becomes of their fragments.
macro_rules! cell_program {
    ($($part:literal),+) => {
        program!(
            "projection/frame.wgsl",
            "projection/vertices.wgsl",
            "projection/mesh.wgsl",
            "common/turns.wgsl",
            "common/sides.wgsl",
            "projection/footprint.wgsl",
            "projection/chord.wgsl",
            "common/optics_model.wgsl",
            "common/layer.wgsl",
            "common/transfer_function.wgsl",
            "common/optics.wgsl",
            "common/cue.wgsl",
            "common/look.wgsl",
            "common/ends.wgsl",
            "preintegration/axes.wgsl",
            "preintegration/lookup.wgsl",
            "projection/transfer.wgsl",
            "projection/pieces.wgsl",
            "projection/segment.wgsl",
            $($part),+
        )
    };
}

/// A program that draws the faces of cells; `$part` is how those are stored.
macro_rules! face_program {
    ($part:literal) => {
        program!(
            "projection/frame.wgsl",
            "projection/vertices.wgsl",
            "projection/mesh.wgsl",
            "projection/faces.wgsl",
            $part,
            "common/look.wgsl",
            "common/ends.wgsl",
            "common/optics_model.wgsl",
            "common/transfer_function.wgsl",
            "common/optics.wgsl",
            "preintegration/axes.wgsl",
            "preintegration/lookup.wgsl",
            "projection/transfer.wgsl",
            "projection/face.wgsl",
        )
    };
}

/// A program that takes rays through one cell; `$part` is how it finds where they leave it.
macro_rules! step_program {
    ($($part:literal),+) => {
        program!(
            "ping_pong/rays.wgsl",
            "common/optics_model.wgsl",
            "common/layer.wgsl",
            "common/transfer_function.wgsl",
            "common/optics.wgsl",
            "preintegration/axes.wgsl",
            "preintegration/lookup.wgsl",
            "ping_pong/transfer.wgsl",
            $($part,)+
            "ping_pong/step.wgsl",
        )
    };
}

/// The GPU radix sort of `tetrascope-gpu`, one program for each of its passes.
pub mod sort {
    /// Pass 1: count the digits of each block.
    pub const COUNT: &str = program!("sort/digits.wgsl", "sort/count.wgsl");
    /// Pass 2: where each digit of each block begins.
    pub const SCAN: &str = program!("sort/digits.wgsl", "sort/scan.wgsl");
    /// Pass 3: move each pair to its place.
    pub const SCATTER: &str = program!("sort/digits.wgsl", "sort/scatter.wgsl");
}

/// The sum of a volume's parts, `canvas` of `tetrascope-gpu`.
pub mod gather {
    /// Puts the sum over the background.
    pub const RESOLVE: &str = program!("common/optics_model.wgsl", "gather/resolve.wgsl");
    /// Where rays meet what an application has drawn.
    pub const ENDS: &str = program!("gather/scene.wgsl", "gather/ends.wgsl");
    /// Puts isosurfaces among what an application has drawn.
    pub const AMONG: &str = program!("gather/scene.wgsl", "gather/among.wgsl");
}

/// The parts in `common`, as programs for their tests.
pub mod common {
    /// `sides.wgsl` over many points at once.
    pub const SIDES: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "common/sides_probe.wgsl",
    );
    /// `optics.wgsl` and tables over many segments at once.
    pub const PROBE: &str = program!(
        "common/optics_model.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "preintegration/axes.wgsl",
        "preintegration/lookup.wgsl",
        "common/probe.wgsl",
    );
}

/// Tables of integrals, `preintegration` of `tetrascope-gpu`.
pub mod preintegration {
    /// Fills a table of light.
    pub const FILL_COLOR: &str = program!(
        "preintegration/axes.wgsl",
        "common/optics_model.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "preintegration/put_color.wgsl",
        "preintegration/fill.wgsl",
        "preintegration/fill_lengths.wgsl",
    );
    /// Fills a table of optical depth or opacity alone.
    pub const FILL_DEPTH: &str = program!(
        "preintegration/axes.wgsl",
        "common/optics_model.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "preintegration/put_depth.wgsl",
        "preintegration/fill.wgsl",
        "preintegration/fill_lengths.wgsl",
    );
}

/// Cell projection (`tetrascope-projection`).
pub mod projection {
    /// Pass 1: the vertices in camera space.
    pub const TRANSFORM: &str = program!(
        "projection/frame.wgsl",
        "projection/vertices.wgsl",
        "projection/transform.wgsl",
    );
    /// Pass 2, for models that do not commute: a sort key for each cell.
    pub const ORDER: &str = program!(
        "projection/frame.wgsl",
        "projection/vertices.wgsl",
        "projection/mesh.wgsl",
        "projection/order.wgsl",
    );
    /// Pass 3: draw the cells and blend what each adds.
    pub const CELL: &str = cell_program!("projection/cell.wgsl");
    /// Pass 3 for isosurfaces: draw where rays meet them in cells.
    pub const SURFACE: &str = cell_program!("common/surfaces.wgsl", "projection/surface.wgsl");
    /// Pass 3 by ray parameters at vertices: faces of shared vertices.
    pub const FACES_SHARED: &str = face_program!("projection/faces_shared.wgsl");
    /// Pass 3 by ray parameters at vertices: twelve vertices per cell.
    pub const FACES_FLOATS: &str = face_program!("projection/faces_floats.wgsl");
    /// Pass 3 by ray parameters at vertices: twelve vertices per cell, in 16 bits.
    pub const FACES_SHORTS: &str = face_program!("projection/faces_shorts.wgsl");
    /// Pass 3, sorted in each pixel: draw the cells and list what each adds.
    pub const FILL: &str = cell_program!("projection/fragments.wgsl", "projection/fill.wgsl");
    /// Pass 4, sorted in each pixel: sort the lists and add them up.
    pub const COMPOSITE: &str = program!(
        "common/optics_model.wgsl",
        "common/sums.wgsl",
        "projection/fragments.wgsl",
        "projection/composite.wgsl",
    );
}

/// Slicing of regular grids (`tetrascope-slicing`).
pub mod slicing {
    /// Lists the boxes that can show, back to front.
    pub const CULL: &str = program!("slicing/box.wgsl", "slicing/cull.wgsl");
    /// Finds the least and greatest scalar of each box of a grid on the device.
    pub const RANGES: &str = program!("slicing/ranges.wgsl");
    /// Draws slabs of a volume of `f32`.
    pub const SLICE_FLOAT: &str = slice_program!(
        "slicing/trilinear.wgsl",
        "slicing/uncovered.wgsl",
        "slicing/voxels_float.wgsl"
    );
    /// Draws slabs of a volume of unsigned integers.
    pub const SLICE_UNSIGNED: &str = slice_program!(
        "slicing/trilinear.wgsl",
        "slicing/uncovered.wgsl",
        "slicing/voxels_unsigned.wgsl"
    );
    /// Draws slabs of a volume of signed integers.
    pub const SLICE_SIGNED: &str = slice_program!(
        "slicing/trilinear.wgsl",
        "slicing/uncovered.wgsl",
        "slicing/voxels_signed.wgsl"
    );
    /// Draws slabs of a volume that the texture unit filters.
    pub const SLICE_FILTERED: &str =
        slice_program!("slicing/uncovered.wgsl", "slicing/voxels_filtered.wgsl");
    /// Draws slabs of a volume that was made on the device.
    pub const SLICE_DEVICE: &str = slice_program!(
        "slicing/trilinear.wgsl",
        "slicing/uncovered.wgsl",
        "slicing/voxels_device.wgsl"
    );
    /// Draws slabs of a volume that was made on the device, with coverage.
    pub const SLICE_COVERED: &str =
        slice_program!("slicing/trilinear.wgsl", "slicing/covered.wgsl");
}

/// Ray casting through tetrahedral meshes (`tetrascope-raycast-peel`).
pub mod raycast_peel {
    /// Follow each ray to its end.
    pub const MARCH: &str = program!(
        "common/optics_model.wgsl",
        "common/layer.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "common/cue.wgsl",
        "common/look.wgsl",
        "common/ends.wgsl",
        "common/surfaces.wgsl",
        "preintegration/axes.wgsl",
        "preintegration/lookup.wgsl",
        "common/turns.wgsl",
        "common/sides.wgsl",
        "common/texels.wgsl",
        "raycast_peel/rays.wgsl",
        "raycast_peel/shear.wgsl",
        "raycast_peel/walk.wgsl",
        "raycast_peel/layers.wgsl",
        "raycast_peel/boundary.wgsl",
        "raycast_peel/crossings.wgsl",
        "common/sums.wgsl",
        "raycast_peel/gather.wgsl",
        "raycast_peel/follow.wgsl",
        "raycast_peel/march.wgsl",
        "raycast_peel/state.wgsl",
    );
    /// The boundary faces that rays cross, layer by layer.
    pub const PEEL: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "common/texels.wgsl",
        "raycast_peel/rays.wgsl",
        "raycast_peel/shear.wgsl",
        "raycast_peel/walk.wgsl",
        "raycast_peel/layers.wgsl",
        "raycast_peel/boundary.wgsl",
        "raycast_peel/peel.wgsl",
    );
    /// Other scalars for vertices that are there.
    pub const SCALARS: &str = program!("raycast_peel/scalars.wgsl");
    /// The same for rays that are given one by one, to test it.
    pub const AIM: &str = program!(
        "common/optics_model.wgsl",
        "common/layer.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "common/cue.wgsl",
        "common/look.wgsl",
        "common/ends.wgsl",
        "common/surfaces.wgsl",
        "preintegration/axes.wgsl",
        "preintegration/lookup.wgsl",
        "common/turns.wgsl",
        "common/sides.wgsl",
        "common/texels.wgsl",
        "raycast_peel/rays.wgsl",
        "raycast_peel/shear.wgsl",
        "raycast_peel/walk.wgsl",
        "raycast_peel/layers.wgsl",
        "raycast_peel/boundary.wgsl",
        "raycast_peel/crossings.wgsl",
        "common/sums.wgsl",
        "raycast_peel/gather.wgsl",
        "raycast_peel/follow.wgsl",
        "raycast_peel/march.wgsl",
        "raycast_peel/state.wgsl",
        "raycast_peel/aim.wgsl",
    );
}

/// Ray casting one step per pass (`ping_pong` of `tetrascope-raycast-peel`).
pub mod ping_pong {
    /// Phases 1 and 2: where rays come in, by planes as published.
    pub const ENTRY: &str = program!(
        "ping_pong/rays.wgsl",
        "ping_pong/planes.wgsl",
        "ping_pong/entry.wgsl",
    );
    /// Phases 1 and 2: where rays come in, by sides.
    pub const ENTRY_SIDES: &str = program!(
        "ping_pong/rays.wgsl",
        "common/turns.wgsl",
        "common/sides.wgsl",
        "raycast_peel/shear.wgsl",
        "ping_pong/sides.wgsl",
        "raycast_peel/layers.wgsl",
        "ping_pong/entry_sides.wgsl",
    );
    /// Phase 3a: one cell, by planes as published.
    pub const STEP: &str = step_program!("ping_pong/planes.wgsl");
    /// Phase 3a: one cell, by sides.
    pub const STEP_SIDES: &str = step_program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "raycast_peel/shear.wgsl",
        "ping_pong/sides.wgsl"
    );
    /// Phase 3b: retire idle rays.
    pub const RETIRE: &str = program!("ping_pong/rays.wgsl", "ping_pong/retire.wgsl");
    /// How many rays a layer lost.
    pub const TALLY: &str = program!("ping_pong/rays.wgsl", "ping_pong/tally.wgsl");
}

/// Work of cells that meet columns, `columns` of `tetrascope-gpu`.
pub mod columns {
    /// How many workgroups take the cells with much to do.
    pub const ARRANGE: &str = program!("columns/arrange.wgsl");
}

/// Resampling of tetrahedral meshes (`tetrascope-resample`).
pub mod resample {
    /// The samples in cells, with little and with much to do.
    pub const FILL: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "resample/mesh.wgsl",
        "columns/crossing.wgsl",
        "resample/column.wgsl",
        "resample/put.wgsl",
        "columns/fill.wgsl",
    );
    /// As `FILL`, and how often each sample is written, to test it.
    pub const FILL_COUNTED: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "resample/mesh.wgsl",
        "columns/crossing.wgsl",
        "resample/column.wgsl",
        "resample/put_counted.wgsl",
        "columns/fill.wgsl",
    );
    /// The triangles of every cell, as published.
    pub const ELEMENTS: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "resample/mesh.wgsl",
        "resample/element.wgsl",
        "resample/triangles.wgsl",
        "resample/elements.wgsl",
    );
    /// Those that a slab meets.
    pub const ACTIVE: &str = program!("resample/element.wgsl", "resample/active.wgsl");
    /// Their cross sections with a slice.
    pub const SECTION: &str = program!(
        "resample/mesh.wgsl",
        "resample/element.wgsl",
        "resample/section.wgsl",
    );
}

/// Voxelization between two buffers (`tetrascope-voxel-hw`).
pub mod voxel_hw {
    /// The voxels of tetrahedra, in integers.
    pub const TETRAHEDRA: &str = program!(
        "common/turns.wgsl",
        "voxel_hw/wide.wgsl",
        "voxel_hw/work.wgsl",
        "voxel_hw/face.wgsl",
        "voxel_hw/tetrahedra.wgsl",
        "voxel_hw/column.wgsl",
        "voxel_hw/put.wgsl",
        "columns/fill.wgsl",
    );
    /// The voxels of any convex cells, in integers.
    pub const POLYHEDRA: &str = program!(
        "voxel_hw/wide.wgsl",
        "voxel_hw/work.wgsl",
        "voxel_hw/face.wgsl",
        "voxel_hw/polyhedra.wgsl",
        "voxel_hw/column.wgsl",
        "voxel_hw/put.wgsl",
        "columns/fill.wgsl",
    );
    /// The voxels of tetrahedra, in floats.
    pub const TETRAHEDRA_FLOAT: &str = program!(
        "common/turns.wgsl",
        "common/sides.wgsl",
        "columns/crossing.wgsl",
        "voxel_hw/work.wgsl",
        "voxel_hw/wide.wgsl",
        "voxel_hw/tetrahedra_float.wgsl",
        "voxel_hw/put.wgsl",
        "columns/fill.wgsl",
    );
    /// Sums of scalars become samples.
    pub const RESOLVE: &str = program!("voxel_hw/resolve.wgsl");
}

/// Slices of tetrahedral meshes (`mesh_slices` of `tetrascope-resample`).
pub mod mesh_slices {
    /// The triangles of every cell as a camera sees it.
    pub const VIEW_ELEMENTS: &str = program!(
        "common/look.wgsl",
        "common/turns.wgsl",
        "common/sides.wgsl",
        "mesh_slices/frame.wgsl",
        "resample/element.wgsl",
        "resample/triangles.wgsl",
        "mesh_slices/view_elements.wgsl",
    );
    /// The light that their cross sections with a plane add to a picture.
    pub const MESH_SLICE: &str = program!(
        "common/look.wgsl",
        "common/ends.wgsl",
        "common/optics_model.wgsl",
        "common/transfer_function.wgsl",
        "common/turns.wgsl",
        "common/sides.wgsl",
        "mesh_slices/frame.wgsl",
        "resample/element.wgsl",
        "mesh_slices/mesh_slice.wgsl",
    );
}

/// Stacks of textured rectangles (`stacks` of `tetrascope-voxel-hw`).
pub mod stacks {
    /// The samples of a grid as layers.
    pub const TURN_VALUES: &str = program!("stacks/values.wgsl", "stacks/turn.wgsl");
    /// The same for samples with coverage.
    pub const TURN_COVERED: &str = program!("stacks/covered.wgsl", "stacks/turn.wgsl");
    /// The light that a layer, or the slab behind it, adds to a picture.
    pub const RECTANGLE: &str = program!(
        "common/look.wgsl",
        "common/ends.wgsl",
        "common/optics_model.wgsl",
        "common/transfer_function.wgsl",
        "common/optics.wgsl",
        "common/cue.wgsl",
        "stacks/frame.wgsl",
        "stacks/layer.wgsl",
        "stacks/rectangle.wgsl",
    );
}

/// Every program with its name.
pub const PROGRAMS: [(&str, &str); 52] = [
    ("sort::COUNT", sort::COUNT),
    ("sort::SCAN", sort::SCAN),
    ("sort::SCATTER", sort::SCATTER),
    ("common::PROBE", common::PROBE),
    ("common::SIDES", common::SIDES),
    ("preintegration::FILL_COLOR", preintegration::FILL_COLOR),
    ("preintegration::FILL_DEPTH", preintegration::FILL_DEPTH),
    ("projection::TRANSFORM", projection::TRANSFORM),
    ("projection::ORDER", projection::ORDER),
    ("projection::CELL", projection::CELL),
    ("projection::FILL", projection::FILL),
    ("projection::FACES_SHARED", projection::FACES_SHARED),
    ("projection::FACES_FLOATS", projection::FACES_FLOATS),
    ("projection::FACES_SHORTS", projection::FACES_SHORTS),
    ("projection::SURFACE", projection::SURFACE),
    ("projection::COMPOSITE", projection::COMPOSITE),
    ("gather::RESOLVE", gather::RESOLVE),
    ("gather::ENDS", gather::ENDS),
    ("gather::AMONG", gather::AMONG),
    ("slicing::CULL", slicing::CULL),
    ("slicing::SLICE_FLOAT", slicing::SLICE_FLOAT),
    ("slicing::SLICE_UNSIGNED", slicing::SLICE_UNSIGNED),
    ("slicing::SLICE_SIGNED", slicing::SLICE_SIGNED),
    ("slicing::SLICE_FILTERED", slicing::SLICE_FILTERED),
    ("slicing::SLICE_DEVICE", slicing::SLICE_DEVICE),
    ("slicing::SLICE_COVERED", slicing::SLICE_COVERED),
    ("slicing::RANGES", slicing::RANGES),
    ("columns::ARRANGE", columns::ARRANGE),
    ("voxel_hw::TETRAHEDRA", voxel_hw::TETRAHEDRA),
    ("voxel_hw::POLYHEDRA", voxel_hw::POLYHEDRA),
    ("voxel_hw::TETRAHEDRA_FLOAT", voxel_hw::TETRAHEDRA_FLOAT),
    ("voxel_hw::RESOLVE", voxel_hw::RESOLVE),
    ("resample::FILL", resample::FILL),
    ("resample::FILL_COUNTED", resample::FILL_COUNTED),
    ("resample::ELEMENTS", resample::ELEMENTS),
    ("resample::ACTIVE", resample::ACTIVE),
    ("resample::SECTION", resample::SECTION),
    ("mesh_slices::VIEW_ELEMENTS", mesh_slices::VIEW_ELEMENTS),
    ("mesh_slices::MESH_SLICE", mesh_slices::MESH_SLICE),
    ("stacks::TURN_VALUES", stacks::TURN_VALUES),
    ("stacks::TURN_COVERED", stacks::TURN_COVERED),
    ("stacks::RECTANGLE", stacks::RECTANGLE),
    ("raycast_peel::MARCH", raycast_peel::MARCH),
    ("raycast_peel::AIM", raycast_peel::AIM),
    ("raycast_peel::PEEL", raycast_peel::PEEL),
    ("raycast_peel::SCALARS", raycast_peel::SCALARS),
    ("ping_pong::ENTRY", ping_pong::ENTRY),
    ("ping_pong::ENTRY_SIDES", ping_pong::ENTRY_SIDES),
    ("ping_pong::STEP", ping_pong::STEP),
    ("ping_pong::STEP_SIDES", ping_pong::STEP_SIDES),
    ("ping_pong::RETIRE", ping_pong::RETIRE),
    ("ping_pong::TALLY", ping_pong::TALLY),
];

#[cfg(test)]
mod tests {
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    #[test]
    fn every_program_is_valid() {
        for (name, source) in PROGRAMS {
            let module = naga::front::wgsl::parse_str(source)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
            // No capabilities: the programs must run on any WebGPU device.
            Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        }
    }

    #[test]
    fn every_file_is_in_a_program() {
        for folder in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/wgsl"))
            .expect("the crate has shaders")
        {
            let folder = folder.expect("readable").path();
            for file in std::fs::read_dir(folder).expect("readable") {
                let path = file.expect("readable").path();
                let text = std::fs::read_to_string(&path).expect("WGSL is text");
                let used = PROGRAMS.iter().any(|(_, source)| source.contains(&text));
                assert!(used, "{} is in no program", path.display());
            }
        }
    }
}
