//! Gmsh meshes, `.msh`: versions 2 and 4.1, text and binary in both byte orders.
//!
//! *Gmsh Reference Manual*, "Gmsh file formats". Volumes of order 1 and 2, and tetrahedra and hexahedra to order 6, become VTK's cells
//! with their nodes in VTK's order; of others the corners are taken. Points, lines and
//! surfaces are left out, with a note. Nodes and elements may have any tags.
//!
//! `$NodeData` and `$ElementData` of one name are one field; of several time steps the first
//! is read, or that of [`ReadOptions::step`](crate::ReadOptions::step). What has no value is NaN. `$ElementNodeData` is left out, with a note. The first
//! physical group of each element is the cell field `physical id`, where there is more than
//! one.
//!
//! Version 2 repeats an element for each of its physical groups: it becomes one cell.

mod cells;
mod cursor;
mod elements;
mod nodes;
mod orders;
mod tags;
mod views;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, glam};

use self::cells::Elements;
use self::cursor::{Cursor, Encoding, clip};
use self::tags::Tags;
use self::views::View;
use crate::MeshData;
use crate::fields::{Array, Runs};
use crate::read::check;
use crate::source::{Endian, Source, count};
use crate::steps::{StepChoice, choose, note};

/// Help with files of other versions.
const CONVERT: &str = "convert it: gmsh old.msh -save -format msh41 -o new.msh";

/// Fields that a file may have: each takes time for every point or cell.
const MOST_FIELDS: usize = 4096;

/// Whether a file begins as one of Gmsh does: with its format or, before it, with comments.
pub(crate) fn is_gmsh(head: &[u8]) -> bool {
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    let head_of_old = [b"$NOD".as_slice(), b"$PTS"];
    head.starts_with(b"$MeshFormat")
        || head_of_old.iter().any(|word| head.starts_with(word))
        || (head.starts_with(b"$Comments") && (has(b"$MeshFormat") || has(b"$NOD")))
}

/// Reads a `.msh` file.
pub(crate) fn read(source: Source, choice: Option<StepChoice>) -> Result<MeshData, Error> {
    let source = Arc::new(source);
    let mut reader = Reader::new(&source, Scope::All);
    reader.sections()?;
    let steps = &reader.steps;
    let times: Vec<f64> = steps.values().copied().collect();
    let chosen = choose(&source.path, choice, &times)?;
    // Without a choice each field has its own first step.
    let chosen = choice.and(chosen);
    let step = chosen.and_then(|number| steps.keys().copied().nth(number));
    let note = chosen.and_then(|number| note(&times, number));
    let mut data = reader.mesh(&source, step)?;
    data.notes.extend(note);
    Ok(data)
}

/// The times of the steps that the fields of a `.msh` file have.
pub(crate) fn steps(source: Source) -> Result<Vec<f64>, Error> {
    let mut reader = Reader::new(&source, Scope::Steps);
    reader.sections()?;
    Ok(reader.steps.into_values().collect())
}

/// The parts of a file that are read.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    All,
    /// The time steps alone.
    Steps,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source, scope: Scope) -> Reader<'a> {
        Reader {
            scope,
            cursor: Cursor::new(source),
            version: None,
            node_tags: Vec::new(),
            points: Vec::new(),
            elements: Elements::default(),
            physical: HashMap::new(),
            names: HashMap::new(),
            views: Vec::new(),
            steps: BTreeMap::new(),
            left_out: Vec::new(),
        }
    }

    /// Reads all sections.
    fn sections(&mut self) -> Result<(), Error> {
        if self.cursor.rest().starts_with(b"\xef\xbb\xbf") {
            self.cursor.at = 3;
        }
        while let Some(line) = self.cursor.full_line() {
            let name = std::str::from_utf8(line).ok();
            let Some(name) = name.and_then(|line| line.strip_prefix('$')) else {
                let line = String::from_utf8_lossy(line);
                return Err(self.cursor.truncated(format!(
                    "'{}' where a section such as $Nodes is to begin",
                    clip(&line)
                )));
            };
            self.section(name)?;
        }
        Ok(())
    }
}

