//! Finding `DataItem` elements and the files that they name.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

use tetrascope_core::Error;

use super::document::{Document, Id};
use super::item::{Item, Place, product};
use crate::grid::header::clip;
use crate::grid::number::Number;
#[cfg(feature = "hdf5")]
use crate::hdf5;
use crate::source::{Endian, KEEP_TOGETHER, beside, open_file};

/// Files that a file may name.
const MOST_FILES: usize = 1 << 16;

/// The items of a file, and the files that they name.
pub(super) struct Items<'a> {
    pub(super) document: &'a Document,
    files: RefCell<Files>,
}

#[derive(Default)]
struct Files {
    /// In the order in which they are named.
    paths: Vec<PathBuf>,
    bytes: u64,
    binary: HashMap<String, (PathBuf, u64)>,
    #[cfg(feature = "hdf5")]
    hdf5: HashMap<String, hdf5::Group>,
}

impl<'a> Items<'a> {
    pub(super) fn new(document: &'a Document) -> Items<'a> {
        Items {
            document,
            files: RefCell::default(),
        }
    }

    /// All files so far, the one that names the others first.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.document.source.path.clone()];
        files.extend_from_slice(&self.files.borrow().paths);
        files
    }

    /// How many bytes they have.
    pub(super) fn length(&self) -> u64 {
        let own = self.document.source.bytes.len() as u64;
        own.saturating_add(self.files.borrow().bytes)
    }

    /// The items in an element.
    pub(super) fn of(&self, id: Id) -> Result<Vec<Item>, Error> {
        let ids = self.document.named(id, "DataItem")?;
        ids.into_iter().map(|id| self.item(id)).collect()
    }

    fn item(&self, id: Id) -> Result<Item, Error> {
        let document = self.document;
        let kind = document
            .attribute(id, &["itemtype", "type"])
            .unwrap_or("Uniform");
        match kind.to_ascii_lowercase().as_str() {
            "uniform" => self.plain(id),
            "hyperslab" => self.slab(id),
            _ => Err(self.unread(id, &format!("a DataItem of the type {}", clip(kind)))),
        }
    }

    fn unread(&self, id: Id, what: &str) -> Error {
        document_help(
            self.document,
            id,
            format!("{what} is not read"),
            "write the numbers that it stands for",
        )
    }

