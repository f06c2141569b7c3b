//! The mesh in three textures (the paper's section 4.1 and figure 8): 144 bytes per cell.

use tetrascope_core::glam::{DVec3, Vec3};
use tetrascope_core::mesh::{Association, FACES, NO_NEIGHBOR};
use tetrascope_core::{Error, TetMesh};
use tetrascope_f32::layout::{cell_order, inverse};
use tetrascope_f32::{Domain, Normalization, ScalarMap, longest_edge};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::memory::texture_bytes;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};

use super::orientation::{exchanged, ordered};
use crate::options::{Crossings, RaycastOptions};
use crate::single::TRANSPARENT_SCALAR;

/// Texels of one cell in each texture.
const CELL_TEXELS: u32 = 3;

/// One texel.
type Texel = [f32; 4];

/// In place of a neighbor where there is none, as in `rays.wgsl`.
const OUTSIDE: f32 = -1.0;

/// Where each cell lies in the textures: row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Packing {
    /// Cells a row.
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl Packing {
    /// Textures about as wide as high for `cells` cells, at most `limit` texels per side.
    pub(super) fn new(cells: usize, limit: u32) -> Result<Packing, Error> {
        let cells = cells.max(1) as u64;
        let widest = u64::from(limit / CELL_TEXELS).max(1);
        let square = (cells as f64 / f64::from(CELL_TEXELS)).sqrt().ceil() as u64;
        // Wider only where square is too high.
        let columns = square.max(cells.div_ceil(limit.into())).min(widest);
        let rows = cells.div_ceil(columns);
        if rows > limit.into() {
            return Err(Error::TooLarge {
                what: "the mesh in textures".into(),
                needed: cells,
                limit: widest * u64::from(limit),
                unit: "cells",
            });
        }
        Ok(Packing {
            columns: columns as u32,
            rows: rows as u32,
        })
    }

    /// (t_u, t_v) of a cell.
    pub(super) fn texel(&self, cell: u32) -> [f32; 2] {
        let column = cell % self.columns;
        // Exact: no texture has 2²⁴ texels per side.
        [(CELL_TEXELS * column) as f32, (cell / self.columns) as f32]
    }

    fn size(&self) -> (u32, u32) {
        (CELL_TEXELS * self.columns, self.rows)
    }

    /// Room for all three texels of every cell.
    fn texels(&self) -> Vec<Texel> {
        let (width, height) = self.size();
        vec![[0.0; 4]; width as usize * height as usize]
    }
}

/// A corner of a boundary face as the rasterizer gets it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct BoundaryCorner {
    /// Normalized.
    position: [f32; 3],
    /// (t_u, t_v) of the cell behind the face.
    cell: [f32; 2],
}

impl BoundaryCorner {
    pub(super) const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: size_of::<BoundaryCorner>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2],
    };
}

/// A boundary face as it is drawn where rays cross by sides.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct BoundaryFace {
    /// (t_u, t_v) of the cell behind the face.
    cell: [f32; 2],
    /// The corner of the cell that is not the face's.
    opposite: f32,
}

impl BoundaryFace {
    pub(super) const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: size_of::<BoundaryFace>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![1 => Float32x3],
    };
}

/// The boundary's faces as the rasterizer gets them.
#[derive(Clone, Debug)]
pub(super) enum Boundary {
    /// Three corners each.
    Corners(wgpu::Buffer, u32),
    /// By increasing cell, with the corners, normalized, from which a frame's rectangles come.
    Faces(wgpu::Buffer, Vec<[Vec3; 3]>),
}

impl Boundary {
    fn new(
        gpu: &Gpu,
        mesh: &TetMesh,
        normalization: &Normalization,
        packing: &Packing,
        cell_order: &[u32],
        exchanged: Option<&[bool]>,
    ) -> Result<Boundary, Error> {
        let label = "ping-pong::boundary";
        match exchanged {
            None => {
                let corners = boundary_corners(mesh, normalization, packing, cell_order);
                let buffer = gpu.upload(label, &corners, BufferUsages::VERTEX)?;
                Ok(Boundary::Corners(buffer, corners.len() as u32))
            }
            Some(exchanged) => {
                let cell_at = inverse(cell_order);
                let mut faces = mesh.boundary_faces().to_vec();
                faces.sort_by_key(|&(cell, _)| cell_at[cell as usize]);
                let drawn: Vec<BoundaryFace> = faces
                    .iter()
                    .map(|&(cell, opposite)| BoundaryFace {
                        cell: packing.texel(cell_at[cell as usize]),
                        opposite: ordered(exchanged[cell as usize], [0.0, 1.0, 2.0, 3.0])
                            [usize::from(opposite)],
                    })
                    .collect();
                let corners = faces.iter().map(|&(cell, opposite)| {
                    let points = corners(mesh, normalization, cell);
                    FACES[usize::from(opposite)].map(|corner| points[corner].as_vec3())
                });
                let corners = corners.collect();
                let buffer = gpu.upload(label, &drawn, BufferUsages::VERTEX)?;
                Ok(Boundary::Faces(buffer, corners))
            }
        }
    }

