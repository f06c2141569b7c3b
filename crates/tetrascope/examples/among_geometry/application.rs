//! The application's own part: a device, textures, and an opaque ball that it draws with depths.

use tetrascope::core::glam::DMat4;
use tetrascope::gpu::Gpu;
use tetrascope::gpu::wgpu::util::{BufferInitDescriptor, DeviceExt as _};
use tetrascope::gpu::wgpu::{self, LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

use crate::{COLOR, DEPTH, SIZE};

/// Six for each quadrilateral.
const VERTICES: u32 = 48 * 24 * 6;

/// A device of the application's own, with what makes renderers faster or more exact.
pub(crate) async fn device() -> Result<(wgpu::Device, wgpu::Queue), String> {
    let instance = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let adapter = wgpu::Instance::new(instance).request_adapter(&Default::default());
    let adapter = adapter.await.map_err(|_| "wgpu finds no driver")?;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("application"),
        required_features: Gpu::useful_features(&adapter),
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let device = adapter.request_device(&descriptor).await;
    device.map_err(|error| error.to_string())
}

/// A texture to draw into, and to use as `usage` says.
pub(crate) fn texture(
    device: &wgpu::Device,
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("application"),
        size: wgpu::Extent3d {
            width: SIZE.0,
            height: SIZE.1,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// Clears both targets, color and depth, and draws the ball.
pub(crate) fn draw_ball(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    [color, depth]: [&wgpu::TextureView; 2],
    clip_from_world: DMat4,
) {
    let pipeline = pipeline(device);
    let numbers = clip_from_world.as_mat4().to_cols_array();
    let uniform = device.create_buffer_init(&BufferInitDescriptor {
        label: Some("ball"),
        contents: &numbers.map(f32::to_le_bytes).concat(),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("ball"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: uniform.as_entire_binding(),
        }],
    });
    let background = wgpu::Color {
        r: 0.012,
        g: 0.015,
        b: 0.025,
        a: 1.0,
    };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("ball"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                load: LoadOp::Clear(background),
                store: StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(Operations {
                load: LoadOp::Clear(1.0),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..VERTICES, 0..1);
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("ball.wgsl"));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("ball"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs"),
            compilation_options: Default::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
