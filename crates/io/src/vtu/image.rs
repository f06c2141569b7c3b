//! The samples of a `.vti` file, and of those that a `.pvti` file lists.

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::mesh::Association;

use super::document::{ArrayElement, Compressor, Data, Document, Image, Piece};
use super::{Opened, Part};
use crate::grid::ghosts::Ghosts;
use crate::grid::number::{Number, Numbers};
use crate::grid::{self, Entries, GridData, GridField, RawFile, split};
use crate::source::{Source, count, read_at};

/// Reads all fields of the pieces of `files`, which make `image`; `source` is the file that was
/// asked for. Cell data become samples at the cells' centers that fill their cells.
pub(super) fn read(source: &Source, files: &[Opened], image: &Image) -> Result<GridData, Error> {
    let mut notes: Vec<String> = Vec::new();
    for note in files.iter().flat_map(|file| &file.document.notes) {
        if !notes.contains(note) {
            notes.push(note.clone());
        }
    }
    // Programs write empty pieces, too.
    let has_points = |part: &Part| {
        let points = Box3::of(&part.piece.extent, Association::Point);
        points.and_then(|points| points.count()) != Some(0)
    };
    let parts: Vec<Part> = files
        .iter()
        .flat_map(Opened::parts)
        .filter(has_points)
        .collect();
    let mut fields = ImageFields::new(notes);
    if parts.len() > 1 {
        let pieces = count(parts.len() as u64, "piece");
        fields.notes().push(format!("{pieces} joined"));
    }
    for association in [Association::Point, Association::Cell] {
        let whole = Box3::of(&image.extent, association);
        let whole = whole.ok_or_else(|| {
            source.error(
                "<ImageData>",
                format!("the extent {:?} is empty", image.extent),
            )
        })?;
        let whole = (image, &whole, association);
        read_fields(source, &parts, whole, &mut fields)?;
    }
    let data = fields.finish();
    data.ok_or_else(|| source.error("<ImageData>", "the image has no field of numbers"))
}

/// The fields of an image, as they are read.
pub(crate) struct ImageFields {
    data: GridData,
    /// Whether each field comes later than others of its association.
    later: Vec<bool>,
    ghosts: Ghosts,
}

/// An array of an image.
pub(crate) struct ImageArray {
    pub(crate) name: String,
    pub(crate) components: usize,
    /// The file marks it as the one to draw.
    pub(crate) active: bool,
    pub(crate) kind: Number,
    pub(crate) numbers: Numbers,
}

impl ImageFields {
    pub(crate) fn new(notes: Vec<String>) -> ImageFields {
        ImageFields {
            data: GridData {
                fields: Vec::new(),
                space: None,
                notes,
                files: Vec::new(),
            },
            later: Vec::new(),
            ghosts: Ghosts::default(),
        }
    }

    pub(crate) fn notes(&mut self) -> &mut Vec<String> {
        &mut self.data.notes
    }

    /// Where the samples of an image lie, which is in `whole`; `None`, with a note, for those of
    /// cells that have no lattice.
    pub(crate) fn lattice(
        &mut self,
        image: &Image,
        whole: &Box3,
        association: Association,
    ) -> Result<Option<Lattice>, Error> {
        match lattice(image, whole, association, &mut self.data.notes) {
            Ok(lattice) => Ok(Some(lattice)),
            Err(error) if association == Association::Cell => {
                let note = format!("cell data left out: {error}");
                self.data.notes.push(note);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// Adds the fields that an array becomes.
    pub(crate) fn add(&mut self, array: ImageArray, lattice: Lattice, association: Association) {
        let ImageArray {
            name,
            components,
            active,
            kind,
            numbers,
        } = array;
        if name == "vtkGhostType" && components == 1 {
            match association {
                Association::Point => self.ghosts.points = Some(numbers),
                Association::Cell => self.ghosts.cells = Some(numbers),
            }
            return;
        }
        let entries = Entries::of_bytes(kind, components);
        for field in split(&name, numbers, components, entries, &mut self.data.notes) {
            self.data.fields.push(field.on(lattice, association));
            self.later.push(!active);
        }
    }

    /// The grid, without what is hidden; `None` if it has no field.
    pub(crate) fn finish(self) -> Option<GridData> {
        let ImageFields {
            mut data,
            later,
            ghosts,
        } = self;
        let mut fields: Vec<_> = data.fields.into_iter().zip(later).collect();
        let is_cell = |field: &GridField| field.association == Association::Cell;
        fields.sort_by_key(|(field, later)| (is_cell(field), *later)); // stable
        data.fields = fields.into_iter().map(|(field, _)| field).collect();
        ghosts.hide(&mut data);
        (!data.fields.is_empty()).then_some(data)
    }
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
pub(crate) struct Box3 {
    low: [i64; 3],
    pub(crate) size: [usize; 3],
}

impl Box3 {
    /// `None` if it is empty or has more than can be counted.
    pub(crate) fn of(extent: &[i64; 6], association: Association) -> Option<Box3> {
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

    pub(crate) fn count(&self) -> Option<usize> {
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
    fields: &mut ImageFields,
) -> Result<(), Error> {
    let Some(first) = parts.first().map(|part| part.piece) else {
        return Err(source.error("<ImageData>", "the image has no <Piece>"));
    };
    if arrays(first, association).is_empty() {
        return Ok(());
    }
    let lattice = fields.lattice(image, whole, association);
    let lattice = lattice.map_err(|error| source.error("<ImageData>", error.to_string()))?;
    let Some(lattice) = lattice else {
        return Ok(());
    };
    for (i, element) in arrays(first, association).iter().enumerate() {
        let name = match element.name.as_str() {
            "" => format!("unnamed-{i}"),
            name => name.to_owned(),
        };
        let array = ImageArray {
            numbers: join(parts, (whole, association), i)?,
            components: element.components as usize,
            active: first.active(association) == Some(element.name.as_str()),
            kind: element.kind,
            name,
        };
        fields.add(array, lattice, association);
    }
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
