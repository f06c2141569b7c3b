//! Pass 2: sort the cells by the distance of their centroids (`order.wgsl`).

use tetrascope_core::Error;
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, WRITE, group};
use tetrascope_gpu::sort::SortedPairs;
use tetrascope_gpu::wgpu::{self, BindingResource, ShaderStages};
use tetrascope_gpu::{ComputeProgram, Gpu, RadixSort};
use tetrascope_shaders::projection::ORDER;

use crate::classified::Classified;
use crate::frame::KEY_BITS;
use crate::mesh::Geometry;

/// Cells that one workgroup keys.
const WORKGROUP: u32 = 256;

/// The pipelines of the pass.
#[derive(Clone, Debug)]
pub(crate) struct OrderPass {
    sort: RadixSort,
    pipeline: wgpu::ComputePipeline,
    frame_layout: wgpu::BindGroupLayout,
    volume_layout: wgpu::BindGroupLayout,
    pair_layout: wgpu::BindGroupLayout,
}

/// The buffers of the pass for one volume.
#[derive(Debug)]
pub(crate) struct OrderData {
    pairs: SortedPairs,
    volume_group: wgpu::BindGroup,
    pair_group: wgpu::BindGroup,
    count: u32,
}

impl OrderPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<OrderPass, Error> {
        let sort = RadixSort::new(gpu)?;
        let label = "projection::order";
        let stage = ShaderStages::COMPUTE;
        let frame_layout = gpu.layout(label, stage, &[UNIFORM])?;
        let volume_layout = gpu.layout(label, stage, &[TEXELS, READ, READ, READ, READ])?;
        let pair_layout = gpu.layout(label, stage, &[WRITE, WRITE])?;
        let layouts = [&frame_layout, &volume_layout, &pair_layout];
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label,
            source: ORDER,
            groups: layouts.map(Clone::clone).to_vec(),
            ..Default::default()
        })?;
        Ok(OrderPass {
            sort,
            pipeline,
            frame_layout,
            volume_layout,
            pair_layout,
        })
    }

    /// Buffers for the cells that `look` leaves to draw.
    pub(crate) fn data(
        &self,
        gpu: &Gpu,
        geometry: &Geometry,
        scalars: &wgpu::Buffer,
        classified: &Classified,
    ) -> Result<OrderData, Error> {
        let label = "projection::order";
        let pairs = self.sort.pairs(gpu, classified.culled.items, KEY_BITS)?;
        let transformed = geometry.transformed.create_view(&Default::default());
        let resources = [
            BindingResource::TextureView(&transformed),
            scalars.as_entire_binding(),
            geometry.cells.as_entire_binding(),
            classified.culled.drawn.as_entire_binding(),
            classified.culled.pieces.as_entire_binding(),
        ];
        let (volume_group, pair_group) = gpu.checked(label, 0, || {
            let (keys, values) = (pairs.keys(), pairs.values());
            let pairs = [keys.as_entire_binding(), values.as_entire_binding()];
            (
                group(gpu, label, &self.volume_layout, &resources),
                group(gpu, label, &self.pair_layout, &pairs),
            )
        })?;
        Ok(OrderData {
            pairs,
            volume_group,
            pair_group,
            count: classified.culled.items,
        })
    }

    /// Records keys and sort.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        data: &OrderData,
    ) {
        let label = "projection::order";
        let frame = group(gpu, label, &self.frame_layout, &[frame.as_entire_binding()]);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame, &[]);
        pass.set_bind_group(1, &data.volume_group, &[]);
        pass.set_bind_group(2, &data.pair_group, &[]);
        // Two dimensions: one holds 65 535 workgroups on most devices.
        let groups = data.count.div_ceil(WORKGROUP);
        let row = groups.clamp(1, gpu.limits().max_compute_workgroups_per_dimension);
        pass.dispatch_workgroups(row, groups.div_ceil(row), 1);
        data.pairs.record(&mut pass);
    }
}

impl OrderData {
    /// Items, back to front once the pass has run.
    pub(crate) fn sorted(&self) -> &wgpu::Buffer {
        self.pairs.values()
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.pairs.bytes()
    }
}
