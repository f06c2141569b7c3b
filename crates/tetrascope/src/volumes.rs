//! A volume from where a scene says it is: a file or a data set.

use std::collections::BTreeMap;
use std::path::PathBuf;

use tetrascope_core::clusters::{CellSource, MeshClusters};
use tetrascope_core::grid::Interpolation;
use tetrascope_core::mesh::curved::Straightening;
use tetrascope_core::mesh::{Association, type_name, volume_corners};
use tetrascope_core::{Bounds, Error, Scalars, TetMesh, Volume, is_value, number};
use tetrascope_datasets::{Dataset, Options};
use tetrascope_io::{
    FieldSamples, FileData, GridData, GridField, MeshData, ReadOptions, StepChoice, read_file,
};
use tetrascope_scene::{AppearanceSpec, CameraSpec, SceneFile, VolumeSource};

/// A volume and what was found out while loading it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The volume, with the chosen field.
    pub volume: Volume,
    /// The name of that field; [`FieldSummary::drawn`] tells it from another of its name.
    pub field: String,
    /// A description of one line: cells before and after splitting, and the field.
    pub description: String,
    /// Findings, repairs and omissions, one sentence each.
    pub notes: Vec<String>,
    /// Every scalar field that the source offers.
    pub fields: Vec<FieldSummary>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
    /// The world in which a grid's file says that it lies, "LPS"; `None` for all others.
    pub space: Option<&'static str>,
}

/// A field that a source offers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FieldSummary {
    /// Name in the source.
    pub name: String,
    /// "point" or "cell".
    pub association: &'static str,
    /// The least and greatest finite value that volume cells use, if there is any.
    pub range: Option<(f64, f64)>,
    /// Whether it is the chosen one.
    pub drawn: bool,
    /// How many values are not finite, which is to have no value; `None` for fields of
    /// meshes that are not drawn.
    pub missing: Option<u64>,
    /// A number of the source is a value and this.
    pub offset: f64,
}

/// The contents of a source, be there something to draw or not.
#[derive(Clone, Debug)]
pub enum Contents {
    /// A volume with a field.
    Drawable(Loaded),
    /// A mesh without.
    Bare(BareMesh),
}

/// A mesh of which nothing can be drawn.
#[derive(Clone, Debug)]
pub struct BareMesh {
    /// The reason for which it cannot be drawn, as a sentence.
    pub why: &'static str,
    /// Its volume cells, if it has any, with 0 in place of a field.
    pub mesh: Option<TetMesh>,
    /// How many cells there are of each of VTK's types.
    pub cells_by_type: BTreeMap<u8, usize>,
    /// How many points there are.
    pub points: usize,
    /// The box around the points that cells use; around all without a cell.
    pub bounds: Bounds,
    /// Every scalar field that the source offers.
    pub fields: Vec<FieldSummary>,
    /// Findings, repairs and omissions, one sentence each.
    pub notes: Vec<String>,
}

/// Reads or makes the volume that `source` names.
///
/// # Errors
/// Those of [`read_file`] and of [`Dataset::mesh`](tetrascope_datasets::Dataset::mesh);
/// [`Error::NoSuchField`] with the fields that exist; [`Error::Invalid`] for a
/// source that names no volume, or two, or options that do not go with it.
pub fn load(source: &VolumeSource) -> Result<Loaded, Error> {
    load_step(source, None)
}

/// As [`load`], for a step of a series that follows `previous`: a mesh of the very same
/// geometry shares it, so that renderers need only its scalars.
///
/// # Errors
/// As [`load`].
pub fn load_step(source: &VolumeSource, previous: Option<&Volume>) -> Result<Loaded, Error> {
    match open(source)? {
        Opened::Mesh(data) => from_mesh(data, source, previous),
        Opened::Grid(data) => from_grid(data, source),
        Opened::Clusters(clusters) => from_clusters(clusters, source),
        Opened::Dataset(name) => from_dataset(name, source),
    }
}

