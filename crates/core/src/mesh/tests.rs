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
