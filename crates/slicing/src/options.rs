//! Options of slicing.

use tetrascope_core::grid::coverage::fades;
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::{Error, OpticalModel, Settings};
pub use tetrascope_f32::Domain;

use crate::NAME;

use crate::ENTRY;

/// How a grid is sliced.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicingOptions {
    /// Slices that a ray crosses on the shortest way between two samples, at least; in
    /// [[`MIN_SLICES_PER_VOXEL`], [`MAX_SLICES_PER_VOXEL`]]. Where those are thousands, as
    /// samples are near each other along one axis alone, on its own way from sample to sample.
    pub slices_per_voxel: f64,
    /// The quantity that is computed for a slab.
    pub integration: Integration,
    /// How samples are interpolated.
    pub filtering: Filtering,
    /// How long a slab is.
    pub step_length: StepLength,
    /// The treatment of slabs that are partly outside of the volume.
    pub slab_ends: SlabEnds,
    /// Which edges of a box count as cut by a plane; [`Slicer::Rays`] has none.
    pub plane_test: PlaneTest,
    /// Who cuts boxes, if anyone does.
    pub slicer: Slicer,
    /// Who finds the boxes that can show.
    pub traversal: Traversal,
    /// Into how many boxes the volume is divided, to skip the empty ones.
    pub level: Level,
    /// Whether and how the volume is lit.
    pub shading: Shading,
    /// How isosurfaces are found.
    pub crossing: Crossing,
    /// The normals of lit volumes and isosurfaces.
    pub gradient: Gradient,
    /// The box and range to which positions, scalars of isosurfaces and the depth cue are relative, for parts of a
    /// grid or steps of a time series that are to agree; `None` for the volume's own.
    pub domain: Option<Domain>,
    /// How samples lie in textures.
    pub storage: Storage,
    /// The level of the octree whose boxes are bricks, where samples are stored in bricks.
    /// Deeper ones skip more of the volume and repeat more of it: a brick of b³ cells has
    /// (b + 1)³ samples, or (b + 3)³ where slabs or gradients reach beyond it. That is 10 %
    /// or 31 % more than b³ for 32 cells, 42 % or 160 % for 8.
    pub brick_level: Level,
    /// The most bytes of textures for samples and of copies on their way there.
    pub memory_budget: u64,
}

/// The least [`SlicingOptions::slices_per_voxel`]: a slab's ends then lie at most one
/// sample away from its middle, as far as a brick's border reaches.
pub const MIN_SLICES_PER_VOXEL: f64 = 0.5;

/// The greatest [`SlicingOptions::slices_per_voxel`].
pub const MAX_SLICES_PER_VOXEL: f64 = 64.0;

tetrascope_core::choices! {
    Integration: "post-classified" = PostClassified, "slabs" = Slabs;
    Filtering: "exact" = Exact, "hardware" = Hardware;
    StepLength: "per-ray" = PerRay, "planar" = Planar;
    SlabEnds: "clipped" = Clipped, "whole" = Whole;
    PlaneTest: "published" = Published, "sides" = Sides;
    Slicer: "rays" = Rays, "vertex-program" = VertexProgram, "cpu" = Cpu;
    Traversal: "cpu" = Cpu, "gpu" = Gpu;
    Level: "auto" = Auto, "0" = Fixed(0), "1" = Fixed(1), "2" = Fixed(2), "3" = Fixed(3),
        "4" = Fixed(4), "5" = Fixed(5), "6" = Fixed(6), "7" = Fixed(7);
    Shading: "none" = None, "phong" = Phong(Phong::DEFAULT);
    Crossing: "cells" = Cells, "corrected" = Corrected, "linear" = Linear;
    Gradient: "auto" = Auto, "central-differences" = CentralDifferences, "trilinear" = Trilinear;
    Storage: "auto" = Auto, "bricks" = Bricks;
}

