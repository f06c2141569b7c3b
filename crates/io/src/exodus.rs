//! Exodus II meshes, `.e`, `.exo`, `.ex2`, in netCDF classic files, which are CDF-1, CDF-2 and
//! CDF-5, and in HDF5 files, which netCDF-4 writes.
//!
//! L. A. Schoof and V. R. Yarberry, *EXODUS II: A Finite Element Data Model*, 1994. Blocks of
//! tetrahedra, hexahedra, wedges and pyramids of order 1 and 2 are read, with their nodes in
//! VTK's order; other blocks are left out, with a note. Element variables are NaN where
//! the file has none for a block, by its truth table or for want of values. Of several time
//! steps the first is read, or that of [`ReadOptions::step`](crate::ReadOptions::step). Three
//! variables that follow each other and end in X, Y and Z are a vector. Where there are several
//! blocks, `block id` is a cell field.

mod file;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error, glam};

use self::file::File;
use crate::MeshData;
use crate::fields::{Array, Numbers, Runs, vectors};
use crate::grid::payload::most_unpacked;
use crate::read::check;
use crate::source::{Source, count, reserve, room};
use crate::steps::{StepChoice, choose, note};

/// Blocks times variables: each takes a look for its values.
const MOST_PAIRS: u64 = 1 << 20;

/// Time steps that are read.
const MOST_STEPS: u64 = 1 << 20;

/// Reads an Exodus file in netCDF's classic format.
pub(crate) fn read(source: Source, choice: Option<StepChoice>) -> Result<MeshData, Error> {
    read_mesh(File::classic(source)?, choice)
}

/// Reads an Exodus file in HDF5.
#[cfg(feature = "hdf5")]
pub(crate) fn read_hdf5(
    root: &crate::hdf5::Group,
    choice: Option<StepChoice>,
) -> Result<MeshData, Error> {
    read_mesh(File::hdf5(root)?, choice)
}

/// The times of the steps of a file in netCDF's classic format.
pub(crate) fn steps(source: Source) -> Result<Vec<f64>, Error> {
    times(&File::classic(source)?)
}

/// The times of the steps of a file in HDF5.
#[cfg(feature = "hdf5")]
pub(crate) fn hdf5_steps(root: &crate::hdf5::Group) -> Result<Vec<f64>, Error> {
    times(&File::hdf5(root)?)
}

/// Whether an HDF5 file with these datasets is Exodus.
#[cfg(feature = "hdf5")]
pub(crate) fn is_exodus(datasets: &[String]) -> bool {
    let names = ["coord", "coordx", "num_el_blk"];
    datasets.iter().any(|name| names.contains(&name.as_str()))
}

fn times(file: &File) -> Result<Vec<f64>, Error> {
    match file.variable("time_whole") {
        Some(variable) if variable.shape[0] > MOST_STEPS => {
            let what = format!("{} steps; up to {MOST_STEPS} are read", variable.shape[0]);
            Err(file.error("variable 'time_whole'", what))
        }
        Some(_) => file.floats("time_whole", &[]),
        None => Ok(Vec::new()),
    }
}

fn read_mesh(file: File, choice: Option<StepChoice>) -> Result<MeshData, Error> {
    let file = Arc::new(file);
    let times = times(&file)?;
    let step = choose(&file.path, choice, &times)?.unwrap_or(0);
    let mut data = MeshData {
        points: points(&file)?,
        ..MeshData::default()
    };
    let blocks: Arc<[Block]> = blocks(&file, &mut data)?.into();
    if data.cells.types.is_empty() {
        return Err(file.error("the element blocks", "the file has no volumes"));
    }
    data.notes.extend(note(&times, step));
    let mut arrays = Vec::new();
    for association in [Association::Point, Association::Cell] {
        for (name, variables) in vectors(&names(&file, association)?) {
            let values = Values {
                step: step as u64,
                file: file.clone(),
                blocks: blocks.clone(),
                association,
                points: data.points.len(),
                variables,
            };
            arrays.extend(values.array(name, &mut data)?);
        }
    }
    if blocks.len() > 1 {
        let mut end = 0;
        let runs = blocks.iter().map(|block| {
            end += block.cells;
            (end, block.id)
        });
        let runs = Arc::new(Runs(runs.collect()));
        let cells = data.cells.types.len();
        arrays.push(Array::scalar("block id", Association::Cell, cells, runs));
    }
    check(&file.path, &data, &arrays)?;
    let numbers = arrays.iter().map(|a| a.tuples as u64 * a.components as u64);
    let bytes = numbers.fold(0_u64, |bytes, n| bytes.saturating_add(8 * n));
    if bytes > most_unpacked(file.length) {
        let what = format!(
            "{bytes} bytes are packed in {}, which is refused",
            file.length
        );
        return Err(file.error("the variables", what));
    }
    data.add_fields(arrays)?;
    Ok(data)
}

