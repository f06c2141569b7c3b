//! A scene: which volume, how it looks, from where; as TOML or JSON.
//!
//! [`SceneFile`] is what a person writes, nearly all of it optional.
//! [`SceneFile::resolve`] fills the rest from the volume and gives a [`Scene`],
//! which is complete and prints as a scene file again.

mod defaults;
mod raw;

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::camera::DEFAULT_VIEW_ANGLE;
use crate::colormap::Colormap;
use crate::grid::Interpolation;
use crate::transfer_function::OpacityRamp;
use crate::view::{BLACK, TRANSPARENT};
use crate::{
    Appearance, Camera, CameraFit, ClipPlane, DepthCue, DirectionalLight, Error, Isosurface, Knot,
    Lighting, OpticalModel, Projection, TransferFunction, View, Volume, number,
};

use defaults::{default_isovalue, default_ramp};

pub use defaults::{default_side, default_unit_distance};
pub use raw::{ByteOrder, RawLayout, RawNumber};

/// The version of the scene format that this crate reads and writes.
pub const SCENE_VERSION: u32 = 1;

/// Knots in a transfer function made from a color map: between them the sampled
/// extinction −ln(1 − α)/D is within 2 % of its curve up to α = 0.95.
const COLORMAP_KNOTS: usize = 33;

/// Pixels a side unless the scene says otherwise.
const DEFAULT_SIZE: u32 = 512;

/// No scene file is longer: some ten thousand knots. A mesh given as a scene by mistake is,
/// and so is a device that never ends.
pub const MAX_SCENE_BYTES: u64 = 1 << 20;

/// A scene as written: what is left out is chosen by [`SceneFile::resolve`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// [`SCENE_VERSION`].
    pub version: u32,
    /// What to draw.
    #[serde(default)]
    pub volume: VolumeSource,
    /// From where.
    #[serde(default)]
    pub camera: CameraSpec,
    /// How large and before what.
    #[serde(default)]
    pub image: ImageSpec,
    /// How scalars become light.
    #[serde(default)]
    pub appearance: AppearanceSpec,
}

/// Where a volume comes from: a file or a named data set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VolumeSource {
    /// A mesh file; relative paths start at the scene file.
    ///
    /// Text holds UTF-8 alone: a name of other bytes is written with replacements, so
    /// such a scene does not find its file again.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        serialize_with = "text"
    )]
    pub file: Option<PathBuf>,
    /// The Plot3D solution that belongs to a Plot3D grid; found by name if left out.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        serialize_with = "text"
    )]
    pub solution: Option<PathBuf>,
    /// A generated data set, in place of a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dataset: Option<String>,
    /// About how many cells to generate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<u64>,
    /// The seed of random data sets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Which field to draw, by a name that `info` lists; `cell:NAME` and `point:NAME` tell two of
    /// one name apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The scalar between a grid's samples; linear for samples at points, nearest for those
    /// of cells unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// Samples along each axis of a raw file, x fastest. The keys below are for raw
    /// files too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dims: Option<[usize; 3]>,
    /// The type of a raw file's numbers.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub number: Option<RawNumber>,
    /// The distance of samples along each axis, world units; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<DVec3>,
    /// Where the first sample lies, world space; at 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<DVec3>,
    /// Bytes before the first number; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<u64>,
    /// The order of a number's bytes; little unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub byte_order: Option<ByteOrder>,
}

/// A path as text, whatever its bytes: TOML and JSON would fail.
fn text<S: serde::Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(path) => serializer.serialize_some(&path.to_string_lossy()),
        None => serializer.serialize_none(),
    }
}

/// A camera as written: `fit`, or position and the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// Fit the volume from this side; excludes the four below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<CameraFit>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<DVec3>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focal_point: Option<DVec3>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_up: Option<DVec3>,
    /// Perspective, unless there is a `parallel_scale`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub projection: Option<ProjectionKind>,
    /// Vertical, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_angle: Option<f64>,
    /// Half the image's height, world units; makes the camera orthographic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel_scale: Option<f64>,
}

