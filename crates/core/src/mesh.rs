//! Unstructured meshes: any linear cells in, tetrahedra out.

mod adjacency;
mod boundary;
mod cell_type;
mod crossed;
pub mod curved;
mod five;
mod orientation;
mod places;
mod report;
mod sort;
mod split;
mod warp;

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use crate::groups::marked;
use crate::{Bounds, Error, is_value};

pub use adjacency::FACES;
pub use boundary::BoundaryStatistics;
pub use cell_type::{type_name, volume_corners, volume_faces};
pub use report::MeshReport;
pub use split::Split;

use adjacency::Adjacency;
use orientation::{LARGEST_COORDINATE, determinant, orientation};
use places::Places;
use split::Pieces;

/// Cells in VTK's layout: cell i has the type `types[i]` and the points
/// `connectivity[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// VTK's numbers: 10 tetra, 11 voxel, 12 hexahedron, 13 wedge, 14 pyramid,
    /// 24…27 their quadratic forms, …
    pub types: Vec<u8>,
    /// One more than there are cells, not decreasing, from 0 to the length of `connectivity`.
    pub offsets: Vec<u64>,
    /// Point indices.
    pub connectivity: Vec<u64>,
}

/// Where a field's values live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Association {
    /// One value a point, linear in each tetrahedron.
    Point,
    /// One value an input cell, constant in it.
    Cell,
}

/// A scalar field on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalars {
    /// Name in the file.
    pub name: String,
    /// Where the values live.
    pub association: Association,
    /// One for each point or each input cell. A number that is not a value ([`is_value`]) becomes NaN in
    /// a [`TetMesh`], and cells that have it are transparent.
    pub values: Vec<f64>,
}

/// A tetrahedral mesh with one scalar field.
///
/// Cheap to clone: geometry is shared, also between meshes that differ in their
/// scalars alone ([`TetMesh::with_scalars`]).
///
/// # Memory
/// 24 bytes per point, 32 per tetrahedron and 8 per boundary face; 4 more per tetrahedron where cells
/// were split, 16 more where points coincide, and 1 per point where some are unused. While neighbors
/// are found, it needs 8 more per tetrahedron and up to 40 per point. [`TetMesh::keeping_cells`] keeps 9 more per input
/// cell and 8 for each of its points.
#[derive(Clone, Debug)]
pub struct TetMesh {
    geometry: Arc<Geometry>,
    field: Arc<Field>,
}

#[derive(Debug)]
struct Geometry {
    points: Vec<DVec3>,
    /// Whether tetrahedra use each point; empty where they use all.
    used: Vec<bool>,
    tetrahedra: Vec<[u32; 4]>,
    /// The same by places; empty where no two points coincide.
    places: Vec<[u32; 4]>,
    /// The input cell of each tetrahedron; empty when each is its own.
    sources: Vec<u32>,
    input_cell_count: usize,
    /// The input cells, if they were to be kept.
    cells: Option<Arc<Cells>>,
    bounds: Bounds,
    /// Without what the adjacency holds or the scalars decide.
    report: MeshReport,
    adjacency: Adjacency,
    boundary: OnceLock<BoundaryStatistics>,
    volume: OnceLock<f64>,
}

impl Geometry {
    /// Whether all that is made of `other` would be made of this, to the last bit.
    fn is_same(&self, other: &Geometry) -> bool {
        let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
        let points = || self.points.iter().map(bits);
        // Places and bounds are made from these; the report says how.
        self.points.len() == other.points.len()
            && self.tetrahedra == other.tetrahedra
            && self.sources == other.sources
            && self.input_cell_count == other.input_cell_count
            && self.report == other.report
            && points().eq(other.points.iter().map(bits))
            && self.cells == other.cells
    }
}

#[derive(Debug)]
struct Field {
    scalars: Scalars,
    range: OnceLock<Option<(f64, f64)>>,
    continuous: OnceLock<bool>,
}

/// VTK's type of a cell of four corners.
const TETRAHEDRON: u8 = 10;

