//! Progress on a terminal, and files.

use std::io::{IsTerminal as _, Write as _};
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tetrascope::core::Error;

/// Writes a file, whole or not at all, and the folders that it is in.
///
/// # Errors
/// The folder or the file cannot be written.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let failed = |source| Error::Io {
        action: "cannot write",
        path: path.into(),
        source,
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    tetrascope::io::write_file(path, content.as_ref())
}

/// Prints a result on standard output; nobody is told where who reads it has enough.
///
/// # Errors
/// It cannot be written.
pub fn print(text: &str) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    match written {
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Io {
            action: "cannot write",
            path: "standard output".into(),
            source,
        }),
        _ => Ok(()),
    }
}

/// A bar on a terminal, nothing elsewhere.
pub(crate) fn progress(steps: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {wide_msg}");
    bar.set_style(style.expect("the template is valid"));
    bar
}

/// Says what is done now: beside the bar, or as a line.
pub(crate) fn phase(progress: &ProgressBar, what: &str) {
    if std::io::stderr().is_terminal() {
        progress.set_message(what.to_owned());
    } else {
        eprintln!("{what}");
    }
}
