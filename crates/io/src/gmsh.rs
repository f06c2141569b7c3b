//! Gmsh meshes, `.msh`: versions 2 and 4.1, text and binary in both byte orders.
//!
//! *Gmsh Reference Manual*, "Gmsh file formats". Volumes of order 1 and 2 become VTK's cells
//! with their nodes in VTK's order; of higher orders the corners are taken. Points, lines and
//! surfaces are left out, with a note. Nodes and elements may have any tags.
//!
//! `$NodeData` and `$ElementData` of one name are one field; of several time steps the first
//! is read, or that of [`ReadOptions::step`](crate::ReadOptions::step). What has no value is NaN. `$ElementNodeData` is left out, with a note. The first
//! physical group of each element is the cell field `physical id`, where there is more than
//! one.
//!
//! Version 2 repeats an element for each of its physical groups: it becomes one cell.

mod cursor;
mod elements;
mod tags;

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error, glam};

use self::cursor::{Cursor, Encoding, Number, clip};
use self::elements::{Cell, Element, element};
use self::tags::Tags;
use crate::fields::{Array, MOST_COMPONENTS, Numbers, Runs};
use crate::read::check;
use crate::source::{Endian, Source, count, reserve};
use crate::steps::{StepChoice, choose, note};
use crate::{MeshData, parse_float};

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

/// What is read of a file.
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

#[derive(Default)]
struct Elements {
    tags: Vec<u64>,
    /// The connectivity is the tags of nodes until all are read.
    cells: Cells,
    /// The physical group of each cell, for cells that follow each other up to the number.
    groups: Vec<(u64, f64)>,
    /// Elements that are not volumes, by name.
    skipped: BTreeMap<&'static str, u64>,
    straightened: u64,
    repeated: u64,
}

/// A field of one name.
struct View {
    association: Association,
    name: String,
    components: usize,
    /// The time step that comes first.
    first: i64,
    /// Where the values of each step's sections begin, and for how many nodes or elements.
    steps: BTreeMap<i64, Vec<(usize, u64)>>,
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

    fn begin_nodes(&mut self) -> Result<(), Error> {
        if !self.points.is_empty() {
            return Err(self.cursor.error("a second section $Nodes"));
        }
        Ok(())
    }

    fn position(&mut self) -> Result<DVec3, Error> {
        let cursor = &mut self.cursor;
        let mut next = || cursor.double("a node's coordinate");
        Ok(DVec3::new(next()?, next()?, next()?))
    }

    fn nodes_2(&mut self) -> Result<(), Error> {
        self.begin_nodes()?;
        let nodes: u64 = self.cursor.number_line("a number of nodes")?;
        let encoding = self.cursor.encoding;
        let bytes = encoding.least_bytes(Number::Int) + 3 * encoding.least_bytes(Number::Double);
        let nodes = self.cursor.fits(nodes, bytes, "nodes")?;
        reserve(&mut self.node_tags, nodes)?;
        reserve(&mut self.points, nodes)?;
        for _ in 0..nodes {
            let tag = self.cursor.unsigned("a node's number")?;
            self.node_tags.push(tag);
            let position = self.position()?;
            self.points.push(position);
        }
        Ok(())
    }