/// Reads or makes what `source` names, with every field: what [`load`] chooses one from.
///
/// # Errors
/// As [`load`], but for fields.
pub fn read(source: &VolumeSource) -> Result<FileData, Error> {
    Ok(match open(source)? {
        Opened::Mesh(data) => FileData::Mesh(data),
        Opened::Grid(data) => FileData::Grid(data),
        Opened::Clusters(clusters) => FileData::Clusters(clusters),
        Opened::Dataset(name) => match from_dataset(name, source)?.volume {
            Volume::Mesh(mesh) => FileData::Mesh(MeshData::of(&mesh)?),
            _ => unreachable!("a grid was opened as one"),
        },
    })
}

/// As [`load`], but a mesh without a field or without volume cells is described too.
///
/// # Errors
/// As [`load`].
pub fn examine(source: &VolumeSource) -> Result<Contents, Error> {
    let loaded = match open(source)? {
        Opened::Mesh(data) => match lacks(&data) {
            Some(why) if source.field.is_none() => return Ok(Contents::Bare(bare(data, why)?)),
            _ => from_mesh(data, source, None),
        },
        Opened::Grid(data) => from_grid(data, source),
        Opened::Clusters(clusters) => from_clusters(clusters, source),
        Opened::Dataset(name) => from_dataset(name, source),
    };
    Ok(Contents::Drawable(loaded?))
}

/// The cells that a file of clusters is made of.
pub struct LoadedCells {
    /// A mesh in memory, or a data set whose cells are told one by one.
    pub cells: Box<dyn CellSource>,
    /// Findings, repairs and omissions, one sentence each.
    pub notes: Vec<String>,
}

/// Reads the mesh that `source` names, to be cut into clusters. Data sets whose cells can be told one by
/// one take no memory.
///
/// # Errors
/// As [`load`]; [`Error::Invalid`] for a regular grid and for a mesh that is in clusters already.
pub fn load_cells(source: &VolumeSource) -> Result<LoadedCells, Error> {
    check(source)?;
    if let Some(name) = &source.dataset {
        let cells = tetrascope_datasets::find(name)?.cells(&options(source))?;
        if let Some(cells) = cells {
            if let Some(wanted) = source.field.as_ref().filter(|f| *f != cells.field().0) {
                let (name, _) = cells.field();
                return Err(Error::NoSuchField {
                    name: wanted.clone(),
                    available: vec![name.to_owned()],
                });
            }
            let notes = Vec::new();
            return Ok(LoadedCells { cells, notes });
        }
    }
    let loaded = load(source)?;
    let refused = |what: &str| {
        Err(Error::Invalid {
            what: format!("{what}, and meshes are packed in clusters"),
            help: Some("draw it as it is".into()),
        })
    };
    match loaded.volume {
        Volume::Mesh(mesh) => Ok(LoadedCells {
            cells: Box::new(mesh),
            notes: loaded.notes,
        }),
        Volume::Clusters(_) => refused("the file holds a mesh in clusters already"),
        _ => refused("the volume is a regular grid"),
    }
}

