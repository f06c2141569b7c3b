//! Gmsh's meshes, shorter than the fixtures.

use super::Seed;
use crate::pack::Part;

pub(super) const WORDS: &[&str] = &[
    "$MeshFormat\n",
    "2.2 0 8\n",
    "2.2 1 8\n",
    "4.1 0 8\n",
    "4.1 1 8\n",
    "$EndMeshFormat\n",
    "$PhysicalNames\n",
    "$EndPhysicalNames\n",
    "$Entities\n",
    "$EndEntities\n",
    "$PartitionedEntities\n",
    "$Nodes\n",
    "$EndNodes\n",
    "$Elements\n",
    "$EndElements\n",
    "$Periodic\n",
    "$GhostElements\n",
    "$Comments\n",
    "$NodeData\n",
    "$EndNodeData\n",
    "$ElementData\n",
    "$EndElementData\n",
    "$ElementNodeData\n",
    "$EndElementNodeData\n",
    "\"s\"",
    "nan",
    "1e999",
    "\r\n",
];

const NODES: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
];

const FIELDS: &str = "$NodeData\n1\n\"s\"\n1\n0.5\n3\n0\n1\n5\n1 0\n2 1\n3 2\n4 3\n5 4\n\
    $EndNodeData\n$ElementData\n1\n\"c\"\n0\n3\n2\n1\n2\n1 5\n2 6\n$EndElementData\n\
    $ElementNodeData\n1\n\"e\"\n1\n0\n3\n0\n1\n1\n2 4 1 2 3 4\n$EndElementNodeData\n";

pub(super) fn gmsh() -> Vec<Seed> {
    let old = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"one\"\n\
        $EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
        $Elements\n3\n1 4 2 7 1 1 2 3 4\n2 4 2 7 1 2 3 4 5\n3 2 2 0 1 1 2 3\n$EndElements\n";
    let new = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n\
        1 0 0 0 1 1 1 1 7 0\n$EndEntities\n$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n\
        0 1 0\n0 0 1\n1 1 1\n$EndNodes\n$Elements\n1 2 1 2\n3 1 4 2\n1 1 2 3 4\n2 2 3 4 5\n\
        $EndElements\n";
    let curved = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 2 0 0\n3 0 2 0\n\
        4 0 0 2\n5 1 0 0\n6 1 1 0\n7 0 1 0\n8 0 0 1\n9 0 1 1\n10 1 0 1\n$EndNodes\n$Elements\n1\n\
        1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
    let text = |file: String| Seed::single("mesh.msh", vec![Part::plain(file)]);
    vec![
        text(old.to_owned() + FIELDS),
        text(new.to_owned() + FIELDS),
        text(curved.to_owned()),
        Seed::single("mesh.msh", vec![Part::plain(binary_22())]),
        Seed::single("mesh.msh", vec![Part::plain(binary_41())]),
    ]
}

fn ints(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn sizes(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn floats(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A section in the binary form.
fn section(name: &str, content: &[Vec<u8>]) -> Vec<u8> {
    let content = content.concat();
    let (begin, end) = (format!("${name}\n"), format!("\n$End{name}\n"));
    [begin.as_bytes(), &content, end.as_bytes()].concat()
}

/// A field at the nodes.
fn node_data() -> Vec<u8> {
    let values = (1..6).flat_map(|i| [ints(&[i]), floats(&[f64::from(i)])]);
    let head = b"1\n\"s\"\n1\n0\n3\n0\n1\n5\n".to_vec();
    section("NodeData", &[vec![head], values.collect()].concat())
}

fn binary_22() -> Vec<u8> {
    let nodes = (1..).zip(NODES);
    let nodes = nodes.flat_map(|(i, place)| [ints(&[i]), floats(&place)]);
    let elements = [4, 2, 2, 1, 7, 1, 1, 2, 3, 4, 2, 7, 1, 2, 3, 4, 5];
    [
        section("MeshFormat", &[b"2.2 1 8\n".to_vec(), ints(&[1])]),
        section("Nodes", &[vec![b"5\n".to_vec()], nodes.collect()].concat()),
        section("Elements", &[b"2\n".to_vec(), ints(&elements)]),
        node_data(),
    ]
    .concat()
}

fn binary_41() -> Vec<u8> {
    let block = |head: [i32; 3], count: u64| [ints(&head), sizes(&[count])].concat();
    [
        section("MeshFormat", &[b"4.1 1 8\n".to_vec(), ints(&[1])]),
        section(
            "Nodes",
            &[
                sizes(&[1, 5, 1, 5]),
                block([3, 1, 0], 5),
                sizes(&[1, 2, 3, 4, 5]),
                floats(NODES.as_flattened()),
            ],
        ),
        section(
            "Elements",
            &[
                sizes(&[1, 2, 1, 2]),
                block([3, 1, 4], 2),
                sizes(&[1, 1, 2, 3, 4, 2, 2, 3, 4, 5]),
            ],
        ),
        node_data(),
    ]
    .concat()
}
