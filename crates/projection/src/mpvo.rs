//! Visibility order through face adjacency.
//!
//! P. Williams, "Visibility Ordering Meshed Polyhedra", ACM Transactions on Graphics
//! 1992: of two cells that share a face, the one on the eye's side of it is in front.
//! A depth-first search that finishes a cell after all cells behind it gives an order
//! for all, in O(n).
//!
//! It is right if every two cells on a ray are connected by faces that the ray crosses,
//! and if no cells hide each other in a cycle. The first holds for every view if the mesh is
//! convex and each face inside it has a cell on either side ([`unproven`]); the second
//! is found in each view.
//!
//! Where a ray leaves a mesh and comes back, no face tells which part is in front.
//! MPVONC's heuristic starts the search from the faces of the boundary that look at
//! the eye, farthest first, so far parts are finished before near ones. That is a guess:
//! a far face may hide a near one. The same goes for hanging nodes, across which cells
//! share no face, and for cells that overlap.

use std::sync::Arc;

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::{FACES, NO_NEIGHBOR};
use tetrascope_core::{Projection, TetMesh, View};
use tetrascope_f32::Normalization;

use crate::mesh::{flat, has_no_volume};

/// Cells back to front.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sorted {
    pub(crate) cells: Vec<u32>,
    /// Faces whose order was given up because cells hide each other in a cycle.
    pub(crate) cycles: u64,
}

/// Where the eye is, in normalized space.
#[derive(Clone, Copy, Debug)]
enum Eye {
    At(DVec3),
    /// Infinitely far in this direction.
    Toward(DVec3),
}

/// The part of the order that does not depend on the view.
#[derive(Debug)]
pub(crate) struct Mpvo {
    mesh: TetMesh,
    shape: Arc<Shape>,
    shown: Vec<bool>,
}

/// The part of it that does not depend on the appearance either.
#[derive(Debug)]
pub(crate) struct Shape {
    /// Normalized.
    points: Vec<DVec3>,
    /// Cells without volume, of which no side is the inside.
    flat: Vec<bool>,
}

impl Shape {
    pub(crate) fn new(mesh: &TetMesh, normalization: &Normalization) -> Shape {
        let points = mesh.points().iter().map(|p| normalization.point(*p));
        let points: Vec<DVec3> = points.collect();
        let corners = mesh.tetrahedra().iter();
        let flat = corners.map(|c| flat(c.map(|p| points[p as usize])));
        Shape {
            flat: flat.collect(),
            points,
        }
    }
}

/// A cell's place in the search.
#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    /// The cells behind it are being searched.
    Open,
    Done,
}

impl Mpvo {
    /// For the cells `drawn`, by index. The others take part in the search, as order
    /// passes through them.
    pub(crate) fn new(mesh: &TetMesh, shape: Arc<Shape>, drawn: &[u32]) -> Mpvo {
        let mut shown = vec![false; mesh.cell_count()];
        for cell in drawn {
            shown[*cell as usize] = true;
        }
        Mpvo {
            mesh: mesh.clone(),
            shape,
            shown,
        }
    }

    /// The drawn cells as `view` sees them.
    pub(crate) fn sorted(&self, view: &View, normalization: &Normalization) -> Sorted {
        let camera = &view.camera;
        let eye = match camera.projection {
            Projection::Perspective { .. } => Eye::At(normalization.point(camera.position)),
            Projection::Orthographic { .. } => Eye::Toward(-camera.axes().2),
        };
        let mut search = Search {
            mpvo: self,
            eye,
            states: vec![State::New; self.mesh.cell_count()],
            path: Vec::new(),
            sorted: Sorted {
                cells: Vec::new(),
                cycles: 0,
            },
        };
        for cell in self.starts(eye) {
            search.finish_from(cell);
        }
        // What no boundary face is in front of: around the eye, or in a cycle.
        for cell in 0..self.mesh.cell_count() as u32 {
            search.finish_from(cell);
        }
        search.sorted
    }

    /// The cells of the boundary faces that look at the eye, farthest first.
    fn starts(&self, eye: Eye) -> Vec<u32> {
        let mut faces: Vec<(f64, u32)> = Vec::new();
        for &(cell, face) in self.mesh.boundary_faces() {
            if self.side(cell, usize::from(face), eye) == 1 {
                let corners = self.corners(cell, usize::from(face));
                let center = (corners[0] + corners[1] + corners[2]) / 3.0;
                let distance = match eye {
                    Eye::At(eye) => center.distance_squared(eye),
                    Eye::Toward(direction) => -center.dot(direction),
                };
                faces.push((distance, cell));
            }
        }
        faces.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        faces.into_iter().map(|(_, cell)| cell).collect()
    }

