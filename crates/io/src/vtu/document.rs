//! The XML of a `.vtu`, `.vts`, `.vtr` or `.vti` file: which arrays there are and where their numbers stand.

use std::borrow::Cow;
use std::collections::HashMap;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use tetrascope_core::Error;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::mesh::Association;

use super::structured::{self, Structure};
use crate::collection::AS_A_SERIES;
use crate::fields::MOST_COMPONENTS;
use crate::grid::number::Number;
use crate::source::{Endian, Source};

/// Compression of binary data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    None,
    Zlib,
    Lz4,
    #[cfg(feature = "lzma")]
    Lzma,
    /// Another, by name: it is refused where binary data are.
    Unknown(String),
}

/// The type of an array's numbers, by VTK's name.
fn kind_of(name: &str) -> Option<Number> {
    Some(match name {
        "Int8" => Number::I8,
        "UInt8" => Number::U8,
        "Int16" => Number::I16,
        "UInt16" => Number::U16,
        "Int32" => Number::I32,
        "UInt32" => Number::U32,
        "Int64" => Number::I64,
        "UInt64" => Number::U64,
        "Float32" => Number::F32,
        "Float64" => Number::F64,
        _ => return None,
    })
}

/// Where an array's numbers are.
#[derive(Clone, Debug)]
pub(super) enum Data<'a> {
    /// Numbers in words, in the element.
    Ascii(Cow<'a, str>),
    /// Base64 in the element.
    Inline(Cow<'a, str>),
    /// In `AppendedData`, this many bytes or characters after the underscore.
    Appended(u64),
}

/// A `DataArray` element.
#[derive(Clone, Debug)]
pub(super) struct ArrayElement<'a> {
    pub(super) name: String,
    pub(super) kind: Number,
    pub(super) components: u64,
    /// As far as the file names them.
    pub(super) component_names: Vec<Option<String>>,
    pub(super) data: Data<'a>,
}

/// The parts of a piece that hold arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Section {
    PointData,
    CellData,
    Points,
    Coordinates,
    Cells,
}

/// A `Piece` element.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece<'a> {
    pub(super) points: u64,
    pub(super) cells: u64,
    pub(super) point_data: Vec<ArrayElement<'a>>,
    pub(super) cell_data: Vec<ArrayElement<'a>>,
    /// Coordinates of the points, or along the axes of a rectilinear grid.
    pub(super) coordinates: Vec<ArrayElement<'a>>,
    pub(super) topology: Vec<ArrayElement<'a>>,
    /// The first and last point along each axis, where there is no list of cells.
    pub(super) extent: [i64; 6],
    /// The `Scalars` of `PointData` and `CellData`.
    active: [Option<String>; 2],
}

impl<'a> Piece<'a> {
    /// The name of the scalars to draw, where the file gives one.
    pub(super) fn active(&self, association: Association) -> Option<&str> {
        self.active[usize::from(association == Association::Cell)].as_deref()
    }

    fn section(&mut self, section: Section) -> &mut Vec<ArrayElement<'a>> {
        match section {
            Section::PointData => &mut self.point_data,
            Section::CellData => &mut self.cell_data,
            Section::Points | Section::Coordinates => &mut self.coordinates,
            Section::Cells => &mut self.topology,
        }
    }
}

/// The data behind the underscore of `AppendedData`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Appended<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) raw: bool,
}

/// An `ImageData` element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Image {
    /// The first and last sample along each axis.
    pub(crate) extent: [i64; 6],
    /// Where sample (0, 0, 0) lies, whether it is in the extent or not.
    pub(crate) origin: DVec3,
    pub(crate) spacing: DVec3,
    /// The axes' directions, one per column.
    pub(crate) direction: DMat3,
}

/// A `.vtu`, `.vts`, `.vtr` or `.vti` file.
#[derive(Debug)]
pub(super) struct Document<'a> {
    /// The image that a `.vti` file has in place of points and cells.
    pub(super) image: Option<Image>,
    /// The structure that a `.vts` or `.vtr` file has in place of cells.
    pub(super) structure: Option<Structure>,
    /// Of the format, major and minor; 0 where the file says none.
    pub(super) version: [u32; 2],
    pub(super) endian: Endian,
    /// Headers of binary data are 64-bit numbers, else 32-bit.
    pub(super) wide_headers: bool,
    pub(super) compressor: Compressor,
    pub(super) pieces: Vec<Piece<'a>>,
    pub(super) appended: Option<Appended<'a>>,
    /// How many times some array is there, one for each time step.
    pub(super) time_steps: usize,
    pub(super) notes: Vec<String>,
}

