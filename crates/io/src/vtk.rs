//! Legacy VTK files, `.vtk`: unstructured and structured grids and structured points,
//! ASCII and binary.
//!
//! *VTK File Formats*, the VTK documentation; versions 1.0 to 4.2 and 5.1, which
//! stores cells as offsets and connectivity. Binary numbers are big-endian.
//! Array names are decoded (`Nodal%20Stress`). A structured grid becomes
//! hexahedra, structured points a regular grid whose samples keep their type. Large binary
//! ones of one field stay in their file.

mod scanner;

use glam::DVec3;
use tetrascope_core::grid::{Lattice, Samples};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error, glam};

pub(crate) use self::scanner::parse_float;
use self::scanner::{Kind, Scanner, clip};
use crate::MeshData;
use crate::fields::{Array, take_ghosts, to_scalars};
use crate::grid::number::Number;
use crate::grid::{FieldSamples, GridData, GridField, RawFile, split};
use crate::mesh_data::add_hexahedra;
use crate::read::{FileData, check};
use crate::source::{Endian, Source, count, read_at};

/// What has been read so far.
struct Reader<'a> {
    scanner: Scanner<'a>,
    dimensions: Option<[u64; 3]>,
    points: Option<Vec<DVec3>>,
    cells: Option<Cells>,
    arrays: Vec<Array>,
    /// What the arrays that follow belong to, and how many values they have.
    data: Option<(Association, u64)>,
    /// The samples of structured points.
    image: Option<Image>,
}

/// Structured points.
struct Image {
    origin: [f64; 3],
    spacing: [f64; 3],
    /// Not those of SCALARS, name, samples, components.
    fields: Vec<(bool, String, Samples, usize)>,
    notes: Vec<String>,
}

/// Reads a legacy `.vtk` file.
pub(crate) fn read(source: &Source) -> Result<FileData, Error> {
    let mut reader = Reader::new(source);
    reader.header()?;
    while let Some(keyword) = reader.scanner.word() {
        reader.section(keyword)?;
    }
    match reader.image.take() {
        Some(image) => reader.grid(image).map(FileData::Grid),
        None => mesh(source, reader).map(FileData::Mesh),
    }
}

/// The structured points of a file of which this is the beginning, left where they are if
/// they stand there as they are, with nothing behind them, and take more than `above` bytes.
///
/// `None` for others, which [`read`] reads, or refuses with more to say.
pub(crate) fn stream(head: &Source, above: u64) -> Result<Option<GridData>, Error> {
    let mut reader = Reader::new(head);
    let Some((name, kind, points)) = reader.single_field() else {
        return Ok(None);
    };
    let start = reader.scanner.data_start();
    let (Some(image), Some(sample_type)) =
        (&reader.image, kind.number().and_then(Number::sample_type))
    else {
        return Ok(None);
    };
    let Ok((lattice, needed)) = reader.lattice(image) else {
        return Ok(None);
    };
    let end = points
        .checked_mul(sample_type.bytes() as u64)
        .filter(|bytes| points == needed && *bytes > above)
        .and_then(|bytes| bytes.checked_add(start));
    let Some(end) = end else {
        return Ok(None);
    };
    // Blank lines, and what VTK says of an array's components.
    const BEHIND: usize = 4096;
    let behind = read_at(&head.path, end, BEHIND)?;
    let text = behind.trim_ascii();
    if behind.len() == BEHIND || !(text.is_empty() || text.starts_with(b"METADATA")) {
        return Ok(None);
    }
    let file = RawFile::open(&head.path, start, lattice, sample_type, Endian::Big.into())?;
    GridData::streamed(head, std::iter::once((name, file)), Vec::new())
}

