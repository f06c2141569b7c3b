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

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::Error;
use tetrascope_core::glam;
use tetrascope_core::mesh::{Association, volume_corners};

pub use self::write::{check_path, write_vtu};

pub(crate) use self::document::{attributes, line};
pub(crate) use self::encoding::to_utf8;

use self::decode::Decoder;
use self::document::{ArrayElement, Document, Piece};
use self::stored::{File, Stored};
use crate::MeshData;
use crate::fields::{Array, GHOSTS, Numbers, take_ghosts};
use crate::grid::GridData;
use crate::grid::number::Number;
use crate::polyhedra::POLYHEDRON;
use crate::read::{FileData, check};
use crate::source::{Source, count, reserve, room};

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

/// Which arrays of several pieces become fields.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fields {
    /// Those that all pieces have: they are parts of one mesh.
    Common,
    /// All, NaN where a piece has none: the pieces are meshes of their own. Those without
    /// volume are left out.
    All,
}

/// Joins the pieces of `files` to a mesh. `source` is the file that was asked for.
fn read_mesh(source: &Source, files: &[Opened], fields: Fields) -> Result<MeshData, Error> {
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
    // Pieces without cells add nothing, and their arrays are often absent.
    let pieces = |file| pieces(file).filter(|part| part.piece.cells > 0);
    let mut parts: Vec<Part> = files.iter().flat_map(pieces).collect();
    let budget = Budget::of(source, files);
    let points = read_cells(&budget, &mut parts, fields, &mut data)?;
    let joined = data.notes.len();
    let kept = keep_points(&budget, points, &mut data)?;
    read_points(&parts, kept.as_deref(), &mut data)?;
    let mut arrays = find_arrays(&parts, fields, &mut data);
    if let Some(kept) = kept {
        for array in &mut arrays {
            if array.association == Association::Point {
                array.tuples = kept.len();
                array.numbers = kept_numbers(array.numbers.clone(), array.components, &kept);
            }
        }
    }
    check(&source.path, &data, &arrays)?;
    let ghosts = take_ghosts(&mut arrays);
    data.remove_ghosts(source, &ghosts)?;
    if let Some(polyhedra) = data.polyhedra.take() {
        polyhedra.split(&source.path, &mut data, budget.bytes())?;
    }
    if parts.len() > 1 {
        let pieces = count(parts.len() as u64, "piece");
        let note = match data.coincident_points() {
            0 => format!("{pieces} joined"),
            points => format!(
                "{pieces} joined: {} where others are, and neighbors share faces there",
                match points {
                    1 => "1 point lies exactly".into(),
                    _ => format!("{points} points lie exactly"),
                }
            ),
        };
        data.notes.insert(joined, note);
    }
    data.add_fields(arrays)?;
    Ok(data)
}

fn pieces<'a>(file: &'a Opened<'a>) -> impl Iterator<Item = Part<'a>> {
    let pieces = file.document.pieces.iter();
    pieces.map(move |piece| Part { file, piece })
}

/// The most bytes that points and cells of rectilinear grids may take, which files only imply:
/// as many as samples of packed grids.
pub(crate) fn most_implied(file_bytes: u64) -> u64 {
    (1 << 30) + 64 * file_bytes
}

/// The most bytes that points and cells may take in memory.
///
/// Cells that differ do not compress well: an index that changes takes a byte and more of
/// a compressed file, so that a cell of 41 bytes in memory takes 2.6 or more in the file.
/// Thirty-two times the files thus refuses only cells that repeat each other thousands of
/// times, in a file that is damaged or made to take all memory.
struct Budget<'a> {
    /// What errors are about.
    source: &'a Source,
    /// Of all files.
    file_bytes: u64,
    /// Whether some points and cells are only implied.
    implied: bool,
}

