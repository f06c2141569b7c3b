//! A ring with a hole, closed without a seam, and a field that winds around it.
//!
//! A disc of triangles is carried around the z axis; between two sections each
//! triangle sweeps a prism, cut into three tetrahedra. The cut goes by the order
//! of the points in the disc alone, so it is the same in every section and the
//! last meets the first. All cells are positive, however coarse the mesh: a
//! tetrahedron between sections δ apart has the volume sin δ · A · R / 3, with A
//! the triangle's area and R the distance of one of its corners from the axis.

use std::f64::consts::TAU;

use tetrascope_core::clusters::CellSource;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Bounds, CameraFit, Error, Scalars, TetMesh};

use crate::{Dataset, Look, MOST_CELLS, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "torus",
    about: "a ring of curved prisms, non-convex with a hole; a smooth field winds around it",
    paper: "none: for depth complexity, re-entry and a boundary of genus 1",
    default_cells: 150_000,
    max_cells: MOST_CELLS,
    seeded: false,
    make: Make::Mesh(make),
    cells: Some(cells),
    look,
};

/// Radius of the core circle, world units.
const MAJOR: f64 = 1.0;
/// Radius of the ring's section, world units.
const MINOR: f64 = 0.4;
/// How often the field turns around the section on one way around the ring, in halves.
const TWIST: f64 = 3.0;

/// Rings of triangles in the disc, and sections around the axis.
fn dimensions(cells: u64) -> (usize, usize) {
    // 6 n² triangles make 18 n² tetrahedra a section; sections as far apart as
    // the disc's points, MINOR/n, are TAU·MAJOR·n/MINOR.
    let cells = cells as f64;
    let n = (cells * MINOR / (18.0 * TAU * MAJOR))
        .cbrt()
        .round()
        .max(1.0);
    let sections = (cells / (18.0 * n * n)).round().max(3.0);
    (n as usize, sections as usize)
}

/// The mesh, told from the numbers of its cells and points: the disc is in memory, the sections are not.
struct Cells {
    sections: usize,
    points: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    bounds: Bounds,
}

fn cells(cells: u64) -> Box<dyn CellSource> {
    Box::new(Cells::new(cells))
}

impl Cells {
    fn new(cells: u64) -> Cells {
        let (n, sections) = dimensions(cells);
        let mut cells = Cells {
            sections,
            points: disc_points(n),
            triangles: disc_triangles(n),
            bounds: Bounds::EMPTY,
        };
        // The surface has the extremes.
        let rim = cells.points.len() - 6 * n..cells.points.len();
        let numbers = (0..sections).flat_map(|s| rim.clone().map(move |i| (s, i)));
        let count = cells.points.len();
        let points = numbers.map(|(section, i)| cells.point((section * count + i) as u32));
        cells.bounds = Bounds::of(points);
        cells
    }

    /// The section of a point and its place in the disc, and the angle of the section.
    fn place(&self, point: u64) -> ([f64; 2], f64) {
        let count = self.points.len() as u64;
        let (section, place) = (point / count, point % count);
        let phi = TAU * section as f64 / self.sections as f64;
        (self.points[place as usize], phi)
    }
}

impl CellSource for Cells {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn field(&self) -> (&str, Association) {
        (FIELD, Association::Point)
    }

    fn cell_count(&self) -> u64 {
        3 * (self.sections * self.triangles.len()) as u64
    }

    fn cell(&self, cell: u64) -> [u32; 4] {
        let (prism, piece) = ((cell / 3) as usize, cell % 3);
        let (section, triangle) = (prism / self.triangles.len(), prism % self.triangles.len());
        let start = |section: usize| (section * self.points.len()) as u32;
        let (near, far) = (start(section), start((section + 1) % self.sections));
        let [a, b, c] = self.triangles[triangle];
        match piece {
            0 => [near + a, near + b, near + c, far + c],
            1 => [near + a, near + b, far + b, far + c],
            _ => [near + a, far + a, far + b, far + c],
        }
    }

    fn point(&self, point: u32) -> DVec3 {
        let ([u, v], phi) = self.place(point.into());
        let (sin, cos) = phi.sin_cos();
        let radius = MAJOR + MINOR * u;
        DVec3::new(radius * cos, radius * sin, MINOR * v)
    }

    fn value(&self, point: u64) -> f64 {
        let ([u, v], phi) = self.place(point);
        field(u, v, phi)
    }
}

const FIELD: &str = "flux";

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    let cells = Cells::new(cells);
    let count = cells.sections * cells.points.len();
    let points = (0..count as u32).map(|point| cells.point(point)).collect();
    let values = (0..count as u64).map(|point| cells.value(point)).collect();
    let tetrahedra = (0..cells.cell_count())
        .map(|cell| cells.cell(cell))
        .collect();
    let scalars = Scalars {
        name: FIELD.into(),
        association: Association::Point,
        values,
    };
    TetMesh::from_tetrahedra(points, tetrahedra, scalars)
}

/// 1 on the core, elliptic around it; the ellipses turn with φ as a stellarator's do.
/// With q and θ the polar coordinates of (u, v): 1 − q² + q² cos(2θ − 3φ)/2.
fn field(u: f64, v: f64, phi: f64) -> f64 {
    let (sin, cos) = (TWIST * phi).sin_cos();
    1.0 - (u * u + v * v) + 0.5 * ((u * u - v * v) * cos + 2.0 * u * v * sin)
}