fn points(file: &File) -> Result<Vec<DVec3>, Error> {
    let [x, y, z] = if file.variable("coord").is_some() {
        let axis = |place| file.floats("coord", &[place]);
        [axis(0)?, axis(1)?, axis(2)?]
    } else if file.variable("coordx").is_some() {
        let axis = |name| file.floats(name, &[]);
        [axis("coordx")?, axis("coordy")?, axis("coordz")?]
    } else {
        return Err(file.error(
            "variable 'coordx'",
            "the netCDF file is not an Exodus mesh: it has no coordinates of nodes",
        ));
    };
    if x.len() != y.len() || x.len() != z.len() {
        let [x, y, z] = [x.len(), y.len(), z.len()];
        return Err(file.error(
            "the coordinates",
            format!("{x} of x, {y} of y and {z} of z"),
        ));
    }
    let mut points = room(x.len())?;
    let places = x.into_iter().zip(y).zip(z);
    points.extend(places.map(|((x, y), z)| DVec3::new(x, y, z)));
    Ok(points)
}

/// A block of volumes.
struct Block {
    /// From 1, as in names of variables.
    number: u64,
    id: f64,
    cells: u64,
    /// The variables that the truth table says it does not have, by number.
    absent: Vec<u64>,
}

/// `elem_var_tab`: whether each block has values of each variable.
struct Truth {
    marks: Vec<f64>,
    variables: usize,
}

impl Truth {
    /// The table of a file of so many blocks, if it has one.
    fn of(file: &File, blocks: u64) -> Result<Truth, Error> {
        let none = Truth {
            marks: Vec::new(),
            variables: 1,
        };
        let Some(table) = file.variable("elem_var_tab") else {
            return Ok(none);
        };
        match table.shape[..] {
            [rows, variables] if rows == blocks && variables > 0 => {
                let pairs = rows.saturating_mul(variables);
                if pairs > MOST_PAIRS {
                    let what = format!("{pairs} pairs; up to {MOST_PAIRS} are read");
                    return Err(file.error("variable 'elem_var_tab'", what));
                }
                Ok(Truth {
                    marks: file.floats("elem_var_tab", &[])?,
                    variables: variables as usize,
                })
            }
            _ => Ok(none),
        }
    }

    /// The numbers of the variables that block `number` does not have.
    fn absent(&self, number: u64) -> Vec<u64> {
        let mut rows = self.marks.chunks_exact(self.variables);
        let row = rows.nth(number as usize - 1).unwrap_or_default();
        let marks = row.iter().zip(1..).filter(|(mark, _)| **mark == 0.0);
        marks.map(|(_, variable)| variable).collect()
    }
}

/// A cell type: its VTK number and, for each of its points, which of a block's nodes it is.
type Shape = (u8, &'static [usize]);

/// Edges around the base, then those that rise, then those of the top; VTK has these last two
/// the other way round. Faces: middle, z, x and y; VTK has x, y, z and the middle.
const HEXAHEDRON: [usize; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, // corners
    8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15, // edges
    23, 24, 25, 26, 21, 22, 20, // faces and the middle
];
/// As of hexahedra.
const WEDGE: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11];
/// Tetrahedra and pyramids have VTK's order.
const SAME: [usize; 13] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];

/// The shape of a type with so many nodes, `None` for what is not a volume. Further nodes,
/// of faces and middles, are passed over.
fn shape(kind: &str, nodes: usize) -> Option<Shape> {
    let kind = kind.to_ascii_uppercase();
    let shapes: [Shape; 3] = match () {
        () if kind.starts_with("TET") => {
            let linear = (10, &SAME[..4]);
            [linear, linear, (24, &SAME[..10])]
        }
        () if kind.starts_with("HEX") => [
            (12, &HEXAHEDRON[..8]),
            (25, &HEXAHEDRON[..20]),
            (29, &HEXAHEDRON[..]),
        ],
        () if kind.starts_with("WED") => {
            let linear = (13, &WEDGE[..6]);
            [linear, linear, (26, &WEDGE[..])]
        }
        () if kind.starts_with("PYR") => {
            let linear = (14, &SAME[..5]);
            [linear, linear, (27, &SAME[..])]
        }
        () => return None,
    };
    let fits = |(_, order): &Shape| order.len() <= nodes;
    shapes.into_iter().rev().find(fits)
}

