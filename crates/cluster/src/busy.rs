//! The time that processors have worked for this process, which other programs on the machine do not change.

use std::time::Instant;

/// A clock of work: of seconds that all threads of this process have been on a processor, where the system says so (Linux),
/// and of the wall elsewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    started: Instant,
    before: Option<f64>,
}

impl Work {
    /// A clock that begins now.
    pub(crate) fn start() -> Work {
        Work {
            started: Instant::now(),
            before: seconds(),
        }
    }

    /// Seconds since it began.
    pub(crate) fn seconds(&self) -> f64 {
        match (self.before, seconds()) {
            (Some(before), Some(now)) => (now - before).max(0.0),
            _ => self.started.elapsed().as_secs_f64(),
        }
    }
}

/// Seconds that the threads of this process have worked so far; schedstat of proc(5) is nanoseconds.
fn seconds() -> Option<f64> {
    let mut all = 0.0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let file = thread.ok()?.path().join("schedstat");
        let text = std::fs::read_to_string(file).ok()?;
        let nanoseconds: f64 = text.split(' ').next()?.parse().ok()?;
        all += nanoseconds;
    }
    Some(all * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time() {
        let work = Work::start();
        let mut sum = 0.0_f64;
        for i in 0..2_000_000 {
            sum += f64::from(i).sqrt();
        }
        assert!(sum > 0.0 && work.seconds() > 0.0);
    }
}
