//! The pass that finds boxes on the device (`cull.wgsl`).

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::Zeroable as _;
use tetrascope_core::{Appearance, Error};
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE, group};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{ComputeProgram, Gpu};
use tetrascope_shaders::slicing::CULL;

use crate::boxes::{Boxes, places};
use crate::float_table::FloatTable;
use crate::frustum::Frustum;
use crate::gpu_data::{Arguments, Cull, PlacedBox};
use crate::octree::{Octree, Viewer};
use crate::options::Slicer;
use crate::ranges::first_range;
use crate::samples::{Content, Samples};
use crate::skip::SkipTable;
use crate::table::{self, Table};
use crate::voxels::Voxels;

const LABEL: &str = "slicing::cull";

/// Boxes of a workgroup.
const BLOCK: u32 = 256;

/// The parts of the pass that do not depend on the volume.
#[derive(Debug)]
pub(crate) struct CullPass {
    layout: wgpu::BindGroupLayout,
    /// Count, scan, and list or table.
    pipelines: [wgpu::ComputePipeline; 3],
}

/// The octree and the transfer function on the device.
#[derive(Debug)]
pub(crate) struct CullData {
    judge: Judge,
    counts: wgpu::Buffer,
    bricks: wgpu::Buffer,
}

/// The table that tells by a box's range whether it can show.
#[derive(Debug)]
enum Judge {
    /// For ranges that the CPU knows.
    Samples {
        table: Arc<SkipTable>,
        /// The boxes' ranges, of the levels that were drawn.
        ranges: Mutex<HashMap<u32, wgpu::Buffer>>,
    },
    /// For ranges that only the device knows.
    Device(FloatTable),
}

/// The pass for one frame.
pub(crate) struct Culling {
    group: wgpu::BindGroup,
    block_count: u32,
    /// The list of boxes, once the pass has run.
    pub(crate) boxes: wgpu::Buffer,
    /// The table of boxes in its place, and where the pass writes it.
    table: Option<(Table, wgpu::BindGroup)>,
    /// [`Arguments`] of the draw.
    pub(crate) arguments: wgpu::Buffer,
    /// How many boxes there are in all.
    pub(crate) box_count: u64,
    /// Bytes sent to the device for it.
    pub(crate) bytes: u64,
}

/// The scene of a frame, and from where it is seen.
pub(crate) struct Cast<'a> {
    pub(crate) level: u32,
    pub(crate) slicer: Slicer,
    pub(crate) viewer: Viewer,
    pub(crate) frustum: &'a Frustum,
    /// At least as many boxes as can show.
    pub(crate) room: usize,
    /// Indices that draw one box.
    pub(crate) index_count: u32,
}

impl CullPass {
    pub(crate) fn new(gpu: &Gpu, slicer: Slicer) -> Result<CullPass, Error> {
        let types = [UNIFORM, READ, READ, READ, READ, WRITE, WRITE, WRITE];
        let layout = gpu.layout(LABEL, ShaderStages::COMPUTE, &types)?;
        let pipeline = |entry, groups: &[&wgpu::BindGroupLayout]| {
            gpu.compute_pipeline(&ComputeProgram {
                label: LABEL,
                source: CULL,
                entry: Some(entry),
                groups: groups.iter().copied().cloned().collect(),
                ..Default::default()
            })
        };
        let pipelines = [
            pipeline("cs_count", &[&layout])?,
            pipeline("cs_scan", &[&layout])?,
            match slicer {
                Slicer::Rays => pipeline("cs_table", &[&layout, &table::writing(gpu)?])?,
                _ => pipeline("cs_list", &[&layout])?,
            },
        ];
        Ok(CullPass { layout, pipelines })
    }

