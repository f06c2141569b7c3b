//! Voxelization of unstructured grids between two buffers.
//!
//! C. E. Prakash and S. Manohar, "Hardware Architecture for Voxelization-based Volume Rendering
//! of Unstructured Grids", 1995. This is its algorithm, on the CPU in readable form and on a graphics
//! device, a renderer, and a model of the machine that it proposes.
//!
//! A cell's front faces are scan converted into one frame- and z-buffer and its back faces into
//! another; what lies between the two is filled, column by column. Cells come one at a time, in
//! any order, and nothing is asked of their neighbors.
//!
//! 1. `source` takes the cells of a mesh into voxel space, one after the other (§2.2.2).
//! 2. `face` says what a face's extents per scan line are, and scan converts them. The numbers
//!    for that are in `fixed`, as published, or in `float` (§2.2: `form_buffers`,
//!    `scan_convert`).
//! 3. `cell` has the two buffers, and fills what is between them (§2.1, §2.2.1:
//!    `voxelize_between_two_buffers`).
//! 4. `offsets` are the places of samples within a voxel (§3).
//! 5. [`Voxelizer`] goes through all cells and offsets (§2.2: `voxelize_all_cells`, §3.1:
//!    `voxel_accumulation_buffer`), and [`VoxelVolume`] is what comes out.
//! 6. [`errors`] measures how far that is from the mesh (§3.1, §5.4).
//! 7. [`VoxelContext`] takes tetrahedra corner by corner (§5.5).
//! 8. [`machine`] is a model of the hardware, which makes the same voxels (§5.1 to §5.4).
//!
//! With the feature `gpu` also on a graphics device:
//!
//! 9. `device` has the passes ([`DeviceVoxelizer`]). `columns/fill.wgsl` goes through the pixels that a
//!    cell may cover. `tetrahedra.wgsl` and `polyhedra.wgsl` tell the front from the back faces there,
//!    `face.wgsl` where they lie, in the 64-bit integers of `wide.wgsl`; `column.wgsl` fills what is
//!    between them, `put.wgsl` is the accumulation buffer, and `resolve.wgsl` makes a grid of it.
//!    `tetrahedra_float.wgsl` is the same in floats.
//! 10. `stacks` draws the grid by textured rectangles ([`Stacks`], §4), or `slicing` does as one
//!     texture of three dimensions; [`Voxelization`] is the renderer.
//!
//! ```
//! use tetrascope_core::glam::{DMat3, DVec3};
//! use tetrascope_core::grid::{Interpolation, Lattice};
//! use tetrascope_core::mesh::Association;
//! use tetrascope_core::{Scalars, TetMesh};
//! use tetrascope_voxel_hw::{Offsets, Voxelizer, VoxelizerOptions};
//!
//! let points = vec![DVec3::ZERO, DVec3::X * 8.0, DVec3::Y * 8.0, DVec3::Z * 8.0];
//! let scalars = Scalars {
//!     name: "x".into(),
//!     association: Association::Point,
//!     values: points.iter().map(|p| p.x).collect(),
//! };
//! let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars)?;
//!
//! let unit_voxels = Lattice {
//!     dims: [8; 3],
//!     origin: DVec3::splat(0.5),
//!     spacing: DVec3::ONE,
//!     direction: DMat3::IDENTITY,
//!     interpolation: Interpolation::Nearest,
//! };
//! let voxelizer = Voxelizer::new(VoxelizerOptions {
//!     offsets: Offsets::Regular(4),
//!     ..VoxelizerOptions::default()
//! })?;
//! let voxels = voxelizer.voxelize(&mesh, &unit_voxels)?;
//! assert_eq!(voxels.coverage(0), 1.0);
//! assert!((voxels.scalar(0).expect("inside") - 0.5).abs() < 1e-6);
//! let volume: f32 = (0..512).map(|voxel| voxels.coverage(voxel)).sum();
//! assert!((volume - 512.0 / 6.0).abs() < 2.0);
//! # Ok::<(), tetrascope_core::Error>(())
//! ```
//!
//! # Where the paper leaves a choice
//! - *Pixels and voxels on a border* belong to the face, or cell, that begins there: to the left,
//!   below and in front. With [`Arithmetic::FixedPoint`] this is decided exactly, so each voxel
//!   center in a mesh of tetrahedra, none of which snapping turned inside out, is written once.
//! - *"Adding a 0.5"* (§2.2.1) is read as ⌈z − 1/2⌉: the first voxel is the first whose center is
//!   not in front of the face, and takes the face's scalar ([`FirstVoxel::Rounded`]). The "more
//!   accurate method", to interpolate from neighboring pixels, is here to interpolate along the
//!   column between both faces ([`FirstVoxel::Interpolated`]), which is exact in a tetrahedron.
//! - *Cells other than tetrahedra* ([`Cells::AsGiven`]): their faces are cut into triangles before
//!   they are scan converted, with the diagonals of the mesh's own tetrahedra
//!   ([`Split::SmallestIndex`](tetrascope_core::mesh::Split::SmallestIndex)). Where such a cell
//!   has a dent along z, it is filled.
//! - *Samples of a voxel that miss the mesh* count towards coverage, not towards the scalar.
//! - *Random sample points* come in pairs of opposites, so that their mean is the center.
//!
//! # Departures from the paper
//! - *Extents* hold depth and scalar at their left end alone. Their slopes along the scan line are
//!   the face's, found once, as the geometry engines of §5.1 do it: slopes of each scan line
//!   would be rounded by themselves, and the faces of a thin cell could cross.
//! - *A voxel that is written again*, as cells overlap, holds the mean. As published the last one
//!   stays, which depends on the order of cells.
//! - *A face at a pixel is computed by itself* on a device, not in increments from the pixel before. In
//!   fixed point nothing is lost in increments, so both are the same, to the last bit. Two buffers are
//!   two fragments there, as an invocation has one pixel of one cell at a time.
//! - *Columns run along the longest axis* where one likes ([`Columns::Longest`]): the fewer pixels, the
//!   less work.
//! - *A layer of empty voxels* surrounds what [`Voxelization`] draws, so that the outer half of voxels on
//!   the border is drawn as well.
//! - *A voxel is written with its scalar*; the transfer function comes after, unless one asks for
//!   [`Voxelizer::voxelize_colors`].
//!
//! # Limits
//! - At most [`MOST_SIDE`] voxels along an axis, and [`MOST_VOXELS`] in all. In fixed point no cell
//!   is wider than [`MOST_SIDE`] voxels, also where most of it is outside of the volume.
//! - In fixed point a vertex is moved by up to 2⁻⁹ voxels along each axis, and keeps its scalar.
//!   Cells that are thinner than that may turn inside out. They are left out and counted
//!   ([`Counts::inverted`]); their neighbors, which then overlap, write voxels twice.
//! - On a device cells are at most [`MOST_SIDE`] voxels wide in floats as well, whose vertices are there
//!   rounded to 2⁻¹⁹ voxels; cells as they are given have fixed point alone. The transfer function comes
//!   after the mean.
//! - A picture's border fades over two voxels, so its error is of order 1.2 to 1.5 in the voxels' size. Greatest
//!   colors and isosurfaces have no extinction that could fade, and end where a voxel is covered by less
//!   than a half.
//! - With [`Arithmetic::Float`] a voxel whose center lies on a face but for rounding may be written
//!   several times, and is always written in a mesh without gaps.
//!
//! # In an application with its own wgpu
#![cfg_attr(
    feature = "gpu",
    doc = r#"
