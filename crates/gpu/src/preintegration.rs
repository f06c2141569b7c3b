//! Tables of the integral over a segment, filled on the device.
//!
//! S. Röttger, M. Kraus, T. Ertl, "Hardware-Accelerated Volume and Isosurface Rendering
//! Based on Cell-Projection", IEEE Visualization 2000; K. Engel, M. Kraus, T. Ertl,
//! "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel
//! Shading", 2001; as Weiler, Kraus, Ertl 2002, §5.1, and Bernardon et al. 2004 use them.
//!
//! `preintegration/fill.wgsl` and, where there are lengths, `fill_lengths.wgsl` integrate every
//! entry in closed form, in parallel, so an entry has the rounding of f32 alone; `lookup.wgsl`
//! interpolates between them.
//!
//! # The axes
//! - *Scalars at the front and the back* go from the transfer function's first knot to its
//!   last. The field's own range would make a table depend on each step of a time series,
//!   and would spend entries where the function is constant: what lies beyond the knots
//!   is added in closed form, and costs nothing where no scalar does.
//! - *The length* goes from 0 to the longest edge in the volume, the most that a ray can
//!   have in a tetrahedron. Only integrals that are not linear in it have this axis.
//!
//! [`Integration::TableFixed`] is the exception to both: no axis is a length, and the
//! scalars go from the field's least to its greatest, as a part of a segment outside of the
//! table would need a length of its own.
//!
//! # Errors
//! Interpolation is linear, so its error is of second order in the distance of the samples
//! where the integral is smooth (measured: 2.00), and its root mean square of about first
//! order where the transfer function has steps (measured: 1.1 to 1.2): near a step the mean
//! over an interval takes any value between both sides. A maximum has edges as well, and
//! errs by up to the slope times the distance of the samples.
//!
//! Interpolation is written out in f32. Texture units keep 8 bits of a weight, so that
//! they err by up to 1/512 of the difference between neighbors, h f'/512, where
//! interpolation itself errs by h² f''/8: more than all else for smooth functions from some
//! 64 samples per side on; and what a table errs by would depend on the adapter. They also
//! need the feature `FLOAT32_FILTERABLE`. The price: on llvmpipe (Mesa 22.3.6), whose
//! filter is in f32 and agrees to 4e-6, 2²¹ lookups in 128³ samples take 0.36 s by the
//! texture unit and 0.6 s by hand.

use tetrascope_core::{Error, OpticalModel};
use tetrascope_f32::look::table_span;
use tetrascope_f32::{KnotPair, deepest};
use wgpu::{BindingType, BufferUsages, TextureFormat, TextureUsages};

use crate::Gpu;
use crate::passes::{READ, deep, group, model_constant};
use crate::pipelines::{ComputeProgram, Constant};

/// How a ray's segment in a cell is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integration {
    /// Split at the transfer function's knots, then in closed form.
    Exact,
    /// From a table over the scalars at both ends, times the length. Exact but for the
    /// table's resolution in [`OpticalModel::Emission`], [`OpticalModel::Absorption`] and
    /// [`OpticalModel::MaximumIntensity`]; there is none for
    /// [`OpticalModel::EmissionAbsorption`], which is not linear in the length.
    Table2d {
        /// Samples along each axis, from 2 to [`Integration::MOST_2D`].
        n: u32,
    },
    /// From a table over the scalars at both ends and the length, of light and opacity
    /// or, in [`OpticalModel::Absorption`], of opacity. Models without an opacity need
    /// no third axis and get the table of [`Integration::Table2d`].
    Table3d {
        /// Samples along each axis, from 2 to [`Integration::MOST_3D`].
        n: u32,
    },
    /// From a table over the scalars at both ends, of light and opacity of a segment of one
    /// length, which every segment is taken to have: Bernardon et al. 2004, §3.2, "an
    /// alternate 2D LUT table can be used instead if we assume a fixed distance value".
    ///
    /// They do not say which value. Here it is the mean length of a line in a cell
    /// ([`mean_chord`](tetrascope_f32::mean_chord)), with which the optical depth of a homogeneous volume is right on
    /// average over all lines; on one line of k cells of length l it is k · mean / l times
    /// what it should be, and no finer table mends that. A maximum knows no length and
    /// gets the table of [`Integration::Table2d`].
    TableFixed {
        /// Samples along each axis, from 2 to [`Integration::MOST_2D`].
        n: u32,
    },
}

