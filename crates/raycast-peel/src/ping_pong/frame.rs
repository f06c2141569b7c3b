//! One frame: layers of the boundary, rounds of steps, and when to end.

use tetrascope_core::glam::{DVec3, DVec4};
use tetrascope_core::{Error, FrameStats, OpticalModel, Projection, View};
use tetrascope_f32::tiles::rectangles;
use tetrascope_f32::{ImagePlane, Rays, say_if_flat};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::passes::group;
use tetrascope_gpu::wgpu::{
    self, BindGroup, BindingResource, BufferUsages, Color, LoadOp, TextureUsages, TextureView,
};
use tetrascope_gpu::{Canvas, Commands, Gpu, Recorded, Sums, Target, read_back};

use super::PingPong;
use super::gpu_data::{CameraUniform, TILES, Tally};
use super::mesh::Boundary;
use super::passes::{BEFORE, DEPTHS, TEXELS, record_clear};
use super::tiles::{Tile, tiles};
use crate::NAME;
use crate::counters::{
    FRAGMENTS, LAYERS, LEAST_TILE_PASSES, LOST_RAYS, MOST_TILE_PASSES, TILES_DRAWN, TILES_SKIPPED,
};
use crate::options::Crossings;

/// Textures as large as the image, which live as long as a frame.
struct Targets {
    /// Figure 9: cell, λ and scalar; written in turn.
    states: [TextureView; 2],
    /// Figure 9: color and opacity; written in turn.
    colors: [wgpu::Texture; 2],
    /// Figure 6: where rays come in, layer after layer in turn.
    layers: [TextureView; 2],
    /// Depths of the boundary's faces.
    depths: TextureView,
    /// 0 for idle rays, 1 for the others.
    retired: TextureView,
}

impl Targets {
    fn new(gpu: &Gpu, size: (u32, u32)) -> Result<Targets, Error> {
        let make = |label, format, more| {
            let usage = TextureUsages::RENDER_ATTACHMENT | more;
            gpu.texture(label, size, format, usage)
        };
        let view = |label, format, more| {
            make(label, format, more).map(|t| t.create_view(&Default::default()))
        };
        let texels = |label| view(label, TEXELS, TextureUsages::TEXTURE_BINDING);
        let color = || make("ping-pong::color", TEXELS, TextureUsages::TEXTURE_BINDING);
        let depths = |label| view(label, DEPTHS, TextureUsages::empty());
        Ok(Targets {
            states: [texels("ping-pong::state")?, texels("ping-pong::state")?],
            colors: [color()?, color()?],
            layers: [texels("ping-pong::layer")?, texels("ping-pong::layer")?],
            depths: depths("ping-pong::depths")?,
            retired: depths("ping-pong::retired")?,
        })
    }
}

fn view_of(texture: &wgpu::Texture) -> TextureView {
    texture.create_view(&Default::default())
}

/// A frame while it is drawn.
struct Drawing<'a> {
    renderer: &'a PingPong,
    size: (u32, u32),
    targets: Targets,
    frame: BindGroup,
    mesh: BindGroup,
    integration: BindGroup,
    /// Rectangles of boundary faces, where rays cross by sides.
    rectangles: Option<wgpu::Buffer>,
    queries: wgpu::QuerySet,
    answers: wgpu::Buffer,
    /// Which of `states` and `colors` was written last.
    written: usize,
    /// Steps that each tile took, by its index.
    steps: [u64; TILES],
    lost_rays: u64,
    stats: FrameStats,
}

