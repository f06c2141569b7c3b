//! The mesh on the device: geometry, and scalars.

use std::sync::{Arc, OnceLock};

use tetrascope_core::glam::Vec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh, Volume};
use tetrascope_f32::{Domain, Normalization, ScalarMap, longest_edge};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};

use crate::mpvo::Shape;
use crate::options::CellLayout;
use crate::{NAME, faces};

const STORAGE: BufferUsages = BufferUsages::STORAGE;

/// Texels a row of the vertices, as in `vertices.wgsl`.
const VERTICES_PER_ROW: u32 = 2048;

/// Camera space and scalar of a vertex.
pub(crate) const TRANSFORMED_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// The size of a texture with `count` items, `per_row` in each row.
pub(crate) fn texels(count: usize, per_row: u32) -> (u32, u32) {
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
    /// The same of each cell, 0 where it has no volume.
    pub(crate) longest_edges: Arc<[f32]>,
    /// Centers of all cells, for orders that are made on the CPU; made when first needed.
    pub(crate) centers: Arc<OnceLock<Arc<[Vec3]>>>,
    pub(crate) shape: Arc<OnceLock<Arc<Shape>>>,
    /// Why an order by faces may be wrong whatever the view, found when it is first asked for.
    pub(crate) unproven: Arc<OnceLock<Option<String>>>,
    /// The vertices in camera space, once a frame has begun.
    pub(crate) transformed: wgpu::Texture,
}

/// Scalars on the device.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) map: ScalarMap,
    pub(crate) per_cell: bool,
    pub(crate) scalars: wgpu::Buffer,
    /// The least and the greatest of each cell, NaN if one is.
    pub(crate) extents: Arc<[[f32; 2]]>,
    /// The vertices of faces, where cells do not share theirs.
    pub(crate) faces: Option<faces::Buffers>,
    /// The least and the greatest of the domain.
    pub(crate) range: (f32, f32),
}

/// The mesh of `volume`, or why there is none.
pub(crate) fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        Volume::Clusters(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes in clusters".into(),
            reason: "it needs all cells at once".into(),
        }),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it projects the cells of a tetrahedral mesh".into(),
        }),
    }
}

impl Geometry {
    pub(crate) fn upload(gpu: &Gpu, mesh: &TetMesh, domain: Domain) -> Result<Geometry, Error> {
        // Four vertices per cell are numbered in 32 bits.
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
        // Of four times one vertex where there is no volume.
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
            longest_edges: longest_edges(&positions, &cells),
            centers: Arc::default(),
            shape: Arc::default(),
            unproven: Arc::default(),
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
            extents: extents(mesh, &scalars, per_cell),
            scalars: gpu.upload("the mesh's scalars", &scalars, STORAGE)?,
        })
    }
}

/// The longest edge of each of `cells`, of which those without volume are four times one vertex.
fn longest_edges(positions: &[[f32; 3]], cells: &[[u32; 4]]) -> Arc<[f32]> {
    const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let longest = |cell: &[u32; 4]| {
        let corners = cell.map(|vertex| Vec3::from_array(positions[vertex as usize]));
        let squares = EDGES.map(|[a, b]| corners[a].distance_squared(corners[b]));
        squares.into_iter().fold(0.0, f32::max).sqrt()
    };
    cells.iter().map(longest).collect()
}

/// The least and the greatest of the scalars of each cell, NaN if one is.
fn extents(mesh: &TetMesh, scalars: &[f32], per_cell: bool) -> Arc<[[f32; 2]]> {
    if per_cell {
        return scalars.iter().map(|scalar| [*scalar; 2]).collect();
    }
    let extent = |cell: &[u32; 4]| {
        let corners = cell.map(|vertex| scalars[vertex as usize]);
        match corners.iter().any(|scalar| scalar.is_nan()) {
            true => [f32::NAN; 2],
            false => [
                corners.into_iter().fold(f32::INFINITY, f32::min),
                corners.into_iter().fold(f32::NEG_INFINITY, f32::max),
            ],
        }
    };
    mesh.tetrahedra().iter().map(extent).collect()
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
