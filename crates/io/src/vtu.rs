//! VTK XML unstructured, structured and rectilinear grids, `.vtu`, `.vts` and `.vtr`, images,
//! `.vti`, and lists of such files, `.pvtu`, `.pvts`, `.pvtr`, `.pvti` and `.vtm`.
//!
//! *VTK XML Formats*, the VTK documentation. Read are all four encodings
//! (appended raw, which ParaView writes by default, appended base64, inline
//! base64, ASCII), uncompressed or compressed with zlib, LZ4 or LZMA (feature `lzma`, on by default), with 32- and
//! 64-bit headers, in both byte orders and with numbers of any type. Pieces
//! become one mesh and keep their own points. Cells that `vtkGhostType` marks as
//! duplicate or hidden, or that touch a hidden point, are left out. Of several
//! time steps the first is read. The XML may be UTF-8 or, where it says so, ISO-8859-1 or
//! windows-1252.
//!
//! A vector field is its magnitude and its components, which have the file's names
//! (`ComponentName0`…) or numbers: `Velocity-magnitude`, `Velocity-0`, `stress-XY`.
//! Fields are decoded when they are asked for.
//!
//! Polyhedra are read in both layouts, a list of faces for each cell and, since VTK 9.4, faces
//! by number, and become tetrahedra. Each gets a point at the mean of its corners, where fields
//! have the mean of the corners' values; notes count the cells, and those that overlap because
//! they are not star-shaped about that point.
//!
//! A structured grid is a mesh of hexahedra. So is a rectilinear one, unless its coordinates
//! are evenly spaced to the rounding of their numbers, or to a ten-thousandth of a step: then
//! it is read as an image. Pieces cover the whole extent; they share their points as other
//! pieces do.
//!
//! The pieces that a `.pvtu` file lists become one mesh, as the pieces of one file do, with
//! the fields that all of them have; so do those of `.pvts` and `.pvtr` files, and those of
//! `.pvti` files one image. They fill the whole extent; where they overlap, later ones count.
//!
//! The meshes among the blocks of a `.vtm` file, nested or not, become one mesh, too;
//! a field is NaN in blocks that lack it, and blocks that are something else
//! or have no volume are left out. Points of pieces that lie at exactly the same place make
//! neighbors of the cells there. Notes say what was left out and how many points met.
//!
//! An image's samples keep their type; `Origin`, `Spacing` and `Direction` say where they
//! lie, and its pieces become one grid. Hidden points are NaN. Large ones that are appended
//! raw and in one piece stay in their file.

mod blocks;
mod decode;
mod document;
mod encoding;
mod faces;
mod image;
mod listed;
mod stored;
pub(crate) mod structured;
mod write;
#[cfg(feature = "lzma")]
mod xz;

use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

pub use self::write::{check_path, write_vtu};

pub(crate) use self::document::Image;
pub(crate) use self::document::{Attributes, attributes, line, version};
pub(crate) use self::encoding::to_utf8;
pub(crate) use self::image::{Box3, ImageArray, ImageFields};
pub(crate) use self::listed::Listed;

use self::decode::Decoder;
use self::document::{ArrayElement, Document, Piece};
use self::stored::{File, Stored};
use crate::MeshData;
use crate::fields::Numbers;
use crate::grid::GridData;
use crate::grid::number::Number;
use crate::pieces::{self, Budget, EachIndices, Faces, Fields, PieceArray, Role};
use crate::read::FileData;
use crate::source::Source;

/// Reads a `.vtu`, `.vts`, `.vtr` or `.vti` file, or the files that a `.pvtu`, `.pvts`, `.pvtr`,
/// `.pvti` or `.vtm` file names.
pub(crate) fn read(source: Source) -> Result<FileData, Error> {
    let source = Arc::new(to_utf8(source)?);
    if let Some(kind) = listed::Kind::of(&source) {
        return listed::read(source, kind);
    }
    let document = Document::parse(&source)?;
    let files = [Opened::new(&source, &document, None)];
    match (&document.image, &document.structure) {
        (Some(image), _) => image::read(&source, &files, image).map(FileData::Grid),
        (_, Some(structure)) => structured::read(&source, &files, structure),
        _ => read_mesh(&source, &files, Fields::Common).map(FileData::Mesh),
    }
}

/// The fields of a `.vti` file of which this is the beginning, left where they are if each
/// stands there as it is and takes more than `above` bytes.
///
/// `None` for others, which [`read`] reads, or refuses with more to say.
pub(crate) fn stream(head: &Source, above: u64) -> Result<Option<GridData>, Error> {
    match Document::parse(head) {
        Ok(document) => image::stream(head, &document, above),
        Err(_) => Ok(None),
    }
}

/// A file whose pieces become parts of a mesh.
struct Opened<'a> {
    source: &'a Arc<Source>,
    document: &'a Document<'a>,
    decoder: Decoder<'a>,
    arrays: Arc<File>,
    /// Its name in the file that lists it.
    name: Option<&'a str>,
}

impl<'a> Opened<'a> {
    fn new(
        source: &'a Arc<Source>,
        document: &'a Document<'a>,
        name: Option<&'a str>,
    ) -> Opened<'a> {
        let decoder = Decoder::new(source, document);
        Opened {
            arrays: File::new(source, document, &decoder),
            source,
            document,
            decoder,
            name,
        }
    }
}

/// A piece and its file.
#[derive(Clone, Copy)]
struct Part<'a> {
    file: &'a Opened<'a>,
    piece: &'a Piece<'a>,
}

