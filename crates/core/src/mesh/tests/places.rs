//! Points that coincide without being the same.

use super::*;

/// Two cells on either side of the face x + y + z = 1, each with points of its own; the
/// second writes some zeros as −0.
fn two_cells() -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut points = corner();
    points.extend([
        DVec3::ONE,
        DVec3::new(1.0, -0.0, 0.0),
        DVec3::new(0.0, 1.0, -0.0),
        DVec3::new(-0.0, -0.0, 1.0),
    ]);
    (points, vec![[0, 1, 2, 3], [4, 5, 7, 6]])
}

#[test]
fn faces_that_coincide_are_shared() {
    let (points, cells) = two_cells();
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars(8)).expect("valid");
    let none = NO_NEIGHBOR;
    assert_eq!(
        mesh.neighbors(),
        [[1, none, none, none], [0, none, none, none]]
    );
    assert_eq!(mesh.places(), [[0, 1, 2, 3], [4, 1, 3, 2]]);
    assert_eq!(mesh.tetrahedra(), [[0, 1, 2, 3], [4, 5, 7, 6]]);
    let report = mesh.report();
    assert_eq!((report.coincident_points, report.joined_faces), (3, 1));
    assert_eq!(
        report.notes(),
        ["1 faces were joined whose points coincide without being the same"]
    );
    let boundary = mesh.boundary_statistics();
    assert_eq!(
        (boundary.faces, boundary.edges, boundary.vertices),
        (6, 9, 5)
    );
    assert!(boundary.convex);
}

#[test]
fn places_are_the_cells_where_nothing_coincides() {
    // Point 4 lies where point 1 does, but no cell uses it.
    let mut points = corner();
    points.push(DVec3::X);
    let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars(5)).expect("valid");
    assert!(std::ptr::eq(mesh.places(), mesh.tetrahedra()));
    let report = mesh.report();
    assert_eq!((report.coincident_points, report.joined_faces), (0, 0));
    assert!(mesh.is_continuous());
}

#[test]
fn a_place_is_named_by_a_point_that_cells_use() {
    // Point 0 lies where point 1 does and is unused; 2 lies there too, and only a cell
    // that is left out uses it.
    let points = vec![
        DVec3::X,
        DVec3::X,
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::ZERO,
    ];
    let cells = vec![[2, 3, 4, 1], [5, 1, 3, 4]];
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars(6)).expect("valid");
    assert_eq!(mesh.report().collapsed, 1);
    assert_eq!(mesh.places(), [[5, 1, 3, 4]]);
    assert!(std::ptr::eq(mesh.places(), mesh.tetrahedra()));
}

#[test]
fn values_that_differ_at_one_place_are_a_discontinuous_field() {
    let (points, cells) = two_cells();
    let field = |association, values: &[f64]| Scalars {
        name: "s".into(),
        association,
        values: values.to_vec(),
    };
    let nan = f64::NAN;
    let equal = field(
        Association::Point,
        &[0.0, 1.0, nan, 0.0, 4.0, 1.0, nan, -0.0],
    );
    let mesh = TetMesh::from_tetrahedra(points, cells, equal).expect("valid");
    assert!(mesh.is_continuous());
    for (association, values, continuous) in [
        (
            Association::Point,
            &[0.0, 1.0, 2.0, 3.0, 4.0, 1.5, 2.0, 3.0][..],
            false,
        ),
        (
            Association::Point,
            &[0.0, 1.0, nan, 3.0, 4.0, 1.0, 2.0, 3.0],
            false,
        ),
        (Association::Cell, &[1.0, 2.0], true),
    ] {
        let other = mesh
            .with_scalars(field(association, values))
            .expect("valid");
        assert_eq!(other.is_continuous(), continuous, "{values:?}");
    }
    assert!(mesh.is_continuous());
}

#[test]
fn a_cell_that_is_there_already_is_left_out_whatever_its_points() {
    let mut points = corner();
    points.extend(corner());
    let values = vec![1.0, 2.0];
    let field = Scalars {
        name: "s".into(),
        association: Association::Cell,
        values,
    };
    let cells = vec![[0, 1, 2, 3], [7, 5, 4, 6]];
    let mesh = TetMesh::from_tetrahedra(points, cells, field).expect("valid");
    assert_eq!((mesh.cell_count(), mesh.report().duplicates), (1, 1));
    assert_eq!(mesh.cell_scalars(0), [1.0; 4]);
    assert_eq!(mesh.report().crowded_faces, 0);
}

