//! Legacy VTK files, `.vtk`: unstructured, structured and rectilinear grids and structured
//! points, ASCII and binary.
//!
//! *VTK File Formats*, the VTK documentation; versions 1.0 to 4.2 and 5.1, which
//! stores cells as offsets and connectivity. Binary numbers are big-endian.
//! Array names are decoded (`Nodal%20Stress`). A structured grid becomes
//! hexahedra, structured points a regular grid whose samples keep their type. Large binary
//! ones of one field stay in their file. A rectilinear grid is regular if its coordinates are
//! evenly spaced, else hexahedra, as in [`vtu`](crate::vtu).

mod scanner;

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error, glam};

pub(crate) use self::scanner::parse_float;
use self::scanner::{Kind, Scanner, clip};
use crate::MeshData;
use crate::fields::{Array, MOST_COMPONENTS, Numbers, take_ghosts};
use crate::grid::ghosts::Ghosts;
use crate::grid::number::{self, Number};
use crate::grid::{Entries, GridData, RawFile, split};
use crate::mesh_data::add_hexahedra;
use crate::pieces::most_implied;
use crate::read::{FileData, check};
use crate::source::{Endian, Source, count, read_at, room};
use crate::vtu::structured::{MOST_POINTS, even_steps, note_of_steps};
use crate::vtu::version;

/// Reads a file from its beginning to its end, and holds what it has read.
struct Reader<'a> {
    scanner: Scanner<'a>,
    /// Of the format, major and minor.
    version: [u32; 2],
    dimensions: Option<[u64; 3]>,
    /// The coordinates of a rectilinear grid, and the ε of their numbers.
    axes: Option<([Vec<f64>; 3], f64)>,
    points: Option<Vec<DVec3>>,
    cells: Option<Cells>,
    arrays: Vec<ArrayPlace>,
    /// Components of the array that was read last, which METADATA may follow, and whether
    /// it is the last of `arrays`.
    last: (usize, bool),
    /// The owner of the arrays that follow, and the number of their values.
    data: Option<(Association, u64)>,
    /// The samples of structured points.
    image: Option<Image>,
}

/// Structured points, or a rectilinear grid that is evenly spaced.
struct Image {
    origin: [f64; 3],
    spacing: [f64; 3],
    notes: Vec<String>,
    fields: Vec<ImageArray>,
}

/// An array of structured points.
struct ImageArray {
    name: String,
    association: Association,
    components: usize,
    entries: Entries,
    numbers: number::Numbers,
    /// The file marks it as the one to draw.
    active: bool,
}