/// An [`Integration`] of so many samples per side.
pub type OfSide = fn(u32) -> Integration;

impl Integration {
    /// The choices of every renderer with their names, made for a number of samples per side.
    pub const ALL: [(&'static str, OfSide); 3] = [
        ("exact", |_| Integration::Exact),
        ("table-2d", |n| Integration::Table2d { n }),
        ("table-3d", |n| Integration::Table3d { n }),
    ];

    /// One more, of renderers that follow rays.
    pub const FIXED: (&'static str, OfSide) = ("table-2d-fixed", |n| Integration::TableFixed { n });

    /// The most samples per side of a table with two axes: 64 MiB.
    pub const MOST_2D: u32 = 2048;

    /// The most samples per side of a table with three axes: 256 MiB.
    pub const MOST_3D: u32 = 256;

    /// Samples along an axis, and how many axes; `None` for [`Integration::Exact`].
    fn shape(self, model: OpticalModel) -> Option<(u32, u32)> {
        let linear = matches!(
            model,
            OpticalModel::Emission | OpticalModel::MaximumIntensity
        );
        match self {
            // Surfaces have no integral.
            _ if model == OpticalModel::Isosurfaces => None,
            Integration::Exact => None,
            Integration::Table2d { n } | Integration::TableFixed { n } => Some((n, 2)),
            Integration::Table3d { n } if linear => Some((n, 2)),
            Integration::Table3d { n } => Some((n, 3)),
        }
    }

    /// Whether each segment of `model` is taken to have one length.
    fn is_fixed(self, model: OpticalModel) -> bool {
        let lengthless = matches!(
            model,
            OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces
        );
        matches!(self, Integration::TableFixed { .. }) && !lengthless
    }

    /// Whether `renderer` can draw `model` like this, on any device; `has_length` says whether
    /// it knows a length for [`Integration::TableFixed`].
    ///
    /// [`Error::Unsupported`] for a model without such a table and for more samples than
    /// the range above, [`Error::Invalid`] for fewer.
    pub fn check(
        self,
        renderer: &'static str,
        model: OpticalModel,
        has_length: bool,
    ) -> Result<(), Error> {
        let most = match self {
            Integration::Exact => return Ok(()),
            Integration::Table2d { .. } | Integration::TableFixed { .. } => Integration::MOST_2D,
            Integration::Table3d { .. } => Integration::MOST_3D,
        };
        let (Integration::Table2d { n }
        | Integration::Table3d { n }
        | Integration::TableFixed { n }) = self
        else {
            return Ok(());
        };
        if n < 2 {
            return Err(Error::Invalid {
                what: format!("a table of integrals with {n} samples a side"),
                help: Some(format!("give 2 to {most}")),
            });
        }
        if n > most {
            return Err(Error::Unsupported {
                renderer,
                what: format!("a table of integrals with {n} samples a side"),
                reason: format!("beyond {most} a table of this many axes takes too much memory"),
            });
        }
        // Only now, so that a restyle to another model meets no bad number.
        let two = matches!(self, Integration::Table2d { .. });
        if two && model == OpticalModel::EmissionAbsorption {
            return Err(Error::Unsupported {
                renderer,
                what: "emission and absorption from a table with two axes".into(),
                reason: "the integral is not linear in a segment's length; table-3d has the \
                         length as well, table-2d-fixed takes all for equally long"
                    .into(),
            });
        }
        if self.is_fixed(model) && !has_length {
            return Err(Error::Unsupported {
                renderer,
                what: "segments that are all taken for equally long".into(),
                reason: "its fragments are of any length".into(),
            });
        }
        Ok(())
    }
}

/// The input of a table; equal inputs make equal tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Source<'a> {
    /// How segments are integrated.
    pub integration: Integration,
    /// The optical model of the integral.
    pub model: OpticalModel,
    /// The transfer function.
    pub intervals: &'a [KnotPair],
    /// The longest segment that there can be, normalized.
    pub longest: f32,
    /// The fixed length that [`Integration::TableFixed`] needs; without it that is unsupported.
    pub fixed: Option<Fixed>,
}

/// Segments that are all taken for equally long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    /// Normalized.
    pub length: f32,
    /// The field's least and greatest scalar, in the unit of the intervals: the table's axes.
    pub scalars: (f32, f32),
}

