//! Cells that meet columns of a grid, as `columns/fill.wgsl` goes through them: those with little to
//! do one for each invocation, and the others, which the first dispatch lists, shared by workgroups.

use tetrascope_core::Error;
use tetrascope_shaders::columns::ARRANGE;
use wgpu::{BufferUsages, ShaderStages};

use crate::Gpu;
use crate::passes::{READ, WRITE, group};
use crate::pipelines::ComputeProgram;

const LABEL: &str = "columns";

/// Invocations of a workgroup.
const THREADS: u32 = 64;

/// Bytes of the list of cells with much to do, for each cell.
pub const LIST_BYTES: usize = 8;

/// A program with `columns/fill.wgsl` in it.
#[derive(Debug)]
pub struct Programs {
    small: wgpu::ComputePipeline,
    large: wgpu::ComputePipeline,
}

impl Programs {
    /// Compiles both entry points of `program`.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn new(gpu: &Gpu, program: &ComputeProgram) -> Result<Programs, Error> {
        let pipeline = |entry| {
            gpu.compute_pipeline(&ComputeProgram {
                entry: Some(entry),
                ..program.clone()
            })
        };
        Ok(Programs {
            small: pipeline("cs_small")?,
            large: pipeline("cs_large")?,
        })
    }
}

/// How many cells are listed, and what that makes of dispatches.
#[derive(Debug)]
pub struct Columns {
    arrange: wgpu::ComputePipeline,
    counts: wgpu::Buffer,
    workgroups: wgpu::Buffer,
    arranged: wgpu::BindGroup,
}

impl Columns {
    /// Compiles what arranges dispatches.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn new(gpu: &Gpu) -> Result<Columns, Error> {
        let layout = gpu.layout(LABEL, ShaderStages::COMPUTE, &[READ, WRITE])?;
        let arrange = gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source: ARRANGE,
            entry: Some("cs_arrange"),
            constants: vec![],
            groups: vec![layout.clone()],
        })?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let counts = gpu.buffer("columns::counts", 16, usage)?;
        let usage = BufferUsages::STORAGE | BufferUsages::INDIRECT;
        let workgroups = gpu.buffer("columns::workgroups", 48, usage)?;
        let arranged = gpu.checked(LABEL, 0, || {
            let resources = [&counts, &workgroups].map(|b| b.as_entire_binding());
            group(gpu, LABEL, &layout, &resources)
        })?;
        Ok(Columns {
            arrange,
            counts,
            workgroups,
            arranged,
        })
    }

    /// How many cells are in each list, for binding 4 of the first group; binding 5 are the lists,
    /// [`LIST_BYTES`] for each cell.
    pub fn counts(&self) -> &wgpu::Buffer {
        &self.counts
    }

    /// Records the passes for all `cell_count` cells.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        programs: &Programs,
        groups: &[&wgpu::BindGroup],
        cell_count: u32,
    ) {
        let workgroups = cell_count.div_ceil(THREADS);
        let rows = workgroups.div_ceil(65_535).max(1);
        encoder.clear_buffer(&self.counts, 0, None);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(LABEL),
            timestamp_writes: None,
        });
        let bind = |pass: &mut wgpu::ComputePass| {
            for (index, group) in (0..).zip(groups) {
                pass.set_bind_group(index, *group, &[]);
            }
        };
        bind(&mut pass);
        pass.set_pipeline(&programs.small);
        pass.dispatch_workgroups(workgroups.div_ceil(rows), rows, 1);
        pass.set_bind_group(0, &self.arranged, &[]);
        pass.set_pipeline(&self.arrange);
        pass.dispatch_workgroups(1, 1, 1);
        bind(&mut pass);
        pass.set_pipeline(&programs.large);
        for list in 0..3 {
            pass.dispatch_workgroups_indirect(&self.workgroups, 16 * list);
        }
    }
}