/// Whether elements of a type fill space.
fn is_volume(kind: &str) -> bool {
    let kind = kind.to_ascii_uppercase();
    let volumes = ["TET", "HEX", "WED", "PYR", "NFACED"];
    volumes.iter().any(|name| kind.starts_with(name))
}

/// Adds the cells of all blocks of volumes.
fn blocks(file: &File, data: &mut MeshData) -> Result<Vec<Block>, Error> {
    let number = file.dimension("num_el_blk");
    if number > MOST_PAIRS {
        let what = format!("{number} blocks; up to {MOST_PAIRS} are read");
        return Err(file.error("dimension 'num_el_blk'", what));
    }
    let ids = match file.variable("eb_prop1") {
        Some(_) => file.floats("eb_prop1", &[])?,
        None => Vec::new(),
    };
    let truth = Truth::of(file, number)?;
    let (mut blocks, mut skipped) = (Vec::new(), BTreeMap::<String, u64>::new());
    let mut bytes = 0_u64;
    data.cells.offsets.push(0);
    for number in 1..=number {
        // A block without elements has no variable.
        let name = format!("connect{number}");
        let Some(variable) = file.variable(&name) else {
            continue;
        };
        let &[elements, nodes] = &variable.shape[..] else {
            continue;
        };
        let at = || format!("variable '{name}'");
        let kind = variable.element_type.as_str();
        let Some((vtk, order)) = shape(kind, nodes as usize) else {
            if is_volume(kind) {
                return Err(file.error(at(), format!("{kind} of {nodes} nodes are not read")));
            }
            *skipped.entry(kind.chars().take(40).collect()).or_default() += elements;
            continue;
        };
        // Blocks that lie at one place in the file would make more of it than there is.
        bytes = bytes.saturating_add(4 * elements.saturating_mul(nodes));
        if bytes > file.most_bytes {
            return Err(file.error(at(), "the blocks overlap in the file"));
        }
        let connectivity = file.floats(&name, &[])?;
        add_cells(
            file,
            &name,
            &connectivity,
            nodes as usize,
            (vtk, order),
            data,
        )?;
        blocks.push(Block {
            number,
            absent: truth.absent(number),
            id: ids
                .get(number as usize - 1)
                .copied()
                .unwrap_or(number as f64),
            cells: elements,
        });
    }
    if !skipped.is_empty() {
        let list = skipped.iter().map(|(kind, number)| match kind.as_str() {
            "" => count(*number, "element"),
            kind => format!("{number} {kind}"),
        });
        let list = list.collect::<Vec<_>>().join(", ");
        data.notes
            .push(format!("{list} left out: only volumes are drawn"));
    }
    Ok(blocks)
}

/// Adds cells of `nodes` nodes each, which are numbered from 1.
fn add_cells(
    file: &File,
    name: &str,
    connectivity: &[f64],
    nodes: usize,
    (vtk, order): Shape,
    data: &mut MeshData,
) -> Result<(), Error> {
    let points = data.points.len();
    let Cells {
        types,
        offsets,
        connectivity: indices,
    } = &mut data.cells;
    let elements = connectivity.len() / nodes;
    reserve(types, elements)?;
    reserve(offsets, elements)?;
    reserve(indices, elements * order.len())?;
    for (element, used) in connectivity.chunks_exact(nodes).enumerate() {
        for &place in order {
            let node = used[place];
            // Whole numbers up to 2^53 are exact.
            if !(node >= 1.0 && node <= points as f64) {
                return Err(file.error(
                    format!("variable '{name}'"),
                    format!("element {} uses node {node} of {points}", element + 1),
                ));
            }
            indices.push(node as u64 - 1);
        }
        types.push(vtk);
        offsets.push(indices.len() as u64);
    }
    Ok(())
}

