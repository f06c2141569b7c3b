use std::fs;
use std::path::Path;

use super::*;

#[cfg(feature = "hdf5")]
mod hdf5;

fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn read_bytes(bytes: &[u8]) -> Result<MeshData, Error> {
    let source = Source {
        path: "a.e".into(),
        bytes: bytes.into(),
    };
    read(source, None)
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    let field = data.field(Some(name));
    field.unwrap_or_else(|e| panic!("{e}")).values
}

#[test]
fn coordinates_and_variables_are_read_of_both_layouts() {
    for name in ["lattice-axes.e", "lattice-together.e"] {
        let data = read_bytes(&fixture(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(data.points.len(), 27, "{name}");
        assert_eq!(data.cells.types, [10; 40], "{name}");
        let first = [0, 1, 3, 9, 1, 4, 3, 13];
        assert_eq!(data.cells.connectivity[..8], first, "{name}");
        assert_eq!(data.points[13].to_array(), [1.25, 1.0, 0.75], "{name}");
        let f = |p: &DVec3| p.x + 10.0 * p.y + 100.0 * p.z;
        let f: Vec<f64> = data.points.iter().map(f).collect();
        assert_eq!(values(&data, "f"), f, "{name}");
        let v: Vec<f64> = data.points.iter().map(|p| -p.z).collect();
        assert_eq!(values(&data, "v-z"), v, "{name}");
        let c: Vec<f64> = (0..40).map(f64::from).collect();
        assert_eq!(values(&data, "c"), c, "{name}");
        assert_eq!(data.field(None).expect("it has fields").name, "f");
        assert_eq!(data.notes, [""; 0], "{name}");
        // Moving the middle point leaves the volume of the cube.
        let mesh = data.into_mesh(None).expect("a mesh");
        assert!((mesh.volume() - 8.0).abs() < 1e-13, "{name}");
    }
}

/// The pairs of corners in whose middles the points after the corners lie: of the edges, then
/// of the faces and the whole (vtkTriQuadraticHexahedron, vtkQuadraticWedge and others).
fn middles(kind: u8) -> &'static [[usize; 2]] {
    match kind {
        24 => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        25 => &middles(29)[..12],
        26 => &[
            [0, 1],
            [1, 2],
            [2, 0],
            [3, 4],
            [4, 5],
            [5, 3],
            [0, 3],
            [1, 4],
            [2, 5],
        ],
        27 => &[
            [0, 1],
            [1, 2],
            [2, 3],
            [3, 0],
            [0, 4],
            [1, 4],
            [2, 4],
            [3, 4],
        ],
        29 => &[
            [0, 1],
            [1, 2],
            [2, 3],
            [3, 0],
            [4, 5],
            [5, 6],
            [6, 7],
            [7, 4],
            [0, 4],
            [1, 5],
            [2, 6],
            [3, 7],
            [0, 7],
            [1, 6],
            [0, 5],
            [3, 6],
            [0, 2],
            [4, 6],
            [0, 6],
        ],
        _ => &[],
    }
}

#[test]
fn every_shape_is_read_in_the_order_of_vtk() {
    let data = read_bytes(&fixture("shapes.e")).expect("a mesh");
    assert_eq!(data.cells.types, [12, 25, 29, 13, 26, 24, 14, 27]);
    for (cell, &kind) in data.cells.types.iter().enumerate() {
        let ends = &data.cells.offsets[cell..cell + 2];
        let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
        let at = |i: usize| data.points[points[i] as usize];
        let corners = tetrascope_core::mesh::volume_corners(kind).expect("a volume");
        assert_eq!(points.len(), corners + middles(kind).len());
        for (point, &[a, b]) in (corners..).zip(middles(kind)) {
            assert_eq!(
                at(point),
                (at(a) + at(b)) / 2.0,
                "type {kind}, point {point}"
            );
        }
    }
    assert_eq!(
        data.notes,
        [
            "1 SHELL4 left out: only volumes are drawn",
            "the file holds 2 time steps: the first, at 0, is read"
        ]
    );
    // The fourth block has no values.
    let stress = values(&data, "stress");
    assert!(stress[3].is_nan());
    assert_eq!((stress[2], stress[4]), (3.0, 5.0));
    let ids = values(&data, "block id");
    assert_eq!(ids, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0]);
    let x = values(&data, "x");
    assert!(x.iter().zip(&data.points).all(|(x, point)| *x == point.x));
    // Three cubes, two wedges, a corner of a cube and two pyramids.
    let volume = data.into_mesh(Some("x")).expect("a mesh").volume();
    assert!(
        (volume - (3.0 + 1.0 + 1.0 / 6.0 + 2.0 / 3.0)).abs() < 1e-13,
        "{volume}"
    );
}

