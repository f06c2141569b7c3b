//! What can be chosen.

use tetrascope_core::Error;
pub use tetrascope_gpu::Integration;
use tetrascope_gpu::wgpu::{CompareFunction, TextureFormat};

/// How cells are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionOptions {
    /// Where a ray's other crossing with a cell is found.
    pub exit_search: ExitSearch,
    /// How cells lie in the device's memory.
    pub cell_layout: CellLayout,
    /// How a ray's segment in a cell is integrated.
    pub integration: Integration,
    /// In which order cells are drawn where the optical model does not commute.
    pub order: Order,
    /// Bytes that [`Order::PerPixel`] may take for the fragments of one tile of the
    /// image, 24 each. With less, there are more tiles, and each draws all cells.
    pub fragment_bytes: u64,
    /// How isosurfaces are found in a cell.
    pub surfaces: SurfaceSearch,
    /// The depth buffer that [`Projection::encode_among`](crate::Projection::encode_among)
    /// draws with; without, it is not compiled.
    pub depth_format: Option<DepthFormat>,
    /// The format of the textures that [`Projection::encode`](crate::Projection::encode)
    /// draws into; it gets linear premultiplied RGBA.
    pub target_format: TextureFormat,
}

impl Default for ProjectionOptions {
    fn default() -> Self {
        ProjectionOptions {
            exit_search: ExitSearch::PerFragment,
            cell_layout: CellLayout::SharedVertices,
            integration: Integration::Exact,
            order: Order::Centroid,
            fragment_bytes: 1 << 28,
            surfaces: SurfaceSearch::Exact,
            depth_format: None,
            target_format: TextureFormat::Rgba32Float,
        }
    }
}

/// Where a ray's other crossing with a cell is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ExitSearch {
    /// In each fragment (§3.2).
    PerFragment,
}

/// How cells lie in the device's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum CellLayout {
    /// Four indices a cell into vertices that cells share (§8): 16 bytes a cell,
    /// 16 bytes a vertex, and 4 bytes a cell that is drawn.
    SharedVertices,
}

/// In which order cells are drawn where the optical model does not commute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Order {
    /// As they come: right only for models that commute.
    Unsorted,
    /// By the distance of their centroids, farthest first: not always the order of
    /// visibility.
    Centroid,
    /// By which cell is in front of which across their face, on the CPU (Williams
    /// 1992): exact in convex meshes without cycles. Parts of other meshes are ordered
    /// by their distance, and cycles are broken and counted.
    Mpvo,
    /// Fragments are sorted in each pixel: exact in any mesh.
    PerPixel,
}

/// How isosurfaces are found in a cell (§5.2).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceSearch {
    /// Where the scalar along the ray crosses the isovalue: no gaps, no thickness.
    Exact,
    /// In a table over the scalars where the ray enters and leaves the cell, as
    /// published. Its samples blur which rays meet a surface; thickness hides gaps.
    Table {
        /// Samples along each axis, from 2 to [`SurfaceSearch::MOST`].
        n: u32,
        /// How far a surface reaches on either side, samples, 0 or more.
        thickness: f32,
    },
}

impl SurfaceSearch {
    /// The most samples a side of a table.
    pub const MOST: u32 = 2048;

    /// Refuses numbers out of range.
    pub(crate) fn validate(self) -> Result<(), Error> {
        let SurfaceSearch::Table { n, thickness } = self else {
            return Ok(());
        };
        let most = SurfaceSearch::MOST;
        if (2..=most).contains(&n) && (0.0..=most as f32).contains(&thickness) {
            return Ok(());
        }
        Err(Error::Invalid {
            what: format!("a table of isosurfaces with {n} samples a side, {thickness} thick"),
            help: Some(format!(
                "give 2 to {most} samples, and a thickness of 0 to as many"
            )),
        })
    }
}

/// An application's depth buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthFormat {
    /// A format with depth.
    pub format: TextureFormat,
    /// Which of two depths is kept: `Less` where the near plane is 0, `Greater` where
    /// it is 1.
    pub compare: CompareFunction,
}

impl ExitSearch {
    /// Every choice, with its name.
    pub const ALL: [(&'static str, ExitSearch); 1] = [("per-fragment", ExitSearch::PerFragment)];
}

impl CellLayout {
    /// Every choice, with its name.
    pub const ALL: [(&'static str, CellLayout); 1] =
        [("shared-vertices", CellLayout::SharedVertices)];
}

impl Order {
    /// Every choice, with its name.
    pub const ALL: [(&'static str, Order); 4] = [
        ("unsorted", Order::Unsorted),
        ("centroid", Order::Centroid),
        ("mpvo", Order::Mpvo),
        ("per-pixel", Order::PerPixel),
    ];
}