/// The names of variables at nodes or of elements, with their numbers from 1.
fn names(file: &File, association: Association) -> Result<Vec<(String, u64)>, Error> {
    let list = match association {
        Association::Point => "name_nod_var",
        Association::Cell => "name_elem_var",
    };
    let blocks = file.dimension("num_el_blk").max(1);
    let Some(variable) = file.variable(list) else {
        return Ok(Vec::new());
    };
    let variables = variable.shape[0];
    if variables.saturating_mul(blocks) > MOST_PAIRS {
        return Err(file.error(
            format!("variable '{list}'"),
            format!("{variables} variables of {blocks} blocks; up to {MOST_PAIRS} pairs are read"),
        ));
    }
    let texts = file.texts(list)?;
    let named = texts.into_iter().zip(1..).map(|(text, number)| {
        let text = text.trim_matches(['\0', ' ']);
        match text {
            "" => (format!("variable {number}"), number),
            text => (text.to_owned(), number),
        }
    });
    Ok(named.collect())
}

/// The values of a field in the file at a time step.
struct Values {
    step: u64,
    file: Arc<File>,
    blocks: Arc<[Block]>,
    association: Association,
    points: usize,
    /// The number of each component.
    variables: Vec<u64>,
}

impl Values {
    /// The field, if the file has values of it; others get a note.
    fn array(self, name: String, data: &mut MeshData) -> Result<Option<Array>, Error> {
        let has_any = match self.association {
            Association::Point => self.variables.iter().all(|&v| self.nodal(v).is_some()),
            Association::Cell => {
                let of_block =
                    |b: &Block| self.variables.iter().any(|&v| self.element(v, b).is_some());
                self.blocks.iter().any(of_block)
            }
        };
        if !has_any {
            let why = "the file has no values of it for volumes";
            data.notes.push(format!("field '{name}' left out: {why}"));
            data.left_out.push((name, why.into()));
            return Ok(None);
        }
        let tuples = match self.association {
            Association::Point => self.points,
            Association::Cell => data.cells.types.len(),
        };
        let components = self.variables.len();
        let mut array = Array::scalar(&name, self.association, tuples, Arc::new(self));
        array.components = components;
        if components == 3 {
            array.component_names = ["x", "y", "z"].map(|name| Some(name.to_owned())).into();
        }
        Ok(Some(array))
    }

    /// Where the values of a nodal variable are: a variable for each, or one for all.
    fn nodal(&self, variable: u64) -> Option<(String, Vec<u64>)> {
        let own = format!("vals_nod_var{variable}");
        let (name, places) = match self.file.variable(&own) {
            Some(_) => (own, vec![self.step]),
            None => ("vals_nod_var".to_owned(), vec![self.step, variable - 1]),
        };
        self.has(&name, &places).then_some((name, places))
    }

    fn element(&self, variable: u64, block: &Block) -> Option<(String, Vec<u64>)> {
        let name = format!("vals_elem_var{variable}eb{}", block.number);
        let places = vec![self.step];
        let is_there = !block.absent.contains(&variable) && self.has(&name, &places);
        is_there.then_some((name, places))
    }

    /// Whether a variable has these places; one without time steps has none.
    fn has(&self, name: &str, places: &[u64]) -> bool {
        let variable = self.file.variable(name);
        variable.is_some_and(|v| {
            v.shape.len() == places.len() + 1 && places.iter().zip(&v.shape).all(|(at, n)| at < n)
        })
    }

    /// Calls `each` with so many tuples, of which a component may be absent.
    fn tuples(
        &self,
        tuples: u64,
        places: &[Option<(String, Vec<u64>)>],
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        let mut components = Vec::new();
        for place in places {
            let Some((name, places)) = place else {
                components.push(Vec::new());
                continue;
            };
            let values = self.file.floats(name, places)?;
            if values.len() as u64 != tuples {
                return Err(self.file.error(
                    format!("variable '{name}'"),
                    format!("{} values where {tuples} are needed", values.len()),
                ));
            }
            components.push(values);
        }
        for tuple in 0..tuples as usize {
            for values in &components {
                each(values.get(tuple).copied().unwrap_or(f64::NAN));
            }
        }
        Ok(())
    }
}

impl fmt::Debug for Values {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let path = self.file.path.display();
        write!(formatter, "variables {:?} of {path}", self.variables)
    }
}

impl Numbers for Values {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let variables = self.variables.iter();
        match self.association {
            Association::Point => {
                let places: Vec<_> = variables.map(|&v| self.nodal(v)).collect();
                self.tuples(self.points as u64, &places, each)
            }
            Association::Cell => {
                for block in &*self.blocks {
                    let places: Vec<_> = self
                        .variables
                        .iter()
                        .map(|&v| self.element(v, block))
                        .collect();
                    self.tuples(block.cells, &places, each)?;
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests;