#[test]
fn axes_are_joined_where_all_three_follow() {
    let joined = |names: &[&str]| {
        let names: Vec<_> = names.iter().map(|n| n.to_string()).zip(1..).collect();
        let fields = vectors(&names).into_iter();
        fields.map(|(name, v)| (name, v.len())).collect::<Vec<_>>()
    };
    let of = |name: &str, n| (name.to_owned(), n);
    assert_eq!(joined(&["vel_x", "vel_y", "vel_z"]), [of("vel", 3)]);
    assert_eq!(
        joined(&["T", "VELX", "VELY", "VELZ"]),
        [of("T", 1), of("VEL", 3)]
    );
    assert_eq!(
        joined(&["x", "y", "z"]),
        [of("x", 1), of("y", 1), of("z", 1)]
    );
    assert_eq!(
        joined(&["ax", "by", "az"]),
        [of("ax", 1), of("by", 1), of("az", 1)]
    );
    assert_eq!(joined(&["vx", "vy"]), [of("vx", 1), of("vy", 1)]);
}

/// Replaces the one place where `from` is.
fn edited(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|w| w == from);
    let at = at.expect("it is there");
    let mut bytes = bytes.to_vec();
    bytes[at..at + to.len()].copy_from_slice(to);
    bytes
}

#[test]
fn what_is_wrong_is_said() {
    let bytes = fixture("lattice-axes.e");
    // The first cell: nodes 1, 2, 4 and 10.
    let cell = [0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, 10];
    let mut far = cell;
    far[15] = 28;
    let mut none = cell;
    none[3] = 0;
    let nodes = b"num_nodes\0\0\0\0\0\0\x1b";
    for (from, to, words) in [
        (&cell[..], &far[..], "element 1 uses node 28 of 27, in"),
        (&cell, &none, "element 1 uses node 0 of 27, in"),
        (b"TETRA", b"TET99", "1"),
        (b"TETRA", b"NODES", "the file has no volumes"),
        (b"TETRA", b"HEX20", "HEX20 of 4 nodes are not read"),
        (b"coordx", b"coordw", "is not an Exodus mesh"),
        (b"coordz", b"coordw", "variable 'coordz'"),
        (nodes, b"num_nodes\0\0\0\0\0\0\x1a", ""),
        (
            nodes,
            b"num_nodes\0\0\0\x7f\xff\xff\xff",
            "but the file has only",
        ),
    ] {
        let result = read_bytes(&edited(&bytes, from, to));
        match result {
            Ok(_) => assert!(words == "1", "{words}"),
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains(words), "{words}: {message}");
                assert!(!message.contains('\n'), "{message}");
            }
        }
    }
}

#[test]
fn every_truncation_is_an_error_or_the_whole_mesh() {
    for name in ["lattice-axes.e", "shapes.e"] {
        let bytes = fixture(name);
        for length in (1..bytes.len()).step_by(7) {
            match read_bytes(&bytes[..length]) {
                Ok(data) => panic!("{name} cut to {length}: {} cells", data.cells.types.len()),
                Err(error) => assert!(matches!(error, Error::Format { .. }), "{length}: {error}"),
            }
        }
    }
}

#[test]
fn damaged_files_do_not_panic() {
    let mut state = 7_u64;
    let mut random = || {
        // Marsaglia's xorshift.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as usize
    };
    for name in ["lattice-axes.e", "lattice-together.e", "shapes.e"] {
        let bytes = fixture(name);
        for _ in 0..300 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random() % 3 {
                // Most of what can go wrong is in the header.
                let end = if random() % 2 == 0 {
                    1500
                } else {
                    damaged.len()
                };
                let at = random() % end.min(damaged.len());
                damaged[at] = if random() % 3 == 0 {
                    0xff
                } else {
                    random() as u8
                };
            }
            if let Ok(data) = read_bytes(&damaged) {
                let _ = data.field_list();
            }
        }
    }
}

#[test]
fn a_time_step_is_read_where_it_is_chosen() {
    let source = || Source {
        path: "a.e".into(),
        bytes: fixture("shapes.e"),
    };
    assert_eq!(steps(source()).expect("times"), [0.0, 0.5]);
    for choice in [StepChoice::Number(1), StepChoice::Time(0.5)] {
        let data = read(source(), Some(choice)).expect("a mesh");
        let note = "the file holds 2 time steps: number 1, at 0.5, is read";
        assert!(data.notes.iter().any(|n| n == note), "{:?}", data.notes);
        let stress = values(&data, "stress");
        assert_eq!((stress[2], stress[4]), (6.0, 10.0));
        let x = values(&data, "x");
        let twice = x.iter().zip(&data.points).all(|(x, p)| *x == 2.0 * p.x);
        assert!(twice, "{x:?}");
    }
    let error = read(source(), Some(StepChoice::Time(0.25))).expect_err("between");
    assert!(error.to_string().contains("number 1 at 0.5"), "{error}");
}
