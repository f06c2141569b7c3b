//! Pieces whose cells a file lists by type, or each with the number of its type, as XDMF and
//! CGNS do, or does not list as they lie on a lattice.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::{Association, volume_corners};

use super::{Budget, EachIndices, Faces, Piece, PieceArray};
use crate::fields::Numbers;
use crate::source::{format_error, room};

/// Whole numbers of a file that are not below 0.
pub(crate) trait Indices: Send + Sync {
    /// How many there are.
    fn count(&self) -> u64;

    /// Calls `each` with all of them, a part at a time.
    fn each_indices(&self, each: EachIndices) -> Result<(), Error>;
}

/// How cells of a type use the nodes that a file lists for each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// VTK's type.
    pub(crate) vtk: u8,
    /// How many the file lists.
    pub(crate) nodes: usize,
    /// Which of these are VTK's points, in VTK's order.
    pub(crate) order: &'static [usize],
}

/// The natural order.
const SAME: [usize; 27] = {
    let mut order = [0; 27];
    let mut i = 0;
    while i < order.len() {
        order[i] = i;
        i += 1;
    }
    order
};

impl Shape {
    /// With VTK's nodes in VTK's order.
    pub(crate) const fn same(vtk: u8, nodes: usize) -> Shape {
        Shape {
            vtk,
            nodes,
            order: SAME.split_at(nodes).0,
        }
    }

    pub(crate) fn is_volume(self) -> bool {
        volume_corners(self.vtk).is_some()
    }
}

/// The meaning of a type's number in a list of cells of several types.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Coded {
    Cell(Shape),
    /// A cell of a VTK type that begins with the number of its points.
    Counted(u8),
    /// Nodes that are passed over.
    #[cfg_attr(
        not(feature = "hdf5"),
        expect(dead_code, reason = "only CGNS files, which are HDF5, have them")
    )]
    PassedOver(usize),
}

/// Finds what a number stands for.
///
/// # Errors
/// Says what is not read.
pub(crate) type Code = fn(u64) -> Result<Coded, String>;

/// How cells are listed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Layout {
    /// All of one shape.
    Same(Shape),
    /// Each begins with a number of its type.
    Mixed(Code),
}

/// A list of cells in a file.
pub(crate) struct Section {
    pub(crate) path: PathBuf,
    /// Its name in errors.
    pub(crate) at: String,
    pub(crate) indices: Arc<dyn Indices>,
    pub(crate) layout: Layout,
    /// The number of the first node: 0, or 1.
    pub(crate) first: u64,
}

/// Takes the VTK type of a cell and its points.
type EachCell<'f> = &'f mut dyn FnMut(u8, &[u64]) -> Result<(), Error>;

impl Section {
    fn error(&self, what: String) -> Error {
        format_error(&self.path, &self.at, what)
    }

    /// How many cells it has.
    pub(crate) fn cells(&self) -> Result<u64, Error> {
        let Layout::Same(shape) = self.layout else {
            let mut cells = 0;
            self.each_cell(&mut |_, _| {
                cells += 1;
                Ok(())
            })?;
            return Ok(cells);
        };
        let (count, nodes) = (self.indices.count(), shape.nodes as u64);
        if !count.is_multiple_of(nodes) {
            return Err(self.error(format!(
                "{count} indices, and each cell has {nodes} of them"
            )));
        }
        Ok(count / nodes)
    }

    /// Calls `each` with every cell.
    fn each_cell(&self, each: EachCell) -> Result<(), Error> {
        enum Next {
            Type,
            Count(u8),
            Nodes(u8, Option<Shape>, u64),
            PassedOver(u64),
        }
        let begin = || match self.layout {
            Layout::Same(shape) => Next::Nodes(shape.vtk, Some(shape), shape.nodes as u64),
            Layout::Mixed(_) => Next::Type,
        };
        let mut next = begin();
        let (mut nodes, mut ordered) = (Vec::new(), Vec::new());
        let mut cell = 0_u64;
        let is_mixed = matches!(self.layout, Layout::Mixed(_));
        self.indices.each_indices(&mut |values| {
            for &value in values {
                next = match (&next, self.layout) {
                    (Next::Type, Layout::Mixed(code)) => {
                        let coded = code(value);
                        match coded.map_err(|what| self.error(format!("cell {cell} {what}")))? {
                            Coded::Cell(shape) => {
                                Next::Nodes(shape.vtk, Some(shape), shape.nodes as u64)
                            }
                            Coded::Counted(vtk) => Next::Count(vtk),
                            Coded::PassedOver(0) => Next::Type,
                            Coded::PassedOver(left) => Next::PassedOver(left as u64),
                        }
                    }
                    (Next::Count(_), _) if value == 0 => {
                        return Err(self.error(format!("cell {cell} has no points")));
                    }
                    (Next::Count(vtk), _) => Next::Nodes(*vtk, None, value),
                    (Next::PassedOver(1), _) | (Next::Type, _) => begin(),
                    (Next::PassedOver(left), _) => Next::PassedOver(left - 1),
                    (&Next::Nodes(vtk, shape, needed), _) => {
                        let node = value.checked_sub(self.first).ok_or_else(|| {
                            let first = self.first;
                            let what =
                                format!("cell {cell} uses node {value}, and the first is {first}");
                            self.error(what)
                        })?;
                        nodes.push(node);
                        if (nodes.len() as u64) < needed {
                            continue;
                        }
                        match shape {
                            None => each(vtk, &nodes)?,
                            Some(shape) => {
                                ordered.clear();
                                ordered.extend(shape.order.iter().map(|&place| nodes[place]));
                                each(vtk, &ordered)?;
                            }
                        }
                        nodes.clear();
                        cell += 1;
                        begin()
                    }
                };
            }
            Ok(())
        })?;
        let is_whole = match next {
            Next::Type => true,
            Next::Nodes(..) => nodes.is_empty() && !is_mixed,
            _ => false,
        };
        match is_whole {
            true => Ok(()),
            false => Err(self.error(format!("cell {cell} ends before its last point"))),
        }
    }
}

