//! All that is printed: results on stdout, progress and messages on stderr.

use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use tetrascope::Progress;
use tetrascope::core::Error;

use crate::args::Global;

/// Why a command ends early.
pub(crate) enum Stop {
    /// Something is wrong.
    Error(Error),
    /// Whoever read stdout, such as `head`, has enough; that is no error.
    ClosedPipe,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        Stop::Error(error)
    }
}

/// Where results, progress and messages go.
pub(crate) struct Output {
    /// Results as JSON; stderr then carries nothing but an error's JSON line.
    json: bool,
    quiet: bool,
    verbose: bool,
    /// Whether stderr is a terminal.
    terminal: bool,
    /// Where a terminal shows the step that is running.
    bar: Option<ProgressBar>,
}

impl Output {
    pub(crate) fn new(global: &Global) -> Output {
        let terminal = io::stderr().is_terminal();
        let watched = terminal && !global.json && !global.quiet;
        Output {
            json: global.json,
            quiet: global.quiet,
            verbose: global.verbose > 0,
            terminal,
            bar: watched.then(ProgressBar::no_length),
        }
    }

    pub(crate) fn json(&self) -> bool {
        self.json
    }

    /// Whether stderr is to be colored (<https://no-color.org>).
    pub(crate) fn color(&self) -> bool {
        self.terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
    }

    /// Prints a result on stdout, with a newline.
    pub(crate) fn result(&self, text: impl Display) -> Result<(), Stop> {
        let mut stdout = io::stdout().lock();
        let written = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
        written.map_err(|source| match source.kind() {
            io::ErrorKind::BrokenPipe => Stop::ClosedPipe,
            _ => Stop::Error(Error::Io {
                action: "cannot write",
                path: PathBuf::from("standard output"),
                source,
            }),
        })
    }

    /// Prints a result as JSON on stdout.
    pub(crate) fn json_result(&self, value: &serde_json::Value) -> Result<(), Stop> {
        self.result(format_args!("{value:#}"))
    }

    /// A message for whoever watches.
    pub(crate) fn note(&self, text: impl Display) {
        if !self.quiet && !self.json {
            self.stderr(text);
        }
    }

    /// A message for whoever watches closely, with `-v`.
    pub(crate) fn detail(&self, text: impl Display) {
        if self.verbose && !self.json {
            self.stderr(text);
        }
    }

    /// A problem that does not stop the command.
    pub(crate) fn warning(&self, warning: &Error) {
        if !self.json {
            self.stderr(format_args!("{} {warning}", self.paint("33", "warning:")));
            self.help(warning);
        }
    }

    /// The error that ends the command, and its exit code.
    pub(crate) fn error(&self, error: &Error, code: u8) {
        if self.json {
            self.stderr(json!({
                "code": code,
                "message": error.to_string(),
                "help": error.help(),
            }));
            return;
        }
        self.stderr(format_args!("{} {error}", self.paint("31", "error:")));
        self.help(error);
    }

    fn help(&self, error: &Error) {
        if let Some(help) = error.help() {
            self.stderr(format_args!("  help: {help}"));
        }
    }

    /// Runs a step that takes time, announced as `what`; gives its seconds too.
    ///
    /// A terminal shows a spinner, or a bar while the step calls what
    /// [`Output::progress`] gave; anything else gets one line.
    pub(crate) fn timed<T>(
        &self,
        what: &str,
        step: impl FnOnce() -> Result<T, Error>,
    ) -> Result<(T, f64), Error> {
        match &self.bar {
            Some(bar) => {
                bar.reset();
                bar.unset_length();
                bar.set_style(style("{spinner} {msg} ({elapsed})"));
                bar.set_message(what.to_owned());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
            None => self.note(what),
        }
        let started = Instant::now();
        let result = step();
        let seconds = started.elapsed().as_secs_f64();
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
            self.note(format_args!("{what} ({seconds:.2} s)"));
        }
        Ok((result?, seconds))
    }

    /// Moves the terminal's bar, if there is one.
    pub(crate) fn progress(&self) -> Option<Progress> {
        const STEPS: u64 = 1000;
        let bar = self.bar.clone()?;
        Some(Arc::new(move |share: f64| {
            if bar.length().is_none() {
                bar.set_length(STEPS);
                bar.set_style(style("{msg} {bar:30} {percent} % ({elapsed})"));
            }
            bar.set_position((share * STEPS as f64) as u64);
        }))
    }

    fn paint(&self, sgr: &str, word: &str) -> String {
        if self.color() {
            format!("\x1b[1;{sgr}m{word}\x1b[0m")
        } else {
            word.into()
        }
    }

    fn stderr(&self, text: impl Display) {
        // A closed stderr leaves nobody to tell.
        let _ = writeln!(io::stderr(), "{text}");
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is valid")
}

/// Prints what clap says: help and version on stdout, a mistake on stderr.
///
/// With `--json` among the arguments a mistake is a JSON line.
pub(crate) fn usage(error: &clap::Error) -> ExitCode {
    let json = std::env::args_os().any(|arg| arg == OsStr::new("--json"));
    if json && error.use_stderr() {
        let text = error.render().to_string();
        let line = |prefix: &str| {
            let mut lines = text.lines().map(str::trim);
            lines.find_map(|line| line.strip_prefix(prefix).map(str::to_owned))
        };
        let _ = writeln!(
            io::stderr(),
            "{}",
            json!({
                "code": 2,
                "message": line("error: ").unwrap_or_else(|| text.trim().to_owned()),
                "help": line("tip: ").unwrap_or_else(|| "see `tetrascope --help`".into()),
            })
        );
    } else {
        // Nobody reads it: nothing is lost.
        let _ = error.print();
    }
    if error.use_stderr() {
        ExitCode::from(2)
    } else {
        ExitCode::SUCCESS
    }
}
