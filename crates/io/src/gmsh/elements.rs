//! Gmsh's element types, and their nodes in VTK's order.

use super::orders::{of_hexahedron, of_tetrahedron};

/// An element type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Element {
    /// In the singular: "triangle".
    pub(super) name: &'static str,
    /// 0 for points to 3 for volumes.
    pub(super) dimension: u8,
    pub(super) nodes: usize,
    /// The cell of VTK's that a volume becomes; `None` for points, lines and surfaces.
    pub(super) cell: Option<Cell>,
}

/// A cell of VTK's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    /// VTK's number.
    pub(super) kind: u8,
    /// For each point of the cell, which of the element's nodes it is.
    pub(super) order: &'static [usize],
    /// Of order 3 and more, in types whose functions are not known here: only the corners are taken.
    pub(super) is_straightened: bool,
}

/// The numbers from 0 to 7: corners are in VTK's order already.
const CORNERS: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
const TETRAHEDRON_10: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
/// VTK's order of the nodes of hexahedra: of 20 nodes and, to its end, of 27.
const HEXAHEDRON: [usize; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, // corners
    8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, // edges
    22, 23, 21, 24, 20, 25, 26, // faces and the middle
];
/// VTK's order of the nodes of prisms: of 15 nodes and, to its end, of 18.
const PRISM: [usize; 18] = [
    0, 1, 2, 3, 4, 5, // corners
    6, 9, 7, 12, 14, 13, 8, 10, 11, // edges
    15, 17, 16, // faces
];
/// The 14th node, in the middle of the base, has no place in VTK's pyramid of 13.
const PYRAMID_13: [usize; 13] = [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12];

/// By Gmsh's number (MElement::getInfoMSH of its sources); `None` for types without a fixed
/// number of nodes and for numbers that stand for nothing.
pub(super) fn element(kind: i64) -> Option<Element> {
    let curved = |name, nodes, kind, order| Element {
        name,
        dimension: 3,
        nodes,
        cell: Some(Cell {
            kind,
            order,
            is_straightened: false,
        }),
    };
    let tetrahedron = |nodes| volume("tetrahedron", nodes, 10, 4);
    let hexahedron = |nodes| volume("hexahedron", nodes, 12, 8);
    let prism = |nodes| volume("prism", nodes, 13, 6);
    let pyramid = |nodes| volume("pyramid", nodes, 14, 5);
    let flat = |name, dimension, nodes| Element {
        name,
        dimension,
        nodes,
        cell: None,
    };
    let line = |nodes| flat("line", 1, nodes);
    let triangle = |nodes| flat("triangle", 2, nodes);
    let quadrangle = |nodes| flat("quadrangle", 2, nodes);
    let number = usize::try_from(kind).ok()?;
    Some(match number {
        4 => tetrahedron(4),
        5 => hexahedron(8),
        6 => prism(6),
        7 => pyramid(5),
        11 => curved("tetrahedron", 10, 24, &TETRAHEDRON_10[..]),
        12 => curved("hexahedron", 27, 29, &HEXAHEDRON[..]),
        13 => curved("prism", 18, 32, &PRISM[..]),
        14 => curved("pyramid", 14, 27, &PYRAMID_13[..]),
        17 => curved("hexahedron", 20, 25, &HEXAHEDRON[..20]),
        18 => curved("prism", 15, 26, &PRISM[..15]),
        19 => curved("pyramid", 13, 27, &PYRAMID_13[..]),
        // Order 3 and more: complete, then with nodes on edges alone or on faces, too.
        29 => curved("tetrahedron", 20, 71, of_tetrahedron(3)),
        30 => curved("tetrahedron", 35, 71, of_tetrahedron(4)),
        31 => curved("tetrahedron", 56, 71, of_tetrahedron(5)),
        32 => tetrahedron(22),
        33 => tetrahedron(28),
        71 => curved("tetrahedron", 84, 71, of_tetrahedron(6)),
        72 => tetrahedron(120),
        73 => tetrahedron(165),
        74 => tetrahedron(220),
        75 => tetrahedron(286),
        79..=83 => tetrahedron(34 + 6 * (number - 79)),
        137 => tetrahedron(16),
        90..=91 => prism(complete_prism(number - 87)),
        106..=110 => prism(complete_prism(number - 101)),
        111..=117 => prism(24 + 9 * (number - 111)),
        92..=95 => curved(
            "hexahedron",
            (number - 88).pow(3),
            72,
            of_hexahedron(number - 89),
        ),
        96..=98 => hexahedron((number - 88).pow(3)),
        99..=105 => hexahedron(32 + 12 * (number - 99)),
        118..=124 => pyramid((1..=number - 114).map(|side| side * side).sum()),
        125..=131 => pyramid(21 + 8 * (number - 125)),
        15 => flat("point", 0, 1),
        1 => line(2),
        8 => line(3),
        26..=28 => line(number - 22),
        62..=66 => line(number - 55),
        84 => line(1),
        2 => triangle(3),
        9 => triangle(6),
        20 => triangle(9),
        21 => triangle(10),
        22 => triangle(12),
        23 | 24 => triangle(15),
        25 => triangle(21),
        42 => triangle(28),
        43 => triangle(36),
        44 => triangle(45),
        45 => triangle(55),
        46 => triangle(66),
        52..=56 => triangle(18 + 3 * (number - 52)),
        85 => triangle(1),
        3 => quadrangle(4),
        10 => quadrangle(9),
        16 => quadrangle(8),
        36 => quadrangle(16),
        37 => quadrangle(25),
        38 => quadrangle(36),
        39 => quadrangle(12),
        40 => quadrangle(16),
        41 => quadrangle(20),
        47..=51 => quadrangle((number - 40).pow(2)),
        57..=61 => quadrangle(24 + 4 * (number - 57)),
        86 => quadrangle(1),
        _ => return None,
    })
}

/// A volume of which the corners are taken, its first nodes.
fn volume(name: &'static str, nodes: usize, kind: u8, corners: usize) -> Element {
    Element {
        name,
        dimension: 3,
        nodes,
        cell: Some(Cell {
            kind,
            order: &CORNERS[..corners],
            is_straightened: nodes > corners,
        }),
    }
}

/// The nodes of a prism whose edges have `order` + 1 of them.
fn complete_prism(order: usize) -> usize {
    (order + 1) * (order + 1) * (order + 2) / 2
}

#[cfg(test)]
mod tests {
    use tetrascope_core::mesh::volume_corners;

    use super::*;

    #[test]
    fn an_order_names_every_node_once() {
        for kind in 0..200 {
            let Some(Element { nodes, cell, .. }) = element(kind) else {
                continue;
            };
            let Some(Cell {
                kind: vtk, order, ..
            }) = cell
            else {
                continue;
            };
            let corners = volume_corners(vtk).expect("a volume");
            assert_eq!(order[..corners], CORNERS[..corners], "{kind}");
            let mut sorted = order.to_vec();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..order.len()), "{kind}");
            assert!(order.len() <= nodes, "{kind}");
        }
    }
}
