//! Small meshes.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Scalars, TetMesh, Volume};
use tetrascope_datasets::{Options, find};

/// A data set of about `cells` cells, or of its own size.
pub fn data_set(name: &str, cells: Option<u64>) -> TetMesh {
    let options = Options {
        cells,
        ..Options::default()
    };
    let dataset = find(name).expect("a data set");
    dataset.mesh(&options).expect("a mesh")
}

/// A field `s` with these values at points.
pub fn point_scalars(values: Vec<f64>) -> Scalars {
    Scalars {
        name: "s".into(),
        association: Association::Point,
        values,
    }
}

/// A mesh of these tetrahedra with the field `scalar` at its points.
pub fn mesh(
    (points, tetrahedra): (Vec<DVec3>, Vec<[u32; 4]>),
    scalar: impl Fn(DVec3) -> f64,
) -> TetMesh {
    let scalars = point_scalars(points.iter().map(|p| scalar(*p)).collect());
    TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a valid mesh")
}

/// A mesh of these points, tetrahedra and values at the points.
pub fn cells(points: &[[f64; 3]], cells: &[[u32; 4]], values: &[f64]) -> Volume {
    let points = points.iter().map(|&p| p.into()).collect();
    let mesh = TetMesh::from_tetrahedra(points, cells.to_vec(), point_scalars(values.to_vec()));
    Volume::Mesh(mesh.expect("a mesh"))
}

/// The mesh in `volume`.
pub fn tetrahedra_of(volume: &Volume) -> &TetMesh {
    match volume {
        Volume::Mesh(mesh) => mesh,
        other => panic!("a mesh: {other:?}"),
    }
}

/// The six tetrahedra around a cube's diagonal from corner 0 to 7; bit i of a corner is its
/// place along axis i (H. W. Kuhn, 1960).
pub const CUBE: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 3, 2, 7],
    [0, 2, 6, 7],
    [0, 6, 4, 7],
    [0, 4, 5, 7],
    [0, 5, 1, 7],
];

/// The tetrahedra of n³ cubes, of those that `keep` accepts by their places along the axes;
/// points and cubes are numbered along x first, then y, then z.
pub fn kuhn_cells(n: usize, keep: impl Fn([usize; 3]) -> bool) -> Vec<[u32; 4]> {
    let cubes = (0..n * n * n).map(|i| [i % n, i / n % n, i / (n * n)]);
    let tetrahedra = cubes.filter(|cube| keep(*cube)).flat_map(|[x, y, z]| {
        let corner = |c: usize| {
            let [x, y, z] = [x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)];
            (x + (n + 1) * (y + (n + 1) * z)) as u32
        };
        CUBE.map(|tetrahedron| tetrahedron.map(corner))
    });
    tetrahedra.collect()
}

/// The box from `min` to `max`, cut into n³ boxes of six tetrahedra each, of which there are
/// those that `keep` accepts.
pub fn kuhn(
    n: usize,
    min: DVec3,
    max: DVec3,
    keep: impl Fn([usize; 3]) -> bool,
) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let side = n + 1;
    let points = (0..side * side * side).map(|i| {
        let [x, y, z] = [i % side, i / side % side, i / (side * side)].map(|i| i as f64);
        min + (max - min) * (DVec3::new(x, y, z) / n as f64)
    });
    (points.collect(), kuhn_cells(n, keep))
}

/// `count` plates on each other along z with gaps between, each 0.0008 of the extent thick. The
/// scalar goes from 0 to 1 through each.
pub fn stacked_plates(count: u32) -> Volume {
    let place = |plate: u32, corner: DVec3| {
        let z = 0.0016 * f64::from(plate) + 0.0008 * corner.z;
        DVec3::new(corner.x, corner.y, z)
    };
    boxes(count, place, |i, _| ((i >> 2) & 1) as f64)
}

/// Cubes on each other along z, of whose faces no two have the same diagonal: faces lie in
/// one place and are not the same.
pub fn mismatched(count: u32) -> Volume {
    let place = |cube: u32, corner: DVec3| {
        let x = if cube.is_multiple_of(2) {
            corner.x
        } else {
            1.0 - corner.x
        };
        DVec3::new(x, corner.y, f64::from(cube) + corner.z)
    };
    boxes(count, place, |_, p| p.x + p.y + p.z)
}

/// `count` cubes of six tetrahedra that share no point with each other. A cube's corners lie
/// where `place` puts those of the cube [0, 1]³; the scalar is that of a point's number and
/// place.
fn boxes(
    count: u32,
    place: impl Fn(u32, DVec3) -> DVec3,
    scalar: impl Fn(usize, DVec3) -> f64,
) -> Volume {
    let mut points = Vec::new();
    let mut tetrahedra = Vec::new();
    for cube in 0..count {
        let first = points.len();
        let corners = (0..8).map(|i| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(f64::from)));
        points.extend(corners.map(|corner| place(cube, corner)));
        tetrahedra.extend(CUBE.map(|cell| cell.map(|corner| (first + corner) as u32)));
    }
    let values = points.iter().enumerate().map(|(i, p)| scalar(i, *p));
    let scalars = point_scalars(values.collect());
    Volume::Mesh(TetMesh::from_tetrahedra(points, tetrahedra, scalars).expect("a mesh"))
}

/// The same cells, but no two share a point: where two touch, two faces are in one place.
pub fn split(mesh: &TetMesh) -> Volume {
    let cells = 0..mesh.cell_count();
    let points = cells.clone().flat_map(|c| mesh.cell_points(c)).collect();
    let scalars = Scalars {
        values: cells.clone().flat_map(|c| mesh.cell_scalars(c)).collect(),
        ..mesh.scalars().clone()
    };
    let tetrahedra = cells.map(|c| [0, 1, 2, 3].map(|i| 4 * c as u32 + i));
    let split = TetMesh::from_tetrahedra(points, tetrahedra.collect(), scalars);
    Volume::Mesh(split.expect("a mesh"))
}

/// The same, each cell with values of its own: some higher and steeper, some without any.
pub fn jumping(mesh: &TetMesh) -> Volume {
    let split = split(mesh);
    let split = tetrahedra_of(&split);
    let values = split.scalars().values.iter().enumerate();
    let values = values.map(|(i, s)| match i / 4 % 5 {
        0 => s * 0.8,
        1 if i % 40 == 4 => f64::NAN,
        j => s + 0.03 * j as f64,
    });
    let scalars = Scalars {
        values: values.collect(),
        ..split.scalars().clone()
    };
    let mesh = split.with_scalars(scalars).expect("as many");
    assert!(!mesh.is_continuous());
    Volume::Mesh(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_fills_its_cube() {
        let lattice = kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |c| c != [1, 1, 1]);
        let mesh = mesh(lattice, |p| p.x);
        assert_eq!(mesh.cell_count(), 6 * 26);
        assert!((mesh.volume() - 8.0 * 26.0 / 27.0).abs() < 1e-12);
    }
}