    fn bytes(&self) -> u64 {
        match self {
            Boundary::Corners(buffer, _) | Boundary::Faces(buffer, _) => buffer.size(),
        }
    }
}

/// The data that `reload` changes.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    pub(super) source: TetMesh,
    pub(super) domain: Domain,
    pub(super) normalization: Normalization,
    pub(super) scalar_map: ScalarMap,
    /// No ray is longer in a cell than this, normalized.
    pub(super) longest_edge: f32,
    packing: Packing,
    /// The mesh's own number of each cell.
    cell_order: Vec<u32>,
    vertices: wgpu::Texture,
    normals: wgpu::Texture,
    neighbors: wgpu::Texture,
    pub(super) boundary: Boundary,
    /// Whether the last two corners of each of the mesh's cells are, where rays cross by sides.
    exchanged: Option<Vec<bool>>,
}

impl Mesh {
    pub(super) fn new(
        gpu: &Gpu,
        source: &TetMesh,
        domain: Domain,
        scalar_map: ScalarMap,
        options: &RaycastOptions,
    ) -> Result<Mesh, Error> {
        let normalization = Normalization::of(&domain.bounds);
        let limit = gpu.limits().max_texture_dimension_2d;
        let packing = Packing::new(source.cell_count(), limit)?;
        let cell_order = cell_order(source, options.locality);
        let exchanged = match options.crossings {
            Crossings::Planes => None,
            Crossings::Sides => Some(exchanged(source)),
        };
        let of_cells = exchanged.as_deref();
        let geometry = Geometry::new(source, &normalization, &packing, &cell_order, of_cells);
        let texture = |label, size| texture(gpu, label, size);
        // Sides need no normals: a texel that nobody reads.
        let normals_size = match exchanged {
            None => packing.size(),
            Some(_) => (1, 1),
        };
        let mesh = Mesh {
            longest_edge: longest_edge(source, &normalization),
            vertices: texture("ping-pong::vertices", packing.size())?,
            normals: texture("ping-pong::normals", normals_size)?,
            neighbors: texture("ping-pong::neighbors", packing.size())?,
            boundary: Boundary::new(gpu, source, &normalization, &packing, &cell_order, of_cells)?,
            exchanged,
            source: source.clone(),
            domain,
            normalization,
            scalar_map,
            packing,
            cell_order,
        };
        write(gpu, &mesh.vertices, &geometry.vertices)?;
        if mesh.exchanged.is_none() {
            write(gpu, &mesh.normals, &geometry.normals)?;
        }
        mesh.write_scalars(gpu)?;
        Ok(mesh)
    }

    /// The same geometry with other scalars, or with the same in another unit.
    pub(super) fn with_scalars(
        &self,
        gpu: &Gpu,
        source: &TetMesh,
        domain: Domain,
        scalar_map: ScalarMap,
    ) -> Result<Mesh, Error> {
        let mesh = Mesh {
            source: source.clone(),
            domain,
            scalar_map,
            neighbors: texture(gpu, "ping-pong::neighbors", self.packing.size())?,
            ..self.clone()
        };
        mesh.write_scalars(gpu)?;
        Ok(mesh)
    }

    /// Uploads the one texture in which gradients and scalars are.
    fn write_scalars(&self, gpu: &Gpu) -> Result<(), Error> {
        let texels = neighbor_texels(
            &self.source,
            &self.normalization,
            &self.scalar_map,
            &self.packing,
            &self.cell_order,
            self.exchanged.as_deref(),
        );
        write(gpu, &self.neighbors, &texels)
    }

    /// Vertices, normals, neighbors.
    pub(super) fn textures(&self) -> [&wgpu::Texture; 3] {
        [&self.vertices, &self.normals, &self.neighbors]
    }

    pub(super) fn bytes(&self) -> u64 {
        let textures = self.textures().into_iter().map(texture_bytes);
        textures.sum::<u64>() + self.boundary.bytes()
    }

    /// The cell with `eye`, normalized, in it: its (t_u, t_v) and the scalar there.
    pub(super) fn cell_around(&self, eye: DVec3) -> Option<([f32; 2], f32)> {
        // Vertices lie within 1 of the center.
        if eye.abs().max_element() > 1.0 {
            return None;
        }
        let place = (0..self.cell_order.len()).find(|&place| {
            let points = corners(&self.source, &self.normalization, self.cell_order[place]);
            contains(&points, eye)
        })?;
        let cell = self.cell_order[place];
        let points = corners(&self.source, &self.normalization, cell);
        let field = linear(&self.source, &self.scalar_map, cell, &points);
        let scalar = field.gradient.dot(eye.as_vec3()) + field.at_origin;
        Some((self.packing.texel(place as u32), scalar))
    }
}