impl Source<'_> {
    /// Samples along an axis and how many axes, the scalars at their ends, and the length
    /// that a table knows.
    fn axes(&self) -> Axes {
        let fixed = self.fixed.filter(|_| self.integration.is_fixed(self.model));
        let shape = self.integration.shape(self.model).unwrap_or((1, 0));
        let first = self.intervals.first().map_or(0.0, |i| i.high);
        let last = self.intervals.last().map_or(1.0, |i| i.low);
        Axes {
            shape,
            fixed: fixed.is_some(),
            scalars: fixed.map_or((first, last), |fixed| fixed.scalars),
            length: match (fixed, shape.1) {
                (Some(fixed), _) => fixed.length,
                // Chords in f32 may exceed the longest edge by a few roundings.
                (None, 3) => self.longest * (1.0 + 1e-6),
                (None, _) => 1.0,
            },
        }
    }
}

/// The meaning of a table's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axes {
    /// Samples along an axis, and how many axes; 0 axes where there is no table.
    shape: (u32, u32),
    /// Whether all segments have one length.
    fixed: bool,
    /// At the ends of the first two axes.
    scalars: (f32, f32),
    /// At the end of the third axis, or of every segment.
    length: f32,
}

impl Axes {
    /// The constants of `axes.wgsl`.
    fn constants(&self) -> [Constant; 3] {
        let (side, axes) = self.shape;
        [
            ("TABLE_AXES", axes.into()),
            ("TABLE_SIDE", side.max(2).into()),
            ("TABLE_IS_FIXED", f64::from(u8::from(self.fixed))),
        ]
    }
}

/// Lengths of one invocation, as in `fill_lengths.wgsl`.
const LENGTHS: u32 = 16;

/// A table on the device, or none for [`Integration::Exact`]. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Table {
    axes: Axes,
    model: OpticalModel,
    intervals: Vec<KnotPair>,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

/// How shaders bind a table, `texture_3d<f32>`.
pub const TABLE: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D3,
    multisampled: false,
};

