//! What two GPU renderers of Tetrascope share; nothing about any algorithm.
//!
//! Reading order: [`adapter`] finds a device and makes a [`Gpu`]; [`memory`]
//! makes buffers and textures that are checked against its limits, and reads
//! them back; [`normalization`] is the one place where numbers leave f64;
//! [`timer`] measures a frame on the device; [`sort`] orders keys on it.
//!
//! # Failure
//! A missing adapter, a mesh too large for the device, an exhausted memory and a
//! lost device are each an [`Error`](tetrascope_core::Error). Whatever asks wgpu
//! for something that can fail goes through [`Gpu::checked`].
//!
//! # Headless Mesa
//! Only Vulkan, Metal and DirectX 12 are compiled in: wgpu's OpenGL backend prints
//! an EGL error on machines without a display.

pub mod adapter;
pub mod memory;
pub mod normalization;
pub mod testing;
pub mod timer;

pub use adapter::{Gpu, GpuOptions, adapters, describe};
pub use memory::read_back;
pub use normalization::{Normalization, ScalarMap};
pub use timer::Timer;
pub use wgpu;
