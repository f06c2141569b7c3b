//! Which cells can show, whenever appearance or scalars change: judged, counted and listed
//! on the device (`judge.wgsl`, `compact.wgsl`).

use tetrascope_core::{Error, OpticalModel};
use tetrascope_f32::KnotPair;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE, group, model_constant};
use tetrascope_gpu::pipelines::Constant;
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{ComputeProgram, Gpu, read_back};
use tetrascope_shaders::projection::{COMPACT, JUDGE};

use crate::gpu_data::Cull;
use crate::volume::{Field, Geometry};

/// Cells of one workgroup.
const WORKGROUP: u32 = 256;

/// Pieces a cell, on average, beyond which cells are drawn whole. On llvmpipe a piece costs
/// as much as a turn of the loop; elsewhere, memory.
const MOST_PIECES: u64 = 2;

/// What a list without pieces has, as in `order.wgsl`.
const NO_CELL: u32 = u32::MAX;

/// What is left to draw.
#[derive(Debug)]
pub(crate) struct Culled {
    /// The first and the last interval of each of the mesh's cells, 16 bits each.
    pub(crate) ranges: wgpu::Buffer,
    /// The items that are drawn: cells or, where `in_pieces`, those.
    pub(crate) drawn: wgpu::Buffer,
    /// A cell and what of it is drawn, by piece; see `pieces.wgsl`.
    pub(crate) pieces: wgpu::Buffer,
    pub(crate) items: u32,
    pub(crate) cells: u32,
    pub(crate) in_pieces: bool,
    /// Whether pieces are in parts, none of an optical depth above 1.
    pub(crate) in_parts: bool,
}

/// What decides.
pub(crate) struct Judged<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) field: &'a Field,
    pub(crate) model: OpticalModel,
    pub(crate) intervals: &'a [KnotPair],
    /// Of isosurfaces, in the unit of the scalars.
    pub(crate) isovalues: &'a [f32],
    /// Whether cells may be drawn in pieces.
    pub(crate) pieces: bool,
}

/// Lists what of `judged` is drawn, in submissions of its own.
pub(crate) fn cull(gpu: &Gpu, judged: &Judged) -> Result<Culled, Error> {
    let Judged {
        geometry, field, ..
    } = judged;
    let label = "projection::cull";
    let cells = geometry.mesh.cell_count() as u32;
    let marks = marks(judged);
    let blocks = cells.div_ceil(WORKGROUP);
    let uniform = Cull {
        cells,
        intervals: judged.intervals.len() as u32,
        marks: marks.len() as u32,
        blocks,
    };
    let uniform = gpu.upload(label, &[uniform], BufferUsages::UNIFORM)?;
    let storage = BufferUsages::STORAGE;
    let copied = storage | BufferUsages::COPY_SRC;
    let ranges = gpu.buffer("the cells' intervals", 4 * u64::from(cells.max(1)), copied)?;
    let counts = gpu.buffer(label, 4 * u64::from(cells.max(1)), storage)?;
    let sums = gpu.buffer(label, 16 * u64::from(blocks + 1), copied)?;
    let intervals = gpu.upload(label, judged.intervals, storage)?;
    let marks = gpu.upload(label, &marks, storage)?;
    let pass = |source, entry, constants: &[Constant], buffers: &[_]| {
        let pass = Pass {
            source,
            entry,
            constants,
        };
        pass.record(gpu, buffers, blocks)
    };
    let shared = [&uniform, &counts, &sums];
    let field_constant = ("SCALARS_PER_CELL", f64::from(field.per_cell));
    let constants = [model_constant(judged.model), field_constant];
    let (cells_of, positions) = (&geometry.cells, &geometry.positions);
    let own = [
        cells_of,
        &field.scalars,
        &intervals,
        &marks,
        &ranges,
        positions,
    ];
    let all: Vec<_> = shared.iter().chain(&own).copied().collect();
    gpu.finish(pass(JUDGE, "cs_judge", &constants, &all)?)?;

    let nothing = [
        gpu.buffer(label, 8, storage)?,
        gpu.buffer(label, 8, storage)?,
    ];
    let [drawn, pieces] = &nothing;
    let all: Vec<_> = shared.into_iter().chain([drawn, pieces]).collect();
    let mut encoder = pass(COMPACT, "cs_scan", &[], &all)?;
    let total = read_back(gpu, &mut encoder, Source::Buffer(&sums, sums.size()))?;
    gpu.finish(encoder)?;
    let total: Vec<[u32; 4]> = total.read()?;
    let [cells_drawn, piece_count, part_count, uncounted] = total[blocks as usize];

    let fit = |items: u32| {
        judged.pieces
            && u64::from(items) <= MOST_PIECES * u64::from(cells_drawn)
            && items <= u32::MAX / 4
    };
    let in_parts =
        fit(part_count) && uncounted == 0 && judged.model == OpticalModel::EmissionAbsorption;
    let in_pieces = in_parts || fit(piece_count);
    let items = match (in_pieces, in_parts) {
        (_, true) => part_count,
        (true, false) => piece_count,
        (false, false) => cells_drawn,
    };
    let drawn = gpu.buffer(
        "the list of drawn cells",
        4 * u64::from(items.max(1)),
        copied,
    )?;
    let pieces = match in_pieces {
        true => gpu.buffer("the cells' pieces", 8 * u64::from(items.max(1)), copied)?,
        false => gpu.upload("the cells' pieces", &[[NO_CELL, 0]], copied)?,
    };
    let all: Vec<_> = shared.into_iter().chain([&drawn, &pieces]).collect();
    let constants = [
        ("PIECES", f64::from(in_pieces)),
        ("PARTS", f64::from(in_parts)),
    ];
    gpu.finish(pass(COMPACT, "cs_compact", &constants, &all)?)?;
    Ok(Culled {
        ranges,
        drawn,
        pieces,
        items,
        cells: cells_drawn,
        in_pieces,
        in_parts,
    })
}

