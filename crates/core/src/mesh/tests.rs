mod adjacency;
mod blunt_fin;
mod lattice;
mod places;

use super::*;

fn scalars(count: usize) -> Scalars {
    Scalars {
        name: "s".into(),
        association: Association::Point,
        values: vec![0.0; count],
    }
}

fn corner() -> Vec<DVec3> {
    vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
}

#[test]
fn orientation_is_fixed() {
    let mesh = TetMesh::from_tetrahedra(corner(), vec![[0, 2, 1, 3]], scalars(4)).expect("valid");
    let [a, b, c, d] = mesh.cell_points(0);
    assert_eq!((b - a).dot((c - a).cross(d - a)), 1.0);
}

#[test]
fn faces_point_outward() {
    let mesh = TetMesh::from_tetrahedra(corner(), vec![[0, 1, 2, 3]], scalars(4)).expect("valid");
    let corners = mesh.cell_points(0);
    for (opposite, face) in FACES.iter().enumerate() {
        let [a, b, c] = face.map(|i| corners[i]);
        assert!((b - a).cross(c - a).dot(corners[opposite] - a) < 0.0);
    }
}

#[test]
fn two_cells_are_neighbors() {
    let mut points = corner();
    points.push(DVec3::ONE);
    let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3], [4, 1, 3, 2]], scalars(5))
        .expect("valid");
    let none = NO_NEIGHBOR;
    assert_eq!(
        mesh.neighbors(),
        [[1, none, none, none], [0, none, none, none]]
    );
    assert_eq!(mesh.boundary_faces().len(), 6);
}

