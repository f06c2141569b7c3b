//! The words about a series when it is done.

use std::path::Path;

use serde_json::{Value, json};
use tetrascope::core::Error;
use tetrascope::help;
use tetrascope::io::Step;

use crate::output::{Output, Stop};
use crate::picture::warnings;

/// The frames of a series so far.
#[derive(Default)]
pub(crate) struct Tally<'a> {
    drawn: usize,
    /// Those that were there already.
    skipped: usize,
    /// One for each frame, if they are printed.
    reports: Vec<Value>,
    /// How many frames show little or nothing, and why the first of them does.
    faint: Option<(usize, &'a Step, Error)>,
}

impl<'a> Tally<'a> {
    /// Whether there is any frame.
    pub(crate) fn has_frames(&self) -> bool {
        self.drawn + self.skipped > 0
    }

    /// Counts a frame that was there already.
    pub(crate) fn skip(&mut self, step: &Step, path: &Path) {
        self.skipped += 1;
        self.reports.push(frame(step, path, json!({})));
    }

    /// Counts a frame that was drawn, with what is known about it and why it shows little.
    pub(crate) fn add(
        &mut self,
        step: &'a Step,
        path: &Path,
        picture: Option<Value>,
        warning: Option<Error>,
    ) {
        self.drawn += 1;
        self.reports
            .extend(picture.map(|picture| frame(step, path, picture)));
        if let Some(warning) = warning {
            self.faint.get_or_insert((0, step, warning)).0 += 1;
        }
    }

    /// Prints it; `scene` is that of all frames.
    pub(crate) fn print(
        self,
        scene: Option<Value>,
        warning: Option<&Error>,
        output: &Output,
    ) -> Result<(), Stop> {
        let Tally { drawn, skipped, .. } = self;
        let there = match skipped {
            0 => String::new(),
            _ => format!(", {skipped} were there"),
        };
        let all = drawn + skipped;
        output.note(format_args!("{drawn} of {all} frames drawn{there}"));
        if let Some((count, first, warning)) = &self.faint {
            output.warning(&Error::Invalid {
                what: format!(
                    "{count} of {drawn} frames show little or nothing: of {}, {warning}",
                    first.file.display()
                ),
                help: help(warning),
            });
        }
        match output.json() {
            true => output.json_result(&json!({
                "drawn": drawn,
                "skipped": skipped,
                "scene": scene,
                "frames": self.reports,
                "warnings": warnings(warning),
            })),
            false => Ok(()),
        }
    }
}

/// A frame as JSON; of one that was there already, nothing is known about the picture.
fn frame(step: &Step, path: &Path, mut picture: Value) -> Value {
    let drawn = picture.as_object().is_some_and(|known| !known.is_empty());
    picture["output"] = path.to_string_lossy().into();
    picture["file"] = step.file.to_string_lossy().into();
    picture["time"] = step.time.into();
    picture["drawn"] = drawn.into();
    picture
}
