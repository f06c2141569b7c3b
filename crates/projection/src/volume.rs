//! The mesh on the device, and which of its cells can show.

use std::sync::Arc;

use bytemuck::Zeroable;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Appearance, Error, OpticalModel, TetMesh, Volume};
use tetrascope_gpu::look::look_constants;
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::{Interval, intervals};
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration, Normalization, ScalarMap};

use crate::options::CellLayout;
use crate::{NAME, faces};

const STORAGE: BufferUsages = BufferUsages::STORAGE;

/// Texels a row of the vertices, as in `vertices.wgsl`.
const VERTICES_PER_ROW: u32 = 2048;

/// Camera space and scalar of a vertex.
pub(crate) const TRANSFORMED_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// Intervals a row of the transfer function, three texels each, as in `transfer.wgsl`.
const INTERVALS_PER_ROW: u32 = 256;

/// Cells name intervals in 16 bits.
const MOST_INTERVALS: usize = 1 << 16;

/// What a list without pieces has, as in `order.wgsl`.
const NO_CELL: u32 = u32::MAX;

/// Pieces a cell, on average, beyond which cells are drawn whole. On llvmpipe a piece costs
/// as much as a turn of the loop; elsewhere, memory.
const MOST_PIECES: u64 = 2;

/// The size of a texture with `count` items, `per_row` in each row.
fn texels(count: usize, per_row: u32) -> (u32, u32) {
    let rows = (count as u64).div_ceil(per_row.into()).max(1);
    // What does not fit is refused with the texture.
    (per_row, rows.min(u32::MAX.into()) as u32)
}

/// Geometry on the device.
#[derive(Clone, Debug)]
pub(crate) struct Geometry {
    pub(crate) mesh: TetMesh,
    pub(crate) normalization: Normalization,
    pub(crate) positions: wgpu::Buffer,
    pub(crate) cells: wgpu::Buffer,
    /// The longest edge, normalized.
    pub(crate) longest: f32,
    /// What the vertices are in camera space, once a frame has begun.
    pub(crate) transformed: wgpu::Texture,
}

/// Scalars on the device.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) map: ScalarMap,
    pub(crate) per_cell: bool,
    pub(crate) scalars: wgpu::Buffer,
    /// The vertices of faces, where cells do not share theirs.
    pub(crate) faces: Option<faces::Buffers>,
    /// The least and the greatest.
    pub(crate) range: (f32, f32),
}

/// The transfer function on the device, and what it leaves to draw.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    pub(crate) intervals: wgpu::Texture,
    /// Constants of shaders for clip planes and depth cue.
    pub(crate) extras: [(&'static str, f64); 2],
    pub(crate) interval_count: u32,
    /// The first and the last interval of each cell, 16 bits each.
    pub(crate) ranges: wgpu::Buffer,
    pub(crate) table: Table,
    /// The items that are drawn: cells or, where `pieces` has any, those.
    pub(crate) drawn: wgpu::Buffer,
    pub(crate) items: u32,
    /// Indices of the cells that are drawn.
    pub(crate) cells: Arc<[u32]>,
    pub(crate) pieces: Pieces,
    /// A bound of the optical depth of any segment.
    pub(crate) deepest: f32,
}

/// Cells in pieces, one for each interval of the transfer function (`pieces.wgsl`).
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    /// A cell and how many of its pieces come before, by piece.
    pub(crate) list: wgpu::Buffer,
    /// The first piece of each of the mesh's cells, and the end of the last; or nothing
    /// where cells are drawn whole.
    pub(crate) starts: Option<Arc<[u32]>>,
}

/// The mesh of `volume`, or why there is none.
pub(crate) fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it projects the cells of a tetrahedral mesh".into(),
        }),
    }
}

impl Geometry {
    pub(crate) fn upload(gpu: &Gpu, mesh: &TetMesh) -> Result<Geometry, Error> {
        // Four vertices a cell are numbered in 32 bits.
        let most = u32::MAX / 4;
        if mesh.cell_count() as u64 > u64::from(most) {
            return Err(Error::TooLarge {
                what: "the mesh".into(),
                needed: mesh.cell_count() as u64,
                limit: most.into(),
                unit: "cells",
            });
        }
        let normalization = Normalization::of(&mesh.bounds());
        let positions: Vec<[f32; 3]> = mesh
            .points()
            .iter()
            .map(|p| normalization.position(*p).to_array())
            .collect();
        Ok(Geometry {
            mesh: mesh.clone(),
            normalization,
            positions: gpu.upload("the mesh's vertices", &positions, STORAGE)?,
            cells: gpu.upload("the mesh's cells", mesh.tetrahedra(), STORAGE)?,
            longest: (longest_edge(mesh) / normalization.scale) as f32,
            transformed: gpu.texture(
                "of the mesh's vertices",
                texels(positions.len(), VERTICES_PER_ROW),
                TRANSFORMED_FORMAT,
                TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
            )?,
        })
    }
}