/// Reads a legacy `.vtk` file.
pub(crate) fn read(source: Source) -> Result<FileData, Error> {
    let source = Arc::new(source);
    let mut reader = Reader::new(&source);
    reader.header()?;
    while let Some(keyword) = reader.scanner.word()? {
        reader.section(keyword)?;
    }
    match reader.image.take() {
        Some(image) => reader.grid(image).map(FileData::Grid),
        None => mesh(&source, reader).map(FileData::Mesh),
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
    let Ok((lattice, needed)) = reader.lattice(image, Association::Point) else {
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

fn mesh(source: &Arc<Source>, mut reader: Reader) -> Result<MeshData, Error> {
    if let Some((axes, _)) = reader.axes.take() {
        reader.points = Some(reader.points_of(&axes)?);
    }
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
            let is_flat = dimensions.iter().any(|&d| d < 2);
            if needed != Some(points.len() as u64) || is_flat {
                let [i, j, k] = dimensions;
                return Err(reader.scanner.error(format!(
                    "a structured grid of {i}×{j}×{k} points with {} is no volume: it needs 2 or more along each axis, and as many as their product",
                    count(points.len() as u64, "point")
                )));
            }
            let mut cells = Cells {
                offsets: vec![0],
                ..Cells::default()
            };
            add_hexahedra(&mut cells, dimensions, 0)?;
            cells
        }
        (None, None) => return Err(reader.scanner.truncated("the file has no CELLS")),
    };
    let binary = reader.scanner.binary;
    let arrays = reader.arrays.into_iter();
    let mut arrays: Vec<Array> = arrays
        .map(|place| place.array(source.clone(), binary))
        .collect();
    let mut data = MeshData {
        points,
        cells,
        ..MeshData::default()
    };
    check(&source.path, &data, &arrays)?;
    data.renumber_old(&arrays, |_| reader.version < [5, 1])?;
    let ghosts = take_ghosts(&mut arrays);
    data.remove_ghosts(&source.path, &ghosts)?;
    data.add_fields(arrays)?;
    Ok(data)
}

/// An array of a mesh that stays where it is in the file.
struct ArrayPlace {
    name: String,
    association: Association,
    components: usize,
    component_names: Vec<Option<String>>,
    tuples: usize,
    active: bool,
    colors: bool,
    kind: Kind,
    /// Where its first line begins.
    at: usize,
}

impl ArrayPlace {
    fn array(self, source: Arc<Source>, binary: bool) -> Array {
        let numbers = NumbersInFile {
            source,
            at: self.at,
            binary,
            kind: self.kind,
            count: self.tuples as u64 * self.components as u64, // the file holds them
            colors: self.colors,
        };
        Array {
            name: self.name,
            association: self.association,
            components: self.components,
            component_names: self.component_names,
            tuples: self.tuples,
            numbers: Arc::new(numbers),
            active: self.active,
            colors: self.colors && self.components > 1,
        }
    }
}

/// The numbers of an array in a file in memory.
struct NumbersInFile {
    source: Arc<Source>,
    at: usize,
    binary: bool,
    kind: Kind,
    count: u64,
    colors: bool,
}

impl fmt::Debug for NumbersInFile {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let path = self.source.path.display();
        write!(formatter, "{} numbers at {} of {path}", self.count, self.at)
    }
}

impl Numbers for NumbersInFile {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut scanner = Scanner::new(&self.source);
        scanner.at = self.at;
        scanner.binary = self.binary;
        match self.colors && !self.binary {
            true => scanner.each_float(self.kind, self.count, &mut |value| each(channel(value))),
            false => scanner.each_float(self.kind, self.count, each),
        }
    }
}