impl<'a> Budget<'a> {
    fn of(source: &'a Source, files: &[Opened]) -> Budget<'a> {
        let bytes = files.iter().map(|file| file.source.bytes.len() as u64);
        let is_rectilinear = |file: &Opened| {
            let structure = file.document.structure;
            structure.is_some_and(|structure| structure.rectilinear)
        };
        Budget {
            source,
            file_bytes: bytes.sum(),
            implied: files.iter().any(is_rectilinear),
        }
    }

    fn bytes(&self) -> u64 {
        match self.implied {
            true => most_implied(self.file_bytes),
            false => (32 << 20) + 32 * self.file_bytes,
        }
    }

    /// Whether so many cells with so many indices are within it.
    fn check(&self, cells: u64, indices: u64) -> Result<(), Error> {
        let bytes = cells
            .saturating_mul(9)
            .saturating_add(indices.saturating_mul(8));
        if bytes <= self.bytes() {
            return Ok(());
        }
        let cells = count(cells, "cell");
        Err(self.error("<Cells>", &format!("{cells} with {indices} points")))
    }

    /// There are more of something than there can be.
    fn error(&self, at: &str, many: &str) -> Error {
        self.source.error_with_help(
            at,
            format!(
                "{many}: so many different ones cannot be in {} bytes",
                self.file_bytes
            ),
            "the file is damaged; write it again",
        )
    }
}

/// Reads the cells of all parts; returns how many points these have. Where all fields are
/// read, parts without volume are left out.
fn read_cells(
    budget: &Budget,
    parts: &mut Vec<Part>,
    fields: Fields,
    data: &mut MeshData,
) -> Result<u64, Error> {
    let mut points = 0_u64;
    data.cells.offsets.push(0);
    let mut flat = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let cells = data.cells.types.len();
        append_cells(budget, part, points, data)?;
        let is_flat = data.cells.types[cells..]
            .iter()
            .all(|kind| volume_corners(*kind).is_none() && *kind != POLYHEDRON);
        // Polyhedra are volumes, so that none is counted here.
        if fields == Fields::All && is_flat {
            data.cells.types.truncate(cells);
            data.cells.offsets.truncate(cells + 1);
            let end = *data.cells.offsets.last().expect("it begins with 0");
            data.cells.connectivity.truncate(end as usize);
            let name = part.file.name.unwrap_or_default();
            let note = format!("'{name}' left out: it has no cells with a volume");
            data.notes.push(note);
            flat.push(i);
            continue;
        }
        points = points
            .checked_add(part.piece.points)
            .filter(|&all| i64::try_from(all).is_ok())
            .ok_or_else(|| {
                let source = part.file.source;
                source.error("<Piece>", format!("{} points cannot be", part.piece.points))
            })?;
    }
    let mut number = 0..;
    parts.retain(|_| {
        number
            .next()
            .is_some_and(|i| flat.binary_search(&i).is_err())
    });
    Ok(points)
}

/// Reads the cells of a part whose points begin at number `first`.
fn append_cells(
    budget: &Budget,
    &Part { file, piece }: &Part,
    first: u64,
    data: &mut MeshData,
) -> Result<(), Error> {
    let cells = &mut data.cells;
    let Opened {
        source, decoder, ..
    } = file;
    let check_budget = |cells, indices| budget.check(cells, indices);
    if file.document.structure.is_some() {
        let indices = piece.cells.saturating_mul(8);
        check_budget(
            (cells.types.len() as u64).saturating_add(piece.cells),
            (cells.connectivity.len() as u64).saturating_add(indices),
        )?;
        return structured::append_cells(piece, first, cells);
    }
    let named = |name: &str| -> Result<&ArrayElement, Error> {
        piece
            .topology
            .iter()
            .find(|array| array.name.eq_ignore_ascii_case(name))
            .ok_or_else(|| source.error("<Cells>", format!("there is no array '{name}'")))
    };
    // Text takes a digit and a blank for each number, so that it needs no such bound.
    let (all_cells, all_indices) = (
        (cells.types.len() as u64).saturating_add(piece.cells),
        cells.connectivity.len() as u64,
    );
    check_budget(all_cells, all_indices)?;
    let first_cell = cells.types.len();
    decoder.each_indices(named("types")?, piece.cells, &mut |kinds| {
        for &kind in kinds {
            let cell = cells.types.len() - first_cell;
            let kind = u8::try_from(kind).map_err(|_| {
                source.error(
                    "array 'types'",
                    format!("cell {cell} is of type {kind}, and VTK has none above 255"),
                )
            })?;
            cells.types.push(kind);
        }
        Ok(())
    })?;
    // VTK writes where each cell ends; the last end is the length of the connectivity.
    let ends = decoder.indices(named("offsets")?, piece.cells)?;
    let length = ends.last().copied().unwrap_or(0);
    check_budget(all_cells, all_indices.saturating_add(length))?;
    let start = cells.connectivity.len() as u64;
    reserve(&mut cells.offsets, ends.len())?;
    for (cell, end) in ends.into_iter().enumerate() {
        if end > length {
            return Err(source.error(
                "array 'offsets'",
                format!("cell {cell} ends at {end}, after the last of {length} points of cells"),
            ));
        }
        cells.offsets.push(start + end);
    }
    decoder.each_indices(named("connectivity")?, length, &mut |indices| {
        let done = cells.connectivity.len() as u64 - start;
        if done == 0 {
            reserve(&mut cells.connectivity, length as usize)?;
        }
        if indices.iter().any(|&point| point >= piece.points) {
            let (i, point) = (done..)
                .zip(indices)
                .find(|(_, point)| **point >= piece.points)
                .expect("found above");
            return Err(source.error(
                "array 'connectivity'",
                format!(
                    "value {i} is point {point}, but the piece has {}",
                    count(piece.points, "point")
                ),
            ));
        }
        let joined = indices.iter().map(|point| first + point);
        cells.connectivity.extend(joined);
        Ok(())
    })?;
    match cells.types[first_cell..].contains(&POLYHEDRON) {
        true => faces::read(budget, file, piece, (first, first_cell), data),
        false => Ok(()),
    }
}

