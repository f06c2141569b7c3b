//! Files that list others: the pieces of a mesh, `.pvtu`, `.pvts` and `.pvtr`, or of an image,
//! `.pvti`, and blocks of any kind, `.vtm`.
//!
//! Names start at the folder of the file that lists them and do not lead out of it. A part's
//! points stay its own; where they lie exactly at those of another part, cells of both that
//! have a face there become neighbors.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use tetrascope_core::Error;

use super::document::{self, Document, Image};
use super::structured::{self, Structure};
use super::{Opened, attributes, image, line, read_mesh, to_utf8};
use crate::collection::MAX_COLLECTION_BYTES;
use crate::pieces::Fields;
use crate::read::FileData;
use crate::source::{KEEP_TOGETHER, Source, beside, count, read_at};

/// The kind of pieces that a file lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Pieces of one mesh, all with the same fields: `.pvtu`.
    Pieces,
    /// Pieces of one structured or rectilinear grid or of an image, by their extents: `.pvts`,
    /// `.pvtr`, `.pvti`.
    Extents,
    /// Meshes and other things, each with its own fields: `.vtm`.
    Blocks,
}

impl Kind {
    /// `None` for a file that is not such a list.
    pub(super) fn of(source: &Source) -> Option<Kind> {
        match file_type(source)?.as_str() {
            "PUnstructuredGrid" => Some(Kind::Pieces),
            "PStructuredGrid" | "PRectilinearGrid" | "PImageData" => Some(Kind::Extents),
            "vtkMultiBlockDataSet" => Some(Kind::Blocks),
            _ => None,
        }
    }

    /// The element that names a file, and the attribute that has the name.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Kind::Pieces | Kind::Extents => ("Piece", "source"),
            Kind::Blocks => ("DataSet", "file"),
        }
    }
}

