//! The mesh on the device, and which of its cells can show.

use std::sync::Arc;

use bytemuck::Zeroable;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Appearance, Error, TetMesh, Volume};
use tetrascope_f32::{
    ANY_SCALAR, Domain, KnotPair, Normalization, ScalarMap, deepest, longest_edge,
};
use tetrascope_gpu::passes::look_constants;
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration};

use crate::options::CellLayout;
use crate::passes::cull::{Culled, Judged, cull};
use crate::{NAME, faces};

const STORAGE: BufferUsages = BufferUsages::STORAGE;

/// Texels a row of the vertices, as in `vertices.wgsl`.
const VERTICES_PER_ROW: u32 = 2048;

/// Camera space and scalar of a vertex.
pub(crate) const TRANSFORMED_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// Intervals a row of the transfer function, three texels each, as in `transfer.wgsl`.
const INTERVALS_PER_ROW: u32 = 256;

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
    pub(crate) domain: Domain,
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
    /// The least and the greatest of the domain.
    pub(crate) range: (f32, f32),
}

/// The transfer function on the device, and what it leaves to draw.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    pub(crate) intervals: wgpu::Texture,
    /// Constants of shaders for clip planes and depth cue.
    pub(crate) extras: [(&'static str, f64); 2],
    pub(crate) interval_count: usize,
    pub(crate) culled: Arc<Culled>,
    pub(crate) table: Table,
    pub(crate) listed: Listed,
    /// A bound of the optical depth of any segment.
    pub(crate) deepest: f32,
    /// The same where cells are drawn whole.
    deepest_of_cells: f32,
}

/// What an order that is made on the CPU has to know of the cells that are drawn; empty for
/// others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Listed {
    /// Their indices.
    pub(crate) cells: Arc<[u32]>,
    /// The first piece of each of the mesh's cells, and the end of the last, where cells are
    /// drawn in pieces.
    starts: Option<Arc<[u32]>>,
}

/// What makes a [`Look`].
pub(crate) struct Looked<'a> {
    pub(crate) appearance: &'a Appearance,
    pub(crate) integration: Integration,
    /// The last look's, that is kept if nothing in it changes.
    pub(crate) table: Option<&'a Table>,
    /// Whether cells are drawn in pieces, one for each interval of the transfer function
    /// (`pieces.wgsl`), if there are not too many.
    pub(crate) pieces: bool,
    /// Whether the CPU has to know which.
    pub(crate) listed: bool,
    /// Whether scalars come from a cell's gradient, which may lead beyond those of its corners.
    pub(crate) extrapolates: bool,
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
    pub(crate) fn upload(gpu: &Gpu, mesh: &TetMesh, domain: Domain) -> Result<Geometry, Error> {
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
        let normalization = Normalization::of(&domain.bounds);
        let positions: Vec<[f32; 3]> = mesh
            .points()
            .iter()
            .map(|p| normalization.position(*p).to_array())
            .collect();
        // Of four times one vertex where there is no volume, for `judge.wgsl`.
        let solid =
            |(cell, corners): (usize, &[u32; 4])| match has_no_volume(mesh.cell_points(cell)) {
                true => [corners[0]; 4],
                false => *corners,
            };
        let cells: Vec<[u32; 4]> = mesh.tetrahedra().iter().enumerate().map(solid).collect();
        Ok(Geometry {
            mesh: mesh.clone(),
            domain,
            normalization,
            positions: gpu.upload("the mesh's vertices", &positions, STORAGE)?,
            cells: gpu.upload("the mesh's cells", &cells, STORAGE)?,
            longest: longest_edge(mesh, &normalization),
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
        let range = map.range(geometry.domain.scalar_range);
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

impl Listed {
    /// The items of `cells`, in their order.
    pub(crate) fn items_of(&self, cells: Vec<u32>) -> Vec<u32> {
        let Some(starts) = &self.starts else {
            return cells;
        };
        let pieces = |cell: u32| starts[cell as usize]..starts[cell as usize + 1];
        cells.into_iter().flat_map(pieces).collect()
    }
}

impl Look {
    pub(crate) fn upload(
        gpu: &Gpu,
        geometry: &Geometry,
        field: &Field,
        looked: &Looked,
    ) -> Result<Look, Error> {
        let (appearance, map) = (looked.appearance, &field.map);
        let tf = &appearance.transfer_function;
        let mut intervals: Vec<KnotPair> = knot_pairs(tf, map, &geometry.normalization)?;
        let source = preintegration::Source {
            integration: looked.integration,
            model: appearance.optical_model,
            intervals: &intervals,
            longest: geometry.longest,
            fixed: None,
        };
        let table = match looked.table {
            Some(table) => table.renewed(gpu, NAME, &source)?,
            None => Table::new(gpu, NAME, &source)?,
        };
        let isovalues = appearance.isosurfaces.iter();
        let isovalues: Vec<f32> = isovalues.map(|s| map.scalar(s.value)).collect();
        let culled = cull(
            gpu,
            &Judged {
                geometry,
                field,
                model: appearance.optical_model,
                intervals: &intervals,
                isovalues: &isovalues,
                pieces: looked.pieces,
            },
        )?;
        let mut listed = Listed::default();
        if looked.listed {
            let (cells, starts) = culled.read(gpu, geometry.mesh.cell_count())?;
            listed = Listed {
                cells: cells.into(),
                starts: starts.map(Arc::from),
            };
        }
        let scalars = match looked.extrapolates {
            true => ANY_SCALAR,
            false => field.range,
        };
        let deepest_of_cells = deepest(&intervals, scalars, geometry.longest);
        let deepest = match culled.in_parts {
            true => 1.0,
            false => deepest_of_cells,
        };
        let interval_count = intervals.len();
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
            culled: Arc::new(culled),
            listed,
            deepest,
            deepest_of_cells,
        })
    }

    /// The same with cells that are drawn whole; the CPU must know which.
    pub(crate) fn whole(&self, gpu: &Gpu) -> Result<Look, Error> {
        Ok(Look {
            culled: Arc::new(self.culled.whole(gpu, &self.listed.cells)?),
            deepest: self.deepest_of_cells,
            ..self.clone()
        })
    }
}

/// Whether a cell is flat in the mesh's own coordinates.
pub(crate) fn has_no_volume([p0, p1, p2, p3]: [tetrascope_core::glam::DVec3; 4]) -> bool {
    let volume = (p1 - p0).dot((p2 - p0).cross(p3 - p0));
    // Not `== 0` alone: products of tiny edges may underflow in a cell that has a volume.
    volume == 0.0 && flat([p0, p1, p2, p3])
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
