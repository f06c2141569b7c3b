//! Meshes, sizes and samples of a sweep.

use std::path::PathBuf;

use tetrascope::core::{Error, TetMesh, text};
use tetrascope::datasets;
use tetrascope::scene::VolumeSource;
use tetrascope::volumes;
use tetrascope_testing::{BLUNT_FIN, data_path, read_blunt_fin};

use super::Options;

/// Fragment generators of the published machines.
pub(super) const GENERATORS: [u32; 3] = [5, 10, 20];

/// Tetrahedra of the Blunt Fin: 37 479 hexahedra (section 6.2), in five each.
const BLUNT_FIN_CELLS: u64 = 5 * 37_479;

/// Meshes, sizes and samples, all with each other.
pub(super) struct Plan {
    pub(super) meshes: Vec<PlannedMesh>,
    /// Voxels along the longest axis, ascending.
    pub(super) sides: Vec<usize>,
    /// Samples along each axis of a voxel.
    pub(super) samples: Vec<u32>,
}

/// A mesh that is not there yet.
pub(super) struct PlannedMesh {
    pub(super) name: String,
    pub(super) source: Source,
    /// A remark on it.
    pub(super) note: Option<String>,
}

pub(super) enum Source {
    BluntFin(PathBuf),
    Dataset {
        dataset: &'static str,
        cells: Option<u64>,
    },
    File(PathBuf),
}

/// The plan for what a person asks.
pub(super) fn plan(options: &Options) -> Result<Plan, Error> {
    let meshes = match options.meshes.is_empty() {
        true => vec![staircase(), blunt_fin(data_path(BLUNT_FIN))],
        false => options.meshes.iter().map(file).collect::<Result<_, _>>()?,
    };
    let (sides, samples) = match options.quick {
        true => (vec![32, 64], vec![1]),
        false => (vec![64, 128, 256], vec![1, 2, 3]),
    };
    Ok(Plan {
        meshes,
        sides,
        samples,
    })
}

fn staircase() -> PlannedMesh {
    PlannedMesh {
        name: "Staircase".into(),
        source: Source::Dataset {
            dataset: "staircase",
            cells: None,
        },
        note: Some("23 hexahedra of one scalar, each in six tetrahedra".into()),
    }
}

/// The Blunt Fin, or where it is not a mesh of as many cells, which is said.
fn blunt_fin(path: PathBuf) -> PlannedMesh {
    if path.is_file() {
        return PlannedMesh {
            name: "Blunt Fin".into(),
            source: Source::BluntFin(path),
            note: Some("37 479 hexahedra, each in five tetrahedra".into()),
        };
    }
    let path = path.display();
    let note = format!("in place of the Blunt Fin, as there is no {path}");
    eprintln!("`graded` {note}; TETRASCOPE_DATA names the folder of data");
    PlannedMesh {
        name: "graded".into(),
        source: Source::Dataset {
            dataset: "graded",
            cells: Some(BLUNT_FIN_CELLS),
        },
        note: Some(note),
    }
}

/// A file of the command line; refused before anything is simulated if there is none.
fn file(path: &PathBuf) -> Result<PlannedMesh, Error> {
    std::fs::metadata(path).map_err(|source| Error::Io {
        action: "cannot read",
        path: path.clone(),
        source,
    })?;
    Ok(PlannedMesh {
        name: text::printable(&path.to_string_lossy()).into_owned(),
        source: Source::File(path.clone()),
        note: None,
    })
}

impl Plan {
    /// Where sensitivities are found, and what the answer is about: 128 voxels, the size of the paper's
    /// section 4, or the largest below.
    pub(super) fn standard_side(&self) -> usize {
        let sides = self.sides.iter().copied().filter(|side| *side <= 128);
        sides.max().unwrap_or(self.sides[0])
    }

    /// Machines to simulate, and sensitivities.
    pub(super) fn steps(&self) -> u64 {
        let configurations = self.sides.len() * self.samples.len() * GENERATORS.len();
        (self.meshes.len() * (configurations + 1)) as u64
    }
}

impl PlannedMesh {
    pub(super) fn load(&self) -> Result<TetMesh, Error> {
        match &self.source {
            Source::BluntFin(path) => read_blunt_fin(path),
            Source::Dataset { dataset, cells } => {
                let options = datasets::Options {
                    cells: *cells,
                    seed: None,
                };
                datasets::find(dataset)?.mesh(&options)
            }
            Source::File(path) => {
                let source = VolumeSource {
                    file: Some(path.clone()),
                    ..VolumeSource::default()
                };
                Ok(volumes::load_fields(&source, Some(&[]))?.mesh)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_has_a_place_holder_or_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let missing = folder.path().join("missing.vtu");
        let planned = blunt_fin(missing.clone());
        assert_eq!(planned.name, "graded");
        let cells = planned.load().expect("a data set").cell_count() as f64;
        // The nearest lattice with a whole number of cubes along each axis.
        assert!(
            (cells / BLUNT_FIN_CELLS as f64 - 1.0).abs() < 0.2,
            "{cells}"
        );
        let options = Options {
            quick: true,
            meshes: vec![missing.clone()],
            out: None,
        };
        let error = plan(&options).err().expect("there is no such file");
        assert!(error.to_string().contains("missing.vtu"), "{error}");
        std::fs::write(&missing, "<VTKFile/>").expect("written");
        let plan = plan(&options).expect("there is such a file");
        assert!(plan.meshes[0].name.ends_with("missing.vtu"));
        assert_eq!((plan.standard_side(), plan.steps()), (64, 7));
    }
}