/// If all points would take more memory than there is reason for, those that cells use, in
/// ascending order; cells then count only them.
fn keep_points(
    budget: &Budget,
    points: u64,
    data: &mut MeshData,
) -> Result<Option<Arc<[u64]>>, Error> {
    const POINT: u64 = size_of::<DVec3>() as u64;
    let indices = &mut data.cells.connectivity;
    let cells = 9 * data.cells.types.len() as u64 + 8 * indices.len() as u64;
    let for_points = budget.bytes().saturating_sub(cells);
    if points.saturating_mul(POINT) <= for_points {
        return Ok(None);
    }
    let mut used: Vec<u64> = room(indices.len())?;
    used.extend_from_slice(indices);
    used.sort_unstable();
    used.dedup();
    if used.len() as u64 * POINT > for_points {
        return Err(budget.error("<Points>", &format!("{} points", used.len())));
    }
    for index in indices {
        *index = used.partition_point(|&point| point < *index) as u64;
    }
    data.notes.push(format!(
        "{} left out: no cell uses them",
        count(points - used.len() as u64, "point")
    ));
    Ok(Some(used.into()))
}

/// Reads the points of all parts, or those of them whose numbers are in `kept`.
fn read_points(parts: &[Part], kept: Option<&[u64]>, data: &mut MeshData) -> Result<(), Error> {
    let all = parts.iter().map(|part| part.piece.points).sum::<u64>();
    // Either is within the budget.
    data.points = room(kept.map_or(all as usize, <[u64]>::len))?;
    let mut kept = kept.map(|kept| kept.iter().copied().peekable());
    let (mut point, mut filled, mut number) = ([0.0; 3], 0, 0);
    for &Part { file, piece } in parts {
        let Opened {
            source, decoder, ..
        } = file;
        let points = &mut data.points;
        let mut add = |value| {
            point[filled] = value;
            filled += 1;
            if filled < 3 {
                return;
            }
            filled = 0;
            let is_kept = kept
                .as_mut()
                .is_none_or(|kept| kept.next_if_eq(&number).is_some());
            if is_kept {
                points.push(DVec3::from_array(point));
            }
            number += 1;
        };
        let structure = file.document.structure;
        if structure.is_some_and(|structure| structure.rectilinear) {
            structured::each_coordinate(source, decoder, piece, &mut add)?;
            continue;
        }
        let coordinates = piece
            .coordinates
            .first()
            .ok_or_else(|| source.error("<Points>", "the piece has no points"))?;
        if coordinates.components != 3 {
            return Err(source.error(
                "<Points>",
                format!("points have {} components, not 3", coordinates.components),
            ));
        }
        decoder.each_float(coordinates, piece.points, &mut add)?;
    }
    Ok(())
}

/// The most arrays that are filled up where a piece has none.
const MOST_FILLED: usize = 1000;

/// The point and cell data of the parts.
fn find_arrays(parts: &[Part], fields: Fields, data: &mut MeshData) -> Vec<Array> {
    let mut arrays = Vec::new();
    let mut filled = 0;
    for association in [Association::Point, Association::Cell] {
        let tuples = |part: &Part| match association {
            Association::Point => part.piece.points,
            Association::Cell => part.piece.cells,
        };
        for twins in twins(parts, association) {
            let (first, element) = twins[0];
            let name = match element.name.as_str() {
                "" => {
                    let mut among = elements(parts[first].piece, association).iter();
                    let number = among.position(|other| std::ptr::eq(other, element));
                    format!("unnamed-{}", number.unwrap_or_default())
                }
                name => name.to_owned(),
            };
            let is_ghost = GHOSTS.contains(&element.name.as_str());
            if twins.len() < parts.len() && !is_ghost {
                // The first part without it is where the numbers of those with it part from
                // the natural ones.
                let mut numbers = twins.iter().zip(0..);
                let lacking = numbers.find(|((part, _), number)| part != number);
                let lacking = lacking.map_or(twins.len(), |(_, number)| number);
                let why = match parts[lacking].file.name {
                    Some(file) => format!("'{file}' has no such array"),
                    None => format!("piece {} of {} has no such array", lacking + 1, parts.len()),
                };
                let components = count(element.components, "component");
                filled += 1;
                if fields == Fields::Common || filled > MOST_FILLED {
                    let why = format!("{why} of {components}");
                    data.notes
                        .push(format!("array '{}' left out: {why}", element.name));
                    data.left_out.push((element.name.clone(), why));
                    continue;
                }
                let lack = parts.len() - twins.len();
                data.notes.push(format!(
                    "'{name}' is NaN in {lack} of {} pieces, which have no such array",
                    parts.len()
                ));
            }
            let active = parts[first].piece.active(association);
            arrays.push(Array {
                name,
                association,
                components: element.components as usize,
                component_names: element.component_names.clone(),
                tuples: parts.iter().map(tuples).sum::<u64>() as usize, // counted
                numbers: Arc::new(Chain::new(parts, &twins, tuples, is_ghost)),
                active: active == Some(element.name.as_str()),
                // Bytes, three or four at a time, are colors nearly always.
                colors: element.kind == Number::U8 && matches!(element.components, 3 | 4),
            });
        }
    }
    arrays
}

