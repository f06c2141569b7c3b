//! VTK's cell types: which are volumes, and how their corners lie.

use crate::Error;

/// A linear cell: its corners and its faces, each counterclockwise from outside,
/// as positions in the cell.
#[derive(Debug, PartialEq)]
pub(super) struct Shape {
    pub(super) corners: usize,
    pub(super) faces: &'static [&'static [usize]],
}

pub(super) const TETRAHEDRON: Shape = Shape {
    corners: 4,
    faces: &[&[1, 2, 3], &[0, 3, 2], &[0, 1, 3], &[0, 2, 1]],
};

pub(super) const HEXAHEDRON: Shape = Shape {
    corners: 8,
    faces: &[
        &[0, 4, 7, 3],
        &[1, 2, 6, 5],
        &[0, 1, 5, 4],
        &[3, 7, 6, 2],
        &[0, 3, 2, 1],
        &[4, 5, 6, 7],
    ],
};

/// A hexahedron whose corners are numbered row by row: x, then y, then z.
pub(super) const VOXEL: Shape = Shape {
    corners: 8,
    faces: &[
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
        &[0, 1, 5, 4],
        &[2, 6, 7, 3],
        &[0, 2, 3, 1],
        &[4, 5, 7, 6],
    ],
};

/// The orientation of VTK's code (`vtkWedge::GetParametricCoords`); its manual's
/// figure says the opposite, and files of both kinds are common.
pub(super) const WEDGE: Shape = Shape {
    corners: 6,
    faces: &[
        &[0, 2, 1],
        &[3, 4, 5],
        &[0, 1, 4, 3],
        &[1, 2, 5, 4],
        &[2, 0, 3, 5],
    ],
};

pub(super) const PYRAMID: Shape = Shape {
    corners: 5,
    faces: &[
        &[0, 3, 2, 1],
        &[0, 1, 4],
        &[1, 2, 4],
        &[2, 3, 4],
        &[3, 0, 4],
    ],
};

pub(super) const PENTAGONAL_PRISM: Shape = Shape {
    corners: 10,
    faces: &[
        &[4, 3, 2, 1, 0],
        &[5, 6, 7, 8, 9],
        &[0, 1, 6, 5],
        &[1, 2, 7, 6],
        &[2, 3, 8, 7],
        &[3, 4, 9, 8],
        &[4, 0, 5, 9],
    ],
};

pub(super) const HEXAGONAL_PRISM: Shape = Shape {
    corners: 12,
    faces: &[
        &[5, 4, 3, 2, 1, 0],
        &[6, 7, 8, 9, 10, 11],
        &[0, 1, 7, 6],
        &[1, 2, 8, 7],
        &[2, 3, 9, 8],
        &[3, 4, 10, 9],
        &[4, 5, 11, 10],
        &[5, 0, 6, 11],
    ],
};

