//! Frames that fail: on a device that is lost in the middle of one, or refuses a step of it, or has
//! low limits. Each is an error in words, and the next frame, on that device or another, is drawn.

use std::sync::mpsc;
use std::time::Duration;

use tetrascope::core::{CameraFit, Error, OpticalModel, Volume, VolumeRenderer as _};
use tetrascope::gpu::{ComputeProgram, Gpu, GpuOptions, wgpu};
use tetrascope::{Algorithm, Context, Settings};
use tetrascope_testing::{ImageError, fitted, say};
use xtask::testing::{Failures, algorithms};

use super::{SIDE, for_each, look, same, series, ways};

/// How long a frame of some pixels may take before it counts as hanging.
const HANGS: Duration = Duration::from_secs(60);

/// Does `work` in a thread, and fails if that hangs or panics.
fn within_patience<T: Send + 'static>(what: &str, work: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, waiting) = mpsc::channel();
    std::thread::spawn(move || {
        // The receiver waits for it.
        let _ = done.send(work());
    });
    let answer = waiting.recv_timeout(HANGS);
    answer.unwrap_or_else(|error| panic!("{what} hangs or panics: {error}"))
}

/// When a device is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    FirstStep,
    MiddleStep,
    LastStep,
    BetweenFrames,
    /// An application's device, of which nobody has told that it is lost.
    Applications,
}

const WHEN: [When; 5] = [
    When::FirstStep,
    When::MiddleStep,
    When::LastStep,
    When::BetweenFrames,
    When::Applications,
];

/// The scene of an algorithm's frames: the mesh or the grid, whatever it draws.
fn scene(algorithm: &Algorithm, settings: &Settings) -> Option<[Volume; 3]> {
    series().into_iter().find(|volumes| {
        let volume = &volumes[0];
        let view = fitted(volume, CameraFit::PlusZ, true, SIDE);
        let look = look(volume, OpticalModel::EmissionAbsorption, 3, 1.0);
        (algorithm.supports)(volume, &look, &view, settings).is_ok()
    })
}

/// An error of a lost device, in a line of words.
fn is_told(done: Result<impl Sized, Error>, what: &str) -> Result<(), String> {
    match done {
        Ok(_) => Err(format!("{what} in spite of a lost device")),
        Err(Error::Device { reason }) if !reason.is_empty() && !reason.contains('\n') => Ok(()),
        Err(other) => Err(format!("{what}: {other:?}")),
    }
}

/// Loses the device of a renderer, and draws on another. What is wrong, in words.
fn lose(algorithm: &Algorithm, settings: &Settings, when: When) -> Result<(), String> {
    let Some([volume, _, other]) = scene(algorithm, settings) else {
        return Ok(());
    };
    let style = look(&volume, OpticalModel::EmissionAbsorption, 3, 1.0);
    let view = fitted(&volume, CameraFit::PlusZ, true, SIDE);
    let build = |context: &Context| (algorithm.build)(context, &volume, &style, settings);
    let watched = Gpu::new(&GpuOptions::default()).expect("there is an adapter");
    let gpu = match when {
        When::Applications => Gpu::from_device(watched.device().clone(), watched.queue().clone()),
        _ => watched,
    };
    let context = Context::new().with_gpu(gpu.clone());
    let mut renderer = build(&context).expect("a renderer");
    let expected = renderer.render(&view).expect("a frame");
    let steps = checks(&gpu, || drop(renderer.render(&view).expect("a frame")));
    match when {
        When::FirstStep => gpu.destroy_after(0),
        When::MiddleStep => gpu.destroy_after(steps / 2),
        When::LastStep => gpu.destroy_after(steps - 1),
        When::BetweenFrames | When::Applications => gpu.device().destroy(),
    }
    is_told(renderer.render(&view), "a frame")?;
    is_told(renderer.render(&view), "the next frame")?;
    let built = build(&context).and_then(|renderer| renderer.render(&view));
    is_told(built, "a renderer and its frame")?;
    // These may put off what is to do until a frame, but not panic.
    let _ = renderer.reload(&other);
    let _ = renderer.restyle(&look(&volume, OpticalModel::EmissionAbsorption, 9, 4.0));
    is_told(renderer.render(&view), "a frame in the end")?;
    let again = build(&Context::new()).and_then(|renderer| renderer.render(&view));
    match same(&again.expect("a device"), &expected) {
        true => Ok(()),
        false => Err("another device draws another picture".into()),
    }
}

