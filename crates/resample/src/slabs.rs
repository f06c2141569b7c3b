//! Slabs of slices, and lists of the elements that meet each (`active.wgsl`).

use std::ops::Range;

use tetrascope_core::Error;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE, group};
use tetrascope_gpu::pipelines::ComputeProgram;
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_shaders::resample::ACTIVE;

use crate::gpu_data::{Draw, Element, Step};
use tetrascope_gpu::tables::{grown, holds};

const LABEL: &str = "resample::slabs";

/// Invocations of a workgroup.
const THREADS: u32 = 64;

/// Bytes between the steps of a buffer: what offsets are multiples of on every device.
const STRIDE: u64 = 256;

/// Vertices of an element: four triangles, of which some have no area.
const VERTICES: u32 = 12;

/// How much was drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// How many cells are in the list of each slab.
    pub elements: Vec<u32>,
    /// Triangles with an area, over all slices and passes.
    pub triangles: u64,
}

/// Slabs, and what counts their elements. It does not depend on the mesh.
#[derive(Debug)]
pub(crate) struct Slabs {
    slabs: Vec<Slab>,
    slices: Vec<wgpu::BindGroup>,
    slice_layout: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// Draws of no elements.
    empty: wgpu::Buffer,
    draws: wgpu::Buffer,
    triangles: wgpu::Buffer,
}

#[derive(Debug)]
struct Slab {
    slices: Range<u32>,
    step: wgpu::Buffer,
}

/// Elements of a mesh's cells, the slices that each meets, and the list of a slab. The buffers
/// grow, and never shrink.
#[derive(Debug)]
pub(crate) struct Elements {
    pub(crate) elements: wgpu::Buffer,
    pub(crate) spans: wgpu::Buffer,
    pub(crate) list: wgpu::Buffer,
    cell_count: wgpu::Buffer,
    /// The inputs of each slab's list.
    groups: Vec<wgpu::BindGroup>,
}

impl Slabs {
    /// Divides `slice_count` slices among `slab_count` slabs, or as many as there are slices.
    pub(crate) fn new(gpu: &Gpu, slab_count: u32, slice_count: u32) -> Result<Slabs, Error> {
        let slab_count = slab_count.min(slice_count);
        let compute = ShaderStages::COMPUTE;
        let types = [UNIFORM, READ, READ, WRITE, WRITE, WRITE, READ];
        let layout = gpu.layout(LABEL, compute, &types)?;
        let slice_layout = gpu.layout(LABEL, ShaderStages::VERTEX_FRAGMENT, &[READ])?;
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source: ACTIVE,
            entry: None,
            constants: vec![],
            groups: vec![layout.clone()],
        })?;
        let step = |slices: &Range<u32>, slab: u32| Step {
            first: slices.start as i32,
            end: slices.end as i32,
            slab,
            ..Step::default()
        };
        // Slices are as even among slabs as can be.
        let start =
            |slab: u32| (u64::from(slab) * u64::from(slice_count) / u64::from(slab_count)) as u32;
        let slab = |slab: u32| -> Result<Slab, Error> {
            let slices = start(slab)..start(slab + 1);
            let step = [step(&slices, slab)];
            let step = gpu.upload("resample::slab", &step, BufferUsages::UNIFORM)?;
            Ok(Slab { slices, step })
        };
        let slabs = (0..slab_count).map(slab).collect::<Result<_, _>>()?;
        let per_slice = (STRIDE / size_of::<Step>() as u64) as usize;
        let mut steps = vec![Step::default(); per_slice * slice_count as usize];
        for slice in 0..slice_count {
            steps[per_slice * slice as usize] = step(&(slice..slice + 1), 0);
        }
        let steps = gpu.upload("resample::slices", &steps, BufferUsages::STORAGE)?;
        let slices = gpu.checked(LABEL, 0, || {
            let slice = |slice: u32| {
                let binding = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &steps,
                    offset: STRIDE * u64::from(slice),
                    size: std::num::NonZero::new(size_of::<Step>() as u64),
                });
                group(gpu, LABEL, &slice_layout, &[binding])
            };
            (0..slice_count).map(slice).collect()
        })?;
        let draw = Draw {
            vertices: VERTICES,
            elements: 0,
            first_vertex: 0,
            first_instance: 0,
        };
        let draws = vec![draw; slab_count as usize];
        let bytes = size_of_val(&draws[..]) as u64;
        let copied = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let usage = BufferUsages::STORAGE | copied;
        Ok(Slabs {
            slabs,
            slices,
            slice_layout,
            layout,
            pipeline,
            empty: gpu.upload("resample::no draws", &draws, BufferUsages::COPY_SRC)?,
            draws: gpu.buffer("resample::draws", bytes, usage | BufferUsages::INDIRECT)?,
            triangles: gpu.buffer("resample::triangles", 4 * u64::from(slab_count), usage)?,
        })
    }

    pub(crate) fn count(&self) -> usize {
        self.slabs.len()
    }

    pub(crate) fn slices(&self, slab: usize) -> Range<u32> {
        self.slabs[slab].slices.clone()
    }

    /// The layout of a slice's bind group.
    pub(crate) fn slice_layout(&self) -> &wgpu::BindGroupLayout {
        &self.slice_layout
    }

    pub(crate) fn slice(&self, slice: u32) -> &wgpu::BindGroup {
        &self.slices[slice as usize]
    }

    /// Records that no slab has a list yet.
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.empty, 0, &self.draws, 0, None);
        encoder.clear_buffer(&self.triangles, 0, None);
    }

    /// Records what makes the list of a slab.
    pub(crate) fn list(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        elements: &Elements,
        cell_count: u32,
        slab: usize,
    ) {
        compute(
            encoder,
            cell_count,
            &self.pipeline,
            &[&elements.groups[slab]],
        );
    }

    /// Draws the list of a slab.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass, slab: usize) {
        pass.draw_indirect(&self.draws, size_of::<Draw>() as u64 * slab as u64);
    }

    /// How much was drawn by the last submission, each slice so many times.
    pub(crate) fn drawn(&self, gpu: &Gpu, times: u64) -> Result<Drawn, Error> {
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let draws = Source::Buffer(&self.draws, self.draws.size());
        let draws = read_back(gpu, &mut encoder, draws)?;
        let triangles = Source::Buffer(&self.triangles, self.triangles.size());
        let triangles = read_back(gpu, &mut encoder, triangles)?;
        gpu.finish(encoder)?;
        let draws: Vec<Draw> = draws.read()?;
        let triangles: Vec<u32> = triangles.read()?;
        let of_slab = |(slab, count): (&Slab, &u32)| {
            times * u64::from(slab.slices.end - slab.slices.start) * u64::from(*count)
        };
        Ok(Drawn {
            elements: draws.iter().map(|draw| draw.elements).collect(),
            triangles: self.slabs.iter().zip(&triangles).map(of_slab).sum(),
        })
    }
}