fn texture(gpu: &Gpu, label: &str, size: (u32, u32)) -> Result<wgpu::Texture, Error> {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    gpu.texture(label, size, TextureFormat::Rgba32Float, usage)
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, texels: &[Texel]) -> Result<(), Error> {
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    gpu.checked("the mesh in textures", bytes.len() as u64, || {
        gpu.queue().write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(texture.width() * size_of::<Texel>() as u32),
                rows_per_image: None,
            },
            texture.size(),
        );
    })
}

/// The corners of a cell, normalized.
fn corners(mesh: &TetMesh, normalization: &Normalization, cell: u32) -> [DVec3; 4] {
    mesh.cell_points(cell as usize)
        .map(|point| normalization.point(point))
}

fn contains(points: &[DVec3; 4], eye: DVec3) -> bool {
    let [a, b, c, d] = *points;
    let has_volume = (b - a).cross(c - a).dot(d - a) != 0.0;
    has_volume
        && FACES.iter().all(|&face| {
            let [a, b, c] = face.map(|corner| points[corner]);
            (b - a).cross(c - a).dot(eye - a) <= 0.0
        })
}

/// Vertices and outward normals as figure 8 has them.
struct Geometry {
    vertices: Vec<Texel>,
    normals: Vec<Texel>,
}

impl Geometry {
    fn new(
        mesh: &TetMesh,
        normalization: &Normalization,
        packing: &Packing,
        cell_order: &[u32],
        exchanged: Option<&[bool]>,
    ) -> Geometry {
        let mut vertices = packing.texels();
        let mut normals = packing.texels();
        let places = vertices.chunks_mut(3).zip(normals.chunks_mut(3));
        for ((vertices, normals), &cell) in places.zip(cell_order) {
            let points = corners(mesh, normalization, cell);
            // Of the rounded points, as the planes go through those.
            let is_exchanged = exchanged.is_some_and(|is| is[cell as usize]);
            let rounded = ordered(is_exchanged, points.map(|p| p.as_vec3()));
            vertices.copy_from_slice(&interleaved(rounded));
            normals.copy_from_slice(&interleaved(FACES.map(|face| {
                let [a, b, c] = face.map(|corner| rounded[corner].as_dvec3());
                (b - a).cross(c - a).normalize_or_zero().as_vec3()
            })));
        }
        Geometry { vertices, normals }
    }
}

/// The fourth vector in the fourth components of the other three.
fn interleaved([a, b, c, d]: [Vec3; 4]) -> [Texel; 3] {
    [
        a.extend(d.x).to_array(),
        b.extend(d.y).to_array(),
        c.extend(d.z).to_array(),
    ]
}

fn neighbor_texels(
    mesh: &TetMesh,
    normalization: &Normalization,
    scalar_map: &ScalarMap,
    packing: &Packing,
    cell_order: &[u32],
    exchanged: Option<&[bool]>,
) -> Vec<Texel> {
    let cell_at = inverse(cell_order);
    let mut texels = packing.texels();
    for (texels, &cell) in texels.chunks_mut(3).zip(cell_order) {
        let is_exchanged = exchanged.is_some_and(|is| is[cell as usize]);
        let neighbors = ordered(is_exchanged, mesh.neighbors()[cell as usize]);
        let [a, b, c, d] = neighbors.map(|neighbor| {
            if neighbor == NO_NEIGHBOR {
                [OUTSIDE; 2]
            } else {
                packing.texel(cell_at[neighbor as usize])
            }
        });
        let scalars = match exchanged {
            None => {
                let points = corners(mesh, normalization, cell);
                let field = linear(mesh, scalar_map, cell, &points);
                field.gradient.extend(field.at_origin).to_array()
            }
            Some(_) => {
                let scalars = ordered(is_exchanged, mesh.cell_scalars(cell as usize));
                scalars.map(|s| match s {
                    s if s.is_nan() => TRANSPARENT_SCALAR,
                    s => scalar_map.scalar(s),
                })
            }
        };
        texels.copy_from_slice(&[[a[0], a[1], b[0], b[1]], [c[0], c[1], d[0], d[1]], scalars]);
    }
    texels
}

/// The scalar in a cell as a linear function of the place.
struct Linear {
    gradient: Vec3,
    at_origin: f32,
}

