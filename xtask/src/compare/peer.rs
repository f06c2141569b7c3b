//! VTK as a peer: its mappers draw the same scenes by `benches/peers/vtk_compare.py`, and stand in the
//! same tables and diagrams.
//!
//! Each mapper runs in a process of its own, as one may crash. Some of VTK's rays go through corners of
//! pixels: errors are given as they are and with that forgiven, that is, against the truth's rays
//! through the corner that fits best.

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;
use tetrascope::core::mesh::Association;
use tetrascope::core::{
    Error, Frame, FrameStats, OpticalModel, Projection, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope::io::{Compression, write_grid};
use tetrascope::scene::Scene;
use tetrascope::{Context, Promise, Settings};

use crate::machine;
use crate::metrics::{Errors, median};
use crate::output::write;
use crate::picture::{shown, signed_map};
use crate::report::{Difference, Drawn, Outcome, Picture, Row, Stats};

/// What VTK's rows are called.
pub(super) const VTK: &str = "vtk";

/// A mapper that takes longer is given up.
const PATIENCE: Duration = Duration::from_secs(120);

/// VTK, found.
pub(super) struct Peer {
    python: PathBuf,
    script: PathBuf,
    /// "VTK 9.5.0".
    pub(super) version: String,
    mesh: Vec<String>,
    grid: Vec<String>,
}

/// What the script says of itself.
#[derive(Deserialize)]
struct Listed {
    version: String,
    mesh: Vec<String>,
    grid: Vec<String>,
}

/// What the script says of a mapper.
#[derive(Deserialize)]
struct Measured {
    prepare_ms: f64,
    first_ms: f64,
    frames_ms: Vec<f64>,
    peak_bytes: u64,
}

impl Peer {
    /// Finds Python with VTK: `PYTHON` in the environment, else `python3`.
    ///
    /// # Errors
    /// The line to type where there is none.
    pub(super) fn find() -> Result<Peer, Error> {
        let python = std::env::var_os("PYTHON").map_or("python3".into(), PathBuf::from);
        let script = machine::root().join("benches/peers/vtk_compare.py");
        let missing = |why: String| Error::Invalid {
            what: format!("VTK cannot be run by `{}`: {why}", python.display()),
            help: Some(format!(
                "type `{} -m pip install vtk numpy`, or name another Python in the variable PYTHON",
                python.display()
            )),
        };
        let output = Command::new(&python).arg(&script).arg("--list").output();
        let output = output.map_err(|error| missing(error.to_string()))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().last().unwrap_or("it failed").to_owned();
            return Err(missing(last));
        }
        let listed: Listed = serde_json::from_slice(&output.stdout)
            .map_err(|error| missing(format!("its list is no JSON: {error}")))?;
        Ok(Peer {
            python,
            script,
            version: format!("VTK {}", listed.version),
            mesh: listed.mesh,
            grid: listed.grid,
        })
    }

    /// Rows and pictures of all mappers; a single reason where VTK does not draw such a scene.
    pub(super) fn draw(
        &self,
        context: &Context,
        volume: &Volume,
        scene: &Scene,
        truth: &Frame,
        repeat: u32,
    ) -> Result<(Vec<Row>, Vec<Picture>), Error> {
        let (mappers, reason) = match (volume, scene.appearance.optical_model) {
            (_, model) if !is_drawn(model) => (&[][..], "VTK's mappers draw no such model alike"),
            (Volume::Mesh(mesh), _) if mesh.scalars().association == Association::Cell => {
                (&[][..], "VTK's mappers interpolate values of points")
            }
            (Volume::Mesh(_), _) => (&self.mesh[..], ""),
            (Volume::Grid(_), _) => (&self.grid[..], ""),
            _ => (&[][..], "VTK holds whole grids in memory"),
        };
        if mappers.is_empty() {
            return Ok((vec![row("", Outcome::Skipped(reason.into()))], Vec::new()));
        }
        let folder = tempfile::tempdir().map_err(|source| Error::Io {
            action: "cannot make",
            path: std::env::temp_dir(),
            source,
        })?;
        let scene_file = folder.path().join("scene.toml");
        write(&scene_file, scene.to_toml())?;
        let file = match volume {
            Volume::Grid(grid) => {
                let file = folder.path().join("volume.vti");
                write_grid(&file, grid, "scalar", Compression::None)?;
                file
            }
            Volume::Mesh(mesh) => {
                let file = folder.path().join("volume.vtk");
                write(&file, legacy(mesh))?;
                file
            }
            _ => return Err(Error::invalid("a volume without mappers")),
        };
        let corners = corners(context, volume, scene)?;
        let (mut rows, mut pictures) = (Vec::new(), Vec::new());
        for mapper in mappers {
            let drawn = self.run(mapper, [&file, &scene_file], truth, repeat);
            match drawn {
                Err(why) => rows.push(row(mapper, Outcome::Skipped(why))),
                Ok((frame, measured)) => {
                    let fits = corners.iter().map(|c| Errors::between(c, &frame));
                    let best = fits.min_by(|a, b| a.image.rmse.total_cmp(&b.image.rmse));
                    let error = Errors::between(truth, &frame);
                    if let Some(best) = best.filter(|best| best.image.rmse < error.image.rmse) {
                        let setting = format!("{mapper},offset=forgiven");
                        rows.push(row(&setting, measured.outcome(best, volume)));
                    }
                    pictures.push(Picture {
                        algorithm: VTK.into(),
                        setting: mapper.clone(),
                        image: shown(&frame),
                        difference: Some(Difference {
                            map: signed_map(truth, &frame),
                            worst_pixel: error.image.worst_pixel,
                        }),
                    });
                    rows.push(row(mapper, measured.outcome(error, volume)));
                }
            }
        }
        Ok((rows, pictures))
    }

    /// One mapper's picture; why there is none, in words.
    fn run(
        &self,
        mapper: &str,
        [volume, scene]: [&Path; 2],
        truth: &Frame,
        repeat: u32,
    ) -> Result<(Frame, Measured), String> {
        let image = scene.with_file_name(format!("{mapper}.rgba"));
        let mut child = Command::new(&self.python)
            .arg(&self.script)
            .args([
                mapper.as_ref(),
                volume.as_os_str(),
                scene.as_os_str(),
                image.as_os_str(),
            ])
            .args(["--repeat", &repeat.to_string()])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| error.to_string())?;
        let start = Instant::now();
        let status = loop {
            match child.try_wait().map_err(|error| error.to_string())? {
                Some(status) => break status,
                None if start.elapsed() > PATIENCE => {
                    // Either is gone or will be: there is nothing to do about a failure.
                    _ = child.kill();
                    _ = child.wait();
                    return Err(format!("{mapper} took more than {} s", PATIENCE.as_secs()));
                }
                None => std::thread::sleep(Duration::from_millis(20)),
            }
        };
        if !status.success() {
            return Err(format!("{mapper} ended with {status}"));
        }
        let mut said = String::new();
        let stdout = child.stdout.as_mut().ok_or("no output")?;
        stdout
            .read_to_string(&mut said)
            .map_err(|e| e.to_string())?;
        // VTK may have said something before.
        let last = said.lines().last().unwrap_or_default();
        let measured = serde_json::from_str(last).map_err(|e| format!("{mapper}: {e}"))?;
        let bytes = std::fs::read(&image).map_err(|error| format!("{mapper}: {error}"))?;
        let numbers = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|b| f32::from_le_bytes(*b));
        let numbers: Vec<f32> = numbers.collect();
        let pixels = numbers.as_chunks::<4>().0.to_vec();
        let expected = truth.width as usize * truth.height as usize;
        match pixels.len() == expected {
            true => Ok((
                Frame::new((truth.width, truth.height), pixels, FrameStats::default()),
                measured,
            )),
            false => Err(format!(
                "{mapper} drew {} pixels, not {expected}",
                pixels.len()
            )),
        }
    }
}