/// The cells of a piece.
pub(crate) enum Topology {
    Sections(Vec<Section>),
    /// Hexahedra between so many points along each axis.
    Lattice([u64; 3]),
    /// All are polyhedra.
    #[cfg_attr(
        not(feature = "hdf5"),
        expect(dead_code, reason = "only CGNS files, which are HDF5, have them")
    )]
    Polyhedra(Box<dyn Polyhedra>),
}

/// Polyhedra of a file.
pub(crate) trait Polyhedra: Send + Sync {
    /// Reads their faces.
    fn faces(&self, budget: &Budget) -> Result<Faces, Error>;
}

/// Where points lie.
pub(crate) enum Coordinates {
    /// x, y and z of each.
    Each(Arc<dyn Numbers>),
    /// All those of three axes, x the fastest.
    Axes([Vec<f64>; 3]),
}

/// An array of a [`Zone`].
pub(crate) struct ZoneArray {
    pub(crate) name: String,
    pub(crate) components: u64,
    pub(crate) component_names: Vec<Option<String>>,
    pub(crate) numbers: Arc<dyn Numbers>,
    /// The file marks it as the one to draw.
    pub(crate) active: bool,
}

/// A piece: its points, the cells that use them, and arrays at either.
pub(crate) struct Zone {
    pub(crate) path: PathBuf,
    pub(crate) name: String,
    pub(crate) points: u64,
    pub(crate) cells: u64,
    pub(crate) coordinates: Coordinates,
    pub(crate) topology: Topology,
    /// At points, and in cells.
    pub(crate) arrays: [Vec<ZoneArray>; 2],
}

/// How many points and cells a lattice has; `None` if they cannot be counted or there is no
/// volume.
pub(crate) fn lattice_counts(points: [u64; 3]) -> Option<(u64, u64)> {
    let product = |numbers: [u64; 3]| {
        let product = numbers.iter().try_fold(1_u64, |n, &d| n.checked_mul(d))?;
        i64::try_from(product).ok().map(|_| product)
    };
    let cells = product(points.map(|n| n.saturating_sub(1)))?;
    Some((product(points)?, cells)).filter(|_| cells > 0)
}

impl Zone {
    pub(crate) fn arrays_mut(&mut self, association: Association) -> &mut Vec<ZoneArray> {
        &mut self.arrays[usize::from(association == Association::Cell)]
    }

    fn of(&self, association: Association) -> &[ZoneArray] {
        &self.arrays[usize::from(association == Association::Cell)]
    }

    fn each_cell(&self, each: EachCell) -> Result<(), Error> {
        match &self.topology {
            Topology::Sections(sections) => sections
                .iter()
                .try_for_each(|section| section.each_cell(each)),
            Topology::Lattice(_) | Topology::Polyhedra(_) => Ok(()),
        }
    }
}

impl Piece for Zone {
    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn points(&self) -> u64 {
        self.points
    }

    fn cells(&self) -> u64 {
        self.cells
    }

    fn dimensions(&self) -> Option<[u64; 3]> {
        match self.topology {
            Topology::Lattice(points) => Some(points),
            _ => None,
        }
    }

    fn types(&self, each: EachIndices) -> Result<(), Error> {
        if let Topology::Polyhedra(_) = self.topology {
            // The caller has checked how many there are.
            return (0..self.cells).try_for_each(|_| each(&[crate::polyhedra::POLYHEDRON.into()]));
        }
        self.each_cell(&mut |vtk, _| each(&[vtk.into()]))
    }

    fn ends(&self) -> Result<Vec<u64>, Error> {
        // The caller has checked how many there are.
        let mut ends: Vec<u64> = room(self.cells as usize)?;
        if let Topology::Polyhedra(_) = self.topology {
            ends.resize(self.cells as usize, 0);
        }
        let mut end = 0;
        self.each_cell(&mut |_, points| {
            end += points.len() as u64;
            ends.push(end);
            Ok(())
        })?;
        Ok(ends)
    }

    fn connectivity(&self, _: u64, each: EachIndices) -> Result<(), Error> {
        self.each_cell(&mut |_, points| each(points))
    }

    fn faces(&self, budget: &Budget, _: &[u8]) -> Result<Faces, Error> {
        match &self.topology {
            Topology::Polyhedra(polyhedra) => polyhedra.faces(budget),
            _ => Err(self.error("the cells", "polyhedra without faces".into())),
        }
    }

    fn each_coordinate(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        match &self.coordinates {
            Coordinates::Each(numbers) => numbers.each(each),
            Coordinates::Axes(axes) => {
                crate::vtu::structured::each_point(axes, each);
                Ok(())
            }
        }
    }

    fn arrays(&self, association: Association) -> Vec<PieceArray<'_>> {
        let arrays = self.of(association).iter().map(|array| PieceArray {
            name: &array.name,
            components: array.components,
            component_names: &array.component_names,
            active: array.active,
            colors: false,
        });
        arrays.collect()
    }

    fn numbers(&self, association: Association, array: usize) -> Arc<dyn Numbers> {
        self.of(association)[array].numbers.clone()
    }

    fn error(&self, at: &str, what: String) -> Error {
        zone_error(&self.path, &self.name, at, what)
    }
}

/// An error about a place of a zone.
pub(crate) fn zone_error(path: &Path, name: &str, at: &str, what: String) -> Error {
    format_error(path, format!("'{name}', {at}"), what)
}
