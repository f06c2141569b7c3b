//! Polyhedra into tetrahedra that agree across shared faces.
//!
//! A polyhedron gets a point at the mean of its corners and a tetrahedron for each triangle
//! of its faces. A face is a fan from its smallest corner, as [`TetMesh`] cuts the faces of
//! other cells. Where such a triangle would be turned over or nearly without area, as in faces
//! that are not convex or have a point within an edge, the face is cut around a point at the
//! mean of its own corners, unless a cell of another type has it as well. Both cells of a face
//! thus cut it alike. Corners are ordered by the least index among the points at their place,
//! as in [`TetMesh`], so that this holds also for cells that share places and not points.
//!
//! A field at points has the mean of the corners' values at an added point; a field in cells
//! keeps the polyhedron's value in each tetrahedron. A polyhedron must be star-shaped about
//! the mean of its corners, as convex ones are; parts of others overlap, and a note counts
//! them.
//!
//! [`TetMesh`]: tetrascope_core::TetMesh

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;
use tetrascope_core::mesh::{volume_corners, volume_faces};
use tetrascope_core::{Cells, Error, glam};

use crate::MeshData;
use crate::source::{count, reserve, room};

/// VTK's type of a cell with any faces.
pub(crate) const POLYHEDRON: u8 = 42;

/// VTK's type of a cell with four corners.
const TETRAHEDRON: u8 = 10;

/// A triangle of a fan must have more of its face's area than this, seen along the normal.
const LEAST_SHARE: f64 = 1e-3;

/// The faces of the polyhedra among the cells of a mesh.
///
/// The points of a polyhedron's faces, one face after the other, are its points in [`Cells`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Polyhedra {
    /// Which of the file's cells each is, ascending.
    cells: Vec<usize>,
    /// How many faces each has.
    face_counts: Vec<u32>,
    /// How many points each face has, those of the first polyhedron first.
    sizes: Vec<u32>,
}

/// The points that cutting adds, and how many cells each cell of the file became.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    /// How many cells each of the kept cells became.
    pub(crate) copies: Vec<u32>,
    /// Where the corners of each added point end.
    ends: Vec<usize>,
    /// The corners whose mean is an added point.
    corners: Vec<u64>,
}

impl Added {
    /// How many points were added.
    pub(crate) fn points(&self) -> usize {
        self.ends.len()
    }

    fn push(&mut self, points: &mut Vec<DVec3>, corners: &[u64]) -> u64 {
        let sum: DVec3 = corners.iter().map(|&p| points[p as usize]).sum();
        points.push(sum / corners.len() as f64);
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
        points.len() as u64 - 1
    }

    /// Appends the values at added points to those of all other points.
    pub(crate) fn extend_points(&self, values: &mut Vec<f64>) -> Result<(), Error> {
        reserve(values, self.points())?;
        let mut start = 0;
        for &end in &self.ends {
            let corners = &self.corners[start..end];
            let sum: f64 = corners.iter().map(|&p| values[p as usize]).sum();
            values.push(sum / corners.len() as f64);
            start = end;
        }
        Ok(())
    }

    /// The values of cells from those of the cells that they were cut from.
    pub(crate) fn spread_cells(&self, values: &[f64]) -> Result<Vec<f64>, Error> {
        let all = self.copies.iter().map(|&n| n as usize).sum();
        let mut spread = room(all)?;
        for (&value, &copies) in values.iter().zip(&self.copies) {
            spread.extend(std::iter::repeat_n(value, copies as usize));
        }
        Ok(spread)
    }
}

