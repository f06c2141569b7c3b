//! A shot as files that `tetrascope render` opens: a scene, and beside it what it draws.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use tetrascope::core::mesh::Association;
use tetrascope::core::{Error, TetMesh, Volume};
use tetrascope::io::Compression;
use tetrascope::scene::{Scene, VolumeSource};

use super::case::Shot;
use crate::output::write;

/// Writes the shot into a folder, which is made, and returns the scene's file.
///
/// # Errors
/// Errors of the file system, and a grid that stays in its file.
pub fn keep(folder: &Path, name: &str, shot: &Shot) -> Result<PathBuf, Error> {
    let kept = |c: char| if c.is_alphanumeric() { c } else { '-' };
    let name: String = name.chars().map(kept).collect();
    let volume = match &shot.volume {
        Volume::Mesh(mesh) => {
            let path = folder.join(format!("{name}.vtk"));
            write(&path, legacy_vtk(mesh))?;
            path
        }
        Volume::Grid(grid) => {
            let path = folder.join(format!("{name}.vti"));
            std::fs::create_dir_all(folder).map_err(|source| Error::Io {
                action: "cannot write",
                path: folder.into(),
                source,
            })?;
            let arrays = [("s", grid.samples())];
            tetrascope::io::write_vti(&path, grid.lattice(), &arrays, Compression::Zlib)?;
            path
        }
        _ => return Err(Error::invalid("a grid that stays in its file")),
    };
    let scene = Scene {
        // Beside the scene.
        source: VolumeSource {
            file: volume.file_name().map(PathBuf::from),
            ..VolumeSource::default()
        },
        appearance: shot.appearance.clone(),
        view: shot.view,
        defaults: Vec::new(),
    };
    let path = folder.join(format!("{name}.toml"));
    write(&path, scene.to_toml())?;
    Ok(path)
}

/// A mesh in VTK's legacy format, as text: numbers with all their digits.
fn legacy_vtk(mesh: &TetMesh) -> String {
    let (points, cells, scalars) = (mesh.points(), mesh.tetrahedra(), mesh.scalars());
    let mut text = String::from(
        "# vtk DataFile Version 3.0\nkept by the harness\nASCII\nDATASET UNSTRUCTURED_GRID\n",
    );
    // Writing to a string cannot fail.
    _ = writeln!(text, "POINTS {} double", points.len());
    for p in points {
        _ = writeln!(text, "{:e} {:e} {:e}", p.x, p.y, p.z);
    }
    _ = writeln!(text, "CELLS {} {}", cells.len(), 5 * cells.len());
    for [a, b, c, d] in cells {
        _ = writeln!(text, "4 {a} {b} {c} {d}");
    }
    _ = writeln!(
        text,
        "CELL_TYPES {}\n{}",
        cells.len(),
        "10\n".repeat(cells.len())
    );
    let values: Vec<f64> = match scalars.association {
        Association::Point => {
            _ = writeln!(text, "POINT_DATA {}", points.len());
            scalars.values.clone()
        }
        Association::Cell => {
            _ = writeln!(text, "CELL_DATA {}", cells.len());
            (0..cells.len())
                .map(|cell| mesh.cell_scalars(cell)[0])
                .collect()
        }
    };
    text += "SCALARS s double 1\nLOOKUP_TABLE default\n";
    for value in values {
        _ = writeln!(text, "{value:e}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::suite;

    #[test]
    fn kept_scenes_are_read_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        let cases = suite();
        let names = [
            "geometry: needles and caps",
            "laws: values of cells and of their own corners",
            "values: NaN at vertices",
            "grids: all that 16 bits hold",
        ];
        for name in names {
            let case = cases.iter().find(|case| format!("{case:?}") == name);
            let shot = case.expect("a case").shots.last().expect("a shot");
            let path = keep(folder.path(), name, shot).expect("written");
            let file = tetrascope::scene::SceneFile::read(&path).expect("a scene");
            let loaded = tetrascope::volumes::load(&file.volume)
                .expect("a volume")
                .volume;
            let scene = file.resolve(&loaded).expect("complete");
            assert_eq!(scene.appearance, shot.appearance, "{name}");
            assert_eq!(scene.view, shot.view, "{name}");
            match (&loaded, &shot.volume) {
                (Volume::Mesh(read), Volume::Mesh(kept)) => {
                    assert_eq!(read.points(), kept.points(), "{name}");
                    assert_eq!(read.tetrahedra(), kept.tetrahedra(), "{name}");
                    let of = |mesh: &TetMesh, cell| mesh.cell_scalars(cell).map(f64::to_bits);
                    for cell in 0..kept.cell_count() {
                        assert_eq!(of(read, cell), of(kept, cell), "{name}");
                    }
                }
                (Volume::Grid(read), Volume::Grid(kept)) => {
                    assert_eq!(read.lattice(), kept.lattice(), "{name}");
                    assert_eq!(read.samples(), kept.samples(), "{name}");
                }
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}
