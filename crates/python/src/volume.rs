//! The volume that is drawn: a mesh or a grid, of arrays or of a file.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::grid::{Interpolation, Lattice, Samples};
use tetrascope::core::mesh::curved::{self, Extra, Straightening};
use tetrascope::core::mesh::{Association, type_name};
use tetrascope::core::{self, Cells, Error, Grid, Scalars, TetMesh, is_value};
use tetrascope::scene::VolumeSource;
use tetrascope::volumes::{FieldSummary, Loaded, load_step};

use crate::arrays::{self, Counts, Even, Indices, Padded, Tetrahedra};
use crate::errors::exception;
use crate::scene::parsed;
use crate::work::run;

/// A volume with the field that is drawn.
#[pyclass(frozen, module = "tetrascope._tetrascope")]
pub(crate) struct Volume {
    pub(crate) volume: core::Volume,
    description: String,
    notes: Vec<String>,
    fields: Vec<FieldSummary>,
    files: Vec<PathBuf>,
    /// The mesh as it was given, if its curved cells were cut into straight ones.
    given: Option<Arc<Given>>,
}

/// Points and cells of a mesh with curved cells: other scalars are at these points, and may need
/// finer parts.
struct Given {
    points: Vec<DVec3>,
    cells: Cells,
    how: Straightening,
}

/// VTK's number of a tetrahedron.
const TETRAHEDRON: u8 = 10;

/// Cells as they were packed.
enum Packed {
    Tetrahedra(Vec<[u32; 4]>),
    Any(Cells),
}

/// A mesh of arrays that Python has prepared: `points` are three floats each; `types` are bytes,
/// or one for all cells; `cells` are indices, by `offsets`, or `width` for each cell, or with
/// their number before them. `curved` is how far straight parts of curved cells may be off.
#[pyfunction]
#[pyo3(signature = (points, cells, types, offsets, width, scalars, association, name, curved))]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub(crate) fn mesh(
    py: Python<'_>,
    points: &Bound<'_, PyAny>,
    cells: &Bound<'_, PyAny>,
    types: &Bound<'_, PyAny>,
    offsets: Option<&Bound<'_, PyAny>>,
    width: Option<usize>,
    scalars: &Bound<'_, PyAny>,
    association: &str,
    name: String,
    curved: Option<f64>,
) -> PyResult<Volume> {
    let how = curved.map_or_else(Straightening::default, Straightening::to);
    let notes = Vec::new();
    let points = arrays::points(points)?;
    let indices = Indices::of(cells, "cells")?;
    let offsets = match offsets {
        Some(offsets) => Some(Indices::of(offsets, "offsets")?),
        None => None,
    };
    let scalars = Scalars {
        name,
        association: association_of(association),
        values: arrays::reals(scalars, "scalars")?,
    };
    let packed = match types.extract::<u8>() {
        Ok(all) => of_one_type(&indices, all, width.unwrap_or(0))?,
        Err(_) => {
            let types = arrays::bytes(types, "celltypes")?;
            of_types(&indices, types, offsets.as_ref())?
        }
    };
    let packed = packed.map_err(|error| exception(py, &error))?;
    run(py, move || {
        let mesh = match packed {
            Packed::Tetrahedra(cells) => TetMesh::from_tetrahedra(points, cells, scalars)?,
            Packed::Any(cells)
                if cells
                    .types
                    .iter()
                    .any(|kind| curved::is_straightened(*kind)) =>
            {
                let given = Given { points, cells, how };
                return Volume::of_curved(Arc::new(given), scalars, notes);
            }
            Packed::Any(cells) => TetMesh::from_cells(points, cells, scalars)?,
        };
        Ok(Volume::of_mesh(mesh, notes))
    })
}

/// Cells of one type, with `width` points each.
fn of_one_type(indices: &Indices, kind: u8, width: usize) -> PyResult<Result<Packed, Error>> {
    if kind == TETRAHEDRON && width == 4 {
        let found = indices.read(Tetrahedra::<4>)?;
        if let Some(found) = found.transpose() {
            return Ok(found.map(Packed::Tetrahedra));
        }
    }
    let count = indices.len().checked_div(width).unwrap_or(0);
    let connectivity = indices.read(Counts {
        what: "point number",
    })?;
    Ok(connectivity.map(|connectivity| {
        Packed::Any(Cells {
            types: vec![kind; count],
            offsets: (0..=count).map(|cell| (cell * width) as u64).collect(),
            connectivity,
        })
    }))
}

