//! The renderer: samples from wherever they are, an appearance, and frames of them.

mod frame;
mod style;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use tetrascope_core::grid::BrickSource;
use tetrascope_core::{Appearance, Bounds, Error, Frame, View, Volume, VolumeRenderer};
use tetrascope_gpu::{Canvas, Commands, DeviceGrid, Draw, Gpu, Recorded, Target, draw, wgpu};

use style::{Parts, Style};

use crate::ABILITIES;
use crate::NAME;
use crate::cull::CullPass;
use crate::entry::check;
use crate::options::SlicingOptions;
use crate::samples::{Content, Samples};
use crate::slice::SlicePass;

/// Pipelines and the uploaded grid.
#[derive(Debug)]
pub struct Slicing {
    canvas: Canvas,
    options: SlicingOptions,
    pass: SlicePass,
    /// Where the GPU traverses.
    cull: Option<CullPass>,
    style: Style,
}

impl Slicing {
    /// Uploads the grid in `volume` and compiles what `appearance` needs.
    ///
    /// [`Error::Unsupported`] for a mesh, [`Error::TooLarge`] and
    /// [`Error::OutOfMemory`] if the device or the budget has no room for one brick. A grid with
    /// [coverage](tetrascope_core::grid::coverage) is drawn as by [`Slicing::from_device`], and
    /// refused with what that refuses.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        let bounds = volume.bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::of(gpu, volume, reach, options)
        })
    }

    /// Draws a grid that need not fit in memory; see also
    /// [`GridStream`](tetrascope_core::grid::GridStream).
    ///
    /// Reads all of it once, to know what is empty. Errors as in [`Slicing::new`].
    pub fn from_source(
        gpu: &Gpu,
        source: Arc<dyn BrickSource>,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        let lattice = source.lattice();
        check(&lattice, appearance, options)?;
        let bounds = lattice.bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::from_source(source, reach, options)
        })
    }

    /// Draws a grid that is on the device: no sample is read back or looked at by the CPU, and
    /// what is empty is found there. The texture may be written again; see [`Slicing::refresh`].
    ///
    /// The GPU finds the boxes, whatever [`SlicingOptions::traversal`] says.
    ///
    /// ```no_run
    /// use tetrascope_core::grid::Lattice;
    /// use tetrascope_core::{Appearance, Error, View};
    /// use tetrascope_gpu::device_grid::Texels;
    /// use tetrascope_gpu::{DeviceGrid, Draw as _, Gpu, Target, wgpu};
    /// use tetrascope_slicing::{Slicing, SlicingOptions};
    ///
    /// # fn record_yours(_: &mut wgpu::CommandEncoder, _: &wgpu::Texture) {}
    /// fn frames(
    ///     gpu: &Gpu,
    ///     lattice: &Lattice,
    ///     appearance: &Appearance,
    ///     views: &[View],
    ///     target: &Target,
    /// ) -> Result<(), Error> {
    ///     let range = Some((0.0, 1.0)); // no scalar will lie outside
    ///     let grid = DeviceGrid::new(gpu, lattice, Texels::Covered, range)?;
    ///     let options = SlicingOptions::default();
    ///     let slicing = Slicing::from_device(gpu, &grid, appearance, &options)?;
    ///     for view in views {
    ///         let mut encoder = gpu.device().create_command_encoder(&Default::default());
    ///         // A compute pass that stores (scalar, coverage) in each texel.
    ///         record_yours(&mut encoder, grid.texture());
    ///         slicing.refresh(&mut encoder)?;
    ///         slicing.encode(&mut encoder, view, target)?;
    ///         gpu.queue().submit([encoder.finish()]);
    ///     }
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// [`Error::Unsupported`] for samples that fill cells, for polygons cut on the CPU and for
    /// bricks; with coverage also for shading.
    pub fn from_device(
        gpu: &Gpu,
        grid: &DeviceGrid,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        let bounds = grid.lattice().bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::on_device(gpu, grid.clone(), reach, options)
        })
    }

    /// Draws another grid that is on the device from now on.
    ///
    /// # Errors
    /// As [`Slicing::from_device`]; what was drawn before is kept then.
    pub fn reload_device(&mut self, grid: &DeviceGrid) -> Result<(), Error> {
        self.reload_made(grid, |_| ())
    }

    /// Draws another grid from now on, which the commands that `make` records write; they are
    /// submitted once nothing else can fail. So the grid may have the texture of the one before;
    /// if its lattice and its domain ([`SlicingOptions::domain`]) are the same, too, nothing is
    /// made anew.
    ///
    /// # Errors
    /// As [`Slicing::from_device`]; what was drawn before is kept then.
    pub fn reload_made(
        &mut self,
        grid: &DeviceGrid,
        make: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let appearance = &self.style.appearance;
        ABILITIES.check(NAME, appearance, &grid.lattice().bounds())?;
        let gpu = self.canvas.gpu();
        if self.style.volume.suits(grid, &self.options)? {
            return self.style.volume.find(gpu, make);
        }
        let reach = self.options.reach(appearance.optical_model);
        let samples = Samples::on_device(gpu, grid.clone(), reach, &self.options)?;
        self.replace(samples, make)
    }

    /// Records what is to be done once the texture of a grid on the device was written again:
    /// the ranges of boxes are found anew. The work on the CPU is the same for grids of any
    /// size, so a grid may be made in every frame: record what writes it, this, and
    /// [`Draw::encode`], one behind the other.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the volume is not a grid on the device.
    pub fn refresh(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        match &self.style.volume.content {
            Content::Device { ranges, .. } => {
                self.canvas
                    .gpu()
                    .checked("slicing::ranges", 0, || ranges.record(encoder))
            }
            Content::Source { .. } => Err(Error::Invalid {
                what: "a volume to be found anew on the device, where it is not made".into(),
                help: Some("reload it; `Slicing::from_device` draws what is made there".into()),
            }),
        }
    }

    /// A renderer of the samples that `samples` has, with ranges that reach so far.
    fn with(
        gpu: &Gpu,
        appearance: &Appearance,
        options: &SlicingOptions,
        bounds: &Bounds,
        samples: impl FnOnce(usize) -> Result<Samples, Error>,
    ) -> Result<Slicing, Error> {
        ABILITIES.check(NAME, appearance, bounds)?;
        options.validate()?;
        let pass = SlicePass::new(gpu)?;
        let volume = Arc::new(samples(options.reach(appearance.optical_model))?);
        let parts = Parts {
            gpu,
            options,
            pass: &pass,
        };
        let style = parts.style(appearance, volume, None)?;
        let cull = style
            .cull
            .is_some()
            .then(|| CullPass::new(gpu, options.slicer));
        style.volume.find(gpu, |_| ())?;
        Ok(Slicing {
            cull: cull.transpose()?,
            canvas: Canvas::new(gpu)?,
            options: options.clone(),
            pass,
            style,
        })
    }

    /// Draws other samples from now on, which `make` records the writing of.
    fn replace(
        &mut self,
        samples: Samples,
        make: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let style = self
            .parts()
            .style(&self.style.appearance, Arc::new(samples), None)?;
        self.show(style, make)
    }

    /// Draws with another style from now on.
    fn show(
        &mut self,
        style: Style,
        make: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let gpu = self.canvas.gpu();
        let cull = match (&self.cull, &style.cull) {
            (None, Some(_)) => Some(CullPass::new(gpu, self.options.slicer)?),
            _ => None,
        };
        if !Arc::ptr_eq(&style.volume, &self.style.volume) {
            style.volume.find(gpu, make)?;
        }
        self.cull = cull.or(self.cull.take());
        self.style = style;
        Ok(())
    }

    fn parts(&self) -> Parts<'_> {
        Parts {
            gpu: self.canvas.gpu(),
            options: &self.options,
            pass: &self.pass,
        }
    }
}