/// A mesh with several of its fields.
#[derive(Clone, Debug)]
pub struct LoadedFields {
    /// The mesh, with the first of the fields.
    pub mesh: TetMesh,
    /// The fields, under names that differ.
    pub fields: Vec<Scalars>,
    /// Findings, repairs and omissions, one sentence each.
    pub notes: Vec<String>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Reads or makes the mesh that `source` names, with the fields of these names, each found as
/// [`load`] finds one; with all fields for `None`, and the one that [`load`] takes for no names.
///
/// Where two fields have one name, that of the cells is followed by " (cell)".
///
/// # Errors
/// As [`load`]; [`Error::Invalid`] also for a regular grid.
pub fn load_fields(source: &VolumeSource, names: Option<&[String]>) -> Result<LoadedFields, Error> {
    let mut data = match open(source)? {
        Opened::Mesh(data) => data,
        Opened::Dataset(name) => {
            let fields = names.unwrap_or_default();
            for field in fields {
                let field = Some(field.clone());
                from_dataset(
                    name,
                    &VolumeSource {
                        field,
                        ..source.clone()
                    },
                )?;
            }
            let Volume::Mesh(mesh) = from_dataset(name, source)?.volume else {
                unreachable!("a grid was opened as one");
            };
            return Ok(LoadedFields {
                fields: vec![mesh.scalars().clone()],
                notes: mesh.report().notes(),
                mesh,
                files: Vec::new(),
            });
        }
        Opened::Clusters(_) => {
            return Err(Error::Invalid {
                what: "samples are taken of meshes in memory, and this one is in clusters".into(),
                help: Some("give the file that it was packed from".into()),
            });
        }
        Opened::Grid(_) => {
            return Err(Error::Invalid {
                what: "samples are taken of meshes, and this is a regular grid already".into(),
                help: Some("draw it as it is".into()),
            });
        }
    };
    let mut notes = std::mem::take(&mut data.notes);
    let files = std::mem::take(&mut data.files);
    let mut chosen = Vec::new();
    match names {
        // Of a mesh without any, `choose` says so.
        None if !data.fields.is_empty() => chosen.extend(0..data.fields.len()),
        None | Some([]) => {
            let (index, note) = data.choose(source.field.as_deref())?;
            notes.extend(note);
            chosen.push(index);
        }
        Some(names) => {
            for name in names {
                let (index, note) = data.choose(Some(name))?;
                if !chosen.contains(&index) {
                    notes.extend(note);
                    chosen.push(index);
                }
            }
        }
    }
    let mut fields: Vec<Scalars> = Vec::with_capacity(chosen.len());
    for index in chosen {
        let mut field = data.scalars(index)?;
        while fields.iter().any(|other| other.name == field.name) {
            field.name += &format!(" ({})", association(field.association));
        }
        fields.push(field);
    }
    let straight = data.into_straight(fields, straightening(source))?;
    notes.extend(straight.report.map(|report| report.to_string()));
    let fields = straight.scalars;
    let mesh = TetMesh::from_cells(straight.points, straight.cells, fields[0].clone())?;
    notes.extend(mesh.report().notes());
    Ok(LoadedFields {
        mesh,
        fields,
        notes,
        files,
    })
}

/// Refuses a source that names no volume, or two, and options that do not go with it;
/// nothing is read.
///
/// # Errors
/// [`Error::Invalid`], with what to leave out or to add.
pub fn check(source: &VolumeSource) -> Result<(), Error> {
    match (&source.file, &source.dataset) {
        (Some(_), Some(name)) => wrong(
            format!("a volume is a file or a data set, not both (data set '{name}')"),
            "remove one of the two",
        ),
        (Some(_), None) if source.cells.is_some() || source.seed.is_some() => wrong(
            "`cells` and `seed` are for data sets, and the volume is a file".into(),
            "leave them out",
        ),
        (None, Some(name)) if source.interpolation.is_some() && !is_grid(name) => {
            no_interpolation("the data set")
        }
        (None, Some(_)) if source.curved.is_some() => wrong(
            "`curved` is for files with curved cells, and the volume is a data set".into(),
            "leave it out",
        ),
        (_, None) if source.curved.is_some_and(|tolerance| !(tolerance > 0.0 && tolerance.is_finite())) => {
            wrong(
                "`curved` is a tolerance".into(),
                "give a number above 0, such as 1e-3",
            )
        }
        (None, Some(_)) if source.solution.is_some() => wrong(
            "`solution` is for Plot3D files, and the volume is a data set".into(),
            "leave it out",
        ),
        (_, Some(_)) if source.step.is_some() || source.time.is_some() => wrong(
            "`step` and `time` are for files with time steps, and the volume is a data set".into(),
            "leave them out",
        ),
        (Some(_), None) if source.step.is_some() && source.time.is_some() => wrong(
            "`step` and `time` choose a time step each".into(),
            "leave one of them out",
        ),
        (None, Some(_)) if source.has_raw_keys() => wrong(
            "`dims`, `type` and what goes with them are for raw files, and the volume is a data set"
                .into(),
            "leave them out",
        ),
        (Some(_), None) => source.raw_layout().map(drop),
        (None, Some(_)) => Ok(()),
        (None, None) => wrong(
            "the scene names no volume".into(),
            "add a `file` or a `dataset`",
        ),
    }
}

fn wrong(what: String, help: &str) -> Result<(), Error> {
    Err(Error::Invalid {
        what,
        help: Some(help.into()),
    })
}

fn no_interpolation(of: &str) -> Result<(), Error> {
    wrong(
        format!("`interpolation` is for regular grids, and {of} is a mesh"),
        "leave it out: values at points are interpolated, those of cells are constant in each",
    )
}

/// A source, read but not yet a volume.
enum Opened<'a> {
    Mesh(MeshData),
    Grid(GridData),
    Clusters(MeshClusters),
    Dataset(&'a str),
}

fn open(source: &VolumeSource) -> Result<Opened<'_>, Error> {
    check(source)?;
    let path = match (&source.file, &source.dataset) {
        (Some(path), _) => path,
        (None, Some(name)) => return open_dataset(name, source),
        (None, None) => return Err(Error::invalid("a volume that `check` refuses")),
    };
    let raw = source.raw_layout()?;
    // A raw layout has these already.
    let is_raw = raw.is_some();
    let number = source.step.map(StepChoice::Number);
    let options = ReadOptions {
        solution: source.solution.clone(),
        raw,
        spacing: source.spacing.filter(|_| !is_raw),
        origin: source.origin.filter(|_| !is_raw),
        step: number.or(source.time.map(StepChoice::Time)),
        ..ReadOptions::default()
    };
    match read_file(path, &options)? {
        FileData::Mesh(_) | FileData::Clusters(_) if source.interpolation.is_some() => {
            no_interpolation("the file")?;
            Err(Error::invalid("an interpolation that was refused"))
        }
        FileData::Mesh(data) => Ok(Opened::Mesh(data)),
        FileData::Clusters(_) if source.curved.is_some() => Err(Error::Invalid {
            what: "`curved` is for curved cells, and the file holds tetrahedra".into(),
            help: Some("leave it out; give it when the mesh is packed".into()),
        }),
        FileData::Clusters(clusters) => Ok(Opened::Clusters(clusters)),
        FileData::Grid(_) if source.curved.is_some() => Err(Error::Invalid {
            what: "`curved` is for meshes, and the file is a regular grid".into(),
            help: Some("leave it out".into()),
        }),
        FileData::Grid(data) => Ok(Opened::Grid(data)),
    }
}

