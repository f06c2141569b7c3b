//! The device that tests draw with, and an application that has drawn before them.

mod application;

pub use application::Application;

use tetrascope_core::Error;

use crate::{Gpu, GpuOptions};

/// A device, or `None` after saying on stderr that `test` is skipped.
///
/// # Panics
/// If there is no adapter although the environment variable `CI` is set, or if the
/// adapter gives no device.
pub fn gpu(test: &str) -> Option<Gpu> {
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => {
            eprintln!("{test}: drawn by {}", gpu.describe());
            Some(gpu)
        }
        Err(error @ Error::NoAdapter { .. }) if std::env::var_os("CI").is_none() => {
            eprintln!("{test}: skipped: {error}");
            None
        }
        Err(error) => panic!("{test}: {error}"),
    }
}