/// Names without regard to case: `Format` has been seen for `format`.
pub(crate) type Attributes = HashMap<String, String>;

impl<'a> Document<'a> {
    /// Reads the XML up to the appended data, which need not be XML at all.
    pub(super) fn parse(source: &'a Source) -> Result<Document<'a>, Error> {
        let bytes = source.bytes.as_slice();
        let (head, tail) = match find(bytes, b"<AppendedData") {
            Some(at) => (&bytes[..at], Some(&bytes[at..])),
            None => (bytes, None),
        };
        let appended = tail
            .map(|tail| cut_appended(source, head.len(), tail))
            .transpose()?;
        let head = std::str::from_utf8(head).map_err(|error| {
            source.error(
                format!("byte {}", error.valid_up_to()),
                "the XML part of the file is not UTF-8 text",
            )
        })?;
        let mut parser = Parser {
            source,
            document: Document {
                image: None,
                structure: None,
                version: [0; 2],
                endian: Endian::Little,
                wide_headers: false,
                compressor: Compressor::None,
                pieces: Vec::new(),
                appended,
                time_steps: 1,
                notes: Vec::new(),
            },
            open: Vec::new(),
            section: None,
            array: None,
            repeats: HashMap::new(),
            grid: None,
            ended: false,
        };
        parser.run(head)?;
        structured::check(source, &parser.document)?;
        Ok(parser.document)
    }
}

/// The bytes after the underscore, and how they are encoded.
fn cut_appended<'a>(source: &Source, start: usize, tail: &'a [u8]) -> Result<Appended<'a>, Error> {
    let at = format!("byte {start}");
    let end = tail.iter().position(|&b| b == b'>').ok_or_else(|| {
        source.error(
            at.clone(),
            "the file ends within the <AppendedData> element",
        )
    })?;
    let element = String::from_utf8_lossy(&tail[1..end]);
    let element = BytesStart::from_content(element.trim_end_matches('/'), "AppendedData".len());
    let attributes = attributes(source, &element, start)?;
    let raw = match attributes.get("encoding").map(String::as_str) {
        Some("raw") => true,
        Some("base64") | None => false,
        Some(other) => {
            return Err(source.error(at, format!("appended data of unknown encoding '{other}'")));
        }
    };
    let body = tail[end + 1..].trim_ascii_start();
    match body.strip_prefix(b"_") {
        Some(bytes) => Ok(Appended { bytes, raw }),
        None => Err(source.error(at, "there is no underscore before the appended data")),
    }
}

/// Major and minor version of a format; 0 for what is not there.
pub(crate) fn version(text: &str) -> [u32; 2] {
    let mut numbers = text
        .trim()
        .split('.')
        .map(|number| number.parse().unwrap_or(0));
    let mut next = || numbers.next().unwrap_or(0);
    [next(), next()]
}

struct Parser<'a> {
    source: &'a Source,
    document: Document<'a>,
    /// Names of the elements around the current place.
    open: Vec<String>,
    section: Option<Section>,
    /// The array whose text is being read.
    array: Option<(ArrayElement<'a>, bool)>,
    /// How many times each array of the piece is there.
    repeats: HashMap<(Section, String), usize>,
    /// The name of the element that holds the pieces.
    grid: Option<String>,
    ended: bool,
}

