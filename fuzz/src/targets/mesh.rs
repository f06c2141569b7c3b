//! Meshes that the builder is given, of points, cells and scalars that bytes choose.

use std::sync::Arc;

use arbitrary::Unstructured;
use tetrascope::core::glam::DVec3;
use tetrascope::core::mesh::curved::{self, Extra, Straightening};
use tetrascope::core::mesh::{Association, Split, volume_corners};
use tetrascope::core::{Cells, Error, Scalars, TetMesh};

/// Coordinates and scalars; most are small and meet each other.
const NUMBERS: [f64; 24] = [
    0.0,
    1.0,
    2.0,
    3.0,
    -1.0,
    0.5,
    1.5,
    -0.0,
    1.0 + f64::EPSILON,
    1e-17,
    1e-310,
    -1e-310,
    1e-160,
    1e-30,
    1e30,
    1e39,
    1e155,
    -1e155,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// VTK's types, those that are drawn first.
const TYPES: [u8; 28] = [
    10, 12, 13, 14, 11, 15, 16, 24, 25, 26, 27, 29, 71, 72, 73, 42, 5, 9, 1, 0, 31, 32, 33, 37, 74,
    78, 79, 80,
];

/// Numbers of points of curved cells of orders 1 to 3, some of which fit several types.
const COUNTS: [usize; 16] = [4, 6, 8, 10, 12, 13, 15, 18, 19, 20, 24, 27, 30, 35, 40, 64];

/// Builds a mesh of the bytes; no panic, and a mesh that is consistent.
pub(super) fn build(bytes: &[u8]) -> Result<(), Error> {
    let mut bytes = Unstructured::new(bytes);
    let way = byte(&mut bytes);
    let points = points(&mut bytes);
    let cells = cells(&mut bytes, points.len());
    let scalars = scalars(&mut bytes, points.len(), cells.types.len());
    let (points, cells, scalars) = match way & 16 {
        0 => (points, cells, scalars),
        _ => straight(&mut bytes, points, cells, scalars)?,
    };
    let split = match way & 8 {
        0 => Split::SmallestIndex,
        _ => Split::FiveAlternating,
    };
    let mesh = match way & 3 {
        0 => TetMesh::from_cells(points, cells, scalars),
        1 => TetMesh::with_split(points, &cells, scalars, split),
        2 => TetMesh::keeping_cells(points, Arc::new(cells), scalars, split),
        _ => {
            let corners = cells.connectivity.as_chunks::<4>().0.iter();
            let tetrahedra = corners.map(|cell| cell.map(|point| point as u32)).collect();
            TetMesh::from_tetrahedra(points, tetrahedra, scalars)
        }
    }?;
    check(&mesh);
    Ok(())
}

/// The mesh with its curved cells cut into straight ones.
fn straight(
    bytes: &mut Unstructured,
    points: Vec<DVec3>,
    cells: Cells,
    scalars: Scalars,
) -> Result<(Vec<DVec3>, Cells, Scalars), Error> {
    let chosen = byte(bytes);
    let mut extra = Extra::default();
    if chosen & 1 != 0 {
        let degree = |_: &u8| [byte(bytes), byte(bytes), byte(bytes)].map(|b| f64::from(b % 5));
        extra.degrees = cells.types.iter().map(degree).collect();
    }
    if chosen & 2 != 0 {
        extra.weights = points.iter().map(|_| number(bytes)).collect();
    }
    let how = Straightening {
        tolerance: 10.0_f64.powi(-i32::from(chosen >> 6)),
        most_cells: 4096,
    };
    let made = curved::straighten(points, cells, vec![scalars], &extra, how)?;
    if let Some(report) = made.report {
        assert!(
            report.shape >= 0.0 && report.field >= 0.0 && report.gap >= 0.0,
            "{report}"
        );
    }
    let scalars = made
        .scalars
        .into_iter()
        .next()
        .expect("the one that went in");
    Ok((made.points, made.cells, scalars))
}

fn byte(bytes: &mut Unstructured) -> u8 {
    bytes.arbitrary().unwrap_or(0)
}

fn number(bytes: &mut Unstructured) -> f64 {
    match byte(bytes) {
        255 => bytes.arbitrary().unwrap_or(0.0),
        // One of two is 0 or 1.
        chosen @ 0..128 => f64::from(chosen & 1),
        chosen => NUMBERS[usize::from(chosen) % NUMBERS.len()],
    }
}

fn points(bytes: &mut Unstructured) -> Vec<DVec3> {
    let count = usize::from(byte(bytes)) % 48;
    if byte(bytes) & 1 == 0 {
        // A lattice of 4 in a row, of which few are moved.
        let place = |i: usize| DVec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64);
        let mut points: Vec<DVec3> = (0..count).map(place).collect();
        for _ in 0..byte(bytes) % 4 {
            let at = usize::from(byte(bytes)) % count.max(1);
            let axis = usize::from(byte(bytes)) % 3;
            let moved = number(bytes);
            if let Some(point) = points.get_mut(at) {
                point[axis] = moved;
            }
        }
        return points;
    }
    (0..count)
        .map(|_| DVec3::new(number(bytes), number(bytes), number(bytes)))
        .collect()
}