    fn plain(&self, id: Id) -> Result<Item, Error> {
        let document = self.document;
        let shape = match document.attribute(id, &["dimensions"]) {
            Some(words) => Some(numbers(words).ok_or_else(|| {
                document.error(
                    id,
                    format!("Dimensions are '{}', not whole numbers", clip(words)),
                )
            })?),
            None => None,
        };
        let number = self.number(id)?;
        let format = document.attribute(id, &["format"]).unwrap_or("XML");
        let text = document.text(id);
        let byte = document.byte(id);
        let item = |place, shape: Vec<u64>, signature| Item {
            source: document.source.clone(),
            byte,
            number,
            shape,
            place,
            signature,
        };
        let needed = || document.error(id, "there are no Dimensions");
        match format.to_ascii_uppercase().as_str() {
            "XML" => {
                let shape = shape.ok_or_else(needed)?;
                let count = product(&shape);
                let range = document.text_range(id);
                // A number takes a digit and a blank.
                if count > (range.len() as u64).div_ceil(2) {
                    let what = format!("{count} numbers cannot be in {} bytes", range.len());
                    return Err(document.error(id, what));
                }
                Ok(item(Place::Text(range), shape, format!("byte {byte}")))
            }
            "BINARY" => {
                let shape = shape.ok_or_else(needed)?;
                let seek = match document.attribute(id, &["seek"]) {
                    None | Some("") => 0,
                    Some(word) => word.parse().map_err(|_| {
                        document.error(
                            id,
                            format!("Seek is '{}', not a number of bytes", clip(word)),
                        )
                    })?,
                };
                let endian = document.attribute(id, &["endian"]).unwrap_or("Native");
                let endian = match endian.to_ascii_lowercase().as_str() {
                    "big" => Endian::Big,
                    // Files from elsewhere are little-endian nearly always.
                    _ => Endian::Little,
                };
                if let Some(packed) = document.attribute(id, &["compression"])
                    && !packed.eq_ignore_ascii_case("raw")
                {
                    return Err(self.unread(id, &format!("compression by {}", clip(packed))));
                }
                let (path, length) = self.binary(id, text)?;
                let bytes = product(&shape).saturating_mul(number.size() as u64);
                if bytes.saturating_add(seek) > length {
                    let what = format!(
                        "{bytes} bytes from byte {seek} on are not in '{}', which has {length}",
                        clip(text)
                    );
                    return Err(document.error(id, what));
                }
                let signature = format!("{text} {seek} {number:?} {shape:?} {endian:?}");
                Ok(item(Place::Binary { path, seek, endian }, shape, signature))
            }
            #[cfg(feature = "hdf5")]
            "HDF" | "HDF5" => {
                let dataset = self.dataset(id, text)?;
                let whole = dataset.shape().to_vec();
                let shape = shape.unwrap_or_else(|| whole.clone());
                if product(&shape) != product(&whole) {
                    return Err(dataset.error(format!(
                        "it has {whole:?} numbers, and {shape:?} are needed"
                    )));
                }
                let view = dataset.view(&[], 0..whole.first().copied().unwrap_or(0))?;
                let mut item = item(Place::Hdf5(view), shape, text.to_owned());
                item.number = dataset.number().unwrap_or(number);
                Ok(item)
            }
            #[cfg(not(feature = "hdf5"))]
            "HDF" | "HDF5" => {
                Err(document.error(id, "numbers in HDF5 are read with the feature `hdf5`"))
            }
            _ => Err(self.unread(id, &format!("the format {}", clip(format)))),
        }
    }

    #[cfg(not(feature = "hdf5"))]
    fn slab(&self, id: Id) -> Result<Item, Error> {
        Err(self.unread(id, "a HyperSlab without the feature `hdf5`"))
    }

    /// A part of an item in HDF5, if it is one of rows in their order.
    #[cfg(feature = "hdf5")]
    fn slab(&self, id: Id) -> Result<Item, Error> {
        let wrong = |what| Err(self.document.error(id, what));
        // Neither is a part itself, and so they are not in each other.
        let inner = self.document.named(id, "DataItem")?;
        let &[selection, item] = &inner[..] else {
            return wrong("a HyperSlab needs two items");
        };
        let (selection, item) = (self.plain(selection)?, self.plain(item)?);
        let Place::Hdf5(view) = &item.place else {
            return Err(self.unread(id, "a HyperSlab of numbers that are not in HDF5"));
        };
        let numbers = selection.indices(3 * 32)?;
        let rank = numbers.len() / 3;
        if rank == 0 || numbers.len() != 3 * rank {
            return wrong("a HyperSlab begins with start, stride and count");
        }
        let (start, rest) = numbers.split_at(rank);
        let (stride, counts) = rest.split_at(rank);
        let whole = view.dataset().shape();
        // One place along each of the first dimensions, a range of the next, all of the others.
        let places = counts.iter().take_while(|&&n| n == 1).count().min(rank - 1);
        let is_whole = |axis: usize| start[axis] == 0 && counts[axis] == whole[axis];
        let mut strides = stride.iter().zip(counts);
        let is_simple = whole.len() == rank
            && strides.all(|(&stride, &count)| stride == 1 || count == 1)
            && (places + 1..rank).all(is_whole);
        if !is_simple {
            return Err(self.unread(id, "a HyperSlab that is not a range of rows"));
        }
        let rows = start[places]..start[places].saturating_add(counts[places]);
        let view = view.dataset().view(&start[..places], rows)?;
        Ok(Item {
            shape: counts.to_vec(),
            place: Place::Hdf5(view),
            signature: format!("{} {numbers:?}", item.signature),
            ..item.clone()
        })
    }

