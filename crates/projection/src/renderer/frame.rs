//! Records a frame: orders the cells, draws them, and notes how far their order is proven.

use tetrascope_core::{Error, FrameStats, View};
use tetrascope_f32::look::look;
use tetrascope_f32::{ImagePlane, say_if_flat};
use tetrascope_gpu::gather::gathered_format;
use tetrascope_gpu::memory::{ReadBack, Source};
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{
    Commands, Gpu, Outcome, Recorded, SceneDepth, Sums, SumsKind, Target, read_back,
};

use super::CellProjection;
use super::style::Sorting;
use crate::counters::{
    BYTES_PER_VIEW, CELLS_DRAWN, CELLS_SKIPPED, CELLS_SORTED, FRAGMENTS_SORTED, LOST_RAYS,
    VISIBILITY_CYCLES,
};
use crate::frame::frame;
use crate::gpu_data;
use crate::options::Order;
use crate::passes::cell::{FrameData, Uploaded};
use crate::passes::faces::FacePass;
use crate::passes::lists::{self, ListPass};
use crate::passes::surface::{self, SurfaceData};
use crate::tiles::{boxes, tiles};

impl CellProjection {
    pub(super) fn record_frame(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        self.options.check_view(view)?;
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let encoder = commands.encoder();
        if style.classified.culled.cells == 0 && style.surfaces.is_none() {
            let mut stats = self.stats(false);
            stats.passes = self.canvas.put_nothing(encoder, view, target)?;
            return Ok(Recorded::new(stats));
        }
        let normalization = &style.geometry.normalization;
        // Surfaces are hidden when they are put among the geometry.
        let depth = target.depth.as_ref().filter(|_| style.surfaces.is_none());
        let uniform = self.frame(encoder, view, depth)?;
        let ordered = self.ordered(view);
        let in_lists = matches!(ordered.way, Ordered::InLists);
        let mut stats = self.stats(in_lists);
        if let Some(cycles) = ordered.cycles {
            stats.count(VISIBILITY_CYCLES, cycles);
        }
        stats.order_proven = ordered.proven;
        stats.notes.extend(ordered.note);
        let model = style.appearance.optical_model;
        let bounds = &style.geometry.domain.bounds;
        say_if_flat(&mut stats, bounds, normalization, model);
        let sums = self.canvas.sums(
            view,
            SumsKind {
                format: match style.surfaces {
                    Some(_) => surface::COLOR,
                    None => self.format(in_lists),
                },
                usage: TextureUsages::RENDER_ATTACHMENT,
                distances: style.surfaces.is_some(),
            },
        )?;
        gpu.checked("projection::transform", 0, || {
            let data = &style.transform;
            self.transform_pass
                .record(gpu, encoder, &uniform.frame, data);
        })?;
        let mut counts = None;
        match (&style.surfaces, ordered.way) {
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
        let model = style.appearance.optical_model;
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

    /// How the cells of a view are ordered, and what is to be said of it.
    fn ordered(&self, view: &View) -> OrderedCells {
        let style = &self.style;
        let automatic = self.options.order == Order::Auto;
        let mut ordered = OrderedCells {
            way: Ordered::AsListed(None),
            cycles: None,
            proven: None,
            note: None,
        };
        let model = style.appearance.optical_model;
        match &style.sorting {
            Sorting::None => ordered.proven = (!model.commutes()).then_some(false),
            Sorting::Centroid(_) | Sorting::CentroidOnCpu(_) => ordered.proven = Some(false),
            Sorting::PerPixel => {
                ordered.way = Ordered::InLists;
                ordered.proven = Some(true);
                let why = style.unproven.as_ref().filter(|_| automatic);
                ordered.note = why.map(|why| format!("fragments are sorted in each pixel: {why}"));
            }
            Sorting::Mpvo(mpvo) => {
                let sorted = match style.classified.culled.cells {
                    0 => Default::default(),
                    _ => mpvo.sorted(view, &style.geometry.normalization),
                };
                ordered.cycles = Some(sorted.cycles);
                let why = style.unproven.clone().or_else(|| {
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

    /// The uniforms of one frame; its rays end where `depth` says.
    fn frame(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        depth: Option<&SceneDepth>,
    ) -> Result<FrameData, Error> {
        let style = &self.style;
        let normalization = &style.geometry.normalization;
        let plane = ImagePlane::new(view, normalization);
        let uniform = frame(
            &plane,
            (view.width, view.height),
            style.classified.culled.items,
            style.field.per_cell,
        );
        let uniform = gpu_data::CameraUniform {
            scalar_range: style.field.range.into(),
            ..uniform
        };
        let (look, items) = look(
            &style.appearance,
            view,
            &style.geometry.domain.bounds,
            normalization,
            &style.field.map,
            &plane.camera_from_normalized(),
        );
        let span = match &style.surfaces {
            Some(surfaces) => surfaces.span(),
            None => style.classified.table.span(),
        };
        let look = look.with_tables(style.classified.interval_count, span);
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
            false => gathered_format(self.canvas.gpu(), self.style.appearance.optical_model),
        }
    }

    fn stats(&self, in_lists: bool) -> FrameStats {
        let style = &self.style;
        let (geometry, classified) = (&style.geometry, &style.classified);
        let buffers = [
            &geometry.positions,
            &geometry.cells,
            &style.field.scalars,
            &classified.culled.ranges,
            &classified.culled.drawn,
            &classified.culled.pieces,
        ];
        // Four numbers per texel.
        let texels = |t: &wgpu::Texture| 16 * u64::from(t.width()) * u64::from(t.height());
        let (order_bytes, sorted) = match &style.sorting {
            Sorting::Centroid(data) => (data.bytes(), true),
            Sorting::CentroidOnCpu(_) | Sorting::Mpvo(_) => (0, true),
            Sorting::None | Sorting::PerPixel => (0, false),
        };
        let drawn = u64::from(classified.culled.cells);
        let mut stats = FrameStats::default();
        stats.count(CELLS_DRAWN, drawn);
        stats.count(CELLS_SKIPPED, geometry.mesh.cell_count() as u64 - drawn);
        stats.count(CELLS_SORTED, if sorted { drawn } else { 0 });
        let surfaces = style.surfaces.as_ref().map_or(0, SurfaceData::bytes);
        let faces = style.field.faces.iter().flatten().map(wgpu::Buffer::size);
        let faces: u64 = faces.sum();
        // The layout's own: where faces have their vertices, nothing else is drawn from.
        let layout = match &style.field.faces {
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
            + classified.table.bytes()
            + buffers.iter().map(|b| b.size()).sum::<u64>()
            + texels(&classified.intervals);
        if matches!(
            self.format(in_lists),
            TextureFormat::R16Float | TextureFormat::Rgba16Float
        ) {
            let note = "this device does not blend f32, so cells add up in f16";
            stats.notes.push(note.into());
        }
        stats
    }

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
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let pass = self.sorter.lists(gpu, &self.cell_pass)?;
        let whole_cells = style.whole_cells(&self.parts())?;
        let boxes = boxes(
            &style.geometry.mesh,
            &style.classified.listed.cells,
            view,
            &style.geometry.normalization,
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
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let mut cell = style.cell.clone();
        if let (Sorting::Centroid(data), Some(pass)) = (&style.sorting, self.sorter.order()) {
            gpu.checked("projection::order", 0, || {
                pass.record(gpu, encoder, &uniform.frame, data);
            })?;
            stats.passes += 1;
        }
        let sorted = match &style.sorting {
            Sorting::CentroidOnCpu(centroids) => Some(centroids.sorted(&uniform.values)),
            _ => sorted,
        };
        if let Some(cells) = sorted {
            let items = style.classified.listed.items_of(cells);
            stats.bytes_uploaded = 4 * items.len() as u64;
            let label = "projection::sorted";
            let items = gpu.upload(label, &items, BufferUsages::STORAGE)?;
            let uploaded = Uploaded {
                geometry: &style.geometry,
                field: &style.field,
                classified: &style.classified,
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