/// Whether what VTK draws is this model: light that is emitted and absorbed, or absorbed alone where it
/// is black.
fn is_drawn(model: OpticalModel) -> bool {
    matches!(
        model,
        OpticalModel::EmissionAbsorption | OpticalModel::Absorption
    )
}

fn row(setting: &str, outcome: Outcome) -> Row {
    Row {
        algorithm: VTK.into(),
        setting: setting.into(),
        settings: String::new(),
        is_default: false,
        promise: Promise::Open,
        outcome,
    }
}

impl Measured {
    fn outcome(&self, error: Errors, volume: &Volume) -> Outcome {
        let first = [self.first_ms];
        let times = if self.frames_ms.is_empty() {
            &first
        } else {
            &self.frames_ms[..]
        };
        let middle = median(times).unwrap_or(self.first_ms);
        Outcome::Drawn(Box::new(Drawn {
            error: Some(error),
            prepare_ms: self.prepare_ms,
            first_ms: self.first_ms,
            frame_ms: middle,
            frame_range_ms: [
                times.iter().copied().fold(f64::INFINITY, f64::min),
                times.iter().copied().fold(0.0, f64::max),
            ],
            frames: self.frames_ms.len(),
            clock: "wall".into(),
            wall_ms: middle,
            restyle_ms: None,
            peak_bytes: Some(self.peak_bytes),
            stats: Stats {
                cpu_seconds: self.first_ms / 1e3,
                notes: vec![format!(
                    "a process of its own, with {} cells; pictures of 8 bits",
                    volume.cell_count()
                )],
                ..Stats::default()
            },
        }))
    }
}

