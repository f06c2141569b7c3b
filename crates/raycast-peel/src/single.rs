//! Every ray to its end in one dispatch: what is uploaded when, and what a frame records.

use std::time::Instant;

use tetrascope_core::glam::{DAffine3, DVec3};
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, OpticalModel, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::look::{look, look_constants};
use tetrascope_gpu::memory::{ReadBack, Source, texture_bytes};
use tetrascope_gpu::passes::{compute_pipeline, model_constant, module};
use tetrascope_gpu::preintegration::{self, Table, mean_chord};
use tetrascope_gpu::transfer_function::{Interval, intervals};
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration, ScalarMap, Timer, read_back, sides, timer};

use crate::NAME;
use crate::gpu_data::{Counters, March};
use crate::options::{Entries, RaycastOptions};
use crate::rays::Rays;
use crate::renderer::tetrahedra;
use crate::tiles::{TILE, Tiles};

/// What the shader writes for a ray that meets no surface: infinity is nothing to count on.
const NO_SURFACE: f32 = 3e38;

mod layers;
mod mesh;

use layers::{Layers, Peeling};
pub(crate) use mesh::{Mesh, TRANSPARENT_SCALAR, longest_edge};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub(crate) struct Single {
    gpu: Gpu,
    options: RaycastOptions,
    mesh: Mesh,
    style: Style,
    peeling: Option<Peeling>,
    timer: Option<Timer>,
}

/// Where a frame's rays cross the boundary.
enum Found {
    Lists(Tiles),
    /// And lists where rays may be in more layers.
    Layers(Layers, Option<Tiles>),
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

/// What `restyle` changes.
#[derive(Debug)]
struct Style {
    appearance: Appearance,
    pipeline: wgpu::ComputePipeline,
    intervals: wgpu::Texture,
    table: Table,
}

impl Style {
    fn new(
        gpu: &Gpu,
        mesh: &Mesh,
        appearance: &Appearance,
        options: &RaycastOptions,
        last: Option<&Table>,
    ) -> Result<Style, Error> {
        let intervals = intervals(
            &appearance.transfer_function,
            &mesh.scalar_map,
            &mesh.normalization,
        )?;
        let segments = Segments {
            mesh: &mesh.source,
            scale: mesh.normalization.scale,
            intervals: &intervals,
            longest: mesh.longest_edge,
            scalars: mapped_range(&mesh.source, &mesh.scalar_map),
        };
        let table = table(gpu, appearance, &segments, options, last)?;
        let mut constants = constants(gpu, mesh, appearance, &intervals, options)?;
        constants.extend(table.constants(segments.scalars));
        let pipeline = gpu.checked("raycast-peel::cast", 0, || {
            let label = "raycast-peel::cast";
            let program = module(gpu, label, tetrascope_shaders::raycast_peel::MARCH);
            compute_pipeline(gpu, label, &program, Some("cs_cast"), &constants, &[])
        })?;
        Ok(Style {
            appearance: appearance.clone(),
            pipeline,
            table,
            intervals: gpu.upload_texels(
                "of the transfer function",
                TextureFormat::Rgba32Float,
                &texels(&intervals),
            )?,
        })
    }
}

/// What a table is to hold.
pub(crate) struct Segments<'a> {
    pub(crate) mesh: &'a TetMesh,
    /// World units in a normalized unit.
    pub(crate) scale: f64,
    pub(crate) intervals: &'a [Interval],
    /// The longest that there can be, normalized.
    pub(crate) longest: f32,
    /// The least and the greatest scalar, mapped.
    pub(crate) scalars: (f32, f32),
}

/// The table that the options ask for: `last` if that is it.
pub(crate) fn table(
    gpu: &Gpu,
    appearance: &Appearance,
    segments: &Segments,
    options: &RaycastOptions,
    last: Option<&Table>,
) -> Result<Table, Error> {
    let model = appearance.optical_model;
    let integration = match model {
        OpticalModel::Isosurfaces => Integration::Exact,
        _ => options.integration,
    };
    if integration != Integration::Exact && appearance.depth_cue.is_some() {
        return Err(Error::Unsupported {
            renderer: NAME,
            what: "a depth cue with a table of integrals".into(),
            reason: "the cue differs from place to place, the table does not".into(),
        });
    }
    let fixed = || preintegration::Fixed {
        length: (mean_chord(segments.mesh) / segments.scale) as f32,
        scalars: segments.scalars,
    };
    let is_fixed = matches!(integration, Integration::TableFixed { .. });
    let source = preintegration::Source {
        integration,
        model,
        intervals: segments.intervals,
        longest: segments.longest,
        fixed: is_fixed.then(fixed),
    };
    match last {
        Some(last) => last.renewed(gpu, NAME, &source),
        None => Table::new(gpu, NAME, &source),
    }
}

