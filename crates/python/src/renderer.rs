//! A renderer that stays: volumes, appearances and views come at their own rates.

use std::sync::{Arc, Mutex};

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods as _};
use pyo3::prelude::*;
use serde_json::json;
use tetrascope::core::{self, Error, Frame, Stop, VolumeRenderer as _};
use tetrascope::{Algorithm, Settings, algorithm, emptiness};

use crate::context;
use crate::errors::exception;
use crate::scene::Scene;
use crate::volume::Volume;
use crate::work::{run, run_on};

/// A renderer of the registry.
#[pyclass(frozen, module = "tetrascope._tetrascope")]
pub(crate) struct Renderer {
    algorithm: &'static Algorithm,
    settings: Settings,
    /// Ends the frame of an interrupted call.
    stop: Stop,
    shared: Arc<Mutex<Loaded>>,
}

struct Loaded {
    renderer: tetrascope::Renderer,
    volume: core::Volume,
}

/// Pixels, depths of surfaces, statistics as JSON; why the picture shows nothing and how to
/// help.
pub(crate) type Drawn<'py> = (
    Bound<'py, PyArray3<f32>>,
    Option<Bound<'py, PyArray2<f32>>>,
    String,
    Option<(String, Option<String>)>,
);

/// A frame's pixels and depths as arrays, without a copy.
pub(crate) fn drawn(py: Python<'_>, frame: Frame, warning: Option<Error>) -> PyResult<Drawn<'_>> {
    let size = [frame.height as usize, frame.width as usize];
    let stats = json!(frame.stats).to_string();
    let pixels = PyArray1::from_vec(py, frame.pixels.into_flattened());
    let depths = frame.depths.map(|depths| {
        let depths = PyArray1::from_vec(py, depths);
        depths.reshape(size)
    });
    Ok((
        pixels.reshape([size[0], size[1], 4])?,
        depths.transpose()?,
        stats,
        warning.map(|warning| (warning.to_string(), warning.help())),
    ))
}

#[pymethods]
impl Renderer {
    /// Builds a renderer; `settings` are "key=value".
    #[new]
    fn new(
        py: Python<'_>,
        volume: &Volume,
        scene: &Scene,
        algorithm: &str,
        settings: Vec<String>,
    ) -> PyResult<Renderer> {
        let (algorithm, settings) =
            chosen(algorithm, &settings).map_err(|error| exception(py, &error))?;
        let (volume, scene) = (volume.volume.clone(), scene.scene.clone());
        let of_frame = settings.clone();
        let stop = Stop::new();
        let context = context().clone().with_stop(stop.clone());
        let loaded = run(py, move || {
            let appearance = &scene.appearance;
            (algorithm.supports)(&volume, appearance, &scene.view, &of_frame)?;
            let renderer = (algorithm.build)(&context, &volume, appearance, &of_frame)?;
            Ok(Loaded { renderer, volume })
        })?;
        Ok(Renderer {
            algorithm,
            settings,
            stop,
            shared: Arc::new(Mutex::new(loaded)),
        })
    }

    /// Draws one frame.
    fn render<'py>(&self, py: Python<'py>, scene: &Scene) -> PyResult<Drawn<'py>> {
        let scene = scene.scene.clone();
        let (algorithm, settings) = (self.algorithm, self.settings.clone());
        let (frame, warning) = run_on(py, &self.shared, &self.stop, move |loaded| {
            let Loaded { renderer, volume } = loaded;
            (algorithm.supports)(volume, &scene.appearance, &scene.view, &settings)?;
            scene.view.check_memory(BYTES_PER_PIXEL)?;
            let frame = renderer.render(&scene.view)?;
            let warning = emptiness::explain(volume, &scene.appearance, &scene.view, &frame);
            Ok((frame, warning))
        })?;
        drawn(py, frame, warning)
    }

    /// Takes a volume whose geometry or scalars changed.
    fn reload(&self, py: Python<'_>, volume: &Volume) -> PyResult<()> {
        let volume = volume.volume.clone();
        run_on(py, &self.shared, &self.stop, move |loaded| {
            loaded.renderer.reload(&volume)?;
            loaded.volume = volume;
            Ok(())
        })
    }

    /// Takes another appearance.
    fn restyle(&self, py: Python<'_>, scene: &Scene) -> PyResult<()> {
        let scene = scene.scene.clone();
        let (algorithm, settings) = (self.algorithm, self.settings.clone());
        run_on(py, &self.shared, &self.stop, move |loaded| {
            let appearance = &scene.appearance;
            (algorithm.supports)(&loaded.volume, appearance, &scene.view, &settings)?;
            loaded.renderer.restyle(appearance)
        })
    }

    /// The algorithm's name.
    #[getter]
    fn algorithm(&self) -> &'static str {
        self.algorithm.name
    }

    /// Names and values of all settings.
    #[getter]
    fn settings(&self) -> Vec<(String, String)> {
        let settings = self.settings.iter();
        settings.map(|(k, v)| (k.into(), v.into())).collect()
    }

    /// The graphics adapter in words; `None` if the CPU draws.
    #[getter]
    fn adapter(&self) -> Option<String> {
        context().adapter().filter(|_| self.algorithm.needs_gpu)
    }
}

/// Memory for a pixel of any algorithm's picture, at least: the frame with its depths, twice.
pub(crate) const BYTES_PER_PIXEL: u64 = 2 * (16 + 4);

/// An algorithm and its settings by their names.
pub(crate) fn chosen(
    name: &str,
    settings: &[String],
) -> Result<(&'static Algorithm, Settings), Error> {
    let algorithm = algorithm(name)?;
    let settings = Settings::parse(algorithm, settings.iter().map(String::as_str))?;
    Ok((algorithm, settings))
}
