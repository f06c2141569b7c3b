//! The state of a viewer and the threads that draw it, without a network.

use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tetrascope_core::{Error, Settings};
use tetrascope_io::Step;
use tetrascope_scene::SceneFile;

use super::command::Message;
use super::encoded::Encoded;
use super::judge::{self, Estimate};
use super::loader;
use super::renderers::Renderers;
use super::shared::{Complete, Inbox, Shared};
use super::state::{Applied, Field, State};
use super::workers;
use crate::volumes::Loaded;
use crate::{Algorithm, Context};

/// The beginning of a session.
pub struct Start {
    /// The scene that is asked for; its volume's file is absolute, so that a saved scene finds it.
    pub scene: SceneFile,
    /// The volume that it names, or the first step's.
    pub loaded: Loaded,
    /// The time steps, if there are several.
    pub steps: Vec<Step>,
    /// The algorithm that draws complete pictures.
    pub algorithm: &'static Algorithm,
    /// How.
    pub settings: Settings,
    /// Where this machine's measurements are ([`user_cache`](crate::choose::user_cache)).
    pub measurements: Option<PathBuf>,
}

/// An event in a session.
#[derive(Clone, Debug)]
pub enum Event {
    /// Another state; by which client, if by one, and whether more is about to follow.
    State(Arc<State>, Option<u64>, bool),
    /// A picture.
    Picture(Arc<Encoded>),
    /// How wrong a complete picture is.
    Estimate(Arc<Estimate>),
    /// The share of the truth that is drawn, of a version of the state.
    Progress(u64, f64),
    /// Something could not be done; by whose wish, if by somebody's.
    Problem(String, Option<String>, Option<u64>),
    /// Something to know.
    Note(String, Option<u64>),
}

/// A viewer without a network. Dropping it ends its threads.
pub struct Session {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

impl Session {
    /// Starts the threads; `tell` is called by any of them.
    ///
    /// # Errors
    /// Those of [`SceneFile::resolve`], what the algorithm does not draw, and threads that the
    /// system refuses.
    pub fn start(
        start: Start,
        tell: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<Session, Error> {
        let source = start.scene.volume.clone();
        let step = source.step.unwrap_or(0);
        let step = if start.steps.is_empty() { 0 } else { step };
        let field = Field::new(start.loaded, source, step, 1);
        let state = State::new(
            Arc::new(field),
            start.scene,
            start.algorithm,
            start.settings,
        )?;
        let shared = Arc::new(Shared {
            inbox: Mutex::new(Inbox::new(Arc::new(state))),
            changed: Condvar::new(),
            renderers: Renderers::new(Context::new()),
            pace: Mutex::default(),
            measured: Mutex::default(),
            measurements: start.measurements,
            steps: start.steps,
            tell: Box::new(tell),
            pictures: AtomicU64::new(0),
            fields: AtomicU64::new(1),
            applying: Mutex::default(),
        });
        let mut session = Session {
            shared,
            threads: Vec::new(),
        };
        type Work = fn(&Shared);
        let works: [(&str, Work); 4] = [
            ("quick pictures", workers::quick),
            ("complete pictures", workers::complete),
            ("the truth", judge::work),
            ("loading", loader::work),
        ];
        for (name, work) in works {
            let shared = session.shared.clone();
            let thread = std::thread::Builder::new().name(name.into());
            let thread = thread.spawn(move || work(&shared)).map_err(|error| {
                Error::invalid(format!("a thread for {name} cannot be started: {error}"))
            })?;
            session.threads.push(thread);
        }
        Ok(session)
    }

    /// The newest state.
    pub fn state(&self) -> Arc<State> {
        self.shared.lock().state.clone()
    }

    /// The time steps, if there are several.
    pub fn steps(&self) -> &[Step] {
        &self.shared.steps
    }

    /// Does what a message of a client asks for.
    ///
    /// # Errors
    /// An invalid command, or one whose result is not drawn; the state is as it was.
    pub fn take(&self, client: u64, message: &Message) -> Result<(), Error> {
        let result = match &message.command {
            None => Ok(()),
            Some(command) => {
                let _one = self
                    .shared
                    .applying
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner);
                let state = self.state();
                match state.apply(command) {
                    Ok(Applied::State(next)) => {
                        self.shared
                            .replace(*next, Some((client, message.seq)), message.moving);
                        Ok(())
                    }
                    Ok(Applied::Load(wanted)) => {
                        self.shared.want(wanted, Some(client));
                        Ok(())
                    }
                    Err(error) => Err(error),
                }
            }
        };
        let mut inbox = self.shared.lock();
        // Questions do not say whether a hand moves; a message of nothing says that it rests.
        let asks = message.histogram.is_some() || message.difference.is_some() || message.estimate;
        if message.command.is_some() || !asks {
            inbox.moving = message.moving;
            inbox.touched = Instant::now();
        }
        if let Some(on) = message.difference {
            inbox.wants_difference = on;
            if !on {
                inbox.differed = 0;
                inbox.stop_judge();
            }
        }
        inbox.wants_estimate |= message.estimate;
        drop(inbox);
        self.shared.changed.notify_all();
        result
    }

    /// Says that a client has a picture on its screen, and how long that took from sending it.
    pub fn delivered(&self, size: [u32; 2], took: Duration) {
        self.shared.lock_pace().delivered(size, took);
    }

    /// Says that nobody's hand moves, as when a client is gone.
    pub fn rest(&self) {
        let (state, moved) = self.shared.update(|inbox| {
            let moved = std::mem::replace(&mut inbox.moving, false);
            (inbox.state.clone(), moved)
        });
        if moved {
            (self.shared.tell)(Event::State(state, None, false));
        }
    }

    /// The complete picture of the newest state, for which this waits.
    ///
    /// # Errors
    /// [`Error::Usage`] where it is not there in time, or cannot be drawn.
    pub(crate) fn complete(&self, patience: Duration) -> Result<Complete, Error> {
        let until = Instant::now() + patience;
        let mut inbox = self.shared.lock();
        inbox.moving = false;
        self.shared.changed.notify_all();
        loop {
            let version = inbox.state.version;
            if let Some(complete) = &inbox.complete
                && complete.state.version == version
            {
                return Ok(complete.clone());
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || inbox.is_closing || inbox.finished == version {
                return Err(Error::Usage {
                    what: "there is no complete picture of this view".into(),
                    help: Some("wait until it is drawn, or choose a faster algorithm".into()),
                });
            }
            inbox = self.shared.wait(inbox, left);
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let mut inbox = self.shared.lock();
        inbox.is_closing = true;
        inbox.stop_drawing();
        drop(inbox);
        self.shared.changed.notify_all();
        for thread in self.threads.drain(..) {
            // One that panicked has said so.
            let _ = thread.join();
        }
    }
}
