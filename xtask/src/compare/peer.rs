//! VTK as a peer: its mappers draw the same scenes by `benches/peers/vtk_compare.py`, and stand in the
//! same tables and diagrams.
//!
//! Each mapper runs in a process of its own, as one may crash. Some of VTK's rays go through corners of
//! pixels: errors are given as they are and with that forgiven, that is, against the truth's rays
//! through the corner that fits best (`corners`). `legacy` writes meshes for it.

mod corners;
mod legacy;

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;
use tetrascope::core::mesh::Association;
use tetrascope::core::{Error, Frame, FrameStats, OpticalModel, Volume};
use tetrascope::io::{Compression, TemporaryFolder, write_grid};
use tetrascope::scene::Scene;
use tetrascope::{Context, Promise};

use self::corners::corners;
use self::legacy::legacy;
use crate::machine;
use crate::metrics::{Errors, median};
use crate::output::write;
use crate::picture::{shown, signed_map};
use crate::report::{Difference, Drawn, Outcome, Picture, Row, Stats};

/// The name of VTK's rows.
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

/// The script's description of itself.
#[derive(Deserialize)]
struct Listed {
    version: String,
    mesh: Vec<String>,
    grid: Vec<String>,
}

/// The script's measurements of a mapper.
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
        let folder = TemporaryFolder::new()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope::scene::{SceneFile, VolumeSource};

    /// A small mesh and its scene of 9×6 pixels.
    pub(super) fn sphere() -> (Volume, Scene) {
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
}