impl TetMesh {
    /// Splits `cells` into tetrahedra that agree across shared faces, by
    /// [`Split::SmallestIndex`].
    ///
    /// Taken are VTK's linear volume cells; curved ones (quadratic, Lagrange, Bézier)
    /// by their corners. Points, curves and surfaces are skipped. Orientation is
    /// fixed where it is wrong, tetrahedra with two corners at one place are left out,
    /// and of tetrahedra with the same four corners the first is kept; points that
    /// coincide count as the same in this. What was found is in [`TetMesh::report`].
    ///
    /// # Errors
    /// With the cell's number: offsets that decrease or run out of the connectivity, a
    /// wrong number of points, a point that does not exist or is not finite,
    /// polyhedra and unknown types. Also no volume cell at all, more points or cells
    /// than 32 bits count, and scalars of the wrong length.
    pub fn new(points: Vec<DVec3>, cells: &Cells, scalars: Scalars) -> Result<TetMesh, Error> {
        TetMesh::with_split(points, cells, scalars, Split::default())
    }

    /// As [`TetMesh::new`], with a choice of how cells are cut.
    ///
    /// # Errors
    /// Also cells that cannot be cut so.
    pub fn with_split(
        points: Vec<DVec3>,
        cells: &Cells,
        scalars: Scalars,
        split: Split,
    ) -> Result<TetMesh, Error> {
        check_counts(points.len(), cells.types.len())?;
        split::check_cells(&points, cells)?;
        let mut report = MeshReport::default();
        let mut counts = [0; 256];
        for &cell_type in &cells.types {
            counts[usize::from(cell_type)] += 1;
        }
        let counts = (0..=u8::MAX).zip(counts).filter(|(_, count)| *count > 0);
        report.cells_by_type = counts.collect();
        for (&cell_type, &count) in &report.cells_by_type {
            match cell_type::Kind::of(cell_type) {
                cell_type::Kind::Linear(_) => {}
                cell_type::Kind::Quadratic(..) | cell_type::Kind::AnyOrder(_) => {
                    report.quadratic += count;
                }
                cell_type::Kind::Skipped | cell_type::Kind::Refused => {
                    report.skipped.insert(cell_type, count);
                }
            }
        }
        if report.skipped.values().sum::<usize>() == cells.types.len() {
            let found = report.skipped.iter();
            let found: Vec<String> = found
                .map(|(&cell_type, count)| format!("{count} × {}", type_name(cell_type)))
                .collect();
            return Err(Error::Invalid {
                what: match found.is_empty() {
                    true => "the mesh has no cells".into(),
                    false => format!("the mesh has no volume cells, only {}", found.join(", ")),
                },
                help: Some(
                    "a volume needs tetrahedra, hexahedra, voxels, wedges, prisms or pyramids"
                        .into(),
                ),
            });
        }
        let named = cells.connectivity.par_iter().map(|&point| point as usize);
        let named = marked(points.len(), named);
        report.unused_points = named.iter().filter(|named| !**named).count();
        drop(named);
        (report.warped, report.warp) = warp::warped_cells(&points, cells);
        let places = Places::new(&points, &split::used_corners(points.len(), cells));
        let pieces = split::split_cells(&points, cells, &places, split)?;
        TetMesh::from_pieces(points, &places, pieces, cells.types.len(), report, scalars)
    }

    /// As [`TetMesh::with_split`], and keeps the cells as they are: for whom a hexahedron or a
    /// curved cell is more than its tetrahedra.
    ///
    /// # Errors
    /// As [`TetMesh::with_split`].
    pub fn keeping_cells(
        points: Vec<DVec3>,
        cells: Arc<Cells>,
        scalars: Scalars,
        split: Split,
    ) -> Result<TetMesh, Error> {
        let mut mesh = TetMesh::with_split(points, &cells, scalars, split)?;
        let geometry = Arc::get_mut(&mut mesh.geometry).expect("nobody else has it yet");
        geometry.cells = Some(cells);
        Ok(mesh)
    }

