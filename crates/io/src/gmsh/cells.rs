//! The sections of elements and of entities, in both versions, and the cells that they make.

use std::collections::BTreeMap;

use rayon::prelude::*;
use tetrascope_core::{Cells, Error};

use super::Reader;
use super::cursor::{Encoding, Number};
use super::elements::{Cell, Element, element};
use super::tags::Tags;
use crate::source::Source;

#[derive(Default)]
pub(super) struct Elements {
    pub(super) tags: Vec<u64>,
    /// The connectivity is the tags of nodes until all are read.
    pub(super) cells: Cells,
    /// The physical group of each cell, for cells that follow each other up to the number.
    pub(super) groups: Vec<(u64, f64)>,
    /// Elements that are not volumes, by name.
    pub(super) skipped: BTreeMap<&'static str, u64>,
    pub(super) straightened: u64,
    pub(super) repeated: u64,
}

impl Reader<'_> {
    pub(super) fn element_of(&self, kind: i64) -> Result<Element, Error> {
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

    pub(super) fn elements_2(&mut self) -> Result<(), Error> {
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

    pub(super) fn elements_4(&mut self) -> Result<(), Error> {
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
    pub(super) fn entities(&mut self) -> Result<(), Error> {
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
}

impl Elements {
    /// Adds an element, whose nodes' tags `node` reads, if it is a volume and not the one
    /// before it; returns whether it is.
    pub(super) fn add(
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
    pub(super) fn group(&mut self, group: i64) {
        let end = self.cells.types.len() as u64;
        match self.groups.last_mut() {
            Some(run) if run.1 == group as f64 => run.0 = end,
            _ => self.groups.push((end, group as f64)),
        }
    }

    /// Puts the nodes' places for their tags.
    pub(super) fn number_nodes(&mut self, source: &Source, nodes: &Tags) -> Result<(), Error> {
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
