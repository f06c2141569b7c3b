//! The part of a state that a page keeps, and its way back.

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::Colormap;
use tetrascope_core::{Error, Settings};
use tetrascope_scene::{IsosurfaceSpec, Preset, SceneFile, VolumeSource};

use super::State;
use crate::algorithm;
use crate::view::look::Look;

/// A view that outlasts a server: all but the volume's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    pub(super) scene: SceneFile,
    pub(super) step: usize,
    /// With the ends of its colors alone, if the map has a name.
    preset: Preset,
    colormap: Option<Colormap>,
    unit_distance: f64,
    surfaces: Vec<IsosurfaceSpec>,
    algorithm: String,
    settings: String,
}

impl State {
    /// The part that a page keeps of it.
    pub fn saved(&self) -> Saved {
        let mut scene = self.scene.to_file();
        scene.volume = VolumeSource {
            field: Some(self.field.name().into()),
            ..VolumeSource::default()
        };
        scene.image.background = self.background;
        let mut preset = self.look.preset.clone();
        // Facts that follow from the points are left out, as an address is to hold it.
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

    pub(super) fn restore(&mut self, saved: &Saved) -> Result<(), Error> {
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
}
