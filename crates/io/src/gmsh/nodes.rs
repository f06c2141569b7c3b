//! The section of nodes, in both versions.

use glam::DVec3;
use tetrascope_core::{Error, glam};

use super::Reader;
use super::cursor::Number;
use crate::source::reserve;

impl Reader<'_> {
    pub(super) fn begin_nodes(&mut self) -> Result<(), Error> {
        if !self.points.is_empty() {
            return Err(self.cursor.error("a second section $Nodes"));
        }
        Ok(())
    }

    pub(super) fn position(&mut self) -> Result<DVec3, Error> {
        let cursor = &mut self.cursor;
        let mut next = || cursor.double("a node's coordinate");
        Ok(DVec3::new(next()?, next()?, next()?))
    }

    pub(super) fn nodes_2(&mut self) -> Result<(), Error> {
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

    pub(super) fn nodes_4(&mut self) -> Result<(), Error> {
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
}
