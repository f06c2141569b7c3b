//! HDF5 files: groups, attributes, and datasets by parts.
//!
//! The HDF Group, *HDF5 File Format Specification*. Bytes are read at their places when they are
//! needed, without a memory map. Links to other files, data in other files and virtual datasets
//! are refused. What a file says of sizes is checked by those who read: a [`View`] allocates
//! for a part at a time, and no part is larger than the file may unpack to.

mod dataset;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::storage::{DynStorage, FileStorage};
use hdf5_reader::{Attribute, ExternalFileResolver, ExternalLinkResolver, Hdf5File, OpenOptions};
use tetrascope_core::Error;

pub(crate) use self::dataset::{Dataset, View};

use crate::grid::payload::most_unpacked;
use crate::source::{format_error, format_error_with_help, open_file};

/// The help of an error about a file that is damaged.
const COPY: &str = "the file is truncated or damaged; copy or write it again";

/// An open file.
pub(crate) struct File {
    pub(crate) path: PathBuf,
    /// In bytes.
    pub(crate) length: u64,
}

/// A group of a file.
#[derive(Clone)]
pub(crate) struct Group {
    pub(crate) file: Arc<File>,
    group: hdf5_reader::group::Group,
    /// From the root.
    pub(crate) path: String,
}

/// Opens a file; gives its root.
pub(crate) fn open(path: &Path) -> Result<Group, Error> {
    let (handle, length) = open_file(path)?;
    let file = Arc::new(File {
        path: path.to_owned(),
        length,
    });
    let damaged =
        |error: Hdf5Error| format_error_with_help(path, "the HDF5 header", one_line(&error), COPY);
    let most = usize::try_from(most_unpacked(length)).unwrap_or(usize::MAX);
    let refuse = Arc::new(Refuse);
    let options = OpenOptions {
        // Enough for the chunks that pieces share.
        chunk_cache_bytes: 16 << 20,
        max_chunk_bytes: hdf5_reader::DEFAULT_MAX_CHUNK_BYTES.min(most),
        max_read_bytes: most,
        external_file_resolver: Some(refuse.clone()),
        external_link_resolver: Some(refuse),
        ..OpenOptions::default()
    };
    let storage = FileStorage::from_file(handle).map_err(damaged)?;
    let opened = Hdf5File::from_storage_with_options(Arc::new(storage), options);
    let opened = opened.map_err(damaged)?;
    // What is missing would show later, or never: groups may seem empty.
    let end = opened.superblock().eof_address;
    if end > length {
        return Err(format_error_with_help(
            path,
            "the HDF5 header",
            format!("the file ends at byte {length} of {end}"),
            COPY,
        ));
    }
    Ok(Group {
        group: opened.root_group().map_err(damaged)?,
        file,
        path: String::new(),
    })
}

/// Refuses what is in other files, so that it does not seem absent.
struct Refuse;

fn other_file(name: &str) -> Hdf5Error {
    Hdf5Error::Other(format!(
        "part of it is in another file, '{name}', which is not read: save it as one file"
    ))
}

impl ExternalFileResolver for Refuse {
    fn resolve_external_file(&self, name: &str) -> Result<Option<DynStorage>, Hdf5Error> {
        Err(other_file(name))
    }
}

impl ExternalLinkResolver for Refuse {
    fn resolve_external_link(&self, name: &str) -> Result<Option<Hdf5File>, Hdf5Error> {
        Err(other_file(name))
    }
}

/// An error's words in one line, not too long.
fn one_line(error: &Hdf5Error) -> String {
    let words = error.to_string().replace(char::is_control, " ");
    match words.char_indices().nth(200) {
        None => words,
        Some((end, _)) => format!("{}…", &words[..end]),
    }
}

impl File {
    /// An error at a place in the file.
    pub(crate) fn error(&self, at: impl Into<String>, what: impl Into<String>) -> Error {
        format_error(&self.path, at, what)
    }
}

impl Group {
    /// An error about the group.
    pub(crate) fn error(&self, what: impl Into<String>) -> Error {
        self.file.error(self.place(), what)
    }

    /// The same with something to try.
    pub(crate) fn error_with_help(
        &self,
        what: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        format_error_with_help(&self.file.path, self.place(), what, help)
    }

    fn place(&self) -> String {
        match self.path.as_str() {
            "" => "the root group".into(),
            path => format!("group '{path}'"),
        }
    }

    fn damaged(&self, name: &str, error: &Hdf5Error) -> Error {
        let at = format!("'{}/{name}'", self.path);
        self.file.error(at, one_line(error))
    }

    /// Where it is in the file: the same for all of its names.
    pub(crate) fn address(&self) -> u64 {
        self.group.address()
    }

    /// The names of the groups and of the datasets in it.
    pub(crate) fn members(&self) -> Result<(Vec<String>, Vec<String>), Error> {
        let names = self.group.member_names();
        names.map_err(|error| self.error(one_line(&error)))
    }

    /// The group of a name, if it is there.
    pub(crate) fn group(&self, name: &str) -> Result<Option<Group>, Error> {
        match self.group.group(name) {
            Ok(group) => Ok(Some(Group {
                file: self.file.clone(),
                group,
                path: format!("{}/{name}", self.path),
            })),
            Err(Hdf5Error::GroupNotFound(_)) => Ok(None),
            Err(error) => Err(self.damaged(name, &error)),
        }
    }

    /// The dataset of a name, if it is there.
    pub(crate) fn dataset(&self, name: &str) -> Result<Option<Dataset>, Error> {
        match self.group.dataset(name) {
            Ok(dataset) => {
                let path = format!("{}/{name}", self.path);
                Ok(Some(Dataset::new(&self.file, dataset, path)))
            }
            Err(Hdf5Error::DatasetNotFound(_)) => Ok(None),
            Err(error) => Err(self.damaged(name, &error)),
        }
    }

    fn attribute(&self, name: &str) -> Result<Option<Attribute>, Error> {
        match self.group.attribute(name) {
            Ok(attribute) => Ok(Some(attribute)),
            Err(Hdf5Error::AttributeNotFound(_)) => Ok(None),
            Err(error) => Err(self.damaged(name, &error)),
        }
    }

    /// The text of an attribute, by its size or up to a zero; `None` if it is not there or not
    /// text.
    pub(crate) fn text(&self, name: &str) -> Result<Option<String>, Error> {
        let attribute = self.attribute(name)?;
        Ok(attribute.and_then(|attribute| text(&attribute)))
    }

    /// The numbers of an attribute; `None` if it is not there.
    pub(crate) fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, Error> {
        let Some(attribute) = self.attribute(name)? else {
            return Ok(None);
        };
        let numbers = dataset::attribute_numbers(&attribute);
        let numbers = numbers.ok_or_else(|| {
            let at = format!("attribute '{name}' of {}", self.place());
            self.file.error(at, "it does not hold numbers")
        })?;
        Ok(Some(numbers))
    }
}

/// See [`Group::text`].
fn text(attribute: &Attribute) -> Option<String> {
    let text = attribute.read_string().ok()?;
    Some(text.trim_matches(['\0', ' ']).to_owned())
}

#[cfg(test)]
pub(crate) mod tests;