/// How rays spread, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionKind {
    /// From a point.
    Perspective,
    /// In parallel.
    Orthographic,
}

/// Size and background as written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSpec {
    /// Pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Linear RGBA, straight alpha.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<[f32; 4]>,
}

/// Appearance as written: `transfer_function`, or a color map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AppearanceSpec {
    /// Emission-absorption unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optical_model: Option<OpticalModel>,
    /// Viridis unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colormap: Option<Colormap>,
    /// The color map's scalars, over which opacity rises linearly from 0 to 1. Unless
    /// given, both are chosen by the field's values: without outliers and marks for "no
    /// value", and clear where most of the volume has one value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// The distance over which the color map's opacity counts, world units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_distance: Option<f64>,
    /// How much light the farthest point loses, 0 to 1; no depth cue unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_cue: Option<f64>,
    /// Share of a surface's color that shows without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<f64>,
    /// Knots by increasing scalar; excludes `colormap`, `range` and `unit_distance`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<Vec<Knot>>,
    /// For the model `isosurfaces`: the middle of the range unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isosurfaces: Option<Vec<IsosurfaceSpec>>,
    /// Lights on surfaces; one at the eye unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<DirectionalLight>>,
    /// What lies behind any of these is cut away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_planes: Option<Vec<ClipPlane>>,
}

/// An isosurface as written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IsosurfaceSpec {
    /// In the field's own units.
    pub value: f64,
    /// Linear RGB; the transfer function's at `value` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<DVec3>,
}

/// A complete scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What to draw.
    pub source: VolumeSource,
    /// How it looks.
    pub appearance: Appearance,
    /// From where, how large and before what.
    pub view: View,
    /// What was chosen because the scene file left it out, one line each.
    pub defaults: Vec<String>,
}

impl SceneFile {
    /// A scene file that leaves everything out.
    pub fn new(volume: VolumeSource) -> SceneFile {
        SceneFile {
            version: SCENE_VERSION,
            volume,
            ..SceneFile::default()
        }
    }

