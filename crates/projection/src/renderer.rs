//! The renderer: what lasts, and how a frame is recorded.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, OpticalModel, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::gather::{Resolve, ResolvePass, gathered_format};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, ScalarMap, Timer, read_back, timer};

use crate::frame::frame;
use crate::options::{Order, ProjectionOptions};
use crate::passes::cell::{CellData, CellPass};
use crate::passes::order::{OrderData, OrderPass};
use crate::volume::{Field, Geometry, Look, mesh_of};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct Projection {
    gpu: Gpu,
    options: ProjectionOptions,
    cell_pass: CellPass,
    /// Compiled when a model first needs it.
    order_pass: Option<OrderPass>,
    scene: Scene,
    /// The texture of the last frame, for the next of the same size.
    gathered: Mutex<Option<wgpu::Texture>>,
}

/// All that `reload` and `restyle` replace, at once or not at all.
#[derive(Debug)]
struct Scene {
    appearance: Appearance,
    geometry: Geometry,
    field: Field,
    look: Look,
    order: Option<OrderData>,
    cell: CellData,
    /// Into the caller's format, and into the one that `render` reads back.
    resolve: [ResolvePass; 2],
}

/// Where a frame is drawn, an index of [`Scene::resolve`].
#[derive(Clone, Copy)]
enum To {
    Caller,
    ReadBack,
}

/// What `render` reads back.
const READ_BACK_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

impl Projection {
    /// Uploads the mesh in `volume` and compiles what `appearance` needs.
    ///
    /// [`Error::Unsupported`] for a grid, [`Error::TooLarge`] and
    /// [`Error::OutOfMemory`] if the device does not hold the mesh.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &ProjectionOptions,
    ) -> Result<Projection, Error> {
        let mesh = mesh_of(volume)?;
        let cell_pass = CellPass::new(gpu)?;
        let sorted = sorts(options, appearance.optical_model);
        let order_pass = sorted.then(|| OrderPass::new(gpu)).transpose()?;
        let geometry = Geometry::upload(gpu, mesh)?;
        let map = ScalarMap::of(&appearance.transfer_function);
        let field = Field::upload(gpu, mesh, map)?;
        let parts = Parts {
            gpu,
            options,
            cell_pass: &cell_pass,
            order_pass: order_pass.as_ref(),
        };
        let scene = parts.scene(appearance, geometry, field)?;
        Ok(Projection {
            gpu: gpu.clone(),
            options: options.clone(),
            cell_pass,
            order_pass,
            scene,
            gathered: Mutex::new(None),
        })
    }

    /// Records a frame into `target`, a view of a texture of the view's size and of
    /// [`ProjectionOptions::target_format`]; the caller submits.
    ///
    /// Every texel is written: linear premultiplied RGBA, over the view's background.
    /// Times and readback are for [`VolumeRenderer::render`]: the stats returned have
    /// the counts alone.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        target: &wgpu::TextureView,
    ) -> Result<FrameStats, Error> {
        self.record(encoder, view, target, To::Caller, None)
    }

    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        target: &wgpu::TextureView,
        to: To,
        timer: Option<&Timer>,
    ) -> Result<FrameStats, Error> {
        view.validate()?;
        let (gpu, scene) = (&self.gpu, &self.scene);
        let (normalization, field) = (&scene.geometry.normalization, &scene.field);
        let count = scene.look.drawn_count;
        let uniform = frame(view, normalization, count, field.per_cell);
        // New buffers each time: frames may be recorded before others are submitted.
        let uniform = gpu.upload("projection::frame", &[uniform], BufferUsages::UNIFORM)?;
        let background = [Resolve::of(view)];
        let background = gpu.upload("projection::resolve", &background, BufferUsages::UNIFORM)?;
        let gathered = self.gathered((view.width, view.height))?;
        let gathered = gathered.create_view(&Default::default());
        let mut stats = self.stats();
        gpu.checked("projection::encode", 0, || {
            let mut first = timer;
            if let (Some(pass), Some(data)) = (&self.order_pass, &scene.order) {
                let times = first.take().map(Timer::first_compute_pass);
                pass.record(gpu, encoder, &uniform, data, times);
                stats.passes += 1;
            }
            let times = first.take().map(Timer::first_render_pass);
            let cell = &self.cell_pass;
            cell.record(gpu, encoder, &uniform, &scene.cell, &gathered, times);
            let times = timer.map(Timer::last_render_pass);
            let resolve = &scene.resolve[to as usize];
            resolve.record(gpu, encoder, &background, &gathered, target, times);
            stats.passes += 2;
        })?;
        Ok(stats)
    }

    /// The texture in which cells add up, kept for the next frame.
    fn gathered(&self, size: (u32, u32)) -> Result<wgpu::Texture, Error> {
        let format = gathered_format(&self.gpu, self.scene.appearance.optical_model);
        let mut kept = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |t: &&wgpu::Texture| (t.width(), t.height()) == size && t.format() == format;
        if let Some(texture) = kept.as_ref().filter(fits) {
            return Ok(texture.clone());
        }
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let texture = self.gpu.texture("of sums", size, format, usage)?;
        *kept = Some(texture.clone());
        Ok(texture)
    }

    fn stats(&self) -> FrameStats {
        let scene = &self.scene;
        let (geometry, look) = (&scene.geometry, &scene.look);
        let buffers = [
            &geometry.positions,
            &geometry.cells,
            &scene.field.scalars,
            &look.intervals,
            &look.drawn,
        ];
        let order_bytes = scene.order.as_ref().map_or(0, OrderData::bytes);
        let drawn = u64::from(look.drawn_count);
        let mut stats = FrameStats::default();
        stats.cells_drawn = Some(drawn);
        stats.cells_skipped = Some(geometry.mesh.cell_count() as u64 - drawn);
        stats.cells_sorted = Some(if scene.order.is_some() { drawn } else { 0 });
        stats.bytes_resident = order_bytes + buffers.iter().map(|b| b.size()).sum::<u64>();
        let format = gathered_format(&self.gpu, scene.appearance.optical_model);
        if matches!(format, TextureFormat::R16Float | TextureFormat::Rgba16Float) {
            let note = "this device does not blend f32, so cells add up in f16";
            stats.notes.push(note.into());
        }
        stats
    }

    fn parts(&self) -> Parts<'_> {
        Parts {
            gpu: &self.gpu,
            options: &self.options,
            cell_pass: &self.cell_pass,
            order_pass: self.order_pass.as_ref(),
        }
    }

    fn reload_mesh(&mut self, mesh: &TetMesh) -> Result<(), Error> {
        let old = &self.scene.geometry;
        let geometry = if old.mesh.shares_geometry(mesh) {
            Geometry {
                mesh: mesh.clone(),
                ..old.clone()
            }
        } else {
            Geometry::upload(&self.gpu, mesh)?
        };
        let field = Field::upload(&self.gpu, mesh, self.scene.field.map)?;
        let appearance = &self.scene.appearance;
        self.scene = self.parts().scene(appearance, geometry, field)?;
        Ok(())
    }
}

