//! For programs: what is told to end leaves no file half written, and ends as a shell expects.
//!
//! A picture takes its name only when it is complete. What would be left of it otherwise is its
//! temporary file. A thread that waits for signals removes those and then ends the program by the
//! signal itself, whatever the other threads do: a frame that takes long does not delay it. A shell
//! sees the code 128 and the signal's number: 130 for SIGINT (Ctrl-C), 143 for SIGTERM.

/// From now on SIGINT, SIGTERM and SIGHUP end this process only once its temporary files are gone.
///
/// A signal that is ignored, as SIGHUP is after `nohup`, stays so. Elsewhere than on Unix nothing
/// changes, and neither does it where the system refuses: signals then end the process as ever.
pub fn leave_no_temporary_files() {
    #[cfg(unix)]
    unix::wait();
}

/// Ends this process as `signal` does when nobody handles it, for a program that has put away
/// what it left.
#[cfg(unix)]
pub fn end_by(signal: i32) {
    // Fails for what is not a signal alone.
    let _ = signal_hook::low_level::emulate_default_handler(signal);
}

#[cfg(unix)]
mod unix {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use tetrascope_io::remove_temporary_files_and;

    pub(super) fn wait() {
        let Ok(mut signals) = Signals::new(handled(ignored())) else {
            return;
        };
        let wait = move || {
            if let Some(signal) = signals.forever().next() {
                remove_temporary_files_and(|| super::end_by(signal));
            }
        };
        let started = std::thread::Builder::new()
            .name("signals".into())
            .spawn(wait);
        // Without the thread nobody would end the program.
        if let Err(error) = started {
            panic!("a thread that waits for signals cannot be started: {error}");
        }
    }

    /// The signals to handle where those of the bits of `ignored` are ignored, if that is known.
    fn handled(ignored: Option<u64>) -> Vec<i32> {
        let is_heeded = |signal: &i32| match ignored {
            Some(bits) => bits >> (signal - 1) & 1 == 0,
            // It is what `nohup` has ignored.
            None => *signal != SIGHUP,
        };
        [SIGINT, SIGTERM, SIGHUP]
            .into_iter()
            .filter(is_heeded)
            .collect()
    }

    /// A bit for each signal that this process ignores, the lowest for signal 1; `None` where the
    /// system does not say (proc(5)).
    fn ignored() -> Option<u64> {
        ignored_of(&std::fs::read_to_string("/proc/self/status").ok()?)
    }

    fn ignored_of(status: &str) -> Option<u64> {
        let bits = status
            .lines()
            .find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(bits.trim(), 16).ok()
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn what_is_ignored_stays_so() {
            let bits = ignored_of("Name:\tsh\nSigIgn:\t0000000000000003\nSigCgt:\t0\n");
            assert_eq!(handled(bits), [SIGTERM]);
            assert_eq!(
                handled(ignored_of("SigIgn:\t0000000000001000\n")),
                [SIGINT, SIGTERM, SIGHUP]
            );
            assert_eq!(handled(ignored_of("Name:\tsh\n")), [SIGINT, SIGTERM]);
        }
    }
}