#[test]
fn a_cell_with_two_corners_at_one_place_holds_nothing_together() {
    // Between two cells lies one without inside: points 3 and 4 coincide.
    let mut points = corner();
    points.extend([DVec3::Z, -DVec3::Y]);
    let cells = vec![[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 5]];
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars(6)).expect("valid");
    let report = mesh.report();
    assert_eq!(
        (report.tetrahedra, report.collapsed, report.degenerate),
        (2, 1, 0)
    );
    assert_eq!(report.joined_faces, 1);
    assert_eq!(mesh.boundary_faces().len(), 6);
    for row in mesh.places() {
        assert!((1..4).all(|i| !row[..i].contains(&row[i])), "{row:?}");
    }
}

/// 125 hexahedra between the same planes, numbered by hand; each has points of its own.
#[test]
fn hexahedra_without_common_points_are_cut_as_if_they_shared_them() {
    let mut points = Vec::new();
    let mut list: Vec<(u8, Vec<u64>)> = Vec::new();
    for cube in 0..125_u32 {
        let at = DVec3::new((cube % 5).into(), (cube / 5 % 5).into(), (cube / 25).into());
        let first = points.len() as u64;
        // Each begins with another corner: turned about z, and upside down.
        let turn = (0..4).map(|i| (i + cube as usize) % 4);
        let order: Vec<usize> = match cube % 3 {
            0 => turn.clone().chain(turn.map(|i| i + 4)).collect(),
            _ => turn
                .clone()
                .rev()
                .map(|i| i + 4)
                .chain(turn.rev())
                .collect(),
        };
        points.extend(order.iter().map(|&i| at + cube_corner(i)));
        list.push((12, (first..first + 8).collect()));
    }
    let list: Vec<(u8, &[u64])> = list.iter().map(|(t, c)| (*t, c.as_slice())).collect();
    for split in [Split::SmallestIndex, Split::FiveAlternating] {
        let count = points.len();
        let mesh = TetMesh::with_split(points.clone(), &cells(&list), scalars(count), split)
            .expect("valid");
        let boundary = mesh.boundary_statistics();
        assert_eq!(boundary.faces, 6 * 25 * 2, "{split:?}");
        assert!(boundary.convex, "{split:?}");
        let report = mesh.report();
        assert_eq!(report.coincident_points, 1000 - 216, "{split:?}");
        // Between cubes there are 3 · 4 · 25 quadrilaterals, each of two triangles.
        assert_eq!(report.joined_faces, 600, "{split:?}");
    }
}

fn cube_corner(i: usize) -> DVec3 {
    DVec3::from_array(CUBE[i].map(f64::from))
}

/// The ring of three hexahedra that cannot be colored, each with points of its own: their
/// colors agree across two seams, and the third is left open.
#[test]
fn an_odd_ring_of_blocks_is_cut_into_five_each() {
    let corner = |third: u32, radius: f64, z: f64| {
        let angle = f64::from(third % 3) * std::f64::consts::TAU / 3.0;
        DVec3::from((glam::DVec2::from_angle(angle) * radius, z))
    };
    let mut points = Vec::new();
    let mut list: Vec<(u8, Vec<u64>)> = Vec::new();
    for third in 0..3 {
        let first = points.len() as u64;
        for z in [0.0, 1.0] {
            let ring = [(0, 1.0), (0, 2.0), (1, 2.0), (1, 1.0)];
            points.extend(ring.map(|(next, radius)| corner(third + next, radius, z)));
        }
        list.push((12, (first..first + 8).collect()));
    }
    let list: Vec<(u8, &[u64])> = list.iter().map(|(t, c)| (*t, c.as_slice())).collect();
    let mesh = TetMesh::with_split(points, &cells(&list), scalars(24), Split::FiveAlternating)
        .expect("valid");
    assert_eq!(mesh.cell_count(), 15);
    assert_eq!(mesh.report().joined_faces, 4);
    assert!(!mesh.boundary_statistics().closed);
}
