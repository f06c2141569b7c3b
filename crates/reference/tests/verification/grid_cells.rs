//! Regular grids whose samples fill cells: as the same cells in a mesh.

use crate::grids::truth;
use crate::scenes::*;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Grid, OpticalModel, Ray, Scalars, TetMesh, Volume};

/// Cells along each axis of [0, 1]³.
const N: usize = 3;

/// One value for each of 27 cells, no two neighbors alike.
fn values() -> Vec<f32> {
    (0..N * N * N).map(|i| (i * 7 % 27) as f32 / 27.0).collect()
}

fn cells(values: Vec<f32>) -> Grid {
    let spacing = 1.0 / N as f64;
    let lattice = Lattice {
        dims: [N; 3],
        origin: DVec3::splat(0.5 * spacing),
        spacing: DVec3::splat(spacing),
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Nearest,
    };
    Grid::on(lattice, Samples::F32(values)).expect("a valid grid")
}

/// The same cells as tetrahedra, six for each.
fn tetrahedra(values: &[f32]) -> TetMesh {
    let (points, cells) = kuhn(N, DVec3::ZERO, DVec3::ONE);
    let of_six = values.iter().flat_map(|v| [f64::from(*v); 6]);
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Cell,
        values: of_six.collect(),
    };
    TetMesh::from_tetrahedra(points, cells, scalars).expect("a valid mesh")
}

/// Steps, a tent and slopes over [0, 1].
fn knots() -> Vec<tetrascope_core::Knot> {
    vec![
        knot(0.1, [0.9, 0.3, 0.1], 0.0),
        knot(0.4, [0.2, 0.8, 0.4], 3.0),
        knot(0.4, [0.7, 0.1, 0.9], 0.5),
        knot(0.9, [0.4, 0.2, 0.3], 9.0),
    ]
}

// Both integrate constant cells exactly; they differ by rounding, which their bounds hold.
#[test]
fn cells_of_a_grid_look_as_in_a_mesh() {
    let mut with_gap = values();
    with_gap[13] = f32::NAN;
    for values in [values(), with_gap] {
        let (grid, mesh) = (cells(values.clone()), tetrahedra(&values));
        // A spacing of a third, times three, is rounded.
        let (of_grid, of_mesh) = (Volume::Grid(grid.clone()).bounds(), mesh.bounds());
        assert!(of_grid.min.abs_diff_eq(of_mesh.min, f64::EPSILON));
        assert!(of_grid.max.abs_diff_eq(of_mesh.max, f64::EPSILON));
        for model in OpticalModel::VOLUMETRIC {
            let look = appearance(knots(), model);
            let (on_grid, on_mesh) = (truth(&grid, &look), reference(&mesh, &look));
            // Not along an axis: there rounding decides which of two cells a ray is in.
            for view in [views(24)[0], views(24)[1]] {
                let a = on_grid.render_exact(&view).expect("a valid view");
                let b = on_mesh.render_exact(&view).expect("a valid view");
                assert!(a.pixels.iter().any(|p| p[0] > 0.1 || p[3] > 0.1));
                for i in 0..a.pixels.len() {
                    let bound = a.error_bound[i] + b.error_bound[i];
                    assert!(bound < 1e-10, "{model:?} {i}: {bound:e}");
                    for (a, b) in a.pixels[i].iter().zip(b.pixels[i]) {
                        assert!(
                            (a - b).abs() <= bound,
                            "{model:?} {i}: {a} {b}, bound {bound:e}"
                        );
                    }
                }
            }
        }
    }
}

// Cells 0, 1 and 2 along x at the height of their middles: each a third of the way.
#[test]
fn a_ray_meets_whole_cells() {
    let look = appearance(vec![knot(0.0, [1.0; 3], 1.0)], OpticalModel::Absorption);
    let ray = Ray {
        origin: DVec3::new(-1.0, 1.0 / 6.0, 1.0 / 6.0),
        direction: DVec3::X,
    };
    let trace = truth(&cells(values()), &look).trace(&ray).expect("a ray");
    let met: Vec<usize> = trace.intervals.iter().map(|i| i.cell).collect();
    assert_eq!(met, [0, 1, 2]);
    for (i, interval) in trace.intervals.iter().enumerate() {
        let at = 1.0 + i as f64 / 3.0;
        assert!((interval.t_in - at).abs() < 1e-14);
        assert_eq!(interval.scalar_in, interval.scalar_out);
        assert_eq!(interval.scalar_in, f64::from(values()[i]));
    }
}
