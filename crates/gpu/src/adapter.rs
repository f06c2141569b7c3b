//! Which device draws: an adapter of this machine, or what the application has.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use tetrascope_core::{Error, Stop};
use wgpu::Features;

use crate::pipelines::Compiled;

/// The environment variable that chooses an adapter by a part of its name.
pub const ADAPTER_NAME_VARIABLE: &str = "WGPU_ADAPTER_NAME";

/// Features that some renderer makes use of; each is taken where it exists.
const USEFUL: Features = Features::FLOAT32_BLENDABLE
    .union(Features::FLOAT32_FILTERABLE)
    .union(Features::TEXTURE_FORMAT_16BIT_NORM)
    .union(Features::TIMESTAMP_QUERY)
    .union(Features::PIPELINE_STATISTICS_QUERY);

/// How to choose a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuOptions {
    /// A part of the adapter's name, in any case; `None` takes the fastest kind.
    pub adapter_name: Option<String>,
    /// Whether a software adapter such as llvmpipe will do.
    pub allow_software: bool,
}

impl Default for GpuOptions {
    /// The adapter that `WGPU_ADAPTER_NAME` names; software allowed.
    fn default() -> Self {
        GpuOptions {
            adapter_name: std::env::var(ADAPTER_NAME_VARIABLE)
                .ok()
                .filter(|name| !name.is_empty()),
            allow_software: true,
        }
    }
}

/// A device, its queue and what it can do. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Gpu {
    shared: Arc<Shared>,
    stop: Stop,
}

#[derive(Debug)]
struct Shared {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    limits: wgpu::Limits,
    features: Features,
    failure: Failure,
    /// Whether `sides.wgsl` has to compare integers, once that is known.
    integer_sides: OnceLock<bool>,
    compiled: Mutex<Compiled>,
    /// Buffers and textures that were made.
    allocations: AtomicU64,
    /// How many checks come before one that a test has fail; none if negative.
    checks_left: AtomicI64,
    /// Whether the device is then destroyed.
    destroys: AtomicBool,
}

/// The first thing that went wrong outside of [`Gpu::checked`], in the driver's words.
type Failure = Arc<Mutex<Option<String>>>;

/// The adapters of this machine, fastest kind first.
pub fn adapters() -> Vec<wgpu::AdapterInfo> {
    let found = enumerate();
    found.iter().map(wgpu::Adapter::get_info).collect()
}

/// An adapter in one line: name, type, backend and driver.
pub fn describe(info: &wgpu::AdapterInfo) -> String {
    let kind = match info.device_type {
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Other => "other",
    };
    let driver = format!("{} {}", info.driver, info.driver_info);
    let name = &info.name;
    let backend = info.backend.to_str();
    format!("{name} ({kind}, {backend}, {})", driver.trim())
}

impl Gpu {
    /// A device of this machine.
    ///
    /// [`Error::NoAdapter`] if there is none like that.
    pub fn new(options: &GpuOptions) -> Result<Gpu, Error> {
        Gpu::with_limits(options, |_| {})
    }

