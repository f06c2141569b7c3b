//! Stacks of textured rectangles, with which a regular grid is drawn (section 4).
//!
//! "Treat each plane of the volume as a 2D texture and then … apply the texture to a rectangle." The
//! rectangles lie in the planes of samples and are blended back to front. Seen from their edges they
//! are nothing, so a grid has three stacks, one for each of its axes, and a frame takes the one whose
//! axis is most nearly along the optical axis.
//!
//! 1. `volume` copies the grid's samples into three arrays of textures, on the device (`turn.wgsl`).
//! 2. `frame` chooses the stack, and has the camera in it and the order of rectangles.
//! 3. `style` has what an appearance needs.
//! 4. `layer.wgsl` interpolates in a layer, `rectangle.wgsl` says what a rectangle adds to a pixel.
//!
//! # Departures from the paper
//! - *A rectangle stands for the slab up to the next one* ([`Integration::Slabs`], the default): a ray
//!   has a scalar where it enters the slab and one where it leaves it, and what is between them is
//!   integrated. So there are no bands, and slabs end exactly where the box of samples does, at clip
//!   planes and at what an application has drawn. [`Integration::Slices`] is the published form.
//! - *Opacities are those of lengths along the ray*, 1 − exp(−τ). The paper does not say how opacities
//!   of planes depend on their distance. In [`Integration::Slices`] the first and the last plane stand
//!   for half of it, as samples end there, and no plane stands for more than the ray's length in the
//!   box.
//! - *Colors come after interpolation*, from the transfer function in each fragment.
//! - *Interpolation is in f32*, by four loads; texture units may have fractions of 8 bits.
//! - *A fragment decides whether its ray meets a rectangle*. What is rasterized is the part of the
//!   image around it, so that no pixel depends on how rasterizers round.
//! - *Rectangles behind the eye are drawn, too*, as rays beside the optical axis may go backward
//!   through the stack.
//!
//! # Limits
//! - The three stacks take three times the bytes of the grid, beside it. All are made with the grid:
//!   one made for a view would be in the commands of that frame, which an application may drop.
//! - No more samples along an axis than the device has layers in a texture: 256 at least, often 2048.
//! - Between two planes the scalar is taken to be linear along the ray, or the sample's own. A ray
//!   that is oblique to the planes passes several cells there: up to one along each of the other axes
//!   where rays are parallel and samples are equally far apart, more where they are nearer along these
//!   axes, or in perspective far from the optical axis. Frames in which rays pass more than eight cells
//!   say so. A wide view from inside of smooth waves, with rays along the planes, was off by 6e-3 of
//!   white (RMSE) with slabs and by 0.03 to 0.06 with slices, which such rays meet by chance.
//! - In [`Integration::Slices`] where a ray enters or leaves through another side of the box is known
//!   to the distance of two planes.
//! - No isosurfaces: they lie between planes. Greatest colors are those at planes, or linear between
//!   them; with coverage they end at the cells that planes meet.

mod frame;
mod style;
#[cfg(test)]
mod tests;
mod volume;

use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::{
    Abilities, Appearance, Error, Frame, FrameStats, View, Volume, VolumeRenderer,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{ImagePlane, Normalization};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::gather::gathered_format;
use tetrascope_gpu::passes::group;
use tetrascope_gpu::transfer_function::check_knots;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Canvas, Commands, DeviceGrid, Draw, Gpu, Recorded, SumsKind, Target, draw};

use self::frame::{CameraUniform, Stacked};
use self::style::{Layouts, Style};
use self::volume::Layers;
use crate::NAME;

const LABEL: &str = "voxel-hw::stacks";

/// How a stack is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct StacksOptions {
    /// The quantity that a rectangle adds to a pixel.
    pub integration: Integration,
}

/// The quantity that a rectangle adds to a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integration {
    /// As published (section 4): the color and extinction of the sample in its plane, for as long as
    /// planes are apart along the ray. Converges at first order in the distance of samples, where a
    /// ray enters and leaves the box through its planes at second.
    Slices,
    /// The integral between its plane and the next one, in which the scalar goes linearly from one
    /// to the other. Converges at second order.
    #[default]
    Slabs,
}

tetrascope_core::choices! {
    Integration: "slices" = Slices, "slabs" = Slabs;
}