/// The `type` of the first element of a VTK XML file.
pub(super) fn file_type(source: &Source) -> Option<String> {
    // The first element is short; what follows may be anything.
    let head = &source.bytes[..source.bytes.len().min(4096)];
    let text = String::from_utf8_lossy(head);
    let mut reader = Reader::from_str(&text);
    loop {
        match reader.read_event().ok()? {
            Event::Start(element) | Event::Empty(element) => {
                return attributes(source, &element, 0).ok()?.remove("type");
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

/// A file that is listed.
struct Entry {
    name: String,
    path: PathBuf,
}

/// Reads the files that `list` names and joins their meshes or images.
pub(super) fn read(list: Arc<Source>, kind: Kind) -> Result<FileData, Error> {
    let (entries, grid) = entries(&list, kind)?;
    let mut notes = Vec::new();
    let mut sources = Vec::new();
    let mut names = Vec::new();
    for Entry { name, path } in &entries {
        if kind == Kind::Blocks
            && let Some(other) = other_kind(path)?
        {
            notes.push(left_out(name, &other));
            continue;
        }
        sources.push(Arc::new(to_utf8(Source::open(path)?)?));
        names.push(name.as_str());
    }
    let mut documents = Vec::new();
    for source in &sources {
        let document = Document::parse(source)?;
        let what = match (document.image.is_some(), &grid) {
            (true, Some(Whole::Image(_))) => None,
            (true, _) => Some("a piece of a mesh is a regular grid, which cannot be"),
            (false, Some(Whole::Image(_))) => Some("a piece of an image is none"),
            (false, _) => None,
        };
        if let Some(what) = what {
            return Err(source.error("<VTKFile>", what));
        }
        documents.push(document);
    }
    if documents.is_empty() {
        return Err(no_mesh(&list));
    }
    let files = sources.iter().zip(&documents).zip(names);
    let files: Vec<Opened> = files
        .map(|((source, document), name)| Opened::new(source, document, Some(name)))
        .collect();
    let read = match (kind, grid) {
        (_, Some(Whole::Image(image))) => image::read(&list, &files, &image).map(FileData::Grid),
        (_, Some(Whole::Structure(structure))) => {
            let pieces = documents.iter().flat_map(|document| &document.pieces);
            structured::check_pieces(&list, &structure.extent, pieces)?;
            structured::read(&list, &files, &structure)
        }
        (Kind::Blocks, _) => read_mesh(&list, &files, Fields::All).map(FileData::Mesh),
        _ => read_mesh(&list, &files, Fields::Common).map(FileData::Mesh),
    };
    let mut read = read?;
    let (all_notes, all_files) = match &mut read {
        FileData::Mesh(data) => (&mut data.notes, &mut data.files),
        FileData::Grid(data) => (&mut data.notes, &mut data.files),
        FileData::Clusters(_) => unreachable!("pieces are meshes and images"),
    };
    all_notes.splice(0..0, notes);
    *all_files = vec![list.path.clone()];
    all_files.extend(sources.iter().map(|s| s.path.clone()));
    Ok(read)
}

/// The meshes that a `.pvtu` or `.vtm` file lists.
pub(crate) struct Listed {
    pub(crate) files: Vec<PathBuf>,
    /// Parts that were left out.
    pub(crate) notes: Vec<String>,
    /// Whether each has fields of its own: `.vtm`.
    pub(crate) all_fields: bool,
}

impl Listed {
    /// The files that `list` names, none of which is read; `None` if it is not a list of meshes that can be read each by itself.
    pub(crate) fn of(list: Source) -> Result<Option<Listed>, Error> {
        let list = to_utf8(list)?;
        let kind = match Kind::of(&list) {
            Some(kind @ (Kind::Pieces | Kind::Blocks)) => kind,
            _ => return Ok(None),
        };
        let (entries, _) = entries(&list, kind)?;
        let mut listed = Listed {
            files: Vec::new(),
            notes: Vec::new(),
            all_fields: kind == Kind::Blocks,
        };
        for Entry { name, path } in entries {
            match kind {
                Kind::Blocks => match other_kind(&path)? {
                    Some(other) => listed.notes.push(left_out(&name, &other)),
                    None => listed.files.push(path),
                },
                _ => listed.files.push(path),
            }
        }
        match listed.files.is_empty() {
            true => Err(no_mesh(&list)),
            false => Ok(Some(listed)),
        }
    }
}

fn left_out(name: &str, other: &str) -> String {
    format!("'{name}' left out: it holds a {other}, and meshes are joined")
}

fn no_mesh(list: &Source) -> Error {
    list.error_with_help(
        "its end",
        "the file lists no mesh",
        "give one of the files that it lists",
    )
}

/// The grid that pieces make together.
enum Whole {
    Image(Image),
    Structure(Structure),
}

impl Whole {
    /// The whole that the element of a list at byte `place` describes.
    fn of(list: &Source, element: &BytesStart, place: usize) -> Result<Whole, Error> {
        let attributes = attributes(list, element, place)?;
        Ok(match element.local_name().as_ref() {
            "PImageData" => Whole::Image(document::image(list, &attributes, place)?),
            kind => Whole::Structure(document::structure(list, &attributes, kind, place)?),
        })
    }
}

/// The kind of a VTK XML file that is not a mesh.
fn other_kind(path: &Path) -> Result<Option<String>, Error> {
    let head = Source {
        path: path.to_owned(),
        bytes: read_at(path, 0, 4096)?,
    };
    let kind = file_type(&head);
    let meshes = ["UnstructuredGrid", "StructuredGrid", "RectilinearGrid"];
    Ok(kind.filter(|kind| !meshes.contains(&kind.as_str())))
}

/// The files that are listed, in their order; each is there. With them the grid that they make,
/// where the list has one.
fn entries(list: &Source, kind: Kind) -> Result<(Vec<Entry>, Option<Whole>), Error> {
    if list.bytes.len() as u64 > MAX_COLLECTION_BYTES {
        return Err(list.error(
            "",
            format!("a list of files of more than {MAX_COLLECTION_BYTES} bytes is not read"),
        ));
    }
    let text = String::from_utf8_lossy(&list.bytes);
    let mut reader = Reader::from_str(&text);
    let (element_name, key) = kind.names();
    let mut entries = Vec::new();
    let mut known = HashSet::new();
    let (mut is_whole, mut grid) = (false, None);
    loop {
        let place = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            list.error(
                line(&text, reader.error_position() as usize),
                format!("the XML is damaged: {error}"),
            )
        })?;
        match event {
            Event::Start(element) | Event::Empty(element) => {
                let element_kind = element.local_name();
                let element_kind = element_kind.as_ref();
                if kind == Kind::Extents && grid.is_none() && element_kind != "VTKFile" {
                    grid = Some(Whole::of(list, &element, place)?);
                    continue;
                }
                if element_kind != element_name {
                    continue;
                }
                // A block without a file is empty.
                let name = attributes(list, &element, place)?.remove(key);
                let Some(name) = name.filter(|name| !name.is_empty()) else {
                    match kind {
                        Kind::Pieces | Kind::Extents => {
                            let what = "a <Piece> without Source: no file is named";
                            return Err(list.error(line(&text, place), what));
                        }
                        Kind::Blocks => continue,
                    }
                };
                let path = checked(list, &name, &mut known)
                    .map_err(|(what, help)| list.error_with_help(line(&text, place), what, help))?;
                entries.push(Entry { name, path });
            }
            Event::DocType(_) => {
                let what = "the XML has a document type, which is not read";
                return Err(list.error(line(&text, place), what));
            }
            Event::End(element) => is_whole |= element.local_name().as_ref() == "VTKFile",
            Event::Eof => break,
            _ => {}
        }
    }
    if !is_whole {
        return Err(list.error_with_help(
            format!("byte {}", text.len()),
            "the file ends before </VTKFile>",
            "the file is truncated; copy or write it again",
        ));
    }
    if entries.is_empty() {
        let what = format!("the file lists no file: there is no <{element_name}> with a name");
        return Err(list.error("its end", what));
    }
    let is_missing = |entry: &&Entry| !entry.path.is_file();
    if let Some(first) = entries.iter().find(is_missing) {
        let others = match entries.iter().filter(is_missing).count() as u64 - 1 {
            0 => String::new(),
            others => format!(", nor are {}", count(others, "other")),
        };
        return Err(list.error_with_help(
            "its list of files",
            format!("the file '{}' is not there{others}", first.name),
            "names of files start at the folder of this file: copy them with it",
        ));
    }
    Ok((entries, grid))
}

/// The path of a name that was not listed before and is in the folder of `list` or below; else
/// what is wrong, and what helps.
fn checked(
    list: &Source,
    name: &str,
    known: &mut HashSet<PathBuf>,
) -> Result<PathBuf, (String, &'static str)> {
    let path = beside(&list.path, name).ok_or_else(|| {
        let what = format!("'{name}' is not in the folder of the file that lists it");
        (what, KEEP_TOGETHER)
    })?;
    let parts = Path::new(name).components();
    let plain: PathBuf = parts.filter(|part| *part != Component::CurDir).collect();
    match known.insert(plain) {
        true => Ok(path),
        false => Err((
            format!("'{name}' is listed twice"),
            "each file is one part of the mesh",
        )),
    }
}

#[cfg(test)]
mod tests;