impl Field {
    pub(crate) fn upload(
        gpu: &Gpu,
        geometry: &Geometry,
        mesh: &TetMesh,
        map: ScalarMap,
        layout: CellLayout,
    ) -> Result<Field, Error> {
        let per_cell = mesh.scalars().association == Association::Cell;
        let scalars: Vec<f32> = if per_cell {
            let cells = 0..mesh.cell_count();
            cells.map(|c| map.scalar(mesh.cell_scalars(c)[0])).collect()
        } else {
            let values = &mesh.scalars().values;
            values.iter().map(|s| map.scalar(*s)).collect()
        };
        let (low, high) = mesh.scalar_range().unwrap_or((0.0, 0.0));
        let range = (map.scalar(low), map.scalar(high));
        let normalization = &geometry.normalization;
        Ok(Field {
            map,
            per_cell,
            range,
            faces: faces::upload(gpu, mesh, normalization, (&map, range), layout)?,
            scalars: gpu.upload("the mesh's scalars", &scalars, STORAGE)?,
        })
    }
}

impl Look {
    /// The items of `cells`, in their order.
    pub(crate) fn items_of(&self, cells: Vec<u32>) -> Vec<u32> {
        let Some(starts) = &self.pieces.starts else {
            return cells;
        };
        let pieces = |cell: u32| starts[cell as usize]..starts[cell as usize + 1];
        cells.into_iter().flat_map(pieces).collect()
    }

    /// With `table`, the last look's, that is kept if nothing in it changes. Cells are in
    /// pieces if `pieces` and if there are not too many.
    pub(crate) fn upload(
        gpu: &Gpu,
        geometry: &Geometry,
        map: &ScalarMap,
        appearance: &Appearance,
        (integration, table): (Integration, Option<&Table>),
        pieces: bool,
    ) -> Result<Look, Error> {
        let (drawn, deepest) = visible_cells(&geometry.mesh, map, appearance);
        let tf = &appearance.transfer_function;
        let mut intervals: Vec<Interval> = intervals(tf, map, &geometry.normalization);
        if intervals.len() > MOST_INTERVALS {
            return Err(Error::TooLarge {
                what: "the transfer function".into(),
                needed: intervals.len() as u64 - 1,
                limit: MOST_INTERVALS as u64 - 1,
                unit: "knots",
            });
        }
        let source = preintegration::Source {
            integration,
            model: appearance.optical_model,
            intervals: &intervals,
            longest: geometry.longest,
            fixed: None,
        };
        let table = match table {
            Some(table) => table.renewed(gpu, NAME, &source)?,
            None => Table::new(gpu, NAME, &source)?,
        };
        let ranges = ranges(&geometry.mesh, map, &intervals);
        let pieces = pieces
            .then(|| in_pieces(&geometry.mesh, &drawn, &ranges))
            .flatten();
        let items = pieces
            .as_ref()
            .map(|(list, _)| (0..list.len() as u32).collect::<Vec<_>>());
        let (list, starts) = pieces.unzip();
        let pieces = Pieces {
            list: gpu.upload(
                "the cells' pieces",
                &list.unwrap_or_else(|| vec![[NO_CELL, 0]]),
                STORAGE,
            )?,
            starts: starts.map(Arc::from),
        };
        let interval_count = intervals.len() as u32;
        let (width, height) = texels(intervals.len(), INTERVALS_PER_ROW);
        intervals.resize((width * height) as usize, Zeroable::zeroed());
        let texture = gpu.texture(
            "of the transfer function",
            (3 * width, height),
            TextureFormat::Rgba32Float,
            TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        )?;
        gpu.write_texture(&texture, &intervals)?;
        Ok(Look {
            table,
            intervals: texture,
            extras: look_constants(appearance),
            interval_count,
            ranges: gpu.upload("the cells' intervals", &ranges, STORAGE)?,
            drawn: gpu.upload(
                "the list of drawn cells",
                items.as_deref().unwrap_or(&drawn),
                STORAGE,
            )?,
            items: items.as_ref().unwrap_or(&drawn).len() as u32,
            pieces,
            cells: drawn.into(),
            // Rounded up: f32 may be under the bound by 2⁻²⁴ of it, and the shader's
            // own rounding over it by as little.
            deepest: (deepest * (1.0 + 1e-5)).min(1e30) as f32,
        })
    }
}