/// Corners of a hexahedron of the lattice, from its first; other types take the first few.
const CORNERS: [usize; 8] = [0, 1, 5, 4, 16, 17, 21, 20];

fn cells(bytes: &mut Unstructured, points: usize) -> Cells {
    let mut cells = Cells {
        types: Vec::new(),
        offsets: vec![0],
        connectivity: Vec::new(),
    };
    for _ in 0..byte(bytes) % 32 {
        let chosen = byte(bytes);
        let kind = match chosen {
            0..240 => TYPES[usize::from(chosen) % TYPES.len()],
            _ => byte(bytes),
        };
        let shape = byte(bytes);
        let count = match shape >> 5 {
            7 => usize::from(byte(bytes)) % 40,
            6 => COUNTS[usize::from(byte(bytes)) % COUNTS.len()],
            _ => volume_corners(kind).unwrap_or(usize::from(shape) % 30),
        };
        let first = usize::from(byte(bytes));
        for corner in 0..count {
            let place = match shape & 3 {
                // Of the lattice, so that cells are neighbors.
                0..2 => first + CORNERS.get(corner).copied().unwrap_or(corner),
                2 => usize::from(byte(bytes)),
                _ => first + corner,
            };
            cells.connectivity.push((place % points.max(1)) as u64);
        }
        cells.types.push(kind);
        cells.offsets.push(cells.connectivity.len() as u64);
    }
    // What a reader would not hand on.
    for _ in 0..byte(bytes) % 3 {
        let wrong = match byte(bytes) {
            255 => bytes.arbitrary().unwrap_or(u64::MAX),
            small => u64::from(small),
        };
        let list = match byte(bytes) & 1 {
            0 => &mut cells.offsets,
            _ => &mut cells.connectivity,
        };
        let at = usize::from(byte(bytes)) % list.len().max(1);
        match (list.get_mut(at), byte(bytes) % 4) {
            (Some(number), 0..3) => *number = wrong,
            _ => list.push(wrong),
        }
    }
    cells
}

fn scalars(bytes: &mut Unstructured, points: usize, cells: usize) -> Scalars {
    let (association, count) = match byte(bytes) & 1 {
        0 => (Association::Point, points),
        _ => (Association::Cell, cells),
    };
    let count = match byte(bytes) {
        255 => usize::from(byte(bytes)),
        _ => count,
    };
    Scalars {
        name: "s".into(),
        association,
        values: (0..count).map(|_| number(bytes)).collect(),
    }
}

/// Checks the properties that every mesh must have.
fn check(mesh: &TetMesh) {
    let points = mesh.points().len();
    let cells = mesh.cell_count();
    for (cell, corners) in mesh.tetrahedra().iter().enumerate() {
        assert!(corners.iter().all(|&point| (point as usize) < points));
        mesh.source_cell(cell);
        mesh.cell_points(cell);
        mesh.cell_scalars(cell);
    }
    let mut faces = 0;
    for (cell, neighbors) in mesh.neighbors().iter().enumerate() {
        for &neighbor in neighbors {
            let Some(others) = mesh.neighbors().get(neighbor as usize) else {
                faces += 1;
                continue;
            };
            let back = others.contains(&(cell as u32));
            assert!(back, "{neighbor} is a neighbor of {cell}, not the reverse");
        }
    }
    assert_eq!(faces, mesh.boundary_faces().len(), "faces of {cells} cells");
    mesh.report().notes();
    mesh.boundary_statistics();
    mesh.bounds();
    mesh.scalar_range();
    mesh.is_continuous();
    assert!(!mesh.volume().is_nan() && mesh.volume() >= 0.0);
}

/// A tetrahedron, a row of hexahedra, and each of the drawn types alone.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![
        vec![3, 4, 0, 0, 1, 0, 3, 0],
        vec![0, 32, 0, 0, 3, 1, 0, 0, 1, 0, 1, 1, 0, 2],
    ];
    for (kind, _) in (0u8..).zip(TYPES) {
        seeds.push(vec![kind % 3, 47, 0, 0, 2, kind, 3, 0, kind, 3, 6]);
        // Two cells with many points, cut into straight ones.
        seeds.push(vec![
            16 + kind % 3,
            47,
            0,
            0,
            2,
            kind,
            195,
            9,
            0,
            kind,
            195,
            11,
            6,
        ]);
    }
    seeds
}