impl VolumeRenderer for Projection {
    /// Uploads scalars alone where the geometry is the same.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        self.reload_mesh(mesh_of(volume)?)
    }

    /// Uploads the transfer function and which cells it leaves to draw; scalars only
    /// if its range moved so far that f32 would run out of digits.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        if self.order_pass.is_none() && sorts(&self.options, appearance.optical_model) {
            self.order_pass = Some(OrderPass::new(&self.gpu)?);
        }
        let tf = &appearance.transfer_function;
        let geometry = self.scene.geometry.clone();
        let field = if self.scene.field.map.suits(tf) {
            self.scene.field.clone()
        } else {
            Field::upload(&self.gpu, &geometry.mesh, ScalarMap::of(tf))?
        };
        self.scene = self.parts().scene(appearance, geometry, field)?;
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        let start = Instant::now();
        view.validate()?;
        let gpu = &self.gpu;
        let size = (view.width, view.height);
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = gpu.texture("to read back", size, READ_BACK_FORMAT, usage)?;
        let timer = Timer::new(gpu)?;
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let target_view = target.create_view(&Default::default());
        let mut stats = self.record(
            &mut encoder,
            view,
            &target_view,
            To::ReadBack,
            timer.as_ref(),
        )?;
        let pixels = read_back(gpu, &mut encoder, Source::Texture(&target))?;
        let times = timer.map(|t| t.resolve(gpu, &mut encoder)).transpose()?;
        gpu.finish(encoder)?;
        let pixels = pixels.read()?;
        if let Some(times) = times {
            stats.gpu_seconds = timer::seconds(gpu, times)?;
        }
        stats.cpu_seconds = start.elapsed().as_secs_f64();
        Ok(Frame {
            width: view.width,
            height: view.height,
            pixels,
            stats,
        })
    }
}

/// What a [`Scene`] is made with.
struct Parts<'a> {
    gpu: &'a Gpu,
    options: &'a ProjectionOptions,
    cell_pass: &'a CellPass,
    order_pass: Option<&'a OrderPass>,
}

impl Parts<'_> {
    fn scene(
        &self,
        appearance: &Appearance,
        geometry: Geometry,
        field: Field,
    ) -> Result<Scene, Error> {
        let gpu = self.gpu;
        let model = appearance.optical_model;
        let look = Look::upload(gpu, &geometry, &field.map, appearance)?;
        let order = match self.order_pass {
            Some(pass) if sorts(self.options, model) => {
                Some(pass.data(gpu, &geometry, &field.scalars, &look)?)
            }
            _ => None,
        };
        let drawn = order.as_ref().map_or(&look.drawn, OrderData::sorted);
        let cell = self
            .cell_pass
            .data(gpu, &geometry, &field, &look, drawn, model)?;
        let format = self.options.target_format;
        let resolve = ResolvePass::new(gpu, model, format)?;
        let resolve_read_back = if format == READ_BACK_FORMAT {
            resolve.clone()
        } else {
            ResolvePass::new(gpu, model, READ_BACK_FORMAT)?
        };
        Ok(Scene {
            appearance: appearance.clone(),
            geometry,
            field,
            look,
            order,
            cell,
            resolve: [resolve, resolve_read_back],
        })
    }
}

/// Whether cells are sorted for this model.
fn sorts(options: &ProjectionOptions, model: OpticalModel) -> bool {
    options.order == Order::Centroid && !model.commutes()
}