/// Arrays of one name and number of components: the number of a part, and its array.
type Twins<'a> = Vec<(usize, &'a ArrayElement<'a>)>;

/// The arrays of all parts, those with one name together, in the order in which they come.
fn twins<'a>(parts: &[Part<'a>], association: Association) -> Vec<Twins<'a>> {
    let mut known: HashMap<(&str, u64, usize), usize> = HashMap::new();
    let mut all: Vec<Twins> = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        // Arrays without a name are told apart by their order.
        let mut unnamed = 0;
        for element in elements(part.piece, association) {
            let name = element.name.as_str();
            unnamed += usize::from(name.is_empty());
            let order = if name.is_empty() { unnamed } else { 0 };
            let at = *known
                .entry((name, element.components, order))
                .or_insert(all.len());
            match all.get_mut(at) {
                None => all.push(vec![(number, element)]),
                Some(twins) => twins.push((number, element)),
            }
        }
    }
    all
}

/// The numbers of the same array of several parts, one after the other.
#[derive(Debug)]
struct Chain(Vec<Link>);

#[derive(Debug)]
enum Link {
    Stored(Stored),
    /// So many times the same, where parts have no such array.
    Same(u64, f64),
}

impl Chain {
    /// `tuples` counts those of a part. Without ghosts, all are one's own: 0.
    fn new(parts: &[Part], twins: &Twins, tuples: impl Fn(&Part) -> u64, is_ghost: bool) -> Chain {
        let filler = if is_ghost { 0.0 } else { f64::NAN };
        let components = twins[0].1.components;
        let mut links = Vec::new();
        let fill = |links: &mut Vec<Link>, parts: &[Part]| {
            let missing = parts.iter().map(&tuples).sum::<u64>();
            if missing > 0 {
                links.push(Link::Same(missing * components, filler));
            }
        };
        let mut done = 0;
        for &(part, element) in twins {
            fill(&mut links, &parts[done..part]);
            let here = (element, tuples(&parts[part]));
            let stored = Stored::new(&parts[part].file.arrays, std::iter::once(here));
            links.push(Link::Stored(stored));
            done = part + 1;
        }
        fill(&mut links, &parts[done..]);
        Chain(links)
    }
}

impl Numbers for Chain {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        for link in &self.0 {
            match link {
                Link::Stored(stored) => stored.each(each)?,
                Link::Same(count, value) => (0..*count).for_each(|_| each(*value)),
            }
        }
        Ok(())
    }
}

fn elements<'p>(piece: &'p Piece, association: Association) -> &'p [ArrayElement<'p>] {
    match association {
        Association::Point => &piece.point_data,
        Association::Cell => &piece.cell_data,
    }
}

/// The numbers of those tuples of an array whose numbers are in `tuples`, ascending.
pub(crate) fn kept_numbers(
    numbers: Arc<dyn Numbers>,
    components: usize,
    tuples: &Arc<[u64]>,
) -> Arc<dyn Numbers> {
    Arc::new(Kept {
        numbers,
        components,
        tuples: tuples.clone(),
    })
}

/// See [`kept_numbers`].
#[derive(Debug)]
struct Kept {
    numbers: Arc<dyn Numbers>,
    components: usize,
    /// Which tuples, in ascending order.
    tuples: Arc<[u64]>,
}

impl Numbers for Kept {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut kept = self.tuples.iter().peekable();
        let (mut tuple, mut component) = (0, 0);
        self.numbers.each(&mut |value| {
            if kept.peek() == Some(&&tuple) {
                each(value);
            }
            component += 1;
            if component == self.components {
                kept.next_if_eq(&&tuple);
                component = 0;
                tuple += 1;
            }
        })
    }
}
