//! The mesh in the grid's own units, as `mesh.wgsl` sees it.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh, is_value};

use crate::NAME;
use crate::gpu_data::Vertex;

/// A scalar that stands for none; `NO_VALUE` of `mesh.wgsl` is below.
const NO_SCALAR: f32 = f32::MAX;

/// Farther away than this, in samples, products of places would not fit 32-bit floats: their
/// fourth power does.
const FARTHEST: f64 = (1u64 << 31) as f64;

/// A point that no cell names.
const UNUSED: Vertex = Vertex {
    sample: [0.0; 3],
    key: 0,
    offset: [0.0; 3],
    scalar: NO_SCALAR,
};

/// The data that are uploaded of a mesh, beside its cells.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) vertices: Vec<Vertex>,
    /// One for each cell; empty for a field of points.
    pub(crate) cell_scalars: Vec<f32>,
    /// The least and greatest scalar, as 32-bit floats have them.
    pub(crate) scalar_range: Option<(f64, f64)>,
}

/// The axis along which columns run: the longest, the first of them.
pub(crate) fn along(lattice: &Lattice) -> usize {
    let [x, y, z] = lattice.dims;
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Refuses a mesh without volume.
pub(crate) fn check_volume(mesh: &TetMesh) -> Result<(), Error> {
    match mesh.cell_count() == 0 || mesh.bounds().size().cmple(DVec3::ZERO).any() {
        true => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes without volume".into(),
            reason: "there is nothing to take samples of".into(),
        }),
        false => Ok(()),
    }
}

impl Placed {
    /// Places `mesh` in `lattice`, which is valid, with `axis` along columns.
    ///
    /// # Errors
    /// A mesh without volume, and one that is too far away, or too large, for its samples.
    pub(crate) fn new(mesh: &TetMesh, lattice: &Lattice, axis: usize) -> Result<Placed, Error> {
        check_volume(mesh)?;
        let from_world = lattice.linear().inverse();
        let farthest = lattice.corners().map(|corner| corner.abs().max_element());
        let farthest = farthest.into_iter().fold(0.0, f64::max);
        let is_finite = from_world.is_finite() && farthest.is_finite();
        let place = |point: DVec3| from_world * (point - lattice.origin);
        let turn = |v: DVec3| match axis {
            0 => DVec3::new(v.y, v.z, v.x),
            1 => DVec3::new(v.z, v.x, v.y),
            _ => v,
        };
        let points = mesh.points();
        let values = &mesh.scalars().values;
        let of_points = mesh.scalars().association == Association::Point;
        // Points that no cell uses may be anywhere, and their values anything.
        let mut is_used = vec![false; points.len()];
        for &point in mesh.tetrahedra().iter().flatten() {
            is_used[point as usize] = true;
        }
        let mut is_near = true;
        let vertex = |(index, point): (usize, &DVec3)| {
            if !is_used[index] {
                return UNUSED;
            }
            let place = turn(place(*point));
            is_near &= place.abs().max_element() <= FARTHEST;
            let sample = place.round();
            Vertex {
                sample: sample.as_vec3().to_array(),
                key: key(place),
                // A sample far away is not a float: what that leaves counts as well.
                offset: (place - sample.as_vec3().as_dvec3()).as_vec3().to_array(),
                scalar: if of_points {
                    stored(values[index])
                } else {
                    0.0
                },
            }
        };
        let vertices: Vec<Vertex> = points.iter().enumerate().map(vertex).collect();
        if !(is_finite && is_near) {
            return Err(Error::invalid(format!(
                "the mesh reaches {FARTHEST:e} samples from the grid's first sample, or farther"
            )));
        }
        let cell_scalars: Vec<f32> = match of_points {
            true => Vec::new(),
            false => {
                let cells = 0..mesh.cell_count();
                cells.map(|c| stored(values[mesh.source_cell(c)])).collect()
            }
        };
        let scalars: Box<dyn Iterator<Item = f32>> = match of_points {
            true => Box::new(vertices.iter().map(|v| v.scalar)),
            false => Box::new(cell_scalars.iter().copied()),
        };
        let range = scalars.filter(|s| *s < NO_SCALAR).fold(None, widened);
        Ok(Placed {
            vertices,
            cell_scalars,
            scalar_range: range.map(|(low, high)| (low.into(), high.into())),
        })
    }
}

fn widened(range: Option<(f32, f32)>, scalar: f32) -> Option<(f32, f32)> {
    let (low, high) = range.unwrap_or((scalar, scalar));
    Some((low.min(scalar), high.max(scalar)))
}

fn stored(scalar: f64) -> f32 {
    if is_value(scalar) {
        scalar as f32
    } else {
        NO_SCALAR
    }
}

/// A number that is the same for the same place, and seldom for others (Steele, Lea, Flood
/// 2014, the mixing of SplitMix64).
fn key(place: DVec3) -> u32 {
    let mix = |mut h: u64| {
        h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^ (h >> 31)
    };
    // Zeros of both signs are one place.
    let bits = (place + DVec3::ZERO).to_array().map(f64::to_bits);
    let mixed = bits.into_iter().fold(0, |h: u64, b| mix(h ^ b));
    (mixed >> 32) as u32
}
