//! The renderer: what lasts, and how a frame is recorded.

mod scene;
mod surfaces;

use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{Domain, ImagePlane, ScalarMap};
use tetrascope_gpu::gather::gathered_format;
use tetrascope_gpu::memory::{ReadBack, Source};
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{
    Canvas, Commands, Draw, Gpu, Outcome, Recorded, SceneDepth, Sums, SumsKind, Target, draw,
    read_back,
};

use self::scene::{Parts, Scene, Sorter, Sorting};
use self::surfaces::prepared;
use crate::counters::{
    BYTES_PER_VIEW, CELLS_DRAWN, CELLS_SKIPPED, CELLS_SORTED, FRAGMENTS_SORTED, LOST_RAYS,
    VISIBILITY_CYCLES,
};
use crate::entry::check;
use crate::frame::frame;
use crate::gpu_data;
use crate::options::{ExitSearch, Order, ProjectionOptions};
use crate::passes::cell::{CellPass, FrameData, Uploaded};
use crate::passes::faces::FacePass;
use crate::passes::lists::{self, ListPass};
use crate::passes::surface::{self, SurfaceData, SurfacePass};
use crate::passes::transform::TransformPass;
use crate::tiles::{boxes, tiles};
use crate::volume::{Field, Geometry, mesh_of};
use crate::{ABILITIES, NAME};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct CellProjection {
    canvas: Canvas,
    options: ProjectionOptions,
    transform_pass: TransformPass,
    cell_pass: CellPass,
    sorter: Sorter,
    scene: Scene,
    /// Compiled when isosurfaces are first drawn.
    surface_pass: Option<SurfacePass>,
    /// Compiled where ray parameters are computed at vertices.
    face_pass: Option<FacePass>,
}

