//! Irregular cells: the Delaunay mesh of random points in a ball.
//!
//! Bowyer and Watson's method: cells whose circumsphere holds the new point make
//! a cavity, and the point is joined to its walls (A. Bowyer, "Computing Dirichlet
//! tessellations", D. Watson, "Computing the n-dimensional Delaunay tessellation",
//! both The Computer Journal 24, 1981). Outside the hull there are cells too, with
//! a point at infinity, so hull points are no special case and the result is
//! convex. Signs are exact (J. Shewchuk, "Adaptive Precision Floating-Point
//! Arithmetic and Fast Robust Geometric Predicates", 1997), so slivers, of which
//! such a mesh has many, are thin but never inside out.

use robust::{Coord3D, insphere, orient3d};
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{CameraFit, Error, Scalars, TetMesh};

use crate::random::Random;
use crate::{Dataset, Look, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "delaunay",
    about: "random points in a ball, irregular cells and slivers, with a gyroid; convex",
    paper: "none: for cells of all shapes, in no order",
    default_cells: 100_000,
    max_cells: 10_000_000,
    seeded: true,
    make: Make::Mesh(make),
    cells: None,
    look,
};

/// Frequency of the field's waves, radians per world unit; the ball's radius is 1.
const FREQUENCY: f64 = 5.0;

fn make(cells: u64, seed: u64) -> Result<TetMesh, Error> {
    let points = random_points(point_count(cells), seed);
    let tetrahedra = tetrahedralize(&points);
    let scalars = Scalars {
        name: "gyroid".into(),
        association: Association::Point,
        values: points.iter().map(|&p| gyroid(p)).collect(),
    };
    TetMesh::from_tetrahedra(points, tetrahedra, scalars)
}

/// How many points make about `cells` cells.
///
/// Inside there are 24 π²/35 ≈ 6.77 cells per point (R. Miles, 1970); the hull, of
/// the order of √n points in a ball, and the flatter cells near it take away some.
fn point_count(cells: u64) -> usize {
    let n = cells as f64 / 6.77;
    (n + HULL * n.sqrt()).round().max(4.0) as usize
}

/// Fitted to meshes of 1000, 10 000 and 100 000 cells: 2.9, 3.1 and 3.2.
const HULL: f64 = 3.05;

/// Uniform in the unit ball, by rejection from the cube; sorted along a Z-order
/// curve, so that neighbors in the list are mostly neighbors in space.
fn random_points(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random(seed);
    let mut random = || random.signed();
    let mut points: Vec<DVec3> =
        std::iter::repeat_with(|| DVec3::new(random(), random(), random()))
            .filter(|p| p.length_squared() <= 1.0)
            .take(count)
            .collect();
    points.sort_by_cached_key(|p| {
        let [x, y, z] = p.to_array().map(|c| ((c + 1.0) * 512.0) as u32);
        (0..10).fold(0u32, |code, bit| {
            code | (x >> bit & 1) << (3 * bit)
                | (y >> bit & 1) << (3 * bit + 1)
                | (z >> bit & 1) << (3 * bit + 2)
        })
    });
    points
}

fn gyroid(p: DVec3) -> f64 {
    let [x, y, z] = (p * FREQUENCY).to_array();
    x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
}

/// The point at infinity.
const INFINITY: u32 = u32::MAX;

/// The Delaunay tetrahedra of at least four points in general position,
/// positively oriented.
fn tetrahedralize(points: &[DVec3]) -> Vec<[u32; 4]> {
    let mut mesh = Incremental::new(points);
    for p in 4..points.len() {
        mesh.insert(p as u32);
    }
    let alive = mesh
        .cells
        .iter()
        .zip(&mesh.alive)
        .filter(|(_, alive)| **alive);
    alive
        .map(|(cell, _)| *cell)
        .filter(|cell| !cell.contains(&INFINITY))
        .collect()
}

struct Incremental<'a> {
    points: &'a [DVec3],
    /// Positively oriented, with infinity outside the hull.
    cells: Vec<[u32; 4]>,
    /// Across the face opposite each point.
    neighbors: Vec<[u32; 4]>,
    alive: Vec<bool>,
    /// Cells that are not alive, to be used again.
    free: Vec<u32>,
    /// Where the next search starts: a cell of the hull's inside.
    last: u32,
}