fn is_grid(dataset: &str) -> bool {
    tetrascope_datasets::find(dataset).is_ok_and(Dataset::is_grid)
}

/// A data set that is a grid goes the way of grids in files.
fn open_dataset<'a>(name: &'a str, source: &VolumeSource) -> Result<Opened<'a>, Error> {
    let dataset = tetrascope_datasets::find(name)?;
    if !dataset.is_grid() {
        return Ok(Opened::Dataset(name));
    }
    let grid = dataset.grid(&options(source))?;
    Ok(Opened::Grid(GridData {
        fields: vec![GridField {
            name: name.into(),
            association: Association::Point,
            lattice: *grid.lattice(),
            samples: FieldSamples::Loaded(grid.samples().clone()),
            offset: 0.0,
        }],
        space: None,
        notes: Vec::new(),
        files: Vec::new(),
    }))
}

/// How large and how random a source wants its data set.
fn options(source: &VolumeSource) -> Options {
    Options {
        cells: source.cells,
        seed: source.seed,
    }
}

/// The part that a mesh lacks to be drawn.
fn lacks(data: &MeshData) -> Option<&'static str> {
    let is_volume = |&kind: &u8| volume_corners(kind).is_some();
    if !data.cells.types.iter().any(is_volume) {
        return Some("the mesh has no volume cells that can be drawn");
    }
    data.fields.is_empty().then_some("the mesh has no fields")
}

fn bare(mut data: MeshData, why: &'static str) -> Result<BareMesh, Error> {
    let fields = summaries(&data, None);
    let mut notes = std::mem::take(&mut data.notes);
    let counts = data.cell_counts();
    let MeshData { points, cells, .. } = data;
    let count = points.len();
    let mut bounds = Bounds::of(
        cells
            .connectivity
            .iter()
            .filter_map(|&point| points.get(usize::try_from(point).ok()?).copied()),
    );
    if bounds.is_empty() {
        bounds = Bounds::of(points.iter().copied());
    }
    let has_volume = counts
        .iter()
        .any(|&(kind, _)| volume_corners(kind).is_some());
    let mesh = match has_volume {
        true => {
            let nothing = Scalars {
                name: String::new(),
                association: Association::Point,
                values: vec![0.0; count],
            };
            let mesh = TetMesh::new(points, &cells, nothing)?;
            notes.extend(mesh.report().notes());
            Some(mesh)
        }
        false => None,
    };
    Ok(BareMesh {
        why,
        mesh,
        cells_by_type: counts.into_iter().collect(),
        points: count,
        bounds,
        fields,
        notes,
    })
}

