//! Which cells share a face.

use super::NO_NEIGHBOR;
use super::sort::sort_by_point;

/// The points of the face opposite vertex 0…3 of a positively oriented cell,
/// counterclockwise as seen from outside.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Face neighbors of all cells, and the faces that have none.
#[derive(Debug)]
pub(super) struct Adjacency {
    pub(super) neighbors: Vec<[u32; 4]>,
    pub(super) boundary: Vec<(u32, u8)>,
    /// Faces of three or more cells.
    pub(super) crowded_faces: usize,
    /// Faces of two cells that name different points there.
    pub(super) joined_faces: usize,
}

/// A face by its places in ascending order, then its cell and opposite vertex.
type FaceKey = ([u32; 3], u32, u8);

impl Adjacency {
    /// Pairs faces between the same places. O(n): see [`sort_by_point`].
    ///
    /// `places` are the cells by places and `tetrahedra` the same by points.
    pub(super) fn new(
        places: &[[u32; 4]],
        tetrahedra: &[[u32; 4]],
        point_count: usize,
    ) -> Adjacency {
        let by_points = |cell: u32, opposite: u8| {
            ascending(FACES[usize::from(opposite)].map(|corner| tetrahedra[cell as usize][corner]))
        };
        let faces = places.iter().zip(0_u32..).flat_map(|(cell, index)| {
            FACES.iter().zip(0_u8..).map(move |(face, opposite)| {
                (ascending(face.map(|corner| cell[corner])), index, opposite)
            })
        });
        let faces: Vec<FaceKey> = sort_by_point(faces, point_count, |(face, ..)| face[0]);

        let mut neighbors = vec![[NO_NEIGHBOR; 4]; tetrahedra.len()];
        let (mut crowded_faces, mut joined_faces) = (0, 0);
        for same in faces.chunk_by(|a, b| a.0 == b.0) {
            match *same {
                [_] => {}
                [(_, a, a_opposite), (_, b, b_opposite)] => {
                    neighbors[a as usize][usize::from(a_opposite)] = b;
                    neighbors[b as usize][usize::from(b_opposite)] = a;
                    // Where no points coincide, both are the same slice.
                    let differ = || by_points(a, a_opposite) != by_points(b, b_opposite);
                    joined_faces += usize::from(!std::ptr::eq(places, tetrahedra) && differ());
                }
                // No pairing is better than another: all of them are boundary.
                _ => crowded_faces += 1,
            }
        }
        let boundary = neighbors
            .iter()
            .zip(0_u32..)
            .flat_map(|(row, cell)| {
                row.iter()
                    .zip(0_u8..)
                    .filter(|(neighbor, _)| **neighbor == NO_NEIGHBOR)
                    .map(move |(_, opposite)| (cell, opposite))
            })
            .collect();
        Adjacency {
            neighbors,
            boundary,
            crowded_faces,
            joined_faces,
        }
    }
}

fn ascending([a, b, c]: [u32; 3]) -> [u32; 3] {
    let (a, b) = (a.min(b), a.max(b));
    let (b, c) = (b.min(c), b.max(c));
    let (a, b) = (a.min(b), a.max(b));
    [a, b, c]
}