    /// As [`TetMesh::new`], and keeps the cells ([`TetMesh::cells`]) if they are not all tetrahedra.
    ///
    /// # Errors
    /// As [`TetMesh::new`].
    pub fn from_cells(
        points: Vec<DVec3>,
        cells: Cells,
        scalars: Scalars,
    ) -> Result<TetMesh, Error> {
        if let Some(tetrahedra) = split::as_tetrahedra(points.len(), &cells) {
            drop(cells); // they are larger than the mesh
            return TetMesh::from_tetrahedra(points, tetrahedra, scalars);
        }
        let is_other =
            |cell_type: &u8| volume_corners(*cell_type).is_some() && *cell_type != TETRAHEDRON;
        match cells.types.iter().any(is_other) {
            true => TetMesh::keeping_cells(points, Arc::new(cells), scalars, Split::default()),
            false => TetMesh::new(points, &cells, scalars),
        }
    }

    /// A mesh of tetrahedra, treated as in [`TetMesh::new`]. May be empty.
    ///
    /// # Errors
    /// A cell that names a point that does not exist or is not finite, more points or
    /// cells than 32 bits count, and scalars of the wrong length.
    pub fn from_tetrahedra(
        points: Vec<DVec3>,
        tetrahedra: Vec<[u32; 4]>,
        scalars: Scalars,
    ) -> Result<TetMesh, Error> {
        check_counts(points.len(), tetrahedra.len())?;
        split::check_tetrahedra(&points, &tetrahedra)?;
        let used = used_points(points.len(), &tetrahedra);
        let places = Places::new(&points, &used);
        let cell_count = tetrahedra.len();
        let pieces = split::orient_tetrahedra(&points, tetrahedra, &places);
        let mut report = MeshReport::default();
        report.cells_by_type.insert(TETRAHEDRON, cell_count);
        report.unused_points = used.iter().filter(|used| !**used).count();
        drop(used);
        TetMesh::from_pieces(points, &places, pieces, cell_count, report, scalars)
    }

    fn from_pieces(
        points: Vec<DVec3>,
        places: &Places,
        mut pieces: Pieces,
        input_cell_count: usize,
        mut report: MeshReport,
        scalars: Scalars,
    ) -> Result<TetMesh, Error> {
        // One cell becomes up to 16 tetrahedra.
        check_counts(points.len(), pieces.tetrahedra.len())?;
        let mut cells_by_place = places.of_cells(&pieces.tetrahedra);
        let mut adjacency = Adjacency::new(&cells_by_place, &pieces.tetrahedra, points.len());
        if adjacency.has_duplicates {
            report.duplicates = pieces.remove_duplicates(places, points.len());
            cells_by_place = places.of_cells(&pieces.tetrahedra);
            adjacency = Adjacency::new(&cells_by_place, &pieces.tetrahedra, points.len());
        }
        let places = cells_by_place;
        let Pieces {
            tetrahedra,
            mut sources,
            ..
        } = pieces;
        report.tetrahedra = tetrahedra.len();
        let by_place = if places.is_empty() {
            &tetrahedra
        } else {
            &places
        };
        report.crossed_faces = crossed::crossed_faces(by_place, &adjacency.boundary, &sources);
        report.flipped = pieces.flipped;
        report.folded = pieces.folded;
        report.collapsed = pieces.collapsed;
        report.degenerate = match report.duplicates {
            0 => pieces.degenerate,
            _ => {
                let cells = tetrahedra.par_iter();
                let positions = cells.map(|&cell| corners_of(cell, &points));
                positions.filter(|p| orientation(*p).degenerate).count()
            }
        };
        if sources
            .iter()
            .zip(0..)
            .all(|(&source, cell)| source == cell)
        {
            sources = Vec::new();
        }
        let mut used = used_points(points.len(), &tetrahedra);
        report.coincident_points = match places.is_empty() {
            true => 0,
            false => {
                let places = used_points(points.len(), &places);
                let is_other = |(used, place): &(&bool, &bool)| **used && !**place;
                used.iter().zip(&places).filter(is_other).count()
            }
        };
        if used.iter().all(|used| *used) {
            used = Vec::new();
        }
        let geometry = Geometry {
            bounds: Bounds::of(used_among(&used, &points).copied()),
            points,
            used,
            tetrahedra,
            places,
            sources,
            input_cell_count,
            cells: None,
            report,
            adjacency,
            boundary: OnceLock::new(),
            volume: OnceLock::new(),
        };
        TetMesh::assemble(Arc::new(geometry), scalars)
    }