/// The least and the greatest scalar, mapped.
pub(crate) fn mapped_range(mesh: &TetMesh, map: &ScalarMap) -> (f32, f32) {
    let (low, high) = mesh.scalar_range().unwrap_or((0.0, 0.0));
    (map.scalar(low), map.scalar(high))
}

/// The constant of `sides.wgsl`.
pub(crate) fn sides_constant(
    gpu: &Gpu,
    options: &RaycastOptions,
) -> Result<(&'static str, f64), Error> {
    match options.integer_sides {
        true => Ok(sides::integer_sides(true)),
        false => sides::constant(gpu),
    }
}

/// The constants of `march.wgsl`, but for its table's.
fn constants(
    gpu: &Gpu,
    mesh: &Mesh,
    appearance: &Appearance,
    intervals: &[Interval],
    options: &RaycastOptions,
) -> Result<Vec<(&'static str, f64)>, Error> {
    let per_cell = mesh.source.scalars().association == Association::Cell;
    let layered = options.entries == Entries::PeeledLayers;
    let [clipped, cued] = look_constants(appearance);
    Ok(vec![
        sides_constant(gpu, options)?,
        clipped,
        cued,
        model_constant(appearance.optical_model),
        ("INTERVAL_COUNT", intervals.len() as f64),
        ("DEEPEST", deepest(intervals, mesh.longest_edge)),
        ("SCALARS_PER_CELL", f64::from(u8::from(per_cell))),
        ("LAYERED", f64::from(u8::from(layered))),
    ])
}

/// Three texels an interval.
fn texels(intervals: &[Interval]) -> Vec<[f32; 4]> {
    let three = |i: &Interval| [i.at_low, i.at_high, [i.low, i.high, i.inverse_width, 0.0]];
    intervals.iter().flat_map(three).collect()
}

/// A bound of the optical depth of a cell; what only deeper ones need is not compiled.
pub(crate) fn deepest(intervals: &[Interval], longest_edge: f32) -> f64 {
    let extinctions = intervals.iter().flat_map(|i| [i.at_low[3], i.at_high[3]]);
    let greatest = f64::from(extinctions.fold(0.0, f32::max));
    // Lengths and depths are rounded on the way.
    (1.001 * greatest * f64::from(longest_edge)).min(1e30)
}

impl Single {
    /// A renderer of `volume`, which must be a mesh.
    ///
    /// # Errors
    /// A grid is unsupported; a mesh larger than the device's bindings is too large.
    pub(crate) fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<Single, Error> {
        let map = ScalarMap::of_appearance(appearance, volume.scalar_range());
        let mesh = Mesh::new(gpu, tetrahedra(volume)?, map, options.locality)?;
        Ok(Single {
            style: Style::new(gpu, &mesh, appearance, options, None)?,
            peeling: match options.entries {
                Entries::TileLists => None,
                Entries::PeeledLayers => Some(Peeling::new(gpu, sides_constant(gpu, options)?)?),
            },
            mesh,
            gpu: gpu.clone(),
            options: *options,
            timer: Timer::new(gpu)?,
        })
    }

    /// Bytes on the device between frames, the image not counted.
    pub(crate) fn bytes_resident(&self) -> u64 {
        let textures = self
            .mesh
            .textures()
            .into_iter()
            .chain([&self.style.intervals]);
        textures.map(texture_bytes).sum::<u64>() + self.style.table.bytes()
    }

