//! All that a picture depends on, and what commands make of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::Colormap;
use tetrascope_core::transfer_function::MAX_OPACITY;
use tetrascope_core::view::{BLACK, TRANSPARENT, check_background, check_size};
use tetrascope_core::{
    Camera, DepthCue, Error, OpticalModel, Projection, Settings, TransferFunction, Volume,
    camera::DEFAULT_VIEW_ANGLE,
};
use tetrascope_scene::{
    FieldValues, IsosurfaceSpec, Preset, Scene, SceneFile, VolumeSource, default_unit_distance,
};

use super::command::Command;
use super::look::{self, Look};
use crate::volumes::Loaded;
use crate::{Algorithm, algorithm};

/// The longest side of a picture: that of large screens.
const LONGEST_SIDE: u32 = 8192;

/// The most pixels of a picture.
const MOST_PIXELS: u64 = 1 << 24;

/// A volume with one of its fields at one time step.
#[derive(Debug)]
pub struct Field {
    /// The volume, and what was found out while loading it.
    pub loaded: Loaded,
    /// The field's values.
    pub values: FieldValues,
    /// Which volume, with its field and time step, as a scene file says it.
    pub source: VolumeSource,
    /// The number of the time step, from 0.
    pub step: usize,
    /// Counts loads.
    pub id: u64,
}

impl Field {
    /// The field of a volume that was loaded from `source`, as step number `step`.
    pub fn new(loaded: Loaded, source: VolumeSource, step: usize, id: u64) -> Field {
        Field {
            values: FieldValues::of(&loaded.volume),
            loaded,
            source,
            step,
            id,
        }
    }

    /// The field's name, as it is asked for.
    pub fn name(&self) -> &str {
        self.source.field.as_deref().unwrap_or(&self.loaded.field)
    }

    /// The volume that can be drawn.
    pub fn volume(&self) -> &Volume {
        &self.loaded.volume
    }
}

/// All that a picture depends on.
#[derive(Clone, Debug)]
pub struct State {
    /// Counts changes.
    pub version: u64,
    /// The volume.
    pub field: Arc<Field>,
    /// The complete scene.
    pub scene: Scene,
    /// The algorithm that draws complete pictures.
    pub algorithm: &'static Algorithm,
    /// How.
    pub settings: Settings,
    /// The background that was chosen; `None` as the optical model has it.
    pub(crate) background: Option<[f32; 4]>,
    pub(crate) look: Look,
    /// As the viewer was asked for.
    initial: Arc<SceneFile>,
}

