//! The parts of the command line that its programs share: how a volume and its look are chosen, and what is printed.
//!
//! [`options`] are those of `tetrascope render` that choose a volume and a look, with their [`values`]; [`request`] makes a
//! scene of them; [`output`] prints results on stdout and everything else on stderr.

pub mod options;
pub mod output;
pub mod request;
pub mod values;

pub use options::{Elsewhere, Global, GridArgs, SceneArgs, SourceArgs, VolumeArgs};
pub use output::{Output, Stop};
pub use request::Request;

use tetrascope_core::ErrorKind;

/// The exit code of a program that an error ends, as `--help` documents them.
pub fn exit_code(kind: ErrorKind) -> u8 {
    match kind {
        ErrorKind::Failure => 1,
        ErrorKind::Usage => 2,
        ErrorKind::Input => 3,
        ErrorKind::Gpu => 4,
    }
}

/// Makes a file that grows beyond the limit of this process (`ulimit -f`) an error of the
/// write, which then removes its temporary file: unless SIGXFSZ is handled, it kills.
#[cfg(unix)]
pub fn outlive_large_files() {
    let noted = std::sync::Arc::default();
    // Where this fails, all is as it was.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, noted);
}

/// Starts `count` threads, on which all work in parallel is done.
///
/// # Errors
/// [`Error::Invalid`](tetrascope_core::Error::Invalid) where the system refuses.
pub fn use_threads(count: usize) -> Result<(), tetrascope_core::Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(|error| {
        tetrascope_core::Error::invalid(format!("cannot start {count} threads: {error}"))
    })
}