/// For each interval the next, from it on, at one end of which something shows; or the
/// isovalues' bits, sorted. See `judge.wgsl`.
fn marks(judged: &Judged) -> Vec<u32> {
    if judged.model == OpticalModel::Isosurfaces {
        let mut values = judged.isovalues.to_vec();
        values.sort_by(f32::total_cmp);
        return values.into_iter().map(f32::to_bits).collect();
    }
    let shows = |at: &[f32; 4]| match judged.model {
        OpticalModel::MaximumIntensity => at[..3].iter().any(|c| *c > 0.0),
        _ => at[3] > 0.0,
    };
    let mut next = u32::MAX;
    let mut marks = vec![next; judged.intervals.len()];
    for (index, interval) in judged.intervals.iter().enumerate().rev() {
        if shows(&interval.at_low) || shows(&interval.at_high) {
            next = index as u32;
        }
        marks[index] = next;
    }
    marks
}

/// One of the passes.
struct Pass<'a> {
    source: &'static str,
    entry: &'static str,
    constants: &'a [Constant],
}

impl Pass<'_> {
    /// Commands that run it over `blocks` workgroups, or one that scans.
    fn record(
        &self,
        gpu: &Gpu,
        buffers: &[&wgpu::Buffer],
        blocks: u32,
    ) -> Result<wgpu::CommandEncoder, Error> {
        let label = "projection::cull";
        let mut types = vec![UNIFORM, WRITE, WRITE];
        types.extend(match self.entry {
            "cs_judge" => vec![READ, READ, READ, READ, WRITE, READ],
            _ => vec![WRITE, WRITE],
        });
        let layout = gpu.layout(label, ShaderStages::COMPUTE, &types)?;
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label,
            source: self.source,
            entry: Some(self.entry),
            constants: self.constants.to_vec(),
            groups: vec![layout.clone()],
        })?;
        gpu.checked(label, 0, || {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let resources: Vec<_> = buffers.iter().map(|b| b.as_entire_binding()).collect();
            let group = group(gpu, label, &layout, &resources);
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                // Two dimensions: one holds 65 535 workgroups on most devices.
                let blocks = if self.entry == "cs_scan" { 1 } else { blocks };
                let row = blocks.clamp(1, gpu.limits().max_compute_workgroups_per_dimension);
                pass.dispatch_workgroups(row, blocks.div_ceil(row), 1);
            }
            encoder
        })
    }
}