fn mesh(source: &Source, mut reader: Reader) -> Result<MeshData, Error> {
    let points = reader
        .points
        .ok_or_else(|| reader.scanner.truncated("the file has no POINTS"))?;
    let cells = match (reader.cells, reader.dimensions) {
        (Some(cells), _) if cells.types.len() + 1 == cells.offsets.len() => cells,
        (Some(cells), None) => {
            return Err(reader.scanner.truncated(format!(
                "{} and {} types of cells",
                count(cells.offsets.len() as u64 - 1, "cell"),
                cells.types.len()
            )));
        }
        (_, Some(dimensions)) => {
            let needed = dimensions.iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
            if needed != Some(points.len() as u64) || dimensions.contains(&1) {
                let [i, j, k] = dimensions;
                return Err(reader.scanner.error(format!(
                    "a structured grid of {i}×{j}×{k} with {} is no volume",
                    count(points.len() as u64, "point")
                )));
            }
            let mut cells = Cells {
                offsets: vec![0],
                ..Cells::default()
            };
            add_hexahedra(&mut cells, dimensions, 0);
            cells
        }
        (None, None) => return Err(reader.scanner.truncated("the file has no CELLS")),
    };
    let ghosts = take_ghosts(&mut reader.arrays);
    let mut data = MeshData {
        points,
        cells,
        fields: to_scalars(reader.arrays),
        ..MeshData::default()
    };
    check(&source.path, &data)?;
    data.remove_ghosts(source, &ghosts)?;
    Ok(data)
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source) -> Reader<'a> {
        Reader {
            scanner: Scanner::new(source),
            dimensions: None,
            points: None,
            cells: None,
            arrays: Vec::new(),
            data: None,
            image: None,
        }
    }

    /// Name, type and number of the samples of binary structured points with SCALARS of one
    /// component, with the scanner behind their head; `None` for what differs in any way.
    fn single_field(&mut self) -> Option<(String, Kind, u64)> {
        self.header().ok()?;
        loop {
            let keyword = self.scanner.word()?;
            match keyword.to_ascii_uppercase().as_str() {
                "DATASET" | "DIMENSIONS" | "ORIGIN" | "SPACING" | "ASPECT_RATIO" | "POINT_DATA"
                | "METADATA" => self.section(keyword).ok()?,
                "SCALARS" => break,
                _ => return None,
            }
        }
        let (name, kind, components) = self.scalars_head().ok()?;
        match self.data {
            Some((Association::Point, points)) if self.scanner.binary && components == 1 => {
                Some((name, kind, points))
            }
            _ => None,
        }
    }

    /// Three lines: version, title, ASCII or BINARY.
    fn header(&mut self) -> Result<(), Error> {
        self.scanner.line();
        self.scanner.line();
        let encoding = self.scanner.expect("ASCII or BINARY")?;
        self.scanner.binary = match encoding.to_ascii_uppercase().as_str() {
            "ASCII" => false,
            "BINARY" => true,
            _ => {
                return Err(self.scanner.error(format!(
                    "'{}' where ASCII or BINARY is needed",
                    clip(encoding)
                )));
            }
        };
        Ok(())
    }

    fn section(&mut self, keyword: &str) -> Result<(), Error> {
        match keyword.to_ascii_uppercase().as_str() {
            "DATASET" => self.dataset(),
            "DIMENSIONS" => {
                let mut size = || self.scanner.count("a number of points");
                self.dimensions = Some([size()?, size()?, size()?]);
                Ok(())
            }
            word @ ("ORIGIN" | "SPACING" | "ASPECT_RATIO") => {
                // Words also in a binary file.
                let mut number = || {
                    let word = self.scanner.expect("a number")?;
                    parse_float(word).ok_or_else(|| {
                        self.scanner
                            .error(format!("'{}' is not a number", clip(word)))
                    })
                };
                let numbers = [number()?, number()?, number()?];
                match (&mut self.image, word) {
                    (Some(image), "ORIGIN") => image.origin = numbers,
                    (Some(image), _) => image.spacing = numbers,
                    (None, _) => {}
                }
                Ok(())
            }
            "POINTS" => self.points(),
            "CELLS" => self.cells(),
            "CELL_TYPES" => self.cell_types(),
            "POINT_DATA" => self.begin_data(Association::Point),
            "CELL_DATA" => self.begin_data(Association::Cell),
            "SCALARS" => self.scalars(),
            "VECTORS" | "NORMALS" => self.attribute(3),
            "TENSORS" => self.attribute(9),
            "TENSORS6" => self.attribute(6),
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.attribute(1),
            "TEXTURE_COORDINATES" => {
                let name = self.scanner.name()?;
                let components = self.scanner.count("a number of components")?;
                let kind = self.scanner.kind()?;
                self.array(name, components, kind, false)
            }
            "COLOR_SCALARS" => {
                let name = self.scanner.name()?;
                let components = self.scanner.count("a number of components")?;
                // Bytes, or fractions of 1 as text.
                self.array(name, components, Kind::U8, false)
            }
            "LOOKUP_TABLE" => {
                self.scanner.name()?;
                let colors = self.scanner.count("a number of colors")?;
                let values = colors.saturating_mul(4);
                self.scanner.floats(Kind::U8, values).map(drop)
            }
            "FIELD" => self.field(),
            "METADATA" => {
                self.scanner.skip_metadata();
                Ok(())
            }
            _ => Err(self
                .scanner
                .truncated(format!("'{}' where a keyword is needed", clip(keyword)))),
        }
    }

    fn dataset(&mut self) -> Result<(), Error> {
        let kind = self.scanner.expect("the type of the data set")?;
        match kind.to_ascii_uppercase().as_str() {
            "UNSTRUCTURED_GRID" | "STRUCTURED_GRID" => Ok(()),
            "STRUCTURED_POINTS" => {
                self.image = Some(Image {
                    origin: [0.0; 3],
                    spacing: [1.0; 3],
                    fields: Vec::new(),
                    notes: Vec::new(),
                });
                Ok(())
            }
            other => Err(self.scanner.error(format!(
                "the file holds {}; of legacy VTK files UNSTRUCTURED_GRID, STRUCTURED_GRID and \
                 STRUCTURED_POINTS are read",
                clip(other)
            ))),
        }
    }

    /// The grid of structured points.
    fn grid(&self, image: Image) -> Result<GridData, Error> {
        let (lattice, points) = self.lattice(&image)?;
        let [i, j, k] = lattice.dims;
        let mut fields = image.fields;
        fields.sort_by_key(|(later, ..)| *later); // stable
        let mut found = Vec::new();
        for (_, name, samples, components) in fields {
            if (samples.len() / components) as u64 != points {
                return Err(self.scanner.error(format!(
                    "array '{name}' has {} where {i}×{j}×{k} are needed",
                    count((samples.len() / components) as u64, "sample")
                )));
            }
            for (name, samples) in split(&name, samples, components, true) {
                found.push(GridField {
                    name,
                    association: Association::Point,
                    lattice,
                    samples: FieldSamples::Loaded(samples),
                });
            }
        }
        if found.is_empty() {
            return Err(self.scanner.truncated("the file has no POINT_DATA"));
        }
        Ok(GridData {
            fields: found,
            notes: image.notes,
            files: Vec::new(),
        })
    }

    /// Where the samples of structured points lie, and how many they are.
    fn lattice(&self, image: &Image) -> Result<(Lattice, u64), Error> {
        let dims = self
            .dimensions
            .ok_or_else(|| self.scanner.truncated("the file has no DIMENSIONS"))?;
        let [i, j, k] = dims;
        let points = dims.iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
        if points.is_none_or(|n| usize::try_from(n).is_err()) {
            return Err(self.scanner.error(format!("{i}×{j}×{k} points")));
        }
        let [x, y, z] = image.spacing;
        let axes = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z];
        let lattice = Lattice::from_axes(dims.map(|d| d as usize), image.origin.into(), axes);
        let lattice = lattice.map_err(|error| self.scanner.error(error.to_string()))?;
        Ok((lattice, points.unwrap_or(0)))
    }

    fn points(&mut self) -> Result<(), Error> {
        let n = self.scanner.count("a number of points")?;
        let kind = self.scanner.kind()?;
        let values = self.scanner.floats(kind, n.saturating_mul(3))?;
        self.points = Some(values.chunks_exact(3).map(DVec3::from_slice).collect());
        Ok(())
    }

    fn cells(&mut self) -> Result<(), Error> {
        let first = self.scanner.count("a number of cells")?;
        let second = self.scanner.count("a number of values")?;
        let mut cells = Cells {
            types: self.cells.take().map_or_else(Vec::new, |c| c.types),
            ..Cells::default()
        };
        if self
            .scanner
            .peek()
            .is_some_and(|w| w.eq_ignore_ascii_case("OFFSETS"))
        {
            self.scanner.word();
            let kind = self.scanner.kind()?;
            cells.offsets = self.scanner.indices(kind, first)?;
            let keyword = self.scanner.expect("CONNECTIVITY")?;
            if !keyword.eq_ignore_ascii_case("CONNECTIVITY") {
                return Err(self.scanner.error("CONNECTIVITY is needed after OFFSETS"));
            }
            let kind = self.scanner.kind()?;
            cells.connectivity = self.scanner.indices(kind, second)?;
        } else {
            let values = self.scanner.indices(Kind::I32, second)?;
            cells.offsets.push(0);
            let mut rest = values.as_slice();
            for cell in 0..first {
                let Some(points) = rest.split_first().and_then(|(&n, tail)| {
                    let n = usize::try_from(n).ok().filter(|&n| n <= tail.len())?;
                    let (points, tail) = tail.split_at(n);
                    rest = tail;
                    Some(points)
                }) else {
                    return Err(self.scanner.error(format!(
                        "cell {cell} of {first} goes beyond the {second} values of CELLS"
                    )));
                };
                cells.connectivity.extend_from_slice(points);
                cells.offsets.push(cells.connectivity.len() as u64);
            }
            if !rest.is_empty() {
                return Err(self.scanner.error(format!(
                    "{} left over after the {first} cells of CELLS",
                    count(rest.len() as u64, "value")
                )));
            }
        }
        if cells.offsets.is_empty() {
            return Err(self.scanner.error("the mesh has no cells"));
        }
        self.cells = Some(cells);
        Ok(())
    }

    fn cell_types(&mut self) -> Result<(), Error> {
        let n = self.scanner.count("a number of cells")?;
        let types = self.scanner.indices(Kind::I32, n)?;
        let types: Result<Vec<u8>, Error> = types
            .into_iter()
            .enumerate()
            .map(|(cell, kind)| {
                u8::try_from(kind).map_err(|_| {
                    self.scanner.error(format!(
                        "cell {cell} is of type {kind}, and VTK has none above 255"
                    ))
                })
            })
            .collect();
        let cells = self.cells.get_or_insert_default();
        cells.types = types?;
        if cells.offsets.is_empty() {
            cells.offsets.push(0);
        }
        Ok(())
    }

    fn begin_data(&mut self, association: Association) -> Result<(), Error> {
        let n = self.scanner.count("a number of values")?;
        self.data = Some((association, n));
        Ok(())
    }

    fn scalars(&mut self) -> Result<(), Error> {
        let (name, kind, components) = self.scalars_head()?;
        self.array(name, components, kind, true)
    }

    /// Name, type and number of components.
    fn scalars_head(&mut self) -> Result<(String, Kind, u64), Error> {
        let name = self.scanner.name()?;
        let kind = self.scanner.kind()?;
        let components = match self.scanner.word_in_line() {
            Some(word) => word.parse().map_err(|_| {
                self.scanner
                    .error(format!("'{}' is not a number of components", clip(word)))
            })?,
            None => 1,
        };
        if self
            .scanner
            .peek()
            .is_some_and(|w| w.eq_ignore_ascii_case("LOOKUP_TABLE"))
        {
            self.scanner.word();
            self.scanner.name()?;
        }
        Ok((name, kind, components))
    }

    fn attribute(&mut self, components: u64) -> Result<(), Error> {
        let name = self.scanner.name()?;
        let kind = self.scanner.kind()?;
        self.array(name, components, kind, false)
    }

    /// Arrays of any shape; before POINT_DATA or CELL_DATA they are the data
    /// set's own and passed over.
    fn field(&mut self) -> Result<(), Error> {
        self.scanner.name()?;
        let arrays = self.scanner.count("a number of arrays")?;
        for _ in 0..arrays {
            while self
                .scanner
                .peek()
                .is_some_and(|w| w.eq_ignore_ascii_case("METADATA"))
            {
                self.scanner.skip_metadata();
            }
            let name = self.scanner.name()?;
            let components = self.scanner.count("a number of components")?;
            let tuples = self.scanner.count("a number of values")?;
            if self.scanner.peek().is_some_and(|w| {
                ["string", "utf8_string", "vtkstring"].contains(&w.to_ascii_lowercase().as_str())
            }) {
                self.scanner.word();
                self.scanner.skip_texts(components.saturating_mul(tuples))?;
                continue;
            }
            let kind = self.scanner.kind()?;
            match self.data {
                Some((_, n)) if n != tuples => {
                    return Err(self.scanner.error(format!(
                        "array '{name}' has {tuples} values where {n} are needed"
                    )));
                }
                Some(_) => self.array(name, components, kind, false)?,
                None => {
                    self.scanner
                        .floats(kind, components.saturating_mul(tuples))?;
                }
            }
        }
        Ok(())
    }

    fn array(
        &mut self,
        name: String,
        components: u64,
        kind: Kind,
        active: bool,
    ) -> Result<(), Error> {
        let Some((association, n)) = self.data else {
            return Err(self.scanner.error(format!(
                "array '{name}' comes before POINT_DATA or CELL_DATA"
            )));
        };
        // More would be a table, not a field.
        const MOST_COMPONENTS: u64 = 64;
        if components == 0 || components > MOST_COMPONENTS {
            return Err(self.scanner.error(format!(
                "array '{name}' has {components} components; 1 to {MOST_COMPONENTS} are read"
            )));
        }
        if let Some(image) = &mut self.image {
            let converted = self.scanner.samples(kind, n.saturating_mul(components))?;
            if association == Association::Cell {
                image.notes.push(format!("cell data '{name}' left out"));
                return Ok(());
            }
            if converted.rounded {
                image
                    .notes
                    .push(format!("samples of '{name}' are rounded to 32-bit floats"));
            }
            let field = (!active, name, converted.samples, components as usize);
            image.fields.push(field);
            return Ok(());
        }
        let values = self.scanner.floats(kind, n.saturating_mul(components))?;
        self.arrays.push(Array {
            name,
            association,
            components: components as usize,
            values,
            active,
        });
        Ok(())
    }
}
