//! Twelve vertices per cell, three for each face (§6), in 32 and in 16 bits.
//!
//! Each has the plane of the face opposite in three numbers (equation 4), where to put its
//! ray parameter, one adjacent face's normal (§4.3), and what is the same for the whole
//! cell. Offsets are of the plane whose normal the shader decodes, so that rounding tilts
//! a plane and does not move it.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::FACES;
use tetrascope_core::{Error, TetMesh};
use tetrascope_f32::{Normalization, ScalarMap};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, BufferUsages};

use crate::options::CellLayout;

/// The buffers that `faces_floats.wgsl` and `faces_shorts.wgsl` call `placed` and `shaped`.
pub(crate) type Buffers = [wgpu::Buffer; 2];

/// The vertices of all faces, or nothing where cells share theirs.
///
/// `range` is that of the scalars in `map`.
pub(crate) fn upload(
    gpu: &Gpu,
    mesh: &TetMesh,
    normalization: &Normalization,
    (map, range): (&ScalarMap, (f32, f32)),
    layout: CellLayout,
) -> Result<Option<Buffers>, Error> {
    let mut placed: Vec<f32> = Vec::new();
    let mut floats: Vec<f32> = Vec::new();
    let mut shorts: Vec<u16> = Vec::new();
    match layout {
        CellLayout::SharedVertices => return Ok(None),
        CellLayout::TwelveFloats => {
            for cell in 0..mesh.cell_count() {
                for vertex in vertices(mesh, cell, normalization, map) {
                    let [nx, ny] = [vertex.normal.x as f32, vertex.normal.y as f32];
                    let offset = vertex.offset([nx, ny].map(f64::from));
                    placed.extend(vertex.position.as_vec3().to_array());
                    placed.push(offset as f32);
                    placed.extend(vertex.gradient.as_vec3().to_array());
                    placed.push(vertex.scalar);
                    floats.extend([nx, ny, vertex.slot as f32, vertex.longest as f32]);
                    floats.extend(vertex.adjacent.as_vec3().to_array());
                }
            }
        }
        CellLayout::TwelveShorts => {
            for cell in 0..mesh.cell_count() {
                for vertex in vertices(mesh, cell, normalization, map) {
                    let normal = [vertex.normal.x, vertex.normal.y].map(snorm);
                    let decoded = normal.map(|n| f64::from(n) / 32767.0);
                    placed.extend(vertex.position.as_vec3().to_array());
                    placed.push(vertex.offset(decoded) as f32);
                    shorts.extend(normal.map(|n| n as u16));
                    shorts.extend(vertex.adjacent.to_array().map(|n| snorm(n) as u16));
                    shorts.push(vertex.slot as u16);
                    let width = range.1 - range.0;
                    let share = (vertex.scalar - range.0) / if width > 0.0 { width } else { 1.0 };
                    shorts.push((share * 65535.0).round() as u16);
                    // Up, as no segment is longer.
                    shorts.push(
                        ((vertex.longest as f32).to_bits().saturating_add(0xffff) >> 16) as u16,
                    );
                    shorts.extend(vertex.gradient.to_array().map(upper_half));
                }
            }
        }
    }
    let placed = gpu.upload("the faces' positions", &placed, BufferUsages::STORAGE)?;
    let shaped = "the faces' planes";
    let shaped = if shorts.is_empty() {
        gpu.upload(shaped, &floats, BufferUsages::STORAGE)?
    } else {
        gpu.upload(shaped, &shorts, BufferUsages::STORAGE)?
    };
    Ok(Some([placed, shaped]))
}

/// A vertex of a face, in normalized units.
struct FaceVertex {
    position: DVec3,
    /// Normal of the face opposite; z is not negative.
    normal: DVec3,
    /// A point of that face.
    opposite: DVec3,
    /// Which of the three parameters it has.
    slot: usize,
    adjacent: DVec3,
    longest: f64,
    gradient: DVec3,
    scalar: f32,
}

impl FaceVertex {
    /// normal · x on the face opposite, with the normal that has these two components.
    fn offset(&self, [x, y]: [f64; 2]) -> f64 {
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        DVec3::new(x, y, z).dot(self.opposite)
    }
}

fn vertices(
    mesh: &TetMesh,
    cell: usize,
    normalization: &Normalization,
    map: &ScalarMap,
) -> [FaceVertex; 12] {
    let points = mesh.cell_points(cell);
    let points = points.map(|p| normalization.position(p).as_dvec3());
    let scalars: [f64; 4] = mesh.cell_scalars(cell);
    let scalars = scalars.map(|s| map.scalar(s));
    let normals = FACES.map(|face| {
        let [a, b, c] = face.map(|i| points[i]);
        (b - a).cross(c - a).normalize_or_zero()
    });
    let [a, b, c] = [1, 2, 3].map(|i| points[i] - points[0]);
    let [f, g, h] = [1, 2, 3].map(|i| f64::from(scalars[i] - scalars[0]));
    let volume = a.dot(b.cross(c));
    let gradient = f * b.cross(c) + g * c.cross(a) + h * a.cross(b);
    let gradient = if volume == 0.0 {
        DVec3::ZERO
    } else {
        gradient / volume
    };
    let lengths = [a, b, c, b - a, c - a, c - b].map(|e| e.length());
    let longest = lengths.into_iter().fold(0.0, f64::max);
    std::array::from_fn(|i| {
        let (face, slot) = (FACES[i / 3], i % 3);
        let own = face[slot];
        let normal = normals[own];
        FaceVertex {
            position: points[own],
            normal: if normal.z < 0.0 { -normal } else { normal },
            opposite: FACES[own].map(|i| points[i]).iter().sum::<DVec3>() / 3.0,
            slot,
            adjacent: normals[face[(slot + 2) % 3]],
            longest,
            gradient,
            scalar: scalars[own],
        }
    })
}

/// A number in [−1, 1], as WGSL's `unpack2x16snorm` reads it.
fn snorm(x: f64) -> i16 {
    (x.clamp(-1.0, 1.0) * 32767.0).round() as i16
}

/// The upper 16 bits of an f32, rounded to nearest.
fn upper_half(x: f64) -> u16 {
    let x = (x as f32).clamp(-1e38, 1e38);
    ((x.to_bits() + 0x8000) >> 16) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_keep_eight_digits_of_two() {
        for x in [0.0, 1.0, -3.25, 1e-20, 7.7e30] {
            let back = f32::from_bits(u32::from(upper_half(x)) << 16);
            // Half of the last of 8 bits.
            assert!((f64::from(back) - x).abs() <= x.abs() / 256.0, "{x} {back}");
        }
        assert_eq!(
            [snorm(1.0), snorm(-1.0), snorm(2.0)],
            [32767, -32767, 32767]
        );
    }
}