/// The fields of a mesh, of which number `chosen` is drawn.
fn summaries(data: &MeshData, chosen: Option<usize>) -> Vec<FieldSummary> {
    let fields = data.fields.iter().enumerate();
    let fields = fields.map(|(i, field)| FieldSummary {
        name: field.name.clone(),
        association: association(field.association),
        range: field.range,
        drawn: chosen == Some(i),
        missing: None,
        offset: 0.0,
    });
    fields.collect()
}

fn from_mesh(
    mut data: MeshData,
    source: &VolumeSource,
    previous: Option<&Volume>,
) -> Result<Loaded, Error> {
    let (chosen, note) = data.choose(source.field.as_deref())?;
    let mut notes = std::mem::take(&mut data.notes);
    notes.extend(note);
    let files = std::mem::take(&mut data.files);
    let mut fields = summaries(&data, Some(chosen));
    let scalars = data.scalars(chosen)?;
    fields[chosen].missing = Some(missing(&scalars.values));
    let straight = data.into_straight(vec![scalars], straightening(source))?;
    let is_curved = straight.report.is_some();
    notes.extend(straight.report.map(|report| report.to_string()));
    let scalars = straight
        .scalars
        .into_iter()
        .next()
        .expect("the one that went in");
    let mut mesh = TetMesh::from_cells(straight.points, straight.cells, scalars)?;
    if is_curved {
        // It reaches beyond that of the corners.
        fields[chosen].range = mesh.scalar_range();
    }
    if let Some(Volume::Mesh(previous)) = previous {
        mesh = mesh.sharing_with(previous);
    }
    Ok(loaded(mesh, notes, fields, files))
}

fn from_grid(mut data: GridData, source: &VolumeSource) -> Result<Loaded, Error> {
    let (chosen, note) = data.choose(source.field.as_deref())?;
    let mut notes = std::mem::take(&mut data.notes);
    notes.extend(note);
    let files = std::mem::take(&mut data.files);
    let fields = data.fields.iter().enumerate();
    let fields = fields.map(|(i, field)| FieldSummary {
        name: field.name.clone(),
        association: association(field.association),
        range: field.samples.range(),
        drawn: i == chosen,
        missing: Some(field.samples.missing()),
        offset: field.offset,
    });
    let fields: Vec<FieldSummary> = fields.collect();
    let space = data.space;
    for field in &mut data.fields {
        let own = field.lattice.interpolation;
        field.lattice.interpolation = source.interpolation.unwrap_or(own);
    }
    let (volume, field) = data.into_volume(source.field.as_deref())?;
    let (lattice, sample_type) = match &volume {
        Volume::Grid(grid) => (*grid.lattice(), grid.samples().sample_type()),
        Volume::Stream(stream) => (stream.source().lattice(), stream.source().sample_type()),
        _ => return Err(Error::invalid("a grid that is none")),
    };
    let [nx, ny, nz] = lattice.dims;
    let [x, y, z] = lattice.spacing.to_array().map(number::exact);
    let filled = match lattice.interpolation {
        Interpolation::Linear => "",
        Interpolation::Nearest => ", each in a cell of its own",
    };
    Ok(Loaded {
        description: format!(
            "{nx}×{ny}×{nz} samples of {}, {x}×{y}×{z} apart{filled}, field '{field}'",
            sample_type.name()
        ),
        volume,
        field,
        notes,
        fields,
        files,
        space,
    })
}

