//! Water in a basin over which waves run: a mesh that is made anew in every step.
//!
//! For what Westermann 2001 promises: where nothing is sorted and no topology is built, a mesh
//! whose geometry and connectivity change every frame costs the same as one that does not. From
//! one step to the next the surface and all points below it move, columns of cells crowd where the
//! crest is, and the cubes are cut along another of their four diagonals. The number of points
//! and of cells stays the same.

use std::f64::consts::{PI, TAU};

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, Scalars, TetMesh};

use crate::MOST_CELLS;
use crate::lattice::{Lattice, Split, nearest_dimensions};

/// Steps in which a crest comes once around.
pub const WAVE_STEPS: u64 = 60;

/// How high crests are above the mean surface at z = 0.
const HEIGHT: f64 = 0.3;

/// How much columns crowd: the least distance of two is this less than the mean one.
const CROWDING: f64 = 0.4;

/// The water in [−1, 1]² × [−1, surface] after so many steps, in about `cells` cells, with the
/// speed of its parts as the field "speed", 0 to 1 and a little.
///
/// The same arguments give the same mesh, to the last bit; it comes back after [`WAVE_STEPS`],
/// but for the diagonals along which cubes are cut, which are the same every fourth step.
///
/// # Errors
/// [`Error::Invalid`] for no cells, and for more than 100 million.
pub fn wave(cells: u64, step: u64) -> Result<TetMesh, Error> {
    if cells == 0 || cells > MOST_CELLS {
        return Err(Error::Invalid {
            what: format!("a wave of {cells} cells"),
            help: Some(format!("ask for 1 to {MOST_CELLS} cells")),
        });
    }
    let phase = TAU * (step % WAVE_STEPS) as f64 / WAVE_STEPS as f64;
    let lattice = Lattice::centered(1.0, nearest_dimensions(cells, Split::Six));
    let points: Vec<DVec3> = lattice.points().iter().map(|p| moved(*p, phase)).collect();
    let scalars = Scalars {
        name: "speed".into(),
        association: Association::Point,
        values: points.iter().map(|p| speed(*p, phase)).collect(),
    };
    let tetrahedra = lattice.tetrahedra_along(step % 4);
    TetMesh::from_tetrahedra(points, tetrahedra, scalars)
}

/// How high the surface is.
fn surface(x: f64, y: f64, phase: f64) -> f64 {
    HEIGHT * (0.7 * (PI * x - phase).sin() + 0.3 * (PI * y + phase).sin())
}

/// Where a point of the basin at rest, [−1, 1]³, is in the water: columns stay upright, so no cell
/// is turned inside out.
fn moved(rest: DVec3, phase: f64) -> DVec3 {
    // Increases with the place at rest, and leaves the walls where they are.
    let crowded = |u: f64, by: f64| u + CROWDING * by * (PI * u).sin() / PI;
    let x = crowded(rest.x, phase.sin());
    let y = crowded(rest.y, phase.cos());
    let depth = 1.0 + surface(x, y, phase);
    DVec3::new(x, y, 0.5 * (rest.z + 1.0) * depth - 1.0)
}

/// Greatest at the crests, and less with depth, as of waves on deep water.
fn speed(p: DVec3, phase: f64) -> f64 {
    let surface = surface(p.x, p.y, phase);
    let below = p.z - surface;
    (0.5 + 0.5 * surface / HEIGHT) * (2.0 * below).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks;

    fn of_step(step: u64) -> TetMesh {
        wave(6 * 8 * 8 * 8, step).expect("a valid size")
    }

    #[test]
    fn every_step_is_a_valid_mesh_of_as_many_cells() {
        let first = of_step(0);
        for step in [0, 1, 2, 3, 17, 59] {
            let mesh = of_step(step);
            assert_eq!(mesh.cell_count(), 6 * 8 * 8 * 8);
            assert_eq!(mesh.points().len(), first.points().len());
            checks::conforms(&mesh);
            checks::positive(&mesh);
            assert_eq!(checks::boundary(&mesh).len(), 2 * 6 * 8 * 8);
            let (low, high) = mesh.scalar_range().expect("finite");
            // e⁻² and less at the bottom of a trough.
            assert!((0.0..0.2).contains(&low) && (0.8..=1.0).contains(&high));
        }
    }

    #[test]
    fn points_and_connectivity_change_in_every_step() {
        for step in 0..8 {
            let (now, next) = (of_step(step), of_step(step + 1));
            assert_ne!(now.points(), next.points(), "{step}");
            assert_ne!(now.tetrahedra(), next.tetrahedra(), "{step}");
        }
        let again = of_step(4 * WAVE_STEPS);
        assert_eq!(again.points(), of_step(0).points());
        assert_eq!(again.tetrahedra(), of_step(0).tetrahedra());
    }

    // Waves add up to nothing over the basin. What is cut off and added between points of the
    // surface is of second order in their distance.
    #[test]
    fn the_water_stays() {
        let off = |n: u64, step: u64| {
            let mesh = wave(6 * n * n * n, step).expect("a valid size");
            (checks::volume(&mesh) - 4.0).abs()
        };
        for step in [5, 23] {
            let ratio = off(8, step) / off(16, step);
            assert!((3.6..4.4).contains(&ratio), "{step}: {ratio}");
        }
    }

    #[test]
    fn impossible_sizes_are_refused() {
        for cells in [0, MOST_CELLS + 1] {
            let error = wave(cells, 0).expect_err("no such size");
            assert!(error.to_string().contains(&cells.to_string()), "{error}");
        }
    }
}