    /// A device whose limits `lower` has lowered. For tests of what does not fit.
    #[doc(hidden)]
    pub fn with_limits(
        options: &GpuOptions,
        lower: impl FnOnce(&mut wgpu::Limits),
    ) -> Result<Gpu, Error> {
        let adapter = choose(enumerate(), options)?;
        // The defaults of WebGPU stop at 128 MiB a binding even on large devices.
        let mut limits = adapter.limits();
        lower(&mut limits);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("tetrascope"),
            required_features: Gpu::useful_features(&adapter),
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
                Error::Device {
                    reason: format!("{} gives no device: {error}", adapter.get_info().name),
                }
            })?;
        Ok(Gpu::watched(device, queue))
    }

    /// A device that belongs to nobody else: what happens to it is noted.
    fn watched(device: wgpu::Device, queue: wgpu::Queue) -> Gpu {
        let failure = Failure::default();
        let note = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error| first(&note, error.to_string())));
        let note = failure.clone();
        device.set_device_lost_callback(move |reason, message| {
            let what = match reason {
                wgpu::DeviceLostReason::Destroyed => "it was destroyed".into(),
                _ => format!("device lost: {message}"),
            };
            first(&note, what);
        });
        Gpu::with_failure(device, queue, failure)
    }

    /// The features of `adapter` that some renderer makes use of: an application asks for them,
    /// and for what it needs itself, when it makes a device for [`Gpu::from_device`].
    pub fn useful_features(adapter: &wgpu::Adapter) -> Features {
        USEFUL & adapter.features()
    }

    /// An application's own device and queue.
    ///
    /// The application's handlers for lost devices and uncaptured errors are left
    /// alone, so that a device is found to be lost once a frame is read back, not before. Renderers use the features and limits that the device was made with. Among
    /// [`Gpu::useful_features`], [`Features::FLOAT32_BLENDABLE`] keeps blending in f32,
    /// [`Features::FLOAT32_FILTERABLE`] and [`Features::TEXTURE_FORMAT_16BIT_NORM`] let
    /// texture units filter the samples of a grid, and [`Features::TIMESTAMP_QUERY`] and
    /// [`Features::PIPELINE_STATISTICS_QUERY`] measure frames. With the adapter's own limits
    /// a mesh may be larger than with WebGPU's defaults.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Gpu {
        Gpu::with_failure(device, queue, Failure::default())
    }

    fn with_failure(device: wgpu::Device, queue: wgpu::Queue, failure: Failure) -> Gpu {
        Gpu {
            stop: Stop::new(),
            shared: Arc::new(Shared {
                info: device.adapter_info(),
                limits: device.limits(),
                features: device.features(),
                device,
                queue,
                failure,
                integer_sides: OnceLock::new(),
                compiled: Mutex::default(),
                allocations: AtomicU64::new(0),
                checks_left: AtomicI64::new(-1),
                destroys: AtomicBool::new(false),
            }),
        }
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.shared.device
    }

    /// The device's queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// The adapter behind the device.
    pub fn info(&self) -> &wgpu::AdapterInfo {
        &self.shared.info
    }

    /// Whether the adapter computes on the CPU.
    pub fn is_software(&self) -> bool {
        self.info().device_type == wgpu::DeviceType::Cpu
    }

    /// The limits that the device was made with.
    pub fn limits(&self) -> &wgpu::Limits {
        &self.shared.limits
    }

    /// The features that the device was made with.
    pub fn features(&self) -> Features {
        self.shared.features
    }

    /// How many buffers and textures were made on this device by way of this and its clones.
    pub fn allocations(&self) -> u64 {
        self.shared.allocations.load(Ordering::Relaxed)
    }

    /// Counts a buffer or a texture that is being made.
    pub(crate) fn count_allocation(&self) {
        self.shared.allocations.fetch_add(1, Ordering::Relaxed);
    }

    /// The answer of `sides` about the device.
    pub(crate) fn integer_sides(&self) -> &OnceLock<bool> {
        &self.shared.integer_sides
    }

    /// The programs that were compiled on the device.
    pub(crate) fn compiled(&self) -> &Mutex<Compiled> {
        &self.shared.compiled
    }

    /// Lets so many calls of [`Gpu::checked`] pass and refuses the one after, once; `None` refuses
    /// none. For tests of what a failure leaves behind.
    #[doc(hidden)]
    pub fn refuse_after(&self, checks: Option<u32>) {
        let checks = checks.map_or(-1, i64::from);
        self.shared.destroys.store(false, Ordering::SeqCst);
        self.shared.checks_left.store(checks, Ordering::SeqCst);
    }

    /// Lets so many calls of [`Gpu::checked`] pass and destroys the device before the one after.
    /// For tests of devices that are lost in the middle of a frame.
    #[doc(hidden)]
    pub fn destroy_after(&self, checks: u32) {
        self.shared.destroys.store(true, Ordering::SeqCst);
        self.shared
            .checks_left
            .store(checks.into(), Ordering::SeqCst);
    }

    /// How many calls of [`Gpu::checked`] [`Gpu::refuse_after`] and [`Gpu::destroy_after`] still
    /// let pass; negative once one has failed.
    #[doc(hidden)]
    pub fn checks_left(&self) -> i64 {
        self.shared.checks_left.load(Ordering::SeqCst)
    }

    /// The adapter in one line: name, type, backend and driver.
    pub fn describe(&self) -> String {
        describe(self.info())
    }

    /// Runs `work`, and returns what wgpu refused in it as an error.
    ///
    /// `what` and `bytes` name what is being made, for [`Error::OutOfMemory`].
    pub fn checked<T>(&self, what: &str, bytes: u64, work: impl FnOnce() -> T) -> Result<T, Error> {
        self.healthy()?;
        let left = &self.shared.checks_left;
        if left.load(Ordering::SeqCst) >= 0 && left.fetch_sub(1, Ordering::SeqCst) == 0 {
            match self.shared.destroys.load(Ordering::SeqCst) {
                true => self.device().destroy(),
                false => {
                    return Err(Error::OutOfMemory {
                        what: what.into(),
                        bytes,
                    });
                }
            }
        }
        let scope = |filter| self.device().push_error_scope(filter);
        let memory = scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = scope(wgpu::ErrorFilter::Internal);
        let validation = scope(wgpu::ErrorFilter::Validation);
        let result = work();
        // All three are popped before any is looked at: they nest.
        let refused = [validation, internal, memory].map(|s| pollster::block_on(s.pop()));
        match refused.into_iter().flatten().next() {
            None => {
                self.healthy()?;
                Ok(result)
            }
            Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory {
                what: what.into(),
                bytes,
            }),
            Some(error) => Err(Error::Device {
                reason: format!("{what}: {}", one_line(&error.to_string())),
            }),
        }
    }

    /// The same device; a frame of a renderer that is built with this ends early with
    /// [`Error::Stopped`] where `stop` asks for it, before each of the frame's submissions. One that
    /// was submitted is not taken back: most frames are one.
    pub fn with_stop(&self, stop: Stop) -> Gpu {
        Gpu {
            stop,
            ..self.clone()
        }
    }

    /// The request that ends frames early.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// An error if the device was lost or refused something.
    pub fn healthy(&self) -> Result<(), Error> {
        let failure = self.shared.failure.lock();
        match &*failure.unwrap_or_else(PoisonError::into_inner) {
            None => Ok(()),
            Some(reason) => Err(Error::Device {
                reason: one_line(reason),
            }),
        }
    }

    /// Submits `commands` and waits until the device has done them.
    pub fn finish(&self, commands: wgpu::CommandEncoder) -> Result<(), Error> {
        self.checked("the frame's commands", 0, || {
            self.queue().submit([commands.finish()]);
        })?;
        self.wait()
    }

    /// Waits until the device has done all that was submitted.
    pub fn wait(&self) -> Result<(), Error> {
        // wgpu panics when the device is lost while it waits (wgpu 30, `CoreDevice::poll`).
        let poll = || self.device().poll(wgpu::PollType::wait_indefinitely());
        let waited = std::panic::catch_unwind(std::panic::AssertUnwindSafe(poll));
        self.healthy()?;
        match waited {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(Error::Device {
                reason: error.to_string(),
            }),
            Err(_) => Err(Error::Device {
                reason: "the device was lost while drawing".into(),
            }),
        }
    }
}