impl<'a> Incremental<'a> {
    /// The first four points and the four cells around them.
    fn new(points: &'a [DVec3]) -> Self {
        let mut first = [0, 1, 2, 3];
        if orientation(first.map(|p| points[p as usize])) < 0.0 {
            first.swap(0, 1);
        }
        let mut cells = vec![first];
        for i in 0..4 {
            // Infinity in place of a point is on the other side of the face: swap two.
            let mut cell = first;
            cell[i] = INFINITY;
            cell.swap((i + 1) % 4, (i + 2) % 4);
            cells.push(cell);
        }
        let across = |cell: &[u32; 4], i: usize| {
            let shares = |other: &[u32; 4]| (0..4).all(|k| k == i || other.contains(&cell[k]));
            let found = cells
                .iter()
                .position(|other| other != cell && shares(other));
            found.expect("the five cells close up") as u32
        };
        let neighbors = cells
            .iter()
            .map(|cell| [0, 1, 2, 3].map(|i| across(cell, i)))
            .collect();
        Incremental {
            points,
            neighbors,
            alive: vec![true; cells.len()],
            cells,
            free: Vec::new(),
            last: 0,
        }
    }

    /// The orientation of `cell` with point `i` replaced by `p`.
    fn side(&self, cell: u32, i: usize, p: u32) -> f64 {
        let mut corners = self.cells[cell as usize];
        corners[i] = p;
        orientation(corners.map(|c| self.points[c as usize]))
    }

    /// Whether the circumsphere of `cell` holds `p`; beyond the hull, whether `p`
    /// sees the cell's face.
    fn conflicts(&self, cell: u32, p: u32) -> bool {
        let corners = self.cells[cell as usize];
        match corners.iter().position(|&c| c == INFINITY) {
            Some(i) => self.side(cell, i, p) > 0.0,
            None => {
                let [a, b, c, d] = corners.map(|c| coordinates(self.points[c as usize]));
                // Shewchuk's orientation is the opposite of ours, and so the sign.
                insphere(a, b, c, d, coordinates(self.points[p as usize])) < 0.0
            }
        }
    }

    /// The cell that holds `p`, or one outside the hull that sees it.
    fn locate(&self, p: u32) -> u32 {
        let mut cell = self.last;
        // In a Delaunay mesh a walk toward the point ends, whichever face it takes.
        'walk: loop {
            let corners = self.cells[cell as usize];
            if corners.contains(&INFINITY) {
                return cell;
            }
            for i in 0..4 {
                if self.side(cell, i, p) < 0.0 {
                    cell = self.neighbors[cell as usize][i];
                    continue 'walk;
                }
            }
            return cell;
        }
    }

    fn insert(&mut self, p: u32) {
        // The cavity grows from the cell that holds the point; `alive` marks it.
        let mut cavity = vec![self.locate(p)];
        self.alive[cavity[0] as usize] = false;
        let mut walls = Vec::new();
        let mut next = 0;
        while let Some(&cell) = cavity.get(next) {
            next += 1;
            for i in 0..4 {
                let neighbor = self.neighbors[cell as usize][i];
                if !self.alive[neighbor as usize] {
                    continue;
                }
                if self.conflicts(neighbor, p) {
                    self.alive[neighbor as usize] = false;
                    cavity.push(neighbor);
                } else {
                    walls.push((cell, i, neighbor));
                }
            }
        }
        // Each wall makes a cell with the point; those meet at the walls' edges.
        let mut edges = Vec::with_capacity(3 * walls.len());
        for (cell, i, neighbor) in walls {
            let mut corners = self.cells[cell as usize];
            corners[i] = p;
            let new = self.free.pop().unwrap_or(self.cells.len() as u32);
            if new as usize == self.cells.len() {
                self.cells.push(corners);
                self.neighbors.push([neighbor; 4]);
                self.alive.push(true);
            } else {
                self.cells[new as usize] = corners;
                self.neighbors[new as usize] = [neighbor; 4];
                self.alive[new as usize] = true;
            }
            let back = self.neighbors[neighbor as usize]
                .iter()
                .position(|&c| c == cell)
                .expect("neighbors know each other");
            self.neighbors[neighbor as usize][back] = new;
            for k in (0..4).filter(|&k| k != i) {
                // The edge that the face opposite corner k shares with the wall.
                let mut ends = (0..4).filter(|&c| c != i && c != k).map(|c| corners[c]);
                let (j, l) = (ends.next().expect("two"), ends.next().expect("two"));
                edges.push(((j.min(l), j.max(l)), new, k));
            }
            // A walk that started outside would end there.
            if !corners.contains(&INFINITY) {
                self.last = new;
            }
        }
        edges.sort_unstable();
        for pair in edges.chunks_exact(2) {
            let [(_, a, i), (_, b, j)] = [pair[0], pair[1]];
            self.neighbors[a as usize][i] = b;
            self.neighbors[b as usize][j] = a;
        }
        self.free.extend(cavity);
    }
}