impl CellProjection {
    /// Uploads the mesh in `volume` and compiles what `appearance` needs.
    ///
    /// [`Error::Unsupported`] for a grid, [`Error::TooLarge`] and
    /// [`Error::OutOfMemory`] if the device does not hold the mesh.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &ProjectionOptions,
    ) -> Result<CellProjection, Error> {
        let mesh = check(volume, appearance, options)?;
        let transform_pass = TransformPass::new(gpu)?;
        let cell_pass = CellPass::new(gpu)?;
        let mut sorter = Sorter::default();
        let domain = Domain::of(mesh).within(options.domain)?;
        let geometry = Geometry::upload(gpu, mesh, domain)?;
        let model = appearance.optical_model;
        sorter.prepare(gpu, options, &cell_pass, model, &geometry)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        let field = Field::upload(gpu, &geometry, mesh, map, options.cell_layout)?;
        let face_pass = match options.exit_search {
            ExitSearch::PerFragment => None,
            _ => Some(FacePass::new(gpu, options, &cell_pass)?),
        };
        let surface_pass = prepared(None, gpu, &cell_pass, appearance)?;
        let parts = Parts {
            gpu,
            options,
            transform_pass: &transform_pass,
            cell_pass: &cell_pass,
            sorter: &sorter,
            surface_pass: surface_pass.as_ref(),
            face_pass: face_pass.as_ref(),
        };
        let scene = parts.scene(appearance, geometry, field, None)?;
        Ok(CellProjection {
            canvas: Canvas::new(gpu)?,
            options: options.clone(),
            transform_pass,
            cell_pass,
            sorter,
            scene,
            surface_pass,
            face_pass,
        })
    }

    /// How the cells of a view are ordered, and what is to be said of it.
    fn ordered(&self, view: &View) -> OrderedCells {
        let scene = &self.scene;
        let automatic = self.options.order == Order::Auto;
        let mut ordered = OrderedCells {
            way: Ordered::AsListed(None),
            cycles: None,
            proven: None,
            note: None,
        };
        let model = scene.appearance.optical_model;
        match &scene.sorting {
            Sorting::None => ordered.proven = (!model.commutes()).then_some(false),
            Sorting::Centroid(_) | Sorting::CentroidOnCpu(_) => ordered.proven = Some(false),
            Sorting::PerPixel => {
                ordered.way = Ordered::InLists;
                ordered.proven = Some(true);
                let why = scene.unproven.as_ref().filter(|_| automatic);
                ordered.note = why.map(|why| format!("fragments are sorted in each pixel: {why}"));
            }
            Sorting::Mpvo(mpvo) => {
                let sorted = match scene.look.culled.cells {
                    0 => Default::default(),
                    _ => mpvo.sorted(view, &scene.geometry.normalization),
                };
                ordered.cycles = Some(sorted.cycles);
                let why = scene.unproven.clone().or_else(|| {
                    (sorted.cycles > 0).then(|| "cells hide each other in a cycle".into())
                });
                ordered.proven = Some(why.is_none());
                ordered.note = match why {
                    None if automatic => {
                        Some("cells are sorted by their faces: the mesh is convex".into())
                    }
                    None => None,
                    Some(why) if automatic && self.face_pass.is_none() => {
                        ordered.way = Ordered::InLists;
                        ordered.proven = Some(true);
                        Some(format!("fragments are sorted in each pixel: {why}"))
                    }
                    Some(why) => Some(format!("the order of cells may be wrong: {why}")),
                };
                if let Ordered::AsListed(cells) = &mut ordered.way {
                    *cells = Some(sorted.cells);
                }
            }
        }
        ordered
    }

    /// What changes with every frame; rays end where `depth` says.
    fn frame(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        depth: Option<&SceneDepth>,
    ) -> Result<FrameData, Error> {
        let scene = &self.scene;
        let normalization = &scene.geometry.normalization;
        let plane = ImagePlane::new(view, normalization);
        let uniform = frame(
            &plane,
            (view.width, view.height),
            scene.look.culled.items,
            scene.field.per_cell,
        );
        let uniform = gpu_data::CameraUniform {
            scalar_range: scene.field.range.into(),
            ..uniform
        };
        let (look, items) = look(
            &scene.appearance,
            view,
            &scene.geometry.domain.bounds,
            normalization,
            &scene.field.map,
            &plane.camera_from_normalized(),
        );
        let span = match &scene.surfaces {
            Some(surfaces) => surfaces.span(),
            None => scene.look.table.span(),
        };
        let look = look.with_tables(scene.look.interval_count, span);
        let ends = self
            .canvas
            .ends(encoder, view, normalization, plane.anchor_depth, depth)?;
        let gpu = self.canvas.gpu();
        let upload =
            |gpu: &Gpu, bytes: &[u8]| gpu.upload("projection::frame", bytes, BufferUsages::UNIFORM);
        Ok(FrameData {
            values: uniform,
            frame: upload(gpu, bytemuck::bytes_of(&uniform))?,
            look: upload(gpu, bytemuck::bytes_of(&look))?,
            ends,
            items,
        })
    }

    fn format(&self, in_lists: bool) -> TextureFormat {
        match in_lists {
            true => lists::FORMAT,
            false => gathered_format(self.canvas.gpu(), self.scene.appearance.optical_model),
        }
    }

    fn stats(&self, in_lists: bool) -> FrameStats {
        let scene = &self.scene;
        let (geometry, look) = (&scene.geometry, &scene.look);
        let buffers = [
            &geometry.positions,
            &geometry.cells,
            &scene.field.scalars,
            &look.culled.ranges,
            &look.culled.drawn,
            &look.culled.pieces,
        ];
        // Four numbers a texel.
        let texels = |t: &wgpu::Texture| 16 * u64::from(t.width()) * u64::from(t.height());
        let (order_bytes, sorted) = match &scene.sorting {
            Sorting::Centroid(data) => (data.bytes(), true),
            Sorting::CentroidOnCpu(_) | Sorting::Mpvo(_) => (0, true),
            Sorting::None | Sorting::PerPixel => (0, false),
        };
        let drawn = u64::from(look.culled.cells);
        let mut stats = FrameStats::default();
        stats.count(CELLS_DRAWN, drawn);
        stats.count(CELLS_SKIPPED, geometry.mesh.cell_count() as u64 - drawn);
        stats.count(CELLS_SORTED, if sorted { drawn } else { 0 });
        let surfaces = scene.surfaces.as_ref().map_or(0, SurfaceData::bytes);
        let faces = scene.field.faces.iter().flatten().map(wgpu::Buffer::size);
        let faces: u64 = faces.sum();
        // The layout's own: where faces have their vertices, nothing else is drawn from.
        let layout = match &scene.field.faces {
            Some(_) => faces,
            None => buffers[..3].iter().map(|b| b.size()).sum(),
        };
        stats.bytes_per_cell = Some(layout as f64 / geometry.mesh.cell_count().max(1) as f64);
        let per_view = order_bytes + texels(&geometry.transformed);
        stats.count(BYTES_PER_VIEW, per_view);
        stats.bytes_resident = per_view
            + surfaces
            + faces
            + self.face_pass.as_ref().map_or(0, FacePass::bytes)
            + look.table.bytes()
            + buffers.iter().map(|b| b.size()).sum::<u64>()
            + texels(&look.intervals);
        if matches!(
            self.format(in_lists),
            TextureFormat::R16Float | TextureFormat::Rgba16Float
        ) {
            let note = "this device does not blend f32, so cells add up in f16";
            stats.notes.push(note.into());
        }
        stats
    }

    fn parts(&self) -> Parts<'_> {
        Parts {
            gpu: self.canvas.gpu(),
            options: &self.options,
            transform_pass: &self.transform_pass,
            cell_pass: &self.cell_pass,
            sorter: &self.sorter,
            surface_pass: self.surface_pass.as_ref(),
            face_pass: self.face_pass.as_ref(),
        }
    }

    fn reload_mesh(&mut self, mesh: &TetMesh) -> Result<(), Error> {
        let old = &self.scene.geometry;
        let domain = Domain::of(mesh).within(self.options.domain)?;
        let geometry = if old.mesh.shares_geometry(mesh) {
            Geometry {
                mesh: mesh.clone(),
                domain,
                ..old.clone()
            }
        } else {
            Geometry::upload(self.canvas.gpu(), mesh, domain)?
        };
        let (map, range) = (self.scene.field.map, domain.scalar_range);
        let map = match map.suits_appearance(&self.scene.appearance, range) {
            true => map,
            false => ScalarMap::of_appearance(&self.scene.appearance, range),
        };
        let layout = self.options.cell_layout;
        let field = Field::upload(self.canvas.gpu(), &geometry, mesh, map, layout)?;
        let appearance = &self.scene.appearance;
        let model = appearance.optical_model;
        self.sorter.prepare(
            self.canvas.gpu(),
            &self.options,
            &self.cell_pass,
            model,
            &geometry,
        )?;
        let last = Some(&self.scene.look);
        self.scene = self.parts().scene(appearance, geometry, field, last)?;
        Ok(())
    }
}