impl Polyhedra {
    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.cells.len()
    }

    /// Adds the faces of the file's cell `cell`, by how many points each has.
    pub(crate) fn push(&mut self, cell: usize, sizes: impl Iterator<Item = u32>) {
        let before = self.sizes.len();
        self.sizes.extend(sizes);
        self.cells.push(cell);
        self.face_counts.push((self.sizes.len() - before) as u32); // of the file's bytes
    }

    /// The sizes of the faces of each polyhedron that is kept.
    fn kept<'a>(&'a self, kept_cells: &'a [bool]) -> impl Iterator<Item = &'a [u32]> {
        let mut rest = self.sizes.as_slice();
        let faces = self.face_counts.iter().map(move |&faces| {
            let (sizes, others) = rest.split_at(faces as usize);
            rest = others;
            sizes
        });
        let kept = self.cells.iter().map(|&cell| kept_cells.get(cell));
        let both = faces.zip(kept);
        both.filter_map(|(sizes, kept)| (kept != Some(&false)).then_some(sizes))
    }

    /// Puts tetrahedra in the place of the polyhedra of a mesh. `most` bounds the bytes that
    /// these and the points that are added may take.
    ///
    /// # Errors
    /// Faces that do not close a cell, and too little memory.
    pub(crate) fn split(&self, path: &Path, data: &mut MeshData, most: u64) -> Result<(), Error> {
        if self.kept(&data.kept_cells).next().is_none() {
            return Ok(());
        }
        let refuse = |at: String, what: String, help: &str| Error::Format {
            path: path.to_owned(),
            at,
            what,
            help: Some(help.into()),
        };
        // A tetrahedron for each edge of a face at most, with its type, its end and four
        // corners; and a corner of an added point.
        let edges: u64 = self
            .kept(&data.kept_cells)
            .flatten()
            .map(|&n| u64::from(n))
            .sum();
        let face_count = self.kept(&data.kept_cells).flatten().count() as u64;
        let Cells {
            types,
            connectivity,
            ..
        } = &data.cells;
        let held = 24 * data.points.len() + 9 * types.len() + 8 * connectivity.len();
        if edges * (41 + 8) + face_count * (24 + 8) + held as u64 > most {
            return Err(refuse(
                "<Cells>".into(),
                format!("polyhedra with {edges} corners of faces take more than {most} bytes"),
                "the file is damaged; write it again",
            ));
        }
        let order = Order::new(data);
        let mut centers = self.faces_with_centers(data, &order);
        let mut added = Added::default();
        let mut cells = Cells::default();
        reserve(&mut data.points, self.count())?;
        cells.offsets.push(0);
        let mut sizes = self.kept(&data.kept_cells);
        let (mut polyhedra, mut tetrahedra, mut overlapping) = (0_u64, 0_u64, 0_u64);
        for (cell, &kind) in data.cells.types.iter().enumerate() {
            let ends = &data.cells.offsets[cell..cell + 2];
            let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
            if kind != POLYHEDRON {
                cells.types.push(kind);
                cells.connectivity.extend_from_slice(points);
                cells.offsets.push(cells.connectivity.len() as u64);
                added.copies.push(1);
                continue;
            }
            let faces = faces(points, sizes.next().unwrap_or_default(), &order);
            let surface = surface(&faces, &order).map_err(|what| {
                refuse(
                    format!("cell {cell}"),
                    format!("the faces of a polyhedron do not close it: {what}"),
                    "repair the mesh, or leave the cell out",
                )
            })?;
            let mut corners: Vec<u64> = faces.iter().flatten().copied().collect();
            corners.sort_unstable_by_key(|&point| order.of(point));
            corners.dedup_by_key(|point| order.place(*point));
            let before = cells.types.len();
            let mut volumes = (0.0, 0.0_f64);
            let mut add = |points: &[DVec3], mut corners: [u64; 4]| {
                let [a, b, c, d] = corners.map(|point| points[point as usize]);
                let volume = (b - a).dot((c - a).cross(d - a));
                if volume < 0.0 {
                    corners.swap(2, 3);
                }
                volumes = (volumes.0 + volume, volumes.1 + volume.abs());
                cells.types.push(TETRAHEDRON);
                cells.connectivity.extend(corners);
                cells.offsets.push(cells.connectivity.len() as u64);
            };
            polyhedra += 1;
            if let (&[a, b, c, d], 4) = (&corners[..], faces.len()) {
                add(&data.points, [a, b, c, d]);
            } else {
                let apex = added.push(&mut data.points, &corners);
                for face in &faces {
                    let center = centers.get_mut(&order.key(face)).map(|center| {
                        *center.get_or_insert_with(|| {
                            let corners = order.sorted(face);
                            added.push(&mut data.points, &corners)
                        })
                    });
                    each_triangle(face, center, |triangle| {
                        let [a, b, c] = triangle;
                        add(&data.points, [apex, a, b, c]);
                    });
                }
            }
            let copies = cells.types.len() - before;
            tetrahedra += copies as u64;
            added.copies.push(copies as u32); // no more than edges
            let (signed, all) = volumes;
            let is_whole = signed.abs() >= all * (1.0 - 1e-9);
            overlapping += u64::from(copies > 1 && surface == Surface::Oriented && !is_whole);
        }
        drop(sizes);
        data.cells = cells;
        let around = centers.values().filter(|center| center.is_some()).count() as u64;
        let of_faces = match around {
            0 => String::new(),
            faces => format!(", {} around their own", count(faces, "face")),
        };
        data.notes.push(format!(
            "{polyhedra} polyhedra cut into {} around the mean of their corners{of_faces}; fields \
             at points have the mean of the corners' values there",
            count(tetrahedra, "tetrahedron").replace("tetrahedrons", "tetrahedra")
        ));
        if overlapping > 0 {
            data.notes.push(format!(
                "{overlapping} polyhedra do not see all of their faces from the mean of their \
                 corners: parts of them overlap"
            ));
        }
        data.added = Some(Box::new(added));
        Ok(())
    }

    /// The faces that are cut around a point of their own, by key, and that point once it is
    /// there.
    fn faces_with_centers(
        &self,
        data: &MeshData,
        order: &Order,
    ) -> HashMap<Box<[u64]>, Option<u64>> {
        let mut centers = HashMap::new();
        let mut sizes = self.kept(&data.kept_cells);
        let cells = || {
            let ends = data.cells.offsets.windows(2);
            data.cells.types.iter().zip(ends).map(|(&kind, ends)| {
                let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
                (kind, points)
            })
        };
        for (_, points) in cells().filter(|(kind, _)| *kind == POLYHEDRON) {
            for face in faces(points, sizes.next().unwrap_or_default(), order) {
                if face.len() > 3 && !is_good_fan(&face, &data.points) {
                    centers.insert(order.key(&face), None);
                }
            }
        }
        if centers.is_empty() {
            return centers;
        }
        // Cells of other types cut all faces as fans.
        for (kind, points) in cells() {
            for face in volume_faces(kind).unwrap_or_default() {
                let corners = face.iter().map(|&corner| points.get(corner).copied());
                let corners: Option<Vec<u64>> = corners.collect();
                if let Some(corners) = corners.filter(|corners| corners.len() > 3) {
                    centers.remove(&order.key(&corners));
                }
            }
        }
        centers
    }
}

