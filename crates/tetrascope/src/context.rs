//! The context in which algorithms are built: the graphics device, whom to tell of progress, who may stop.

use std::sync::Arc;
#[cfg(feature = "gpu")]
use std::sync::OnceLock;

#[cfg(feature = "gpu")]
use tetrascope_core::Error;
use tetrascope_core::Stop;
#[cfg(feature = "gpu")]
use tetrascope_gpu::{Gpu, GpuOptions};

/// Is told which share of a frame is done, increasing to 1, from any thread.
pub type Progress = Arc<dyn Fn(f64) + Send + Sync>;

/// Things that algorithms share: the graphics device, made when first needed. Clones share it, too.
#[derive(Clone, Default)]
pub struct Context {
    progress: Option<Progress>,
    stop: Stop,
    #[cfg(feature = "gpu")]
    gpu: Arc<OnceLock<Gpu>>,
}

impl Context {
    /// A context without a device so far.
    pub fn new() -> Context {
        Context::default()
    }

    /// The same context; algorithms that can tell their progress call `progress`.
    pub fn with_progress(mut self, progress: Progress) -> Context {
        self.progress = Some(progress);
        self
    }

    /// The same context; frames end early where `stop` asks: on the CPU soon, on a GPU before each of
    /// their submissions, of which most frames have one.
    pub fn with_stop(mut self, stop: Stop) -> Context {
        self.stop = stop;
        self
    }

    /// The same context with an application's device, on which algorithms then draw.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(mut self, gpu: Gpu) -> Context {
        self.gpu = Arc::new(gpu.into());
        self
    }

    /// The request that algorithms look at while they draw.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// Whom to tell of progress.
    pub fn progress(&self) -> Option<&Progress> {
        self.progress.as_ref()
    }

    /// The graphics device, made on the first call and kept.
    ///
    /// [`Error::NoAdapter`] where there is none; the next call looks again.
    #[cfg(feature = "gpu")]
    pub fn gpu(&self) -> Result<&Gpu, Error> {
        if let Some(gpu) = self.gpu.get() {
            return Ok(gpu);
        }
        let gpu = Gpu::new(&GpuOptions::default())?;
        Ok(self.gpu.get_or_init(|| gpu))
    }

    /// The adapter in words, if a device was made.
    pub fn adapter(&self) -> Option<String> {
        #[cfg(feature = "gpu")]
        return self.gpu.get().map(Gpu::describe);
        #[cfg(not(feature = "gpu"))]
        None
    }
}
