use std::fs;
use std::path::Path;

use tetrascope_core::mesh::curved::lagrange_nodes;

use super::*;

fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn read_bytes(bytes: impl Into<Vec<u8>>) -> Result<MeshData, Error> {
    let source = Source {
        path: "a.msh".into(),
        bytes: bytes.into(),
    };
    read(source, None)
}

fn read_fixture(name: &str) -> MeshData {
    read_bytes(fixture(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn volume(data: MeshData) -> f64 {
    let field = Some("physical id").filter(|name| data.choose(Some(name)).is_ok());
    let mesh = data.into_mesh(field).unwrap_or_else(|e| panic!("{e}"));
    mesh.volume()
}

const LATTICES: [&str; 4] = [
    "lattice-22-ascii.msh",
    "lattice-22-binary.msh",
    "lattice-41-ascii.msh",
    "lattice-41-binary.msh",
];

#[test]
fn what_is_left_out_is_said() {
    for name in LATTICES {
        let data = read_fixture(name);
        assert_eq!(
            data.notes,
            [
                "2 triangles left out: only volumes are drawn",
                "field 'corners' left out: it has a value for each corner of each element \
                 ($ElementNodeData); save it as $NodeData",
                "field 'v' has 2 time steps: the first is read",
            ],
            "{name}"
        );
        let error = data.choose(Some("corners")).expect_err("left out");
        assert!(error.to_string().contains("$ElementNodeData"), "{error}");
    }
}

/// The pairs of corners in whose middles the points after the corners lie: the edges of
/// vtkQuadraticTetra, vtkQuadraticHexahedron, vtkQuadraticWedge and vtkQuadraticPyramid.
fn edges(kind: u8) -> &'static [[usize; 2]] {
    match kind {
        24 => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        25 | 29 => &[
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
        ],
        26 | 32 => &[
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
        _ => unreachable!("not of order 2"),
    }
}

/// Opposite corners of the faces, in the order of their points (vtkTriQuadraticHexahedron,
/// vtkBiQuadraticQuadraticWedge), and of the whole.
fn middles(kind: u8) -> &'static [[usize; 2]] {
    match kind {
        29 => &[[0, 7], [1, 6], [0, 5], [3, 6], [0, 2], [4, 6], [0, 6]],
        32 => &[[0, 4], [1, 5], [2, 3]],
        _ => &[],
    }
}

#[test]
fn nodes_of_order_2_come_in_the_order_of_vtk() {
    let data = read_fixture("curved.msh");
    assert_eq!(data.cells.types, [24, 29, 32, 27, 25, 26, 27]);
    for (cell, &kind) in data.cells.types.iter().enumerate() {
        let ends = &data.cells.offsets[cell..cell + 2];
        let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
        let at = |i: usize| data.points[points[i] as usize];
        let corners = tetrascope_core::mesh::volume_corners(kind).expect("a volume");
        let pairs = edges(kind).iter().chain(middles(kind));
        let mut point = corners;
        for &[a, b] in pairs {
            assert_eq!(
                at(point),
                (at(a) + at(b)) / 2.0,
                "type {kind}, point {point}"
            );
            point += 1;
        }
        assert_eq!(point, points.len(), "type {kind}");
    }
}

#[test]
fn an_element_in_two_physical_groups_is_one_cell() {
    for name in ["groups-22.msh", "groups-41.msh"] {
        let data = read_fixture(name);
        let notes = data.notes.iter();
        let repeated = notes
            .filter(|n| n.contains("another physical group"))
            .count();
        assert_eq!(repeated, usize::from(name == "groups-22.msh"));
        let groups = data.field(Some("physical id")).expect("two groups").values;
        let cells = groups.len() / 2;
        assert!(groups[..cells].iter().all(|&group| group == 7.0), "{name}");
        assert!(groups[cells..].iter().all(|&group| group == 8.0), "{name}");
        // Two boxes of 1 × 1 × 2.
        assert!((volume(data) - 4.0).abs() < 1e-12, "{name}");
    }
}

/// A tetrahedron with a field in which one node has no value.
const TEXT: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 0 1 0\n\
    7 0 0 1\n$EndNodes\n$Elements\n2\n1 15 0 10\n5 4 2 0 1 10 20 30 7\n$EndElements\n\
    $NodeData\n1\n\"t\"\n1\n0.5\n3\n0\n1\n3\n10 1\n7 4\n20 2\n$EndNodeData\n";

/// The same in version 4.1.
const TEXT_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 7 30\n3 1 0 4\n10\n20\n30\n7\n\
    0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 5 5\n3 1 4 1\n5 10 20 30 7\n$EndElements\n\
    $NodeData\n1\n\"t\"\n0\n3\n0\n1\n3\n10 1\n7 4\n20 2\n$EndNodeData\n";

#[test]
fn a_node_without_a_value_has_none() {
    for text in [TEXT.to_owned(), TEXT_4.into(), TEXT.replace('\n', "\r\n")] {
        let data = read_bytes(text).expect("a mesh");
        assert_eq!(data.cells.connectivity, [0, 1, 2, 3]);
        assert_eq!(data.fields.len(), 1);
        assert_eq!(data.fields[0].missing, 1);
        assert_eq!(data.fields[0].range, Some((1.0, 4.0)));
        let values = data.field(Some("t")).expect("it is there").values;
        assert_eq!(values[..2], [1.0, 2.0]);
        assert!(values[2].is_nan());
        assert_eq!(values[3], 4.0);
    }
}

#[test]
fn big_and_little_binary_files_are_read() {
    type Order = (fn(i32) -> [u8; 4], fn(f64) -> [u8; 8]);
    let orders: [Order; 2] = [
        (i32::to_le_bytes, f64::to_le_bytes),
        (i32::to_be_bytes, f64::to_be_bytes),
    ];
    for (int, double) in orders {
        let mut bytes = b"$MeshFormat\n2.2 1 8\n".to_vec();
        bytes.extend(int(1));
        bytes.extend(b"\n$EndMeshFormat\n$Nodes\n4\n");
        for (tag, [x, y, z]) in [
            (10, [0.0, 0.0, 0.0]),
            (20, [1.0, 0.0, 0.0]),
            (30, [0.0, 1.0, 0.0]),
            (7, [0.0, 0.0, 1.0]),
        ] {
            bytes.extend(int(tag));
            bytes.extend([x, y, z].map(double).as_flattened());
        }
        bytes.extend(b"\n$EndNodes\n$Elements\n1\n");
        bytes.extend([4, 1, 2, 5, 0, 1, 10, 20, 30, 7].map(int).as_flattened());
        bytes.extend(b"\n$EndElements\n");
        let data = read_bytes(bytes).expect("a mesh");
        assert_eq!(data.points[3], DVec3::Z);
        assert_eq!(data.cells.connectivity, [0, 1, 2, 3]);
    }
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    const HUGE: &str = "9223372036854775808";
    for (text, from, to, words) in [
        (TEXT, "2.2 0", "1 0", "version 1; 2 and 4.1 are read"),
        (TEXT, "2.2 0", "4 0", "version 4; 2 and 4.1 are read"),
        (TEXT, "2.2 0", "4.0 0", "version 4.0; 2 and 4.1 are read"),
        (TEXT, "$MeshFormat", "$NOD", "version 1; 2 and 4.1 are read"),
        (TEXT, "2.2 0 8", "2.2 1 4", "'2.2 1 4' where a version"),
        (TEXT, "2.2 0 8", "2.2 1 8", "in neither order"),
        (TEXT, "2.2 0 8", "2.2", "where a version"),
        (
            TEXT,
            "$Nodes\n4",
            "$Nodes\n5",
            "'$EndNodes' where a node's number is needed",
        ),
        (
            TEXT,
            "$Nodes\n4",
            "$Nodes\n3",
            "'7 0 0 1' where $EndNodes is needed",
        ),
        (
            TEXT,
            "30 0 1 0",
            "20 0 1 0",
            "two nodes have the number 20, in a.msh at $Nodes",
        ),
        (
            TEXT,
            "30 0 1 0",
            "-3 0 1 0",
            "-3 where a node's number is needed",
        ),
        (
            TEXT,
            "30 0 1 0",
            "30 0 x 0",
            "'x' where a node's coordinate is needed",
        ),
        (
            TEXT,
            "30 0 1 0",
            "30 0 inf 0",
            "its point 2 is at (0, inf, 0)",
        ),
        (
            TEXT,
            "20 30 7",
            "20 30 8",
            "uses node 8, which the file does not have, in a.msh at element 5",
        ),
        (
            TEXT,
            "5 4 2",
            "5 35 2",
            "elements of type 35 (polyhedron) are not read",
        ),
        (TEXT, "5 4 2", "5 -4 2", "elements of type -4 are not read"),
        (
            TEXT,
            "5 4 2",
            "5 2 3",
            "the file has no volumes, but 1 point, 1 triangle",
        ),
        (
            TEXT,
            "$Elements\n2",
            "$Elements\n0",
            "'1 15 0 10' where $EndElements",
        ),
        (
            TEXT,
            "3\n0\n1\n3\n",
            "3\n0\n0\n3\n",
            "'t' has 0 components; 1 to 64 are read",
        ),
        (TEXT, "3\n0\n1\n3\n", "2\n0\n1\n", "'t' has 2 integers"),
        (TEXT, "10 1\n", "10 one\n", "'one' where a value is needed"),
        (
            TEXT,
            "$EndNodeData\n",
            "",
            "the file ends before $EndNodeData",
        ),
        (
            TEXT,
            "$EndNodes",
            "$NodesEnd",
            "'$NodesEnd' where $EndNodes is needed",
        ),
        (
            TEXT,
            "$NodeData",
            "NodeData",
            "'NodeData' where a section such as $Nodes is to begin",
        ),
        (
            TEXT_4,
            "1 4 7 30\n",
            "2 4 7 30\n",
            "'$EndNodes' where a dimension is needed",
        ),
        (
            TEXT_4,
            "1 4 7 30\n",
            "1 5 7 30\n",
            "hold 4 nodes where 5 are announced",
        ),
        (
            TEXT_4,
            "1 1 5 5\n",
            "1 2 5 5\n",
            "hold 1 elements where 2 are announced",
        ),
        (
            TEXT_4,
            "3 1 4 1\n",
            "2 1 4 1\n",
            "tetrahedrons in an entity of dimension 2",
        ),
        (TEXT_4, "3 1 0 4\n", "4 1 1 4\n", "an entity of dimension 4"),
        (
            TEXT_4,
            "3 1 0 4\n",
            "3 1 2 4\n",
            "2 where 0 or 1 for parameters is needed",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let error = read_bytes(text.replacen(from, to, 1)).expect_err(to);
        let message = error.to_string();
        assert!(message.contains(words), "{to}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
    for (text, from, to) in [
        (TEXT, "$Nodes\n4", format!("$Nodes\n{HUGE}")),
        (
            TEXT,
            "3\n0\n1\n3\n",
            "3\n0\n1\n9223372036854775807\n".into(),
        ),
        (TEXT_4, "3 1 0 4\n", format!("3 1 0 {HUGE}\n")),
        (TEXT_4, "3 1 4 1\n", format!("3 1 4 {HUGE}\n")),
    ] {
        let error = read_bytes(text.replacen(from, &to, 1)).expect_err(&to);
        let message = error.to_string();
        assert!(message.contains("bytes that are left"), "{to}: {message}");
    }
    let old = read_bytes(TEXT.replacen("2.2", "4", 1)).expect_err("not read");
    assert_eq!(old.help().as_deref(), Some(CONVERT));
}

#[test]
fn values_of_other_nodes_alone_are_left_out() {
    let data = read_bytes(TEXT.replace("10 1\n7 4\n20 2\n", "1 1\n2 4\n3 2\n")).expect("a mesh");
    assert!(data.fields.is_empty());
    assert_eq!(
        data.notes,
        [
            "1 point left out: only volumes are drawn",
            "field 't' left out: no node of the file has a value"
        ]
    );
}

#[test]
fn corners_of_elements_without_nodes_inside_are_taken() {
    let nodes: Vec<String> = (1..=22)
        .map(|i| format!("{i} {i} {} {}", i * i % 7, i % 3))
        .collect();
    let tags: Vec<String> = (1..=22).map(|i| i.to_string()).collect();
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n22\n{}\n$EndNodes\n$Elements\n1\n1 32 0 {}\n$EndElements\n",
        nodes.join("\n"),
        tags.join(" ")
    );
    let data = read_bytes(text).expect("a mesh");
    assert_eq!(data.cells.types, [10]);
    assert_eq!(data.cells.connectivity, [0, 1, 2, 3]);
    assert_eq!(
        data.notes,
        ["1 element of order 3 or more: drawn straight, by its corners"]
    );
}

#[test]
fn binary_values_that_lack_one_byte_are_refused() {
    // Once the values' end was taken for one byte after the file's.
    let bytes = fixture("lattice-22-binary.msh");
    let start = b"$NodeData".as_slice();
    let at = bytes.windows(start.len()).position(|w| w == start);
    let head = bytes[..at.expect("it has data")].to_vec();
    for (values, words) in [(12, "the file ends before"), (11, "bytes that are left")] {
        let mut bytes = head.clone();
        bytes.extend(b"$NodeData\n1\n\"t\"\n0\n3\n0\n1\n1\n");
        bytes.extend(vec![1; values]);
        let error = read_bytes(bytes).expect_err("cut").to_string();
        assert!(error.contains(words), "{values}: {error}");
    }
}

#[test]
fn a_time_step_is_read_where_it_is_chosen() {
    for name in LATTICES {
        let source = || Source {
            path: "a.msh".into(),
            bytes: fixture(name),
        };
        assert_eq!(steps(source()).expect("times"), [0.0, 0.5], "{name}");
        let first = read_fixture(name);
        for choice in [StepChoice::Number(1), StepChoice::Time(0.5)] {
            let data = read(source(), Some(choice)).expect("a mesh");
            let [one, two] = [&first, &data].map(|data| {
                let field = data.field(Some("v-0"));
                field.unwrap_or_else(|e| panic!("{e}")).values
            });
            let twice: Vec<f64> = one.iter().map(|x| 2.0 * x).collect();
            assert_eq!(two, twice, "{name}");
            // It has one step, and no other that would be its own.
            let field = data.field(Some("f"));
            assert!(field.is_ok(), "{name}");
            let note = "the file holds 2 time steps: number 1, at 0.5, is read";
            assert!(data.notes.iter().any(|n| n == note), "{:?}", data.notes);
        }
        let error = read(source(), Some(StepChoice::Number(2))).expect_err("not there");
        assert!(error.to_string().contains("time step 2"), "{name}: {error}");
    }
}

/// Whether the nodes of cells lie at their places in Gmsh's reference elements.
fn check_orders(data: &MeshData) -> Vec<(u8, usize)> {
    let mut found = Vec::new();
    for (cell, &kind) in data.cells.types.iter().enumerate() {
        let ends = &data.cells.offsets[cell..cell + 2];
        let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
        let order = (1..10).find(|&order| lagrange_nodes(kind, order).len() == points.len());
        let order = order.expect("an order");
        // A tetrahedron's edges are from 0 to 1, a hexahedron's from -1 to 1.
        let (low, length) = if kind == 71 { (0.0, 1.0) } else { (-1.0, 2.0) };
        for (&point, place) in points.iter().zip(lagrange_nodes(kind, order)) {
            let at = place.map(|step| low + length * step as f64 / order as f64);
            let expected = DVec3::from(at) + DVec3::X * (4 * cell) as f64;
            // Numbers up to 24, of which Gmsh wrote 16 digits.
            assert!(
                (data.points[point as usize] - expected).length() < 1e-14,
                "{kind} {order}"
            );
        }
        found.push((kind, order));
    }
    found
}

#[test]
fn nodes_of_orders_3_to_6_come_in_the_order_of_vtk() {
    let data = read_fixture("higher_order/orders.msh");
    assert!(data.notes.is_empty(), "{:?}", data.notes);
    assert_eq!(
        check_orders(&data),
        [(71, 3), (71, 4), (71, 5), (71, 6), (72, 3), (72, 4)]
    );
}
