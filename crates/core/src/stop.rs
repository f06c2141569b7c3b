//! A request to stop drawing, for programs in which a newer picture may be wanted.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::Error;

/// Shared by who draws and who may want something else before it is done; from any thread.
///
/// A renderer that was given one looks at it many times in a frame and ends with
/// [`Error::Stopped`] once it is set. It stays as it was and can draw again.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// A request that was not made yet.
    pub fn new() -> Stop {
        Stop::default()
    }

    /// Asks to stop, until [`Stop::clear`].
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Takes the request back.
    pub fn clear(&self) {
        self.0.store(false, Ordering::Relaxed);
    }

    /// Whether to stop.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// An error if it is time to stop.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub fn check(&self) -> Result<(), Error> {
        match self.is_set() {
            true => Err(Error::Stopped),
            false => Ok(()),
        }
    }
}