/// How many checks `work` makes.
fn checks(gpu: &Gpu, work: impl FnOnce()) -> u32 {
    const MANY: u32 = 1 << 20;
    gpu.refuse_after(Some(MANY));
    work();
    let left = gpu.checks_left();
    gpu.refuse_after(None);
    u32::try_from(i64::from(MANY) - left).expect("fewer")
}

#[test]
fn a_device_that_is_lost_in_a_frame_is_an_error_and_another_draws() {
    let test = "a_device_that_is_lost_in_a_frame_is_an_error_and_another_draws";
    let mut failures = Failures::default();
    for algorithm in algorithms(test).into_iter().filter(|a| a.needs_gpu) {
        // Some of its settings, and each moment at least once.
        let drawn = ways(algorithm).into_iter();
        let drawn: Vec<_> = drawn
            .filter(|way| scene(algorithm, way).is_some())
            .collect();
        let apart = drawn.len().div_ceil(6);
        let chosen: Vec<_> = drawn.into_iter().step_by(apart).collect();
        for i in 0..chosen.len().max(WHEN.len()) {
            let settings = chosen[i % chosen.len()].clone();
            let when = WHEN[i % WHEN.len()];
            let what = format!("{} {settings}, {when:?}", algorithm.name);
            let done = within_patience(&what, move || lose(algorithm, &settings, when));
            if let Err(why) = done {
                failures.push(format!("{what}: {why}"));
            }
        }
    }
    failures.finish();
}

/// Each step of making a renderer and of a frame is refused in turn; the next frame is drawn.
#[test]
fn a_frame_that_fails_is_drawn_the_next_time() {
    let mut failures = Failures::default();
    let test = "a_frame_that_fails_is_drawn_the_next_time";
    let mut count = 0;
    for_each(test, |gpu, case, model, [volume, ..]| {
        if model != OpticalModel::EmissionAbsorption {
            return;
        }
        let look = look(volume, model, 3, 1.0);
        let what = format!(
            "{} {}, {}",
            case.algorithm.name,
            case.settings,
            model.name()
        );
        let build = || (case.algorithm.build)(case.context, volume, &look, &case.settings);
        let expected = case
            .build(volume, &look)
            .render(&case.view)
            .expect("a frame");
        // Pipelines are there by now, so these are the steps of what is uploaded and recorded.
        for step in 0.. {
            gpu.refuse_after(Some(step));
            let made = build();
            gpu.refuse_after(None);
            match made {
                Ok(_) => break,
                Err(Error::OutOfMemory { .. }) => count += 1,
                Err(error) => failures.push(format!("{what}: made, {step}: {error}")),
            }
        }
        let renderer = case.build(volume, &look);
        for step in 0.. {
            gpu.refuse_after(Some(step));
            let frame = renderer.render(&case.view);
            gpu.refuse_after(None);
            match frame {
                Ok(_) => break,
                Err(Error::OutOfMemory { .. }) => count += 1,
                Err(error) => failures.push(format!("{what}: a frame, {step}: {error}")),
            }
            if !same(&renderer.render(&case.view).expect("a frame"), &expected) {
                failures.push(format!("{what}: not drawn again after step {step}"));
            }
        }
    });
    eprintln!("{count} steps refused");
    failures.finish();
}