impl Table {
    /// Fills a table for `renderer`, in a submission of its own, and waits for it.
    ///
    /// Errors as the docs of [`Integration`] say, and as [`Gpu::texture`] has them.
    pub fn new(gpu: &Gpu, renderer: &'static str, source: &Source) -> Result<Table, Error> {
        let Source {
            integration,
            model,
            intervals,
            ..
        } = *source;
        integration.check(renderer, model, source.fixed.is_some())?;
        let format = match model {
            OpticalModel::Absorption => TextureFormat::R32Float,
            _ => TextureFormat::Rgba32Float,
        };
        let (side, axes) = source.axes().shape;
        let limit = gpu.limits().max_texture_dimension_3d;
        if side > limit {
            return Err(Error::TooLarge {
                what: "the table of integrals".into(),
                needed: side.into(),
                limit: limit.into(),
                unit: "samples a side",
            });
        }
        let size = wgpu::Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: if axes == 3 { side } else { 1 },
        };
        let usage = TextureUsages::TEXTURE_BINDING
            | TextureUsages::STORAGE_BINDING
            | TextureUsages::COPY_SRC;
        let texture = gpu.texture_3d("the table of integrals", size, format, usage)?;
        let table = Table {
            axes: source.axes(),
            model,
            intervals: intervals.to_vec(),
            view: texture.create_view(&Default::default()),
            texture,
        };
        if axes > 0 {
            table.fill(gpu)?;
        }
        Ok(table)
    }

    /// This table if it is what [`Table::new`] would make, else a new one.
    pub fn renewed(
        &self,
        gpu: &Gpu,
        renderer: &'static str,
        source: &Source,
    ) -> Result<Table, Error> {
        let axes = source.axes();
        let unused = axes.shape.1 == 0 && self.axes.shape.1 == 0;
        let same =
            self.axes == axes && self.model == source.model && self.intervals == source.intervals;
        if unused || same {
            return Ok(self.clone());
        }
        Table::new(gpu, renderer, source)
    }

    /// The constants of `lookup.wgsl` for a volume whose scalars, in the unit of the
    /// intervals, go from `low` to `high`.
    pub fn constants(&self, (low, high): (f32, f32)) -> [Constant; 4] {
        let [axes, side, fixed] = self.axes.constants();
        let left = low < self.axes.scalars.0 || high > self.axes.scalars.1;
        let left = (
            "TABLE_IS_LEFT",
            f64::from(u8::from(left && !self.axes.fixed)),
        );
        [axes, side, fixed, left]
    }

    /// The values that `table_span` of `axes.wgsl` has.
    pub fn span(&self) -> [f32; 4] {
        table_span(self.axes.scalars, self.axes.length)
    }

    /// The resource that shaders bind as [`TABLE`].
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::TextureView(&self.view)
    }

    /// The texture: red is the scalar at the front, then that at the back, then the length.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Bytes on the device, 0 where there is no table.
    pub fn bytes(&self) -> u64 {
        let (side, axes) = self.axes.shape;
        let texel = u64::from(self.texture.format().block_copy_size(None).unwrap_or(16));
        match axes {
            0 => 0,
            axes => u64::from(side).pow(axes) * texel,
        }
    }

    /// The constant that says how deep all entries are.
    fn deep(&self) -> Constant {
        deep(deepest(
            &self.intervals,
            self.axes.scalars,
            self.axes.length,
        ))
    }

    fn fill(&self, gpu: &Gpu) -> Result<(), Error> {
        let label = "gpu::preintegration";
        let format = self.texture.format();
        let source = match format {
            TextureFormat::R32Float => tetrascope_shaders::preintegration::FILL_DEPTH,
            _ => tetrascope_shaders::preintegration::FILL_COLOR,
        };
        let storage = BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: wgpu::TextureViewDimension::D3,
        };
        let intervals = gpu.upload(label, &self.intervals, BufferUsages::STORAGE)?;
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let stage = wgpu::ShaderStages::COMPUTE;
        let layout = gpu.layout(label, stage, &[READ, storage, READ])?;
        let mut constants = self.axes.constants().to_vec();
        let deep = self.deep();
        let is_deep = deep.1 != 0.0;
        constants.extend([model_constant(self.model), deep]);
        let has_lengths = self.axes.shape.1 == 3;
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label,
            source,
            entry: Some(match has_lengths {
                true => "cs_fill_lengths",
                false => "cs_fill",
            }),
            constants,
            groups: vec![layout.clone()],
        })?;
        let span = gpu.upload(label, &[self.span()], BufferUsages::STORAGE)?;
        gpu.checked(label, 0, || {
            let resources = [
                intervals.as_entire_binding(),
                self.binding(),
                span.as_entire_binding(),
            ];
            let group = group(gpu, label, &layout, &resources);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(label),
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            let side = self.axes.shape.0;
            let per_group = |entries: u32| side.div_ceil(entries);
            match has_lengths {
                true => {
                    // The first lengths are split among three where segments may be deep.
                    let more = if is_deep { 2 } else { 0 };
                    pass.dispatch_workgroups(per_group(64), side, per_group(LENGTHS) + more);
                }
                false => pass.dispatch_workgroups(per_group(8), per_group(8), 1),
            }
        })?;
        // What goes wrong is to be known here, and the time is this table's.
        gpu.finish(encoder)
    }
}
