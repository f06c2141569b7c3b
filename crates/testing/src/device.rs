//! The device that tests draw with.

use tetrascope_gpu::{Gpu, GpuOptions};

use crate::or_skipped;

/// A device, or `None` after saying that `test` is skipped; see [`or_skipped`].
pub fn gpu(test: &str) -> Option<Gpu> {
    let gpu = or_skipped(test, Gpu::new(&GpuOptions::default()))?;
    eprintln!("{test}: drawn by {}", gpu.describe());
    Some(gpu)
}