/// The cells that can change the picture, and a bound of the optical depth of a ray in any.
///
/// Left out are cells without volume, cells with a scalar that is NaN, and cells whose
/// scalars the transfer function maps to nothing: no extinction, or black where only
/// color counts. Where isosurfaces are drawn, cells that none goes through.
fn visible_cells(mesh: &TetMesh, map: &ScalarMap, appearance: &Appearance) -> (Vec<u32>, f64) {
    let tf = &appearance.transfer_function;
    let surfaces = appearance.isosurfaces.iter();
    let isovalues: Vec<f32> = surfaces.map(|s| map.scalar(s.value)).collect();
    let mut deepest = 0.0_f64;
    let visible = |&cell: &u32| {
        let scalars = mesh.cell_scalars(cell as usize);
        if scalars.iter().any(|s| s.is_nan()) {
            return false;
        }
        let [p0, p1, p2, p3] = mesh.cell_points(cell as usize);
        let volume = (p1 - p0).dot((p2 - p0).cross(p3 - p0));
        // Not `> 0`: products of tiny edges may underflow in a cell that has a volume.
        if volume == 0.0 && flat([p0, p1, p2, p3]) {
            return false;
        }
        let low = scalars.iter().copied().fold(f64::INFINITY, f64::min);
        let high = scalars.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if appearance.optical_model == OpticalModel::Isosurfaces {
            // As the shader decides, with what it knows.
            let (low, high) = (map.scalar(low), map.scalar(high));
            return isovalues.iter().any(|v| low < *v && *v <= high);
        }
        if appearance.optical_model == OpticalModel::MaximumIntensity {
            return tf.max_color(low, high) > 0.0;
        }
        let extinction = tf.max_extinction(low, high);
        let edges = [p1 - p0, p2 - p0, p3 - p0, p2 - p1, p3 - p1, p3 - p2];
        let longest = edges.iter().map(|e| e.length()).fold(0.0, f64::max);
        deepest = deepest.max(extinction * longest);
        extinction > 0.0
    };
    let drawn = (0..mesh.cell_count() as u32).filter(visible).collect();
    (drawn, deepest)
}

/// The longest edge of any cell, world units.
fn longest_edge(mesh: &TetMesh) -> f64 {
    let of_cell = |cell| {
        let [p0, p1, p2, p3] = mesh.cell_points(cell);
        let edges = [p1 - p0, p2 - p0, p3 - p0, p2 - p1, p3 - p1, p3 - p2];
        edges.into_iter().map(|e| e.length()).fold(0.0, f64::max)
    };
    (0..mesh.cell_count()).map(of_cell).fold(0.0, f64::max)
}

/// The first and the last of `intervals` that each cell's scalars are in, 16 bits each.
///
/// What only touches a knot is not beyond it, unless it is constant: then it is on both
/// sides.
fn ranges(mesh: &TetMesh, map: &ScalarMap, intervals: &[Interval]) -> Vec<u32> {
    let range = |cell| {
        let scalars: [f64; 4] = mesh.cell_scalars(cell);
        let scalars = scalars.map(|s| map.scalar(s));
        let low = scalars.iter().copied().fold(f32::INFINITY, f32::min);
        let high = scalars.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        // The lowest interval reaches below every scalar.
        let first = intervals[1..].partition_point(|i| i.low <= low) as u32;
        let last = intervals[1..].partition_point(|i| i.low < high) as u32;
        first.min(last) | first.max(last) << 16
    };
    (0..mesh.cell_count()).map(range).collect()
}

/// Each piece of `cells` and where each cell's begin, or nothing where fragments had
/// better loop: each piece costs a footprint and the search for the chord.
///
/// `ranges` as [`ranges`] gives them. A constant cell is one piece.
fn in_pieces(mesh: &TetMesh, cells: &[u32], ranges: &[u32]) -> Option<(Vec<[u32; 2]>, Vec<u32>)> {
    let count = |cell: u32| {
        let [first, rest @ ..] = mesh.cell_scalars(cell as usize);
        let range = ranges[cell as usize];
        let constant = rest.iter().all(|s| *s == first);
        if constant {
            1
        } else {
            (range >> 16) - (range & 0xffff) + 1
        }
    };
    let total: u64 = cells.iter().map(|c| u64::from(count(*c))).sum();
    if total > MOST_PIECES * cells.len() as u64 || total > u64::from(u32::MAX / 4) {
        return None;
    }
    let mut list = Vec::with_capacity(total as usize);
    let mut starts = Vec::with_capacity(mesh.cell_count() + 1);
    for &cell in cells {
        // Cells that are not drawn have no pieces.
        starts.resize(cell as usize + 1, list.len() as u32);
        list.extend((0..count(cell)).map(|rank| [cell, rank]));
    }
    starts.resize(mesh.cell_count() + 1, list.len() as u32);
    Some((list, starts))
}

/// Whether four points lie in a plane, whatever their scale.
pub(crate) fn flat(points: [tetrascope_core::glam::DVec3; 4]) -> bool {
    let edges = [1, 2, 3].map(|i| points[i] - points[0]);
    let scale = edges
        .iter()
        .map(|e| e.abs().max_element())
        .fold(0.0, f64::max);
    let [a, b, c] = edges.map(|e| e / scale);
    scale == 0.0 || a.dot(b.cross(c)) == 0.0
}
