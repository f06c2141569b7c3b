//! Grids that are made on the device, and what it takes to draw them.

use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::{
    Appearance, Error, Frame, Grid, OpticalModel, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_gpu::ComputeProgram;
use tetrascope_gpu::device_grid::{NO_VALUE, Texels};
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages, TextureFormat, TextureUsages};
use tetrascope_gpu::{DeviceGrid, Draw as _, Gpu, Target, passes};
use tetrascope_slicing::counters::{BRICKS_DRAWN, BRICKS_SKIPPED, GEOMETRY_BYTES};
use tetrascope_slicing::{
    Integration, Level, Shading, Slicer, Slicing, SlicingOptions, Storage, Traversal,
};

use crate::support::*;

/// An algorithm that makes grids: a blob in emptiness, in whole 1024ths, which f32 has.
const MAKE: &str = "
@group(0) @binding(0) var<uniform> step: vec4i;
@group(0) @binding(1) var made: texture_storage_3d<r32float, write>;

@compute @workgroup_size(4, 4, 4)
fn cs_make(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(made);
    if any(id >= size) {
        return;
    }
    let p = vec3i(id) - vec3i(size) / 2 + vec3i(step.x, 0, 0);
    var number = f32(max(1024 - 4 * (p.x * p.x + 2 * p.y * p.y + p.z * p.z), 0)) / 1024.0;
    if step.y > 0 && (p.x + 3 * p.y + p.z) % 23 == 0 {
        number = 3.40282346638528859811704183484516925e+38;
    }
    textureStore(made, id, vec4f(number, 0.0, 0.0, 0.0));
}
";

/// The same, of which whole 128ths are there: all near the middle, nothing far from it.
const MAKE_COVERED: &str = "
@group(0) @binding(0) var<uniform> step: vec4i;
@group(0) @binding(1) var made: texture_storage_3d<rg32float, write>;

@compute @workgroup_size(4, 4, 4)
fn cs_make(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(made);
    if any(id >= size) {
        return;
    }
    let p = vec3i(id) - vec3i(size) / 2 + vec3i(step.x, 0, 0);
    let number = f32(1024 - (p.x * p.x + p.y * p.z)) / 2048.0;
    let coverage = f32(clamp(150 - (p.x * p.x + p.y * p.y + p.z * p.z), 0, 128)) / 128.0;
    textureStore(made, id, vec4f(number, coverage, 0.0, 0.0));
}
";

/// The same numbers on the CPU.
fn samples(dims: [usize; 3], step: [i32; 2]) -> Samples {
    let sample = |i: usize| {
        let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
        let [x, y, z] = [0, 1, 2].map(|a| at[a] as i32 - dims[a] as i32 / 2);
        let x = x + step[0];
        if step[1] > 0 && (x + 3 * y + z) % 23 == 0 {
            return f32::NAN;
        }
        (1024 - 4 * (x * x + 2 * y * y + z * z)).max(0) as f32 / 1024.0
    };
    Samples::F32((0..dims.iter().product()).map(sample).collect())
}

/// The pass of [`MAKE`] for one grid.
struct Maker {
    uniform: wgpu::Buffer,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 3],
}

