//! A watch over what may hang.

use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

/// Ends the program, and says what hangs, if something that is watched takes too long.
///
/// A shader that hangs cannot be stopped from within, and neither can a loop.
pub(super) struct Watch {
    shared: Arc<Shared>,
}

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The picture that is watched, and since when.
    watched: Option<(String, Instant)>,
    is_over: bool,
}

impl Watch {
    /// A watch that waits so long.
    pub(super) fn new(limit: Duration) -> Watch {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            changed: Condvar::new(),
        });
        let watcher = Arc::clone(&shared);
        std::thread::spawn(move || watcher.watch(limit));
        Watch { shared }
    }

    /// Watches until the value is dropped.
    pub(super) fn over(&self, what: String) -> Watched<'_> {
        self.shared.set(Some((what, Instant::now())));
        Watched(&self.shared)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.shared.lock().is_over = true;
        self.shared.changed.notify_all();
    }
}

/// A picture that is watched.
pub(super) struct Watched<'a>(&'a Shared);

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        self.0.set(None);
    }
}

impl Shared {
    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().expect("nobody panics with it")
    }

    fn set(&self, watched: Option<(String, Instant)>) {
        self.lock().watched = watched;
    }

    fn watch(&self, limit: Duration) {
        let mut state = self.lock();
        while !state.is_over {
            if let Some((what, since)) = &state.watched
                && since.elapsed() > limit
            {
                eprintln!(
                    "error: {what}: hangs: no picture after {} s",
                    limit.as_secs()
                );
                std::process::exit(5);
            }
            let woken = self.changed.wait_timeout(state, Duration::from_secs(1));
            state = woken.expect("nobody panics with it").0;
        }
    }
}