impl VolumeRenderer for CellProjection {
    /// Uploads scalars alone where the geometry is the same.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        ABILITIES.check(NAME, &self.scene.appearance, &volume.bounds())?;
        self.reload_mesh(mesh_of(volume)?)
    }

    /// Uploads the transfer function and which cells it leaves to draw; scalars only
    /// if its range moved so far that f32 would run out of digits.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let mesh = &self.scene.geometry.mesh;
        ABILITIES.check(NAME, appearance, &mesh.bounds())?;
        let model = appearance.optical_model;
        self.options.validate(appearance)?;
        let geometry = self.scene.geometry.clone();
        self.sorter.prepare(
            self.canvas.gpu(),
            &self.options,
            &self.cell_pass,
            model,
            &geometry,
        )?;
        let range = geometry.domain.scalar_range;
        let field = if self.scene.field.map.suits_appearance(appearance, range) {
            self.scene.field.clone()
        } else {
            let map = ScalarMap::of_appearance(appearance, range);
            let layout = self.options.cell_layout;
            Field::upload(self.canvas.gpu(), &geometry, &geometry.mesh, map, layout)?
        };
        let pass = self.surface_pass.clone();
        self.surface_pass = prepared(pass, self.canvas.gpu(), &self.cell_pass, appearance)?;
        let last = Some(&self.scene.look);
        let scene = self.parts().scene(appearance, geometry, field, last)?;
        // Uploads begin now, so that the room for them is free again when the next ones come: else
        // it grows with each edit until a frame is drawn.
        let gpu = self.canvas.gpu();
        gpu.checked("projection::restyle", 0, || gpu.queue().submit([]))?;
        self.scene = scene;
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for CellProjection {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        self.options.check_view(view)?;
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
        let encoder = commands.encoder();
        if scene.look.culled.cells == 0 && scene.surfaces.is_none() {
            let mut stats = self.stats(false);
            stats.passes = self.canvas.put_nothing(encoder, view, target)?;
            return Ok(Recorded::new(stats));
        }
        let normalization = &scene.geometry.normalization;
        // Surfaces are hidden when they are put among the geometry.
        let depth = target.depth.as_ref().filter(|_| scene.surfaces.is_none());
        let uniform = self.frame(encoder, view, depth)?;
        let ordered = self.ordered(view);
        let in_lists = matches!(ordered.way, Ordered::InLists);
        let mut stats = self.stats(in_lists);
        if let Some(cycles) = ordered.cycles {
            stats.count(VISIBILITY_CYCLES, cycles);
        }
        stats.order_proven = ordered.proven;
        stats.notes.extend(ordered.note);
        let sums = self.canvas.sums(
            view,
            SumsKind {
                format: match scene.surfaces {
                    Some(_) => surface::COLOR,
                    None => self.format(in_lists),
                },
                usage: TextureUsages::RENDER_ATTACHMENT,
                distances: scene.surfaces.is_some(),
            },
        )?;
        gpu.checked("projection::transform", 0, || {
            let data = &scene.transform;
            self.transform_pass
                .record(gpu, encoder, &uniform.frame, data);
        })?;
        let mut counts = None;
        match (&scene.surfaces, ordered.way) {
            (Some(data), _) => {
                self.record_surfaces(encoder, &uniform, data, &sums)?;
                stats.passes += 1;
            }
            (None, Ordered::InLists) => {
                let (copy, most, passes) = self.record_lists(encoder, view, &uniform, &sums)?;
                stats.passes += passes;
                counts = Some((copy, most));
            }
            (None, Ordered::AsListed(sorted)) => {
                self.record_cells(encoder, &uniform, sorted, &sums, &mut stats)?;
            }
        }
        let model = scene.appearance.optical_model;
        self.canvas
            .put(encoder, view, normalization, (model, &sums), target)?;
        // And the transform.
        stats.passes += 2;
        let mut recorded = Recorded::new(stats);
        if let Some(distances) = &sums.distances {
            recorded = recorded.with_distances(distances, normalization.scale);
        }
        Ok(match counts {
            None => recorded,
            Some((copy, most)) => recorded.then(move |stats| count(stats, copy, &most)),
        })
    }
}