/// Limits in which devices differ, and whether each is a size.
type Lower = (&'static str, fn(&mut wgpu::Limits), bool);

const LOWER: [Lower; 12] = [
    (
        "buffers of 1 kB",
        |l| {
            l.max_buffer_size = 1 << 10;
            l.max_storage_buffer_binding_size = 1 << 10;
            l.max_uniform_buffer_binding_size = 1 << 10;
        },
        true,
    ),
    (
        "bindings of 512 bytes",
        |l| l.max_storage_buffer_binding_size = 512,
        true,
    ),
    (
        "uniforms of 16 bytes",
        |l| l.max_uniform_buffer_binding_size = 16,
        true,
    ),
    (
        "images of 4 pixels",
        |l| {
            l.max_texture_dimension_1d = 4;
            l.max_texture_dimension_2d = 4;
        },
        true,
    ),
    (
        "volumes of 2 texels",
        |l| l.max_texture_dimension_3d = 2,
        true,
    ),
    ("2 layers", |l| l.max_texture_array_layers = 2, true),
    ("1 bind group", |l| l.max_bind_groups = 1, false),
    (
        "1 storage buffer",
        |l| l.max_storage_buffers_per_shader_stage = 1,
        false,
    ),
    (
        "no storage texture",
        |l| l.max_storage_textures_per_shader_stage = 0,
        false,
    ),
    (
        "1 texture",
        |l| l.max_sampled_textures_per_shader_stage = 1,
        false,
    ),
    (
        "workgroups of 8",
        |l| {
            l.max_compute_invocations_per_workgroup = 8;
            l.max_compute_workgroup_size_x = 8;
            l.max_compute_workgroup_size_y = 8;
            l.max_compute_workgroup_size_z = 8;
        },
        false,
    ),
    (
        "1 workgroup a side",
        |l| l.max_compute_workgroups_per_dimension = 1,
        false,
    ),
];

/// A renderer on a device that has less draws the same picture, or says what it lacks: of a size,
/// how much there is and how much is needed; of anything that WebGPU has everywhere, in wgpu's words.
#[test]
fn a_device_of_low_limits_draws_or_says_what_it_lacks() {
    let test = "a_device_of_low_limits_draws_or_says_what_it_lacks";
    let mut failures = Failures::default();
    let whole = Context::new();
    let (mut drawn, mut sizes, mut others) = (0, 0, 0);
    for algorithm in algorithms(test).into_iter().filter(|a| a.needs_gpu) {
        let ways = ways(algorithm);
        for (i, (limit, lower, is_size)) in LOWER.into_iter().enumerate() {
            let gpu = Gpu::with_limits(&GpuOptions::default(), lower).expect("less than it has");
            let low = Context::new().with_gpu(gpu.clone());
            for settings in [&ways[0], &ways[1 + i % (ways.len() - 1)]] {
                let Some([volume, ..]) = scene(algorithm, settings) else {
                    continue;
                };
                let look = look(&volume, OpticalModel::EmissionAbsorption, 3, 1.0);
                let view = fitted(&volume, CameraFit::PlusZ, true, SIDE);
                let draw = |context: &Context| {
                    let renderer = (algorithm.build)(context, &volume, &look, settings)?;
                    renderer.render(&view)
                };
                let what = format!("{} {settings}, {limit}", algorithm.name);
                match draw(&low) {
                    Ok(frame) => {
                        drawn += 1;
                        let apart = ImageError::between(&draw(&whole).expect("a frame"), &frame);
                        if !apart.within(3e-6, 1e-4) {
                            failures.push(format!("{what}: another picture: {apart:?}"));
                        }
                    }
                    Err(Error::TooLarge { needed, limit, .. }) if needed > limit => sizes += 1,
                    Err(Error::Device { reason }) if !is_size && !reason.contains('\n') => {
                        others += 1;
                    }
                    Err(error) => failures.push(format!("{what}: {error}")),
                }
                if let Err(error) = gpu.healthy() {
                    failures.push(format!("{what}: the device failed: {error}"));
                }
            }
        }
    }
    eprintln!("{drawn} drawn, {sizes} too large, {others} refused");
    failures.finish();
}

/// In a process of its own, whose address space is limited: a software adapter's memory is the
/// process's.
#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_exhausted_is_an_error_and_the_device_goes_on() {
    let test = "memory_that_is_exhausted_is_an_error_and_the_device_goes_on";
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) if gpu.is_software() => {}
        other => {
            let why = other.map_or_else(|error| error.to_string(), |gpu| gpu.describe());
            say(&format!("skipped: {test} on a software adapter: {why}"));
            return;
        }
    }
    let program = std::env::current_exe().expect("this one");
    let run = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh"])
        .arg(program)
        .args([
            "--exact",
            "faults::little_memory",
            "--ignored",
            "--nocapture",
        ])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    let more = String::from_utf8_lossy(&run.stderr);
    assert!(
        run.status.success() && said.contains("1 passed"),
        "{said}{more}"
    );
}