    /// The pass for boxes of one level.
    pub(crate) fn frame(
        &self,
        gpu: &Gpu,
        data: &CullData,
        samples: &Samples,
        voxels: &Voxels,
        cast: &Cast,
    ) -> Result<Culling, Error> {
        let boxes = &samples.boxes;
        let halvings = boxes.halvings(cast.level);
        let brick_level = voxels.least_level();
        let bricks = boxes.halvings(brick_level);
        let four = |v: [u32; 3]| [v[0], v[1], v[2], 0];
        let box_size = boxes.box_size(cast.level).map(|s| s as u32);
        let (eye, from_point) = match cast.viewer {
            Viewer::Eye(eye) => (eye, 1.0),
            Viewer::Direction(direction) => (direction, 0.0),
        };
        let bits: u32 = halvings.iter().sum();
        let block_count = (1_u32 << bits).div_ceil(BLOCK);
        let uniform = Cull {
            whole: four(boxes.box_size(0).map(|s| s as u32)),
            box_size: four(box_size),
            halvings: four(halvings),
            brick_shift: four([0, 1, 2].map(|a| halvings[a] - bricks[a])),
            brick_count: four(boxes.divisions(brick_level).map(|n| n as u32)),
            eye: eye.as_vec3().extend(from_point).to_array(),
            margin: cast.frustum.margin.extend(0.0).to_array(),
            level: cast.level,
            bits,
            plane_count: cast.frustum.planes.len() as u32,
            block_count,
            ..data.judge.uniform(boxes, cast.level)
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
        let table = match cast.slicer {
            Slicer::Rays => {
                let table = Table::to_write(gpu, boxes, cast.level)?;
                let written = table.writing(gpu)?;
                Some((table, written))
            }
            _ => None,
        };
        let room = match table {
            Some(_) => 1,
            None => cast.room.max(1),
        };
        let room = room * size_of::<PlacedBox>();
        let list = gpu.buffer("slicing::boxes", room as u64, storage)?;
        let ranges = data.ranges(gpu, samples, cast.level)?;
        let buffers = [
            &uniform,
            &ranges,
            &data.counts,
            &planes,
            &data.bricks,
            &blocks,
            &list,
            &arguments,
        ];
        let buffers = buffers.map(|buffer| buffer.as_entire_binding());
        Ok(Culling {
            group: gpu.checked(LABEL, 0, || group(gpu, LABEL, &self.layout, &buffers))?,
            block_count,
            table,
            boxes: list,
            arguments,
            box_count: boxes.box_count(cast.level) as u64,
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
        if let Some((_, written)) = &culling.table {
            pass.set_bind_group(1, written, &[]);
        }
        let blocks = culling.block_count;
        for (pipeline, groups) in self.pipelines.iter().zip([blocks, 1, blocks]) {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups, 1, 1);
        }
    }
}

impl Culling {
    /// The table of boxes, once the pass has run.
    pub(crate) fn table(&self) -> Option<&Table> {
        self.table.as_ref().map(|(table, _)| table)
    }
}

impl CullData {
    /// For `voxels` that are all on the device; `table` is that of ranges which the CPU knows.
    pub(crate) fn new(
        gpu: &Gpu,
        samples: &Samples,
        table: Option<SkipTable>,
        appearance: &Appearance,
        voxels: &Voxels,
    ) -> Result<CullData, Error> {
        let judge = match table {
            None => Judge::Device(FloatTable::new(appearance)),
            Some(table) => Judge::Samples {
                table: Arc::new(table),
                ranges: Mutex::default(),
            },
        };
        let (boxes, level) = (&samples.boxes, voxels.least_level());
        let texel = |place| {
            // Bricks that cannot show have no slot, and are not asked for.
            let [x, y, z] = voxels.texel(boxes, level, place).unwrap_or_default();
            [x, y, z, 0]
        };
        let bricks: Vec<[i32; 4]> = places(boxes.divisions(level)).map(texel).collect();
        let counts = match &judge {
            Judge::Samples { table, .. } => table.counts(),
            Judge::Device(table) => &table.counts,
        };
        Ok(CullData {
            counts: gpu.upload(LABEL, counts, BufferUsages::STORAGE)?,
            bricks: gpu.upload(LABEL, &bricks, BufferUsages::STORAGE)?,
            judge,
        })
    }

    /// The boxes' ranges of a level; on the device those of all levels.
    fn ranges(&self, gpu: &Gpu, samples: &Samples, level: u32) -> Result<wgpu::Buffer, Error> {
        match (&self.judge, &samples.content) {
            (Judge::Samples { table, ranges }, Content::Source { octree, .. }) => {
                entries(gpu, octree, table, ranges, level)
            }
            (_, Content::Device { ranges, .. }) => Ok(ranges.buffer.clone()),
            (Judge::Device(_), Content::Source { .. }) => {
                unreachable!("a source has a table of the ranges that the CPU knows")
            }
        }
    }
}

/// The ranges of a level as entries of `table`, uploaded when they are first needed.
fn entries(
    gpu: &Gpu,
    octree: &Octree,
    table: &SkipTable,
    kept: &Mutex<HashMap<u32, wgpu::Buffer>>,
    level: u32,
) -> Result<wgpu::Buffer, Error> {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(ranges) = kept.get(&level) {
        return Ok(ranges.clone());
    }
    let ranges = octree.entries(level, table);
    let ranges = gpu.upload(LABEL, &ranges, BufferUsages::STORAGE)?;
    kept.insert(level, ranges.clone());
    Ok(ranges)
}

impl Judge {
    /// The numbers with which the shader judges ranges of a level; the rest is 0.
    fn uniform(&self, boxes: &Boxes, level: u32) -> Cull {
        match self {
            Judge::Samples { .. } => Cull::zeroed(),
            Judge::Device(table) => Cull {
                base: table.base,
                most: table.most,
                bins_per_scalar: table.bins_per_scalar,
                offset: table.offset,
                bins: table.bins,
                first_range: first_range(boxes, level) as u32,
                ..Cull::zeroed()
            },
        }
    }
}