/// Draws a grid on the device by one of three stacks of textured rectangles (section 4), in every
/// optical model but isosurfaces.
///
/// The work on the CPU does not depend on how many samples there are, and none is read back.
///
/// ```no_run
/// use tetrascope_core::{Appearance, Error, View};
/// use tetrascope_gpu::{DeviceGrid, Draw as _, Gpu, Target, wgpu};
/// use tetrascope_voxel_hw::{Stacks, StacksOptions};
///
/// # fn record_yours(_: &mut wgpu::CommandEncoder, _: &wgpu::Texture) {}
/// /// Frames of a grid that a compute pass writes anew for each.
/// fn frames(
///     gpu: &Gpu,
///     grid: &DeviceGrid,
///     appearance: &Appearance,
///     views: &[View],
///     target: &Target,
/// ) -> Result<(), Error> {
///     let stacks = Stacks::from_device(gpu, grid, appearance, &StacksOptions::default())?;
///     for view in views {
///         let mut encoder = gpu.device().create_command_encoder(&Default::default());
///         record_yours(&mut encoder, grid.texture());
///         stacks.refresh(&mut encoder)?;
///         // The application submits; the statistics, which wait for that, are left alone.
///         let _ = stacks.encode(&mut encoder, view, target)?;
///         gpu.queue().submit([encoder.finish()]);
///     }
///     Ok(())
/// }
/// ```
#[derive(Debug)]
pub struct Stacks {
    canvas: Canvas,
    options: StacksOptions,
    layouts: Layouts,
    layers: Layers,
    style: Style,
}

impl Stacks {
    /// The parts of an appearance that are drawn.
    pub const ABILITIES: Abilities = Abilities {
        isosurfaces: false,
        ..Abilities::ALL
    };

    /// Copies the samples of `grid` into stacks and compiles what `appearance` needs.
    ///
    /// The commands that copy are submitted behind those that were submitted before; nothing waits
    /// for them.
    ///
    /// # Errors
    /// Refusals of [`Stacks::supports`] that do not depend on the view; [`Error::TooLarge`] for more samples
    /// along an axis than the device has layers, and [`Error::OutOfMemory`].
    pub fn from_device(
        gpu: &Gpu,
        grid: &DeviceGrid,
        appearance: &Appearance,
        options: &StacksOptions,
    ) -> Result<Stacks, Error> {
        check(grid.lattice(), grid.texels(), appearance)?;
        let layouts = Layouts::new(gpu)?;
        let layers = Layers::new(gpu, grid, None)?;
        let style = Style::new(gpu, &layouts, &layers, appearance, options)?;
        layers.submit(gpu, |_| ())?;
        Ok(Stacks {
            canvas: Canvas::new(gpu)?,
            options: *options,
            layouts,
            layers,
            style,
        })
    }

    /// Draws another grid from now on, which the commands that `made` records write; they are
    /// submitted once nothing else can fail, and those that copy the samples behind them. So the
    /// grid may have the texture of the one before. Stacks of as many samples are used again.
    ///
    /// # Errors
    /// As [`Stacks::from_device`]; what was drawn before is kept then.
    pub fn reload_made(
        &mut self,
        grid: &DeviceGrid,
        made: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let appearance = &self.style.appearance;
        check(grid.lattice(), grid.texels(), appearance)?;
        let gpu = self.canvas.gpu();
        if self.layers.are_of(grid) {
            return self.layers.submit(gpu, made);
        }
        let layers = Layers::new(gpu, grid, Some(&self.layers))?;
        let style = Style::new(gpu, &self.layouts, &layers, appearance, &self.options)?;
        layers.submit(gpu, made)?;
        (self.layers, self.style) = (layers, style);
        Ok(())
    }

    /// Records what is to be done once the texture of the grid was written again: its samples are
    /// copied anew. So a grid may be made in every frame: record what writes it, this, and
    /// [`Draw::encode`], one behind the other.
    ///
    /// # Errors
    /// Refusals of the device.
    pub fn refresh(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        let gpu = self.canvas.gpu();
        gpu.checked(LABEL, 0, || self.layers.record(encoder))
    }

    /// Whether [`Stacks::from_device`] would draw such a grid, as far as that can be said without a
    /// device.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for samples that fill cells, gaps and isosurfaces; an appearance or a
    /// view that is not valid, and too many knots.
    pub fn supports(
        lattice: &Lattice,
        texels: Texels,
        appearance: &Appearance,
        view: &View,
        options: &StacksOptions,
    ) -> Result<(), Error> {
        // Both ways of integration draw the same grids.
        let StacksOptions { integration: _ } = options;
        check(lattice, texels, appearance)?;
        view.validate()
    }

    fn format(&self) -> TextureFormat {
        gathered_format(self.canvas.gpu(), self.style.appearance.optical_model)
    }

    fn stats(&self) -> FrameStats {
        let mut stats = FrameStats::default();
        stats.bytes_resident = self.layers.bytes() + self.style.bytes();
        stats.order_proven = Some(true);
        if matches!(
            self.format(),
            TextureFormat::R16Float | TextureFormat::Rgba16Float
        ) {
            let note = "this device does not blend f32, so rectangles add up in f16, and thin ones \
                        may be lost";
            stats.notes.push(note.into());
        }
        stats
    }

