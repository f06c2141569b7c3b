//! The state that a command makes of another.

use tetrascope_core::camera::DEFAULT_VIEW_ANGLE;
use tetrascope_core::view::{check_background, check_size};
use tetrascope_core::{Camera, DepthCue, Error, OpticalModel, Projection, Settings};
use tetrascope_scene::{IsosurfaceSpec, Preset, SceneFile};

use super::State;
use crate::algorithm;
use crate::view::command::Command;
use crate::view::look::{self, Look};

/// The longest side of a picture: that of large screens.
const LONGEST_SIDE: u32 = 8192;

/// The most pixels of a picture.
const MOST_PIXELS: u64 = 1 << 24;

/// The most isosurfaces that a page may ask for.
const MOST_SURFACES: usize = 64;

/// The result of a command on a state.
pub(crate) enum Applied {
    /// Another state of the same volume.
    State(Box<State>),
    /// Nothing before this is loaded.
    Load(Wanted),
}

/// A volume that is to be loaded.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// The field's name; `None` for the one there is.
    pub(crate) field: Option<String>,
    pub(crate) step: usize,
    /// The command to apply then.
    pub(crate) then: Option<Command>,
}

impl State {
    /// The result of a command on it.
    ///
    /// # Errors
    /// An invalid command, and one for which the algorithm draws nothing.
    pub(crate) fn apply(&self, command: &Command) -> Result<Applied, Error> {
        let mut next = self.clone();
        match command {
            Command::Camera { camera } => {
                let file = SceneFile {
                    camera: *camera,
                    ..self.scene.to_file()
                };
                next.scene.view.camera = file.resolve(self.field.volume())?.view.camera;
            }
            Command::Fit { from } => {
                let view = &mut next.scene.view;
                let is_parallel = matches!(view.camera.projection, Projection::Orthographic { .. });
                let aspect = f64::from(view.width) / f64::from(view.height);
                let outline = self.field.volume().outline();
                view.camera = Camera::frame(outline, *from, is_parallel, aspect);
            }
            Command::Orthographic { on } => {
                let camera = &mut next.scene.view.camera;
                *camera = match on {
                    true => camera.to_orthographic(),
                    false => to_perspective(*camera),
                };
            }
            Command::Size { width, height } => {
                check_size(*width, *height)?;
                let pixels = u64::from(*width) * u64::from(*height);
                if (*width).max(*height) > LONGEST_SIDE || pixels > MOST_PIXELS {
                    return Err(Error::Usage {
                        what: format!("a view of {width}x{height} pixels"),
                        help: Some(format!("give at most {MOST_PIXELS} pixels")),
                    });
                }
                (next.scene.view.width, next.scene.view.height) = (*width, *height);
            }
            Command::Background { color } => {
                color.map_or(Ok(()), check_background)?;
                next.background = *color;
            }
            Command::Model { name } => next.set_model(*name)?,
            Command::Points {
                preset,
                keep_colors,
            } => {
                next.look.set_points(preset.clone(), *keep_colors)?;
                next.redraw_points()?;
            }
            Command::Colormap { name } => {
                next.look.set_colormap(*name);
                next.redraw_points()?;
            }
            Command::Range { low, high } => next.set_range(*low, *high)?,
            Command::Percentiles { low, high } => {
                let values = &self.field.values;
                let [low, high] = [low, high].map(|percent| values.quantile(percent / 100.0));
                let (Some(low), Some(high)) = (low, high) else {
                    return Err(Error::invalid("the field has no finite value"));
                };
                next.set_range(low, high)?;
            }
            Command::UnitDistance { length } => {
                if !(*length > 0.0 && length.is_finite()) {
                    return Err(Error::Usage {
                        what: format!("a unit distance of {length}"),
                        help: Some("give a length in world units, more than 0".into()),
                    });
                }
                let factor = self.look.unit_distance / length;
                let function = look::thicker(&next.scene.appearance.transfer_function, factor)?;
                next.scene.appearance.transfer_function = function;
                next.look.unit_distance = *length;
            }
            Command::Isosurfaces { surfaces } => {
                if surfaces.len() > MOST_SURFACES {
                    return Err(Error::Usage {
                        what: format!("{} isosurfaces", surfaces.len()),
                        help: Some(format!("give at most {MOST_SURFACES}")),
                    });
                }
                next.look.surfaces.clone_from(surfaces);
            }
            Command::Clip { planes } => next.scene.appearance.clip_planes.clone_from(planes),
            Command::DepthCue { strength } => {
                let cue = strength.map(|strength| DepthCue { strength });
                next.scene.appearance.depth_cue = cue;
            }
            Command::Field { name } => return Ok(self.load(Some(name.clone()), self.field.step)),
            Command::Step { number } => return Ok(self.load(None, *number)),
            Command::Algorithm { name, settings } => {
                next.algorithm = algorithm(name)?;
                let pairs: Vec<String> = settings
                    .iter()
                    .map(|(key, value)| format!("{key}={value}"))
                    .collect();
                let pairs = pairs.iter().map(String::as_str);
                next.settings = Settings::parse(next.algorithm, pairs)?;
            }
            Command::ImportPreset { text, keep_range } => {
                let read = Preset::from_json(text)?;
                let range = self.scene.appearance.transfer_function.range();
                let preset = match keep_range {
                    true => read.preset.scaled_to(range),
                    false => read.preset,
                };
                next.look.set_points(preset, false)?;
                next.redraw_points()?;
            }
            Command::ImportScene { text, json } => {
                let name = if *json { "scene.json" } else { "scene.toml" };
                let file = SceneFile::parse(text, name.as_ref())?;
                next.take(file)?;
            }
            Command::Reset {} => next.take(SceneFile::clone(&self.initial))?,
            Command::Restore { saved } => {
                let field = saved.scene.volume.field.clone();
                let is_other = field
                    .as_deref()
                    .is_some_and(|name| name != self.field.name());
                if is_other || saved.step != self.field.step {
                    return Ok(Applied::Load(Wanted {
                        field: field.filter(|_| is_other),
                        step: saved.step,
                        then: Some(command.clone()),
                    }));
                }
                next.restore(saved)?;
            }
        }
        Ok(Applied::State(Box::new(next.checked()?)))
    }

