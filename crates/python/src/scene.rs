//! How a volume is drawn: camera, size, colors, opacity; a scene of the library, completed.

use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::json;
use tetrascope::core::colormap::{linear_to_srgb, srgb_to_linear};
use tetrascope::core::glam::DVec3;
use tetrascope::core::transfer_function::{MAX_OPACITY, Side};
use tetrascope::core::{self, Error, Knot, TransferFunction, number};
use tetrascope::scene::{self, SceneFile, default_unit_distance};

use crate::arrays;
use crate::errors::exception;
use crate::volume::Volume;
use crate::work::run;

/// A scene with nothing left out.
#[pyclass(frozen, module = "tetrascope._tetrascope")]
pub(crate) struct Scene {
    pub(crate) scene: scene::Scene,
}

/// Colors and opacities of Python, which scenes do not name.
struct Paint {
    /// sRGB, evenly over the range of the scalars; those of the scene if empty.
    colors: Vec<DVec3>,
    /// Scalar and opacity, by increasing scalar; that of the scene if there are none.
    opacities: Opacities,
    unit_distance: Option<f64>,
}

enum Opacities {
    OfScene,
    /// Evenly over the range of the scalars.
    Even(Vec<f64>),
    At(Vec<(f64, f64)>),
}

/// The value of a JSON text, which Python has checked for its types.
pub(crate) fn parsed<T: DeserializeOwned>(py: Python<'_>, text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| {
        let error = error.to_string();
        // The place in a text that nobody has written helps nobody.
        let what = error
            .rsplit_once(" at line")
            .map_or(&*error, |(what, _)| what);
        exception(py, &Error::invalid(what))
    })
}

/// Completes a scene, given as JSON, for a volume; with the camera and the size of `view`, if
/// there is one. `colors` are three floats each, sRGB; `opacities` are of scalars, or evenly over
/// their range.
#[pyfunction]
#[pyo3(signature = (volume, json, view=None, colors=None, opacities=None, scalars=None))]
pub(crate) fn resolve(
    py: Python<'_>,
    volume: &Volume,
    json: &str,
    view: Option<&Scene>,
    colors: Option<&Bound<'_, PyAny>>,
    opacities: Option<Vec<f64>>,
    scalars: Option<Vec<f64>>,
) -> PyResult<Scene> {
    let mut file: SceneFile = parsed(py, json)?;
    if let Some(view) = view {
        let complete = view.scene.to_file();
        (file.camera, file.image) = (complete.camera, complete.image);
    }
    let colors = match colors {
        Some(colors) => arrays::points(colors)?,
        None => Vec::new(),
    };
    let paint = Paint {
        colors,
        opacities: match (opacities, scalars) {
            (None, _) => Opacities::OfScene,
            (Some(opacities), None) => Opacities::Even(opacities),
            (Some(opacities), Some(scalars)) => {
                Opacities::At(scalars.into_iter().zip(opacities).collect())
            }
        },
        unit_distance: file.appearance.unit_distance,
    };
    let volume = volume.volume.clone();
    run(py, move || {
        let mut scene = file.resolve(&volume)?;
        if !paint.is_nothing() {
            paint.on(&mut scene, &volume)?;
            scene.appearance.validate_in(&volume.bounds())?;
        }
        Ok(Scene { scene })
    })
}

impl Paint {
    fn is_nothing(&self) -> bool {
        self.colors.is_empty() && matches!(self.opacities, Opacities::OfScene)
    }

    /// Replaces colors and opacities of a scene's transfer function, whose range stays.
    fn on(&self, scene: &mut scene::Scene, volume: &core::Volume) -> Result<(), Error> {
        let old = scene.appearance.transfer_function.clone();
        let (low, high) = old.range();
        let table = thinned(&self.colors);
        let at = |share: f64| low * (1.0 - share) + high * share;
        let mut scalars: Vec<f64> = table.iter().map(|(share, _)| at(*share)).collect();
        let opacities = match &self.opacities {
            Opacities::OfScene => None,
            Opacities::Even(opacities) => {
                let last = opacities.len().saturating_sub(1).max(1) as f64;
                let even = opacities.iter().enumerate();
                Some(even.map(|(i, o)| (at(i as f64 / last), *o)).collect())
            }
            Opacities::At(opacities) => Some(opacities.clone()),
        };
        let extinctions = match opacities {
            None => old.clone(),
            Some(opacities) => {
                let unit_distance = self.unit_distance.unwrap_or_else(|| {
                    let (_, _, forward) = scene.view.camera.axes();
                    let model = scene.appearance.optical_model;
                    let (distance, why) = default_unit_distance(volume, model, forward);
                    let is_of_ramp = |line: &String| {
                        line.starts_with("unit distance:") || line.starts_with("opacity:")
                    };
                    scene.defaults.retain(|line| !is_of_ramp(line));
                    let rounded = number::rounded(distance);
                    scene
                        .defaults
                        .push(format!("unit distance: {rounded}, {why}"));
                    distance
                });
                of_opacities(&opacities, unit_distance)?
            }
        };
        scalars.extend(extinctions.knots().iter().map(|knot| knot.scalar));
        if table.is_empty() {
            scalars.extend(old.knots().iter().map(|knot| knot.scalar));
        }
        scalars.sort_by(f64::total_cmp);
        scalars.dedup();
        let share = |scalar: f64| match low < high {
            true => (scalar * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5),
            false => 0.5,
        };
        let mut knots: Vec<Knot> = Vec::new();
        for scalar in scalars {
            for side in [Side::Below, Side::Above] {
                let (color, _) = old.limit(scalar, side);
                // Keep black and clear what the scene has made so.
                let color = match table.is_empty() || color == DVec3::ZERO {
                    true => color,
                    false => lookup(&table, share(scalar)),
                };
                let knot = Knot {
                    scalar,
                    color,
                    extinction: extinctions.limit(scalar, side).1,
                };
                if knots.last() != Some(&knot) {
                    knots.push(knot);
                }
            }
        }
        scene.appearance.transfer_function = TransferFunction::new(knots)?;
        for surface in &mut scene.appearance.isosurfaces {
            if let Some((color, _)) = scene.appearance.transfer_function.sample(surface.value) {
                surface.color = color;
            }
        }
        if !self.colors.is_empty() {
            scene.defaults.retain(|line| !line.starts_with("colormap:"));
        }
        Ok(())
    }
}

