//! The distance from the middle of a cube: isosurfaces are spheres.
//!
//! Weiler, Kraus and Ertl 2002, figure 13 (left) and tables 1 to 3: "an
//! analytical dataset of about 150K tetrahedra", 148 955 in the tables. They do
//! not say how it is cut; 148 955 = 5 · 31³, so ours is a lattice of 31³ cubes
//! in five tetrahedra each, which is that number exactly.

use tetrascope_core::clusters::CellSource;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Bounds, CameraFit, Error, Scalars, TetMesh};

use crate::lattice::{Lattice, Split, nearest_dimensions};
use crate::{Dataset, Look, MOST_CELLS, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "sphere",
    about: "a cube of tetrahedra with the distance from its middle; convex",
    paper: "Weiler, Kraus, Ertl 2002, figure 13 and tables 1 to 3",
    default_cells: 148_955,
    max_cells: MOST_CELLS,
    seeded: false,
    make: Make::Mesh(make),
    cells: Some(cells),
    look,
};

fn lattice(cells: u64) -> Lattice {
    Lattice::centered(1.0, nearest_dimensions(cells, Split::Five))
}

/// The cells, told from their numbers.
struct Cells(Lattice);

fn cells(cells: u64) -> Box<dyn CellSource> {
    Box::new(Cells(lattice(cells)))
}

impl CellSource for Cells {
    fn bounds(&self) -> Bounds {
        let ends = |axis: &Vec<f64>| [axis[0], axis[axis.len() - 1]];
        let [x, y, z] = self.0.axes.each_ref().map(ends);
        Bounds {
            min: DVec3::new(x[0], y[0], z[0]),
            max: DVec3::new(x[1], y[1], z[1]),
        }
    }

    fn field(&self) -> (&str, Association) {
        (FIELD, Association::Point)
    }

    fn cell_count(&self) -> u64 {
        self.0.cell_count(Split::Five)
    }

    fn cell(&self, cell: u64) -> [u32; 4] {
        self.0.tetrahedron(Split::Five, cell)
    }

    fn point(&self, point: u32) -> DVec3 {
        self.0.point(point)
    }

    fn value(&self, point: u64) -> f64 {
        self.0.point(point as u32).length()
    }
}

const FIELD: &str = "distance";

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    let lattice = lattice(cells);
    let points = lattice.points();
    let scalars = Scalars {
        name: FIELD.into(),
        association: Association::Point,
        values: points.iter().map(|p| p.length()).collect(),
    };
    TetMesh::from_tetrahedra(points, lattice.tetrahedra(Split::Five), scalars)
}

/// A thin shell around a solid core, as in the paper's figure of two isosurfaces.
fn look() -> Look {
    let core = [1.0, 0.42, 0.06];
    let shell = [0.08, 0.38, 0.95];
    Look {
        fit: CameraFit::PlusIso,
        knots: vec![
            knot(0.0, core, 9.0),
            knot(0.34, core, 9.0),
            knot(0.42, [0.8, 0.16, 0.04], 0.0),
            knot(0.66, shell, 0.0),
            knot(0.78, shell, 2.5),
            knot(0.90, [0.3, 0.7, 1.0], 0.0),
            knot(1.73, [0.3, 0.7, 1.0], 0.0),
        ],
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: Option<u64>) -> TetMesh {
        DATASET
            .mesh(&Options { cells, seed: None })
            .expect("valid options")
    }

    #[test]
    fn it_has_the_papers_number_of_cells() {
        let mesh = mesh(None);
        assert_eq!(mesh.cell_count(), 148_955);
        assert_eq!(mesh.points().len(), 32 * 32 * 32);
        checks::conforms(&mesh);
        checks::positive(&mesh);
        // 8, the cube's volume; 148 955 additions err by at most as many ulps of 8.
        assert!((checks::volume(&mesh) - 8.0).abs() < 148_955.0 * 8.0 * f64::EPSILON);
        // Two triangles on each of 31² squares of six sides: nothing inside is open.
        assert_eq!(checks::boundary(&mesh).len(), 2 * 6 * 31 * 31);
    }

    #[test]
    fn the_range_is_from_the_middle_to_the_corner() {
        // An odd lattice has a cube in the middle, an even one a point.
        let (low, high) = mesh(None).scalar_range().expect("finite");
        assert!((low - 3f64.sqrt() / 31.0).abs() < 1e-15);
        assert_eq!(high, 3f64.sqrt());
        assert_eq!(mesh(Some(5 * 64)).scalar_range(), Some((0.0, 3f64.sqrt())));
    }

    // The mean distance from the middle of [−1, 1]³ is √3/4 − π/24 + ln(2 + √3)/2;
    // linear interpolation in each tetrahedron errs as h².
    #[test]
    fn the_field_converges_at_second_order() {
        let mean = 3f64.sqrt() / 4.0 - PI / 24.0 + (2.0 + 3f64.sqrt()).ln() / 2.0;
        let error =
            |n: u64| (checks::integral(&mesh(Some(5 * n * n * n)), |s, _| s) - 8.0 * mean).abs();
        let ratio = error(8) / error(16);
        // 4 in the limit; the kink in the middle, a volume of h³, costs under 5 %.
        assert!((3.8..4.2).contains(&ratio), "{ratio}");
    }
}
