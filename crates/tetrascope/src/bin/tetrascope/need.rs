//! What a picture has to keep, in place of an algorithm: `--error`, `--budget`, `--memory`.

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
    #[arg(long, value_name = "RMSE", value_parser = error, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    error: Option<f64>,
    /// Choose the most exact setting that draws a frame in this time, as 16ms or 0.5s; beside
    /// --error it gives way where both cannot be kept
    #[arg(long, value_name = "TIME", value_parser = budget, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    budget: Option<Duration>,
    /// Choose a setting that holds the volume in this memory, as 2GB or 512MB
    #[arg(long, value_name = "SIZE", value_parser = memory, conflicts_with_all = NAMED, help_heading = CHOICE, allow_hyphen_values = true)]
    memory: Option<u64>,
    /// Measure this machine anew before choosing
    #[arg(long, help_heading = CHOICE)]
    recalibrate: bool,
}

/// What says which algorithm is meant. Frames that are there already were drawn by one.
const NAMED: [&str; 3] = ["algorithm", "settings", "resume"];

impl NeedArgs {
    /// What is asked for; `None` if nothing is.
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

fn error(text: &str) -> Result<f64, String> {
    let error = text
        .trim()
        .parse()
        .ok()
        .filter(|e: &f64| *e > 0.0 && e.is_finite());
    error.ok_or_else(|| "give an RMSE of more than 0, such as 1e-3".into())
}

fn budget(text: &str) -> Result<Duration, String> {
    const UNITS: [(&str, f64); 5] = [
        ("ms", 1e-3),
        ("us", 1e-6),
        ("µs", 1e-6),
        ("min", 60.0),
        ("s", 1.0),
    ];
    let seconds = quantity(text, &UNITS);
    let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    let duration = duration.filter(|duration| !duration.is_zero());
    duration.ok_or_else(|| "write it like 16ms or 0.5s".into())
}

fn memory(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 9] = [
        ("kB", 1e3),
        ("KB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
        ("KiB", 1024.0),
        ("MiB", 1048576.0),
        ("GiB", 1073741824.0),
        ("B", 1.0),
    ];
    let bytes = quantity(text, &UNITS);
    let bytes = bytes.filter(|b| *b >= 1.0 && *b < u64::MAX as f64);
    let bytes = bytes.map(|bytes| bytes as u64);
    bytes.ok_or_else(|| "write it like 2GB or 512MB".into())
}

/// A number with the first unit that its text ends with; units that end others come last.
fn quantity(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let (number, unit) = units
        .iter()
        .find_map(|(unit, size)| Some((text.strip_suffix(unit)?, size)))?;
    let number: f64 = number.trim().parse().ok()?;
    Some(number * unit).filter(|n| *n > 0.0 && n.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_units() {
        assert_eq!(budget("16ms"), Ok(Duration::from_millis(16)));
        assert_eq!(budget("0.5s"), Ok(Duration::from_millis(500)));
        assert_eq!(budget("250 µs"), Ok(Duration::from_micros(250)));
        assert_eq!(budget("2min"), Ok(Duration::from_secs(120)));
        for wrong in [
            "", "16", "ms", "-1ms", "0s", "infs", "nans", "1e400s", "1e30s", "16 m", "1e-12s",
        ] {
            assert_eq!(
                budget(wrong),
                Err("write it like 16ms or 0.5s".into()),
                "{wrong}"
            );
        }
        assert_eq!(memory("2GB"), Ok(2_000_000_000));
        assert_eq!(memory("512 MB"), Ok(512_000_000));
        assert_eq!(memory("1.5GiB"), Ok(3 << 29));
        assert_eq!(memory("100B"), Ok(100));
        for wrong in ["", "2", "GB", "-2GB", "0B", "2gb", "1e30TB", "0.5B"] {
            assert_eq!(
                memory(wrong),
                Err("write it like 2GB or 512MB".into()),
                "{wrong}"
            );
        }
        assert_eq!(error("1e-3"), Ok(1e-3));
        for wrong in ["", "0", "-1", "nan", "inf", "1e-3s"] {
            assert!(error(wrong).is_err(), "{wrong}");
        }
    }
}