/// The unit disc: a point in the middle, then rings of 6, 12, … 6n.
fn disc_points(n: usize) -> Vec<[f64; 2]> {
    let ring = |k: usize| {
        (0..6 * k).map(move |j| {
            let (sin, cos) = (TAU * j as f64 / (6 * k) as f64).sin_cos();
            let radius = k as f64 / n as f64;
            [radius * cos, radius * sin]
        })
    };
    std::iter::once([0.0, 0.0])
        .chain((1..=n).flat_map(ring))
        .collect()
}

/// The triangles between the rings, each with its points by increasing index,
/// which fixes how the prisms over them are cut.
fn disc_triangles(n: usize) -> Vec<[u32; 3]> {
    // Point j of ring k, which starts after 1 + 6 + … + 6(k − 1) points.
    let point = |k: usize, j: usize| match k {
        0 => 0,
        _ => (1 + 3 * k * (k - 1) + j % (6 * k)) as u32,
    };
    let mut triangles = Vec::with_capacity(6 * n * n);
    for k in 1..=n {
        for sextant in 0..6 {
            let outer = |j| point(k, sextant * k + j);
            let inner = |j| point(k - 1, sextant * (k - 1) + j);
            triangles.extend((0..k).map(|j| [inner(j), outer(j), outer(j + 1)]));
            triangles.extend((1..k).map(|j| [inner(j - 1), inner(j), outer(j)]));
        }
    }
    triangles.iter_mut().for_each(|t| t.sort_unstable());
    triangles
}

/// The core, glowing, in a translucent twisted body.
fn look() -> Look {
    Look {
        fit: CameraFit::PlusIso,
        knots: vec![
            knot(-0.5, [0.05, 0.10, 0.55], 0.4),
            knot(0.2, [0.05, 0.45, 0.85], 1.0),
            knot(0.5, [0.10, 0.75, 0.55], 1.5),
            knot(0.75, [0.95, 0.65, 0.08], 6.0),
            knot(1.0, [1.0, 0.22, 0.04], 20.0),
        ],
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: Option<u64>) -> TetMesh {
        DATASET.mesh(&Options { cells, seed: None }).expect("valid")
    }

    #[test]
    fn the_ring_is_closed_and_has_a_hole() {
        for cells in [1, 500, 5000, 150_000] {
            let mesh = mesh(Some(cells));
            checks::conforms(&mesh);
            checks::positive(&mesh);
            let (n, sections) = dimensions(cells);
            assert_eq!(mesh.cell_count(), 18 * n * n * sections);
            // A torus: V − E + F = 0, and E = 3F/2 on a closed surface.
            let boundary = checks::boundary(&mesh);
            assert_eq!(boundary.len(), 2 * 6 * n * sections);
            let mut corners: Vec<u32> = boundary.iter().flatten().copied().collect();
            corners.sort_unstable();
            corners.dedup();
            assert_eq!(2 * corners.len(), boundary.len());
        }
    }

    #[test]
    fn the_number_of_cells_is_near_the_request() {
        for cells in (1_000..300_000).step_by(4_321) {
            let (n, sections) = dimensions(cells);
            let made = (18 * n * n * sections) as u64;
            // Half a section more or less.
            assert!(
                made.abs_diff(cells) <= (9 * n * n) as u64,
                "{cells}: {made}"
            );
        }
    }

    // Summed over a section's prisms, sin δ · A · R / 3 is sin δ ∫ R dA = sin δ · MAJOR · A,
    // as the disc is symmetric, with A that of a regular 6n-gon. It tends to
    // 2 π² MAJOR MINOR² at second order.
    #[test]
    fn the_volume_is_that_of_the_polygons_and_converges_at_second_order() {
        let polygon = |sides: f64| sides * (TAU / sides).sin(); // 2π in the limit
        let round = 2.0 * PI * PI * MAJOR * MINOR * MINOR;
        let mut errors = Vec::new();
        for cells in [2_000, 16_000, 128_000] {
            let mesh = mesh(Some(cells));
            let (n, sections) = dimensions(cells);
            let exact =
                polygon(sections as f64) * polygon(6.0 * n as f64) / 2.0 * (MAJOR * MINOR * MINOR);
            let volume = checks::volume(&mesh);
            // One rounding error a cell.
            let rounding = mesh.cell_count() as f64 * f64::EPSILON * exact;
            assert!((volume - exact).abs() < rounding, "{volume} {exact}");
            errors.push((round - volume, 1.0 / (n * n) as f64));
        }
        for pair in errors.windows(2) {
            let order = (pair[0].0 / pair[1].0) / (pair[0].1 / pair[1].1);
            // n and the sections are rounded to whole numbers, each by a few percent.
            assert!((0.8..1.25).contains(&order), "{errors:?}");
        }
    }

    #[test]
    fn the_field_is_one_on_the_core_and_winds_three_half_turns() {
        let (low, high) = mesh(None).scalar_range().expect("finite");
        assert_eq!(high, 1.0);
        // −1/2 where cos(2θ − 3φ) = −1 on the surface; a surface point is within
        // π/(6n) of such a θ, n = 8, and cos falls by half the square of twice it.
        let miss = 0.5 * (1.0 - (2.0 * PI / 48.0).cos());
        assert!((-0.5..=-0.5 + miss).contains(&low), "{low}");
        // A third of the way around the ring is one half turn plus a whole: the same.
        for (u, v) in [(0.3, 0.4), (-0.7, 0.2)] {
            let (a, b) = (field(u, v, 0.0), field(u, v, TAU / 3.0));
            assert!((a - b).abs() < 1e-14);
            assert!((field(u, v, TAU / 6.0) - field(v, -u, 0.0)).abs() < 1e-14);
        }
    }
}
