//! Work that takes time: other threads of Python run meanwhile, and Ctrl-C interrupts it.

use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use tetrascope::core::{Error, Stop};

use crate::errors::{exception, fault};

/// Python is asked for signals so often.
const PATIENCE: Duration = Duration::from_millis(50);

/// Work that somebody waits for, and the threads that do it.
#[derive(Clone)]
struct Task {
    caller: Arc<Mutex<Caller>>,
    pool: Arc<ThreadPool>,
}

/// The state of a call.
enum Caller {
    /// It waits for its work, which this ends early, once it has begun.
    Waits(Option<Stop>),
    /// It was interrupted.
    IsGone,
}

/// The threads that work now. Those of an interrupted call go on with that alone, and others take
/// their place: work of later calls would wait behind it.
static POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

impl Task {
    fn new() -> Result<Task, Error> {
        let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
        let pool = match &*pool {
            Some(pool) => pool.clone(),
            None => {
                let made = ThreadPoolBuilder::new()
                    .build()
                    .map_err(|error| Error::invalid(format!("cannot start threads: {error}")))?;
                pool.insert(Arc::new(made)).clone()
            }
        };
        Ok(Task {
            caller: Arc::new(Mutex::new(Caller::Waits(None))),
            pool,
        })
    }

    fn caller(&self) -> MutexGuard<'_, Caller> {
        self.caller.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says that work has begun which `stop` ends, or with `None` that it is done.
    ///
    /// # Errors
    /// [`Error::Stopped`] if nobody waits for it.
    fn stops_by(&self, stop: Option<&Stop>) -> Result<(), Error> {
        let mut caller = self.caller();
        if let Caller::IsGone = *caller {
            return Err(Error::Stopped);
        }
        // An earlier call may have been ended by the same.
        stop.inspect(|stop| stop.clear());
        *caller = Caller::Waits(stop.cloned());
        Ok(())
    }

    /// Nobody waits any more.
    fn abandon(&self) {
        if let Caller::Waits(Some(stop)) = std::mem::replace(&mut *self.caller(), Caller::IsGone) {
            stop.set();
        }
        let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
        pool.take_if(|pool| Arc::ptr_eq(pool, &self.pool));
    }
}

/// News from a thread that works.
enum News<T> {
    Line(String),
    Done(Result<T, Error>),
}

/// Does `work` on a thread of its own, without Python's lock.
///
/// Ctrl-C raises `KeyboardInterrupt` within a twentieth of a second. The work then goes on to
/// its end, on its thread, and its result is dropped. A panic becomes `RuntimeError`.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    wait_for(py, |_| Ok(()), |task, _| task.pool.install(work))
}

/// As [`run`], for work that tells lines, which `say` is called with in Python's thread.
pub(crate) fn run_telling<T: Send + 'static>(
    py: Python<'_>,
    say: impl Fn(String) -> PyResult<()>,
    work: impl FnOnce(&(dyn Fn(&str) + Sync)) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    wait_for(py, say, |task, sender| {
        // Lines come from any of the threads, a sender is for one at a time.
        let sender = Mutex::new(sender);
        let tell = |line: &str| {
            let sender = sender.lock().unwrap_or_else(PoisonError::into_inner);
            _ = sender.send(News::Line(line.into()));
        };
        task.pool.install(|| work(&tell))
    })
}

/// As [`run`], on something that is for one call at a time. The work of an interrupted call ends
/// early where it looks at `stop`; another call on the same waits until then.
pub(crate) fn run_on<S: Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    shared: &Arc<Mutex<S>>,
    stop: &Stop,
    work: impl FnOnce(&mut S) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let (shared, stop) = (shared.clone(), stop.clone());
    wait_for(
        py,
        |_| Ok(()),
        move |task, _| {
            // Not in the pool: who waits there may be asked to help the one that it waits for. A panic
            // has not left a renderer half changed, as it keeps what it had.
            let mut guard = shared.lock().unwrap_or_else(PoisonError::into_inner);
            task.stops_by(Some(&stop))?;
            let shared = &mut *guard;
            let result = task.pool.install(|| work(shared));
            // Whoever comes next is not to be stopped by this call's interrupt.
            task.stops_by(None)?;
            result
        },
    )
}

fn wait_for<T: Send + 'static>(
    py: Python<'_>,
    say: impl Fn(String) -> PyResult<()>,
    work: impl FnOnce(&Task, Sender<News<T>>) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    check_process().map_err(|error| exception(py, &error))?;
    let (sender, mut receiver) = channel();
    let started = Task::new().and_then(|task| Ok((start(task.clone(), sender, work)?, task)));
    let (thread, task) = started.map_err(|error| exception(py, &error))?;
    loop {
        let news;
        (receiver, news) = py.detach(move || wait(receiver));
        let heard = match news {
            Ok(News::Done(result)) => return result.map_err(|error| exception(py, &error)),
            Ok(News::Line(line)) => say(line),
            Err(RecvTimeoutError::Timeout) => py.check_signals(),
            // It ended without a result.
            Err(RecvTimeoutError::Disconnected) => {
                let ended = py.detach(move || thread.join());
                let payload = ended.err().unwrap_or_else(|| Box::new("it ended early"));
                return Err(fault(&*payload));
            }
        };
        if let Err(interrupt) = heard {
            task.abandon();
            return Err(interrupt);
        }
    }
}

/// A receiver is for one thread at a time: it goes in and comes out.
fn wait<T>(receiver: Receiver<T>) -> (Receiver<T>, Result<T, RecvTimeoutError>) {
    let news = receiver.recv_timeout(PATIENCE);
    (receiver, news)
}

fn start<T: Send + 'static>(
    task: Task,
    sender: Sender<News<T>>,
    work: impl FnOnce(&Task, Sender<News<T>>) -> Result<T, Error> + Send + 'static,
) -> Result<JoinHandle<()>, Error> {
    let body = move || {
        let result = work(&task, sender.clone());
        // Nobody may wait for it any more.
        _ = sender.send(News::Done(result));
    };
    let started = Builder::new().name("tetrascope".into()).spawn(body);
    started.map_err(|error| Error::invalid(format!("cannot start a thread: {error}")))
}

/// Refuses to wait for threads that a fork has left behind: it would be forever.
fn check_process() -> Result<(), Error> {
    static PROCESS: AtomicU32 = AtomicU32::new(0);
    let this = process::id();
    match PROCESS.compare_exchange(0, this, Ordering::Relaxed, Ordering::Relaxed) {
        Err(first) if first != this => Err(Error::Invalid {
            what: "this process was forked from one in which tetrascope was at work, and its \
                   threads are not here"
                .into(),
            help: Some("start processes by 'spawn' or 'forkserver'".into()),
        }),
        _ => Ok(()),
    }
}