/// Cells with a type each, by offsets or with their number of points before these.
fn of_types(
    indices: &Indices,
    types: Vec<u8>,
    offsets: Option<&Indices>,
) -> PyResult<Result<Packed, Error>> {
    let only_tetrahedra = !types.is_empty() && types.iter().all(|&kind| kind == TETRAHEDRON);
    let Some(offsets) = offsets else {
        if only_tetrahedra && indices.len() == types.len() * 5 {
            let found = indices.read(Tetrahedra::<5>)?;
            if let Some(found) = found.transpose() {
                return Ok(found.map(Packed::Tetrahedra));
            }
        }
        let padded = indices.read(Padded { cells: types.len() })?;
        return Ok(padded.map(|(offsets, connectivity)| {
            Packed::Any(Cells {
                types,
                offsets,
                connectivity,
            })
        }));
    };
    let fits = offsets.len() == types.len() + 1 && indices.len() == types.len() * 4;
    if only_tetrahedra && fits && offsets.read(Even { points: 4 })? {
        let found = indices.read(Tetrahedra::<4>)?;
        if let Some(found) = found.transpose() {
            return Ok(found.map(Packed::Tetrahedra));
        }
    }
    let offsets = offsets.read(Counts { what: "offset" })?;
    let connectivity = indices.read(Counts {
        what: "point number",
    })?;
    Ok(offsets.and_then(|offsets| {
        Ok(Packed::Any(Cells {
            types,
            offsets,
            connectivity: connectivity?,
        }))
    }))
}

/// A grid of samples that Python has prepared, x fastest; the columns of `direction` are the
/// directions of its axes.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub(crate) fn grid(
    py: Python<'_>,
    samples: &Bound<'_, PyAny>,
    dims: [usize; 3],
    spacing: [f64; 3],
    origin: [f64; 3],
    direction: [[f64; 3]; 3],
    nearest: bool,
    name: String,
    notes: Vec<String>,
) -> PyResult<Volume> {
    let samples = arrays::samples(samples)?;
    let interpolation = match nearest {
        true => Interpolation::Nearest,
        false => Interpolation::Linear,
    };
    let lattice = Lattice {
        dims,
        origin: DVec3::from_array(origin),
        spacing: DVec3::from_array(spacing),
        // Rows are given, and kept as columns.
        direction: DMat3::from_cols_array_2d(&direction).transpose(),
        interpolation,
    };
    run(py, move || Volume::of_grid(lattice, samples, name, notes))
}

/// The volume that a file or a data set holds; `source` is JSON, of a scene's `[volume]`, without
/// its file. A mesh shares geometry with that of `previous`, if it is the same.
#[pyfunction]
#[pyo3(signature = (file, source, previous=None))]
pub(crate) fn load(
    py: Python<'_>,
    file: Option<PathBuf>,
    source: &str,
    previous: Option<&Volume>,
) -> PyResult<Volume> {
    let mut source: VolumeSource = parsed(py, source)?;
    source.file = file;
    let previous = previous.map(|previous| previous.volume.clone());
    run(py, move || {
        let loaded = load_step(&source, previous.as_ref())?;
        let Loaded {
            volume,
            description,
            notes,
            fields,
            files,
            ..
        } = loaded;
        Ok(Volume {
            volume,
            description,
            notes,
            fields,
            files,
            given: None,
        })
    })
}

impl Volume {
    /// A mesh of which curved cells become straight ones, as in files.
    fn of_curved(
        given: Arc<Given>,
        scalars: Scalars,
        mut notes: Vec<String>,
    ) -> Result<Volume, Error> {
        let Given { points, cells, how } = &*given;
        let straight = curved::straighten(
            points.clone(),
            cells.clone(),
            vec![scalars],
            &Extra::default(),
            *how,
        )?;
        notes.extend(straight.report.map(|report| report.to_string()));
        let scalars = straight.scalars.into_iter().next();
        let scalars = scalars.expect("the one that went in");
        let mesh = TetMesh::from_cells(straight.points, straight.cells, scalars)?;
        Ok(Volume {
            given: Some(given),
            ..Volume::of_mesh(mesh, notes)
        })
    }

    fn of_mesh(mesh: TetMesh, mut notes: Vec<String>) -> Volume {
        let report = mesh.report();
        notes.extend(report.notes());
        let kinds = report.cells_by_type.iter();
        let kinds = kinds.map(|(&kind, count)| format!("{} × {count}", type_name(kind)));
        let field = summary(&mesh.scalars().name, mesh.scalars().association, &mesh);
        Volume {
            description: format!(
                "{} tetrahedra from {}, field '{}' ({})",
                mesh.cell_count(),
                kinds.collect::<Vec<_>>().join(", "),
                field.name,
                field.association
            ),
            volume: core::Volume::Mesh(mesh),
            notes,
            fields: vec![field],
            files: Vec::new(),
            given: None,
        }
    }

    fn of_grid(
        lattice: Lattice,
        samples: Samples,
        name: String,
        notes: Vec<String>,
    ) -> Result<Volume, Error> {
        let field = FieldSummary {
            association: match lattice.interpolation {
                Interpolation::Linear => "point",
                Interpolation::Nearest => "cell",
            },
            range: samples.range(),
            drawn: true,
            missing: Some(samples.missing()),
            offset: 0.0,
            name,
        };
        let [nx, ny, nz] = lattice.dims;
        let kind = samples.sample_type().name();
        Ok(Volume {
            description: format!("{nx}×{ny}×{nz} samples of {kind}, field '{}'", field.name),
            volume: core::Volume::Grid(Grid::on(lattice, samples)?),
            notes,
            fields: vec![field],
            files: Vec::new(),
            given: None,
        })
    }
}

