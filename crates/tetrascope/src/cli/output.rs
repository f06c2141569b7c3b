//! All that is printed: results on stdout, progress and messages on stderr.
//!
//! Text of files goes into both. What a terminal would obey is escaped here, and in the
//! `Display` of errors; only the bytes of a result that a program reads stay as they are.

use std::ffi::OsStr;
use std::fmt::{Display, Write as _};
use std::io::{self, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use tetrascope_core::Error;
use tetrascope_core::text::{clip, is_unprintable, printable};

use super::Global;
use crate::{Progress, help};

/// Why a command ends early.
pub enum Stop {
    /// Something is wrong.
    Error(Error),
    /// Something is wrong with a step of a series.
    Step(Box<StepError>),
    /// Whoever read stdout, such as `head`, has enough; that is no error.
    ClosedPipe,
}

/// An error in a step of a series.
pub struct StepError {
    /// The error.
    pub error: Error,
    /// The step's file.
    pub file: PathBuf,
    /// A hint beside the error's own.
    pub help: Option<&'static str>,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        Stop::Error(error)
    }
}

/// Where results, progress and messages go.
pub struct Output {
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
    /// Output as the options of every command say.
    pub fn new(global: &Global) -> Output {
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

    /// For errors that come before the options are known.
    pub fn plain(json: bool) -> Output {
        Output {
            json,
            quiet: false,
            verbose: false,
            terminal: io::stderr().is_terminal(),
            bar: None,
        }
    }

    /// Whether results are printed as JSON.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Whether stderr is to be colored (<https://no-color.org>).
    pub fn color(&self) -> bool {
        self.terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
    }

    /// Prints text for programs on stdout, with a newline; a terminal gets it printable.
    pub fn result(&self, text: impl Display) -> Result<(), Stop> {
        let text = text.to_string();
        if !io::stdout().is_terminal() {
            return print(text.as_bytes());
        }
        let lines: Vec<_> = text.split('\n').map(printable).collect();
        print(lines.join("\n").as_bytes())
    }

    /// Prints lines for people on stdout.
    pub fn lines(&self, lines: &[String]) -> Result<(), Stop> {
        let lines: Vec<_> = lines.iter().map(|line| clip(line, LONGEST_LINE)).collect();
        print(lines.join("\n").as_bytes())
    }

    /// Prints the name of a file that was written: a program gets its very bytes.
    pub fn written(&self, path: &Path) -> Result<(), Stop> {
        match io::stdout().is_terminal() {
            true => self.result(path.display()),
            false => print(path.as_os_str().as_encoded_bytes()),
        }
    }

    /// Prints a result as JSON on stdout.
    pub fn json_result(&self, value: &serde_json::Value) -> Result<(), Stop> {
        print(ascii_controls(&format!("{value:#}")).as_bytes())
    }

    /// A message for whoever watches.
    pub fn note(&self, text: impl Display) {
        if !self.quiet && !self.json {
            self.stderr(clip(&text.to_string(), LONGEST_LINE));
        }
    }

    /// A message for whoever watches closely, with `-v`.
    pub fn detail(&self, text: impl Display) {
        if self.verbose && !self.json {
            self.stderr(clip(&text.to_string(), LONGEST_LINE));
        }
    }

    /// A problem that does not stop the command.
    pub fn warning(&self, warning: &Error) {
        if !self.json {
            self.stderr(format_args!("{} {warning}", self.paint("33", "warning:")));
            self.help(warning);
        }
    }

    /// The error that ends the command, and its exit code.
    pub fn error(&self, error: &Error, code: u8) {
        if self.json {
            self.stderr(json_line(code, &error.to_string(), help(error)));
            return;
        }
        self.stderr(format_args!("{} {error}", self.paint("31", "error:")));
        self.help(error);
    }

    /// The error in a step of a series, which ends the command.
    pub fn error_in(&self, step: &StepError, code: u8) {
        let StepError {
            error,
            file,
            help: more,
        } = step;
        let message = match error {
            // These name a file themselves, be it another.
            Error::Io { .. } | Error::Format { .. } => error.to_string(),
            _ => format!(
                "{error}, in {}",
                clip(&file.to_string_lossy(), LONGEST_PATH)
            ),
        };
        let helps = help(error).into_iter().chain(more.map(String::from));
        let helps: Vec<String> = helps.collect();
        let help = (!helps.is_empty()).then(|| helps.join("; "));
        if self.json {
            self.stderr(json_line(code, &message, help));
            return;
        }
        self.stderr(format_args!("{} {message}", self.paint("31", "error:")));
        if let Some(help) = help {
            self.stderr(format_args!("  help: {help}"));
        }
    }

    fn help(&self, error: &Error) {
        if let Some(help) = help(error) {
            self.stderr(format_args!("  help: {help}"));
        }
    }

    /// Runs a step that takes time, announced as `what`; gives its seconds too.
    ///
    /// A terminal shows a spinner, or a bar while the step calls what
    /// [`Output::progress`] gave; anything else gets one line.
    pub fn timed<T>(
        &self,
        what: &str,
        step: impl FnOnce() -> Result<T, Error>,
    ) -> Result<(T, f64), Error> {
        match &self.bar {
            Some(bar) => {
                bar.reset();
                bar.unset_length();
                bar.set_style(style("{spinner} {msg} ({elapsed})"));
                bar.set_message(clip(what, LONGEST_LINE).into_owned());
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
    pub fn progress(&self) -> Option<Progress> {
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

    /// Begins work on so many steps of a series.
    ///
    /// A terminal shows one bar over all of them.
    pub fn watch(&self, count: usize) -> Watch<'_> {
        if let Some(bar) = &self.bar {
            bar.reset();
            bar.set_length(Watch::PARTS * count as u64);
            bar.set_style(style("{msg} {bar:30} {percent} % ({elapsed}, {eta} left)"));
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Watch {
            output: self,
            done: Arc::default(),
        }
    }

    /// Prints without disturbing the bar.
    fn beside_bar<T>(&self, print: impl FnOnce() -> T) -> T {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
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

/// The display of the work on the steps of a series.
pub struct Watch<'a> {
    output: &'a Output,
    done: Arc<AtomicU64>,
}

impl Watch<'_> {
    /// Parts of the bar per step.
    const PARTS: u64 = 1000;

    /// Says at what work is.
    pub fn begin(&self, what: &str) {
        if let Some(bar) = &self.output.bar {
            bar.set_message(clip(what, LONGEST_PATH).into_owned());
        }
    }

    /// Says that a step is done.
    pub fn end(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(bar) = &self.output.bar {
            bar.set_position(Self::PARTS * done);
        }
    }

    /// Prints a line for whoever watches where there is no bar.
    pub fn line(&self, text: impl Display) {
        match self.output.bar {
            Some(_) => self.detail(text),
            None => self.output.note(text),
        }
    }

    /// As [`Output::note`].
    pub fn note(&self, text: impl Display) {
        self.output.beside_bar(|| self.output.note(text));
    }

    /// As [`Output::detail`].
    pub fn detail(&self, text: impl Display) {
        self.output.beside_bar(|| self.output.detail(text));
    }

    /// As [`Output::written`].
    pub fn written(&self, path: &Path) -> Result<(), Stop> {
        self.output.beside_bar(|| self.output.written(path))
    }

    /// Moves the bar within a step, if there is one.
    pub fn progress(&self) -> Option<Progress> {
        let bar = self.output.bar.clone()?;
        let done = self.done.clone();
        Some(Arc::new(move |share: f64| {
            let part = (share * Self::PARTS as f64) as u64;
            bar.set_position(Self::PARTS * done.load(Ordering::Relaxed) + part);
        }))
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        if let Some(bar) = &self.output.bar {
            bar.finish_and_clear();
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is valid")
}

/// The most characters of a line: names are shorter, lists of counts are not.
const LONGEST_LINE: usize = 800;

/// The most characters of a file's path, with what is said of it.
const LONGEST_PATH: usize = 300;

/// Writes bytes to stdout, with a newline.
fn print(bytes: &[u8]) -> Result<(), Stop> {
    let mut stdout = io::stdout().lock();
    let written = stdout
        .write_all(bytes)
        .and_then(|()| stdout.write_all(b"\n"))
        .and_then(|()| stdout.flush());
    written.map_err(|source| match source.kind() {
        io::ErrorKind::BrokenPipe => Stop::ClosedPipe,
        _ => Stop::Error(Error::Io {
            action: "cannot write",
            path: PathBuf::from("standard output"),
            source,
        }),
    })
}

/// JSON with `\u009b` for what [`printable`] escapes and JSON does not; line ends between
/// its values stay.
fn ascii_controls(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c == '\n' || !is_unprintable(c) {
            text.push(c);
            continue;
        }
        // Within strings alone, where an escape is as good.
        for unit in c.encode_utf16(&mut [0; 2]) {
            let _ = write!(text, "\\u{unit:04x}");
        }
    }
    text
}

/// An error as one line of JSON.
fn json_line(code: u8, message: &str, help: Option<String>) -> String {
    let line = json!({ "code": code, "message": message, "help": help });
    ascii_controls(&line.to_string())
}

/// Prints what clap says: help and version on stdout, a mistake on stderr.
///
/// With `--json` among the arguments a mistake is a JSON line.
pub fn usage(error: &clap::Error) -> Result<ExitCode, Stop> {
    if !error.use_stderr() {
        return print(error.render().to_string().trim_end().as_bytes()).map(|()| ExitCode::SUCCESS);
    }
    let json = std::env::args_os().any(|arg| arg == OsStr::new("--json"));
    // What was typed is quoted, and may come from a script that found it in a folder.
    let mut text = error.render().to_string();
    for argument in std::env::args_os() {
        let argument = argument.to_string_lossy();
        if clip(&argument, LONGEST_LINE) != argument {
            text = text.replace(&*argument, &clip(&argument, LONGEST_LINE));
            // `--option=value` is quoted in parts.
            if let Some((_, value)) = argument.split_once('=') {
                text = text.replace(value, &clip(value, LONGEST_LINE));
            }
        }
    }
    let lines: Vec<_> = text.trim_end().split('\n').map(printable).collect();
    if json {
        let line = |prefix: &str| {
            let mut lines = lines.iter().map(|line| line.trim());
            lines.find_map(|line| line.strip_prefix(prefix).map(str::to_owned))
        };
        let message = line("error: ").unwrap_or_else(|| lines.join(" "));
        let help = line("tip: ").unwrap_or_else(|| "see `tetrascope --help`".into());
        let _ = writeln!(io::stderr(), "{}", json_line(2, &message, Some(help)));
    } else if text == error.render().to_string() && !text.contains(hidden) {
        // With clap's own colors. Nobody reads it: nothing is lost.
        let _ = error.print();
    } else {
        let _ = writeln!(io::stderr(), "{}", lines.join("\n"));
    }
    Ok(ExitCode::from(2))
}

/// Whether a character must not appear in a line of text.
fn hidden(c: char) -> bool {
    c != '\n' && is_unprintable(c)
}
