//! Tools that two or more GPU renderers of Tetrascope share; nothing about any algorithm.
//!
//! Reading order: [`adapter`] finds a device and makes a [`Gpu`]; [`memory`]
//! makes buffers and textures that are checked against its limits, and reads
//! them back; [`device_grid`] is a regular grid that lives there; [`pipelines`] compiles
//! programs and [`passes`] makes bind groups; [`transfer_function`] and
//! [`preintegration`] take numbers of `tetrascope-f32` to the device; [`draw`] is the one way in
//! which renderers record frames, and [`canvas`] what theirs share; [`timer`] measures a frame
//! there; [`sort`] orders keys on it; [`tables`] hold a mesh that changes, and [`columns`] share out
//! its cells among invocations.
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
//!
//! # In an application's own device
//! ```no_run
//! use tetrascope_core::glam::{DMat3, DVec3};
//! use tetrascope_core::grid::Samples;
//! use tetrascope_core::{Error, Grid};
//! use tetrascope_gpu::memory::{Source, read_back};
//! use tetrascope_gpu::wgpu::{self, BufferUsages};
//! use tetrascope_gpu::{DeviceGrid, Gpu};
//!
//! /// An application's device, with the features and limits that renderers make use of.
//! async fn device(adapter: &wgpu::Adapter) -> Result<Gpu, wgpu::RequestDeviceError> {
//!     let descriptor = wgpu::DeviceDescriptor {
//!         required_features: Gpu::useful_features(adapter),
//!         required_limits: adapter.limits(),
//!         ..Default::default()
//!     };
//!     let (device, queue) = adapter.request_device(&descriptor).await?;
//!     Ok(Gpu::from_device(device, queue))
//! }
//!
//! /// Uploads and reads back: whatever the device refuses is an error, not a panic.
//! fn round_trip(gpu: &Gpu) -> Result<(), Error> {
//!     println!("on {}", gpu.describe());
//!     let buffer = gpu.upload("numbers", &[1.0_f32, 2.0, 3.0], BufferUsages::COPY_SRC)?;
//!     let mut encoder = gpu.device().create_command_encoder(&Default::default());
//!     let copy = read_back(gpu, &mut encoder, Source::Buffer(&buffer, 12))?;
//!     gpu.finish(encoder)?;
//!     assert_eq!(copy.read::<f32>()?, [1.0, 2.0, 3.0]);
//!
//!     // A grid of 2×2×2 samples in a texture, for `slicing` to draw.
//!     let samples = Samples::F32(vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
//!     let (origin, spacing) = (DVec3::ZERO, DVec3::ONE);
//!     let grid = Grid::new([2; 3], origin, spacing, DMat3::IDENTITY, samples)?;
//!     assert_eq!(DeviceGrid::upload(gpu, &grid)?.bytes(), 32);
//!     Ok(())
//! }
//! ```

pub mod adapter;
pub mod canvas;
pub mod columns;
pub mod device_grid;
pub mod draw;
pub mod gather;
pub mod memory;
pub mod passes;
pub mod pipelines;
pub mod preintegration;
pub mod sides;
pub mod sort;
pub mod tables;
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