    fn assemble(geometry: Arc<Geometry>, mut scalars: Scalars) -> Result<TetMesh, Error> {
        let (expected, per) = match scalars.association {
            Association::Point => (geometry.points.len(), "points"),
            Association::Cell => (geometry.input_cell_count, "cells"),
        };
        if scalars.values.len() != expected {
            return Err(Error::invalid(format!(
                "field '{}' has {} values for {expected} {per}",
                scalars.name,
                scalars.values.len()
            )));
        }
        // Mark missing values by NaN.
        for value in scalars.values.iter_mut().filter(|v| !is_value(**v)) {
            *value = f64::NAN;
        }
        Ok(TetMesh {
            geometry,
            field: Arc::new(Field {
                scalars,
                range: OnceLock::new(),
                continuous: OnceLock::new(),
            }),
        })
    }

    /// The same geometry with another field; nothing is rebuilt.
    ///
    /// # Errors
    /// The number of values is not that of the points or input cells.
    pub fn with_scalars(&self, scalars: Scalars) -> Result<TetMesh, Error> {
        TetMesh::assemble(self.geometry.clone(), scalars)
    }

    /// Whether `other` has the very same geometry, so that only scalars need an upload.
    pub fn shares_geometry(&self, other: &TetMesh) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
    }

    /// This mesh on the geometry of `other`, if that is the same to the last bit; else as it
    /// is. Steps of a series that were read from files of their own share geometry so.
    pub fn sharing_with(self, other: &TetMesh) -> TetMesh {
        match self.geometry.is_same(&other.geometry) {
            true => TetMesh {
                geometry: other.geometry.clone(),
                field: self.field,
            },
            false => self,
        }
    }

    /// Positions, world space.
    pub fn points(&self) -> &[DVec3] {
        &self.geometry.points
    }

    /// The numbers of the points that tetrahedra use, ascending.
    pub fn points_in_use(&self) -> impl Iterator<Item = u32> {
        (0..).take(self.points().len()).filter(|&point| {
            let used = self.geometry.used.get(point as usize);
            used != Some(&false)
        })
    }

    /// Point indices of each cell, positively oriented:
    /// (p₁ − p₀) · ((p₂ − p₀) × (p₃ − p₀)) ≥ 0, with 0 for a degenerate cell. Exact:
    /// of a cell that is flat but for rounding, f64 may compute the opposite sign.
    pub fn tetrahedra(&self) -> &[[u32; 4]] {
        &self.geometry.tetrahedra
    }

    /// The cells by the places of their points, in the order of [`TetMesh::tetrahedra`]:
    /// in place of each point the least of the points with the same position, −0 being 0,
    /// that cells use. The very slice of [`TetMesh::tetrahedra`] where no two coincide.
    ///
    /// This is what neighbors and boundary are made from, and the four of a cell always
    /// differ. Values are still each point's own.
    pub fn places(&self) -> &[[u32; 4]] {
        match self.geometry.places.is_empty() {
            true => &self.geometry.tetrahedra,
            false => &self.geometry.places,
        }
    }

    /// Whether the field has one value at each place: always for cell data, and for point
    /// data unless points that coincide have different values; NaN equals NaN. Found on
    /// first use and kept.
    pub fn is_continuous(&self) -> bool {
        let scalars = &self.field.scalars;
        if scalars.association == Association::Cell || self.geometry.places.is_empty() {
            return true;
        }
        *self.field.continuous.get_or_init(|| {
            let value = |point: u32| scalars.values[point as usize];
            let equal = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
            let cells = self.tetrahedra().iter().zip(self.places());
            cells
                .flat_map(|(points, places)| points.iter().zip(places))
                .all(|(&point, &place)| equal(value(point), value(place)))
        })
    }

    /// How many tetrahedra there are.
    pub fn cell_count(&self) -> usize {
        self.geometry.tetrahedra.len()
    }

    /// How many input cells there were, drawn or not.
    pub fn input_cell_count(&self) -> usize {
        self.geometry.input_cell_count
    }

    /// The input cell that tetrahedron `cell` was cut from.
    pub fn source_cell(&self, cell: usize) -> usize {
        match self.geometry.sources.get(cell) {
            Some(&source) => source as usize,
            None => cell,
        }
    }

    /// The input cells, if the mesh was made to keep them ([`TetMesh::keeping_cells`]); also
    /// those that are skipped. They name [`TetMesh::points`], and are numbered as
    /// [`TetMesh::source_cell`] and values of cells are.
    pub fn cells(&self) -> Option<&Arc<Cells>> {
        self.geometry.cells.as_ref()
    }

    /// The field.
    pub fn scalars(&self) -> &Scalars {
        &self.field.scalars
    }

    /// The positions of a cell's points.
    pub fn cell_points(&self, cell: usize) -> [DVec3; 4] {
        corners_of(self.geometry.tetrahedra[cell], &self.geometry.points)
    }

    /// The scalars at a cell's points: the linear function that it carries.
    ///
    /// All equal for cell data, so one path serves both.
    pub fn cell_scalars(&self, cell: usize) -> [f64; 4] {
        match self.field.scalars.association {
            Association::Point => {
                self.geometry.tetrahedra[cell].map(|p| self.field.scalars.values[p as usize])
            }
            Association::Cell => [self.field.scalars.values[self.source_cell(cell)]; 4],
        }
    }

    /// The box around all points that cells use.
    pub fn bounds(&self) -> Bounds {
        self.geometry.bounds
    }

    /// The least and greatest finite scalar that cells use, if there is any.
    /// Found on first use and kept.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        *self.field.range.get_or_init(|| {
            self.values_in_use()
                .filter(|s| s.is_finite())
                .fold(None, |range, s| match range {
                    None => Some((s, s)),
                    Some((low, high)) => Some((s.min(low), s.max(high))),
                })
        })
    }

    /// The values that tetrahedra use: each point's once, each cell's at least once.
    fn values_in_use(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        let Scalars {
            association,
            values,
            ..
        } = &self.field.scalars;
        match association {
            Association::Point => Box::new(used_among(&self.geometry.used, values).copied()),
            Association::Cell => {
                let cells = 0..self.cell_count();
                Box::new(cells.map(|cell| values[self.source_cell(cell)]))
            }
        }
    }

    /// The neighbor of each cell across the face opposite its vertex 0…3;
    /// [`NO_NEIGHBOR`] at the boundary.
    ///
    /// Cells share a face if its corners are the same or coincide ([`TetMesh::places`]). A
    /// face that three or more cells share is the boundary of each.
    pub fn neighbors(&self) -> &[[u32; 4]] {
        &self.geometry.adjacency.neighbors
    }

    /// The boundary faces as (cell, opposite vertex 0…3), by cell. [`FACES`] gives a face's
    /// corners.
    pub fn boundary_faces(&self) -> &[(u32, u8)] {
        &self.geometry.adjacency.boundary
    }

    /// The findings and repairs of the mesh.
    pub fn report(&self) -> MeshReport {
        let values = &self.field.scalars.values;
        let non_finite_scalars = match self.field.scalars.association {
            Association::Cell => values.iter().filter(|v| !v.is_finite()).count(),
            Association::Point => self.values_in_use().filter(|v| !v.is_finite()).count(),
        };
        MeshReport {
            crowded_faces: self.crowded_face_count(),
            joined_faces: self.geometry.adjacency.joined_faces,
            non_finite_scalars,
            ..self.geometry.report.clone()
        }
    }

    /// The shape of the boundary. Found on first use and kept.
    pub fn boundary_statistics(&self) -> &BoundaryStatistics {
        self.geometry
            .boundary
            .get_or_init(|| boundary::boundary_statistics(self))
    }

    /// Faces of three or more cells.
    fn crowded_face_count(&self) -> usize {
        self.geometry.adjacency.crowded_faces
    }

    /// The sum of the cells' volumes, cubic world units; 0 or more. Found on first use and kept.
    pub fn volume(&self) -> f64 {
        *self.geometry.volume.get_or_init(|| {
            // Sums of sums: a single sum over a million cells would lose five digits. The
            // pieces are fixed, so that the result does not depend on the threads.
            let sums: Vec<f64> = self
                .tetrahedra()
                .par_chunks(1024)
                .map(|cells| {
                    let six_times = cells
                        .iter()
                        .map(|&cell| determinant(corners_of(cell, self.points())));
                    six_times.sum()
                })
                .collect();
            let six_times: f64 = sums.iter().sum();
            // Cells flatter than rounding may have a sum below 0, and no cell has a volume below it.
            six_times.max(0.0) / 6.0
        })
    }
}