impl Culled {
    /// The same cells, `listed`, drawn whole.
    pub(crate) fn whole(&self, gpu: &Gpu, listed: &[u32]) -> Result<Culled, Error> {
        let storage = BufferUsages::STORAGE;
        Ok(Culled {
            ranges: self.ranges.clone(),
            drawn: gpu.upload("the list of drawn cells", listed, storage)?,
            pieces: gpu.upload("the cells' pieces", &[[NO_CELL, 0]], storage)?,
            items: listed.len() as u32,
            cells: self.cells,
            in_pieces: false,
            in_parts: false,
        })
    }

    /// Indices of the cells that are drawn, and where cells are in pieces the first of each
    /// of the mesh's `cell_count` cells and the end of the last.
    pub(crate) fn read(
        &self,
        gpu: &Gpu,
        cell_count: usize,
    ) -> Result<(Vec<u32>, Option<Vec<u32>>), Error> {
        let items = self.items as usize;
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let list = if self.in_pieces {
            &self.pieces
        } else {
            &self.drawn
        };
        let copy = read_back(gpu, &mut encoder, Source::Buffer(list, list.size()))?;
        gpu.finish(encoder)?;
        if !self.in_pieces {
            let mut cells: Vec<u32> = copy.read()?;
            cells.truncate(items);
            return Ok((cells, None));
        }
        let mut list: Vec<[u32; 2]> = copy.read()?;
        list.truncate(items);
        let mut starts = Vec::with_capacity(cell_count + 1);
        let is_first = |what: u32| what & 0x00ff_ffff == 0;
        for ([cell, what], place) in list.iter().zip(0..) {
            if is_first(*what) {
                // Cells that are not drawn have no pieces.
                starts.resize(*cell as usize + 1, place);
            }
        }
        starts.resize(cell_count + 1, items as u32);
        let cells = list.iter().filter(|[_, what]| is_first(*what));
        Ok((cells.map(|[cell, _]| *cell).collect(), Some(starts)))
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::mesh::{Association, Scalars};
    use tetrascope_core::{Knot, TetMesh, TransferFunction};
    use tetrascope_f32::{Domain, ScalarMap};
    use tetrascope_gpu::transfer_function::knot_pairs;

    use super::*;
    use crate::options::CellLayout;

    /// A row of cells; each has the four scalars that `of` gives it, or the first.
    fn row(association: Association, cells: u32, of: impl Fn(u32) -> [f64; 4]) -> TetMesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let corner = |cell: u32, i: usize| match (cell % 13, i) {
            // Flat.
            (7, 3) => corners[1] + corners[2] + f64::from(cell) * DVec3::X,
            _ => corners[i] + f64::from(cell) * DVec3::X,
        };
        let points = (0..cells).flat_map(|c| (0..4).map(move |i| corner(c, i)));
        let values = match association {
            Association::Point => (0..cells).flat_map(&of).collect(),
            Association::Cell => (0..cells).map(|c| of(c)[0]).collect(),
        };
        let scalars = Scalars {
            name: "s".into(),
            association,
            values,
        };
        let cells = (0..cells)
            .map(|c| [0, 1, 2, 3].map(|i| 4 * c + i))
            .collect();
        TetMesh::from_tetrahedra(points.collect(), cells, scalars).expect("valid")
    }

    /// Two ramps with nothing between, a step, and one color without extinction.
    fn function() -> TransferFunction {
        let knot = |scalar, extinction, color: f64| Knot {
            scalar,
            color: DVec3::splat(color),
            extinction,
        };
        let knots = vec![
            knot(0.0, 0.0, 0.0),
            knot(1.0, 1.0, 1.0),
            knot(2.0, 0.0, 0.0),
            knot(4.0, 0.0, 0.0),
            knot(4.0, 3.0, 0.0),
            knot(5.0, 3.0, 0.0),
            knot(5.0, 0.0, 0.0),
            knot(6.0, 0.0, 0.5),
            knot(7.0, 0.0, 0.0),
        ];
        TransferFunction::new(knots).expect("sorted")
    }