impl<'a> Parser<'a> {
    fn run(&mut self, text: &'a str) -> Result<(), Error> {
        let mut reader = Reader::from_str(text);
        loop {
            let place = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| {
                self.source.error(
                    line(text, reader.error_position() as usize),
                    format!("the XML is damaged: {error}"),
                )
            })?;
            match event {
                Event::Start(element) => {
                    self.start(&element, place)?;
                    self.open.push(element.local_name().as_ref().to_owned());
                }
                Event::Empty(element) => {
                    self.start(&element, place)?;
                    self.end(element.local_name().as_ref(), place)?;
                }
                Event::End(element) => {
                    self.open.pop();
                    self.end(element.local_name().as_ref(), place)?;
                }
                Event::Text(words) => self.text(words.into_inner()),
                Event::CData(words) => self.text(words.into_inner()),
                Event::Eof => break,
                _ => {}
            }
        }
        let Some(grid) = &self.grid else {
            return Err(self.source.error(
                "",
                "there is no element <UnstructuredGrid> or of another grid",
            ));
        };
        if !self.ended {
            return Err(self.source.error_with_help(
                format!("byte {}", text.len()),
                format!("the file ends before </{grid}>"),
                "the file is truncated; copy or write it again",
            ));
        }
        Ok(())
    }

    fn start(&mut self, element: &BytesStart<'a>, place: usize) -> Result<(), Error> {
        let name = element.local_name();
        match name.as_ref() {
            "VTKFile" => {
                let attributes = attributes(self.source, element, place)?;
                self.file(&attributes)
            }
            "UnstructuredGrid" => {
                self.grid = Some(name.as_ref().to_owned());
                Ok(())
            }
            kind @ ("StructuredGrid" | "RectilinearGrid") => {
                self.grid = Some(kind.to_owned());
                let attributes = attributes(self.source, element, place)?;
                let structure = structure(self.source, &attributes, kind, place)?;
                self.document.structure = Some(structure);
                Ok(())
            }
            "ImageData" => {
                self.grid = Some(name.as_ref().to_owned());
                let attributes = attributes(self.source, element, place)?;
                self.document.image = Some(image(self.source, &attributes, place)?);
                Ok(())
            }
            "Piece" if self.grid.is_some() => {
                let attributes = attributes(self.source, element, place)?;
                let extent = numbers(self.source, &attributes, "extent", place)?;
                let structure = self.document.structure.map(|grid| grid.extent);
                let whole = self.document.image.map(|image| image.extent);
                let extent = extent.or(structure).or(whole).unwrap_or_default();
                let number = |key: &str| self.number(&attributes, key, place);
                let (points, cells) = match structure {
                    Some(_) => structured::counts(&extent)
                        .ok_or_else(|| structured::uncountable(self.source, &extent))?,
                    None => (
                        number("numberofpoints")?.unwrap_or(0),
                        number("numberofcells")?.unwrap_or(0),
                    ),
                };
                let piece = Piece {
                    points,
                    cells,
                    extent,
                    ..Piece::default()
                };
                self.document.pieces.push(piece);
                self.repeats.clear();
                Ok(())
            }
            "PointData" | "CellData" | "Points" | "Coordinates" | "Cells" => {
                let section = match name.as_ref() {
                    "PointData" => Section::PointData,
                    "CellData" => Section::CellData,
                    "Points" => Section::Points,
                    "Coordinates" => Section::Coordinates,
                    _ => Section::Cells,
                };
                self.section = Some(section);
                let attributes = attributes(self.source, element, place)?;
                if let (Some(piece), Some(scalars)) =
                    (self.document.pieces.last_mut(), attributes.get("scalars"))
                {
                    piece.active[usize::from(section == Section::CellData)] = Some(scalars.clone());
                }
                Ok(())
            }
            "DataArray" if self.section.is_some() => self.array(element, place),
            _ => Ok(()),
        }
    }

    fn end(&mut self, name: &str, place: usize) -> Result<(), Error> {
        match name {
            "PointData" | "CellData" | "Points" | "Coordinates" | "Cells" => self.section = None,
            "UnstructuredGrid" | "ImageData" | "StructuredGrid" | "RectilinearGrid" => {
                self.ended = true;
            }
            "DataArray" => {
                if let (Some((array, keep)), Some(section)) = (self.array.take(), self.section) {
                    let Some(piece) = self.document.pieces.last_mut() else {
                        return Err(self.source.error(
                            format!("byte {place}"),
                            format!("array '{}' stands outside of a piece", array.name),
                        ));
                    };
                    let arrays = piece.section(section);
                    // One array per time step: the first is drawn.
                    // The axes of a rectilinear grid are told apart by their order.
                    let name_is_empty = array.name.is_empty() || section == Section::Coordinates;
                    let repeats = self.repeats.entry((section, array.name.clone()));
                    let repeats = repeats.or_default();
                    if keep && (*repeats == 0 || name_is_empty) {
                        arrays.push(array);
                    }
                    *repeats += 1;
                    if !name_is_empty {
                        let steps = &mut self.document.time_steps;
                        *steps = (*repeats).max(*steps);
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Keeps the text of an array (not that of elements inside it).
    fn text(&mut self, words: Cow<'a, str>) {
        let Some((array, _)) = &mut self.array else {
            return;
        };
        if self.open.last().is_none_or(|name| name != "DataArray") {
            return;
        }
        if let Data::Ascii(text) | Data::Inline(text) = &mut array.data {
            if text.is_empty() {
                *text = words;
            } else {
                text.to_mut().push_str(&words);
            }
        }
    }

    fn file(&mut self, attributes: &Attributes) -> Result<(), Error> {
        let get = |key: &str| attributes.get(key).map(String::as_str);
        let refuse =
            |what: String, help: &str| Err(self.source.error_with_help("<VTKFile>", what, help));
        let kind = get("type").unwrap_or("UnstructuredGrid");
        if ![
            "UnstructuredGrid",
            "StructuredGrid",
            "RectilinearGrid",
            "ImageData",
        ]
        .contains(&kind)
        {
            if let Some((first, files)) = listed_files(&self.source.bytes) {
                if kind == "Collection" {
                    return refuse(
                        format!(
                            "the file lists {files} files of a series, the first of them '{first}'"
                        ),
                        AS_A_SERIES,
                    );
                }
                return refuse(
                    format!(
                        "the file holds a {kind}, which only lists {files} other files, the first of them '{first}'"
                    ),
                    "give one of these files, or join them, for example by opening this one in ParaView and saving it as .vtu or .vti",
                );
            }
            return refuse(
                format!(
                    "the file holds a {kind}; of VTK XML files UnstructuredGrid, StructuredGrid, \
                     RectilinearGrid and ImageData are read"
                ),
                "save the data as an unstructured grid (.vtu), for example with ParaView's Append Datasets",
            );
        }
        let document = &mut self.document;
        document.version = version(get("version").unwrap_or_default());
        document.endian = match get("byte_order") {
            Some("BigEndian") => Endian::Big,
            Some("LittleEndian") | None => Endian::Little,
            Some(other) => {
                return refuse(
                    format!("unknown byte order '{other}'"),
                    "it is LittleEndian or BigEndian",
                );
            }
        };
        document.wide_headers = match get("header_type") {
            Some("UInt64") => true,
            Some("UInt32") | None => false,
            Some(other) => {
                return refuse(
                    format!("unknown header type '{other}'"),
                    "it is UInt32 or UInt64",
                );
            }
        };
        document.compressor = match get("compressor") {
            None | Some("") => Compressor::None,
            Some("vtkZLibDataCompressor") => Compressor::Zlib,
            Some("vtkLZ4DataCompressor") => Compressor::Lz4,
            #[cfg(feature = "lzma")]
            Some("vtkLZMADataCompressor") => Compressor::Lzma,
            // Text is not compressed, whatever the file says.
            Some(other) => Compressor::Unknown(other.into()),
        };
        Ok(())
    }

    fn array(&mut self, element: &BytesStart<'a>, place: usize) -> Result<(), Error> {
        let attributes = attributes(self.source, element, place)?;
        let name = attributes.get("name").cloned().unwrap_or_default();
        let at = || format!("array '{name}' (byte {place})");
        let data = match attributes
            .get("format")
            .map(|f| f.to_ascii_lowercase())
            .as_deref()
        {
            Some("ascii") | None => Data::Ascii(Cow::Borrowed("")),
            Some("binary") => Data::Inline(Cow::Borrowed("")),
            Some("appended") => match self.number(&attributes, "offset", place)? {
                Some(offset) => Data::Appended(offset),
                None => return Err(self.source.error(at(), "appended data without an offset")),
            },
            Some(other) => {
                return Err(self.source.error(at(), format!("unknown format '{other}'")));
            }
        };
        let components = self
            .number(&attributes, "numberofcomponents", place)?
            .unwrap_or(1);
        let named = attributes.get("type").map_or("", String::as_str);
        let kind = kind_of(named);
        // Points and cells must be numbers; a field of texts is of no use here.
        let is_field = matches!(self.section, Some(Section::PointData | Section::CellData));
        if kind.is_none() && !is_field {
            return Err(self.source.error(at(), format!("unknown type '{named}'")));
        }
        if kind.is_none() {
            self.document
                .notes
                .push(format!("array '{name}' left out: it is of type '{named}'"));
        }
        if components == 0 || components > MOST_COMPONENTS as u64 {
            return Err(self.source.error(
                at(),
                format!("{components} components; 1 to {MOST_COMPONENTS} are read"),
            ));
        }
        let names = (0..components).map(|c| attributes.get(&format!("componentname{c}")).cloned());
        let array = ArrayElement {
            name,
            kind: kind.unwrap_or(Number::U8),
            components,
            component_names: names.collect(),
            data,
        };
        self.array = Some((array, kind.is_some()));
        Ok(())
    }

    fn number(
        &self,
        attributes: &Attributes,
        key: &str,
        place: usize,
    ) -> Result<Option<u64>, Error> {
        let Some(text) = attributes.get(key) else {
            return Ok(None);
        };
        text.trim().parse().map(Some).map_err(|_| {
            self.source.error(
                format!("byte {place}"),
                format!("{key} is '{text}', not a whole number"),
            )
        })
    }
}

/// The structure that the attributes of a `StructuredGrid` or `RectilinearGrid` at byte `place` say, or those of
/// the same with a `P` before, in a list of pieces.
pub(super) fn structure(
    source: &Source,
    attributes: &Attributes,
    kind: &str,
    place: usize,
) -> Result<Structure, Error> {
    let extent = numbers::<i64, 6>(source, attributes, "wholeextent", place)?;
    Ok(Structure {
        extent: extent
            .ok_or_else(|| source.error(format!("byte {place}"), "a grid without WholeExtent"))?,
        rectilinear: kind.ends_with("RectilinearGrid"),
    })
}

/// The image that the attributes of an `ImageData` or `PImageData` at byte `place` say.
pub(super) fn image(
    source: &Source,
    attributes: &Attributes,
    place: usize,
) -> Result<Image, Error> {
    let three = |key: &str| numbers::<f64, 3>(source, attributes, key, place);
    let turn = numbers::<f64, 9>(source, attributes, "direction", place)?;
    let extent = numbers::<i64, 6>(source, attributes, "wholeextent", place)?;
    Ok(Image {
        extent: extent
            .ok_or_else(|| source.error(format!("byte {place}"), "an image without WholeExtent"))?,
        origin: three("origin")?.unwrap_or([0.0; 3]).into(),
        spacing: three("spacing")?.unwrap_or([1.0; 3]).into(),
        // In rows.
        direction: turn.map_or(DMat3::IDENTITY, |t| DMat3::from_cols_array(&t).transpose()),
    })
}

/// Exactly `N` numbers of an attribute.
fn numbers<T: std::str::FromStr, const N: usize>(
    source: &Source,
    attributes: &Attributes,
    key: &str,
    place: usize,
) -> Result<Option<[T; N]>, Error> {
    let Some(text) = attributes.get(key) else {
        return Ok(None);
    };
    let words = text.split_ascii_whitespace();
    let numbers: Option<Vec<T>> = words.map(|word| word.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.map(Some).ok_or_else(|| {
        source.error(
            format!("byte {place}"),
            format!("{key} is '{text}', not {N} numbers"),
        )
    })
}

/// The attributes of an element at byte `place`.
pub(crate) fn attributes(
    source: &Source,
    element: &BytesStart,
    place: usize,
) -> Result<Attributes, Error> {
    element
        .attributes()
        .map(|attribute| {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let value = attribute
                .normalized_value(XmlVersion::Implicit1_0)
                .map_err(|error| error.to_string())?;
            let key = attribute.key.local_name().as_ref().to_ascii_lowercase();
            Ok((key, value.into_owned()))
        })
        .collect::<Result<_, String>>()
        .map_err(|error| {
            source.error(
                format!("byte {place}"),
                format!(
                    "an attribute of <{}> is damaged: {error}",
                    element.name().as_ref()
                ),
            )
        })
}

/// The first of the files that a file of pieces, blocks or time steps names, and how many it
/// names.
fn listed_files(bytes: &[u8]) -> Option<(String, usize)> {
    const MOST: usize = 60;
    for key in [b" Source=\"".as_slice(), b" file=\""] {
        let first = find(bytes, key).map(|at| &bytes[at + key.len()..]);
        let end = |rest: &[u8]| rest.iter().position(|&b| b == b'"');
        if let Some((rest, end)) = first.and_then(|rest| Some((rest, end(rest)?))) {
            let name = String::from_utf8_lossy(&rest[..end]);
            let files = bytes.windows(key.len()).filter(|w| *w == key).count();
            return Some((name.chars().take(MOST).collect(), files));
        }
    }
    None
}

/// "line 3, column 7" of a byte offset.
pub(crate) fn line(text: &str, offset: usize) -> String {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let lines = before.iter().filter(|&&b| b == b'\n').count();
    let column = before.iter().rev().take_while(|&&b| b != b'\n').count();
    format!("line {}, column {}", lines + 1, column + 1)
}

/// The first place of `needle`.
pub(super) fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    let mut from = 0;
    while let Some(at) = bytes[from..].iter().position(|&b| b == needle[0]) {
        if bytes[from + at..].starts_with(needle) {
            return Some(from + at);
        }
        from += at + 1;
    }
    None
}
