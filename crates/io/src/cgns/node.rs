//! Nodes of a CGNS file: groups with a label, and with data in the dataset ` data`.

use std::path::Path;

use tetrascope_core::Error;

use super::MOST_NODES;
use crate::hdf5::{Dataset, Group, View};

/// Text of a node, in bytes.
const MOST_TEXT: u64 = 1 << 24;

pub(super) struct Node {
    group: Group,
    pub(super) name: String,
    label: String,
}

impl Node {
    pub(super) fn root(group: &Group) -> Node {
        Node {
            group: group.clone(),
            name: String::new(),
            label: String::new(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.group.file.path
    }

    /// The length of the file, bytes.
    pub(super) fn length(&self) -> u64 {
        self.group.file.length
    }

    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        self.group.error(what)
    }

    pub(super) fn error_with_help(&self, what: impl Into<String>, help: &str) -> Error {
        self.group.error_with_help(what, help)
    }

    fn all(&self) -> Result<Vec<Node>, Error> {
        let (names, _) = self.group.members()?;
        if names.len() as u64 > MOST_NODES {
            return Err(self.error(format!(
                "{} nodes; up to {MOST_NODES} are read",
                names.len()
            )));
        }
        let mut nodes = Vec::new();
        for name in names {
            if let Some(group) = self.group.group(&name)? {
                let label = group.text("label")?.unwrap_or_default();
                let label = label.trim_end_matches('\0').to_owned();
                nodes.push(Node { group, name, label });
            }
        }
        Ok(nodes)
    }

    /// The nodes of a label in it, by name.
    pub(super) fn children(&self, label: &str) -> Result<Vec<Node>, Error> {
        let mut nodes = self.all()?;
        nodes.retain(|node| node.label == label);
        Ok(nodes)
    }

    /// The first node of a label in it.
    pub(super) fn child(&self, label: &str) -> Result<Option<Node>, Error> {
        Ok(self.children(label)?.into_iter().next())
    }

    /// The node of a name in it.
    pub(super) fn named(&self, name: &str) -> Result<Option<Node>, Error> {
        let group = self.group.group(name)?;
        Ok(group.map(|group| Node {
            group,
            name: name.to_owned(),
            label: String::new(),
        }))
    }

    /// The node of a name that must be there.
    pub(super) fn needed(&self, name: &str) -> Result<Node, Error> {
        let found = self.named(name)?;
        found.ok_or_else(|| self.error(format!("there is no node '{name}'")))
    }

    pub(super) fn data(&self) -> Result<Option<Dataset>, Error> {
        self.group.dataset(" data")
    }

    /// All numbers of the data.
    pub(super) fn view(&self) -> Result<View, Error> {
        let data = self.data()?;
        let data = data.ok_or_else(|| self.error("the node has no data"))?;
        data.view(&[], 0..data.shape().first().copied().unwrap_or(0))
    }

    /// The data as numbers, at most `most`; `None` if there are none.
    pub(super) fn numbers(&self, most: u64) -> Result<Option<Vec<f64>>, Error> {
        self.data()?.map(|data| data.all(most)).transpose()
    }

    /// The data as whole numbers from 0 on, at most `most`.
    pub(super) fn indices(&self, most: u64) -> Result<Vec<u64>, Error> {
        let view = self.view()?;
        if view.count() > most {
            return Err(self.error(format!("{} numbers; up to {most} are read", view.count())));
        }
        view.indices()
    }

    /// The data as text.
    pub(super) fn text(&self) -> Result<String, Error> {
        let bytes = self.numbers(MOST_TEXT)?.unwrap_or_default();
        let bytes: Vec<u8> = bytes.into_iter().map(|byte| byte as u8).collect();
        Ok(String::from_utf8_lossy(&bytes)
            .trim_matches([' ', '\0'])
            .to_owned())
    }

    /// The data as texts of 32 bytes each.
    pub(super) fn texts(&self) -> Result<Vec<String>, Error> {
        let bytes = self.numbers(MOST_TEXT)?.unwrap_or_default();
        let bytes: Vec<u8> = bytes.into_iter().map(|byte| byte as u8).collect();
        let texts = bytes.chunks(32).map(String::from_utf8_lossy);
        Ok(texts
            .map(|text| text.trim_matches([' ', '\0']).to_owned())
            .collect())
    }
}