impl Elements {
    /// Buffers for so many cells, or a little more than `old` has where that is not enough.
    pub(crate) fn new(
        gpu: &Gpu,
        slabs: &Slabs,
        old: Option<&Elements>,
        cells: usize,
    ) -> Result<Elements, Error> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = |label: &str, bytes: usize, old: Option<&wgpu::Buffer>| {
            grown(gpu, label, (cells, bytes), usage, old)
        };
        let old_elements = old.map(|o| &o.elements);
        let elements = buffer("resample::elements", size_of::<Element>(), old_elements)?;
        let spans = buffer("resample::spans", 8, old.map(|o| &o.spans))?;
        let list = buffer("resample::list", 4, old.map(|o| &o.list))?;
        let cell_count = gpu.buffer("resample::cell count", 4, usage)?;
        let groups = gpu.checked(LABEL, 0, || {
            let of_slab = |slab: &Slab| {
                let buffers = [
                    &slab.step,
                    &spans,
                    &elements,
                    &list,
                    &slabs.draws,
                    &slabs.triangles,
                    &cell_count,
                ];
                let resources = buffers.map(|b| b.as_entire_binding());
                group(gpu, LABEL, &slabs.layout, &resources)
            };
            slabs.slabs.iter().map(of_slab).collect()
        })?;
        Ok(Elements {
            elements,
            spans,
            list,
            cell_count,
            groups,
        })
    }

    pub(crate) fn fit(&self, cells: usize) -> bool {
        holds(&self.elements, (cells, size_of::<Element>()))
            && holds(&self.spans, (cells, 8))
            && holds(&self.list, (cells, 4))
    }

    /// Says how many cells there are from now on.
    pub(crate) fn set_count(&self, gpu: &Gpu, cells: u32) -> Result<(), Error> {
        gpu.write(LABEL, &self.cell_count, &[cells])
    }

    pub(crate) fn bytes(&self) -> u64 {
        let buffers = [&self.elements, &self.spans, &self.list];
        buffers.map(wgpu::Buffer::size).iter().sum()
    }
}

/// Records a dispatch with an invocation for each cell.
pub(crate) fn compute(
    encoder: &mut wgpu::CommandEncoder,
    cell_count: u32,
    pipeline: &wgpu::ComputePipeline,
    groups: &[&wgpu::BindGroup],
) {
    let workgroups = cell_count.div_ceil(THREADS);
    let rows = workgroups.div_ceil(65_535).max(1);
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some(LABEL),
        timestamp_writes: None,
    });
    pass.set_pipeline(pipeline);
    for (index, group) in (0..).zip(groups) {
        pass.set_bind_group(index, *group, &[]);
    }
    pass.dispatch_workgroups(workgroups.div_ceil(rows), rows, 1);
}