/// A view that outlasts a server: all but the volume's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    scene: SceneFile,
    step: usize,
    /// With the ends of its colors alone, if the map has a name.
    preset: Preset,
    colormap: Option<Colormap>,
    unit_distance: f64,
    surfaces: Vec<IsosurfaceSpec>,
    algorithm: String,
    settings: String,
}

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
    /// The first state: `file` completed for the volume.
    ///
    /// # Errors
    /// Those of [`SceneFile::resolve`], and what the algorithm does not draw.
    pub(crate) fn new(
        field: Arc<Field>,
        file: SceneFile,
        algorithm: &'static Algorithm,
        settings: Settings,
    ) -> Result<State, Error> {
        let scene = file.resolve(field.volume())?;
        let look = look_of(&scene, &file, field.volume());
        let state = State {
            version: 1,
            background: file.image.background,
            field,
            scene,
            algorithm,
            settings,
            look,
            initial: Arc::new(file),
        };
        state.checked()
    }

    /// The result of a command on it.
    ///
    /// # Errors
    /// What the command asks for is invalid, or not drawn by the algorithm.
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

    /// The same view of another volume of the same source: with its own look if the field is
    /// another one.
    pub(crate) fn with_field(&self, field: Arc<Field>) -> Result<State, Error> {
        let mut next = self.clone();
        let is_same = field.name() == self.field.name();
        next.scene.source = field.source.clone();
        next.field = field;
        if !is_same {
            let mut file = self.scene.to_file();
            file.appearance.transfer_function = None;
            file.appearance.colormap = self.look.colormap.or(Some(Colormap::Viridis));
            file.appearance.isosurfaces = None;
            file.image.background = self.background;
            next.take(file)?;
        }
        next.checked()
    }

    /// The part that a page keeps of it.
    pub fn saved(&self) -> Saved {
        let mut scene = self.scene.to_file();
        scene.volume = VolumeSource {
            field: Some(self.field.name().into()),
            ..VolumeSource::default()
        };
        scene.image.background = self.background;
        let mut preset = self.look.preset.clone();
        // What follows from the points is left out, as an address is to hold it.
        let follows = preset.transfer_function(self.look.unit_distance);
        if follows.is_ok_and(|f| f == self.scene.appearance.transfer_function) {
            scene.appearance.transfer_function = None;
        }
        if self.look.colormap.is_some() && preset.colors.len() > 2 {
            preset.colors.drain(1..preset.colors.len() - 1);
        }
        Saved {
            scene,
            step: self.field.step,
            preset,
            colormap: self.look.colormap,
            unit_distance: self.look.unit_distance,
            surfaces: self.look.surfaces.clone(),
            algorithm: self.algorithm.name.into(),
            settings: self.settings.to_string(),
        }
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), Error> {
        self.algorithm = algorithm(&saved.algorithm)?;
        self.settings = Settings::parse(self.algorithm, saved.settings.split(','))?;
        self.take(saved.scene.clone())?;
        let mut preset = saved.preset.clone();
        preset.validate()?;
        if let (Some(map), Some(first), Some(last)) =
            (saved.colormap, preset.colors.first(), preset.colors.last())
        {
            preset.colors = Preset::colors_of(map, (first.scalar, last.scalar));
        }
        if !(saved.unit_distance > 0.0 && saved.unit_distance.is_finite()) {
            return Err(Error::invalid(format!(
                "a unit distance of {}",
                saved.unit_distance
            )));
        }
        self.look = Look {
            preset,
            colormap: saved.colormap,
            unit_distance: saved.unit_distance,
            surfaces: saved.surfaces.clone(),
        };
        match saved.scene.appearance.transfer_function {
            None => self.redraw_points(),
            Some(_) => Ok(()),
        }
    }

    /// Takes camera, background and look of a scene, not its volume and not its size.
    fn take(&mut self, mut file: SceneFile) -> Result<(), Error> {
        file.volume = self.scene.source.clone();
        file.image.width = Some(self.scene.view.width);
        file.image.height = Some(self.scene.view.height);
        let volume = self.field.volume();
        self.scene = file.resolve(volume)?;
        self.look = look_of(&self.scene, &file, volume);
        self.background = file.image.background;
        Ok(())
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
    fn redraw_points(&mut self) -> Result<(), Error> {
        let function = self
            .look
            .preset
            .transfer_function(self.look.unit_distance)?;
        self.scene.appearance.transfer_function = function;
        Ok(())
    }

    /// The state with all that follows from the rest, if the algorithm draws it.
    fn checked(mut self) -> Result<State, Error> {
        let model = self.scene.appearance.optical_model;
        self.scene.view.background = self.background.unwrap_or(match model.only_adds_light() {
            true => BLACK,
            false => TRANSPARENT,
        });
        let function = &self.scene.appearance.transfer_function;
        self.scene.appearance.isosurfaces = self.look.isosurfaces(function);
        self.scene.view.validate()?;
        let volume = self.field.volume();
        self.scene.appearance.validate_in(&volume.bounds())?;
        let Scene {
            appearance, view, ..
        } = &self.scene;
        (self.algorithm.supports)(volume, appearance, view, &self.settings)?;
        Ok(self)
    }
}

/// The most isosurfaces that a page may ask for.
const MOST_SURFACES: usize = 64;

/// The look of a scene that was completed from a file.
fn look_of(scene: &Scene, file: &SceneFile, volume: &Volume) -> Look {
    let function = &scene.appearance.transfer_function;
    let spec = &file.appearance;
    let colormap = match spec.transfer_function {
        None => Some(spec.colormap.unwrap_or(Colormap::Viridis)),
        Some(_) => None,
    };
    let distance = match (spec.unit_distance, &spec.transfer_function) {
        (Some(distance), None) => distance,
        (_, given) => opaque_distance(function, scene, volume, given.is_some()),
    };
    let mut look = Look::of(&scene.appearance, colormap, distance);
    if spec.isosurfaces.is_none() {
        look.surfaces
            .iter_mut()
            .for_each(|surface| surface.color = None);
    }
    look
}

/// The distance over which the function's opacities are told: that of the color map that made it,
/// else the default one, but not so long that opacities that differ are all opaque.
fn opaque_distance(
    function: &TransferFunction,
    scene: &Scene,
    volume: &Volume,
    is_given: bool,
) -> f64 {
    let (_, _, forward) = scene.view.camera.axes();
    let model = scene.appearance.optical_model;
    let (usual, _) = default_unit_distance(volume, model, forward);
    let densest = function.max_extinction(f64::NEG_INFINITY, f64::INFINITY);
    let opaque = -(-MAX_OPACITY).ln_1p() / densest;
    match is_given {
        _ if !(opaque > 0.0 && opaque.is_finite()) => usual,
        // A constant field's map has half the opacity.
        false if function.knots().len() > 1 => opaque,
        _ => usual.min(opaque),
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
