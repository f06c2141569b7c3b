//! Quadrilaterals that the cells on their two sides cut along different diagonals.
//!
//! Cells that are cut here agree on the diagonals of the faces that they share. Where a file's own tetrahedra touch a
//! hexahedron's face, they may have the other diagonal. Their four triangles are all boundary then. Where the four
//! corners lie in a plane, a ray leaves by one and enters by another at one place, and nothing is lost; elsewhere
//! there is a gap or an overlap, as thick as the diagonals pass each other.

use super::adjacency::FACES;

/// More boundary triangles than these at one edge are not looked at in pairs: no mesh that fills space has so many.
const MOST_AT_AN_EDGE: usize = 64;

/// A triangle of the boundary at one of its sides.
struct Side {
    /// The ends in ascending order.
    ends: [u32; 2],
    /// Whether the triangle, seen from outside its cell, runs from the lesser end to the greater.
    ascends: bool,
    third: u32,
    cell: u32,
}

/// Two triangles of the boundary with a common side.
struct Quad {
    /// Corners counterclockwise as seen from outside the cells, from the least one on.
    corners: [u32; 4],
    diagonal: [u32; 2],
    cells: [u32; 2],
}

impl Quad {
    fn of(a: &Side, b: &Side) -> Option<Quad> {
        let (up, down) = match (a.ascends, b.ascends) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => return None,
        };
        let [low, high] = up.ends;
        let mut corners = [low, down.third, high, up.third];
        let least = (0..4).min_by_key(|&i| corners[i]).unwrap_or_default();
        corners.rotate_left(least);
        Some(Quad {
            corners,
            diagonal: up.ends,
            cells: [a.cell, b.cell],
        })
    }

    /// As seen from the other side.
    fn reversed(&self) -> [u32; 4] {
        let [a, b, c, d] = self.corners;
        [a, d, c, b]
    }
}

/// How many faces of cells that were cut meet two triangles of other cells which are cut along the other diagonal.
///
/// `tetrahedra` are by places, `boundary` are faces without a neighbor, and `sources` the input cell of each tetrahedron,
/// empty where each is its own.
pub(super) fn crossed_faces(
    tetrahedra: &[[u32; 4]],
    boundary: &[(u32, u8)],
    sources: &[u32],
) -> usize {
    if sources.is_empty() {
        return 0;
    }
    let sides = boundary.iter().flat_map(|&(cell, opposite)| {
        let [a, b, c] = FACES[usize::from(opposite)].map(|i| tetrahedra[cell as usize][i]);
        [(a, b, c), (b, c, a), (c, a, b)].map(|(from, to, third)| Side {
            ends: [from.min(to), from.max(to)],
            ascends: from < to,
            third,
            cell,
        })
    });
    let mut sides: Vec<Side> = sides.collect();
    sides.sort_unstable_by_key(|side| side.ends);
    let mut quads = Vec::new();
    for at_edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        if at_edge.len() > MOST_AT_AN_EDGE {
            continue;
        }
        for (i, a) in at_edge.iter().enumerate() {
            quads.extend(at_edge[i + 1..].iter().filter_map(|b| Quad::of(a, b)));
        }
    }
    drop(sides);
    quads.sort_unstable_by_key(|quad| (quad.corners, quad.diagonal));
    let is_cut = |quad: &&Quad| {
        let [a, b] = quad.cells.map(|cell| sources[cell as usize]);
        a == b
    };
    let crosses = |quad: &&Quad| {
        let reversed = quad.reversed();
        let first = quads.partition_point(|other| other.corners < reversed);
        let same = quads[first..].iter().take_while(|q| q.corners == reversed);
        let mut others = same.filter(|other| {
            let is_apart = other.cells.iter().all(|cell| !quad.cells.contains(cell));
            // Count a face between two cut cells once.
            let counts = !is_cut(other) || quad.diagonal < other.diagonal;
            other.diagonal != quad.diagonal && is_apart && counts
        });
        others.next().is_some()
    };
    quads.iter().filter(is_cut).filter(crosses).count()
}
