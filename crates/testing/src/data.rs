//! Real data, where it is: in the folder that the environment variable `TETRASCOPE_DATA` names,
//! or in `../shared/data` beside the repository.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tetrascope_core::mesh::Split;
use tetrascope_core::{Error, TetMesh};
use tetrascope_io::{MeshData, ReadOptions, read_mesh};

use crate::{point_scalars, say};

/// Where the data file `name` is looked for.
pub fn data_path(name: &str) -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("TETRASCOPE_DATA").map_or_else(beside, PathBuf::from);
    folder.join(name)
}

/// The path of a data file; without it, says that `test` is skipped.
pub fn file(test: &str, name: &str) -> Option<PathBuf> {
    let path = data_path(name);
    if !path.is_file() {
        say(&format!("skipped: {test}: there is no {}", path.display()));
        return None;
    }
    Some(path)
}

/// The mesh in a data file.
pub fn mesh_data(test: &str, name: &str) -> Option<MeshData> {
    let path = file(test, name)?;
    Some(read_mesh(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}")))
}

/// The Blunt Fin and its density, each hexahedron in five.
pub fn blunt_fin(test: &str) -> Option<TetMesh> {
    let path = file(test, BLUNT_FIN)?;
    let mesh = read_blunt_fin(&path).unwrap_or_else(|error| panic!("{error}"));
    // Of the 187 395 of the paper, those with four corners at different places.
    assert_eq!(mesh.cell_count(), 187_395 - 77);
    Some(mesh)
}

/// The Blunt Fin's file.
pub const BLUNT_FIN: &str = "bluntfinxyz.bin";

/// The Blunt Fin in the file `path` and its density, each hexahedron in five; it keeps the
/// hexahedra.
///
/// # Errors
/// Those of the file.
pub fn read_blunt_fin(path: &Path) -> Result<TetMesh, Error> {
    let data = read_mesh(path, &ReadOptions::default())?;
    let field = data.field(Some("density"))?;
    let cells = Arc::new(data.cells);
    TetMesh::keeping_cells(data.points, cells, field, Split::FiveAlternating)
}

/// The Super Phoenix.
pub fn super_phoenix(test: &str) -> Option<TetMesh> {
    let data = mesh_data(test, "spx.vtu")?;
    Some(data.into_mesh(None).expect("a mesh"))
}

/// The Liquid Oxygen Post and its energy.
pub fn liquid_oxygen_post(test: &str) -> Option<TetMesh> {
    let data = mesh_data(test, "postxyz.bin")?;
    let field = data.fields.iter().find(|f| f.name.contains("energy"));
    let field = field.map(|field| field.name.clone());
    Some(data.into_mesh(field.as_deref()).expect("a mesh"))
}

/// Seven blocks that touch but share no point; the field is the distance from the origin, as
/// the file's own numbers the points.
pub fn angular_sector(test: &str) -> Option<TetMesh> {
    let data = mesh_data(test, "AngularSector.vtk")?;
    let distances = data.points.iter().map(|p| p.length()).collect();
    let mesh = TetMesh::new(data.points, &data.cells, point_scalars(distances));
    Some(mesh.expect("a mesh"))
}