fn linear(mesh: &TetMesh, map: &ScalarMap, cell: u32, points: &[DVec3; 4]) -> Linear {
    let scalars = mesh.cell_scalars(cell as usize);
    if scalars.iter().any(|s| s.is_nan()) {
        return Linear {
            gradient: Vec3::ZERO,
            at_origin: TRANSPARENT_SCALAR,
        };
    }
    // Clamped as mapped scalars are everywhere.
    let scalars = scalars.map(|s| f64::from(map.scalar(s)));
    let gradient = match mesh.scalars().association {
        Association::Cell => DVec3::ZERO,
        Association::Point => gradient(points, &scalars),
    };
    let limit = DVec3::splat(1e30);
    let gradient = gradient.clamp(-limit, limit);
    Linear {
        gradient: gradient.as_vec3(),
        at_origin: (scalars[0] - gradient.dot(points[0])).clamp(-1e33, 1e33) as f32,
    }
}

/// The gradient of the linear function with `scalars` at `points`, normalized.
///
/// In a flat cell, the least one that agrees with the scalars in the cell's plane. A cell
/// is flat if it is thinner than f32 resolves a place on a ray, 2⁻²²: there the
/// gradient across it would add more error than leaving it out does.
fn gradient(points: &[DVec3; 4], scalars: &[f64; 4]) -> DVec3 {
    const FLAT: f64 = 1.0 / (1 << 22) as f64;
    let mut edges = [1, 2, 3].map(|i| (points[i] - points[0], scalars[i] - scalars[0]));
    let mut gradient = DVec3::ZERO;
    // Gram and Schmidt, the longest first; what was used becomes zero.
    for _ in 0..3 {
        let longest = |a: &(DVec3, f64), b: &(DVec3, f64)| {
            a.0.length_squared().total_cmp(&b.0.length_squared())
        };
        let (edge, rise) = edges.into_iter().max_by(longest).expect("three edges");
        let length = edge.length();
        if length <= FLAT {
            break;
        }
        let axis = edge / length;
        let slope = rise / length;
        gradient += slope * axis;
        for (edge, rise) in &mut edges {
            let along = edge.dot(axis);
            *edge -= along * axis;
            *rise -= along * slope;
        }
    }
    gradient
}

fn boundary_corners(
    mesh: &TetMesh,
    normalization: &Normalization,
    packing: &Packing,
    cell_order: &[u32],
) -> Vec<BoundaryCorner> {
    let cell_at = inverse(cell_order);
    let faces = mesh.boundary_faces().iter();
    faces
        .flat_map(|&(cell, opposite)| {
            let points = corners(mesh, normalization, cell);
            FACES[usize::from(opposite)].map(|corner| BoundaryCorner {
                position: points[corner].as_vec3().to_array(),
                cell: packing.texel(cell_at[cell as usize]),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_takes_144_bytes() {
        for cells in [1, 2, 1000, 187_395, 80_000_000] {
            let packing = Packing::new(cells, 16384).expect("fits");
            let (width, height) = packing.size();
            let bytes = 3 * 16 * u64::from(width) * u64::from(height);
            let whole = 144 * cells as u64;
            // The last row may be short of cells.
            assert!(
                bytes >= whole && bytes < whole + 144 * u64::from(packing.columns),
                "{cells}"
            );
            assert!(width <= 16384 && height <= 16384);
        }
        assert!(Packing::new(5461 * 16384 + 1, 16384).is_err());
    }

    #[test]
    fn cells_are_found_where_they_were_put() {
        let packing = Packing::new(1000, 64).expect("fits");
        let mut seen = std::collections::HashSet::new();
        for cell in 0..1000 {
            let [u, v] = packing.texel(cell);
            let (width, height) = packing.size();
            assert!(u + 2.0 < width as f32 && v < height as f32 && u % 3.0 == 0.0);
            assert!(seen.insert([u as u32, v as u32]));
        }
    }

    #[test]
    fn gradients_are_those_of_the_field() {
        let field = DVec3::new(0.3, -0.2, 0.5);
        let points = [
            DVec3::new(0.1, 0.2, 0.3),
            DVec3::new(0.4, 0.2, 0.3),
            DVec3::new(0.2, 0.6, 0.1),
            DVec3::new(0.1, 0.1, 0.9),
        ];
        let found = gradient(&points, &points.map(|p| 2.0 + field.dot(p)));
        assert!((found - field).length() < 1e-14, "{found}");
        // Two corners in one place, as in the blunt fin: the part in the plane is left.
        let flat = [points[0], points[1], points[2], points[2]];
        let found = gradient(&flat, &flat.map(|p| 2.0 + field.dot(p)));
        for edge in [flat[1] - flat[0], flat[2] - flat[0]] {
            assert!((found - field).dot(edge).abs() < 1e-14, "{found}");
        }
        assert_eq!(
            gradient(&[points[0]; 4], &[1.0, 2.0, 3.0, 4.0]),
            DVec3::ZERO
        );
    }
}
