//! Arrays that stay in their file, in memory, and are decoded when they are asked for.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use tetrascope_core::Error;

use super::decode::Decoder;
use super::document::{Appended, ArrayElement, Compressor, Data, Document};
use crate::fields::Numbers;
use crate::grid::number::Number;
use crate::source::{Endian, Source};

/// Facts that all arrays of a file share.
pub(super) struct File {
    source: Arc<Source>,
    endian: Endian,
    wide_headers: bool,
    compressor: Compressor,
    /// Where appended data begin, and whether they are raw.
    appended: Option<(usize, bool)>,
    /// See [`Decoder::counting`].
    consumed: Arc<AtomicU64>,
}

impl File {
    /// The file that `decoder` has begun to read.
    pub(super) fn new(source: &Arc<Source>, document: &Document, decoder: &Decoder) -> Arc<File> {
        let appended = document.appended;
        Arc::new(File {
            source: source.clone(),
            endian: document.endian,
            wide_headers: document.wide_headers,
            compressor: document.compressor.clone(),
            appended: appended.map(|a| (source.bytes.len() - a.bytes.len(), a.raw)),
            consumed: decoder.consumed(),
        })
    }

    /// The facts that a decoder needs.
    fn document(&self) -> Document<'_> {
        Document {
            image: None,
            structure: None,
            version: [0; 2], // it says nothing of arrays
            endian: self.endian,
            wide_headers: self.wide_headers,
            compressor: self.compressor.clone(),
            pieces: Vec::new(),
            appended: self.appended.map(|(start, raw)| Appended {
                bytes: &self.source.bytes[start..],
                raw,
            }),
            time_steps: 1,
            notes: Vec::new(),
        }
    }
}

/// The array of a piece.
pub(super) struct Stored {
    file: Arc<File>,
    name: String,
    kind: Number,
    components: u64,
    tuples: u64,
    place: Place,
    /// Whether it was read before, so that its bytes are counted.
    is_counted: AtomicBool,
}

enum Place {
    Ascii(Text),
    Inline(Text),
    Appended(u64),
}

enum Text {
    /// Bytes of the file.
    InFile(Range<usize>),
    /// Text in several parts, between which other elements stand.
    Joined(String),
}

impl Stored {
    /// An array of a file, and how many tuples it has.
    pub(super) fn new(file: &Arc<File>, (element, tuples): (&ArrayElement, u64)) -> Stored {
        Stored {
            file: file.clone(),
            name: element.name.clone(),
            kind: element.kind,
            components: element.components,
            tuples,
            place: match &element.data {
                Data::Ascii(text) => Place::Ascii(file.text(text)),
                Data::Inline(text) => Place::Inline(file.text(text)),
                Data::Appended(offset) => Place::Appended(*offset),
            },
            is_counted: AtomicBool::new(false),
        }
    }
}

impl File {
    fn text(&self, text: &str) -> Text {
        let bytes = self.source.bytes.as_ptr_range();
        let range = text.as_bytes().as_ptr_range();
        if bytes.start <= range.start && range.end <= bytes.end {
            let start = range.start as usize - bytes.start as usize;
            Text::InFile(start..start + text.len())
        } else {
            Text::Joined(text.to_owned())
        }
    }

    fn words<'s>(&'s self, text: &'s Text) -> Cow<'s, str> {
        match text {
            // It was text when it was found.
            Text::InFile(range) => String::from_utf8_lossy(&self.source.bytes[range.clone()]),
            Text::Joined(text) => Cow::Borrowed(text),
        }
    }
}

impl fmt::Debug for Stored {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.name)
    }
}

impl Numbers for Stored {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let document = self.file.document();
        let consumed = match self.is_counted.swap(true, Ordering::Relaxed) {
            false => self.file.consumed.clone(),
            true => Arc::default(),
        };
        let decoder = Decoder::counting(&self.file.source, &document, consumed);
        let element = ArrayElement {
            name: self.name.clone(),
            kind: self.kind,
            components: self.components,
            component_names: Vec::new(),
            data: match &self.place {
                Place::Ascii(text) => Data::Ascii(self.file.words(text)),
                Place::Inline(text) => Data::Inline(self.file.words(text)),
                Place::Appended(offset) => Data::Appended(*offset),
            },
        };
        decoder.each_float(&element, self.tuples, each)
    }
}
