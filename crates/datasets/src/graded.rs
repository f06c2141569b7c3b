//! A boundary layer: cells a million times wider than high over a curved wall.
//!
//! Layers grow geometrically from the wall at the bottom, which has a hump, to
//! the flat top. Every column is shifted up and down as a whole, so each
//! tetrahedron's volume is a triangle's area times a layer's height over three,
//! and none is turned inside out. The field is a velocity that grows as the
//! logarithm of the distance from the wall, as turbulent boundary layers do, and
//! it varies in the thinnest cells as in the largest.

use std::f64::consts::{PI, SQRT_2};

use tetrascope_core::mesh::Association;
use tetrascope_core::{CameraFit, Error, Scalars, TetMesh};

use crate::lattice::{Lattice, Split};
use crate::{Dataset, Look, MOST_CELLS, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "graded",
    about: "a boundary layer over a hump, cells up to 1e6 times longer than high, with its velocity",
    paper: "none: for rounding, slivers and scales",
    default_cells: 96_000,
    max_cells: MOST_CELLS,
    seeded: false,
    make: Make::Mesh(make),
    cells: None,
    look,
};

/// A horizontal cell diagonal over the height of the layer at the wall.
const ASPECT: f64 = 1e6;
/// The height of the hump in the box of height 1, world units.
const HUMP: f64 = 0.1;
/// Where the logarithm starts, world units: at x = 0, and how many times that at x = 1.
const ROUGHNESS: (f64, f64) = (1e-4, 100.0);

/// Cubes along x and y, and layers.
fn dimensions(cells: u64) -> (usize, usize) {
    // 2n layers: growth from one to the next is then about 1e12^(1/4n) at most.
    let cells = cells as f64;
    let n = (cells / 12.0).cbrt().round().max(1.0);
    let layers = (cells / (6.0 * n * n)).round().max(2.0);
    (n as usize, layers as usize)
}

/// Heights in [0, 1] of which the first is `first` and the steps grow geometrically:
/// (e^(β k/m) − 1) / (e^β − 1).
fn heights(layers: usize, first: f64) -> Vec<f64> {
    let height = |beta: f64, k: usize| (beta * k as f64 / layers as f64).exp_m1() / beta.exp_m1();
    // The first height falls from 1/m at β = 0; 700 is where e^β ends.
    let (mut low, mut high) = (1e-9, 700.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if height(middle, 1) > first {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0..=layers).map(|k| height(low, k)).collect()
}

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    let (n, layers) = dimensions(cells);
    let side: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
    let first = SQRT_2 / (n as f64 * ASPECT);
    let lattice = Lattice {
        axes: [side.clone(), side, heights(layers, first)],
    };
    let mut points = lattice.points();
    let values = points.iter().map(|p| velocity(p.x, p.z)).collect();
    for p in &mut points {
        let wall = HUMP * ((PI * p.x).sin() * (PI * p.y).sin()).powi(2);
        p.z = wall + (1.0 - wall) * p.z;
    }
    let scalars = Scalars {
        name: "velocity".into(),
        association: Association::Point,
        values,
    };
    TetMesh::from_tetrahedra(points, lattice.tetrahedra(Split::Six), scalars)
}

/// From 0 at the wall to 1 at the top; `height` is the fraction of the column.
fn velocity(x: f64, height: f64) -> f64 {
    let roughness = ROUGHNESS.0 * (1.0 + (ROUGHNESS.1 - 1.0) * x);
    (height / roughness).ln_1p() / roughness.recip().ln_1p()
}

/// The slow fluid at the wall, thickening downstream.
fn look() -> Look {
    Look {
        fit: CameraFit::MinusY,
        knots: vec![
            knot(0.0, [0.35, 0.02, 0.35], 40.0),
            knot(0.3, [0.80, 0.10, 0.15], 25.0),
            knot(0.55, [1.0, 0.55, 0.08], 6.0),
            knot(0.75, [0.35, 0.75, 0.40], 0.8),
            knot(0.9, [0.10, 0.40, 0.85], 0.25),
            knot(1.0, [0.10, 0.25, 0.80], 0.05),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: u64) -> TetMesh {
        let cells = Some(cells);
        DATASET.mesh(&Options { cells, seed: None }).expect("valid")
    }

    // ∫ sin²(πx) sin²(πy) = 1/4, and the trapezoidal rule, which linear
    // interpolation amounts to, is exact for it from two cubes a side.
    #[test]
    fn the_volume_is_exact_at_every_size() {
        for cells in [100, 1000, 96_000] {
            let mesh = mesh(cells);
            checks::conforms(&mesh);
            checks::positive(&mesh);
            let exact = 1.0 - HUMP / 4.0;
            // Heights are differences of numbers up to 1: each cell errs by the
            // rounding of its corners' z, an ulp of 1, on its share of the floor.
            let rounding = 10.0 * f64::EPSILON * mesh.cell_count() as f64;
            assert!((checks::volume(&mesh) - exact).abs() < rounding);
        }
    }

    // Longest edge over least height, 3V over the largest face's area.
    #[test]
    fn the_thinnest_cells_have_an_aspect_of_a_million() {
        for cells in [1000, 96_000] {
            let mesh = mesh(cells);
            let aspect = |cell| {
                let p = mesh.cell_points(cell);
                let edges = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
                let longest = edges.map(|(i, j)| p[i].distance(p[j])).fold(0.0, f64::max);
                let area = |i: usize| {
                    let [a, b, c] = [1, 2, 3].map(|k| p[(i + k) % 4]);
                    (b - a).cross(c - a).length() / 2.0
                };
                let volume = (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) / 6.0;
                longest * (0..4).map(area).fold(0.0, f64::max) / (3.0 * volume)
            };
            let aspects: Vec<f64> = (0..mesh.cell_count()).map(aspect).collect();
            let greatest = aspects.iter().fold(0.0f64, |a, &b| a.max(b));
            // The hump adds its slope, at most 0.1 π, squared to lengths and areas,
            // and takes a tenth of the height.
            assert!((0.99e6..1.3e6).contains(&greatest), "{greatest}");
            // And the cells at the top are well shaped again.
            let least = aspects.iter().fold(f64::INFINITY, |a, &b| a.min(b));
            assert!(least < 20.0, "{least}");
        }
    }

    #[test]
    fn layers_grow_from_the_wall_to_the_top() {
        let heights = heights(40, 1e-7);
        assert_eq!((heights[0], heights[40]), (0.0, 1.0));
        assert!((heights[1] / 1e-7 - 1.0).abs() < 1e-10);
        let steps: Vec<f64> = heights.windows(2).map(|w| w[1] - w[0]).collect();
        let growth = steps[1] / steps[0];
        for pair in steps.windows(2) {
            // The ulp of 1 against a step.
            let tolerance = 1e-9 + 4.0 * f64::EPSILON / pair[0];
            assert!((pair[1] / pair[0] / growth - 1.0).abs() < tolerance);
        }
    }

    #[test]
    fn the_velocity_goes_from_rest_to_one() {
        let (low, high) = mesh(5000).scalar_range().expect("finite");
        assert_eq!(low, 0.0);
        // Two logarithms and a division round.
        assert!((high - 1.0).abs() < 4.0 * f64::EPSILON);
        // The layer thickens downstream: at one height the fluid is slower.
        assert!(velocity(0.9, 0.01) < velocity(0.1, 0.01));
    }
}