impl PingPong {
    /// Draws one frame. Submits once per layer and once every `query_interval` steps.
    pub(crate) fn record(
        &self,
        canvas: &Canvas,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        if !commands.may_submit() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "one step per pass into the caller's encoder".into(),
                reason: "the CPU reads between passes whether rays are left".into(),
            });
        }
        let all = tiles(self.options.tiles, (view.width, view.height));
        if self.style.is_transparent {
            let mut stats = FrameStats::default();
            stats.bytes_resident = self.bytes_resident();
            stats.passes = canvas.put_nothing(commands.encoder(), view, target)?;
            stats.count(TILES_DRAWN, 0);
            stats.count(TILES_SKIPPED, all.len() as u64);
            stats.count(LOST_RAYS, 0);
            return Ok(Recorded::new(stats));
        }
        commands.submit()?;
        let eye = self.mesh.normalization.point(view.camera.position);
        let inside = match (view.camera.projection, self.options.crossings) {
            (Projection::Perspective { .. }, Crossings::Planes) => self.mesh.cell_around(eye),
            // Parallel rays begin before the mesh; what is behind the camera is cut off.
            // Those that cross by sides begin there in any case.
            _ => None,
        };
        let mut drawing = Drawing::new(self, view, inside)?;
        drawing.clear()?;
        let one_layer = self.mesh.source.boundary_statistics().convex;
        let mut seen = [false; TILES];
        for layer in 0.. {
            let active = drawing.enter(layer, inside.is_some(), &all)?;
            if active.is_empty() {
                break;
            }
            active.iter().for_each(|tile| seen[tile.index] = true);
            drawing.march(layer, &active)?;
            if one_layer {
                break;
            }
        }
        let sums = Sums {
            color: drawing.targets.colors[drawing.written].clone(),
            distances: None,
        };
        // Opacity, not depth, is gathered, where nothing shines too.
        let model = match self.style.appearance.optical_model {
            OpticalModel::Absorption => OpticalModel::EmissionAbsorption,
            model => model,
        };
        let normalization = &self.mesh.normalization;
        canvas.put(
            commands.encoder(),
            view,
            normalization,
            (model, &sums),
            target,
        )?;
        let mut stats = drawing.stats;
        stats.passes += 1;
        let drawn = || all.iter().filter(|tile| seen[tile.index]);
        let steps = || drawn().map(|tile| drawing.steps[tile.index]);
        stats.count(TILES_DRAWN, drawn().count() as u64);
        stats.count(TILES_SKIPPED, (all.len() - drawn().count()) as u64);
        if let (Some(least), Some(most)) = (steps().min(), steps().max()) {
            stats.count(LEAST_TILE_PASSES, least);
            stats.count(MOST_TILE_PASSES, most);
        }
        stats.count(LOST_RAYS, drawing.lost_rays);
        if drawing.lost_rays > 0 {
            stats.notes.push(format!(
                "{} rays were given up in the mesh and show a part of what they cross",
                drawing.lost_rays
            ));
        }
        let bounds = self.mesh.source.bounds();
        say_if_flat(&mut stats, &bounds, normalization, model);
        stats.bytes_resident = self.bytes_resident();
        Ok(Recorded::new(stats))
    }

    fn frame(&self, view: &View, inside: Option<([f32; 2], f32)>) -> CameraUniform {
        let rays = Rays::new(view, &self.mesh.normalization);
        let extended = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        let ([u, v], scalar) = inside.unwrap_or_default();
        // Normalized lengths; the scale is a power of two.
        let extent = self.mesh.source.bounds().size().max_element();
        let extent = (extent / self.mesh.normalization.scale) as f32;
        CameraUniform {
            clip: self.clip(view),
            anchor: extended(rays.anchor, 0.0),
            anchor_x: extended(rays.anchor_x, 0.0),
            anchor_y: extended(rays.anchor_y, 0.0),
            eye: extended(rays.eye, if rays.is_point { 1.0 } else { 0.0 }),
            inside: [u, v, 0.0, scalar],
            eye_depth: rays.eye_depth as f32,
            bias: self.options.peel_bias * extent.max(0.0),
            stop_opacity: self.options.stop_opacity,
            starts_behind: u32::from(!rays.is_point || self.may_be_inside(view)),
            table_span: self.style.table.span(),
        }
    }

    /// Whether the eye is in the mesh's box, with room for rounding: else no path leads
    /// through it, and what lies behind it is not followed.
    fn may_be_inside(&self, view: &View) -> bool {
        let bounds = self.mesh.source.bounds();
        let from_center = (view.camera.position - bounds.center()).abs();
        from_center.cmple(bounds.size() * 0.501).all()
    }

    /// From normalized space to clip space, columns. Depth falls from the eye on, so
    /// that f32 resolves it everywhere.
    fn clip(&self, view: &View) -> [[f32; 4]; 4] {
        // Before this nothing is drawn: far below what f32 resolves of the mesh.
        const NEAR: f64 = 1e-6;
        let plane = ImagePlane::new(view, &self.mesh.normalization);
        let row = |axis: DVec3, factor: f64, from: DVec3| {
            let axis = axis * factor;
            axis.extend(-axis.dot(from))
        };
        let [zoom_x, zoom_y] = plane.reach.map(f64::recip);
        let (depth, w) = match plane.is_perspective {
            true => (DVec4::W * NEAR, row(plane.forward, 1.0, plane.eye)),
            // Vertices lie within √3 of the center.
            false => {
                let depth = row(plane.forward, -0.25, DVec3::ZERO) + DVec4::W * 0.5;
                (depth, DVec4::W)
            }
        };
        let rows = [
            row(plane.right, zoom_x, plane.eye),
            row(plane.up, zoom_y, plane.eye),
            depth,
            w,
        ];
        [0, 1, 2, 3].map(|column| rows.map(|row| row[column] as f32))
    }
}