/// In place of a cell index: there is no cell.
pub const NO_NEIGHBOR: u32 = u32::MAX;

fn check_counts(point_count: usize, cell_count: usize) -> Result<(), Error> {
    // The largest u32 stands for "no neighbor".
    for (what, count) in [("points", point_count), ("cells", cell_count)] {
        if count >= NO_NEIGHBOR as usize {
            return Err(Error::Invalid {
                what: format!(
                    "the mesh has {count} {what}; at most {} fit",
                    NO_NEIGHBOR - 1
                ),
                help: Some("cut the mesh into parts and draw them one at a time".into()),
            });
        }
    }
    Ok(())
}

/// The index of a point of a cell, if it exists and lies where arithmetic works.
fn check_point(points: &[DVec3], cell: usize, point: u64) -> Result<u32, Error> {
    let position = usize::try_from(point).ok().and_then(|p| points.get(p));
    match position {
        None => Err(Error::invalid(format!(
            "cell {cell} uses point {point}, but there are {} points, counted from 0",
            points.len()
        ))),
        Some(p) if !lies_well(p) => Err(Error::Invalid {
            what: format!(
                "cell {cell} uses point {point}, which lies at ({}, {}, {})",
                p.x, p.y, p.z
            ),
            help: Some(format!(
                "coordinates must be finite and at most {LARGEST_COORDINATE:e} in magnitude"
            )),
        }),
        Some(_) => Ok(u32::try_from(point).expect("checked with the counts")),
    }
}

/// Whether a point lies where arithmetic works.
fn lies_well(point: &DVec3) -> bool {
    point.abs().max_element() <= LARGEST_COORDINATE && point.is_finite()
}

/// The positions of four points. (`array::map` is a call for each, which is not inlined.)
#[inline]
fn corners_of([a, b, c, d]: [u32; 4], points: &[DVec3]) -> [DVec3; 4] {
    let at = |point: u32| points[point as usize];
    [at(a), at(b), at(c), at(d)]
}

/// Whether each point is a corner of a tetrahedron.
fn used_points(point_count: usize, tetrahedra: &[[u32; 4]]) -> Vec<bool> {
    let corners = tetrahedra.par_iter().flatten_iter();
    marked(point_count, corners.map(|&point| point as usize))
}

/// Those of `items` that are used: all for an empty `used`.
fn used_among<'a, T>(used: &'a [bool], items: &'a [T]) -> impl Iterator<Item = &'a T> {
    let numbered = items.iter().enumerate();
    let used = numbered.filter(|(number, _)| used.get(*number) != Some(&false));
    used.map(|(_, item)| item)
}

#[cfg(test)]
mod tests;