/// Colors of a table at shares of its length, linear RGB: those alone that the eye could miss,
/// which is half a level of 256.
fn thinned(srgb: &[DVec3]) -> Vec<(f64, DVec3)> {
    let last = srgb.len().saturating_sub(1).max(1) as f64;
    let each = |map: fn(f64) -> f64, color: DVec3| DVec3::from_array(color.to_array().map(map));
    let linear: Vec<DVec3> = srgb.iter().map(|c| each(srgb_to_linear, *c)).collect();
    let is_between = |first: usize, end: usize, i: usize| {
        let x = (i - first) as f64 / (end - first) as f64;
        let mixed = each(linear_to_srgb, linear[first].lerp(linear[end], x));
        (mixed - srgb[i]).abs().max_element() <= 0.5 / 255.0
    };
    let mut kept = Vec::new();
    let mut first = 0;
    while first < srgb.len() {
        kept.push((first as f64 / last, linear[first]));
        let reaches = |end: &usize| (first + 1..*end).all(|i| is_between(first, *end, i));
        let next = (first + 1..srgb.len()).take_while(reaches).last();
        first = next.unwrap_or(srgb.len());
    }
    kept
}

/// The color at a share of a table's length.
fn lookup(table: &[(f64, DVec3)], share: f64) -> DVec3 {
    let after = table.partition_point(|(at, _)| *at < share);
    match (after.checked_sub(1).map(|i| table[i]), table.get(after)) {
        (Some((a, color)), Some((b, next))) => color.lerp(*next, (share - a) / (b - a)),
        (Some((_, color)), None) | (None, Some(&(_, color))) => color,
        (None, None) => DVec3::ONE,
    }
}

/// Knots for opacities from 0 to 1, as a scene has them for its color maps.
const KNOTS: f64 = 32.0;

/// Extinctions of opacities that are linear between scalars: σ = −ln(1 − α) / D.
fn of_opacities(opacities: &[(f64, f64)], unit_distance: f64) -> Result<TransferFunction, Error> {
    if !(unit_distance > 0.0 && unit_distance.is_finite()) {
        return Err(Error::Invalid {
            what: format!("a unit distance of {}", number::exact(unit_distance)),
            help: Some(
                "give the distance over which an opacity counts, world units, more than 0".into(),
            ),
        });
    }
    if let Some((i, (_, opacity))) = opacities
        .iter()
        .enumerate()
        .find(|(_, (_, opacity))| !(0.0..=1.0).contains(opacity))
    {
        return Err(Error::Invalid {
            what: format!("opacity {i} is {opacity}"),
            help: Some("give opacities from 0, clear, to 1, opaque".into()),
        });
    }
    let knot = |scalar: f64, opacity: f64| Knot {
        scalar,
        color: DVec3::ZERO,
        extinction: -(-opacity.min(MAX_OPACITY)).ln_1p() / unit_distance,
    };
    let mut knots = Vec::new();
    for pair in opacities.windows(2) {
        let [(s, a), (t, b)] = [pair[0], pair[1]];
        let steps = (KNOTS * (b - a).abs()).ceil().max(1.0) as usize;
        // A step has no scalars in between.
        let steps = if s < t { steps } else { 1 };
        for k in 0..steps {
            let x = k as f64 / steps as f64;
            knots.push(knot(s * (1.0 - x) + t * x, a * (1.0 - x) + b * x));
        }
    }
    knots.extend(
        opacities
            .last()
            .map(|(scalar, opacity)| knot(*scalar, *opacity)),
    );
    // One opacity for all scalars is one knot.
    knots.dedup();
    TransferFunction::new(knots)
}

/// A camera and an image as given, over those of a scene.
#[derive(serde::Deserialize)]
struct Over {
    camera: Option<scene::CameraSpec>,
    image: scene::ImageSpec,
}

#[pymethods]
impl Scene {
    /// The same with what JSON says of camera, width, height and background.
    fn with_view(&self, py: Python<'_>, volume: &Volume, json: &str) -> PyResult<Scene> {
        let over: Over = parsed(py, json)?;
        let mut file = self.scene.to_file();
        if let Some(camera) = over.camera {
            file.camera = camera;
        }
        file.image.background = over.image.background.or(file.image.background);
        if over.image.width.or(over.image.height).is_some() {
            (file.image.width, file.image.height) = (over.image.width, over.image.height);
        }
        let resolved = file.resolve(&volume.volume);
        let resolved = resolved.map_err(|error| exception(py, &error))?;
        Ok(Scene {
            scene: scene::Scene {
                appearance: self.scene.appearance.clone(),
                defaults: self.scene.defaults.clone(),
                ..resolved
            },
        })
    }

    /// The choices for everything that was not given, one line each.
    #[getter]
    fn defaults(&self) -> Vec<String> {
        self.scene.defaults.clone()
    }

    /// The scene with nothing left out, as TOML.
    fn to_toml(&self) -> String {
        self.scene.to_toml()
    }

    /// The same as JSON.
    fn to_json(&self) -> String {
        json!(self.scene.to_file()).to_string()
    }

    /// Width and height, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.scene.view.width, self.scene.view.height)
    }
}