impl CellProjection {
    /// Records whole cells into lists of fragments, which are sorted and added up. Returns how
    /// many fragments each tile got and how many of its pixels were not done, on the way to the
    /// CPU; how many fragments each had room for; and the number of passes.
    fn record_lists(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        uniform: &FrameData,
        sums: &Sums,
    ) -> Result<(ReadBack, Vec<u64>, u64), Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
        let pass = self.sorter.lists(gpu, &self.cell_pass)?;
        let whole_cells = scene.whole_cells(&self.parts())?;
        let boxes = boxes(
            &scene.geometry.mesh,
            &scene.look.listed.cells,
            view,
            &scene.geometry.normalization,
        );
        let capacity = ListPass::capacity(gpu, self.options.fragment_bytes);
        let tiles = tiles(&boxes, (view.width, view.height), capacity)?;
        let cells = (&self.cell_pass, whole_cells);
        let gathered = sums.color.create_view(&Default::default());
        let counts = pass.record(gpu, encoder, uniform, cells, &tiles, &gathered)?;
        let copy = read_back(gpu, encoder, Source::Buffer(&counts, counts.size()))?;
        let most = tiles.iter().map(|t| t.most).collect();
        Ok((copy, most, ListPass::passes(&tiles)))
    }

    /// Records one draw of the cells that can show, in the order of `sorted` or as the device
    /// has them.
    fn record_cells(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        uniform: &FrameData,
        sorted: Option<Vec<u32>>,
        sums: &Sums,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
        let mut cell = scene.cell.clone();
        if let (Sorting::Centroid(data), Some(pass)) = (&scene.sorting, self.sorter.order()) {
            gpu.checked("projection::order", 0, || {
                pass.record(gpu, encoder, &uniform.frame, data);
            })?;
            stats.passes += 1;
        }
        let sorted = match &scene.sorting {
            Sorting::CentroidOnCpu(centroids) => Some(centroids.sorted(&uniform.values)),
            _ => sorted,
        };
        if let Some(cells) = sorted {
            let items = scene.look.listed.items_of(cells);
            stats.bytes_uploaded = 4 * items.len() as u64;
            let label = "projection::sorted";
            let items = gpu.upload(label, &items, BufferUsages::STORAGE)?;
            let uploaded = Uploaded {
                geometry: &scene.geometry,
                field: &scene.field,
                look: &scene.look,
            };
            cell.volume_group = self.cell_pass.volume_group(gpu, uploaded, &items)?;
        }
        let gathered = sums.color.create_view(&Default::default());
        gpu.checked("projection::cell", 0, || {
            let pass = &self.cell_pass;
            pass.record(gpu, encoder, uniform, &cell, &gathered)
        })??;
        stats.passes += 1;
        Ok(())
    }
}

