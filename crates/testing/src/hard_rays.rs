//! Rays aimed at what breaks walks from cell to cell: vertices, edges, along faces, in meshes whose
//! cells are flat or inverted.
//!
//! The meshes are those on which published walks were measured to lose up to all rays
//! along an axis: cubes of six tetrahedra, exact or jittered, near and far from the
//! origin, and in layers so thin that jitter turns cells inside out.

use tetrascope_core::TetMesh;
use tetrascope_core::glam::{DVec3, Vec3};

use crate::{kuhn_cells, point_scalars};

/// Cubes along each side of a mesh.
const CUBES: usize = 3;

/// A sequence of numbers without pattern (Marsaglia 2003, xorshift).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    fn below(&mut self, count: usize) -> usize {
        self.bits() as usize % count
    }

    /// In [−1, 1].
    fn signed(&mut self) -> f64 {
        f64::from(self.bits()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    /// In [−1, 1]³.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// A kind of mesh that is hard to walk through.
#[derive(Clone, Copy, Debug)]
pub struct HardMesh {
    /// In words.
    pub name: &'static str,
    /// By how much vertices are moved, in cubes.
    pub jitter: f64,
    /// How far from the origin, in cubes.
    pub offset: f64,
    /// The thickness of every other layer, in cubes.
    pub thickness: f64,
    /// A cube in the middle is left out.
    pub cavity: bool,
    /// Seed of the random numbers by which vertices are moved.
    pub seed: u64,
}

const PLAIN: HardMesh = HardMesh {
    name: "structured",
    jitter: 0.0,
    offset: 0.0,
    thickness: 1.0,
    cavity: false,
    seed: 0x2545_f491_4f6c_dd1d,
};

/// All kinds.
pub const HARD_MESHES: [HardMesh; 9] = [
    PLAIN,
    HardMesh {
        name: "structured with a cavity",
        cavity: true,
        ..PLAIN
    },
    HardMesh {
        name: "jittered",
        jitter: 0.2,
        ..PLAIN
    },
    HardMesh {
        name: "jittered, at 1e5",
        jitter: 0.2,
        offset: 1e5,
        ..PLAIN
    },
    HardMesh {
        name: "structured, at 1e6",
        offset: 1e6,
        ..PLAIN
    },
    HardMesh {
        name: "jittered until cells turn inside out",
        jitter: 0.9,
        cavity: true,
        ..PLAIN
    },
    HardMesh {
        name: "layers of 1e-4",
        jitter: 1e-5,
        thickness: 1e-4,
        ..PLAIN
    },
    // Thinner than f32 resolves, and jittered by as much: flat and inverted cells.
    HardMesh {
        name: "layers of 1e-6",
        jitter: 1e-6,
        thickness: 1e-6,
        ..PLAIN
    },
    HardMesh {
        name: "layers of no thickness",
        thickness: 0.0,
        ..PLAIN
    },
];

impl HardMesh {
    /// One of any kind: moved by up to a millionth of a cube or by most of one, up to 1e6 cubes from the
    /// origin, with layers of any thickness and of none.
    pub fn random(seed: u64) -> HardMesh {
        // Seeds that follow each other begin alike.
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let power = |random: &mut Random, least: f64| 10f64.powf(least * random.signed().abs());
        HardMesh {
            name: "random",
            jitter: 0.9 * power(&mut random, -7.0),
            offset: power(&mut random, 6.0),
            thickness: match random.below(4) {
                0 => 0.0,
                1 => 1.0,
                _ => power(&mut random, -8.0),
            },
            cavity: random.below(2) == 0,
            seed: u64::from(random.bits()) | 1,
        }
    }

    /// The mesh, of 3³ cubes; its field is 0.
    pub fn mesh(&self) -> TetMesh {
        let kind = self;
        let mut random = Random(kind.seed);
        let side = CUBES + 1;
        let height = |k: usize| {
            let (pairs, rest) = (k / 2, k % 2);
            pairs as f64 * (1.0 + kind.thickness) + rest as f64 * kind.thickness
        };
        let mut points = Vec::new();
        for place in 0..side * side * side {
            let [i, j, k] = [place % side, place / side % side, place / (side * side)];
            let at = DVec3::new(i as f64, j as f64, height(k));
            points.push(at + kind.jitter * random.vector() + kind.offset);
        }
        let tetrahedra = kuhn_cells(CUBES, |at| !kind.cavity || at != [CUBES / 2; 3]);
        let scalars = point_scalars(vec![0.0; points.len()]);
        TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a mesh")
    }
}

/// A ray that is hard to follow through a mesh with vertices at `points` and these cells.
///
/// A point of it and a direction of any length, but not none.
pub fn hard_ray(random: &mut Random, points: &[Vec3], cells: &[[u32; 4]]) -> [Vec3; 2] {
    let cell = cells[random.below(cells.len())];
    let first = random.below(4);
    let [a, b, c, _] = [0, 1, 2, 3].map(|i| points[cell[(first + i) % 4] as usize]);
    // At a vertex, an edge, a face; exactly but for the rounding of the mean.
    let anchor = match random.below(4) {
        0 | 1 => a,
        2 => (a + b) / 2.0,
        _ => (a + b + c) / 3.0,
    };
    let axis = [Vec3::X, Vec3::Y, Vec3::Z][random.below(3)];
    let direction = match random.below(8) {
        // Along the lattice: in faces and along edges of cubes.
        0 | 1 => axis,
        2 => Vec3::ONE - axis,
        3 => Vec3::ONE,
        // Along the edge, in the face, to a vertex elsewhere.
        4 => b - a,
        5 => (b - a) + (c - a) * random.signed() as f32,
        6 => points[random.below(points.len())] - anchor,
        _ => random.vector().as_vec3(),
    };
    // Any direction will do where two vertices are in one place.
    let direction = if direction == Vec3::ZERO {
        axis
    } else {
        direction
    };
    [anchor, direction]
}