    /// Reads the scene file at `path`; see [`SceneFile::parse`].
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, and [`Error::Scene`] when it has more than
    /// [`MAX_SCENE_BYTES`], is not UTF-8, or does not parse.
    pub fn read(path: &Path) -> Result<SceneFile, Error> {
        let invalid = |what: String| Error::Scene {
            at: path.display().to_string(),
            what,
            help: Some(
                "a scene is TOML or JSON; `tetrascope print-scene sphere` prints one".into(),
            ),
        };
        // One byte more tells a file that is too long, whatever length it claims.
        let mut bytes = Vec::new();
        let read = File::open(path)
            .and_then(|file| file.take(MAX_SCENE_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        if bytes.len() as u64 > MAX_SCENE_BYTES {
            return Err(invalid(format!(
                "a file of more than {MAX_SCENE_BYTES} bytes is not a scene file"
            )));
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            invalid(format!("byte {at} is not text (UTF-8)"))
        })?;
        SceneFile::parse(&text, path)
    }

    /// Parses TOML, or JSON where `path` ends in `.json`.
    ///
    /// Relative paths inside are taken from the folder of `path`. Unknown keys
    /// and other versions are refused, with line and column.
    pub fn parse(text: &str, path: &Path) -> Result<SceneFile, Error> {
        let wrong = |line: usize, column: usize, what: &str| Error::Scene {
            at: format!("{}, line {line}, column {column}", path.display()),
            what: what.trim().replace('\n', "; "),
            help: Some(
                "`tetrascope print-scene sphere` prints a complete scene to start from".into(),
            ),
        };
        let is_json = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let mut scene: SceneFile = if is_json {
            serde_json::from_str(text).map_err(|e| {
                // serde_json ends its message with the position that we give ourselves.
                let message = e.to_string();
                let what = message
                    .rsplit_once(" at line")
                    .map_or(message.as_str(), |(what, _)| what);
                wrong(e.line(), e.column(), what)
            })?
        } else {
            toml::from_str(text).map_err(|e: toml::de::Error| {
                let (line, column) = position(text, e.span().map_or(0, |span| span.start));
                wrong(line, column, e.message())
            })?
        };
        if scene.version != SCENE_VERSION {
            return Err(Error::Scene {
                at: path.display().to_string(),
                what: format!("scene version {} is unknown", scene.version),
                help: Some(format!("this program reads version = {SCENE_VERSION}")),
            });
        }
        if let Some(folder) = path.parent() {
            for file in [&mut scene.volume.file, &mut scene.volume.solution]
                .into_iter()
                .flatten()
            {
                *file = folder.join(&*file);
            }
        }
        Ok(scene)
    }

    /// Completes the scene for `volume`: a camera whose picture the volume fills, viridis
    /// over the values to tell apart, and opacity by [`default_unit_distance`].
    pub fn resolve(&self, volume: &Volume) -> Result<Scene, Error> {
        let mut defaults = Vec::new();
        let model = self
            .appearance
            .optical_model
            .unwrap_or(OpticalModel::EmissionAbsorption);
        let view = self.view(volume, model, &mut defaults)?;
        view.validate()?;
        let (_, _, forward) = view.camera.axes();
        let (transfer_function, ramp) =
            self.transfer_function(volume, model, forward, &mut defaults)?;
        let spec = &self.appearance;
        let isovalue = || match ramp {
            Some(ramp) => Ok(ramp),
            None => default_ramp(volume, forward).map(|suggestion| suggestion.ramp),
        };
        let isovalue = || isovalue().map(|ramp| default_isovalue(&ramp));
        let isosurfaces = isosurfaces(spec, model, isovalue, &transfer_function, &mut defaults)?;
        let lighting = Lighting {
            ambient: spec.ambient.unwrap_or(Lighting::default().ambient),
            lights: spec.lights.clone().unwrap_or_default(),
        };
        let appearance = Appearance {
            transfer_function,
            optical_model: model,
            isosurfaces,
            lighting,
            depth_cue: spec.depth_cue.map(|strength| DepthCue { strength }),
            clip_planes: spec.clip_planes.clone().unwrap_or_default(),
        };
        appearance.validate_in(&volume.bounds())?;
        Ok(Scene {
            source: self.volume.clone(),
            appearance,
            view,
            defaults,
        })
    }

    fn view(
        &self,
        volume: &Volume,
        model: OpticalModel,
        defaults: &mut Vec<String>,
    ) -> Result<View, Error> {
        let image = &self.image;
        let (width, height) = match (image.width, image.height) {
            (None, None) => (DEFAULT_SIZE, DEFAULT_SIZE),
            (w, h) => (
                w.or(h).unwrap_or(DEFAULT_SIZE),
                h.or(w).unwrap_or(DEFAULT_SIZE),
            ),
        };
        let background = image.background.unwrap_or_else(|| {
            if model.only_adds_light() {
                defaults.push(format!(
                    "background: opaque black, as {} only adds light",
                    model.name()
                ));
                BLACK
            } else {
                TRANSPARENT
            }
        });
        let aspect = f64::from(width) / f64::from(height.max(1));
        let camera = self.camera.resolve(volume, aspect, defaults)?;
        Ok(View {
            camera,
            width,
            height,
            background,
        })
    }

    /// The transfer function and, if a color map made it, the ramp of its opacity.
    fn transfer_function(
        &self,
        volume: &Volume,
        model: OpticalModel,
        forward: DVec3,
        defaults: &mut Vec<String>,
    ) -> Result<(TransferFunction, Option<OpacityRamp>), Error> {
        let spec = &self.appearance;
        if let Some(knots) = &spec.transfer_function {
            if spec.colormap.is_some() || spec.range.is_some() || spec.unit_distance.is_some() {
                return Err(Error::Scene {
                    at: "[appearance]".into(),
                    what: "transfer_function excludes colormap, range and unit_distance".into(),
                    help: Some("keep one of the two ways".into()),
                });
            }
            return Ok((TransferFunction::new(knots.clone())?, None));
        }
        let map = spec.colormap.unwrap_or_else(|| {
            defaults.push("colormap: viridis".into());
            Colormap::Viridis
        });
        let mut longest_unit = f64::INFINITY;
        let ramp = match spec.range {
            Some([low, high]) if low <= high => OpacityRamp {
                range: (low, high),
                ..OpacityRamp::default()
            },
            Some([low, high]) => {
                let [low, high] = [low, high].map(number::exact);
                return Err(Error::Scene {
                    at: "[appearance]".into(),
                    what: format!("range [{low}, {high}] is reversed"),
                    help: Some(format!("write [{high}, {low}]")),
                });
            }
            None => {
                let suggestion = default_ramp(volume, forward)?;
                defaults.extend(suggestion.lines);
                longest_unit = suggestion.longest_unit;
                suggestion.ramp
            }
        };
        let unit_distance = spec.unit_distance.unwrap_or_else(|| {
            let (mut distance, mut why) = default_unit_distance(volume, model, forward);
            if longest_unit < distance && longest_unit > 0.0 {
                distance = longest_unit;
                why = "as nearly all of the volume is clear";
            }
            let rounded = number::rounded(distance);
            defaults.push(format!("unit distance: {rounded}, {why}"));
            distance
        });
        let function = TransferFunction::from_ramp(map, &ramp, unit_distance, COLORMAP_KNOTS)?;
        Ok((function, Some(ramp)))
    }
}

fn isosurfaces(
    spec: &AppearanceSpec,
    model: OpticalModel,
    default_value: impl FnOnce() -> Result<f64, Error>,
    transfer_function: &TransferFunction,
    defaults: &mut Vec<String>,
) -> Result<Vec<Isosurface>, Error> {
    let written = match &spec.isosurfaces {
        Some(written) => written.clone(),
        None if model != OpticalModel::Isosurfaces => Vec::new(),
        None => {
            let value = default_value()?;
            defaults.push(format!(
                "isosurface: {}, in the middle of the values to tell apart",
                number::exact(value)
            ));
            vec![IsosurfaceSpec { value, color: None }]
        }
    };
    let complete = |written: IsosurfaceSpec| {
        let IsosurfaceSpec { value, color } = written;
        let mapped = || transfer_function.sample(value).map(|(color, _)| color);
        Isosurface {
            value,
            color: color.or_else(mapped).unwrap_or(DVec3::ONE),
        }
    };
    Ok(written.into_iter().map(complete).collect())
}

impl CameraSpec {
    fn resolve(
        &self,
        volume: &Volume,
        aspect: f64,
        defaults: &mut Vec<String>,
    ) -> Result<Camera, Error> {
        let refuse = |what: &str, help: &str| {
            Err(Error::Scene {
                at: "[camera]".into(),
                what: what.into(),
                help: Some(help.into()),
            })
        };
        let orthographic = match self.projection {
            Some(kind) => kind == ProjectionKind::Orthographic,
            None => self.parallel_scale.is_some(),
        };
        if orthographic && self.view_angle.is_some() {
            return refuse(
                "an orthographic camera has no view_angle",
                "use parallel_scale",
            );
        }
        if !orthographic && self.parallel_scale.is_some() {
            return refuse(
                "a perspective camera has no parallel_scale",
                "use view_angle",
            );
        }
        let Some(position) = self.position else {
            if self.focal_point.is_some()
                || self.view_up.is_some()
                || self.view_angle.is_some()
                || self.parallel_scale.is_some()
            {
                return refuse(
                    "the camera has no position",
                    "add position, or use fit alone",
                );
            }
            let (fit, orthographic) = match self.fit {
                Some(fit) => (fit, orthographic),
                None => {
                    let (fit, why) = default_side(volume);
                    let why = why.map_or(String::new(), |why| format!(", {why}"));
                    defaults.push(format!("camera: fit{}{why}", fit.name()));
                    // Near a needle's tip, perspective shows little but the tip.
                    let parallel = !why.is_empty() && self.projection.is_none();
                    (fit, orthographic || parallel)
                }
            };
            return Ok(Camera::frame(volume.outline(), fit, orthographic, aspect));
        };
        if self.fit.is_some() {
            return refuse("fit excludes position", "keep one of the two ways");
        }
        let focal_point = self.focal_point.unwrap_or_else(|| volume.bounds().center());
        let projection = match (orthographic, self.parallel_scale) {
            (false, _) => Projection::Perspective {
                view_angle: self.view_angle.unwrap_or(DEFAULT_VIEW_ANGLE),
            },
            (true, Some(parallel_scale)) => Projection::Orthographic { parallel_scale },
            (true, None) => {
                return refuse(
                    "an orthographic camera needs parallel_scale",
                    "give half the image's height, world units",
                );
            }
        };
        Ok(Camera {
            position,
            focal_point,
            view_up: self.view_up.unwrap_or(DVec3::Y),
            projection,
        })
    }
}

impl Scene {
    /// The scene with nothing left out, as a scene file.
    pub fn to_file(&self) -> SceneFile {
        let Scene {
            source,
            appearance,
            view,
            ..
        } = self;
        let (projection, view_angle, parallel_scale) = match view.camera.projection {
            Projection::Perspective { view_angle } => {
                (ProjectionKind::Perspective, Some(view_angle), None)
            }
            Projection::Orthographic { parallel_scale } => {
                (ProjectionKind::Orthographic, None, Some(parallel_scale))
            }
        };
        SceneFile {
            version: SCENE_VERSION,
            volume: source.clone(),
            camera: CameraSpec {
                fit: None,
                position: Some(view.camera.position),
                focal_point: Some(view.camera.focal_point),
                view_up: Some(view.camera.view_up),
                projection: Some(projection),
                view_angle,
                parallel_scale,
            },
            image: ImageSpec {
                width: Some(view.width),
                height: Some(view.height),
                background: Some(view.background),
            },
            appearance: AppearanceSpec::of(appearance),
        }
    }