/// How the faces of a closed polyhedron lie.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Surface {
    /// All to the outside, or all to the inside.
    Oriented,
    Mixed,
}

/// Whether each edge belongs to two faces; else what is wrong.
fn surface(faces: &[Vec<u64>], order: &Order) -> Result<Surface, String> {
    let mut edges: Vec<(u64, u64, bool, u64, u64)> = Vec::new();
    for face in faces {
        let next = face.iter().cycle().skip(1);
        edges.extend(face.iter().zip(next).map(|(&a, &b)| {
            let (from, to) = (order.place(a), order.place(b));
            (from.min(to), from.max(to), from < to, a, b)
        }));
    }
    if edges.is_empty() {
        return Err("it has none".into());
    }
    edges.sort_unstable();
    let mut surface = Surface::Oriented;
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match edge {
            [one, other] if one.2 != other.2 => {}
            [_, _] => surface = Surface::Mixed,
            _ => {
                let (.., a, b) = edge[0];
                let faces = count(edge.len() as u64, "face");
                return Err(format!(
                    "the edge between points {a} and {b} belongs to {faces}"
                ));
            }
        }
    }
    Ok(surface)
}

/// The faces of a polyhedron with these points, without repeated points and without faces that
/// have no three points then. Each begins with its smallest corner.
fn faces(points: &[u64], sizes: &[u32], order: &Order) -> Vec<Vec<u64>> {
    let mut rest = points;
    let mut faces = Vec::with_capacity(sizes.len());
    for &size in sizes {
        let (face, others) = rest.split_at((size as usize).min(rest.len()));
        rest = others;
        let mut face = face.to_vec();
        face.dedup_by_key(|point| order.place(*point));
        if face.len() > 1 && order.place(face[0]) == order.place(face[face.len() - 1]) {
            face.pop();
        }
        if face.len() < 3 {
            continue;
        }
        let smallest = (0..face.len()).min_by_key(|&i| order.of(face[i]));
        face.rotate_left(smallest.unwrap_or(0));
        faces.push(face);
    }
    faces
}

