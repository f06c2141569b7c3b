//! Files that Ctrl-C does not stop halfway.
//!
//! A picture takes its name only when it is complete. What would be left of it otherwise is
//! its temporary file: a signal that comes while one is there ends the program after it.

#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Holds signals back for a while.
pub(crate) struct Whole {
    /// Whether a signal may end the program at once.
    #[cfg(unix)]
    may_end: Arc<AtomicBool>,
    /// The signal that came while it might not, or 0.
    #[cfg(unix)]
    signal: Arc<AtomicUsize>,
}

#[cfg(unix)]
impl Whole {
    pub(crate) fn new() -> Whole {
        use signal_hook::consts::{SIGINT, SIGTERM};
        use signal_hook::flag;
        let may_end = Arc::new(AtomicBool::new(true));
        let signal = Arc::default();
        for number in [SIGINT, SIGTERM] {
            // Where this fails, a signal ends the program as ever.
            let _ = flag::register_conditional_default(number, Arc::clone(&may_end));
            let _ = flag::register_usize(number, Arc::clone(&signal), number as usize);
        }
        Whole { may_end, signal }
    }

    /// Does `write`, and then what a signal asked for.
    pub(crate) fn write<T>(&self, write: impl FnOnce() -> T) -> T {
        self.may_end.store(false, Ordering::SeqCst);
        let written = write();
        self.may_end.store(true, Ordering::SeqCst);
        match self.signal.load(Ordering::SeqCst) {
            0 => {}
            signal => {
                // Ends the program.
                let _ = signal_hook::low_level::emulate_default_handler(signal as i32);
            }
        }
        written
    }
}

#[cfg(not(unix))]
impl Whole {
    pub(crate) fn new() -> Whole {
        Whole {}
    }

    /// Does `write`.
    pub(crate) fn write<T>(&self, write: impl FnOnce() -> T) -> T {
        write()
    }
}