    fn corners(&self, cell: u32, face: usize) -> [DVec3; 3] {
        let points = self.mesh.tetrahedra()[cell as usize];
        FACES[face].map(|corner| self.shape.points[points[corner] as usize])
    }

    /// On which side of a face the eye is: 1 outside of the cell, −1 inside, 0 too near
    /// to the face's plane to tell, where no ray has a length on either side.
    fn side(&self, cell: u32, face: usize, eye: Eye) -> i32 {
        let [a, b, c] = self.corners(cell, face);
        let (u, v) = (b - a, c - a);
        let to_eye = match eye {
            Eye::At(eye) => eye - a,
            Eye::Toward(direction) => direction,
        };
        let volume = u.cross(v).dot(to_eye);
        // Rounding: each of six products is off by less than 5 · 2⁻⁵³ of the greatest
        // coordinates' product. So both cells of a face agree, or neither can tell.
        let largest = |v: DVec3| v.abs().max_element();
        let rounding = 6.0 * 5.0 * f64::EPSILON * largest(u) * largest(v) * largest(to_eye);
        match volume {
            v if v > rounding => 1,
            v if v < -rounding => -1,
            _ => 0,
        }
    }

    /// Whether the neighbor across a face is behind the cell.
    fn behind(&self, cell: u32, face: usize, neighbor: u32, eye: Eye) -> bool {
        // A flat cell does not know its inside; the neighbor does.
        if self.shape.flat[cell as usize] && !self.shape.flat[neighbor as usize] {
            let back = self.mesh.neighbors()[neighbor as usize];
            let back = back.iter().position(|n| *n == cell);
            return back.is_some_and(|face| self.side(neighbor, face, eye) == 1);
        }
        self.side(cell, face, eye) == -1
    }
}

/// Why the order may be wrong whatever the view; `None` if it is right in all views without
/// cycles.
pub(crate) fn unproven(mesh: &TetMesh) -> Option<String> {
    let boundary = mesh.boundary_statistics();
    let count = |n: usize, one: &str, more: &str| match n {
        1 => format!("1 {one}"),
        n => format!("{n} {more}"),
    };
    // A mesh that consists of nothing is convex.
    if mesh.cell_count() == 0 {
        return None;
    }
    if !boundary.convex {
        let crowded = mesh.report().crowded_faces;
        if crowded > 0 {
            let faces = count(crowded, "face belongs", "faces belong");
            return Some(format!("{faces} to more than two cells"));
        }
        let parts = boundary.components;
        return Some(match (parts, boundary.closed) {
            (1, true) => "the mesh is not convex".into(),
            (1, false) => "the mesh's boundary is not a closed surface".into(),
            _ => format!("the mesh's boundary has {parts} parts"),
        });
    }
    let (folded, flat) = doubtful_faces(mesh);
    if folded > 0 {
        let faces = count(folded, "face has", "faces have");
        return Some(format!("{faces} both cells on one side"));
    }
    (flat > 0).then(|| {
        let faces = count(flat, "face is", "faces are");
        format!("{faces} between two cells without volume")
    })
}

/// How many faces have both of their cells on one side, and how many are between two cells
/// without volume, of which neither knows its sides.
fn doubtful_faces(mesh: &TetMesh) -> (usize, usize) {
    let has_no_volume = |cell: u32| has_no_volume(mesh.cell_points(cell as usize));
    // A face as seen from outside of the cell, beginning with its least place.
    let outward = |cell: u32, face: usize| {
        let places = mesh.places()[cell as usize];
        let [a, b, c] = FACES[face].map(|corner| places[corner]);
        match a.min(b).min(c) {
            least if least == a => [a, b, c],
            least if least == b => [b, c, a],
            _ => [c, a, b],
        }
    };
    let (mut folded, mut without_volume) = (0, 0);
    for (neighbors, cell) in mesh.neighbors().iter().zip(0_u32..) {
        for (face, &neighbor) in neighbors.iter().enumerate() {
            // Each face once, from the lower of its cells.
            if neighbor == NO_NEIGHBOR || neighbor < cell {
                continue;
            }
            let other = &mesh.neighbors()[neighbor as usize];
            let own = outward(cell, face);
            let is_shared = |back: usize| {
                let [a, b, c] = outward(neighbor, back);
                other[back] == cell && (own == [a, b, c] || own == [a, c, b])
            };
            let Some(back) = (0..4).find(|back| is_shared(*back)) else {
                continue;
            };
            match [has_no_volume(cell), has_no_volume(neighbor)] {
                [true, true] => without_volume += 1,
                [false, false] => folded += usize::from(outward(neighbor, back) == own),
                _ => {}
            }
        }
    }
    (folded, without_volume)
}

