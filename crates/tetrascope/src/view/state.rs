//! All that a picture depends on; `apply` has what commands make of it, `saved` what a page keeps.

mod apply;
mod saved;

use std::sync::Arc;

use tetrascope_core::colormap::Colormap;
use tetrascope_core::transfer_function::MAX_OPACITY;
use tetrascope_core::view::{BLACK, TRANSPARENT};
use tetrascope_core::{Error, Settings, TransferFunction, Volume};
use tetrascope_scene::{FieldValues, Scene, SceneFile, VolumeSource, default_unit_distance};

use super::look::Look;
use crate::Algorithm;
use crate::volumes::Loaded;

pub(crate) use apply::{Applied, Wanted};
pub use saved::Saved;

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
