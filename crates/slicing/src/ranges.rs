//! The passes that find the ranges of boxes on the device (`ranges.wgsl`).

use tetrascope_core::Error;
use tetrascope_gpu::ComputeProgram;
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::passes::{UNIFORM, WRITE, group};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{DeviceGrid, Gpu};
use tetrascope_shaders::slicing::RANGES;

use crate::boxes::Boxes;
use crate::gpu_data::Ranges;

const LABEL: &str = "slicing::ranges";

/// Invocations of a workgroup.
const THREADS: u32 = 64;

/// The octree of a grid on the device: the least and greatest scalar of each box.
#[derive(Debug)]
pub(crate) struct DeviceRanges {
    /// Two floats for each box, all levels one behind the other.
    pub(crate) buffer: wgpu::Buffer,
    voxels: wgpu::BindGroup,
    /// From the deepest level up.
    levels: Vec<LevelPass>,
}

/// The pass that finds the ranges of one level.
#[derive(Debug)]
struct LevelPass {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 3],
}

impl DeviceRanges {
    /// Makes the passes; each box's range is to include `reach` samples around it.
    pub(crate) fn new(
        gpu: &Gpu,
        grid: &DeviceGrid,
        boxes: &Boxes,
        reach: usize,
    ) -> Result<DeviceRanges, Error> {
        let levels = boxes.deepest() + 1;
        let bytes = 8 * first_range(boxes, levels) as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let buffer = gpu.buffer("the ranges of boxes", bytes, usage)?;
        let uniforms: Vec<wgpu::Buffer> = (0..levels)
            .map(|level| {
                gpu.upload(
                    LABEL,
                    &[uniform(boxes, level, reach)],
                    BufferUsages::UNIFORM,
                )
            })
            .collect::<Result<_, _>>()?;
        let compute = ShaderStages::COMPUTE;
        let level_layout = gpu.layout(LABEL, compute, &[UNIFORM, WRITE])?;
        let voxel_layout = gpu.layout(LABEL, compute, &[VOXELS])?;
        let yes = |condition: bool| f64::from(u8::from(condition));
        let pipeline = |entry| {
            gpu.compute_pipeline(&ComputeProgram {
                label: LABEL,
                source: RANGES,
                entry: Some(entry),
                constants: vec![
                    ("COVERED", yes(grid.texels() == Texels::Covered)),
                    ("GAPS", yes(grid.texels() == Texels::Gaps)),
                ],
                groups: vec![level_layout.clone(), voxel_layout.clone()],
            })
        };
        let (leaf, gather) = (pipeline("cs_leaf")?, pipeline("cs_gather")?);
        gpu.checked(LABEL, 0, || {
            let pass = |level: u32| {
                let uniform = &uniforms[level as usize];
                let resources = [uniform, &buffer].map(|b| b.as_entire_binding());
                let divisions = boxes.divisions(level).map(|d| d as u32);
                let all: u32 = divisions.iter().product();
                let (pipeline, workgroups) = match level == boxes.deepest() {
                    true => (&leaf, divisions),
                    false => (&gather, [all.div_ceil(THREADS), 1, 1]),
                };
                LevelPass {
                    pipeline: pipeline.clone(),
                    group: group(gpu, LABEL, &level_layout, &resources),
                    workgroups,
                }
            };
            let view = grid.texture().create_view(&Default::default());
            let voxels = [wgpu::BindingResource::TextureView(&view)];
            DeviceRanges {
                voxels: group(gpu, LABEL, &voxel_layout, &voxels),
                levels: (0..levels).rev().map(pass).collect(),
                buffer: buffer.clone(),
            }
        })
    }

    /// Records the passes, for what the texture holds by then. The work on the CPU does not
    /// depend on how many samples there are.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(LABEL),
            timestamp_writes: None,
        });
        pass.set_bind_group(1, &self.voxels, &[]);
        for level in &self.levels {
            let [x, y, z] = level.workgroups;
            pass.set_pipeline(&level.pipeline);
            pass.set_bind_group(0, &level.group, &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    }
}

/// A grid's texture, read texel by texel.
const VOXELS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D3,
    multisampled: false,
};

/// Where the ranges of a level begin among those of all levels.
pub(crate) fn first_range(boxes: &Boxes, level: u32) -> usize {
    let count = |level| boxes.divisions(level).iter().product::<usize>();
    (0..level).map(count).sum()
}

fn uniform(boxes: &Boxes, level: u32, reach: usize) -> Ranges {
    let four = |v: [usize; 3]| [v[0] as u32, v[1] as u32, v[2] as u32, 0];
    let below = (level + 1).min(boxes.deepest());
    let [divisions, finer] = [level, below].map(|level| boxes.divisions(level));
    Ranges {
        cells: four(boxes.cells),
        box_size: four(boxes.box_size(level)),
        divisions: four(divisions),
        halved: four([0, 1, 2].map(|a| usize::from(finer[a] > divisions[a]))),
        first: first_range(boxes, level) as u32,
        first_below: first_range(boxes, below) as u32,
        reach: reach as u32,
        padding: 0,
    }
}

#[cfg(test)]
mod tests;
