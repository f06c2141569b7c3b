//! The data that a session's threads share: the newest state, what is to be done of it, what is there.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tetrascope_core::{Error, Frame, Stop};
use tetrascope_io::Step;

use super::pace::Pace;
use super::quick::{self, Expectation};
use super::renderers::{Renderers, Setup};
use super::session::Event;
use super::state::{Applied, Field, State, Wanted};

/// A hand that says nothing for so long rests.
const RESTS_AFTER: Duration = Duration::from_millis(1500);

/// A complete picture.
#[derive(Clone, Debug)]
pub(crate) struct Complete {
    pub(crate) state: Arc<State>,
    pub(crate) frame: Arc<Frame>,
    pub(crate) setup: Setup,
    /// The graphics adapter in words; `None` if the CPU drew.
    pub(crate) adapter: Option<String>,
}

/// The data that all threads see.
pub(crate) struct Shared {
    pub(crate) inbox: Mutex<Inbox>,
    pub(crate) changed: Condvar,
    pub(crate) renderers: Renderers,
    pub(crate) pace: Mutex<Pace>,
    pub(crate) measured: Mutex<Vec<Expectation>>,
    pub(crate) measurements: Option<PathBuf>,
    pub(crate) steps: Vec<Step>,
    pub(crate) tell: Box<dyn Fn(Event) + Send + Sync>,
    pub(crate) pictures: AtomicU64,
    pub(crate) fields: AtomicU64,
    /// Commands are applied one after the other.
    pub(crate) applying: Mutex<()>,
}

/// The work that is to be done: the newest state, never an older one.
pub(crate) struct Inbox {
    pub(crate) state: Arc<State>,
    /// Whether a hand moves.
    pub(crate) moving: bool,
    pub(crate) touched: Instant,
    pub(crate) input: Option<(u64, u64)>,
    /// The versions of the last pictures.
    pub(crate) quick: u64,
    pub(crate) complete: Option<Complete>,
    /// The version whose complete picture is there or cannot be drawn.
    pub(crate) finished: u64,
    pub(crate) judged: u64,
    /// Set while a complete picture or the truth is being drawn.
    pub(crate) full_stop: Option<Stop>,
    pub(crate) judge_stop: Option<Stop>,
    pub(crate) wants_difference: bool,
    pub(crate) wants_estimate: bool,
    /// The version of the difference that is shown.
    pub(crate) differed: u64,
    pub(crate) wanted: Option<(Wanted, Option<u64>)>,
    pub(crate) is_loading: bool,
    pub(crate) is_closing: bool,
}

impl Inbox {
    pub(crate) fn new(state: Arc<State>) -> Inbox {
        Inbox {
            state,
            moving: false,
            touched: Instant::now(),
            input: None,
            quick: 0,
            complete: None,
            finished: 0,
            judged: 0,
            full_stop: None,
            judge_stop: None,
            wants_difference: false,
            wants_estimate: false,
            differed: 0,
            wanted: None,
            is_loading: false,
            is_closing: false,
        }
    }

    /// Whether no hand moves; if one does, how long until it counts as resting.
    pub(crate) fn rests(&self) -> Result<(), Duration> {
        let left = RESTS_AFTER.saturating_sub(self.touched.elapsed());
        match self.moving && !left.is_zero() {
            true => Err(left),
            false => Ok(()),
        }
    }

    pub(crate) fn stop_judge(&self) {
        if let Some(stop) = &self.judge_stop {
            stop.set();
        }
    }

    pub(crate) fn stop_drawing(&self) {
        self.stop_judge();
        if let Some(stop) = &self.full_stop {
            stop.set();
        }
    }
}

impl Shared {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn lock_pace(&self) -> MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn wait<'a>(
        &self,
        inbox: MutexGuard<'a, Inbox>,
        at_most: Duration,
    ) -> MutexGuard<'a, Inbox> {
        let woken = self.changed.wait_timeout(inbox, at_most);
        woken.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Changes the inbox and wakes who waits for it.
    pub(crate) fn update<T>(&self, change: impl FnOnce(&mut Inbox) -> T) -> T {
        let result = change(&mut self.lock());
        self.changed.notify_all();
        result
    }

    /// Puts a state in place of the one there is; what is being drawn of that one ends.
    pub(crate) fn replace(&self, mut next: State, input: Option<(u64, u64)>, moving: bool) {
        let state = self.update(|inbox| {
            next.version = inbox.state.version + 1;
            let state = Arc::new(next);
            inbox.state = state.clone();
            inbox.moving = moving;
            inbox.touched = Instant::now();
            inbox.input = input;
            inbox.stop_drawing();
            state
        });
        (self.tell)(Event::State(state, input.map(|(client, _)| client), moving));
    }

    pub(crate) fn want(&self, wanted: Wanted, client: Option<u64>) {
        self.update(|inbox| inbox.wanted = Some((wanted, client)));
    }

    /// Takes a volume that was loaded, in place of the one there is.
    pub(crate) fn take_field(
        &self,
        field: Arc<Field>,
        wanted: &Wanted,
        client: Option<u64>,
    ) -> Result<(), Error> {
        let _one = self.applying.lock().unwrap_or_else(PoisonError::into_inner);
        let state = self.lock().state.clone();
        let mut next = state.with_field(field)?;
        if let Some(command) = &wanted.then {
            match next.apply(command)? {
                Applied::State(applied) => next = *applied,
                Applied::Load(_) => {
                    return Err(Error::invalid("the view belongs to another volume"));
                }
            }
        }
        self.replace(next, client.map(|client| (client, 0)), false);
        Ok(())
    }

    /// A number for a picture.
    pub(crate) fn next_picture(&self) -> u64 {
        self.pictures.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// A number for a volume that is loaded.
    pub(crate) fn next_field(&self) -> u64 {
        self.fields.fetch_add(1, Ordering::Relaxed) + 1
    }

    pub(crate) fn problem(&self, error: &Error, client: Option<u64>) {
        let problem = Event::Problem(error.to_string(), crate::help(error), client);
        (self.tell)(problem);
    }

    /// The setups that are in use for a state.
    pub(crate) fn used(&self, state: &State) -> [Setup; 2] {
        let measured = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        [Setup::of(state), quick::choose(state, &measured).setup]
    }
}