/// A color's channel from its text: VTK writes bytes as fractions of 1.
fn channel(fraction: f64) -> f64 {
    (fraction * 255.0).round()
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source) -> Reader<'a> {
        Reader {
            scanner: Scanner::new(source),
            version: [0; 2],
            dimensions: None,
            axes: None,
            points: None,
            cells: None,
            arrays: Vec::new(),
            last: (0, false),
            data: None,
            image: None,
        }
    }

    /// Name, type and number of the samples of binary structured points with SCALARS of one
    /// component, with the scanner behind their head; `None` for what differs in any way.
    fn single_field(&mut self) -> Option<(String, Kind, u64)> {
        self.header().ok()?;
        loop {
            let keyword = self.scanner.word().ok()??;
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
        let first = String::from_utf8_lossy(self.scanner.line()).to_ascii_lowercase();
        if let Some((_, number)) = first.rsplit_once("version") {
            self.version = version(number);
        }
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
            "X_COORDINATES" => self.axis(0),
            "Y_COORDINATES" => self.axis(1),
            "Z_COORDINATES" => self.axis(2),
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
                self.array(name, components, kind, Meaning::Numbers)
            }
            "COLOR_SCALARS" => {
                let name = self.scanner.name()?;
                let components = self.scanner.count("a number of components")?;
                if self.image.is_some() && !self.scanner.binary {
                    return self.color_words(name, components);
                }
                self.array(name, components, Kind::U8, Meaning::Colors)
            }
            "LOOKUP_TABLE" => {
                self.scanner.name()?;
                let colors = self.scanner.count("a number of colors")?;
                let values = colors.saturating_mul(4);
                self.last = (0, false);
                self.scanner.skip_numbers(Kind::U8, values)
            }
            "FIELD" => self.field(),
            "METADATA" => {
                self.metadata();
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
            "RECTILINEAR_GRID" => {
                self.axes = Some(Default::default());
                Ok(())
            }
            "STRUCTURED_POINTS" => {
                self.image = Some(Image {
                    origin: [0.0; 3],
                    spacing: [1.0; 3],
                    notes: Vec::new(),
                    fields: Vec::new(),
                });
                Ok(())
            }
            other => Err(self.scanner.error(format!(
                "the file holds {}; of legacy VTK files UNSTRUCTURED_GRID, STRUCTURED_GRID, \
                 RECTILINEAR_GRID and STRUCTURED_POINTS are read",
                clip(other)
            ))),
        }
    }

    /// The grid of structured points.
    fn grid(&self, image: Image) -> Result<GridData, Error> {
        let lattices = [Association::Point, Association::Cell]
            .map(|association| (association, self.lattice(&image, association)));
        let (mut arrays, notes) = (image.fields, image.notes);
        if arrays.is_empty() {
            return Err(self
                .scanner
                .truncated("the file has no POINT_DATA and no CELL_DATA"));
        }
        arrays.sort_by_key(|array| (array.association == Association::Cell, !array.active));
        let mut data = GridData {
            fields: Vec::new(),
            space: None,
            notes,
            files: Vec::new(),
        };
        let mut ghosts = Ghosts::default();
        let [mut points, mut cells] = lattices.map(|(_, lattice)| Some(lattice));
        for array in arrays {
            let ImageArray {
                name,
                association,
                components,
                entries,
                numbers,
                ..
            } = array;
            let place = match association {
                Association::Point => &mut points,
                Association::Cell => &mut cells,
            };
            let (lattice, needed) = match place {
                Some(Ok(found)) => *found,
                other => {
                    return Err(other.take().and_then(Result::err).unwrap_or_else(|| {
                        self.scanner.error("arrays of a grid without a place")
                    }));
                }
            };
            if (numbers.len() / components) as u64 != needed {
                let [i, j, k] = lattice.dims;
                return Err(self.scanner.error(format!(
                    "array '{name}' has {} where {i}×{j}×{k} are needed",
                    count((numbers.len() / components) as u64, "sample")
                )));
            }
            match (name.as_str(), components, association) {
                ("vtkGhostType", 1, Association::Point) => ghosts.points = Some(numbers),
                ("vtkGhostType", 1, Association::Cell) => ghosts.cells = Some(numbers),
                _ => {
                    let fields = split(&name, numbers, components, entries, &mut data.notes);
                    let fields = fields
                        .into_iter()
                        .map(|field| field.on(lattice, association));
                    data.fields.extend(fields);
                }
            }
        }
        ghosts.hide(&mut data);
        if data.fields.is_empty() {
            return Err(self.scanner.error("the grid has no field of numbers"));
        }
        Ok(data)
    }

    /// Where the samples of structured points, or of the cells between them, lie, and how many
    /// they are.
    fn lattice(&self, image: &Image, association: Association) -> Result<(Lattice, u64), Error> {
        let points = self
            .dimensions
            .ok_or_else(|| self.scanner.truncated("the file has no DIMENSIONS"))?;
        let [x, y, z] = image.spacing;
        let axes = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z];
        let origin = DVec3::from(image.origin);
        let (dims, origin, interpolation) = match association {
            Association::Point => (points, origin, Interpolation::Linear),
            Association::Cell => (
                points.map(|n| n.saturating_sub(1)),
                origin + 0.5 * DVec3::new(x, y, z),
                Interpolation::Nearest,
            ),
        };
        let [i, j, k] = dims;
        let count = dims.iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
        let count = count.filter(|n| usize::try_from(*n).is_ok());
        let wrong = || self.scanner.error(format!("{i}×{j}×{k} samples"));
        let count = count.ok_or_else(wrong)?;
        let dims = dims.map(|d| d as usize);
        let lattice = Lattice::from_axes(dims, origin, axes, interpolation);
        let lattice = lattice.map_err(|error| self.scanner.error(error.to_string()))?;
        Ok((lattice, count))
    }

    /// The coordinates of a rectilinear grid along an axis; behind the last they may turn out
    /// to be evenly spaced.
    fn axis(&mut self, axis: usize) -> Result<(), Error> {
        let n = self.scanner.count("a number of coordinates")?;
        let kind = self.scanner.kind()?;
        if n > MOST_POINTS {
            let what = format!("{n} points along an axis; {MOST_POINTS} are read");
            return Err(self.scanner.error(what));
        }
        let values = self.scanner.floats(kind, n)?;
        self.last = (1, false);
        let Some((axes, epsilon)) = &mut self.axes else {
            return Err(self
                .scanner
                .error("coordinates of what is no RECTILINEAR_GRID"));
        };
        axes[axis] = values;
        *epsilon = epsilon.max(match kind {
            Kind::F32 => f32::EPSILON.into(),
            _ => f64::EPSILON,
        });
        if axes.iter().any(Vec::is_empty) {
            return Ok(());
        }
        let dimensions = axes.each_ref().map(|axis| axis.len() as u64);
        if self.dimensions.is_some_and(|other| other != dimensions) {
            let [i, j, k] = dimensions;
            return Err(self.scanner.error(format!(
                "{i}, {j} and {k} coordinates, which is not what DIMENSIONS says"
            )));
        }
        let steps = axes.each_ref().map(|axis| even_steps(axis, *epsilon));
        // Arrays that were read before are a mesh's.
        if let ([Some(x), Some(y), Some(z)], true) = (steps, self.arrays.is_empty()) {
            let steps = [x, y, z];
            let off = steps.map(|(.., off)| off).into_iter().fold(0.0, f64::max);
            self.dimensions = Some(dimensions);
            self.image = Some(Image {
                origin: steps.map(|(first, ..)| first),
                spacing: steps.map(|(_, step, _)| step),
                notes: vec![note_of_steps(off)],
                fields: Vec::new(),
            });
        }
        Ok(())
    }

    /// The points of a rectilinear grid with these axes.
    fn points_of(&mut self, axes: &[Vec<f64>; 3]) -> Result<Vec<DVec3>, Error> {
        // A point, and a hexahedron with its type, its end and eight corners.
        const BYTES: u64 = 24 + 73;
        let [xs, ys, zs] = axes;
        let dimensions = axes.each_ref().map(|axis| axis.len() as u64);
        let points = dimensions.iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
        let bytes = points.and_then(|points| points.checked_mul(BYTES));
        let most = most_implied(self.scanner.length());
        let Some(points) = points.filter(|_| bytes.is_some_and(|bytes| bytes <= most)) else {
            let [i, j, k] = dimensions;
            return Err(self.scanner.error(format!(
                "a rectilinear grid of {i}×{j}×{k} points takes more than {most} bytes, which is refused"
            )));
        };
        self.dimensions = Some(dimensions);
        let mut all = room(points as usize)?;
        for &z in zs {
            for &y in ys {
                all.extend(xs.iter().map(|&x| DVec3::new(x, y, z)));
            }
        }
        Ok(all)
    }

    fn points(&mut self) -> Result<(), Error> {
        let n = self.scanner.count("a number of points")?;
        let kind = self.scanner.kind()?;
        let mut points = self.scanner.room_for(kind, n, 3)?;
        let (mut point, mut filled) = ([0.0; 3], 0);
        self.scanner
            .each_float(kind, n.saturating_mul(3), &mut |value| {
                point[filled] = value;
                filled += 1;
                if filled == 3 {
                    points.push(DVec3::from_array(point));
                    filled = 0;
                }
            })?;
        self.points = Some(points);
        self.last = (3, false);
        Ok(())
    }

    fn cells(&mut self) -> Result<(), Error> {
        let first = self.scanner.count("a number of cells")?;
        let second = self.scanner.count("a number of values")?;
        let mut cells = Cells {
            types: self.cells.take().map_or_else(Vec::new, |c| c.types),
            ..Cells::default()
        };
        self.last = (0, false);
        if self.scanner.skip_word("OFFSETS") {
            let kind = self.scanner.kind()?;
            cells.offsets = self.scanner.indices(kind, first)?;
            if !self.scanner.skip_word("CONNECTIVITY") {
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
        self.array(name, components, kind, Meaning::Active)
    }

    /// Name, type and number of components.
    fn scalars_head(&mut self) -> Result<(String, Kind, u64), Error> {
        let name = self.scanner.name()?;
        let kind = self.scanner.kind()?;
        let components = match self.scanner.word_in_line()? {
            Some(word) => word.parse().map_err(|_| {
                self.scanner
                    .error(format!("'{}' is not a number of components", clip(word)))
            })?,
            None => 1,
        };
        if self.scanner.skip_word("LOOKUP_TABLE") {
            self.scanner.name()?;
        }
        Ok((name, kind, components))
    }

    fn attribute(&mut self, components: u64) -> Result<(), Error> {
        let name = self.scanner.name()?;
        let kind = self.scanner.kind()?;
        self.array(name, components, kind, Meaning::Numbers)
    }

    /// Arrays of any shape; before POINT_DATA or CELL_DATA they are the data
    /// set's own and passed over.
    fn field(&mut self) -> Result<(), Error> {
        self.scanner.name()?;
        let arrays = self.scanner.count("a number of arrays")?;
        for _ in 0..arrays {
            while self.scanner.skip_word("METADATA") {
                self.metadata();
            }
            let name = self.scanner.name()?;
            let components = self.scanner.count("a number of components")?;
            let tuples = self.scanner.count("a number of values")?;
            let texts = ["string", "utf8_string", "vtkstring"];
            if texts.iter().any(|word| self.scanner.skip_word(word)) {
                self.last = (0, false);
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
                Some(_) => self.array(name, components, kind, Meaning::Numbers)?,
                None => {
                    self.last = (0, false);
                    self.scanner
                        .skip_numbers(kind, components.saturating_mul(tuples))?;
                }
            }
        }
        Ok(())
    }

    /// Names of the components of the array before.
    fn metadata(&mut self) {
        let (components, is_array) = self.last;
        let names = self.scanner.metadata(components);
        if let (true, Some(array)) = (is_array, self.arrays.last_mut()) {
            array.component_names = names;
        }
        self.last = (0, false);
    }

    /// COLOR_SCALARS of structured points in words: fractions of 1 for bytes, which is how VTK
    /// writes the scalars to draw if they are bytes.
    fn color_words(&mut self, name: String, components: u64) -> Result<(), Error> {
        let at = self.image.as_ref().map_or(0, |image| image.fields.len());
        self.array(name, components, Kind::F32, Meaning::Active)?;
        if let Some(array) = self
            .image
            .as_mut()
            .and_then(|image| image.fields.get_mut(at))
        {
            let numbers = &array.numbers;
            let bytes = (0..numbers.len()).map(|i| (numbers.get(i) * 255.0).round() as u8);
            array.numbers = number::Numbers::U8(bytes.collect());
            array.entries = Entries::of_bytes(Number::U8, array.components);
        }
        Ok(())
    }

    fn array(
        &mut self,
        name: String,
        components: u64,
        kind: Kind,
        meaning: Meaning,
    ) -> Result<(), Error> {
        let Some((association, n)) = self.data else {
            return Err(self.scanner.error(format!(
                "array '{name}' comes before POINT_DATA or CELL_DATA"
            )));
        };
        if components == 0 || components > MOST_COMPONENTS as u64 {
            return Err(self.scanner.error(format!(
                "array '{name}' has {components} components; 1 to {MOST_COMPONENTS} are read"
            )));
        }
        let components = components as usize;
        self.last = (components, self.image.is_none());
        if let Some(image) = &mut self.image {
            let numbers = self
                .scanner
                .numbers_of(kind, n.saturating_mul(components as u64))?;
            let number = kind.number().unwrap_or(Number::U8);
            image.fields.push(ImageArray {
                name,
                association,
                components,
                entries: Entries::of_bytes(number, components),
                numbers,
                active: meaning != Meaning::Numbers,
            });
            return Ok(());
        }
        let at = self.scanner.at;
        self.scanner
            .skip_numbers(kind, n.saturating_mul(components as u64))?;
        self.arrays.push(ArrayPlace {
            name,
            association,
            components,
            component_names: Vec::new(),
            tuples: n as usize, // the file holds them
            // VTK writes the scalars to draw as colors if they are bytes.
            active: meaning != Meaning::Numbers,
            colors: meaning == Meaning::Colors,
            kind,
            at,
        });
        Ok(())
    }
}

/// The use of an array.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meaning {
    /// The scalars to draw.
    Active,
    Numbers,
    /// Bytes, or fractions of 1 as text.
    Colors,
}