/// Whether a fan from the first corner has no triangle that is turned over or too small.
///
/// The same for a face in both directions, to the last bit.
fn is_good_fan(face: &[u64], points: &[DVec3]) -> bool {
    let corners: Vec<DVec3> = face.iter().map(|&p| points[p as usize]).collect();
    let spokes: Vec<DVec3> = corners[1..].iter().map(|p| p - corners[0]).collect();
    let areas: Vec<DVec3> = spokes.array_windows().map(|[a, b]| a.cross(*b)).collect();
    // In the other direction all areas change their signs, and come in the opposite order.
    let forward: DVec3 = areas.iter().sum();
    let backward: DVec3 = areas.iter().rev().sum();
    let whole = forward + backward;
    let least = LEAST_SHARE * whole.length_squared();
    areas.iter().all(|area| 2.0 * area.dot(whole) >= least)
}

/// Calls `each` with the triangles of a face: a fan from its first corner, or from `center`.
fn each_triangle(face: &[u64], center: Option<u64>, mut each: impl FnMut([u64; 3])) {
    match center {
        None => {
            for pair in face[1..].array_windows() {
                let [a, b] = *pair;
                each([face[0], a, b]);
            }
        }
        Some(center) => {
            let next = face.iter().cycle().skip(1);
            face.iter()
                .zip(next)
                .for_each(|(&a, &b)| each([center, a, b]));
        }
    }
}

/// The order of points: by the least index of the corners at their place, then by index.
struct Order {
    /// By point; empty where no two corners coincide.
    places: Vec<u64>,
}

impl Order {
    fn new(data: &MeshData) -> Order {
        let mut used = vec![false; data.points.len()];
        let ends = data.cells.offsets.windows(2);
        for (&kind, ends) in data.cells.types.iter().zip(ends) {
            let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
            let corners = match kind {
                POLYHEDRON => points.len(),
                _ => volume_corners(kind).unwrap_or(0),
            };
            for &point in points.iter().take(corners) {
                used[point as usize] = true;
            }
        }
        // Adding 0 turns −0 into +0, which is at the same place.
        let place = |point: u64| {
            data.points[point as usize]
                .to_array()
                .map(|x| (x + 0.0).to_bits())
        };
        let mut corners: Vec<u64> = (0..used.len() as u64)
            .filter(|&p| used[p as usize])
            .collect();
        corners.par_sort_unstable_by_key(|&point| (place(point), point));
        if corners.array_windows().all(|[a, b]| place(*a) != place(*b)) {
            return Order { places: Vec::new() };
        }
        let mut places: Vec<u64> = (0..used.len() as u64).collect();
        for same in corners.chunk_by(|a, b| place(*a) == place(*b)) {
            same.iter()
                .for_each(|&point| places[point as usize] = same[0]);
        }
        Order { places }
    }

    fn place(&self, point: u64) -> u64 {
        self.places.get(point as usize).copied().unwrap_or(point)
    }

    fn of(&self, point: u64) -> (u64, u64) {
        (self.place(point), point)
    }

    fn sorted(&self, face: &[u64]) -> Vec<u64> {
        let mut corners = face.to_vec();
        corners.sort_unstable_by_key(|&point| self.of(point));
        corners
    }

    /// The places of a face's corners, sorted: the same for every face between them.
    fn key(&self, face: &[u64]) -> Box<[u64]> {
        let mut places: Vec<u64> = face.iter().map(|&point| self.place(point)).collect();
        places.sort_unstable();
        places.into()
    }
}

#[cfg(test)]
mod tests;