    /// Quarters, so that f32 has them and many are on knots.
    fn scalars(cell: u32) -> [f64; 4] {
        let start = f64::from(cell * 7 % 41) / 4.0 - 1.0;
        let step = f64::from(cell % 5) / 4.0;
        let last = if cell % 17 == 3 {
            f64::NAN
        } else {
            start + step
        };
        [start, start + step * 0.5, last, start]
    }

    /// What the docs of `judge.wgsl` say, cell by cell.
    fn is_shown(mesh: &TetMesh, cell: usize, model: OpticalModel, isovalues: &[f64]) -> bool {
        let values: [f64; 4] = mesh.cell_scalars(cell);
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if cell % 13 == 7 || values.iter().any(|s| s.is_nan()) {
            return false;
        }
        // Inside of the cell: what it only touches does not count, unless it is constant.
        let inside = if low < high { 1e-6 } else { 0.0 };
        let (low_in, high_in) = (low + inside, high - inside);
        match model {
            OpticalModel::Isosurfaces => isovalues.iter().any(|v| low < *v && *v <= high),
            OpticalModel::MaximumIntensity => function().max_color(low_in, high_in) > 0.0,
            _ => function().max_extinction(low_in, high_in) > 0.0,
        }
    }

    #[test]
    fn the_list_is_that_of_the_cells_that_show() {
        let Some(gpu) = tetrascope_testing::gpu("the_list_is_that_of_the_cells_that_show") else {
            return;
        };
        let isovalues = [3.25, 0.5, 5.0];
        // Around one workgroup and more blocks than one workgroup has threads.
        for cells in [1, 255, 256, 257, 70_001] {
            for association in [Association::Point, Association::Cell] {
                let mesh = row(association, cells, scalars);
                let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
                let map = ScalarMap::of_appearance(
                    &tetrascope_core::Appearance::new(function(), OpticalModel::Emission),
                    mesh.scalar_range(),
                );
                let layout = CellLayout::SharedVertices;
                let field = Field::upload(&gpu, &geometry, &mesh, map, layout).expect("it fits");
                let intervals = knot_pairs(&function(), &map, &geometry.normalization);
                let intervals = intervals.expect("few knots");
                for model in OpticalModel::ALL {
                    let expected = (0..mesh.cell_count())
                        .filter(|cell| is_shown(&mesh, *cell, model, &isovalues));
                    let expected: Vec<u32> = expected.map(|cell| cell as u32).collect();
                    for pieces in [false, true] {
                        let culled = cull(
                            &gpu,
                            &Judged {
                                geometry: &geometry,
                                field: &field,
                                model,
                                intervals: &intervals,
                                isovalues: &isovalues.map(|v| map.scalar(v)),
                                pieces,
                            },
                        );
                        let culled = culled.expect("it fits");
                        let (listed, starts) =
                            culled.read(&gpu, mesh.cell_count()).expect("readable");
                        let what = format!("{cells} {association:?} {model:?} {pieces}");
                        assert_eq!(listed, expected, "{what}");
                        assert_eq!(culled.cells as usize, expected.len(), "{what}");
                        let Some(starts) = starts else {
                            assert_eq!(culled.items, culled.cells, "{what}");
                            continue;
                        };
                        assert!(pieces);
                        assert_eq!(starts.len(), mesh.cell_count() + 1);
                        let many = |cell: usize| starts[cell + 1] - starts[cell];
                        for cell in 0..mesh.cell_count() {
                            let drawn = expected.binary_search(&(cell as u32)).is_ok();
                            assert_eq!(many(cell) > 0, drawn, "{what} {cell}");
                        }
                        assert_eq!(starts[mesh.cell_count()], culled.items, "{what}");
                    }
                }
            }
        }
    }
}