#[test]
#[ignore = "another test runs it with little memory"]
fn little_memory() {
    let gpu = Gpu::new(&GpuOptions::default()).expect("there is an adapter");
    // Half of what SwiftShader says that it makes: it never has room for all of that.
    let size = 1 << 29;
    let mut buffers = Vec::new();
    // More than the address space holds.
    let error = (0..1000).find_map(|_| {
        let made = gpu.buffer("of many", size, wgpu::BufferUsages::COPY_DST);
        made.map(|buffer| buffers.push(buffer)).err()
    });
    match error {
        Some(Error::OutOfMemory { what, bytes }) => assert_eq!((&*what, bytes), ("of many", size)),
        other => panic!("after {} buffers: {other:?}", buffers.len()),
    }
    gpu.healthy().expect("the device itself is fine");
    drop(buffers);
    gpu.wait().expect("the device itself is fine");
    let again = gpu.buffer("of many", size, wgpu::BufferUsages::COPY_DST);
    drop(again.expect("there is room again"));
    // And it draws.
    let context = Context::new().with_gpu(gpu);
    let drawing = tetrascope::algorithms().iter().find(|a| a.needs_gpu);
    let algorithm = drawing.expect("compiled in");
    let settings = &ways(algorithm)[0];
    let [volume, ..] = scene(algorithm, settings).expect("a scene");
    let look = look(&volume, OpticalModel::EmissionAbsorption, 3, 1.0);
    let view = fitted(&volume, CameraFit::PlusZ, true, SIDE);
    let renderer = (algorithm.build)(&context, &volume, &look, settings);
    renderer.and_then(|r| r.render(&view)).expect("a frame");
}

/// How many frames the test below draws of each algorithm, unless the environment says otherwise.
const FRAMES: &str = "TETRASCOPE_FRAMES";

/// Frames from one look to the other, and from one volume to the other: then all is as it was.
const LOOK: u32 = 4;
const VOLUME: u32 = 8;
const PERIOD: u32 = 2 * VOLUME;

/// Pixels per side of the frames that are counted.
const COUNTED: u32 = 96;

/// In a process of its own, as memory is the process's.
#[test]
fn frames_leave_nothing_behind() {
    let program = std::env::current_exe().expect("this one");
    let run = std::process::Command::new(program)
        .args(["--exact", "faults::many_frames", "--ignored", "--nocapture"])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    let more = String::from_utf8_lossy(&run.stderr);
    eprintln!("{more}");
    assert!(
        run.status.success() && said.contains("1 passed"),
        "{said}{more}"
    );
}