    fn nodes_4(&mut self) -> Result<(), Error> {
        self.begin_nodes()?;
        let encoding = self.cursor.encoding;
        let blocks = self.cursor.size("a number of blocks of nodes")?;
        let total = self.cursor.size("a number of nodes")?;
        for _ in 0..2 {
            self.cursor.size("a node's tag")?;
        }
        for _ in 0..blocks {
            let dimension = self.cursor.int("a dimension")?;
            self.cursor.int("an entity's tag")?;
            let is_parametric = match self.cursor.int("0 or 1 for parameters")? {
                0 => false,
                1 => true,
                other => {
                    return Err(self
                        .cursor
                        .error(format!("{other} where 0 or 1 for parameters is needed")));
                }
            };
            let nodes = self.cursor.size("a number of nodes")?;
            let parameters = match dimension {
                0..=3 if is_parametric => dimension,
                0..=3 => 0,
                _ => {
                    return Err(self
                        .cursor
                        .error(format!("an entity of dimension {dimension}")));
                }
            };
            let bytes =
                encoding.least_bytes(Number::Size) + 3 * encoding.least_bytes(Number::Double);
            let nodes = self.cursor.fits(nodes, bytes, "nodes")?;
            reserve(&mut self.node_tags, nodes)?;
            reserve(&mut self.points, nodes)?;
            for _ in 0..nodes {
                let tag = self.cursor.size("a node's tag")?;
                self.node_tags.push(tag);
            }
            for _ in 0..nodes {
                let position = self.position()?;
                self.points.push(position);
                for _ in 0..parameters {
                    self.cursor.double("a node's parameter")?;
                }
            }
        }
        let found = self.points.len() as u64;
        if found != total {
            return Err(self.cursor.error(format!(
                "the blocks of $Nodes hold {found} nodes where {total} are announced"
            )));
        }
        Ok(())
    }

    fn element_of(&self, kind: i64) -> Result<Element, Error> {
        element(kind).ok_or_else(|| {
            let name = match kind {
                34 => " (polygon)",
                35 => " (polyhedron)",
                _ => "",
            };
            self.cursor
                .error(format!("elements of type {kind}{name} are not read"))
        })
    }

    fn elements_2(&mut self) -> Result<(), Error> {
        let total: u64 = self.cursor.number_line("a number of elements")?;
        let mut left = total;
        while left > 0 {
            // A binary file gives type and tags once for elements that follow each other.
            let (number, kind, in_block, tags);
            match self.cursor.encoding {
                Encoding::Text => {
                    number = Some(self.cursor.unsigned("an element's number")?);
                    kind = self.cursor.int("an element's type")?;
                    in_block = 1;
                    tags = self.cursor.unsigned("a number of tags")?;
                }
                Encoding::Binary { .. } => {
                    number = None;
                    kind = self.cursor.int("an element's type")?;
                    in_block = self.cursor.unsigned("a number of elements")?;
                    tags = self.cursor.unsigned("a number of tags")?;
                }
            }
            if in_block == 0 || in_block > left {
                return Err(self.cursor.error(format!(
                    "a block of {in_block} elements where {left} of {total} are left"
                )));
            }
            left -= in_block;
            let element = self.element_of(kind)?;
            for _ in 0..in_block {
                let number = match number {
                    Some(number) => number,
                    None => self.cursor.unsigned("an element's number")?,
                };
                let mut group = 0;
                for i in 0..tags {
                    let tag = self.cursor.int("an element's tag")?;
                    if i == 0 {
                        group = tag;
                    }
                }
                let cursor = &mut self.cursor;
                let mut node = || cursor.unsigned("a node's number");
                let is_new = self.elements.add(number, element, &mut node)?;
                if is_new {
                    self.elements.group(group);
                }
            }
        }
        Ok(())
    }

    fn elements_4(&mut self) -> Result<(), Error> {
        let least = self.cursor.encoding.least_bytes(Number::Size);
        let blocks = self.cursor.size("a number of blocks of elements")?;
        let total = self.cursor.size("a number of elements")?;
        for _ in 0..2 {
            self.cursor.size("an element's tag")?;
        }
        let mut found = 0;
        for _ in 0..blocks {
            let dimension = self.cursor.int("a dimension")?;
            let entity = self.cursor.int("an entity's tag")?;
            let kind = self.cursor.int("an element's type")?;
            let elements = self.cursor.size("a number of elements")?;
            let element = self.element_of(kind)?;
            let bytes = least * (1 + element.nodes as u64);
            let elements = self.cursor.fits(elements, bytes, "elements")?;
            found += elements as u64;
            if i64::from(element.dimension) != dimension {
                return Err(self.cursor.error(format!(
                    "a block of {}s in an entity of dimension {dimension}",
                    element.name
                )));
            }
            let group = self.physical.get(&entity).copied().unwrap_or(0);
            let before = self.elements.cells.types.len();
            for _ in 0..elements {
                let tag = self.cursor.size("an element's tag")?;
                let cursor = &mut self.cursor;
                let mut node = || cursor.size("a node's tag");
                self.elements.add(tag, element, &mut node)?;
            }
            if self.elements.cells.types.len() > before {
                self.elements.group(group);
            }
        }
        if found != total {
            return Err(self.cursor.error(format!(
                "the blocks of $Elements hold {found} elements where {total} are announced"
            )));
        }
        Ok(())
    }