    /// The scene as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(&self.to_file()).expect("a scene has only tables, numbers and strings")
    }
}

impl AppearanceSpec {
    /// What `appearance` has, apart from defaults.
    fn of(appearance: &Appearance) -> AppearanceSpec {
        let Appearance {
            transfer_function,
            optical_model,
            isosurfaces,
            lighting,
            depth_cue,
            clip_planes,
        } = appearance;
        let surface = |surface: &Isosurface| IsosurfaceSpec {
            value: surface.value,
            color: Some(surface.color),
        };
        let surfaces: Vec<_> = isosurfaces.iter().map(surface).collect();
        let is_lit = *optical_model == OpticalModel::Isosurfaces;
        AppearanceSpec {
            optical_model: Some(*optical_model),
            depth_cue: depth_cue.map(|cue| cue.strength),
            ambient: is_lit.then_some(lighting.ambient),
            transfer_function: Some(transfer_function.knots().to_vec()),
            isosurfaces: unless_empty(&surfaces),
            lights: unless_empty(&lighting.lights),
            clip_planes: unless_empty(clip_planes),
            ..AppearanceSpec::default()
        }
    }
}

fn unless_empty<T: Clone>(list: &[T]) -> Option<Vec<T>> {
    (!list.is_empty()).then(|| list.to_vec())
}