/// The meaning of a type of cells for a volume.
#[derive(Debug, PartialEq)]
pub(super) enum Kind {
    /// Straight edges: exactly the shape's corners.
    Linear(&'static Shape),
    /// Curved: the corners come first, then a fixed number of further points.
    Quadratic(&'static Shape, usize),
    /// Curved, of any order: the corners come first, then any number of points.
    AnyOrder(&'static Shape),
    /// Points, curves and surfaces.
    Skipped,
    /// Not drawn and not to be left out in silence.
    Refused,
}

impl Kind {
    /// By VTK's number (vtkCellType.h).
    pub(super) fn of(cell_type: u8) -> Kind {
        match cell_type {
            10 => Kind::Linear(&TETRAHEDRON),
            11 => Kind::Linear(&VOXEL),
            12 => Kind::Linear(&HEXAHEDRON),
            13 => Kind::Linear(&WEDGE),
            14 => Kind::Linear(&PYRAMID),
            15 => Kind::Linear(&PENTAGONAL_PRISM),
            16 => Kind::Linear(&HEXAGONAL_PRISM),
            24 => Kind::Quadratic(&TETRAHEDRON, 10),
            25 => Kind::Quadratic(&HEXAHEDRON, 20),
            26 => Kind::Quadratic(&WEDGE, 15),
            27 => Kind::Quadratic(&PYRAMID, 13),
            29 => Kind::Quadratic(&HEXAHEDRON, 27),
            31 => Kind::Quadratic(&WEDGE, 12),
            32 => Kind::Quadratic(&WEDGE, 18),
            33 => Kind::Quadratic(&HEXAHEDRON, 24),
            37 => Kind::Quadratic(&PYRAMID, 19),
            64 | 71 | 78 => Kind::AnyOrder(&TETRAHEDRON),
            65 | 73 | 80 => Kind::AnyOrder(&WEDGE),
            66 | 74 | 81 => Kind::AnyOrder(&PYRAMID),
            67 | 72 | 79 => Kind::AnyOrder(&HEXAHEDRON),
            0..=9 | 21..=23 | 28 | 30 | 34..=36 | 51..=55 | 60..=63 | 68..=70 | 75..=77 => {
                Kind::Skipped
            }
            _ => Kind::Refused,
        }
    }

    /// The shape of a volume cell.
    pub(super) fn shape(&self) -> Option<&'static Shape> {
        match self {
            Kind::Linear(shape) | Kind::Quadratic(shape, _) | Kind::AnyOrder(shape) => Some(shape),
            Kind::Skipped | Kind::Refused => None,
        }
    }

    /// Checks the number of points of cell number `cell`.
    pub(super) fn check(&self, cell: usize, cell_type: u8, points: usize) -> Result<(), Error> {
        let (is_right, least, count) = match *self {
            Kind::Linear(shape) => (points == shape.corners, "", shape.corners),
            Kind::Quadratic(_, count) => (points == count, "", count),
            Kind::AnyOrder(shape) => (points >= shape.corners, "at least ", shape.corners),
            Kind::Skipped => return Ok(()),
            Kind::Refused => {
                let what = format!("cell {cell} is a {}", type_name(cell_type));
                return Err(Error::Invalid {
                    what: format!("{what}, which is not supported"),
                    help: Some(
                        "convert the mesh first, for example with ParaView's filter Tetrahedralize"
                            .into(),
                    ),
                });
            }
        };
        if is_right {
            return Ok(());
        }
        Err(Error::Invalid {
            what: format!(
                "cell {cell} is a {} of {points} points; it must have {least}{count}",
                type_name(cell_type)
            ),
            help: Some("the file's cell types and offsets do not belong together".into()),
        })
    }
}

/// How many corners a cell of VTK's type `cell_type` has, if it is a volume that is drawn;
/// they are its first points.
pub fn volume_corners(cell_type: u8) -> Option<usize> {
    Kind::of(cell_type).shape().map(|shape| shape.corners)
}

/// The faces of a cell of VTK's type `cell_type`, if it is a volume that is drawn: each
/// counterclockwise from outside, as positions among its corners ([`volume_corners`]). Curved
/// cells have those of their corners.
pub fn volume_faces(cell_type: u8) -> Option<&'static [&'static [usize]]> {
    Kind::of(cell_type).shape().map(|shape| shape.faces)
}

/// VTK's name of a cell type, in the singular: "hexahedron".
pub fn type_name(cell_type: u8) -> String {
    let name = match cell_type {
        0 => "empty cell",
        1 => "vertex",
        2 => "polyvertex",
        3 => "line",
        4 => "polyline",
        5 => "triangle",
        6 => "triangle strip",
        7 => "polygon",
        8 => "pixel",
        9 => "quad",
        10 => "tetrahedron",
        11 => "voxel",
        12 => "hexahedron",
        13 => "wedge",
        14 => "pyramid",
        15 => "pentagonal prism",
        16 => "hexagonal prism",
        21 => "quadratic edge",
        22 => "quadratic triangle",
        23 => "quadratic quad",
        24 => "quadratic tetrahedron",
        25 => "quadratic hexahedron",
        26 => "quadratic wedge",
        27 => "quadratic pyramid",
        28 => "biquadratic quad",
        29 => "triquadratic hexahedron",
        30 => "quadratic-linear quad",
        31 => "quadratic-linear wedge",
        32 => "biquadratic wedge",
        33 => "biquadratic hexahedron",
        34 => "biquadratic triangle",
        35 => "cubic line",
        36 => "quadratic polygon",
        37 => "triquadratic pyramid",
        41 => "convex point set",
        42 => "polyhedron",
        68 => "Lagrange curve",
        69 => "Lagrange triangle",
        70 => "Lagrange quad",
        71 => "Lagrange tetrahedron",
        72 => "Lagrange hexahedron",
        73 => "Lagrange wedge",
        74 => "Lagrange pyramid",
        75 => "Bézier curve",
        76 => "Bézier triangle",
        77 => "Bézier quad",
        78 => "Bézier tetrahedron",
        79 => "Bézier hexahedron",
        80 => "Bézier wedge",
        81 => "Bézier pyramid",
        _ => return format!("cell of VTK type {cell_type}"),
    };
    name.into()
}
