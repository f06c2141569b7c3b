//! Types of cells, by their names and numbers.

use crate::pieces::sections::{Coded, Shape};

/// Nodes are in VTK's order, also those of curved cells: vtkXdmfReader 9.7 has them so.
const NAMES: [(u64, &[&str], Shape); 14] = [
    (4, &["triangle"], Shape::same(5, 3)),
    (5, &["quadrilateral"], Shape::same(9, 4)),
    (6, &["tetrahedron"], Shape::same(10, 4)),
    (7, &["pyramid"], Shape::same(14, 5)),
    (8, &["wedge"], Shape::same(13, 6)),
    (9, &["hexahedron"], Shape::same(12, 8)),
    (0x26, &["tetrahedron_10", "tet_10"], Shape::same(24, 10)),
    (0x27, &["pyramid_13"], Shape::same(27, 13)),
    (0x28, &["wedge_15"], Shape::same(26, 15)),
    (0x29, &["wedge_18"], Shape::same(32, 18)),
    (0x30, &["hexahedron_20", "hex_20"], Shape::same(25, 20)),
    (0x31, &["hexahedron_24", "hex_24"], Shape::same(33, 24)),
    (0x32, &["hexahedron_27", "hex_27"], Shape::same(29, 27)),
    (0x24, &["triangle_6", "tri_6"], Shape::same(22, 6)),
];

/// Other names of what has no volume.
const FLAT: [&str; 12] = [
    "polyvertex",
    "polyline",
    "polygon",
    "edge_3",
    "quadrilateral_8",
    "quad_8",
    "quadrilateral_9",
    "quad_9",
    "2dsmesh",
    "2drectmesh",
    "2dcorectmesh",
    "notopology",
];

/// The shape of a type by its name in lower case; of a surface `Ok(None)`.
pub(super) fn named(name: &str) -> Result<Option<Shape>, String> {
    let known = NAMES.iter().find(|(_, names, _)| names.contains(&name));
    match known {
        Some((_, _, shape)) => Ok(Some(*shape).filter(|shape| shape.is_volume())),
        None if FLAT.contains(&name) => Ok(None),
        None => Err(format!("cells of the type '{name}' are not read")),
    }
}

/// The meaning of a type's number.
pub(super) fn coded(code: u64) -> Result<Coded, String> {
    let known = NAMES.iter().find(|(number, ..)| *number == code);
    Ok(match (code, known) {
        (_, Some((_, _, shape))) => Coded::Cell(*shape),
        (1, _) => Coded::Counted(2),
        (2, _) => Coded::Counted(4),
        (3, _) => Coded::Counted(7),
        (0x22, _) => Coded::Cell(Shape::same(21, 3)),
        (0x23, _) => Coded::Cell(Shape::same(28, 9)),
        (0x25, _) => Coded::Cell(Shape::same(23, 8)),
        (16, _) => {
            return Err("is a polyhedron, which are read from .vtu, VTKHDF and CGNS files".into());
        }
        _ => return Err(format!("is of type {code}, which is not read")),
    })
}