    fn load(&self, field: Option<String>, step: usize) -> Applied {
        Applied::Load(Wanted {
            field,
            step,
            then: None,
        })
    }

    fn set_model(&mut self, model: OpticalModel) -> Result<(), Error> {
        self.scene.appearance.optical_model = model;
        if model == OpticalModel::Isosurfaces && self.look.surfaces.is_empty() {
            let mut file = self.scene.to_file();
            file.appearance.isosurfaces = None;
            let resolved = file.resolve(self.field.volume())?;
            let surfaces = resolved.appearance.isosurfaces.iter();
            self.look.surfaces = surfaces
                .map(|surface| IsosurfaceSpec {
                    value: surface.value,
                    color: None,
                })
                .collect();
        }
        Ok(())
    }

    fn set_range(&mut self, low: f64, high: f64) -> Result<(), Error> {
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(Error::Usage {
                what: format!("a range from {low} to {high}"),
                help: Some("give two finite numbers, the lesser first".into()),
            });
        }
        let appearance = &mut self.scene.appearance;
        let old = appearance.transfer_function.range();
        appearance.transfer_function = look::moved(&appearance.transfer_function, (low, high))?;
        // Points may reach beyond the knots: they move by the same rule.
        let preset = &mut self.look.preset;
        if old.0 < old.1 && preset.range() == old {
            *preset = preset.scaled_to((low, high));
        } else {
            *preset = Look::of(appearance, self.look.colormap, self.look.unit_distance).preset;
        }
        if let Some(map) = self.look.colormap {
            preset.colors = Preset::colors_of(map, preset.range());
        }
        if old.0 == old.1 && low < high {
            // A range that was one scalar has no shape to move.
            preset.opacities = look::ramp((low, high));
            self.redraw_points()?;
        }
        Ok(())
    }

    /// Makes the function anew from the points.
    pub(super) fn redraw_points(&mut self) -> Result<(), Error> {
        let function = self
            .look
            .preset
            .transfer_function(self.look.unit_distance)?;
        self.scene.appearance.transfer_function = function;
        Ok(())
    }
}

/// The same view in perspective: what lies at the focal point keeps its size.
fn to_perspective(camera: Camera) -> Camera {
    let Projection::Orthographic { parallel_scale } = camera.projection else {
        return camera;
    };
    let half = (DEFAULT_VIEW_ANGLE.to_radians() / 2.0).tan();
    let (_, _, forward) = camera.axes();
    Camera {
        position: camera.focal_point - forward * (parallel_scale / half),
        projection: Projection::Perspective {
            view_angle: DEFAULT_VIEW_ANGLE,
        },
        ..camera
    }
}