impl<'a> Drawing<'a> {
    fn new(
        renderer: &'a PingPong,
        view: &View,
        inside: Option<([f32; 2], f32)>,
    ) -> Result<Drawing<'a>, Error> {
        let PingPong {
            gpu,
            passes,
            mesh,
            style,
            ..
        } = renderer;
        let size = (view.width, view.height);
        let targets = Targets::new(gpu, size)?;
        let rectangles = match &mesh.boundary {
            Boundary::Corners(..) => None,
            Boundary::Faces(_, faces) => {
                let rays = Rays::new(view, &mesh.normalization);
                let rectangles = rectangles(view, &rays, faces);
                let usage = BufferUsages::VERTEX;
                Some(gpu.upload("ping-pong::rectangles", &rectangles, usage)?)
            }
        };
        let frame = [renderer.frame(view, inside)];
        let frame = gpu.upload("ping-pong::frame", &frame, BufferUsages::UNIFORM)?;
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let answers = gpu.buffer("ping-pong::answers", 8 * TILES as u64, usage)?;
        let mut stats = FrameStats::default();
        stats.count(LAYERS, 0);
        stats.count(FRAGMENTS, 0);
        gpu.checked("ping-pong", 0, || {
            let textures = mesh.textures().map(|t| t.create_view(&Default::default()));
            let textures = [0, 1, 2].map(|i| BindingResource::TextureView(&textures[i]));
            let frame = [frame.as_entire_binding()];
            let transfer = [style.intervals.as_entire_binding(), style.table.binding()];
            Drawing {
                frame: group(gpu, "ping-pong::frame", &passes.frame_layout, &frame),
                mesh: group(gpu, "ping-pong::mesh", &passes.mesh_layout, &textures),
                integration: group(
                    gpu,
                    "ping-pong::integration",
                    &passes.integration_layout,
                    &transfer,
                ),
                queries: gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("ping-pong::queries"),
                    ty: wgpu::QueryType::Occlusion,
                    count: TILES as u32,
                }),
                rectangles,
                answers,
                renderer,
                size,
                targets,
                written: 0,
                steps: [0; TILES],
                lost_rays: 0,
                stats,
            }
        })
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        let device = self.renderer.gpu.device();
        device.create_command_encoder(&Default::default())
    }

    fn clear(&mut self) -> Result<(), Error> {
        let mut encoder = self.encoder();
        for color in &self.targets.colors {
            record_clear(&mut encoder, &view_of(color), Color::TRANSPARENT);
        }
        // The first layer is written to the other.
        record_clear(&mut encoder, &self.targets.layers[1], BEFORE);
        self.stats.passes += 3;
        self.renderer.gpu.finish(encoder)
    }

    /// The data that a step, or the retirement of rays, reads.
    fn traversal(&self, states: &TextureView, colors: &wgpu::Texture) -> BindGroup {
        let colors = view_of(colors);
        let textures = [states, &colors].map(BindingResource::TextureView);
        let layout = &self.renderer.passes.traversal_layout;
        group(
            &self.renderer.gpu,
            "ping-pong::traversal",
            layout,
            &textures,
        )
    }

    /// Finds where rays come in for the `layer`th time; returns the tiles with such rays.
    fn enter(&mut self, layer: usize, inside: bool, all: &[Tile]) -> Result<Vec<Tile>, Error> {
        let mut encoder = self.encoder();
        let PingPong {
            gpu, passes, mesh, ..
        } = self.renderer;
        let Targets { layers, colors, .. } = &self.targets;
        let (this, before) = (&layers[layer % 2], &layers[1 - layer % 2]);
        let before = [BindingResource::TextureView(before)];
        let before = group(gpu, "ping-pong::before", &passes.before_layout, &before);
        let groups = [&self.frame, &self.mesh, &before];
        let depths = &self.targets.depths;
        if layer == 0 && inside {
            passes.record_inside(&mut encoder, groups, this, depths);
        } else {
            let boundary = (&mesh.boundary, self.rectangles.as_ref());
            passes.record_entry(&mut encoder, groups, boundary, this, depths);
        }
        self.stats.passes += 1;
        let arrived = self.traversal(this, &colors[self.written]);
        self.remaining(encoder, &arrived, all, LoadOp::Clear(1.0))
    }

    /// Retires the rays of `tiles` that `traversal` says are idle, submits, and returns
    /// the tiles with others.
    fn remaining(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        traversal: &BindGroup,
        tiles: &[Tile],
        load: LoadOp<f32>,
    ) -> Result<Vec<Tile>, Error> {
        let PingPong { gpu, passes, .. } = self.renderer;
        let groups = [&self.frame, &self.mesh, traversal];
        let retired = (&self.targets.retired, load);
        passes.record_retire(&mut encoder, groups, tiles, retired, &self.queries);
        self.stats.passes += 1;
        encoder.resolve_query_set(&self.queries, 0..tiles.len() as u32, &self.answers, 0);
        let bytes = 8 * tiles.len() as u64;
        let answers = read_back(gpu, &mut encoder, Source::Buffer(&self.answers, bytes))?;
        gpu.finish(encoder)?;
        let answers: Vec<u64> = answers.read()?;
        let left = tiles
            .iter()
            .zip(answers)
            .filter(|(_, visible)| *visible > 0);
        Ok(left.map(|(tile, _)| *tile).collect())
    }

    /// Takes the rays of a layer to where they leave the mesh.
    ///
    /// Ends: a straight line visits a cell once, so after as many passes as there are
    /// cells what still goes on goes round in circles, and is counted as lost.
    fn march(&mut self, layer: usize, active: &[Tile]) -> Result<(), Error> {
        let renderer = self.renderer;
        let most = renderer.mesh.source.cell_count() as u64;
        let Targets { states, colors, .. } = &self.targets;
        // What the pass that writes i reads.
        let first = [1, 0].map(|i| self.traversal(&self.targets.layers[layer % 2], &colors[i]));
        let later = [1, 0].map(|i| self.traversal(&states[i], &colors[i]));
        let mut drawn = [0; TILES];
        let mut left = active.to_vec();
        let mut taken = 0;
        while !left.is_empty() && taken < most {
            let mut encoder = self.encoder();
            let mut read = &first[0];
            for _ in 0..u64::from(renderer.options.query_interval).min(most - taken) {
                let target = 1 - self.written;
                read = if taken == 0 {
                    &first[target]
                } else {
                    &later[target]
                };
                renderer.style.passes.record_step(
                    &mut encoder,
                    [&self.frame, &self.mesh, read, &self.integration],
                    &left,
                    [
                        &self.targets.states[target],
                        &view_of(&self.targets.colors[target]),
                    ],
                    &self.targets.retired,
                );
                self.written = target;
                taken += 1;
                self.stats.passes += 1;
                for tile in &left {
                    drawn[tile.index] = 1;
                    self.steps[tile.index] += 1;
                    self.stats.add(FRAGMENTS, tile.pixels());
                }
            }
            left = self.remaining(encoder, read, &left, LoadOp::Load)?;
        }
        self.tally(layer, drawn)?;
        self.stats.add(LAYERS, 1);
        Ok(())
    }

    fn tally(&mut self, layer: usize, drawn: [u32; TILES]) -> Result<(), Error> {
        let PingPong {
            gpu,
            passes,
            options,
            ..
        } = self.renderer;
        let tally = Tally {
            tiles: [options.tiles; 4],
            lost: 0,
            drawn,
            padding: [0; 3],
        };
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let buffer = gpu.upload("ping-pong::tally", &[tally], usage)?;
        let (states, colors) = (&self.targets.states, &self.targets.colors);
        let color = view_of(&colors[self.written]);
        let resources = [
            BindingResource::TextureView(&states[self.written]),
            BindingResource::TextureView(&color),
            BindingResource::TextureView(&self.targets.layers[layer % 2]),
            buffer.as_entire_binding(),
        ];
        let read = group(gpu, "ping-pong::tally", &passes.tally_layout, &resources);
        let mut encoder = self.encoder();
        let groups = [&self.frame, &self.mesh, &read];
        passes.record_tally(&mut encoder, groups, self.size);
        self.stats.passes += 1;
        let bytes = size_of::<Tally>() as u64;
        let answer = read_back(gpu, &mut encoder, Source::Buffer(&buffer, bytes))?;
        gpu.finish(encoder)?;
        let answer: Vec<Tally> = answer.read()?;
        let [tally] = answer[..] else {
            return Err(Error::Device {
                reason: "the tally did not come back".into(),
            });
        };
        self.lost_rays += u64::from(tally.lost);
        Ok(())
    }
}