/// The truth with its rays through each of the four corners of every pixel in place of the middle.
///
/// A picture that is a pixel wider and higher at the same size of a pixel has its pixels' middles at
/// the corners of the other's.
fn corners(context: &Context, volume: &Volume, scene: &Scene) -> Result<Vec<Frame>, Error> {
    let Some(truth) = tetrascope::truth() else {
        return Ok(Vec::new());
    };
    let View { width, height, .. } = scene.view;
    let mut view = View {
        width: width + 1,
        height: height + 1,
        ..scene.view
    };
    let taller = f64::from(view.height) / f64::from(height);
    view.camera.projection = match view.camera.projection {
        Projection::Perspective { view_angle } => Projection::Perspective {
            view_angle: 2.0
                * ((view_angle.to_radians() / 2.0).tan() * taller)
                    .atan()
                    .to_degrees(),
        },
        Projection::Orthographic { parallel_scale } => Projection::Orthographic {
            parallel_scale: parallel_scale * taller,
        },
    };
    let renderer = (truth.build)(
        context,
        volume,
        &scene.appearance,
        &Settings::defaults(truth),
    )?;
    let large = renderer.render(&view)?;
    let shifts = [(0, 0), (1, 0), (0, 1), (1, 1)];
    let shifted = shifts.map(|(x, y)| {
        let rows = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        let pixels = rows.map(|(column, row)| large.pixel(column + x, row + y));
        Frame::new((width, height), pixels.collect(), FrameStats::default())
    });
    Ok(shifted.into())
}

/// A mesh as a legacy VTK file, binary, which is big-endian.
fn legacy(mesh: &TetMesh) -> Vec<u8> {
    let mut head =
        String::from("# vtk DataFile Version 3.0\ntetrahedra\nBINARY\nDATASET UNSTRUCTURED_GRID\n");
    let (points, cells) = (mesh.points(), mesh.tetrahedra());
    _ = writeln!(head, "POINTS {} double", points.len());
    let mut file = head.into_bytes();
    for coordinate in points.iter().flat_map(|point| point.to_array()) {
        file.extend(coordinate.to_be_bytes());
    }
    file.extend(format!("\nCELLS {} {}\n", cells.len(), 5 * cells.len()).bytes());
    for cell in cells {
        file.extend(4_i32.to_be_bytes());
        file.extend(cell.iter().flat_map(|point| point.to_be_bytes()));
    }
    file.extend(format!("\nCELL_TYPES {}\n", cells.len()).bytes());
    for _ in cells {
        file.extend(10_i32.to_be_bytes());
    }
    let head = format!(
        "\nPOINT_DATA {}\nSCALARS scalar double 1\nLOOKUP_TABLE default\n",
        points.len()
    );
    file.extend(head.bytes());
    for value in &mesh.scalars().values {
        file.extend(value.to_be_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope::io::{ReadOptions, read_file};
    use tetrascope::scene::{SceneFile, VolumeSource};

    fn sphere() -> (Volume, Scene) {
        let mut file = SceneFile::new(VolumeSource {
            dataset: Some("sphere".into()),
            cells: Some(500),
            ..VolumeSource::default()
        });
        (file.image.width, file.image.height) = (Some(9), Some(6));
        let volume = tetrascope::volumes::load(&file.volume)
            .expect("a data set")
            .volume;
        let scene = file.resolve(&volume).expect("a scene");
        (volume, scene)
    }

    #[test]
    fn what_vtk_is_given_is_the_mesh() {
        let (volume, _) = sphere();
        let Volume::Mesh(mesh) = &volume else {
            panic!("it is a mesh");
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("volume.vtk");
        std::fs::write(&path, legacy(mesh)).expect("written");
        let tetrascope::io::FileData::Mesh(read) =
            read_file(&path, &ReadOptions::default()).expect("our reader takes it")
        else {
            panic!("it is a mesh");
        };
        let read = read.into_mesh(None).expect("tetrahedra");
        assert_eq!(read.points(), mesh.points());
        assert_eq!(read.tetrahedra(), mesh.tetrahedra());
        assert_eq!(read.scalars().values, mesh.scalars().values);
    }

    // A corner of one picture's pixel is a ray of ours: asked for alone, it sees the very same, but for
    // the rounding of its angle.
    #[test]
    fn corners_are_half_a_pixel_away() {
        let (volume, scene) = sphere();
        let context = Context::new();
        let corners = corners(&context, &volume, &scene).expect("drawn");
        let at = |frame: &Frame, x, y| frame.pixel(x, y);
        for (x, y) in [(3, 2), (4, 3), (5, 2)] {
            // The lower right corner of a pixel is the upper left of the next one.
            assert_eq!(at(&corners[3], x, y), at(&corners[0], x + 1, y + 1));
            assert_eq!(at(&corners[1], x, y), at(&corners[0], x + 1, y));
        }
        // Twice as many pixels a side have the corners' neighbors around the middle: the mean of the
        // four corners is the middle's value to second order in half a pixel.
        let truth = tetrascope::truth().expect("compiled in");
        let settings = Settings::defaults(truth);
        let renderer = (truth.build)(&context, &volume, &scene.appearance, &settings);
        let middle = renderer.and_then(|r| r.render(&scene.view)).expect("drawn");
        let error = |frame: &Frame| Errors::between(&middle, frame).image.rmse;
        let mean: Vec<[f32; 4]> = (0..middle.pixels.len())
            .map(|i| std::array::from_fn(|c| corners.iter().map(|f| f.pixels[i][c] / 4.0).sum()))
            .collect();
        let mean = Frame::new((9, 6), mean, FrameStats::default());
        assert!(
            corners
                .iter()
                .all(|corner| error(corner) > 2.0 * error(&mean))
        );
    }
}