/// Reads a file section by section, and holds what it has read.
struct Reader<'a> {
    scope: Scope,
    cursor: Cursor<'a>,
    version: Option<Version>,
    node_tags: Vec<u64>,
    points: Vec<DVec3>,
    elements: Elements,
    /// The first physical group of each volume, by its tag, from version 4.
    physical: HashMap<i64, i64>,
    /// The place of each of `views` there, by whether it is of cells.
    names: HashMap<(bool, String, usize), usize>,
    views: Vec<View>,
    /// The time of each step that a field has.
    steps: BTreeMap<i64, f64>,
    left_out: Vec<(String, String)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Version {
    V2,
    V41,
}

impl Reader<'_> {
    fn section(&mut self, name: &str) -> Result<(), Error> {
        match name {
            "MeshFormat" => self.format()?,
            "Nodes" | "Elements" | "Entities" if self.scope == Scope::Steps => {
                self.find_end(name)?;
            }
            "NOD" | "NOE" | "PTS" | "ELM" => {
                return Err(self.cursor.error_with_help(
                    "this is a Gmsh mesh of version 1; 2 and 4.1 are read",
                    CONVERT,
                ));
            }
            "Nodes" => match self.version("Nodes")? {
                Version::V2 => self.nodes_2()?,
                Version::V41 => self.nodes_4()?,
            },
            "ParametricNodes" => {
                return Err(self.cursor.error_with_help(
                    "nodes with parameters of surfaces are not read in version 2",
                    CONVERT,
                ));
            }
            "Elements" => match self.version("Elements")? {
                Version::V2 => self.elements_2()?,
                Version::V41 => self.elements_4()?,
            },
            "Entities" if self.version == Some(Version::V41) => self.entities()?,
            "NodeData" => self.view(Association::Point)?,
            "ElementData" => self.view(Association::Cell)?,
            "ElementNodeData" => self.element_node_data()?,
            _ => self.find_end(name)?,
        }
        let end = self.cursor.full_line();
        let is_end = |line: &[u8]| line.strip_prefix(b"$End") == Some(name.as_bytes());
        match end {
            Some(line) if is_end(line) => Ok(()),
            Some(line) => {
                let line = String::from_utf8_lossy(line);
                let found = clip(&line);
                Err(self
                    .cursor
                    .error(format!("'{found}' where $End{} is needed", clip(name))))
            }
            None => Err(self.ends_within(name)),
        }
    }

    /// Moves to the line that ends a section.
    fn find_end(&mut self, name: &str) -> Result<(), Error> {
        let end = format!("$End{name}");
        let mut windows = self.cursor.rest().windows(end.len());
        let is_end = |window: &[u8]| window[0] == b'$' && window == end.as_bytes();
        let at = windows.position(is_end);
        self.cursor.at += at.ok_or_else(|| self.ends_within(name))?;
        Ok(())
    }

    fn ends_within(&self, name: &str) -> Error {
        self.cursor
            .truncated(format!("the file ends before $End{}", clip(name)))
    }

    fn version(&self, section: &str) -> Result<Version, Error> {
        self.version.ok_or_else(|| {
            self.cursor
                .error(format!("${section} comes before $MeshFormat"))
        })
    }

    fn format(&mut self) -> Result<(), Error> {
        const LINE: &str = "a version, a file type and a size of data";
        let line = self.cursor.text_line(LINE)?;
        let mut words = line.split_ascii_whitespace();
        let (version, kind, size) = (words.next(), words.next(), words.next());
        let wrong = || {
            self.cursor
                .error(format!("'{}' where {LINE} are needed", clip(line)))
        };
        let version = version.ok_or_else(wrong)?;
        let number: f64 = version.parse().map_err(|_| wrong())?;
        let found = match number {
            2.0..3.0 => Version::V2,
            4.1 => Version::V41,
            _ => {
                return Err(self.cursor.error_with_help(
                    format!(
                        "this is a Gmsh mesh of version {}; 2 and 4.1 are read",
                        clip(version)
                    ),
                    CONVERT,
                ));
            }
        };
        self.version = Some(found);
        match kind {
            Some("0") => return Ok(()),
            Some("1") => {}
            _ => return Err(wrong()),
        }
        let size = match (found, size) {
            (Version::V41, Some("4")) => 4,
            (_, Some("8")) => 8,
            _ => return Err(wrong()),
        };
        let one = self.cursor.rest().get(..4).unwrap_or_default();
        let endian = match one {
            [1, 0, 0, 0] => Endian::Little,
            [0, 0, 0, 1] => Endian::Big,
            _ => {
                return Err(self.cursor.truncated(
                    "the 1 that tells the byte order of a binary file is in neither order",
                ));
            }
        };
        self.cursor.at += 4;
        self.cursor.encoding = Encoding::Binary { endian, size };
        Ok(())
    }

    /// The mesh, with the fields of a time step or, without one, of the first of each.
    fn mesh(self, source: &Arc<Source>, step: Option<i64>) -> Result<MeshData, Error> {
        let Reader {
            cursor,
            node_tags,
            points,
            mut elements,
            views,
            left_out,
            ..
        } = self;
        if points.is_empty() {
            return Err(cursor.truncated("the file has no nodes"));
        }
        let skipped = list(&elements.skipped);
        if elements.cells.types.is_empty() {
            let what = match skipped.as_str() {
                "" => "the file has no elements".into(),
                skipped => format!("the file has no volumes, but {skipped}"),
            };
            return Err(cursor.error_with_help(what, "mesh it in 3 dimensions: gmsh -3 model.geo"));
        }
        let (nodes, repeated) = Tags::new(&node_tags)?;
        if let Some(tag) = repeated {
            return Err(source.error("$Nodes", format!("two nodes have the number {tag}")));
        }
        elements.number_nodes(source, &nodes)?;
        let mut data = MeshData {
            points,
            cells: elements.cells,
            left_out,
            ..MeshData::default()
        };
        if !skipped.is_empty() {
            data.notes
                .push(format!("{skipped} left out: only volumes are drawn"));
        }
        for (number, why) in [
            (
                elements.straightened,
                "of order 3 or more: drawn straight, by its corners",
            ),
            (
                elements.repeated,
                "left out: it is the one before it, in another physical group",
            ),
        ] {
            if number > 0 {
                let elements = count(number, "element");
                data.notes.push(format!("{elements} {why}"));
            }
        }
        for (name, why) in &data.left_out {
            data.notes.push(format!("field '{name}' left out: {why}"));
        }
        let node_tags: Arc<[u64]> = node_tags.into();
        let element_tags: Arc<[u64]> = elements.tags.into();
        let mut arrays = Vec::new();
        for view in views {
            let tags = match view.association {
                Association::Point => &node_tags,
                Association::Cell => &element_tags,
            };
            arrays.extend(view.array(source, cursor.encoding, (tags, step), &mut data)?);
        }
        if elements
            .groups
            .iter()
            .any(|run| run.1 != elements.groups[0].1)
        {
            let groups = Arc::new(Runs(elements.groups));
            let cells = data.cells.types.len();
            arrays.push(Array::scalar(
                "physical id",
                Association::Cell,
                cells,
                groups,
            ));
        }
        check(&source.path, &data, &arrays)?;
        data.add_fields(arrays)?;
        Ok(data)
    }
}

/// "4 lines, 12 triangles".
fn list(counts: &BTreeMap<&str, u64>) -> String {
    let counts = counts.iter().map(|(name, number)| count(*number, name));
    counts.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
