//! The samples of a `.vti` file, and of those that a `.pvti` file lists.

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::mesh::Association;

use super::document::{ArrayElement, Compressor, Data, Document, Image, Piece};
use super::{Opened, Part, pieces};
use crate::grid::ghosts::Ghosts;
use crate::grid::number::Numbers;
use crate::grid::{self, Entries, GridData, GridField, RawFile, split};
use crate::source::{Source, count, read_at};

/// Reads all fields of the pieces of `files`, which make `image`; `source` is the file that was
/// asked for. Cell data become samples at the cells' centers that fill their cells.
pub(super) fn read(source: &Source, files: &[Opened], image: &Image) -> Result<GridData, Error> {
    let mut data = GridData {
        fields: Vec::new(),
        space: None,
        notes: Vec::new(),
        files: Vec::new(),
    };
    for note in files.iter().flat_map(|file| &file.document.notes) {
        if !data.notes.contains(note) {
            data.notes.push(note.clone());
        }
    }
    // Programs write empty pieces, too.
    let has_points = |part: &Part| {
        let points = Box3::of(&part.piece.extent, Association::Point);
        points.and_then(|points| points.count()) != Some(0)
    };
    let parts: Vec<Part> = files.iter().flat_map(pieces).filter(has_points).collect();
    let mut ghosts = Ghosts::default();
    if parts.len() > 1 {
        let pieces = count(parts.len() as u64, "piece");
        data.notes.push(format!("{pieces} joined"));
    }
    for association in [Association::Point, Association::Cell] {
        let whole = Box3::of(&image.extent, association);
        let whole = whole.ok_or_else(|| {
            source.error(
                "<ImageData>",
                format!("the extent {:?} is empty", image.extent),
            )
        })?;
        read_fields(
            source,
            &parts,
            (image, &whole, association),
            (&mut data, &mut ghosts),
        )?;
    }
    ghosts.hide(&mut data);
    if data.fields.is_empty() {
        return Err(source.error("<ImageData>", "the image has no field of numbers"));
    }
    Ok(data)
}

/// See [`super::stream`].
pub(super) fn stream(
    head: &Source,
    document: &Document,
    above: u64,
) -> Result<Option<GridData>, Error> {
    let (Some(image), [piece], Some(appended)) =
        (&document.image, &document.pieces[..], document.appended)
    else {
        return Ok(None);
    };
    let whole = Box3::of(&image.extent, Association::Point);
    let of_piece = Box3::of(&piece.extent, Association::Point);
    let plain = appended.raw && document.compressor == Compressor::None;
    let (Some(whole), true, true) = (whole, plain, piece.cell_data.is_empty()) else {
        return Ok(None);
    };
    let mut notes = document.notes.clone();
    let lattice = lattice(image, &whole, Association::Point, &mut notes);
    let (Some(points), Ok(lattice)) = (whole.count(), lattice) else {
        return Ok(None);
    };
    let start = (head.bytes.len() - appended.bytes.len()) as u64;
    let mut fields = Vec::new();
    for element in &piece.point_data {
        let (Some(sample_type), &Data::Appended(offset)) =
            (element.kind.sample_type(), &element.data)
        else {
            return Ok(None);
        };
        let bytes = points as u64 * element.kind.size() as u64;
        let hides = element.name == "vtkGhostType";
        if hides || element.components != 1 || bytes <= above || of_piece != Some(whole) {
            return Ok(None);
        }
        let Some(at) = start.checked_add(offset) else {
            return Ok(None);
        };
        let width = if document.wide_headers { 8 } else { 4 };
        let header = read_at(&head.path, at, width)?;
        let length = match (header.len(), width) {
            (8, 8) => document.endian.u64(&header),
            (4, 4) => document.endian.u32(&header).into(),
            _ => return Ok(None),
        };
        if length != bytes {
            return Ok(None);
        }
        let order = document.endian.into();
        let data = at + width as u64;
        let file = RawFile::open(&head.path, data, lattice, sample_type, order)?;
        let active = piece.active(Association::Point) == Some(element.name.as_str());
        fields.push((!active, element.name.clone(), file));
    }
    fields.sort_by_key(|(later, ..)| *later); // stable
    let fields = fields.into_iter().map(|(_, name, file)| (name, file));
    GridData::streamed(head, fields, notes)
}

/// A box of points or cells.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Box3 {
    low: [i64; 3],
    size: [usize; 3],
}

impl Box3 {
    /// `None` if it is empty or has more than can be counted.
    fn of(extent: &[i64; 6], association: Association) -> Option<Box3> {
        let more = match association {
            Association::Point => 1,
            Association::Cell => 0,
        };
        let mut size = [0; 3];
        for axis in 0..3 {
            let difference = extent[2 * axis + 1].checked_sub(extent[2 * axis])?;
            size[axis] = usize::try_from(difference.checked_add(more)?).ok()?;
        }
        let low = [extent[0], extent[2], extent[4]];
        let found = Box3 { low, size };
        found.count().map(|_| found)
    }

    fn count(&self) -> Option<usize> {
        let count = self.size.iter().try_fold(1usize, |n, s| n.checked_mul(*s));
        count.filter(|n| n.checked_mul(8).is_some())
    }