/// Adds what lists of fragments counted; `most` is how many each tile had room for.
fn count(stats: &mut FrameStats, counts: ReadBack, most: &[u64]) -> Result<Outcome, Error> {
    let (fragments, given_up) = total(counts.read()?, most)?;
    stats.count(FRAGMENTS_SORTED, fragments);
    stats.count(LOST_RAYS, given_up);
    if given_up > 0 {
        stats.order_proven = Some(false);
        let note = format!("{given_up} pixels are wrong: their fragments were not all sorted");
        stats.notes.push(note);
    }
    Ok(Outcome::Complete)
}

/// How the cells of a view are ordered.
enum Ordered {
    /// As they are listed on the device, or in this order.
    AsListed(Option<Vec<u32>>),
    /// By fragments, in each pixel.
    InLists,
}

/// The same, and what is to be said of it.
struct OrderedCells {
    way: Ordered,
    cycles: Option<u64>,
    /// Whether it is known to be right; `None` where any is.
    proven: Option<bool>,
    note: Option<String>,
}

/// The number of all fragments, and of pixels that were not done; more fragments than
/// expected in a tile would have been lost.
fn total(counts: Vec<[u32; 2]>, most: &[u64]) -> Result<(u64, u64), Error> {
    for ([count, _], most) in counts.iter().zip(most) {
        if u64::from(*count) > *most {
            return Err(Error::TooLarge {
                what: "the list of fragments".into(),
                needed: u64::from(*count),
                limit: *most,
                unit: "fragments",
            });
        }
    }
    let sum = |of: usize| counts.iter().map(|c| u64::from(c[of])).sum();
    Ok((sum(0), sum(1)))
}

#[cfg(test)]
mod tests;