impl VolumeRenderer for Slicing {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let appearance = &self.style.appearance;
        ABILITIES.check(NAME, appearance, &volume.bounds())?;
        let reach = self.options.reach(appearance.optical_model);
        let samples = Samples::of(self.canvas.gpu(), volume, reach, &self.options)?;
        self.replace(samples, |_| ())
    }

    /// Uploads the transfer function; samples only if they are floats and the range that
    /// matters moved so far that f32 would run out of digits, or if they are kept in bricks,
    /// or if the model needs more samples around each box than the one before.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let style = &self.style;
        ABILITIES.check(NAME, appearance, &style.volume.bounds())?;
        let reach = self.options.reach(appearance.optical_model);
        let before = (reach <= style.volume.reach).then_some(style);
        let volume = match before {
            Some(style) => style.volume.clone(),
            None => {
                let gpu = self.canvas.gpu();
                Arc::new(style.volume.reaching(gpu, reach, &self.options)?)
            }
        };
        let style = self.parts().style(appearance, volume, before)?;
        self.show(style, |_| ())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for Slicing {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// # Errors
    /// In a caller's encoder a volume that is streamed is [`Error::Unsupported`], as each of its
    /// batches must be submitted before the next is uploaded.
    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        self.record_frame(commands, view, target)
    }
}