/// A cube of one hexahedron, and on its face x = 1, corners 1 2 6 5, two tetrahedra to point 8 beyond it, cut
/// along 1 6 or 2 5.
fn cube_with_a_roof(along: [u64; 2], lifted: f64) -> TetMesh {
    let mut points: Vec<DVec3> = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        .into_iter()
        .chain([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
        .map(|p| DVec3::from_array(p.map(f64::from)))
        .collect();
    points[6].x += lifted;
    points.push(DVec3::new(3.0, 0.5, 0.5));
    let [a, b] = along;
    let [c, d] = if along == [1, 6] { [2, 5] } else { [1, 6] };
    let cells = Cells {
        connectivity: [
            vec![0, 1, 2, 3, 4, 5, 6, 7],
            vec![a, b, c, 8],
            vec![a, b, d, 8],
        ]
        .concat(),
        offsets: vec![0, 8, 12, 16],
        types: vec![12, 10, 10],
    };
    TetMesh::new(points, &cells, scalars(9)).expect("valid")
}

// The hexahedron's faces are cut from their least corner: 1.
#[test]
fn a_face_that_is_cut_along_both_diagonals_is_counted() {
    let crossed = |along, lifted| {
        let report = cube_with_a_roof(along, lifted).report();
        let notes = report.notes().join("\n");
        assert_eq!(
            report.crossed_faces > 0,
            notes.contains("other diagonal"),
            "{notes}"
        );
        report.crossed_faces
    };
    for lifted in [0.0, 0.25] {
        assert_eq!(crossed([1, 6], lifted), 0);
        assert_eq!(crossed([2, 5], lifted), 1);
    }
    // A hexahedron by itself, and two that were cut alike, cross nothing.
    assert_eq!(cube_with_a_roof([1, 6], 0.0).boundary_faces().len(), 10 + 4);
    assert_eq!(cube_with_a_roof([2, 5], 0.0).boundary_faces().len(), 12 + 6);
}

#[test]
fn bad_input_is_named() {
    let error = |points: Vec<DVec3>, cells: Vec<[u32; 4]>, values| {
        TetMesh::from_tetrahedra(points, cells, scalars(values))
            .expect_err("invalid")
            .to_string()
    };
    assert_eq!(
        error(corner(), vec![[0, 1, 2, 3], [0, 1, 2, 4]], 4),
        "cell 1 uses point 4, but there are 4 points, counted from 0"
    );
    let mut points = corner();
    points[2].y = f64::NAN;
    assert_eq!(
        error(points, vec![[0, 1, 2, 3]], 4),
        "cell 0 uses point 2, which lies at (0, NaN, 0)"
    );
    assert_eq!(
        error(corner(), vec![[0, 1, 2, 3]], 5),
        "field 's' has 5 values for 4 points"
    );
}

fn cells(list: &[(u8, &[u64])]) -> Cells {
    let mut cells = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    for (cell_type, points) in list {
        cells.types.push(*cell_type);
        cells.connectivity.extend_from_slice(points);
        cells.offsets.push(cells.connectivity.len() as u64);
    }
    cells
}

/// Offsets of a cube's corners in VTK's order of a hexahedron.
const CUBE: [[u8; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

fn cube() -> Vec<DVec3> {
    CUBE.map(|corner| DVec3::from_array(corner.map(f64::from)))
        .to_vec()
}

#[test]
fn each_type_fills_its_cell() {
    let hexagon = |z: f64| {
        (0..6).map(move |i| {
            DVec3::from((
                glam::DVec2::from_angle(f64::from(i) * std::f64::consts::FRAC_PI_3),
                z,
            ))
        })
    };
    let prism: Vec<DVec3> = hexagon(0.0).chain(hexagon(1.0)).collect();
    // (type, points, cell, volume): a regular hexagon of side 1 has the area √27/2, and a
    // pentagon that lacks one of its corners √27/2 − √3/4.
    let hexagon_area = 27_f64.sqrt() / 2.0;
    let pentagon_area = hexagon_area - 3_f64.sqrt() / 4.0;
    let cases: [(u8, Vec<DVec3>, &[u64], f64); 7] = [
        (10, cube(), &[0, 1, 2, 5], 1.0 / 6.0),
        (11, cube(), &[0, 1, 3, 2, 4, 5, 7, 6], 1.0),
        (12, cube(), &[0, 1, 2, 3, 4, 5, 6, 7], 1.0),
        (13, cube(), &[0, 1, 2, 4, 5, 6], 0.5),
        (14, cube(), &[0, 1, 2, 3, 4], 1.0 / 3.0),
        (
            15,
            prism.clone(),
            &[0, 1, 2, 3, 4, 6, 7, 8, 9, 10],
            pentagon_area,
        ),
        (
            16,
            prism,
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
            hexagon_area,
        ),
    ];
    for (cell_type, points, indices, volume) in cases {
        let count = points.len();
        let mesh =
            TetMesh::new(points, &cells(&[(cell_type, indices)]), scalars(count)).expect("valid");
        // A dozen roundings of numbers up to 1.
        assert!(
            (mesh.volume() - volume).abs() < 16.0 * f64::EPSILON,
            "type {cell_type}"
        );
        let report = mesh.report();
        assert_eq!(
            (report.flipped, report.folded, report.degenerate),
            (0, 0, 0),
            "type {cell_type}"
        );
        assert!(mesh.boundary_statistics().convex, "type {cell_type}");
    }
}

#[test]
fn both_orders_of_a_wedge_are_right() {
    for indices in [[0, 1, 2, 4, 5, 6], [0, 2, 1, 4, 6, 5]] {
        let mesh = TetMesh::new(cube(), &cells(&[(13, &indices)]), scalars(8)).expect("valid");
        assert_eq!(mesh.volume(), 0.5);
        assert_eq!(mesh.report().folded, 0);
        assert_eq!(mesh.cell_count(), 3);
    }
}

#[test]
fn a_cell_flatter_than_rounding_has_no_volume_below_0() {
    // Six times its volume is 8e-32, and −2e-31 in f64.
    let above = 1.0 + f64::EPSILON;
    let points = vec![
        DVec3::new(3.0, above, above),
        DVec3::new(1.5, 1e-17, -1.0),
        DVec3::new(above, 1.0, 1.0),
        DVec3::new(-1.0, 1.0, above),
    ];
    let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars(4)).expect("valid");
    assert_eq!(mesh.report().degenerate, 1);
    assert_eq!(mesh.volume(), 0.0);
}

#[test]
fn a_mirrored_hexahedron_is_fixed_and_counted() {
    let mesh = TetMesh::new(
        cube(),
        &cells(&[(12, &[4, 5, 6, 7, 0, 1, 2, 3])]),
        scalars(8),
    )
    .expect("valid");
    assert_eq!(mesh.volume(), 1.0);
    assert_eq!(mesh.report().flipped, 1);
}

#[test]
fn a_mesh_keeps_its_cells_if_asked() {
    let mut points = cube();
    points.extend((1..=6).map(|i| DVec3::X * f64::from(i)));
    let list = [
        (5, &[0, 1, 2][..]),
        (12, &[0, 1, 2, 3, 4, 5, 6, 7]),
        (24, &[8, 1, 2, 5, 9, 10, 11, 12, 13, 8]),
    ];
    let given = Arc::new(cells(&list));
    let split = Split::default();
    let mesh = TetMesh::keeping_cells(points.clone(), given.clone(), scalars(14), split);
    let mesh = mesh.expect("valid");
    let other = mesh.with_scalars(scalars(14)).expect("as many");
    for mesh in [&mesh, &other] {
        let kept = mesh.cells().expect("asked for");
        assert!(Arc::ptr_eq(kept, &given));
        for (cell, corners) in mesh.tetrahedra().iter().enumerate() {
            let (_, named) = list[mesh.source_cell(cell)];
            assert!(corners.iter().all(|&c| named.contains(&u64::from(c))));
        }
    }
    let without = TetMesh::new(points, &given, scalars(14)).expect("valid");
    assert_eq!(without.cells(), None);
    assert_eq!(without.tetrahedra(), mesh.tetrahedra());
}

#[test]
fn curved_cells_keep_their_corners_and_flat_ones_are_skipped() {
    let mut points = cube();
    points.extend(corner());
    let mesh = TetMesh::new(
        points,
        &cells(&[
            (5, &[0, 1, 2]),
            (24, &[0, 1, 2, 5, 8, 8, 8, 8, 8, 8]),
            (1, &[3]),
            (71, &[0, 2, 3, 7]),
        ]),
        Scalars {
            association: Association::Cell,
            ..scalars(4)
        },
    )
    .expect("valid");
    let report = mesh.report();
    assert_eq!(report.quadratic, 2);
    assert_eq!(report.skipped, [(1, 1), (5, 1)].into());
    // The points in the middle of edges are named: 8, at least.
    assert_eq!(report.unused_points, 12 - 7);
    assert_eq!(mesh.source_cell(0), 1);
    assert_eq!(mesh.source_cell(1), 3);
    assert_eq!(
        report.notes(),
        [
            "1 × vertex: no volume, left out",
            "1 × triangle: no volume, left out",
            "2 curved cells are drawn by their corners, with straight edges and linear fields",
            "5 points belong to no cell",
        ]
    );
}

#[test]
fn a_warped_face_is_counted_and_measured() {
    let mut points = cube();
    let flat = TetMesh::new(
        points.clone(),
        &cells(&[(12, &[0, 1, 2, 3, 4, 5, 6, 7])]),
        scalars(8),
    );
    assert_eq!(flat.expect("valid").report().warped, 0);
    let corner = points.iter_mut().find(|p| **p == DVec3::ONE);
    corner.expect("a unit cube").z = 1.5;
    let mesh = TetMesh::new(
        points,
        &cells(&[(12, &[0, 1, 2, 3, 4, 5, 6, 7])]),
        scalars(8),
    )
    .expect("valid");
    let report = mesh.report();
    assert_eq!(report.warped, 1);
    // Diagonals u = (1, 1, ½), 1.5 long, and v = (−1, 1, 0); u × v = (−½, −½, 2), and the
    // side (1, 0, 0) between them: ½ / √4.5 / 1.5.
    assert!((report.warp - 0.5 / 4.5_f64.sqrt() / 1.5).abs() < 1e-15);
    assert!(report.notes()[0].contains("at up to 0.16 of its length"));
}

#[test]
fn repeated_and_collapsed_tetrahedra_are_left_out() {
    let mut points = corner();
    points.push(DVec3::ONE);
    let mesh = TetMesh::from_tetrahedra(
        points,
        vec![[0, 1, 2, 3], [2, 3, 1, 1], [1, 0, 2, 3], [4, 1, 3, 2]],
        Scalars {
            association: Association::Cell,
            values: vec![1.0, 2.0, 3.0, 4.0],
            name: "s".into(),
        },
    )
    .expect("valid");
    let report = mesh.report();
    assert_eq!(
        (report.tetrahedra, report.duplicates, report.collapsed),
        (2, 1, 1)
    );
    assert_eq!(mesh.cell_scalars(1), [4.0; 4]);
    assert_eq!(mesh.boundary_faces().len(), 6);
}

#[test]
fn a_face_of_three_cells_is_counted() {
    let mut points = corner();
    points.extend([DVec3::ONE, DVec3::splat(2.0)]);
    let mesh = TetMesh::from_tetrahedra(
        points,
        vec![[0, 1, 2, 3], [4, 1, 2, 3], [5, 1, 2, 3]],
        scalars(6),
    )
    .expect("valid");
    assert_eq!(mesh.report().crowded_faces, 1);
    assert_eq!(mesh.boundary_faces().len(), 12);
    assert!(!mesh.boundary_statistics().convex);
}

#[test]
fn undefined_scalars_are_counted_where_cells_use_them() {
    let mut points = corner();
    points.push(DVec3::ONE);
    let mut field = scalars(5);
    field.values[1] = f64::NAN;
    field.values[4] = f64::NAN;
    let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], field).expect("valid");
    assert_eq!(mesh.report().non_finite_scalars, 1);
    assert_eq!(mesh.scalar_range(), Some((0.0, 0.0)));
}

/// So that no renderer has to know more than NaN.
#[test]
fn a_scalar_that_is_not_finite_in_f32_becomes_nan() {
    let most = f64::from(f32::MAX);
    let values = vec![f64::INFINITY, -1e39, most, -most];
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values,
    };
    let mesh = TetMesh::from_tetrahedra(corner(), vec![[0, 1, 2, 3]], scalars).expect("valid");
    let kept = &mesh.scalars().values;
    assert!(kept[0].is_nan() && kept[1].is_nan());
    assert_eq!(kept[2..], [most, -most]);
    assert_eq!(mesh.report().non_finite_scalars, 2);
    assert_eq!(mesh.scalar_range(), Some((-most, most)));
}

