//! The pass that finds boxes on the device (`cull.wgsl`).

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use tetrascope_core::Error;
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE, group};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{ComputeProgram, Gpu};
use tetrascope_shaders::slicing::CULL;

use crate::frustum::Frustum;
use crate::gpu_data::{Arguments, Box, Cull};
use crate::octree::{Octree, Viewer, places};
use crate::skip::SkipTable;
use crate::voxels::Voxels;

const LABEL: &str = "slicing::cull";

/// Boxes of a workgroup.
const BLOCK: u32 = 256;

/// What does not depend on the volume.
#[derive(Debug)]
pub(crate) struct CullPass {
    layout: wgpu::BindGroupLayout,
    /// Count, scan, list.
    pipelines: [wgpu::ComputePipeline; 3],
}

/// The octree and the transfer function on the device.
#[derive(Debug)]
pub(crate) struct CullData {
    table: SkipTable,
    counts: wgpu::Buffer,
    bricks: wgpu::Buffer,
    /// Of the levels that were drawn, the boxes' ranges.
    ranges: Mutex<HashMap<u32, wgpu::Buffer>>,
}

/// The pass for one frame.
pub(crate) struct Culling {
    group: wgpu::BindGroup,
    block_count: u32,
    /// The list of boxes, once the pass has run.
    pub(crate) boxes: wgpu::Buffer,
    /// [`Arguments`] of the draw.
    pub(crate) arguments: wgpu::Buffer,
    /// How many boxes there are in all.
    pub(crate) box_count: u64,
    /// Bytes sent to the device for it.
    pub(crate) bytes: u64,
}

/// What a frame draws and from where it is seen.
pub(crate) struct Cast<'a> {
    pub(crate) level: u32,
    pub(crate) viewer: Viewer,
    pub(crate) frustum: &'a Frustum,
    /// At least as many boxes as can show.
    pub(crate) room: usize,
    /// Indices that draw one box.
    pub(crate) index_count: u32,
}

impl CullPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<CullPass, Error> {
        let types = [UNIFORM, READ, READ, READ, READ, WRITE, WRITE, WRITE];
        let layout = gpu.layout(LABEL, ShaderStages::COMPUTE, &types)?;
        let pipeline = |entry| {
            gpu.compute_pipeline(&ComputeProgram {
                label: LABEL,
                source: CULL,
                entry: Some(entry),
                groups: vec![layout.clone()],
                ..Default::default()
            })
        };
        let pipelines = [
            pipeline("cs_count")?,
            pipeline("cs_scan")?,
            pipeline("cs_list")?,
        ];
        Ok(CullPass { layout, pipelines })
    }

    /// The pass for boxes of one level.
    pub(crate) fn frame(
        &self,
        gpu: &Gpu,
        data: &CullData,
        octree: &Octree,
        voxels: &Voxels,
        cast: &Cast,
    ) -> Result<Culling, Error> {
        let halvings = octree.halvings(cast.level);
        let brick_level = voxels.least_level();
        let bricks = octree.halvings(brick_level);
        let four = |v: [u32; 3]| [v[0], v[1], v[2], 0];
        let box_size = octree.box_size(cast.level).map(|s| s as u32);
        let (eye, from_point) = match cast.viewer {
            Viewer::Eye(eye) => (eye, 1.0),
            Viewer::Direction(direction) => (direction, 0.0),
        };
        let bits: u32 = halvings.iter().sum();
        let block_count = (1_u32 << bits).div_ceil(BLOCK);
        let uniform = Cull {
            whole: four(octree.box_size(0).map(|s| s as u32)),
            box_size: four(box_size),
            halvings: four(halvings),
            brick_shift: four([0, 1, 2].map(|a| halvings[a] - bricks[a])),
            brick_count: four(octree.divisions(brick_level).map(|n| n as u32)),
            eye: eye.as_vec3().extend(from_point).to_array(),
            margin: cast.frustum.margin.extend(0.0).to_array(),
            level: cast.level,
            bits,
            plane_count: cast.frustum.planes.len() as u32,
            block_count,
        };
        let arguments = Arguments {
            index_count: cast.index_count,
            instance_count: 0,
            first_index: 0,
            base_vertex: 0,
            first_instance: 0,
        };
        let planes: Vec<[f32; 4]> = cast.frustum.planes.iter().map(|p| p.to_array()).collect();
        let storage = BufferUsages::STORAGE;
        let bytes = size_of_val(&uniform) + size_of_val(&arguments) + size_of_val(&planes[..]);
        let uniform = gpu.upload(LABEL, &[uniform], BufferUsages::UNIFORM)?;
        let planes = gpu.upload(LABEL, &planes, storage)?;
        let usage = storage | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let arguments = gpu.upload(LABEL, &[arguments], usage)?;
        let blocks = gpu.buffer(LABEL, 4 * u64::from(block_count), storage)?;
        let room = cast.room.max(1) * size_of::<Box>();
        let boxes = gpu.buffer("slicing::boxes", room as u64, storage)?;
        let ranges = data.ranges(gpu, octree, cast.level)?;
        let buffers = [
            &uniform,
            &ranges,
            &data.counts,
            &planes,
            &data.bricks,
            &blocks,
            &boxes,
            &arguments,
        ];
        let buffers = buffers.map(|buffer| buffer.as_entire_binding());
        Ok(Culling {
            group: gpu.checked(LABEL, 0, || group(gpu, LABEL, &self.layout, &buffers))?,
            block_count,
            boxes,
            arguments,
            box_count: octree.box_count(cast.level) as u64,
            bytes: bytes as u64,
        })
    }

    /// Records the pass.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, culling: &Culling) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(LABEL),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &culling.group, &[]);
        let blocks = culling.block_count;
        for (pipeline, groups) in self.pipelines.iter().zip([blocks, 1, blocks]) {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups, 1, 1);
        }
    }
}

impl CullData {
    /// For `voxels` that are all on the device.
    pub(crate) fn new(
        gpu: &Gpu,
        octree: &Octree,
        table: SkipTable,
        voxels: &Voxels,
    ) -> Result<CullData, Error> {
        let level = voxels.least_level();
        let texel = |place| {
            // Bricks that cannot show have no slot, and are not asked for.
            let [x, y, z] = voxels.texel(octree, level, place).unwrap_or_default();
            [x, y, z, 0]
        };
        let bricks: Vec<[i32; 4]> = places(octree.divisions(level)).map(texel).collect();
        Ok(CullData {
            counts: gpu.upload(LABEL, table.counts(), BufferUsages::STORAGE)?,
            bricks: gpu.upload(LABEL, &bricks, BufferUsages::STORAGE)?,
            ranges: Mutex::default(),
            table,
        })
    }

    fn ranges(&self, gpu: &Gpu, octree: &Octree, level: u32) -> Result<wgpu::Buffer, Error> {
        let mut kept = self.ranges.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(ranges) = kept.get(&level) {
            return Ok(ranges.clone());
        }
        let ranges = octree.entries(level, &self.table);
        let ranges = gpu.upload(LABEL, &ranges, BufferUsages::STORAGE)?;
        kept.insert(level, ranges.clone());
        Ok(ranges)
    }
}