/// The defaults of [`ENTRY`]'s settings.
impl Default for SlicingOptions {
    fn default() -> Self {
        SlicingOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

impl SlicingOptions {
    /// Refuses numbers out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String, help: String| {
            Err(Error::Invalid {
                what,
                help: Some(help),
            })
        };
        let range = MIN_SLICES_PER_VOXEL..=MAX_SLICES_PER_VOXEL;
        if !range.contains(&self.slices_per_voxel) {
            return wrong(
                format!("{} slices per voxel", self.slices_per_voxel),
                format!("give {MIN_SLICES_PER_VOXEL} to {MAX_SLICES_PER_VOXEL}; 2 is usual"),
            );
        }
        for level in [self.level, self.brick_level] {
            if let Level::Fixed(level) = level
                && level > MAX_LEVEL
            {
                return wrong(
                    format!("level {level} of the octree"),
                    format!("give at most {MAX_LEVEL}, or auto"),
                );
            }
        }
        if self.slicer == Slicer::Cpu && self.traversal == Traversal::Gpu {
            return wrong(
                "polygons cut on the CPU for boxes that the GPU finds".into(),
                "take the traversal, or leave the slicer, with the CPU".into(),
            );
        }
        if let Shading::Phong(phong) = self.shading {
            let terms = [
                phong.ambient,
                phong.diffuse,
                phong.specular,
                phong.shininess,
            ];
            if !terms.iter().all(|t| t.is_finite() && *t >= 0.0) {
                return wrong(
                    format!("the light {phong:?}"),
                    "give numbers of 0 or more".into(),
                );
            }
        }
        Ok(())
    }

    /// Refuses a grid on the device that cannot be drawn so.
    pub(crate) fn check_device_grid(&self, lattice: &Lattice) -> Result<(), Error> {
        self.check_interpolation(lattice)?;
        let refused = match (self.slicer, self.storage) {
            (Slicer::Cpu, _) => ("polygons cut on the CPU", "only the GPU knows its boxes"),
            (_, Storage::Bricks) => ("bricks", "it is one texture"),
            _ => return Ok(()),
        };
        let (what, reason) = refused;
        Err(Error::Unsupported {
            renderer: NAME,
            what: format!("a grid on the device in {what}"),
            reason: reason.into(),
        })
    }

    /// Refuses a grid for the device whose samples fill cells.
    pub(crate) fn check_interpolation(&self, lattice: &Lattice) -> Result<(), Error> {
        match lattice.interpolation {
            Interpolation::Linear => Ok(()),
            Interpolation::Nearest => Err(Error::Unsupported {
                renderer: NAME,
                what: "samples that fill cells, on the device".into(),
                reason: "its slices need one sample more along each axis".into(),
            }),
        }
    }

    /// Refuses what has no meaning for a volume with
    /// [coverage](tetrascope_core::grid::coverage).
    pub(crate) fn check_coverage(&self, model: OpticalModel) -> Result<(), Error> {
        match fades(model) && self.shading != Shading::None {
            false => Ok(()),
            true => Err(Error::Unsupported {
                renderer: NAME,
                what: "shading of a grid with coverage".into(),
                reason: "where coverage changes there is no gradient of the scalar alone".into(),
            }),
        }
    }

    /// Samples beyond a box that its slabs may read in `model`.
    pub(crate) fn reach(&self, model: OpticalModel) -> usize {
        let central = !self.is_trilinear(model);
        if model == OpticalModel::Isosurfaces {
            // As far as a slab's ends, and a sample more for differences.
            return 1 + usize::from(central);
        }
        let lit = self.shading != Shading::None && central;
        usize::from(lit || self.integration == Integration::Slabs)
    }

    /// Whether gradients are those of the interpolant.
    pub(crate) fn is_trilinear(&self, model: OpticalModel) -> bool {
        match self.gradient {
            Gradient::Auto => model == OpticalModel::Isosurfaces,
            Gradient::CentralDifferences => false,
            Gradient::Trilinear => true,
        }
    }
}

/// The quantity that is computed for a slab between two planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Integration {
    /// Post-classification (§7): the color and extinction of the sample in the middle,
    /// constant over the slab. Converges at second order where the transfer function is
    /// smooth and all samples have a value; at first order beside those that have none, as
    /// a slab is drawn whole or not at all.
    PostClassified,
    /// The scalar varies linearly between the slab's two ends, split at the transfer
    /// function's knots, and each piece is integrated in closed form: pre-integration
    /// without a table. Converges at second order also where the transfer function has
    /// steps and where samples have no value: slabs end there.
    Slabs,
}

/// How samples are interpolated, trilinearly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filtering {
    /// In f32, by eight loads.
    Exact,
    /// By the texture unit, as published: its fractions may have only 8 bits. Bytes are kept
    /// in 16 bits each, as the result of filtering has no more bits than texels on some
    /// devices. Where the device does not filter a type of samples, as
    /// [`Filtering::Exact`], and the frame says so.
    Hardware,
}