    /// Records one frame into `image`, an Rgba32Float storage texture, and where there are
    /// isosurfaces into `depths`, R32Float; both as large as the view. The caller submits.
    /// What the frame did is in the buffer returned, once the commands have run.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        image: &wgpu::TextureView,
        depths: Option<&wgpu::TextureView>,
    ) -> Result<wgpu::Buffer, Error> {
        view.validate()?;
        if self.peeling.is_some() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "peeled layers into the caller's encoder".into(),
                reason: "the CPU reads between layers whether there are more".into(),
            });
        }
        let rays = Rays::new(view, &self.mesh.normalization);
        let found = Found::Lists(self.lists(view, &rays)?);
        self.encode_march(encoder, view, &rays, &found, (image, depths))
    }

    /// The boundary faces that the rays of each tile may meet.
    fn lists(&self, view: &View, rays: &Rays) -> Result<Tiles, Error> {
        Tiles::new(view, rays, &self.mesh.faces).ok_or_else(|| Error::TooLarge {
            what: "the boundary faces of all tiles".into(),
            needed: u64::from(u32::MAX) + 1,
            limit: u64::from(u32::MAX),
            unit: "pairs of tile and face",
        })
    }

    /// Where rays cross the boundary; layers are peeled here.
    fn find(&self, view: &View, rays: &Rays) -> Result<Found, Error> {
        let Some(peeling) = &self.peeling else {
            return Ok(Found::Lists(self.lists(view, rays)?));
        };
        let layers = peeling.peel(&self.gpu, view, rays, &self.mesh, &self.march(view, rays))?;
        let lists = layers.may_be_more.then(|| self.lists(view, rays));
        Ok(Found::Layers(layers, lists.transpose()?))
    }

    fn encode_march(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        rays: &Rays,
        found: &Found,
        (image, depths): (&wgpu::TextureView, Option<&wgpu::TextureView>),
    ) -> Result<wgpu::Buffer, Error> {
        // A texel that nobody writes, where no depths are wanted: bindings must be filled.
        let unused = match depths {
            Some(_) => None,
            None => Some(self.depths((1, 1))?.create_view(&Default::default())),
        };
        let Some(depths) = depths.or(unused.as_ref()) else {
            return Err(Error::invalid("no texture for depths"));
        };
        let mut march = self.march(view, rays);
        let (lists, layers) = match found {
            Found::Lists(lists) => (Some(lists), layers::none(&self.gpu)?),
            Found::Layers(layers, lists) => {
                march.layers = layers.count;
                if lists.is_some() {
                    march.listed_from = layers.count;
                }
                (lists.as_ref(), layers.view())
            }
        };
        let uniform = self
            .gpu
            .upload("raycast-peel::march", &[march], BufferUsages::UNIFORM)?;
        let storage = BufferUsages::STORAGE;
        let faces = self.gpu.upload(
            "raycast-peel::tile_faces",
            lists.map_or(&[][..], |tiles| &tiles.lists),
            storage,
        )?;
        let (look, items) = look(
            &self.style.appearance,
            view,
            &self.mesh.source.bounds(),
            &self.mesh.normalization,
            &self.mesh.scalar_map,
            &DAffine3::IDENTITY,
        );
        let look = self
            .gpu
            .upload("raycast-peel::look", &[look], BufferUsages::UNIFORM)?;
        let items = self
            .gpu
            .upload("raycast-peel::look_items", &items, storage)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let counters = self
            .gpu
            .upload("raycast-peel::counters", &[Counters::default()], usage)?;
        let Style {
            pipeline,
            intervals,
            table,
            ..
        } = &self.style;
        let group = |index: u32, resources: &[wgpu::BindingResource]| {
            let entries: Vec<wgpu::BindGroupEntry> = (0..)
                .zip(resources)
                .map(|(binding, resource)| wgpu::BindGroupEntry {
                    binding,
                    resource: resource.clone(),
                })
                .collect();
            self.gpu
                .device()
                .create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("raycast-peel::cast"),
                    layout: &pipeline.get_bind_group_layout(index),
                    entries: &entries,
                })
        };
        let views = self.mesh.textures().map(view_of);
        let volume = views.each_ref().map(wgpu::BindingResource::TextureView);
        let intervals = view_of(intervals);
        self.gpu.checked("raycast-peel::cast", 0, || {
            let frame = [
                uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(image),
                counters.as_entire_binding(),
                faces.as_entire_binding(),
                wgpu::BindingResource::TextureView(depths),
                look.as_entire_binding(),
                items.as_entire_binding(),
                wgpu::BindingResource::TextureView(&layers),
            ];
            let groups = [
                group(0, &frame),
                group(1, &volume),
                group(
                    2,
                    &[
                        wgpu::BindingResource::TextureView(&intervals),
                        table.binding(),
                    ],
                ),
            ];
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("raycast-peel::cast"),
                timestamp_writes: self.timer.as_ref().map(Timer::only_compute_pass),
            });
            pass.set_pipeline(pipeline);
            for (index, group) in (0..).zip(&groups) {
                pass.set_bind_group(index, group, &[]);
            }
            pass.dispatch_workgroups(view.width.div_ceil(TILE), view.height.div_ceil(TILE), 1);
        })?;
        Ok(counters)
    }

    /// A texture for depths.
    fn depths(&self, size: (u32, u32)) -> Result<wgpu::Texture, Error> {
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let label = "raycast-peel::depths";
        self.gpu
            .texture(label, size, TextureFormat::R32Float, usage)
    }

    fn march(&self, view: &View, rays: &Rays) -> March {
        let extended = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        March {
            anchor: extended(rays.anchor, 0.0),
            anchor_x: extended(rays.anchor_x, 0.0),
            anchor_y: extended(rays.anchor_y, 0.0),
            eye: extended(rays.eye, if rays.is_point { 1.0 } else { 0.0 }),
            background: view.premultiplied_background().map(|c| c as f32),
            eye_depth: rays.eye_depth as f32,
            width: view.width,
            height: view.height,
            tiles_x: view.width.div_ceil(TILE),
            stop_depth: self.options.stop_depth(),
            scale: self.mesh.normalization.scale as f32,
            layers: 0,
            listed_from: u32::MAX,
        }
    }
}