struct Search<'a> {
    mpvo: &'a Mpvo,
    eye: Eye,
    states: Vec<State>,
    /// Open cells, and the faces of each that are to be looked across.
    path: Vec<(u32, usize)>,
    sorted: Sorted,
}

impl Search<'_> {
    /// Finishes `cell` after all that is behind it.
    fn finish_from(&mut self, cell: u32) {
        self.open(cell);
        while let Some(last) = self.path.last_mut() {
            let (cell, face) = *last;
            if face < 4 {
                last.1 += 1;
                let neighbor = self.mpvo.mesh.neighbors()[cell as usize][face];
                if neighbor != NO_NEIGHBOR && self.mpvo.behind(cell, face, neighbor, self.eye) {
                    // Behind a cell and waiting for it: a cycle, broken here.
                    if self.states[neighbor as usize] == State::Open {
                        self.sorted.cycles += 1;
                    }
                    self.open(neighbor);
                }
            } else {
                self.path.pop();
                self.states[cell as usize] = State::Done;
                if self.mpvo.shown[cell as usize] {
                    self.sorted.cells.push(cell);
                }
            }
        }
    }

    fn open(&mut self, cell: u32) {
        let state = &mut self.states[cell as usize];
        if *state == State::New {
            *state = State::Open;
            self.path.push((cell, 0));
        }
    }
}

#[cfg(test)]
mod tests {

    use tetrascope_core::{Camera, CameraFit};

    use super::*;

    fn mesh(points: Vec<DVec3>, cells: Vec<[u32; 4]>) -> TetMesh {
        let scalars = tetrascope_testing::point_scalars(vec![0.0; points.len()]);
        TetMesh::from_tetrahedra(points, cells, scalars).expect("a valid mesh")
    }

    fn sorted(mesh: &TetMesh, side: CameraFit, orthographic: bool) -> Sorted {
        let normalization = Normalization::of(&mesh.bounds());
        let drawn: Vec<u32> = (0..mesh.cell_count() as u32).collect();
        let view = View {
            camera: Camera::fit(&mesh.bounds(), side, orthographic, 1.0),
            width: 1,
            height: 1,
            background: [0.0; 4],
        };
        Mpvo::new(mesh, Shape::new(mesh, &normalization).into(), &drawn)
            .sorted(&view, &normalization)
    }

    // A fan of tetrahedra in a row along x, each sharing a face with the next.
    #[test]
    fn a_row_is_sorted_from_either_end() {
        let mut points = Vec::new();
        for i in 0..20 {
            let x = f64::from(i);
            let turn = 2.0 * x;
            points.push(DVec3::new(x, 3.0 * turn.cos(), 3.0 * turn.sin()));
        }
        let cells: Vec<[u32; 4]> = (0..17).map(|i| [i, i + 1, i + 2, i + 3]).collect();
        let mesh = mesh(points, cells);
        for orthographic in [false, true] {
            let forth = sorted(&mesh, CameraFit::PlusX, orthographic);
            let back = sorted(&mesh, CameraFit::MinusX, orthographic);
            assert_eq!(forth.cycles, 0);
            let place = |s: &Sorted, c: u32| s.cells.iter().position(|x| *x == c).expect("drawn");
            for cell in 0..16 {
                // The shared face's normal has an x of one sign: the one toward the eye.
                assert!(place(&forth, cell) < place(&forth, cell + 1), "cell {cell}");
                assert!(place(&back, cell) > place(&back, cell + 1), "cell {cell}");
            }
        }
    }

    #[test]
    fn every_drawn_cell_comes_once_whatever_the_mesh() {
        let points = vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::ONE,
            -DVec3::X,
        ];
        // A flat cell (0, 1, 2, 5) among others.
        let cells = vec![[0, 1, 2, 3], [1, 2, 3, 4], [0, 1, 2, 5], [0, 2, 3, 5]];
        let mesh = mesh(points, cells);
        for (_, side) in CameraFit::ALL {
            let mut cells = sorted(&mesh, side, true).cells;
            cells.sort_unstable();
            assert_eq!(cells, [0, 1, 2, 3]);
        }
    }
}
