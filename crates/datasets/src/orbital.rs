//! A hydrogen orbital, 3d z²: two lobes of one sign in a ring of the other.
//!
//! Weiler, Kraus and Ertl 2002, figure 11 and tables 1 to 3: "orbital-like
//! artificial data set consisting of 150K tetrahedra", with as many cells as
//! their sphere, so on the same lattice here. Which orbital they drew is not
//! said. With lengths in Bohr radii,
//!
//! ψ₃₂₀ = (3z² − r²) exp(−r/3) / (81 √(6π)),
//!
//! D. Griffiths, "Introduction to Quantum Mechanics", 2nd ed., tables 4.3 and 4.7.

use std::f64::consts::PI;

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{CameraFit, Error, Scalars, TetMesh};

use crate::lattice::{Lattice, Split, nearest_dimensions};
use crate::{Dataset, Look, MOST_CELLS, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "orbital",
    about: "a cube of tetrahedra with the 3d z² wave function of hydrogen, lengths in Bohr radii; convex",
    paper: "Weiler, Kraus, Ertl 2002, figure 11 and tables 1 to 3",
    default_cells: 148_955,
    max_cells: MOST_CELLS,
    seeded: false,
    make: Make::Mesh(make),
    cells: None,
    look,
};

/// Half the cube's edge, Bohr radii: at the middle of a face across the lobes,
/// |ψ| is 4 % of its greatest value.
const HALF: f64 = 24.0;

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    let lattice = Lattice::centered(HALF, nearest_dimensions(cells, Split::Five));
    let points = lattice.points();
    let scalars = Scalars {
        name: "psi".into(),
        association: Association::Point,
        values: points.iter().map(|&p| psi(p)).collect(),
    };
    TetMesh::from_tetrahedra(points, lattice.tetrahedra(Split::Five), scalars)
}

fn psi(p: DVec3) -> f64 {
    let norm = 1.0 / (81.0 * (6.0 * PI).sqrt());
    norm * (3.0 * p.z * p.z - p.length_squared()) * (-p.length() / 3.0).exp()
}

/// Warm lobes (ψ > 0, up to 0.0277), a cool ring (down to −0.0139), clear between.
fn look() -> Look {
    Look {
        fit: CameraFit::PlusX,
        knots: vec![
            knot(-0.0139, [0.75, 0.95, 1.0], 0.9),
            knot(-0.0080, [0.05, 0.45, 0.95], 0.30),
            knot(-0.0020, [0.03, 0.12, 0.60], 0.0),
            knot(0.0020, [0.60, 0.08, 0.03], 0.0),
            knot(0.0100, [0.95, 0.32, 0.05], 0.20),
            knot(0.0277, [1.0, 0.92, 0.55], 1.0),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, checks};

    fn mesh(n: u64) -> TetMesh {
        let cells = Some(5 * n * n * n);
        DATASET.mesh(&Options { cells, seed: None }).expect("valid")
    }

    // |ψ| has its extremes at r = 6: there d/dr (r² e^(−r/3)) = 0. On the axis
    // ψ = 72 e^(−2) / (81 √(6π)), on the equator minus half of it. The nearest
    // of n points along the axis misses r = 6 by at most 24/n, and one of an odd
    // lattice the axis by as much.
    #[test]
    fn the_range_converges_to_the_lobes_and_the_ring() {
        let lobe = 72.0 * (-2f64).exp() / (81.0 * (6.0 * PI).sqrt());
        let error = |n: u64| {
            let (low, high) = mesh(n).scalar_range().expect("finite");
            assert!(high <= lobe * (1.0 + 1e-14) && low >= -lobe / 2.0 * (1.0 + 1e-14));
            ((high - lobe).abs() / lobe, (low + lobe / 2.0).abs() / lobe)
        };
        // 48/32 divides 6: points lie on the extremes themselves.
        assert!(error(32).0 < 1e-14 && error(32).1 < 1e-14);
        // ψ'' r² / ψ is of order 1 to 10, (24/31)² / 36 = 0.017.
        assert!(error(31).0 < 0.1 && error(31).1 < 0.05);
    }

    // A normalized state: ∫ψ² = 1, less what lies outside the cube.
    #[test]
    fn the_electron_is_somewhere() {
        let total = |n| checks::integral(&mesh(n), |s, _| s * s);
        // Interpolation errs as h²: extrapolate, then only the tail is missing.
        let (coarse, fine) = (total(24), total(48));
        assert!(
            (fine - 1.0).abs() < (coarse - 1.0).abs() / 3.5,
            "{coarse} {fine}"
        );
        let limit = fine + (fine - coarse) / 3.0;
        // The cube holds the ball of radius 24, outside of which there is the part
        // ∫ r⁶ e^(−2r/3) from 24 of the whole: Γ(7, 16)/Γ(7) = e^(−16) Σ 16ᵏ/k!, k < 7.
        let (mut term, mut tail) = ((-16f64).exp(), 0.0);
        for k in 1..=7 {
            tail += term;
            term *= 16.0 / f64::from(k);
        }
        assert!(limit > 1.0 - tail && limit < 1.0, "{limit}, tail {tail}");
    }

    // ψ is orthogonal to the constant by its angular part: ∫ψ over a ball is 0,
    // and by the cube's symmetry x² and z² average alike over the cube too.
    #[test]
    fn the_two_signs_cancel() {
        let mesh = mesh(31);
        let absolute = checks::integral(&mesh, |s, _| s.abs());
        let signed = checks::integral(&mesh, |s, _| s);
        // Rounding alone: the lattice has the cube's symmetry.
        assert!(signed.abs() < 1e-11 * absolute, "{signed} of {absolute}");
    }
}