    fn number(&self, id: Id) -> Result<Number, Error> {
        let document = self.document;
        let kind = document
            .attribute(id, &["numbertype", "datatype"])
            .unwrap_or("Float");
        let precision = document
            .attribute(id, &["precision"])
            .filter(|p| !p.is_empty());
        let kind = kind.to_ascii_lowercase();
        let number = match (kind.as_str(), precision) {
            ("float", None | Some("4")) => Number::F32,
            ("float", Some("8")) => Number::F64,
            ("int", Some("1")) | ("char", _) => Number::I8,
            ("int", Some("2")) | ("short", _) => Number::I16,
            ("int", None | Some("4")) => Number::I32,
            ("int", Some("8")) => Number::I64,
            ("uint", Some("1")) | ("uchar", _) => Number::U8,
            ("uint", Some("2")) | ("ushort", _) => Number::U16,
            ("uint", None | Some("4")) => Number::U32,
            ("uint", Some("8")) => Number::U64,
            _ => {
                let precision = precision.unwrap_or_default();
                let what = format!(
                    "numbers of the type {} {} are not read",
                    clip(&kind),
                    clip(precision)
                );
                return Err(document.error(id, what));
            }
        };
        Ok(number)
    }

    /// The path of a file of a name in the folder of this file or below, and its length.
    fn beside(&self, id: Id, name: &str) -> Result<(PathBuf, u64), Error> {
        let document = self.document;
        let path = beside(&document.source.path, name).ok_or_else(|| {
            let what = format!(
                "'{}' is not in the folder of the file that names it",
                clip(name)
            );
            document_help(document, id, what, KEEP_TOGETHER)
        })?;
        if !path.is_file() {
            let what = format!("the file '{}' is not there", clip(name));
            return Err(document_help(
                document,
                id,
                what,
                "names of files start at the folder of this file: copy them with it",
            ));
        }
        let (_, length) = open_file(&path)?;
        let mut files = self.files.borrow_mut();
        if files.paths.len() >= MOST_FILES {
            return Err(document.error(id, format!("more than {MOST_FILES} files are not read")));
        }
        files.paths.push(path.clone());
        files.bytes = files.bytes.saturating_add(length);
        Ok((path, length))
    }

    fn binary(&self, id: Id, name: &str) -> Result<(PathBuf, u64), Error> {
        let known = self.files.borrow().binary.get(name).cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let file = self.beside(id, name)?;
        self.files
            .borrow_mut()
            .binary
            .insert(name.to_owned(), file.clone());
        Ok(file)
    }

    /// The dataset that `file.h5:/path` means.
    #[cfg(feature = "hdf5")]
    fn dataset(&self, id: Id, text: &str) -> Result<hdf5::Dataset, Error> {
        let document = self.document;
        let Some((name, path)) = text.rsplit_once(':') else {
            return Err(document.error(
                id,
                format!("'{}' does not name a file and a dataset in it", clip(text)),
            ));
        };
        if path.contains('|') {
            return Err(self.unread(id, "a part of a dataset by its name"));
        }
        let known = self.files.borrow().hdf5.get(name).cloned();
        let root = match known {
            Some(root) => root,
            None => {
                let (file, _) = self.beside(id, name)?;
                let root = hdf5::open(&file)?;
                self.files
                    .borrow_mut()
                    .hdf5
                    .insert(name.to_owned(), root.clone());
                root
            }
        };
        let mut parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty()).collect();
        let last = parts.pop().unwrap_or_default();
        let absent = || {
            root.error(format!(
                "there is no dataset '{}', which {} names",
                clip(path),
                document.at(id)
            ))
        };
        let mut group = root.clone();
        for part in parts {
            group = group.group(part)?.ok_or_else(absent)?;
        }
        group.dataset(last)?.ok_or_else(absent)
    }
}

/// An error about an element, with something to try.
fn document_help(document: &Document, id: Id, what: String, help: &str) -> Error {
    document.source.error_with_help(document.at(id), what, help)
}

/// Whole numbers.
pub(super) fn numbers(words: &str) -> Option<Vec<u64>> {
    let words = words.split_ascii_whitespace();
    words.map(|word| word.parse().ok()).collect()
}
