//! The choice of an algorithm by error, time and memory.

use std::time::Duration;

use pyo3::prelude::*;
use serde_json::json;
use tetrascope::choose::{Chooser, Effort, Need, user_cache};
use tetrascope::core::Error;

use crate::context;
use crate::errors::exception;
use crate::renderer::{BYTES_PER_PIXEL, Drawn, drawn};
use crate::scene::Scene;
use crate::volume::Volume;
use crate::work::run_telling;

/// A picture; the name and the settings of what has drawn it; a report as JSON.
type Chosen<'py> = (Drawn<'py>, String, Vec<(String, String)>, String);

/// Chooses and draws. Gives the picture; the name and the settings of what has drawn it; and a
/// report as JSON. `say` is called with lines on what is being measured.
#[pyfunction]
#[pyo3(signature = (volume, scene, error, budget, memory, quick, keep, anew, say))]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub(crate) fn choose<'py>(
    py: Python<'py>,
    volume: &Volume,
    scene: &Scene,
    error: Option<f64>,
    budget: Option<f64>,
    memory: Option<u64>,
    quick: bool,
    keep: bool,
    anew: bool,
    say: &Bound<'py, PyAny>,
) -> PyResult<Chosen<'py>> {
    let budget = budget.map(Duration::try_from_secs_f64).transpose();
    let need = budget.map_err(|_| Error::Usage {
        what: "a budget that is not a time".into(),
        help: Some("give more than 0".into()),
    });
    let need = need.and_then(|budget| {
        let need = Need {
            error,
            budget,
            memory,
        };
        need.validate().map(|()| need)
    });
    let need = need.map_err(|error| exception(py, &error))?;
    let (volume, scene) = (volume.volume.clone(), scene.scene.clone());
    let choice = run_telling(
        py,
        |line| say.call1((line,)).map(drop),
        move |tell| {
            scene.view.check_memory(BYTES_PER_PIXEL)?;
            let effort = if quick { Effort::Quick } else { Effort::Full };
            let mut chooser = Chooser::new(context()).with_effort(effort).telling(tell);
            if let (true, Some(folder)) = (keep, user_cache()) {
                chooser = chooser.keeping_in(folder);
            }
            if anew {
                chooser.recalibrate();
            }
            chooser.choose(&volume, &scene.appearance, &scene.view, &need)
        },
    )?;
    let gives_way = choice.gives_way.iter().map(ToString::to_string);
    let report = json!({
        "chosen": choice.trial,
        "trials": choice.trials,
        "considered": choice.considered,
        "gives_way": gives_way.collect::<Vec<_>>(),
        "failures": choice.failures,
        "report": choice.report(),
    });
    let settings = choice.settings.iter();
    let settings = settings.map(|(k, v)| (k.into(), v.into())).collect();
    let name = choice.algorithm.name.to_owned();
    Ok((
        drawn(py, choice.frame, None)?,
        name,
        settings,
        report.to_string(),
    ))
}