/// Draws frames with every algorithm that draws on a GPU, in looks and of volumes that change. In
/// every later period the device's allocator has as many blocks as in the second, and the process
/// does not grow.
///
/// `TETRASCOPE_FRAMES=10000 cargo test --workspace --test rates many_frames -- --ignored --nocapture`
/// draws so many. Measured with Mesa 22.3.6's llvmpipe, 10 000 frames of 32×32 pixels of each, in ten
/// minutes on two busy cores:
///
/// | | blocks on the device | in RAM after 1000 frames | after 10 000 |
/// |---|---|---|---|
/// | `projection` | 16 | 130 724 kB | 130 724 kB |
/// | `raycast-peel` | 14 | 147 696 kB | 147 696 kB |
/// | `resample` | 22 | 156 672 kB | 156 672 kB |
/// | `slicing` | 11 | 154 480 kB | 154 480 kB |
/// | `voxel-hw` | 25 | 159 244 kB | 159 244 kB |
#[test]
#[ignore = "another test runs it alone"]
fn many_frames() {
    let count: u32 = std::env::var(FRAMES).map_or(96, |n| n.parse().expect("a number"));
    let mut failures = Failures::default();
    for algorithm in algorithms("many_frames")
        .into_iter()
        .filter(|a| a.needs_gpu)
    {
        let settings = &ways(algorithm)[0];
        let [volume, changed, _] = scene(algorithm, settings).expect("a scene");
        let model = OpticalModel::EmissionAbsorption;
        let looks = [look(&volume, model, 3, 1.0), look(&volume, model, 40, 60.0)];
        let view = fitted(&volume, CameraFit::PlusZ, true, COUNTED);
        let context = Context::new();
        let gpu = context.gpu().expect("there is an adapter");
        let build = (algorithm.build)(&context, &volume, &looks[0], settings);
        let mut renderer = build.expect("a renderer");
        let mut before = None;
        let mut early = 0;
        for period in 0..count / PERIOD {
            for frame in 0..PERIOD {
                if frame % VOLUME == 0 {
                    let is_second = frame / VOLUME == 1;
                    let volume = if is_second { &changed } else { &volume };
                    renderer.reload(volume).expect("a volume");
                }
                if frame % LOOK == 0 {
                    let look = &looks[(frame / LOOK % 2) as usize];
                    renderer.restyle(look).expect("a look");
                }
                renderer.render(&view).expect("a frame");
            }
            // What was dropped is gone once the device is asked.
            gpu.wait().expect("a device");
            if period == (count / PERIOD / 10).max(1) {
                early = resident();
            }
            let report = gpu.device().generate_allocator_report();
            let there = report.map(|r| (r.allocations.len(), r.total_allocated_bytes));
            if period == 1 {
                before = there;
            }
            // Where a block lies in its page, and so how many bytes align it, may differ.
            if period > 1 && before.map(|b| b.0) != there.map(|t| t.0) {
                let frame = PERIOD * (period + 1);
                let what = format!("before {before:?}, after {frame} frames {there:?}");
                failures.push(format!("{} on the device: {what}", algorithm.name));
                break;
            }
        }
        let late = resident();
        let device = gpu.describe();
        eprintln!(
            "{}: {count} frames on {device}; blocks and bytes there: {before:?}; resident: {early} kB \
             after a tenth, {late} kB in the end",
            algorithm.name
        );
        if late > early + GROWTH {
            failures.push(format!(
                "{}: grows from {early} to {late} kB",
                algorithm.name
            ));
        }
    }
    failures.finish();
}

/// How much a process may grow from a tenth of its frames to the end, kB: what worker threads and the
/// heap take late. An image takes 147 kB, which the heap asks the system for alone; were one left
/// behind by each of 80 frames, they would take 12 MB.
const GROWTH: u64 = 1024;

/// Memory of this process that is in RAM, kB; 0 where the system does not say.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kb = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse().ok());
    kb.unwrap_or(0)
}

/// A shader that the compiler refuses, or that does not fit the device, is told with its name.
#[test]
fn a_shader_that_is_refused_is_told() {
    let test = "a_shader_that_is_refused_is_told";
    if algorithms(test).iter().all(|a| !a.needs_gpu) {
        return;
    }
    let gpu = Gpu::new(&GpuOptions::default()).expect("there is an adapter");
    for (label, source, words) in [
        ("no program", "this is no program", "expected"),
        (
            "a cut program",
            "@compute @workgroup_size(1) fn cs() { let x = ",
            "expected",
        ),
        (
            "an unknown name",
            "@compute @workgroup_size(1) fn cs() { let x = y; }",
            "y",
        ),
        (
            "a wrong type",
            "@compute @workgroup_size(1) fn cs() { var x: u32 = 1.5f; }",
            "u32",
        ),
        (
            "a large workgroup",
            "@compute @workgroup_size(1048576) fn cs() {}",
            "Workgroup size",
        ),
        ("no entry", "fn cs() {}", "entry point"),
        (
            "no such entry",
            "@compute @workgroup_size(1) fn other() {}",
            "cs",
        ),
    ] {
        let program = ComputeProgram {
            label,
            source,
            entry: Some("cs"),
            ..Default::default()
        };
        // Nor is it kept: the second time is as the first.
        for _ in 0..2 {
            match gpu.compute_pipeline(&program) {
                Err(Error::Device { reason }) => {
                    assert!(reason.starts_with(&format!("{label}: ")), "{reason}");
                    assert!(reason.contains(words), "{label}: {reason}");
                    assert!(!reason.contains('\n'), "{reason}");
                }
                other => panic!("{label}: {other:?}"),
            }
        }
        gpu.healthy().expect("the device itself is fine");
    }
    // The next program compiles.
    let program = ComputeProgram {
        label: "a program",
        source: "@compute @workgroup_size(1) fn cs() {}",
        entry: Some("cs"),
        ..Default::default()
    };
    gpu.compute_pipeline(&program).expect("a program");
}