    /// The physical groups of volumes; those of points, curves and surfaces are passed over.
    fn entities(&mut self) -> Result<(), Error> {
        let cursor = &mut self.cursor;
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = cursor.size("a number of entities")?;
        }
        for (dimension, entities) in counts.into_iter().enumerate() {
            for _ in 0..entities {
                let tag = cursor.int("an entity's tag")?;
                // A point's place, or a box.
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    cursor.double("a coordinate")?;
                }
                let groups = cursor.size("a number of physical groups")?;
                for i in 0..groups {
                    let group = cursor.int("a physical group")?;
                    if dimension == 3 && i == 0 {
                        // A group's sign is the orientation in it.
                        self.physical.insert(tag, group.saturating_abs());
                    }
                }
                if dimension > 0 {
                    let bounding = cursor.size("a number of entities")?;
                    for _ in 0..bounding {
                        cursor.int("an entity's tag")?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The head of a section of data, up to the values: its name, its time and its integers.
    fn data_head(&mut self, what: &str) -> Result<(String, Option<f64>, Vec<i64>), Error> {
        let cursor = &mut self.cursor;
        let texts: u64 = cursor.number_line("a number of texts")?;
        let mut name = None;
        for _ in 0..texts {
            let text = cursor.text_line("a text")?;
            let text = text.strip_prefix('"').unwrap_or(text);
            let text = text.strip_suffix('"').unwrap_or(text);
            name.get_or_insert_with(|| text.to_owned());
        }
        let reals: u64 = cursor.number_line("a number of real values")?;
        let mut time = None;
        for _ in 0..reals {
            let real = cursor.text_line("a real value")?;
            time.get_or_insert(parse_float(real.trim_ascii()));
        }
        let integers: u64 = cursor.number_line("a number of integers")?;
        let integers = cursor.fits(integers, 2, "integers")?;
        let mut values = Vec::new();
        for _ in 0..integers {
            values.push(cursor.number_line("an integer")?);
        }
        let name = name.filter(|name| !name.is_empty());
        Ok((
            name.unwrap_or_else(|| what.to_owned()),
            time.flatten(),
            values,
        ))
    }

    fn view(&mut self, association: Association) -> Result<(), Error> {
        let (section, thing) = match association {
            Association::Point => ("NodeData", "nodes"),
            Association::Cell => ("ElementData", "elements"),
        };
        let (name, time, integers) = self.data_head(section)?;
        let &[step, components, entries, ..] = &integers[..] else {
            return Err(self.cursor.error(format!(
                "${section} '{}' has {} integers; it needs a time step, a number of components and a number of {thing}",
                clip(&name),
                integers.len()
            )));
        };
        let refused = |number: i64, what: &str| {
            let name = clip(&name);
            let what = format!("${section} '{name}' has {number} {what}");
            self.cursor.error(what)
        };
        let components = match usize::try_from(components) {
            Ok(components) if (1..=MOST_COMPONENTS).contains(&components) => components,
            _ => {
                let what = format!("components; 1 to {MOST_COMPONENTS} are read");
                return Err(refused(components, &what));
            }
        };
        let entries = u64::try_from(entries).map_err(|_| refused(entries, "values"))?;
        let encoding = self.cursor.encoding;
        let bytes = encoding.least_bytes(Number::Int)
            + components as u64 * encoding.least_bytes(Number::Double);
        self.cursor.fits(entries, bytes, thing)?;
        let part = (self.cursor.at, entries);
        match encoding {
            Encoding::Text => self.find_end(section)?,
            Encoding::Binary { .. } => self.cursor.at += (entries * bytes) as usize,
        }
        if entries == 0 {
            return Ok(());
        }
        let time = time.filter(|time| time.is_finite()).unwrap_or(step as f64);
        self.steps.entry(step).or_insert(time);
        self.add_part(association, name, components, step, part)
    }

    fn add_part(
        &mut self,
        association: Association,
        name: String,
        components: usize,
        step: i64,
        part: (usize, u64),
    ) -> Result<(), Error> {
        let key = (association == Association::Cell, name, components);
        let place = match self.names.get(&key) {
            Some(&place) => place,
            None if self.views.len() == MOST_FIELDS => {
                return Err(self
                    .cursor
                    .error(format!("more than {MOST_FIELDS} fields are not read")));
            }
            None => {
                self.views.push(View {
                    association,
                    name: key.1.clone(),
                    components,
                    first: step,
                    steps: BTreeMap::new(),
                });
                self.names.insert(key, self.views.len() - 1);
                self.views.len() - 1
            }
        };
        let steps = &mut self.views[place].steps;
        steps.entry(step).or_default().push(part);
        Ok(())
    }

    /// Values for each corner of each element, which are passed over.
    fn element_node_data(&mut self) -> Result<(), Error> {
        let (name, _, integers) = self.data_head("ElementNodeData")?;
        let why = "it has a value for each corner of each element ($ElementNodeData); save it as $NodeData";
        if self.left_out.iter().all(|(other, _)| *other != name)
            && self.left_out.len() < MOST_FIELDS
        {
            self.left_out.push((name, why.into()));
        }
        let Encoding::Binary { .. } = self.cursor.encoding else {
            return self.find_end("ElementNodeData");
        };
        let (components, elements) = match integers[..] {
            [_, components, elements, ..] => (components, elements),
            _ => (1, 0),
        };
        for _ in 0..elements {
            self.cursor.unsigned("an element's number")?;
            let nodes = self.cursor.unsigned("a number of nodes")?;
            let bytes = nodes.saturating_mul(8 * components.clamp(0, 1 << 20) as u64);
            self.cursor.at += self.cursor.fits(bytes, 1, "bytes")?;
        }
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

impl Elements {
    /// Adds an element, whose nodes' tags `node` reads, if it is a volume and not the one
    /// before it; returns whether it is.
    fn add(
        &mut self,
        tag: u64,
        element: Element,
        node: &mut dyn FnMut() -> Result<u64, Error>,
    ) -> Result<bool, Error> {
        let Element {
            name, nodes, cell, ..
        } = element;
        let Some(cell) = cell else {
            for _ in 0..nodes {
                node()?;
            }
            *self.skipped.entry(name).or_default() += 1;
            return Ok(false);
        };
        let Cell {
            kind,
            order,
            is_straightened,
        } = cell;
        // A hexahedron of order 9 has most.
        let mut read = [0; 1000];
        for place in &mut read[..nodes] {
            *place = node()?;
        }
        let Cells {
            types,
            offsets,
            connectivity,
        } = &mut self.cells;
        if offsets.is_empty() {
            offsets.push(0);
        }
        let start = connectivity.len();
        connectivity.extend(order.iter().map(|&place| read[place]));
        let (before, new) = connectivity.split_at(start);
        if types.last() == Some(&kind) && before.ends_with(new) {
            connectivity.truncate(start);
            self.repeated += 1;
            return Ok(false);
        }
        types.push(kind);
        offsets.push(connectivity.len() as u64);
        self.tags.push(tag);
        self.straightened += u64::from(is_straightened);
        Ok(true)
    }

    /// Says the physical group of the cells since the last call.
    fn group(&mut self, group: i64) {
        let end = self.cells.types.len() as u64;
        match self.groups.last_mut() {
            Some(run) if run.1 == group as f64 => run.0 = end,
            _ => self.groups.push((end, group as f64)),
        }
    }

    /// Puts the nodes' places for their tags.
    fn number_nodes(&mut self, source: &Source, nodes: &Tags) -> Result<(), Error> {
        let number = |tag: &mut u64| match nodes.item(*tag) {
            Some(node) => {
                *tag = node;
                false
            }
            None => true,
        };
        let connectivity = &mut self.cells.connectivity;
        let missing = connectivity.par_iter_mut().position_first(number);
        let Some(at) = missing else { return Ok(()) };
        let cell = self
            .cells
            .offsets
            .partition_point(|&start| start <= at as u64)
            - 1;
        Err(source.error(
            format!("element {}", self.tags[cell]),
            format!(
                "the element uses node {}, which the file does not have",
                self.cells.connectivity[at]
            ),
        ))
    }
}

impl View {
    /// The field at `step`, if any of the points or cells with `tags` has a value. A field of
    /// one step is that at all times.
    fn array(
        self,
        source: &Arc<Source>,
        encoding: Encoding,
        (tags, step): (&Arc<[u64]>, Option<i64>),
        data: &mut MeshData,
    ) -> Result<Option<Array>, Error> {
        let View {
            name, mut steps, ..
        } = self;
        let number = steps.len();
        let wanted = match number {
            1 => self.first,
            _ => step.unwrap_or(self.first),
        };
        let Some(parts) = steps.remove(&wanted) else {
            let why = format!("it has {number} time steps, and not this one");
            data.notes.push(format!("field '{name}' left out: {why}"));
            data.left_out.push((name, why));
            return Ok(None);
        };
        let values = Values {
            source: source.clone(),
            encoding,
            components: self.components,
            parts,
            tags: tags.clone(),
        };
        let items = values.entries(&mut |_| {})?;
        if tags.iter().all(|&tag| items.item(tag).is_none()) {
            let why = match self.association {
                Association::Point => "no node of the file has a value",
                Association::Cell => "no volume has a value",
            };
            data.notes.push(format!("field '{name}' left out: {why}"));
            data.left_out.push((name, why.into()));
            return Ok(None);
        }
        if number > 1 && step.is_none() {
            data.notes.push(format!(
                "field '{name}' has {number} time steps: the first is read"
            ));
        }
        let mut array = Array::scalar(&name, self.association, tags.len(), Arc::new(values));
        array.components = self.components;
        Ok(Some(array))
    }
}

/// The numbers of a field in a file in memory.
struct Values {
    source: Arc<Source>,
    encoding: Encoding,
    components: usize,
    /// Where the values of some nodes or elements begin, and of how many.
    parts: Vec<(usize, u64)>,
    /// The tags of the mesh's points or cells, in their order.
    tags: Arc<[u64]>,
}

impl Values {
    /// Which entry belongs to a tag; calls `each` with the values of one entry after the other.
    fn entries(&self, each: &mut dyn FnMut(f64)) -> Result<Tags, Error> {
        let mut cursor = Cursor::new(&self.source);
        cursor.encoding = self.encoding;
        let mut tags = Vec::new();
        for &(at, entries) in &self.parts {
            cursor.at = at;
            for _ in 0..entries {
                tags.push(cursor.unsigned("a node's or an element's number")?);
                for _ in 0..self.components {
                    each(cursor.double("a value")?);
                }
            }
        }
        Ok(Tags::new(&tags)?.0)
    }
}

impl fmt::Debug for Values {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let path = self.source.path.display();
        write!(formatter, "values at {:?} of {path}", self.parts)
    }
}

impl Numbers for Values {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut values = Vec::new();
        let items = self.entries(&mut |value| values.push(value))?;
        for &tag in &*self.tags {
            match items.item(tag) {
                Some(item) => {
                    let start = item as usize * self.components;
                    let tuple = &values[start..start + self.components];
                    tuple.iter().for_each(|&value| each(value));
                }
                None => (0..self.components).for_each(|_| each(f64::NAN)),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