/// The exact sign of (b − a) · ((c − a) × (d − a)).
fn orientation([a, b, c, d]: [DVec3; 4]) -> f64 {
    -orient3d(
        coordinates(a),
        coordinates(b),
        coordinates(c),
        coordinates(d),
    )
}

fn coordinates(p: DVec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// The two labyrinths of a gyroid in two colors, clear between.
fn look() -> Look {
    Look {
        fit: CameraFit::PlusIso,
        knots: vec![
            knot(-1.45, [0.10, 0.35, 0.95], 8.0),
            knot(-0.8, [0.05, 0.55, 0.85], 3.0),
            knot(-0.4, [0.05, 0.30, 0.50], 0.0),
            knot(0.4, [0.50, 0.20, 0.05], 0.0),
            knot(0.8, [0.95, 0.55, 0.10], 3.0),
            knot(1.45, [1.0, 0.85, 0.45], 8.0),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: u64, seed: u64) -> TetMesh {
        let options = Options {
            cells: Some(cells),
            seed: Some(seed),
        };
        DATASET.mesh(&options).expect("valid")
    }

    // The definition, over all pairs of cell and point, with exact signs.
    #[test]
    fn no_circumsphere_holds_a_point() {
        for seed in 0..4 {
            let mesh = mesh(1500, seed);
            for &cell in mesh.tetrahedra() {
                let [a, b, c, d] = cell.map(|p| coordinates(mesh.points()[p as usize]));
                for &p in mesh.points() {
                    assert!(insphere(a, b, c, d, coordinates(p)) >= 0.0);
                }
            }
        }
    }

    #[test]
    fn cells_are_positive_conform_and_fill_the_convex_hull() {
        for (cells, seed) in [(1, 1), (60, 2), (3000, 3), (100_000, 1)] {
            let mesh = mesh(cells, seed);
            checks::conforms(&mesh);
            for &cell in mesh.tetrahedra() {
                assert!(orientation(cell.map(|p| mesh.points()[p as usize])) > 0.0);
            }
            // Convex: no point is beyond a boundary face. Exact, so without tolerance.
            let faces = checks::boundary(&mesh);
            for face in faces.iter().step_by(1 + faces.len() / 200) {
                let [a, b, c] = face.map(|p| mesh.points()[p as usize]);
                let signs = mesh.points().iter().map(|&p| orientation([a, b, c, p]));
                let (low, high) = signs.fold((0.0f64, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
                assert!(low == 0.0 || high == 0.0, "points on both sides");
            }
            // A sphere: F = 2V − 4 for triangles.
            let mut corners: Vec<u32> = faces.iter().flatten().copied().collect();
            corners.sort_unstable();
            corners.dedup();
            assert_eq!(faces.len(), 2 * corners.len() - 4);
            // Divergence theorem: a third of x · n over the hull is the volume.
            let fan: f64 = faces
                .iter()
                .map(|f| {
                    let [a, b, c] = f.map(|p| mesh.points()[p as usize]);
                    (a.dot(b.cross(c)) / 6.0).abs()
                })
                .sum();
            // The middle of the ball lies inside hulls of more than a few points.
            if cells >= 3000 {
                let rounding = mesh.cell_count() as f64 * f64::EPSILON;
                assert!((checks::volume(&mesh) - fan).abs() < 8.0 * rounding);
            }
        }
    }

    #[test]
    fn the_number_of_cells_is_near_the_request() {
        for cells in [1_000, 10_000, 100_000] {
            let made = mesh(cells, 1).cell_count() as f64;
            // Cells a point scatter by about 1 % at 1000 cells.
            assert!((made / cells as f64 - 1.0).abs() < 0.03, "{cells}: {made}");
        }
    }

    #[test]
    fn the_gyroid_stays_in_its_range() {
        let (low, high) = mesh(100_000, 1).scalar_range().expect("finite");
        // |g| ≤ 3/2 everywhere, and 13 waves of points come within a few percent.
        assert!(
            (-1.5..-1.45).contains(&low) && (1.45..1.5).contains(&high),
            "{low} {high}"
        );
    }
}
