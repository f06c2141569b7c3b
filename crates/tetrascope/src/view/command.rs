//! The commands of a page.

use std::collections::BTreeMap;

use serde::Deserialize;
use tetrascope_core::colormap::Colormap;
use tetrascope_core::{CameraFit, ClipPlane, OpticalModel};
use tetrascope_scene::{CameraSpec, IsosurfaceSpec, Preset};

/// One message of a page.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Message {
    /// Counts up; a frame says which input it shows, so that a page knows its latency.
    #[serde(default)]
    pub seq: u64,
    /// Whether more is about to follow, as while a hand drags.
    #[serde(default)]
    pub moving: bool,
    /// A change.
    #[serde(default)]
    pub command: Option<Command>,
    /// The number of a frame that is on the screen now.
    #[serde(default)]
    pub shown: Option<u64>,
    /// Asks for the difference to the truth, or takes that back.
    #[serde(default)]
    pub difference: Option<bool>,
    /// Asks for the error of the picture, where it is not told unasked.
    #[serde(default)]
    pub estimate: bool,
    /// Asks for a histogram of the field between two scalars.
    #[serde(default)]
    pub histogram: Option<[f64; 2]>,
}

/// A change of the state.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Another camera, complete.
    Camera {
        /// Position, focal point, direction up and projection.
        camera: CameraSpec,
    },
    /// The whole volume from a side, in the projection there is.
    Fit {
        /// The side.
        from: CameraFit,
    },
    /// Parallel or perspective rays; what lies at the focal point keeps its size.
    Orthographic {
        /// Whether rays are parallel.
        on: bool,
    },
    /// The size of pictures.
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
    },
    /// The color behind the volume, linear RGBA with straight alpha; `None` as the model has it.
    Background {
        /// The color.
        color: Option<[f32; 4]>,
    },
    /// Another optical model.
    Model {
        /// Its name.
        name: OpticalModel,
    },
    /// Other points of color and opacity.
    Points {
        /// All of them.
        preset: Preset,
        /// Whether colors stay as they are, whatever the preset has.
        #[serde(default)]
        keep_colors: bool,
    },
    /// A color map by name over the range, opacities stay.
    Colormap {
        /// Its name.
        name: Colormap,
    },
    /// Moves all points to another range.
    Range {
        /// The least scalar.
        low: f64,
        /// The greatest.
        high: f64,
    },
    /// Moves all points to the range between two shares of the field's values.
    Percentiles {
        /// Percent of the values that lie below.
        low: f64,
        /// Percent that lie below the upper end.
        high: f64,
    },
    /// The distance over which opacities count, world units.
    UnitDistance {
        /// More than 0.
        length: f64,
    },
    /// The surfaces of the model `isosurfaces`.
    Isosurfaces {
        /// All of them.
        surfaces: Vec<IsosurfaceSpec>,
    },
    /// The clip planes.
    Clip {
        /// All of them.
        planes: Vec<ClipPlane>,
    },
    /// How much light the farthest point loses.
    DepthCue {
        /// 0 to 1; `None` for no cue.
        strength: Option<f64>,
    },
    /// Another field of the same source.
    Field {
        /// Its name, as listed.
        name: String,
    },
    /// Another time step.
    Step {
        /// Its number, from 0.
        number: usize,
    },
    /// Another algorithm.
    Algorithm {
        /// Its name.
        name: String,
        /// Settings that are not at their defaults.
        #[serde(default)]
        settings: BTreeMap<String, String>,
    },
    /// A ParaView preset.
    ImportPreset {
        /// JSON.
        text: String,
        /// Whether its points move to the range there is.
        #[serde(default)]
        keep_range: bool,
    },
    /// Camera, background and look of a scene file; what it says of a volume is passed over.
    ImportScene {
        /// TOML or JSON.
        text: String,
        /// Whether it is JSON.
        #[serde(default)]
        json: bool,
    },
    /// Camera and look as the viewer started.
    Reset {},
    /// A view that a page has kept: a scene, without its volume, and what draws it.
    Restore {
        /// As [`State::saved`](super::State::saved) gives it.
        saved: Box<super::state::Saved>,
    },
}
