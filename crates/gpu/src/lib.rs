//! What two GPU renderers of Tetrascope share; nothing about any algorithm.
//!
//! Reading order: [`adapter`] finds a device and makes a [`Gpu`]; [`memory`]
//! makes buffers and textures that are checked against its limits, and reads
//! them back; [`device_grid`] is a regular grid that lives there; [`pipelines`] compiles
//! programs and [`passes`] makes bind groups; [`transfer_function`] and
//! [`preintegration`] take numbers of `tetrascope-f32` to the device; [`draw`] is the one way in
//! which renderers record frames, and [`canvas`] what theirs share; [`timer`] measures a frame
//! there; [`sort`] orders keys on it.
//!
//! # Failure
//! A missing adapter, a mesh too large for the device, an exhausted memory and a
//! lost device are each an [`Error`](tetrascope_core::Error). Whatever asks wgpu
//! for something that can fail goes through [`Gpu::checked`].
//!
//! # Headless Mesa
//! Only Vulkan, Metal and DirectX 12 are compiled in: wgpu's OpenGL backend prints
//! an EGL error on machines without a display. Mesa's device-select layer may still
//! print "XDG_RUNTIME_DIR is invalid or not set" while adapters are listed, because
//! wgpu asks for what a Wayland window would need; nothing fails. A program that
//! starts another with [`QUIET_MESA`] in its environment spares it the message.

pub mod adapter;
pub mod canvas;
pub mod device_grid;
pub mod draw;
pub mod gather;
pub mod memory;
pub mod passes;
pub mod pipelines;
pub mod preintegration;
pub mod sides;
pub mod sort;
pub mod timer;
pub mod transfer_function;

/// The environment variable, with its value, that switches off Mesa's device-select
/// layer, which looks for a Wayland session.
pub const QUIET_MESA: (&str, &str) = ("NODEVICE_SELECT", "1");

pub use adapter::{Gpu, GpuOptions, adapters, describe};
pub use canvas::{Canvas, Sums, SumsKind};
pub use device_grid::DeviceGrid;
pub use draw::{Commands, Draw, Outcome, Over, Recorded, SceneDepth, Target};
pub use memory::read_back;
pub use pipelines::{ComputeProgram, RenderProgram};
pub use preintegration::Integration;
pub use sort::RadixSort;
pub use timer::Timer;
pub use wgpu;

#[cfg(test)]
mod testing {
    use crate::{Gpu, GpuOptions};

    /// A device of this build of the crate; see `tetrascope_testing::gpu`.
    pub(crate) fn gpu(test: &str) -> Option<Gpu> {
        tetrascope_testing::or_skipped(test, Gpu::new(&GpuOptions::default()))
    }
}
