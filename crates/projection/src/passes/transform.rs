//! Pass 1: the vertices in camera space (`transform.wgsl`).

use tetrascope_core::Error;
use tetrascope_gpu::passes::{READ, UNIFORM, group, write_texels};
use tetrascope_gpu::wgpu::{self, BindingResource, ShaderStages};
use tetrascope_gpu::{ComputeProgram, Gpu};
use tetrascope_shaders::projection::TRANSFORM;

use crate::mesh::{Field, Geometry, TRANSFORMED_FORMAT};

/// Vertices of one workgroup.
const WORKGROUP: u32 = 256;

/// The pipeline of the pass.
#[derive(Clone, Debug)]
pub(crate) struct TransformPass {
    pipeline: wgpu::ComputePipeline,
    frame_layout: wgpu::BindGroupLayout,
    mesh_layout: wgpu::BindGroupLayout,
}

/// The pass for one volume.
#[derive(Clone, Debug)]
pub(crate) struct TransformData {
    mesh_group: wgpu::BindGroup,
    vertices: u32,
}

impl TransformPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<TransformPass, Error> {
        let label = "projection::transform";
        let stage = ShaderStages::COMPUTE;
        let frame_layout = gpu.layout(label, stage, &[UNIFORM])?;
        let written = write_texels(TRANSFORMED_FORMAT);
        let mesh_layout = gpu.layout(label, stage, &[READ, READ, written])?;
        let pipeline = gpu.compute_pipeline(&ComputeProgram {
            label,
            source: TRANSFORM,
            groups: vec![frame_layout.clone(), mesh_layout.clone()],
            ..Default::default()
        })?;
        Ok(TransformPass {
            pipeline,
            frame_layout,
            mesh_layout,
        })
    }

    /// The pass for the vertices of `geometry` with the scalars of `field`.
    pub(crate) fn data(
        &self,
        gpu: &Gpu,
        geometry: &Geometry,
        field: &Field,
    ) -> Result<TransformData, Error> {
        let label = "projection::transform";
        let transformed = geometry.transformed.create_view(&Default::default());
        let resources = [
            geometry.positions.as_entire_binding(),
            field.scalars.as_entire_binding(),
            BindingResource::TextureView(&transformed),
        ];
        Ok(TransformData {
            mesh_group: gpu.checked(label, 0, || {
                group(gpu, label, &self.mesh_layout, &resources)
            })?,
            vertices: geometry.mesh.points().len() as u32,
        })
    }

    /// Records the pass.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        data: &TransformData,
    ) {
        let label = "projection::transform";
        let frame = group(gpu, label, &self.frame_layout, &[frame.as_entire_binding()]);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame, &[]);
        pass.set_bind_group(1, &data.mesh_group, &[]);
        // Two dimensions: one holds 65 535 workgroups on most devices.
        let groups = data.vertices.div_ceil(WORKGROUP);
        let row = groups.clamp(1, gpu.limits().max_compute_workgroups_per_dimension);
        pass.dispatch_workgroups(row, groups.div_ceil(row), 1);
    }
}