#[test]
fn a_nearly_flat_cell_is_oriented_exactly() {
    // In f64, 1/3 is (1 − 2⁻⁵⁴)/3, and the next numbers follow at steps of 2⁻⁵⁴: two steps
    // put the fourth point 2⁻⁵⁴ beyond the plane x + y + z = 1, less than f64
    // determinants resolve.
    let third = DVec3::splat(1.0) / 3.0;
    let points = vec![
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::new(third.x, third.y, third.z.next_up().next_up()),
    ];
    for (cell, oriented) in [([0, 1, 2, 3], [0, 1, 2, 3]), ([0, 2, 1, 3], [0, 2, 3, 1])] {
        let mesh = TetMesh::from_tetrahedra(points.clone(), vec![cell], scalars(4)).expect("valid");
        assert_eq!(mesh.report().degenerate, 1);
        assert_eq!(mesh.tetrahedra(), [oriented]);
    }
}

#[test]
fn bad_cells_are_named() {
    let error = |cells: Cells| {
        TetMesh::new(cube(), &cells, scalars(8))
            .expect_err("invalid")
            .to_string()
    };
    let tetrahedron: (u8, &[u64]) = (10, &[0, 1, 2, 5]);
    assert_eq!(
        error(cells(&[tetrahedron, (42, &[0, 1, 2])])),
        "cell 1 is a polyhedron, which is not supported"
    );
    assert_eq!(
        error(cells(&[tetrahedron, (99, &[])])),
        "cell 1 is a cell of VTK type 99, which is not supported"
    );
    assert_eq!(
        error(cells(&[tetrahedron, (12, &[0, 1, 2])])),
        "cell 1 is a hexahedron of 3 points; it must have 8"
    );
    assert_eq!(
        error(cells(&[(10, &[0, 1, 2, u64::MAX])])),
        "cell 0 uses point 18446744073709551615, but there are 8 points, counted from 0"
    );
    assert_eq!(
        error(cells(&[(5, &[0, 1, 2])])),
        "the mesh has no volume cells, only 1 × triangle"
    );
    let mut broken = cells(&[tetrahedron, tetrahedron]);
    broken.offsets = vec![0, 9, 8];
    assert_eq!(
        error(broken.clone()),
        "cell 1 begins at 9 in the connectivity and ends before, at 8"
    );
    broken.offsets = vec![0, 4, 9];
    assert_eq!(
        error(broken.clone()),
        "cell offsets run from 0 to 9; they must run from 0 to 8, the length of the connectivity"
    );
    broken.offsets = vec![];
    assert_eq!(error(broken), "2 cells need 3 offsets, there are 0");
}

#[test]
fn meshes_that_are_the_same_share_their_geometry() {
    let mesh = |points: Vec<DVec3>, kind: u8, value: f64| {
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: vec![value; points.len()],
        };
        let corners: &[u64] = match kind {
            10 => &[0, 1, 2, 5],
            _ => &[0, 1, 2, 3, 4, 5, 6, 7],
        };
        TetMesh::new(points, &cells(&[(kind, corners)]), scalars).expect("a mesh")
    };
    let first = mesh(cube(), 12, 1.0);
    let next = mesh(cube(), 12, 2.0);
    assert!(!next.shares_geometry(&first));
    let next = next.sharing_with(&first);
    assert!(next.shares_geometry(&first));
    assert_eq!(next.scalars().values, [2.0; 8]);
    let mut moved = cube();
    moved[7].x = -0.0; // not the same bits
    for other in [mesh(moved, 12, 2.0), mesh(cube(), 10, 2.0)] {
        assert!(!other.sharing_with(&first).shares_geometry(&first));
    }
}