/// Line and column, from 1, of byte `offset`.
fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Association;
    use crate::{Scalars, TetMesh};

    fn tet() -> Volume {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: vec![1.0, 2.0, 3.0, 4.0],
        };
        Volume::Mesh(
            TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars).expect("a tet is valid"),
        )
    }

    #[test]
    fn a_volume_alone_makes_a_complete_scene_that_parses_again() {
        for model in OpticalModel::ALL {
            let mut file = SceneFile::new(VolumeSource::default());
            file.appearance.optical_model = Some(model);
            file.appearance.depth_cue = Some(0.5);
            file.appearance.clip_planes = Some(ClipPlane::of_box(&tet().bounds()).to_vec());
            file.appearance.lights = Some(vec![DirectionalLight {
                toward: DVec3::X,
                color: DVec3::ONE,
            }]);
            let scene = file.resolve(&tet()).expect("defaults suffice");
            assert!(!scene.defaults.is_empty());
            let again =
                SceneFile::parse(&scene.to_toml(), Path::new("a.toml")).expect("TOML parses");
            assert_eq!(again, scene.to_file());
            let json = serde_json::to_string(&scene.to_file()).expect("JSON writes");
            assert_eq!(
                SceneFile::parse(&json, Path::new("a.json")).expect("JSON parses"),
                scene.to_file()
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_name_that_is_not_utf_8_is_written_with_replacements() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = std::ffi::OsStr::from_bytes(b"a\xff.vtu");
        let scene = SceneFile::new(VolumeSource {
            file: Some(PathBuf::from(name)),
            ..VolumeSource::default()
        });
        let scene = scene.resolve(&tet()).expect("defaults suffice");
        assert!(scene.to_toml().contains("a\u{fffd}.vtu"));
        let json = serde_json::to_string(&scene.to_file()).expect("it is text");
        assert!(json.contains("a\u{fffd}.vtu"));
    }

    #[test]
    fn a_scene_is_read_to_a_bound() {
        let read = |path: &str| SceneFile::read(Path::new(path)).expect_err("not a scene");
        if cfg!(unix) {
            let error = read("/dev/zero").to_string();
            assert!(error.contains("more than 1048576 bytes"), "{error}");
        }
        assert!(matches!(read("no such file"), Error::Io { .. }));
    }

    #[test]
    fn paths_start_at_the_scene_file() {
        let scene = SceneFile::parse(
            "version = 1\n[volume]\nfile = \"b.vtu\"",
            Path::new("x/a.toml"),
        );
        assert_eq!(
            scene.expect("valid").volume.file,
            Some(PathBuf::from("x/b.vtu"))
        );
    }

    #[test]
    fn mistakes_are_refused_with_their_place() {
        let error = |text: &str, path: &str| {
            SceneFile::parse(text, Path::new(path))
                .expect_err("a mistake")
                .to_string()
        };
        let misspelt = error("version = 1\n[image]\nwidht = 3", "a.toml");
        assert!(
            misspelt.contains("widht") && misspelt.contains("line 3, column 1"),
            "{misspelt}"
        );
        let json = error("{\"version\": 1,\n \"colour\": 2}", "a.json");
        assert!(json.contains("colour") && json.contains("line 2"), "{json}");
        assert!(error("version = 2", "a.toml").contains("version 2"));
        assert!(error("version = ", "a.toml").contains("line 1"));
    }

    #[test]
    fn contradictions_are_refused() {
        for text in [
            "[camera]\nfit = \"+x\"\nposition = [1, 2, 3]",
            "[camera]\nview_angle = 20.0",
            "[camera]\nposition = [9.0, 0.0, 0.0]\nprojection = \"orthographic\"",
            "[camera]\nposition = [9.0, 0.0, 0.0]\nfocal_point = [9.0, 0.0, 0.0]",
            "[appearance]\nrange = [2.0, 1.0]",
            "[appearance]\nunit_distance = -1.0",
            "[appearance]\ndepth_cue = 2.0",
            "[appearance]\nambient = -1.0",
            "[appearance]\nisosurfaces = [{ value = nan }]",
            "[appearance]\nclip_planes = [{ point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 0.0] }]",
            "[image]\nwidth = 0",
        ] {
            let scene = SceneFile::parse(&format!("version = 1\n{text}"), Path::new("a.toml"))
                .expect("parses");
            assert!(scene.resolve(&tet()).is_err(), "{text}");
        }
    }
}
