//! Segments on the device, and what they are made of.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Bounds, Knot, OpticalModel, TransferFunction};
use tetrascope_f32::{KnotPair, Normalization, ScalarMap};
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::passes::model_constant;
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages};
use tetrascope_gpu::{ComputeProgram, Gpu, Integration};
use tetrascope_shaders::common::PROBE;

/// A segment, as `probe.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Probe {
    pub(crate) front: f32,
    pub(crate) back: f32,
    pub(crate) length: f32,
}

/// The intervals of `tf` for a cube that is its own normalization; scalars in [0, 1]
/// are their own map.
pub(crate) fn intervals_of(tf: &TransferFunction) -> Vec<KnotPair> {
    let normalization = Normalization::of(&Bounds::of([DVec3::NEG_ONE, DVec3::ONE]));
    knot_pairs(tf, &ScalarMap::of(tf), &normalization).expect("few knots")
}

/// The table of `tf`, for segments up to `longest`, or all as long as that.
pub(crate) fn table(
    gpu: &Gpu,
    tf: &TransferFunction,
    model: OpticalModel,
    integration: Integration,
    longest: f32,
) -> Table {
    let source = preintegration::Source {
        integration,
        model,
        intervals: &intervals_of(tf),
        longest,
        fixed: Some(preintegration::Fixed {
            length: longest,
            scalars: (0.0, 1.0),
        }),
    };
    Table::new(gpu, "test", &source).expect("it fits")
}

/// Light and optical depth of each probe, and its opacity.
pub(crate) fn on_device(
    gpu: &Gpu,
    tf: &TransferFunction,
    model: OpticalModel,
    table: &Table,
    probes: &[Probe],
) -> Vec<([f32; 4], f32)> {
    let intervals = intervals_of(tf);
    let count = probes.len() as u64;
    let usage = BufferUsages::STORAGE;
    let make = |label, bytes| gpu.buffer(label, bytes, usage | BufferUsages::COPY_SRC);
    let answers = make("answers", 16 * count).expect("it fits");
    let opacities = make("opacities", 4 * count).expect("it fits");
    let buffers = [
        &gpu.upload("intervals", &intervals, usage).expect("it fits"),
        &gpu.upload("probes", probes, usage).expect("it fits"),
        &answers,
        &opacities,
    ];
    let uniform = wgpu::BufferUsages::UNIFORM;
    let span = gpu.upload("span", &[table.span()], uniform);
    let span = span.expect("it fits");
    // Beyond the knots on both sides, as some probes are.
    let mut constants = table.constants((-1.0, 2.0)).to_vec();
    constants.push(model_constant(model));
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let pipeline = gpu.compute_pipeline(&ComputeProgram {
        label: "probe",
        source: PROBE,
        constants,
        ..Default::default()
    });
    let pipeline = pipeline.expect("the program is valid");
    let record = || {
        let device = gpu.device();
        let mut resources = buffers.map(|b| b.as_entire_binding()).to_vec();
        resources.extend([table.binding(), span.as_entire_binding()]);
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("probe"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(probes.len().div_ceil(64) as u32, 1, 1);
    };
    gpu.checked("probe", 0, record)
        .expect("the program is valid");
    let a = read_back(gpu, &mut encoder, Source::Buffer(&answers, 16 * count)).expect("a copy");
    let o = read_back(gpu, &mut encoder, Source::Buffer(&opacities, 4 * count)).expect("a copy");
    gpu.finish(encoder).expect("nothing can fail");
    let answers: Vec<[f32; 4]> = a.read().expect("readable");
    let opacities: Vec<f32> = o.read().expect("readable");
    answers.into_iter().zip(opacities).collect()
}

/// A full-period generator of numbers in [0, 1) (Numerical Recipes' constants).
pub(crate) fn random(seed: u32) -> impl FnMut() -> f64 {
    let mut x = seed;
    move || {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(x >> 8) / f64::from(1 << 24)
    }
}

/// A bumpy transfer function with two steps over [0, 1], extinction at most `most`.
pub(crate) fn bumps(most: f64) -> TransferFunction {
    let knot = |scalar, color: [f64; 3], extinction: f64| Knot {
        scalar,
        color: DVec3::from(color),
        extinction: extinction * most,
    };
    TransferFunction::new(vec![
        knot(0.0, [0.1, 0.9, 0.3], 0.2),
        knot(0.125, [0.9, 0.1, 0.5], 0.7),
        knot(0.25, [0.2, 0.3, 0.8], 0.0),
        knot(0.25, [1.0, 0.6, 0.0], 1.0),
        knot(0.5, [0.0, 0.5, 1.0], 0.999),
        knot(0.75, [0.4, 0.0, 0.2], 0.05),
        knot(0.75, [0.7, 0.8, 0.9], 0.5),
        knot(1.0, [0.3, 0.2, 0.1], 0.9),
    ])
    .expect("the knots are sorted")
}