fn summary(name: &str, association: Association, mesh: &TetMesh) -> FieldSummary {
    let values = mesh.scalars().values.iter();
    FieldSummary {
        name: name.into(),
        association: match association {
            Association::Point => "point",
            Association::Cell => "cell",
        },
        range: mesh.scalar_range(),
        drawn: true,
        missing: Some(values.filter(|value| !is_value(**value)).count() as u64),
        offset: 0.0,
    }
}

fn association_of(word: &str) -> Association {
    match word {
        "cell" => Association::Cell,
        _ => Association::Point,
    }
}

#[pymethods]
impl Volume {
    /// The same geometry with other scalars of a mesh, or other samples of a grid.
    fn with_scalars(
        &self,
        py: Python<'_>,
        scalars: &Bound<'_, PyAny>,
        association: &str,
        name: String,
    ) -> PyResult<Volume> {
        match &self.volume {
            core::Volume::Mesh(mesh) => {
                let scalars = Scalars {
                    name,
                    association: association_of(association),
                    values: arrays::reals(scalars, "scalars")?,
                };
                let (mesh, given) = (mesh.clone(), self.given.clone());
                run(py, move || match given {
                    None => Ok(Volume::of_mesh(mesh.with_scalars(scalars)?, Vec::new())),
                    Some(given) => {
                        let mut volume = Volume::of_curved(given, scalars, Vec::new())?;
                        if let core::Volume::Mesh(next) = volume.volume {
                            volume.volume = core::Volume::Mesh(next.sharing_with(&mesh));
                        }
                        Ok(volume)
                    }
                })
            }
            core::Volume::Grid(grid) => {
                let samples = arrays::samples(scalars)?;
                let lattice = *grid.lattice();
                run(py, move || {
                    Volume::of_grid(lattice, samples, name, Vec::new())
                })
            }
            _ => {
                let error = Error::invalid("a volume that stays in its file has no other scalars");
                Err(exception(py, &error))
            }
        }
    }

    /// "mesh" or "grid".
    #[getter]
    fn kind(&self) -> &'static str {
        match &self.volume {
            core::Volume::Mesh(_) | core::Volume::Clusters(_) => "mesh",
            _ => "grid",
        }
    }

    /// One line: cells before and after splitting, and the field.
    #[getter]
    fn description(&self) -> &str {
        &self.description
    }

    /// Findings, repairs and omissions, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Every scalar field that the source offers, as JSON.
    #[getter]
    fn fields_json(&self) -> String {
        json!(self.fields).to_string()
    }

    /// The files that were read.
    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    /// (xmin, xmax, ymin, ymax, zmin, zmax), world units.
    #[getter]
    fn bounds(&self) -> [f64; 6] {
        let core::Bounds { min, max } = self.volume.bounds();
        [min.x, max.x, min.y, max.y, min.z, max.z]
    }

    /// The least and greatest finite value, if there is any.
    #[getter]
    fn range(&self) -> Option<(f64, f64)> {
        self.volume.scalar_range()
    }

    /// How many tetrahedra or voxel cells there are.
    #[getter]
    fn n_cells(&self) -> usize {
        self.volume.cell_count()
    }

    /// How many points or samples there are; of a mesh with curved cells, as it was given.
    #[getter]
    fn n_points(&self) -> usize {
        if let Some(given) = &self.given {
            return given.points.len();
        }
        match &self.volume {
            core::Volume::Mesh(mesh) => mesh.points().len(),
            core::Volume::Clusters(mesh) => {
                let clusters = mesh.source().clusters().iter();
                clusters.map(|cluster| cluster.points as usize).sum()
            }
            _ => self.dims().map_or(0, |dims| dims.iter().product()),
        }
    }

    /// How many cells a mesh was given with, for values of cells.
    #[getter]
    fn n_input_cells(&self) -> usize {
        if let Some(given) = &self.given {
            return given.cells.types.len();
        }
        match &self.volume {
            core::Volume::Mesh(mesh) => mesh.input_cell_count(),
            _ => self.volume.cell_count(),
        }
    }

    /// Samples of a grid along each axis.
    #[getter]
    fn dims(&self) -> Option<[usize; 3]> {
        match &self.volume {
            core::Volume::Grid(grid) => Some(grid.dims()),
            core::Volume::Stream(stream) => Some(stream.source().lattice().dims),
            _ => None,
        }
    }

    /// Whether the geometry is shared, so that only scalars differ.
    fn shares_geometry(&self, other: &Volume) -> bool {
        match (&self.volume, &other.volume) {
            (core::Volume::Mesh(a), core::Volume::Mesh(b)) => a.shares_geometry(b),
            _ => false,
        }
    }
}