/// Only the directory is read. Missing values are therefore not counted, and the file is identified by its checksum, not
/// listed among the files that were read.
fn from_clusters(clusters: MeshClusters, source: &VolumeSource) -> Result<Loaded, Error> {
    let from = clusters.source();
    let (name, of) = from.field();
    let field = FieldSummary {
        name: name.to_owned(),
        association: association(of),
        range: clusters.scalar_range(),
        drawn: true,
        missing: None,
        offset: 0.0,
    };
    if let Some(wanted) = source.field.as_ref().filter(|wanted| *wanted != name) {
        return Err(Error::NoSuchField {
            name: wanted.clone(),
            available: vec![name.to_owned()],
        });
    }
    let checksum = from.checksum().map_or(String::new(), |checksum| {
        format!(" with the checksum {checksum:08x}")
    });
    Ok(Loaded {
        description: format!(
            "{} in {}{checksum}, field '{name}' ({})",
            tetrahedra(clusters.cell_count() as u64),
            number::count(from.clusters().len() as u64, "cluster", "clusters"),
            association(of)
        ),
        field: name.to_owned(),
        volume: Volume::Clusters(clusters.clone()),
        notes: Vec::new(),
        fields: vec![field],
        files: Vec::new(),
        space: None,
    })
}

/// How many are no values.
fn missing(values: &[f64]) -> u64 {
    values.iter().filter(|value| !is_value(**value)).count() as u64
}

/// The tolerance that is asked for curved cells; the default where none is.
fn straightening(source: &VolumeSource) -> Straightening {
    source
        .curved
        .map_or_else(Straightening::default, Straightening::to)
}

/// A scene that shows a data set well at its default size.
pub fn scene(dataset: &Dataset) -> SceneFile {
    let look = dataset.look();
    SceneFile {
        camera: CameraSpec {
            fit: Some(look.fit),
            ..CameraSpec::default()
        },
        appearance: AppearanceSpec {
            transfer_function: Some(look.knots),
            ..AppearanceSpec::default()
        },
        ..SceneFile::new(VolumeSource {
            dataset: Some(dataset.name.into()),
            ..VolumeSource::default()
        })
    }
}

fn from_dataset(name: &str, source: &VolumeSource) -> Result<Loaded, Error> {
    let mesh = tetrascope_datasets::find(name)?.mesh(&options(source))?;
    let field = FieldSummary {
        name: mesh.scalars().name.clone(),
        association: association(mesh.scalars().association),
        range: mesh.scalar_range(),
        drawn: true,
        missing: Some(missing(&mesh.scalars().values)),
        offset: 0.0,
    };
    if let Some(wanted) = source
        .field
        .as_ref()
        .filter(|wanted| **wanted != field.name)
    {
        let range = field
            .range
            .map_or(String::new(), |range| format!(" {}", number::range(range)));
        return Err(Error::NoSuchField {
            name: wanted.clone(),
            available: vec![format!("{}{range} ({})", field.name, field.association)],
        });
    }
    Ok(loaded(mesh, Vec::new(), vec![field], Vec::new()))
}

/// VTK's number.
const VTK_TETRA: u8 = 10;

fn loaded(
    mesh: TetMesh,
    mut notes: Vec<String>,
    fields: Vec<FieldSummary>,
    files: Vec<PathBuf>,
) -> Loaded {
    let report = mesh.report();
    notes.extend(report.notes());
    let mut description = tetrahedra(mesh.cell_count() as u64);
    if report.cells_by_type.keys().any(|&kind| kind != VTK_TETRA) {
        let counts = report.cells_by_type.iter();
        let counts = counts.map(|(&kind, count)| format!("{} × {count}", type_name(kind)));
        let counts: Vec<String> = counts.collect();
        description += &format!(" from {}", counts.join(", "));
    }
    description += &format!(
        ", field '{}' ({})",
        mesh.scalars().name,
        association(mesh.scalars().association)
    );
    Loaded {
        field: mesh.scalars().name.clone(),
        volume: Volume::Mesh(mesh),
        description,
        notes,
        fields,
        files,
        space: None,
    }
}

fn tetrahedra(count: u64) -> String {
    number::count(count, "tetrahedron", "tetrahedra")
}

fn association(association: Association) -> &'static str {
    match association {
        Association::Point => "point",
        Association::Cell => "cell",
    }
}