/// Reads a file that is a part of a mesh. Perhaps it has no cells.
pub(crate) fn read_part(source: Source) -> Result<MeshData, Error> {
    let source = Arc::new(to_utf8(source)?);
    let what = match listed::file_type(&source).as_deref() {
        Some("UnstructuredGrid" | "StructuredGrid" | "RectilinearGrid") => None,
        Some(kind) => Some(format!("a piece of a mesh holds a {kind}, which cannot be")),
        None => Some("a piece of a mesh is not a VTK XML file".into()),
    };
    if let Some(what) = what {
        return Err(source.error_with_help("byte 0", what, "pieces are .vtu, .vts or .vtr files"));
    }
    let document = Document::parse(&source)?;
    let files = [Opened::new(&source, &document, None)];
    let mut data = join_files(Role::Part, &source, &files, Fields::Common)?;
    data.files.push(source.path.clone());
    Ok(data)
}

/// Joins the pieces of `files` to a mesh. `source` is the file that was asked for.
fn read_mesh(source: &Source, files: &[Opened], fields: Fields) -> Result<MeshData, Error> {
    join_files(Role::Whole, source, files, fields)
}

fn join_files(
    role: Role,
    source: &Source,
    files: &[Opened],
    fields: Fields,
) -> Result<MeshData, Error> {
    let mut data = MeshData::default();
    for note in files.iter().flat_map(|file| &file.document.notes) {
        if !data.notes.contains(note) {
            data.notes.push(note.clone());
        }
    }
    let steps = files.iter().map(|file| file.document.time_steps).max();
    if let Some(steps @ 2..) = steps {
        data.notes.push(format!(
            "the file holds {steps} time steps: the first is read"
        ));
    }
    let bytes = files.iter().map(|file| file.source.bytes.len() as u64);
    let is_rectilinear = files.iter().any(Opened::is_rectilinear);
    let budget = Budget::new(source.path.clone(), bytes.sum(), is_rectilinear);
    let parts = files.iter().flat_map(Opened::parts);
    pieces::join_as(role, &budget, parts.collect(), fields, data)
}

impl Opened<'_> {
    fn parts(&self) -> impl Iterator<Item = Part<'_>> {
        let pieces = self.document.pieces.iter();
        pieces.map(|piece| Part { file: self, piece })
    }

    fn is_rectilinear(&self) -> bool {
        let structure = self.document.structure;
        structure.is_some_and(|structure| structure.rectilinear)
    }
}

impl<'a> Part<'a> {
    /// An array of the cells.
    fn topology(&self, name: &str) -> Result<&'a ArrayElement<'a>, Error> {
        let is_it = |array: &&ArrayElement| array.name.eq_ignore_ascii_case(name);
        let found = self.piece.topology.iter().find(is_it);
        found.ok_or_else(|| self.error("<Cells>", format!("there is no array '{name}'")))
    }

    fn elements(&self, association: Association) -> &'a [ArrayElement<'a>] {
        match association {
            Association::Point => &self.piece.point_data,
            Association::Cell => &self.piece.cell_data,
        }
    }

    fn error(&self, at: &str, what: impl Into<String>) -> Error {
        self.file.source.error(at, what)
    }
}

impl pieces::Piece for Part<'_> {
    fn name(&self) -> Option<&str> {
        self.file.name
    }

    fn points(&self) -> u64 {
        self.piece.points
    }

    fn cells(&self) -> u64 {
        self.piece.cells
    }

    fn dimensions(&self) -> Option<[u64; 3]> {
        let structure = self.file.document.structure.as_ref();
        structure.map(|_| structured::dimensions(&self.piece.extent).unwrap_or_default())
    }

    fn types(&self, each: EachIndices) -> Result<(), Error> {
        let types = self.topology("types")?;
        self.file
            .decoder
            .each_indices(types, self.piece.cells, each)
    }

    fn ends(&self) -> Result<Vec<u64>, Error> {
        let ends = self.topology("offsets")?;
        self.file.decoder.indices(ends, self.piece.cells)
    }

    fn connectivity(&self, length: u64, each: EachIndices) -> Result<(), Error> {
        let connectivity = self.topology("connectivity")?;
        self.file.decoder.each_indices(connectivity, length, each)
    }

    fn faces(&self, budget: &Budget, kinds: &[u8]) -> Result<Faces, Error> {
        faces::read(budget, self.file, self.piece, kinds)
    }

    fn each_coordinate(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let Opened {
            source, decoder, ..
        } = self.file;
        if self.file.is_rectilinear() {
            return structured::each_coordinate(source, decoder, self.piece, each);
        }
        let coordinates = self.piece.coordinates.first();
        let coordinates =
            coordinates.ok_or_else(|| self.error("<Points>", "the piece has no points"))?;
        if coordinates.components != 3 {
            let components = coordinates.components;
            let what = format!("points have {components} components, not 3");
            return Err(self.error("<Points>", what));
        }
        decoder.each_float(coordinates, self.piece.points, each)
    }

    fn arrays(&self, association: Association) -> Vec<PieceArray<'_>> {
        let active = self.piece.active(association);
        let elements = self.elements(association).iter();
        let arrays = elements.map(|element| PieceArray {
            name: &element.name,
            components: element.components,
            component_names: &element.component_names,
            active: active == Some(element.name.as_str()),
            // Bytes, three or four at a time, are colors nearly always.
            colors: element.kind == Number::U8 && matches!(element.components, 3 | 4),
        });
        arrays.collect()
    }

    fn numbers(&self, association: Association, array: usize) -> Arc<dyn Numbers> {
        let tuples = match association {
            Association::Point => self.piece.points,
            Association::Cell => self.piece.cells,
        };
        let element = &self.elements(association)[array];
        Arc::new(Stored::new(&self.file.arrays, (element, tuples)))
    }

    fn is_before_vtk_9(&self) -> bool {
        self.file.document.version < [2, 1]
    }

    fn error(&self, at: &str, what: String) -> Error {
        Part::error(self, at, what)
    }
}
