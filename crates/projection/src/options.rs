//! Options of projection.

use tetrascope_core::{Appearance, Error, OpticalModel, Projection, Settings, View};
pub use tetrascope_f32::Domain;
use tetrascope_gpu::Gpu;
pub use tetrascope_gpu::Integration;
use tetrascope_gpu::transfer_function::check_knots;
use tetrascope_gpu::wgpu::DeviceType;

use crate::{ENTRY, NAME};

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
    /// Where [`Order::Centroid`] sorts.
    pub sort: Sort,
    /// Bytes that [`Order::PerPixel`] may take for the fragments of one tile of the
    /// image, 28 each. With less, there are more tiles, and each draws all cells.
    pub fragment_bytes: u64,
    /// Samples a side of the texture of [`ExitSearch::PerVertexTexture`], from 2 to
    /// [`ExitSearch::MOST`]; the paper has 128.
    pub minimum_side: u32,
    /// How isosurfaces are found in a cell.
    pub surfaces: SurfaceSearch,
    /// The box and range to which positions, scalars of isosurfaces and the depth cue are relative, for parts of a
    /// mesh or steps of a time series that are to agree; `None` for the volume's own.
    pub domain: Option<Domain>,
}

tetrascope_core::choices! {
    ExitSearch: "per-fragment" = PerFragment, "per-vertex" = PerVertex,
        "per-vertex-texture" = PerVertexTexture;
    CellLayout: "shared-vertices" = SharedVertices, "twelve-floats" = TwelveFloats,
        "twelve-shorts" = TwelveShorts;
    Order: "auto" = Auto, "unsorted" = Unsorted, "centroid" = Centroid, "mpvo" = Mpvo,
        "per-pixel" = PerPixel;
    Sort: "auto" = Auto, "gpu" = Gpu, "cpu" = Cpu;
}

/// The defaults of [`ENTRY`]'s settings.
impl Default for ProjectionOptions {
    fn default() -> Self {
        ProjectionOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

/// Where a ray's other crossing with a cell is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ExitSearch {
    /// In each fragment (§3.2).
    PerFragment,
    /// Ray parameters are computed at the vertices of front faces and interpolated, and
    /// their minimum is taken by comparisons (§4). For parallel rays alone, without
    /// [`Order::PerPixel`] and isosurfaces.
    PerVertex,
    /// The same, and their minimum is taken from a texture (§4.1), of
    /// [`ProjectionOptions::minimum_side`].
    PerVertexTexture,
}

/// How cells lie in the device's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum CellLayout {
    /// Four indices per cell into vertices that cells share (§8): 16 bytes per cell,
    /// 16 bytes per vertex, and 4 bytes per cell that is drawn.
    SharedVertices,
    /// Twelve vertices per cell, three for each face, of fifteen numbers (§6): 720 bytes.
    /// For ray parameters at vertices.
    TwelveFloats,
    /// The same with eleven of the numbers in 16 bits (§7): 456 bytes.
    TwelveShorts,
}

/// In which order cells are drawn where the optical model does not commute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Order {
    /// [`Order::Mpvo`] where it is known to be right, else [`Order::PerPixel`]; a note of
    /// the frame says why. [`Order::Mpvo`] alone with ray parameters at vertices, which
    /// leave no other.
    Auto,
    /// As they come: right only for models that commute.
    Unsorted,
    /// By the distance of their centroids, farthest first: the fastest, and not always the
    /// order of visibility. On real files a picture was off by up to 0.25.
    Centroid,
    /// By which cell is in front of which across their face, on the CPU (Williams
    /// 1992): exact in convex meshes, in views in which no cells hide each other in a
    /// cycle. Parts of other meshes are ordered by their distance, which is a guess, and
    /// cycles are broken and counted. A note of the frame says where it is not known to be
    /// right.
    Mpvo,
    /// Fragments are sorted in each pixel: exact in any mesh whose cells do not overlap.
    PerPixel,
}

/// Where [`Order::Centroid`] sorts. Keys and ties are the same, so the picture is too but
/// for cells whose keys differ by rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Sort {
    /// On the CPU where the device is one too (llvmpipe), else on the device. A frame of the
    /// Blunt Fin's 187 395 cells took 0.12 s of CPU time less so, and does not wait between
    /// passes.
    Auto,
    /// By the radix sort of `tetrascope-gpu`, so that nothing is sent for a frame.
    Gpu,
    /// By one on the CPU, which sends 4 bytes for each cell or piece of one.
    Cpu,
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

impl ProjectionOptions {
    /// Refuses what cannot be had together, and numbers out of range.
    pub(crate) fn validate(&self, appearance: &Appearance) -> Result<(), Error> {
        let model = appearance.optical_model;
        check_knots(&appearance.transfer_function)?;
        self.integration.check(NAME, model, false)?;
        self.surfaces.validate()?;
        let fades = appearance.depth_cue.is_some() && model != OpticalModel::Isosurfaces;
        if fades && self.integration != Integration::Exact {
            return unsupported(
                "a depth cue with a table of integrals",
                "the cue differs from place to place, the table does not",
            );
        }
        if self.exit_search == ExitSearch::PerFragment {
            return match self.cell_layout {
                CellLayout::SharedVertices => Ok(()),
                _ => unsupported(
                    "twelve vertices a cell without ray parameters at vertices",
                    "fragments see whole cells, of shared vertices",
                ),
            };
        }
        let most = ExitSearch::MOST;
        if !(2..=most).contains(&self.minimum_side) {
            return Err(Error::Invalid {
                what: format!(
                    "a minimum texture with {} samples a side",
                    self.minimum_side
                ),
                help: Some(format!("give 2 to {most}")),
            });
        }
        if appearance.depth_cue.is_some() || !appearance.clip_planes.is_empty() {
            return unsupported(
                "a depth cue or clip planes with ray parameters at vertices",
                "fragments do not know where on the ray they are",
            );
        }
        match model {
            OpticalModel::Isosurfaces => unsupported(
                "isosurfaces with ray parameters at vertices",
                "they are found where each fragment sees the whole cell",
            ),
            OpticalModel::EmissionAbsorption if self.order == Order::PerPixel => unsupported(
                "per-pixel order with ray parameters at vertices",
                "its tiles are made for what footprints cover",
            ),
            _ => Ok(()),
        }
    }

    /// Refuses a view that is not drawn like this.
    pub(crate) fn check_view(&self, view: &View) -> Result<(), Error> {
        let perspective = matches!(view.camera.projection, Projection::Perspective { .. });
        match perspective && self.exit_search != ExitSearch::PerFragment {
            false => Ok(()),
            true => unsupported(
                "perspective cameras with ray parameters at vertices",
                "they are linear over a face for parallel rays alone",
            ),
        }
    }
}

fn unsupported(what: &str, reason: &str) -> Result<(), Error> {
    Err(Error::Unsupported {
        renderer: NAME,
        what: what.into(),
        reason: reason.into(),
    })
}

impl SurfaceSearch {
    /// The most samples per side of a table.
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

impl ExitSearch {
    /// The most samples per side of a minimum texture: 64 MiB.
    pub const MOST: u32 = 256;
}

impl Sort {
    /// Whether that is on the CPU.
    pub(crate) fn is_on_cpu(self, gpu: &Gpu) -> bool {
        match self {
            Sort::Auto => gpu.info().device_type == DeviceType::Cpu,
            Sort::Gpu => false,
            Sort::Cpu => true,
        }
    }
}
