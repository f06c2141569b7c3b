//! Sections of data at nodes and of elements, which Gmsh calls views, and the fields that they make.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use super::cursor::{Cursor, Encoding, Number, clip};
use super::tags::Tags;
use super::{MOST_FIELDS, Reader};
use crate::fields::{Array, MOST_COMPONENTS, Numbers};
use crate::source::Source;
use crate::{MeshData, parse_float};

/// A field of one name.
pub(super) struct View {
    pub(super) association: Association,
    pub(super) name: String,
    pub(super) components: usize,
    /// The time step that comes first.
    pub(super) first: i64,
    /// Where the values of each step's sections begin, and for how many nodes or elements.
    pub(super) steps: BTreeMap<i64, Vec<(usize, u64)>>,
}

impl Reader<'_> {
    /// The head of a section of data, up to the values: its name, its time and its integers.
    pub(super) fn data_head(
        &mut self,
        what: &str,
    ) -> Result<(String, Option<f64>, Vec<i64>), Error> {
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

    pub(super) fn view(&mut self, association: Association) -> Result<(), Error> {
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

    pub(super) fn add_part(
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
    pub(super) fn element_node_data(&mut self) -> Result<(), Error> {
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
}

impl View {
    /// The field at `step`, if any of the points or cells with `tags` has a value. A field of
    /// one step is that at all times.
    pub(super) fn array(
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
    pub(super) fn entries(&self, each: &mut dyn FnMut(f64)) -> Result<Tags, Error> {
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