fn first(failure: &Failure, reason: String) {
    let mut failure = failure.lock().unwrap_or_else(PoisonError::into_inner);
    failure.get_or_insert(reason);
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::from_env().unwrap_or(backends) & backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    });
    let mut found = pollster::block_on(instance.enumerate_adapters(backends));
    // Stable, so the driver's own order decides within a kind.
    found.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    found
}

fn choose(found: Vec<wgpu::Adapter>, options: &GpuOptions) -> Result<wgpu::Adapter, Error> {
    let names: Vec<String> = found.iter().map(|a| a.get_info().name).collect();
    let fits = |adapter: &wgpu::Adapter| {
        let info = adapter.get_info();
        let named = options.adapter_name.as_ref().is_none_or(|part| {
            let name = info.name.to_lowercase();
            name.contains(&part.to_lowercase())
        });
        named && (options.allow_software || info.device_type != wgpu::DeviceType::Cpu)
    };
    let chosen = found.into_iter().find(fits);
    chosen.ok_or_else(|| no_adapter(&names, options))
}

fn no_adapter(names: &[String], options: &GpuOptions) -> Error {
    let wanted = match (&options.adapter_name, options.allow_software) {
        (Some(name), _) => format!("none is called '{name}'"),
        (None, false) => "software adapters were excluded".into(),
        (None, true) => "this machine has no Vulkan, Metal or DirectX 12 driver".into(),
    };
    if names.is_empty() {
        Error::NoAdapter {
            reason: "this machine has no Vulkan, Metal or DirectX 12 driver".into(),
            help: Some(
                "`apt-get install mesa-vulkan-drivers libvulkan1` gives a software one on \
                 Debian and Ubuntu, and `cargo xtask setup` does that"
                    .into(),
            ),
        }
    } else {
        Error::NoAdapter {
            reason: format!("{wanted}; there are {}", names.join(", ")),
            help: Some(format!(
                "set {ADAPTER_NAME_VARIABLE} to a part of one of those names, or unset it"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_adapter_says_what_to_type() {
        let error = choose(Vec::new(), &GpuOptions::default()).expect_err("there are none");
        let help = error.help().expect("a command to type");
        assert!(help.contains("apt-get install mesa-vulkan-drivers libvulkan1"));
        assert_eq!(error.kind(), tetrascope_core::ErrorKind::Gpu);
    }

    #[test]
    fn a_wrong_adapter_name_lists_the_right_ones() {
        let options = GpuOptions {
            adapter_name: Some("no such adapter".into()),
            allow_software: true,
        };
        let error = no_adapter(&["llvmpipe".into()], &options).to_string();
        assert!(error.contains("no such adapter") && error.contains("llvmpipe"));
    }
}
