//! The needs of a picture, in place of an algorithm: `--error`, `--budget`, `--memory`.

use std::time::Duration;

use clap::Args;
use serde_json::{Value, json};
use tetrascope::Context;
use tetrascope::choose::{Choice, Chooser, Effort, Need, user_cache};
use tetrascope::core::{Error, Volume};
use tetrascope::scene::Scene;

use crate::output::Output;

/// The heading of these options.
const CHOICE: &str = "Choice of the algorithm";

/// Set to "quick", calibrations measure next to nothing: for tests of this program.
const EFFORT: &str = "TETRASCOPE_CALIBRATION";

/// A need, where the algorithm is not named.
#[derive(Args)]
pub(crate) struct NeedArgs {
    /// Choose the fastest setting whose RMSE against the truth is at most this, as 1e-3
    #[arg(long, value_name = "RMSE", value_parser = Need::parse_error, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    error: Option<f64>,
    /// Choose the most exact setting that draws a frame in this time, as 16ms or 0.5s; beside
    /// --error it gives way where both cannot be kept
    #[arg(long, value_name = "TIME", value_parser = Need::parse_budget, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    budget: Option<Duration>,
    /// Choose a setting that holds the volume in this memory, as 2GB or 512MB; a mesh in clusters (.tsc) is
    /// drawn in it
    #[arg(long, value_name = "SIZE", value_parser = Need::parse_memory, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    memory: Option<u64>,
    /// Measure this machine anew before choosing
    #[arg(long, help_heading = CHOICE)]
    recalibrate: bool,
}

/// Options that say which algorithm is meant. Frames that are there already were drawn by one.
const NAMED: [&str; 3] = ["algorithm", "settings", "resume"];

impl NeedArgs {
    /// The needs that were given; `None` if none were.
    pub(crate) fn need(&self) -> Result<Option<Need>, Error> {
        let need = Need {
            error: self.error,
            budget: self.budget,
            memory: self.memory,
        };
        match need == Need::default() {
            true if self.recalibrate => Err(Error::Usage {
                what: "--recalibrate is for choosing an algorithm".into(),
                help: Some("add --error, --budget or --memory".into()),
            }),
            true => Ok(None),
            false => need.validate().map(|()| Some(need)),
        }
    }

    /// Chooses for a scene, and prints what and why.
    pub(crate) fn choose(
        &self,
        need: &Need,
        (volume, scene): (&Volume, &Scene),
        context: &Context,
        output: &Output,
    ) -> Result<Choice, Error> {
        let effort = match std::env::var(EFFORT).as_deref() {
            Ok("quick") => Effort::Quick,
            _ => Effort::Full,
        };
        let mut chooser = Chooser::new(context)
            .with_effort(effort)
            .telling(|line| output.note(line));
        if let Some(folder) = user_cache() {
            chooser = chooser.keeping_in(folder);
        }
        if self.recalibrate {
            chooser.recalibrate();
        }
        let choice = chooser.choose(volume, &scene.appearance, &scene.view, need)?;
        for line in choice.report() {
            output.note(line);
        }
        for way in &choice.gives_way {
            output.warning(&Error::invalid(way.to_string()));
        }
        Ok(choice)
    }
}

/// A choice as JSON.
pub(crate) fn choice_json(choice: &Choice) -> Value {
    let gives_way = choice.gives_way.iter().map(ToString::to_string);
    json!({
        "chosen": choice.trial,
        "trials": choice.trials,
        "considered": choice.considered,
        "gives_way": gives_way.collect::<Vec<String>>(),
        "failures": choice.failures,
    })
}