/// How long a slab is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepLength {
    /// Along the ray.
    PerRay,
    /// The distance of planes, as published: in perspective, slabs are too thin by the
    /// cosine of the angle to the optical axis.
    Planar,
}

/// The treatment of slabs that are partly outside of the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SlabEnds {
    /// They count for the part inside.
    Clipped,
    /// They count whole if their middle is inside, as published: converges at first
    /// order only.
    Whole,
}

/// Which edges of a box count as cut by a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlaneTest {
    /// 0 ≤ λ ≤ 1 (Listing 1, line 45). Rounding may hide the cut edge of a plane that
    /// passes just before a corner, and the polygon's corner is then anywhere.
    Published,
    /// Its ends lie on different sides.
    Sides,
}

/// Who cuts boxes into polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slicer {
    /// Nobody: a pixel's fragment goes through the same slabs of its ray, front to back, and
    /// passes boxes that do not show. Two neighbors share the sample between them, nothing is
    /// blended slab by slab, and what is behind all that shows is left out. A volume that is
    /// streamed is drawn by [`Slicer::VertexProgram`], and the frame says so.
    Rays,
    /// The vertex program, from one list of boxes.
    VertexProgram,
    /// The CPU, as was usual before the paper: it sends every polygon, each frame.
    Cpu,
}

/// Who finds the boxes that can show, and their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Traversal {
    /// The CPU, from the root of the octree down, as published.
    Cpu,
    /// The GPU, all boxes of a level at once; nothing but the camera is sent for a frame.
    /// A volume that is streamed is traversed by the CPU, which has to know what to
    /// stream, and the frame says so. A grid on the device, and one with coverage, is always
    /// traversed by the GPU, which alone knows its ranges.
    Gpu,
}

/// The deepest level of the octree.
pub const MAX_LEVEL: u32 = 7;

/// Into how many boxes the volume is divided: 2^level along each axis, fewer along
/// those on which boxes would have less than 8 cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// This level, at most [`MAX_LEVEL`]; 0 is one box.
    Fixed(u32),
    /// For drawing, the level for which fragments saved most outweigh polygons added, or on the
    /// device, where nobody counts boxes before, the first of at most 16 cells per side; for
    /// bricks, the first of at most 64 cells per side that fit the budget.
    Auto,
}

/// Whether and how volumes are lit; isosurfaces are, by the appearance's own lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shading {
    /// Not at all.
    None,
    /// By a light at the eye and [`SlicingOptions::gradient`] (§7).
    Phong(Phong),
}

/// Phong's terms: a color c becomes c (ambient + diffuse |n · l|), and
/// specular |n · l|^shininess times the opacity is added where the model absorbs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Share of the color without light.
    pub ambient: f64,
    /// Share of the color in full light.
    pub diffuse: f64,
    /// Strength of the white highlight.
    pub specular: f64,
    /// Its exponent.
    pub shininess: f64,
}

impl Phong {
    /// Mostly the color, and a soft highlight.
    pub const DEFAULT: Phong = Phong {
        ambient: 0.3,
        diffuse: 0.7,
        specular: 0.2,
        shininess: 20.0,
    };
}

impl Default for Phong {
    fn default() -> Self {
        Phong::DEFAULT
    }
}

/// How the first isosurface in a slab is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Crossing {
    /// As a root of the cubic that the field is along the ray in each voxel cell: exact to
    /// f32, however far slices are apart.
    Cells,
    /// Between the samples at the slab's ends, if a surface is between their scalars: where
    /// they would be linear, and then corrected by up to eight more samples (false position).
    Corrected,
    /// The same without corrections: off by what the field is bent, so by second order in
    /// the distance of slices.
    Linear,
}

/// The kind of gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gradient {
    /// [`Gradient::Trilinear`] of isosurfaces, and [`Gradient::CentralDifferences`] of lit
    /// volumes.
    Auto,
    /// Differences of samples one voxel before and behind along each axis, on the fly, as
    /// published (§7): six fetches. Smoother than the field itself, which has edges.
    CentralDifferences,
    /// Gradients of the trilinear interpolant in its cell, as `tetrascope_core::appearance` defines it.
    Trilinear,
}

/// How samples lie in textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Storage {
    /// One texture if the budget and the device allow, else bricks.
    Auto,
    /// Bricks with borders, in the slots of one texture; only those that can show. What
    /// does not fit the budget is streamed while a frame is drawn.
    Bricks,
}