impl Maker {
    fn new(gpu: &Gpu, grid: &DeviceGrid) -> Maker {
        let shader = match grid.texels() {
            Texels::Covered => MAKE_COVERED,
            Texels::Values | Texels::Gaps => MAKE,
        };
        let storage = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: grid.texels().format(),
            view_dimension: wgpu::TextureViewDimension::D3,
        };
        let uniform = gpu.upload("step", &[[0_i32; 4]], BufferUsages::UNIFORM);
        let uniform = uniform.expect("16 bytes");
        let types = [passes::UNIFORM, storage];
        let layout = gpu.layout("make", ShaderStages::COMPUTE, &types);
        let layout = layout.expect("two resources");
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label: "make",
            source: shader,
            groups: vec![layout.clone()],
            ..Default::default()
        });
        let made = gpu.checked("make", 0, || {
            let view = grid.texture().create_view(&Default::default());
            let resources = [
                uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(&view),
            ];
            passes::group(gpu, "make", &layout, &resources)
        });
        Maker {
            uniform,
            pipeline: pipeline.expect("the shader is valid"),
            group: made.expect("two resources"),
            workgroups: grid.lattice().dims.map(|d| (d as u32).div_ceil(4)),
        }
    }

    fn record(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, [x, y]: [i32; 2]) {
        let step = [[x, y, 0, 0]];
        gpu.write("step", &self.uniform, &step).expect("16 bytes");
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

const LOW_AND_HIGH: (f64, f64) = (0.0, 1.0);

/// A grid that a compute pass has made, and its twin in memory.
fn made(gpu: &Gpu, dims: [usize; 3], step: [i32; 2]) -> (DeviceGrid, Grid) {
    let twin = Place { dims, ..skewed() }.grid(samples(dims, step));
    let texels = if step[1] > 0 {
        Texels::Gaps
    } else {
        Texels::Values
    };
    let grid = DeviceGrid::new(gpu, twin.lattice(), texels, Some(LOW_AND_HIGH));
    let grid = grid.expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    Maker::new(gpu, &grid).record(gpu, &mut encoder, step);
    gpu.finish(encoder).expect("submitted");
    (grid, twin)
}

const DIMS: [usize; 3] = [51, 37, 42];

fn look(model: OpticalModel) -> Appearance {
    appearance(&ramp(8.0), model)
}

fn render(gpu: &Gpu, grid: &DeviceGrid, look: &Appearance, view: &View) -> Frame {
    let slicing = Slicing::from_device(gpu, grid, look, &SlicingOptions::default());
    let frame = slicing.and_then(|slicing| slicing.render(view));
    frame.unwrap_or_else(|error| panic!("{error}"))
}

/// The knots are at 0 and 1, so the map of scalars itself rounds nothing.
#[test]
fn a_grid_made_by_a_compute_pass_is_drawn_as_its_samples() {
    let Some(gpu) = testing::gpu("a_grid_made_by_a_compute_pass_is_drawn_as_its_samples") else {
        return;
    };
    for step in [[3, 0], [-5, 1]] {
        let (grid, twin) = made(&gpu, DIMS, step);
        for model in OpticalModel::ALL {
            let volume = Volume::Grid(twin.clone());
            let look = match model {
                OpticalModel::Isosurfaces => testing::surfaces(&volume, look(model)),
                _ => look(model),
            };
            for (name, view) in views(&twin) {
                let context = format!("{step:?} {model:?} {name}");
                let from_device = render(&gpu, &grid, &look, &view);
                let from_memory = draw(&gpu, &twin, &look, &Default::default(), &view);
                assert!(shows(&from_memory) || name == "inside", "{context}");
                assert_near(&from_device, &from_memory, &context);
                let depths = [&from_device, &from_memory].map(|frame| frame.depths.clone());
                for (a, b) in std::iter::zip(depths[0].iter().flatten(), depths[1].iter().flatten())
                {
                    assert!(a == b || (a - b).abs() <= 1e-5 * b, "{context}: {a} {b}");
                }
            }
        }
    }
}

/// With other knots the CPU maps in f64 and rounds once, the device rounds the unit and the
/// product, and interpolation three times more: 2⁻²² of a scalar, over which color and
/// opacity change by less than twice as much.
#[test]
fn other_knots_change_no_more_than_rounding() {
    let Some(gpu) = testing::gpu("other_knots_change_no_more_than_rounding") else {
        return;
    };
    let (grid, twin) = made(&gpu, DIMS, [0, 0]);
    let tf = TransferFunction::new(vec![
        knot(0.1, [0.1, 0.3, 0.9], 0.0),
        knot(0.45, [0.9, 0.5, 0.2], 3.0),
        knot(0.93, [1.0, 0.9, 0.6], 5.0),
    ]);
    let look = appearance(&tf.expect("sorted"), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&twin) {
        let from_device = render(&gpu, &grid, &look, &view);
        let from_memory = draw(&gpu, &twin, &look, &Default::default(), &view);
        let (_, most) = between(&from_device, &from_memory);
        assert!(most <= 1e-6, "{name}: {most:e}");
    }
}

/// Empty boxes are skipped without a sample having come back, and no sample is sent.
#[test]
fn nothing_is_uploaded_and_empty_boxes_are_skipped() {
    let Some(gpu) = testing::gpu("nothing_is_uploaded_and_empty_boxes_are_skipped") else {
        return;
    };
    let mut sent = Vec::new();
    for dims in [[90, 70, 80], [140, 141, 142]] {
        let (grid, twin) = made(&gpu, dims, [0, 0]);
        let (_, view) = views(&twin).swap_remove(0);
        let look = look(OpticalModel::EmissionAbsorption);
        for level in [
            Level::Auto,
            Level::Fixed(0),
            Level::Fixed(2),
            Level::Fixed(7),
        ] {
            let options = SlicingOptions {
                level,
                ..Default::default()
            };
            let slicing = Slicing::from_device(&gpu, &grid, &look, &options).expect("it fits");
            let frame = slicing.render(&view).expect("a view");
            let of_cpu = SlicingOptions {
                traversal: Traversal::Cpu,
                level: match level {
                    Level::Auto => Level::Fixed(dims[0].ilog2() - 3),
                    fixed => fixed,
                },
                ..Default::default()
            };
            let cpu = draw(&gpu, &twin, &look, &of_cpu, &view);
            assert_near(&frame, &cpu, &format!("{level:?}"));
            // Air is 0, where the ramp begins: the table of floats tells it as exactly.
            assert_eq!(
                frame.stats.get(BRICKS_DRAWN),
                cpu.stats.get(BRICKS_DRAWN),
                "{level:?}"
            );
            assert_eq!(
                frame.stats.get(BRICKS_SKIPPED),
                cpu.stats.get(BRICKS_SKIPPED)
            );
            if level == Level::Auto {
                let [drawn, skipped] = [
                    frame.stats.get(BRICKS_DRAWN),
                    frame.stats.get(BRICKS_SKIPPED),
                ];
                assert!(drawn < skipped, "{drawn:?} {skipped:?}");
                sent.push(frame.stats.get(GEOMETRY_BYTES).expect("counted"));
            }
            assert_eq!(frame.stats.bytes_uploaded, 0);
            let samples: usize = dims.iter().product();
            assert_eq!(frame.stats.bytes_resident / samples as u64, 4);
            assert_eq!(frame.stats.notes, Vec::<String>::new());
        }
    }
    // The camera and the planes of its frustum, whatever the size of the grid.
    assert_eq!(sent[0], sent[1]);
    assert!(sent[0] < 1000, "{sent:?}");
}

/// Records what makes the grid, what finds its ranges, and the frame, and submits once.
#[test]
fn a_grid_may_be_made_anew_in_every_frame() {
    let Some(gpu) = testing::gpu("a_grid_may_be_made_anew_in_every_frame") else {
        return;
    };
    let (grid, twin) = made(&gpu, DIMS, [0, 0]);
    let maker = Maker::new(&gpu, &grid);
    let look = look(OpticalModel::EmissionAbsorption);
    let slicing = Slicing::from_device(&gpu, &grid, &look, &SlicingOptions::default());
    let slicing = slicing.expect("it fits");
    let (_, view) = views(&twin).swap_remove(0);
    let format = TextureFormat::Rgba32Float;
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let mut drawn = Vec::new();
    // The blob goes through boxes that were empty before.
    for x in [0, 17, -16] {
        let size = (view.width, view.height);
        let picture = gpu
            .texture("picture", size, format, usage)
            .expect("it fits");
        let color = picture.create_view(&Default::default());
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        maker.record(&gpu, &mut encoder, [x, 0]);
        slicing.refresh(&mut encoder).expect("it is on the device");
        let target = Target::new(&color, format);
        let recorded = slicing
            .encode(&mut encoder, &view, &target)
            .expect("recorded");
        let copy = read_back(&gpu, &mut encoder, Source::Texture(&picture)).expect("it fits");
        gpu.finish(encoder).expect("submitted");
        let stats = recorded.statistics().expect("read");
        assert_eq!(stats.bytes_uploaded, 0);
        let pixels: Vec<[f32; 4]> = copy.read().expect("read");
        let drawn_now = Frame::new(size, pixels, stats.clone());
        let twin = Place {
            dims: DIMS,
            ..skewed()
        }
        .grid(samples(DIMS, [x, 0]));
        let truth = draw(&gpu, &twin, &look, &Default::default(), &view);
        assert!(shows(&truth));
        assert_near(&drawn_now, &truth, &x.to_string());
        drawn.push(stats.get(BRICKS_DRAWN));
    }
    assert!(drawn[0] != drawn[1], "other boxes show: {drawn:?}");
}

/// The texels are the same numbers, and so are the shaders.
#[test]
fn a_covered_grid_made_by_a_compute_pass_is_drawn_as_its_samples() {
    let Some(gpu) = testing::gpu("a_covered_grid_made_by_a_compute_pass_is_drawn_as_its_samples")
    else {
        return;
    };
    let each = |number: &dyn Fn([i32; 3]) -> f32| -> Vec<f32> {
        let at = (0..DIMS.iter().product()).map(|i: usize| {
            let at = [i % DIMS[0], i / DIMS[0] % DIMS[1], i / (DIMS[0] * DIMS[1])];
            [0, 1, 2].map(|a| at[a] as i32 - DIMS[a] as i32 / 2)
        });
        at.map(number).collect()
    };
    let numbers = each(&|[x, y, z]| (1024 - (x * x + y * z)) as f32 / 2048.0);
    let shares = each(&|[x, y, z]| (150 - (x * x + y * y + z * z)).clamp(0, 128) as f32 / 128.0);
    let place = Place {
        dims: DIMS,
        ..skewed()
    };
    let twin = place
        .grid(Samples::F32(numbers))
        .covered(shares)
        .expect("shares");
    let range = Some(LOW_AND_HIGH);
    let grid = DeviceGrid::new(&gpu, twin.lattice(), Texels::Covered, range).expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    Maker::new(&gpu, &grid).record(&gpu, &mut encoder, [0, 0]);
    gpu.finish(encoder).expect("submitted");
    let look = look(OpticalModel::EmissionAbsorption);
    for (name, view) in views(&twin) {
        let from_device = render(&gpu, &grid, &look, &view);
        let from_memory = draw(&gpu, &twin, &look, &Default::default(), &view);
        assert!(shows(&from_memory) || name == "inside", "{name}");
        assert!(from_device.pixels == from_memory.pixels, "{name}");
        assert_eq!(
            from_device.stats.get(BRICKS_DRAWN),
            from_memory.stats.get(BRICKS_DRAWN)
        );
        assert!(from_device.stats.get(BRICKS_SKIPPED) > Some(0), "{name}");
    }
}

/// Another appearance leaves the texture as it is; other volumes may come and go.
#[test]
fn a_renderer_goes_from_the_device_to_memory_and_back() {
    let Some(gpu) = testing::gpu("a_renderer_goes_from_the_device_to_memory_and_back") else {
        return;
    };
    let (grid, twin) = made(&gpu, DIMS, [0, 0]);
    let (other, other_twin) = made(&gpu, [20, 61, 33], [4, 1]);
    let options = SlicingOptions::default();
    let first = look(OpticalModel::Emission);
    let mut slicing = Slicing::from_device(&gpu, &grid, &first, &options).expect("it fits");
    let volume = Volume::Grid(twin.clone());
    let second = testing::surfaces(&volume, look(OpticalModel::Isosurfaces));
    let same = |slicing: &Slicing, grid: &Grid, look: &Appearance, step: &str| {
        let (_, view) = views(grid).swap_remove(0);
        let expected = draw(&gpu, grid, look, &options, &view);
        let found = slicing.render(&view).expect("a view");
        assert_near(&found, &expected, step);
    };
    same(&slicing, &twin, &first, "as made");
    // Surfaces reach farther around each box than slabs.
    slicing.restyle(&second).expect("it draws them");
    same(&slicing, &twin, &second, "surfaces");
    slicing.restyle(&first).expect("it draws it");
    slicing.reload_device(&other).expect("it fits");
    same(&slicing, &other_twin, &first, "another grid");
    slicing.reload(&volume).expect("it fits");
    same(&slicing, &twin, &first, "from memory");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let error = slicing
        .refresh(&mut encoder)
        .expect_err("nothing to refresh");
    assert!(
        error.to_string().contains("where it is not made"),
        "{error}"
    );
    slicing.reload_device(&grid).expect("it fits");
    same(&slicing, &twin, &first, "and back");
    // From a renderer that never had anything to cull on the device.
    let mut slicing = Slicing::new(&gpu, &volume, &first, &options).expect("it fits");
    slicing.reload_device(&other).expect("it fits");
    same(&slicing, &other_twin, &first, "from memory to the device");
}

#[test]
fn what_the_device_cannot_do_is_refused() {
    let Some(gpu) = testing::gpu("what_the_device_cannot_do_is_refused") else {
        return;
    };
    let (grid, twin) = made(&gpu, [9, 8, 10], [0, 0]);
    let look = look(OpticalModel::EmissionAbsorption);
    let lattice = Lattice {
        interpolation: Interpolation::Nearest,
        ..*twin.lattice()
    };
    let cells = DeviceGrid::new(&gpu, &lattice, Texels::Values, None).expect("it fits");
    let by_cpu = SlicingOptions {
        slicer: Slicer::Cpu,
        ..Default::default()
    };
    let bricks = SlicingOptions {
        storage: Storage::Bricks,
        ..Default::default()
    };
    let plain = SlicingOptions::default();
    for (grid, options, words) in [
        (&cells, &plain, "samples that fill cells"),
        (&grid, &by_cpu, "polygons cut on the CPU"),
        (&grid, &bricks, "bricks"),
    ] {
        let error = Slicing::from_device(&gpu, grid, &look, options).expect_err(words);
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    assert_eq!(NO_VALUE, f32::MAX);
}

/// Every setting that does not depend on who knows the samples.
#[test]
fn settings_draw_the_same_from_the_device() {
    let Some(gpu) = testing::gpu("settings_draw_the_same_from_the_device") else {
        return;
    };
    let (grid, twin) = made(&gpu, DIMS, [2, 1]);
    let (_, view) = views(&twin).swap_remove(0);
    let look = look(OpticalModel::EmissionAbsorption);
    for options in [
        SlicingOptions {
            integration: Integration::PostClassified,
            ..Default::default()
        },
        SlicingOptions {
            shading: Shading::Phong(Default::default()),
            ..Default::default()
        },
        SlicingOptions {
            slices_per_voxel: 0.5,
            ..Default::default()
        },
    ] {
        let slicing = Slicing::from_device(&gpu, &grid, &look, &options).expect("it fits");
        let found = slicing.render(&view).expect("a view");
        let expected = draw(&gpu, &twin, &look, &options, &view);
        assert_near(&found, &expected, &format!("{options:?}"));
    }
}