```no_run
use tetrascope_core::{Appearance, Error, View, Volume, VolumeRenderer as _};
use tetrascope_gpu::wgpu;
use tetrascope_gpu::{Draw as _, Gpu, Target};
use tetrascope_voxel_hw::{Offsets, Voxelization, VoxelizationOptions, VoxelizerOptions};

/// Voxels of a mesh, with 27 samples each.
fn prepare(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    mesh: &Volume,
    appearance: &Appearance,
) -> Result<Voxelization, Error> {
    let gpu = Gpu::from_device(device.clone(), queue.clone());
    let defaults = VoxelizationOptions::default();
    let options = VoxelizationOptions {
        voxels: 192,
        voxelizer: VoxelizerOptions {
            offsets: Offsets::Regular(3),
            ..defaults.voxelizer
        },
        ..defaults
    };
    Voxelization::new(&gpu, mesh, appearance, &options)
}

/// Every frame; a mesh that has changed first comes in by `renderer.reload(&mesh)`.
fn draw(
    renderer: &Voxelization,
    encoder: &mut wgpu::CommandEncoder,
    (view, target): (&View, &Target),
) -> Result<(), Error> {
    // The application submits; the statistics, which wait for that, are left alone.
    let _ = renderer.encode(encoder, view, target)?;
    Ok(())
}
```
"#
)]

mod options;

mod source;
mod space;

mod face;
mod fixed;
mod float;

mod cell;
mod offsets;
mod volume;
mod voxelizer;

pub mod errors;
mod interface;
pub mod machine;

#[cfg(feature = "gpu")]
pub mod counters;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod entry;
#[cfg(feature = "gpu")]
mod renderer;
#[cfg(feature = "gpu")]
mod stacks;

#[cfg(feature = "gpu")]
pub use device::{DeviceVoxelizer, Items};
#[cfg(feature = "gpu")]
pub use entry::ENTRY;
pub use errors::VoxelErrors;
pub use fixed::{DEPTH_BITS, PLACE_BITS, SCALAR_BITS};
pub use interface::{VoxelContext, voxels_over, with_border};
pub use offsets::{MOST_RANDOM, MOST_REGULAR, Offsets};
pub use options::{
    Arithmetic, Cells, Columns, FirstVoxel, MOST_SIDE, MOST_VOXELS, VoxelSize, VoxelizerOptions,
};
#[cfg(feature = "gpu")]
pub use renderer::{MOST_DRAWN, Textures, Voxelization, VoxelizationOptions};
#[cfg(feature = "gpu")]
pub use stacks::{Integration as StackIntegration, Stacks, StacksOptions};
#[cfg(feature = "gpu")]
pub use tetrascope_slicing::Domain;
pub use volume::{ColorVolume, VoxelVolume, Voxels};
pub use voxelizer::{Counts, Voxelizer};

/// The algorithm's name.
pub const NAME: &str = "voxel-hw";

/// The parts of an appearance that it draws beyond the volumetric optical models.
#[cfg(feature = "gpu")]
pub const ABILITIES: tetrascope_core::Abilities = tetrascope_slicing::ABILITIES;

/// Says in the name of this algorithm that slices refuse something.
#[cfg(feature = "gpu")]
fn renamed(error: tetrascope_core::Error) -> tetrascope_core::Error {
    use tetrascope_core::Error;
    match error {
        Error::Unsupported { what, reason, .. } => Error::Unsupported {
            renderer: NAME,
            what,
            reason,
        },
        other => other,
    }
}