    /// The uniform of a frame, and which stack it is for.
    fn stacked(&self, view: &View, plane: &ImagePlane) -> Stacked {
        let (base, unit) = self.style.scale;
        let is_slabs = self.options.integration == Integration::Slabs;
        let Layers {
            grid,
            normalization,
            ..
        } = &self.layers;
        Stacked::new(view, plane, grid.lattice(), normalization, is_slabs).with_scale(base, unit)
    }

    fn draw_rectangles(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::BindGroup,
        pipeline: &wgpu::RenderPipeline,
        sums: &wgpu::Texture,
        stacked: &Stacked,
    ) {
        let sums = sums.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(LABEL),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &sums,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, &self.style.volumes[stacked.axis], &[]);
        pass.draw(0..6, 0..stacked.uniform.rectangle_count as u32);
    }
}

/// Refuses what is not drawn like this, whatever the view.
fn check(lattice: &Lattice, texels: Texels, appearance: &Appearance) -> Result<(), Error> {
    Stacks::ABILITIES
        .check(NAME, appearance, &lattice.bounds())
        .map_err(|error| match error {
            Error::Unsupported { renderer, what, .. } => Error::Unsupported {
                renderer,
                what: format!("{what} by stacks of rectangles"),
                reason: "they lie between the planes of samples".into(),
            },
            other => other,
        })?;
    check_knots(&appearance.transfer_function)?;
    lattice.validate()?;
    let refused = match (lattice.interpolation, texels) {
        (Interpolation::Nearest, _) => (
            "samples that fill cells, in stacks of rectangles",
            "its planes go through samples, between which it interpolates",
        ),
        (_, Texels::Gaps) => (
            "samples without a value, in stacks of rectangles",
            "planes do not know the cells between them; give those samples a coverage of 0",
        ),
        (_, Texels::Values | Texels::Covered) => return Ok(()),
    };
    let (what, reason) = refused;
    Err(Error::Unsupported {
        renderer: NAME,
        what: what.into(),
        reason: reason.into(),
    })
}

impl VolumeRenderer for Stacks {
    /// Uploads a regular grid; [`Error::Unsupported`] for anything else.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let Volume::Grid(grid) = volume else {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "what is not a regular grid in memory, in stacks of rectangles".into(),
                reason: "they show samples on the device".into(),
            });
        };
        // Refused before the work.
        let texels = match grid.coverage() {
            Some(_) => Texels::Covered,
            None => Texels::Values,
        };
        check(grid.lattice(), texels, &self.style.appearance)?;
        let uploaded = DeviceGrid::upload(self.canvas.gpu(), grid)?;
        self.reload_made(&uploaded, |_| ())
    }

    /// Uploads the transfer function; samples stay as they are.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let Layers { grid, .. } = &self.layers;
        check(grid.lattice(), grid.texels(), appearance)?;
        let gpu = self.canvas.gpu();
        self.style = Style::new(gpu, &self.layouts, &self.layers, appearance, &self.options)?;
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for Stacks {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        let (gpu, encoder) = (self.canvas.gpu(), commands.encoder());
        let mut stats = self.stats();
        if self.style.is_transparent {
            stats.passes = self.canvas.put_nothing(encoder, view, target)?;
            return Ok(Recorded::new(stats));
        }
        let normalization: &Normalization = &self.layers.normalization;
        let appearance = &self.style.appearance;
        let plane = ImagePlane::new(view, normalization);
        let stacked = self.stacked(view, &plane);
        stats.notes.extend(stacked.note());
        let bounds = self.layers.grid.lattice().bounds();
        let space = plane.camera_from_normalized();
        let map = &self.style.map;
        let (look, _) = look(appearance, view, &bounds, normalization, map, &space);
        let (anchor, depth) = (plane.anchor_depth, target.depth.as_ref());
        let (ends, has_ends) = self
            .canvas
            .ends(encoder, view, normalization, anchor, depth)?;
        let uniform = [stacked.uniform];
        let uniform = gpu.upload::<CameraUniform>(LABEL, &uniform, BufferUsages::UNIFORM)?;
        let look = gpu.upload(LABEL, &[look], BufferUsages::UNIFORM)?;
        let pipeline = self.style.pipeline(gpu, has_ends)?;
        let model = appearance.optical_model;
        let kind = SumsKind {
            format: self.format(),
            usage: TextureUsages::RENDER_ATTACHMENT,
            distances: false,
        };
        let sums = self.canvas.sums(view, kind)?;
        gpu.checked(LABEL, 0, || {
            let resources = [
                uniform.as_entire_binding(),
                look.as_entire_binding(),
                wgpu::BindingResource::TextureView(&ends),
            ];
            let frame = group(gpu, LABEL, &self.layouts.frame, &resources);
            self.draw_rectangles(encoder, &frame, &pipeline, &sums.color, &stacked);
        })?;
        self.canvas
            .put(encoder, view, normalization, (model, &sums), target)?;
        stats.passes = 2;
        Ok(Recorded::new(stats))
    }
}