    /// Where this box begins in `whole`, if it lies inside.
    fn within(&self, whole: &Box3) -> Option<[usize; 3]> {
        let mut low = [0; 3];
        for (axis, low) in low.iter_mut().enumerate() {
            let first = self.low[axis].checked_sub(whole.low[axis])?;
            *low = usize::try_from(first).ok()?;
            if low.checked_add(self.size[axis])? > whole.size[axis] {
                return None;
            }
        }
        Some(low)
    }
}

fn arrays<'a>(piece: &'a Piece<'a>, association: Association) -> &'a [ArrayElement<'a>] {
    match association {
        Association::Point => &piece.point_data,
        Association::Cell => &piece.cell_data,
    }
}

fn read_fields(
    source: &Source,
    parts: &[Part],
    (image, whole, association): (&Image, &Box3, Association),
    (data, ghosts): (&mut GridData, &mut Ghosts),
) -> Result<(), Error> {
    let Some(first) = parts.first().map(|part| part.piece) else {
        return Err(source.error("<ImageData>", "the image has no <Piece>"));
    };
    if arrays(first, association).is_empty() {
        return Ok(());
    }
    let lattice = match lattice(image, whole, association, &mut data.notes) {
        Ok(lattice) => lattice,
        Err(error) if association == Association::Cell => {
            data.notes.push(format!("cell data left out: {error}"));
            return Ok(());
        }
        Err(error) => return Err(source.error("<ImageData>", error.to_string())),
    };
    let mut fields: Vec<(bool, GridField)> = Vec::new();
    for (i, element) in arrays(first, association).iter().enumerate() {
        let name = match element.name.as_str() {
            "" => format!("unnamed-{i}"),
            name => name.to_owned(),
        };
        let numbers = join(parts, (whole, association), i)?;
        if name == "vtkGhostType" && element.components == 1 {
            match association {
                Association::Point => ghosts.points = Some(numbers),
                Association::Cell => ghosts.cells = Some(numbers),
            }
            continue;
        }
        let active = first.active(association) == Some(element.name.as_str());
        let components = element.components as usize;
        let entries = Entries::of_bytes(element.kind, components);
        for field in split(&name, numbers, components, entries, &mut data.notes) {
            fields.push((!active, field.on(lattice, association)));
        }
    }
    fields.sort_by_key(|(later, _)| *later); // stable
    data.fields
        .extend(fields.into_iter().map(|(_, field)| field));
    Ok(())
}

/// Where the samples lie.
fn lattice(
    image: &Image,
    whole: &Box3,
    association: Association,
    notes: &mut Vec<String>,
) -> Result<Lattice, Error> {
    let (half, interpolation) = match association {
        Association::Point => (0.0, Interpolation::Linear),
        Association::Cell => (0.5, Interpolation::Nearest),
    };
    let first = DVec3::from_array(whole.low.map(|low| low as f64 + half));
    let direction = image.direction;
    let axes = [
        direction.x_axis * image.spacing.x,
        direction.y_axis * image.spacing.y,
        direction.z_axis * image.spacing.z,
    ];
    let origin = image.origin + direction * (image.spacing * first);
    grid::axes::lattice(whole.size, origin, axes, [0.0; 3], interpolation, notes)
}

/// The numbers of array `index` of all pieces.
fn join(
    parts: &[Part],
    (whole, association): (&Box3, Association),
    index: usize,
) -> Result<Numbers, Error> {
    let first = &arrays(parts[0].piece, association)[index];
    let mut runs = Vec::new();
    for Part { file, piece } in parts {
        let wrong = |what: String| file.source.error("<Piece>", what);
        let part = Box3::of(&piece.extent, association);
        let place = part.and_then(|part| Some((part, part.within(whole)?, part.count()?)));
        let (part, low, points) = place
            .ok_or_else(|| wrong(format!("the extent {:?} is not in the whole", piece.extent)))?;
        let element = arrays(piece, association)
            .iter()
            .find(|e| e.name == first.name && e.components == first.components)
            .ok_or_else(|| wrong(format!("a piece has no array '{}'", first.name)))?;
        runs.push((part, low, file.decoder.numbers(element, points as u64)?));
    }
    if let [(part, _, _)] = &runs[..]
        && part == whole
    {
        let (_, _, numbers) = runs.remove(0);
        return Ok(numbers);
    }
    let wrong = |what: String| parts[0].file.source.error("<Piece>", what);
    let points = whole.count().unwrap_or(usize::MAX);
    let missing = |covered: usize| {
        wrong(format!(
            "pieces with {covered} samples where {points} are needed"
        ))
    };
    // Before there is memory for all of them.
    let counts = runs.iter().filter_map(|(part, ..)| part.count());
    let most = counts.fold(0, usize::saturating_add);
    if most < points {
        return Err(missing(most));
    }
    let components = first.components as usize;
    let mut all = runs[0].2.blank(points * components);
    // Neighbors share samples, so that numbers of them alone do not tell what is missing.
    let mut covered = vec![false; points];
    for (part, low, numbers) in &runs {
        let row = part.size[0] * components;
        for i in 0..part.size[1] * part.size[2] {
            let (y, z) = (low[1] + i % part.size[1], low[2] + i / part.size[1]);
            let start = low[0] + whole.size[0] * (y + whole.size[1] * z);
            covered[start..start + part.size[0]].fill(true);
            if !all.put(start * components, numbers, i * row..(i + 1) * row) {
                return Err(wrong(format!("array '{}' changes its type", first.name)));
            }
        }
    }
    match covered.iter().filter(|covered| **covered).count() {
        all_of_them if all_of_them == points => Ok(all),
        some => Err(missing(some)),
    }
}