impl VolumeRenderer for Single {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let source = tetrahedra(volume)?;
        let (gpu, old) = (&self.gpu, &self.mesh);
        let appearance = &self.style.appearance;
        let range = source.scalar_range();
        let same_kind = source.scalars().association == old.source.scalars().association;
        let same_geometry = source.shares_geometry(&old.source) && same_kind;
        let keeps_map = same_geometry && old.scalar_map.suits_appearance(appearance, range);
        let map = match keeps_map {
            true => old.scalar_map,
            false => ScalarMap::of_appearance(appearance, range),
        };
        let mesh = match same_geometry {
            true => old.with_scalars(gpu, source, map)?,
            false => Mesh::new(gpu, source, map, self.options.locality)?,
        };
        // A table's program knows whether scalars leave it.
        if !keeps_map || self.options.integration != Integration::Exact {
            let table = Some(&self.style.table);
            self.style = Style::new(gpu, &mesh, appearance, &self.options, table)?;
        }
        self.mesh = mesh;
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let (gpu, old) = (&self.gpu, &self.mesh);
        let range = old.source.scalar_range();
        let mesh = match old.scalar_map.suits_appearance(appearance, range) {
            true => None,
            false => {
                let map = ScalarMap::of_appearance(appearance, range);
                Some(old.with_scalars(gpu, &old.source, map)?)
            }
        };
        let drawn = mesh.as_ref().unwrap_or(old);
        let table = Some(&self.style.table);
        self.style = Style::new(gpu, drawn, appearance, &self.options, table)?;
        if let Some(mesh) = mesh {
            self.mesh = mesh;
        }
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        view.validate()?;
        let start = Instant::now();
        let image = self.gpu.texture(
            "raycast-peel::image",
            (view.width, view.height),
            TextureFormat::Rgba32Float,
            TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC,
        )?;
        let mut encoder = self
            .gpu
            .device()
            .create_command_encoder(&Default::default());
        let has_depths = self.style.appearance.optical_model == OpticalModel::Isosurfaces;
        let depths = has_depths
            .then(|| self.depths((view.width, view.height)))
            .transpose()?;
        let depths_view = depths.as_ref().map(|d| d.create_view(&Default::default()));
        let image_view = image.create_view(&Default::default());
        let rays = Rays::new(view, &self.mesh.normalization);
        let found = self.find(view, &rays)?;
        let targets = (&image_view, depths_view.as_ref());
        let counters = self.encode_march(&mut encoder, view, &rays, &found, targets)?;
        let gpu = &self.gpu;
        let depths = depths
            .as_ref()
            .map(|texture| read_back(gpu, &mut encoder, Source::Texture(texture)))
            .transpose()?;
        let pixels = read_back(gpu, &mut encoder, Source::Texture(&image))?;
        let counters = read_back(
            gpu,
            &mut encoder,
            Source::Buffer(&counters, size_of::<Counters>() as u64),
        )?;
        // Layers were peeled before the timer began.
        let timer = self.timer.as_ref().filter(|_| self.peeling.is_none());
        let times = timer
            .map(|timer| timer.resolve(gpu, &mut encoder))
            .transpose()?;
        let submitted = Instant::now();
        gpu.finish(encoder)?;
        let waited = submitted.elapsed();
        let pixels: Vec<[f32; 4]> = pixels.read()?;
        let mut stats = FrameStats::default();
        count(&mut stats, counters)?;
        stats.passes = 1;
        if let Found::Layers(layers, _) = &found {
            stats.passes += layers.passes;
            stats.layers = Some(layers.full);
        }
        stats.bytes_resident = self.bytes_resident();
        if self.peeling.is_none() {
            stats.gpu_seconds = timer::seconds(gpu, times, waited)?;
        }
        stats.cpu_seconds = start.elapsed().as_secs_f64();
        let mut frame = Frame::new((view.width, view.height), pixels, stats);
        if let Some(depths) = depths {
            let mut depths: Vec<f32> = depths.read()?;
            for depth in depths.iter_mut().filter(|depth| **depth >= NO_SURFACE) {
                *depth = f32::INFINITY;
            }
            frame.depths = Some(depths);
        }
        Ok(frame)
    }
}

fn count(stats: &mut FrameStats, counters: ReadBack) -> Result<(), Error> {
    let counters: Vec<Counters> = counters.read()?;
    let [counters] = counters[..] else {
        return Err(Error::Device {
            reason: "the counters did not come back".into(),
        });
    };
    let high = u64::from(counters.cell_visits_high) << 32;
    stats.cell_visits = Some(high | u64::from(counters.cell_visits_low));
    stats.paths = Some(counters.paths.into());
    stats.unpaired_faces = Some(counters.unpaired_faces.into());
    stats.lost_rays = Some(counters.lost_rays.into());
    Ok(())
}

#[cfg(test)]
mod aimed;
