//! Resources that the frames of a renderer share: textures that are kept, and the passes between what a
//! renderer draws and its target.
//!
//! A renderer blends what each cell, slab or segment adds into [`Sums`]; [`Canvas::put`] then
//! puts them over the background or over what is there (`resolve.wgsl`), or among what an
//! application has drawn (`among.wgsl`). [`Canvas::ends`] says where rays meet that (`ends.wgsl`).

use std::sync::{Mutex, OnceLock, PoisonError};

use tetrascope_core::glam::{DMat4, DVec3, DVec4};
use tetrascope_core::{Error, OpticalModel, View};
use tetrascope_f32::{ImagePlane, Normalization};
use tetrascope_shaders::gather::{AMONG, ENDS, RESOLVE};
use wgpu::{
    BindGroupLayout, BindingResource, BindingType, BlendFactor, BlendOperation, BlendState,
    BufferUsages, CommandEncoder, CompareFunction, LoadOp, Operations, RenderPipeline,
    ShaderStages, StoreOp, Texture, TextureAspect, TextureFormat, TextureUsages, TextureView,
};

use crate::Gpu;
use crate::draw::{Over, SceneDepth, Target};
use crate::gather::blend;
use crate::passes::{TEXELS, UNIFORM, group, model_constant};
use crate::pipelines::RenderProgram;

/// The distance where there is no surface: farther away than any. Infinity is nothing to count
/// on.
pub const NOWHERE: f32 = 3e38;

/// The format of what is read back.
const IMAGE: TextureFormat = TextureFormat::Rgba32Float;

/// The mirror of `Resolve` in `resolve.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct Resolve {
    /// Linear RGBA, premultiplied.
    background: [f32; 4],
}

/// The mirror of `Occluder` in `gather/scene.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct Occluder {
    clip_z: [f32; 4],
    clip_w: [f32; 4],
    extent: [f32; 2],
    slope: [f32; 2],
    size: [f32; 2],
    cleared: f32,
    unused: f32,
}

/// Textures in which a volume's parts add up, as large as the view.
#[derive(Clone, Debug)]
pub struct Sums {
    /// Light and opacity, or as the optical model has it, in a format that the renderer chooses.
    pub color: Texture,
    /// Distances of isosurfaces: R32Float, normalized units from where rays start, or [`NOWHERE`].
    pub distances: Option<Texture>,
}

/// How a renderer's sums are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SumsKind {
    /// The format of the colors.
    pub format: TextureFormat,
    /// How both textures are written: drawn or stored to.
    pub usage: TextureUsages,
    /// Whether there are distances.
    pub distances: bool,
}

/// The kinds of targets that sums are put into, each by a pass of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PutKind {
    model: OpticalModel,
    format: TextureFormat,
    over: Over,
    /// For isosurfaces among an application's geometry: its depth's format, and which is nearer.
    depth: Option<(TextureFormat, CompareFunction)>,
}

/// The device, and what frames share. Its textures are those of the last frame, for the next of
/// the same size.
#[derive(Debug)]
pub struct Canvas {
    gpu: Gpu,
    image: Mutex<Option<Texture>>,
    sums: Mutex<Option<(SumsKind, Sums)>>,
    puts: Mutex<Vec<(PutKind, Pass)>>,
    ends: OnceLock<Pass>,
    end_depths: Mutex<Option<Texture>>,
    /// Bound where rays end nowhere.
    no_ends: Texture,
}

/// A pass over the whole image.
#[derive(Clone, Debug)]
struct Pass {
    layout: BindGroupLayout,
    pipeline: RenderPipeline,
}

impl Canvas {
    /// Makes a canvas for a new renderer; passes are compiled when they are first needed.
    pub fn new(gpu: &Gpu) -> Result<Canvas, Error> {
        let usage = TextureUsages::TEXTURE_BINDING;
        Ok(Canvas {
            no_ends: gpu.texture("of no depths", (1, 1), TextureFormat::R32Float, usage)?,
            gpu: gpu.clone(),
            image: Mutex::new(None),
            sums: Mutex::new(None),
            puts: Mutex::new(Vec::new()),
            ends: OnceLock::new(),
            end_depths: Mutex::new(None),
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The texture that is read back.
    pub(crate) fn image(&self, size: (u32, u32)) -> Result<Texture, Error> {
        kept(
            &self.image,
            |t| (t.width(), t.height()) == size,
            || {
                let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
                self.gpu.texture("to read back", size, IMAGE, usage)
            },
        )
    }

    /// The textures in which the parts of a volume add up; their contents are the last frame's.
    pub fn sums(&self, view: &View, kind: SumsKind) -> Result<Sums, Error> {
        let size = (view.width, view.height);
        let fits = |(of, sums): &(SumsKind, Sums)| {
            *of == kind && (sums.color.width(), sums.color.height()) == size
        };
        let (_, sums) = kept(&self.sums, fits, || {
            let read = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
            let texture = |label, format| self.gpu.texture(label, size, format, kind.usage | read);
            let distances = || texture("of distances", TextureFormat::R32Float);
            let sums = Sums {
                color: texture("of sums", kind.format)?,
                distances: kind.distances.then(distances).transpose()?,
            };
            Ok((kind, sums))
        })?;
        Ok(sums)
    }

    /// Records what puts `sums` of `model` into `target`.
    pub fn put(
        &self,
        encoder: &mut CommandEncoder,
        view: &View,
        normalization: &Normalization,
        (model, sums): (OpticalModel, &Sums),
        target: &Target,
    ) -> Result<(), Error> {
        let gpu = &self.gpu;
        let label = "gpu::put";
        let color = sums.color.create_view(&Default::default());
        let background = view.premultiplied_background();
        let among = target.depth.as_ref().zip(sums.distances.as_ref());
        let scene = among.map(|(depth, _)| Occluder::new(view, normalization, 0.0, depth));
        let pass = self.put_pass(PutKind {
            model,
            format: target.format,
            over: target.over,
            depth: among
                .zip(scene)
                .map(|((depth, _), scene)| (depth.texture.format(), scene.nearer())),
        })?;
        let uniform = match &scene {
            Some(scene) => gpu.upload(label, &[*scene], BufferUsages::UNIFORM)?,
            None => {
                // What is there counts when it is blended.
                let background = match target.over {
                    Over::Background => background.map(|c| c as f32),
                    Over::WhatIsThere => [0.0; 4],
                };
                gpu.upload(label, &[Resolve { background }], BufferUsages::UNIFORM)?
            }
        };
        gpu.checked(label, 0, || {
            let mut resources = vec![
                uniform.as_entire_binding(),
                BindingResource::TextureView(&color),
            ];
            let distances = among.map(|(_, d)| d.create_view(&Default::default()));
            resources.extend(distances.as_ref().map(BindingResource::TextureView));
            let load = match (target.over, among) {
                (Over::WhatIsThere, _) => LoadOp::Load,
                // All of it is written.
                (Over::Background, None) => LoadOp::Clear(wgpu::Color::TRANSPARENT),
                (Over::Background, Some(_)) => {
                    let [r, g, b, a] = background;
                    LoadOp::Clear(wgpu::Color { r, g, b, a })
                }
            };
            let depth = among.map(|(depth, _)| {
                let view = depth.texture.create_view(&Default::default());
                (view, depth.texture.format().has_stencil_aspect())
            });
            let mut recorded = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target.color,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations {
                        load,
                        store: StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: depth.as_ref().map(|(view, has_stencil)| {
                    wgpu::RenderPassDepthStencilAttachment {
                        view,
                        depth_ops: Some(Operations {
                            load: LoadOp::Load,
                            store: StoreOp::Store,
                        }),
                        stencil_ops: has_stencil.then_some(Operations {
                            load: LoadOp::Load,
                            store: StoreOp::Store,
                        }),
                    }
                }),
                ..Default::default()
            });
            pass.draw(gpu, label, &mut recorded, &resources);
        })
    }

    /// Records what shows a volume that is transparent: the background, or no command where it is
    /// drawn over what is there. Returns the number of passes.
    pub fn put_nothing(
        &self,
        encoder: &mut CommandEncoder,
        view: &View,
        target: &Target,
    ) -> Result<u64, Error> {
        if target.over == Over::WhatIsThere {
            return Ok(0);
        }
        let label = "gpu::put_nothing";
        let [r, g, b, a] = view.premultiplied_background();
        self.gpu.checked(label, 0, || {
            encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target.color,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations {
                        load: LoadOp::Clear(wgpu::Color { r, g, b, a }),
                        store: StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
        })?;
        Ok(1)
    }

    /// Where rays end in `depth`, R32Float: depths in camera space, from `anchor_depth` before the
    /// eye on, normalized units; one texel that is not to be read without `depth`. With whether
    /// there is any.
    pub fn ends(
        &self,
        encoder: &mut CommandEncoder,
        view: &View,
        normalization: &Normalization,
        anchor_depth: f64,
        depth: Option<&SceneDepth>,
    ) -> Result<(TextureView, bool), Error> {
        let Some(depth) = depth else {
            return Ok((self.no_ends.create_view(&Default::default()), false));
        };
        let gpu = &self.gpu;
        let label = "gpu::ends";
        let size = (view.width, view.height);
        let texture = kept(
            &self.end_depths,
            |t| (t.width(), t.height()) == size,
            || {
                let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
                gpu.texture("of rays' ends", size, TextureFormat::R32Float, usage)
            },
        )?;
        let ends = texture.create_view(&Default::default());
        let pass = match self.ends.get() {
            Some(pass) => pass,
            None => {
                let made = Pass::new(
                    gpu,
                    &PassKind {
                        label,
                        program: ENDS,
                        vertex: "vs_scene",
                        fragment: "fs_ends",
                        types: &[UNIFORM, DEPTHS],
                        constants: &[],
                        target: TextureFormat::R32Float.into(),
                        depth: None,
                    },
                )?;
                self.ends.get_or_init(|| made)
            }
        };
        let scene = [Occluder::new(view, normalization, anchor_depth, depth)];
        let uniform = gpu.upload(label, &scene, BufferUsages::UNIFORM)?;
        gpu.checked(label, 0, || {
            let depths = depth.texture.create_view(&wgpu::TextureViewDescriptor {
                aspect: TextureAspect::DepthOnly,
                ..Default::default()
            });
            let resources = [
                uniform.as_entire_binding(),
                BindingResource::TextureView(&depths),
            ];
            let mut recorded = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &ends,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations {
                        load: LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            pass.draw(gpu, label, &mut recorded, &resources);
        })?;
        Ok((ends, true))
    }

    fn put_pass(&self, kind: PutKind) -> Result<Pass, Error> {
        let mut puts = self.puts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, pass)) = puts.iter().find(|(of, _)| *of == kind) {
            return Ok(pass.clone());
        }
        let target = wgpu::ColorTargetState {
            format: kind.format,
            blend: (kind.over == Over::WhatIsThere).then(|| over(kind.model)),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let pass = match kind.depth {
            None => Pass::new(
                &self.gpu,
                &PassKind {
                    label: "gpu::resolve",
                    program: RESOLVE,
                    vertex: "vs_resolve",
                    fragment: "fs_resolve",
                    types: &[UNIFORM, TEXELS],
                    constants: &[model_constant(kind.model)],
                    target,
                    depth: None,
                },
            )?,
            Some(depth) => Pass::new(
                &self.gpu,
                &PassKind {
                    label: "gpu::among",
                    program: AMONG,
                    vertex: "vs_scene",
                    fragment: "fs_among",
                    types: &[UNIFORM, TEXELS, TEXELS],
                    constants: &[],
                    // Surfaces are opaque.
                    target: kind.format.into(),
                    depth: Some(depth),
                },
            )?,
        };
        puts.push((kind, pass.clone()));
        Ok(pass)
    }
}

/// Takes what is in `slot` if it fits, else what `make` makes, and keeps it there.
fn kept<T: Clone>(
    slot: &Mutex<Option<T>>,
    fits: impl FnOnce(&T) -> bool,
    make: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    // What does not fit goes first: two may need more memory than there is.
    let found = slot.take().filter(fits);
    let found = found.map_or_else(make, Ok)?;
    *slot = Some(found.clone());
    Ok(found)
}

/// A depth texture that shaders read texel by texel.
const DEPTHS: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Depth,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// How sums are blended over what is there.
fn over(model: OpticalModel) -> BlendState {
    match model {
        OpticalModel::Emission | OpticalModel::MaximumIntensity => blend(model),
        _ => {
            let component = wgpu::BlendComponent {
                src_factor: BlendFactor::One,
                dst_factor: BlendFactor::OneMinusSrcAlpha,
                operation: BlendOperation::Add,
            };
            BlendState {
                color: component,
                alpha: component,
            }
        }
    }
}

/// How a [`Pass`] is made.
struct PassKind<'a> {
    label: &'static str,
    program: &'static str,
    vertex: &'static str,
    fragment: &'static str,
    types: &'a [BindingType],
    constants: &'a [(&'static str, f64)],
    target: wgpu::ColorTargetState,
    depth: Option<(TextureFormat, CompareFunction)>,
}

impl Pass {
    fn new(gpu: &Gpu, kind: &PassKind) -> Result<Pass, Error> {
        let layout = gpu.layout(kind.label, ShaderStages::FRAGMENT, kind.types)?;
        let pipeline = gpu.render_pipeline(&RenderProgram {
            label: kind.label,
            source: kind.program,
            vertex: kind.vertex,
            fragment: Some(kind.fragment),
            constants: kind.constants.to_vec(),
            targets: vec![Some(kind.target.clone())],
            groups: vec![layout.clone()],
            depth: kind.depth.map(|(format, nearer)| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(nearer),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            ..Default::default()
        })?;
        Ok(Pass { layout, pipeline })
    }

    /// Draws with `resources` in group 0.
    fn draw(
        &self,
        gpu: &Gpu,
        label: &str,
        pass: &mut wgpu::RenderPass,
        resources: &[BindingResource],
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group(gpu, label, &self.layout, resources), &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Occluder {
    /// For camera space with its anchor this far before the eye.
    fn new(
        view: &View,
        normalization: &Normalization,
        anchor_depth: f64,
        depth: &SceneDepth,
    ) -> Occluder {
        let plane = ImagePlane::new(view, normalization);
        let anchor = plane.eye + anchor_depth * plane.forward;
        let anchor = anchor * normalization.scale + normalization.center;
        let axis = |axis: DVec3| (axis * normalization.scale).extend(0.0);
        let world_from_camera = DMat4::from_cols(
            axis(plane.right),
            axis(plane.up),
            axis(plane.forward),
            anchor.extend(1.0),
        );
        let clip = depth.clip_from_world * world_from_camera;
        let (z, w) = (clip.row(2), clip.row(3));
        // Only their ratio counts: the greatest number becomes 1.
        let greatest = z.abs().max_element().max(w.abs().max_element());
        let single = |row: DVec4| (row / greatest).as_vec4().to_array();
        let pair = |pair: [f64; 2]| pair.map(|x| x as f32);
        Occluder {
            clip_z: single(z),
            clip_w: single(w),
            extent: pair(plane.extent_at(anchor_depth)),
            slope: pair(plane.slope),
            size: [view.width as f32, view.height as f32],
            // On the axis, the derivative of z / w by depth has the sign of this.
            cleared: match z.z * w.w - z.w * w.z < 0.0 {
                true => 0.0,
                false => 1.0,
            },
            unused: 0.0,
        }
    }

    /// Which depths are nearer than others.
    fn nearer(&self) -> CompareFunction {
        match self.cleared == 0.0 {
            true => CompareFunction::Greater,
            false => CompareFunction::Less,
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        assert_layout!(RESOLVE, Resolve { background });
        for program in [ENDS, AMONG] {
            assert_layout!(
                program,
                Occluder {
                    clip_z,
                    clip_w,
                    extent,
                    slope,
                    size,
                    cleared,
                    unused
                }
            );
        }
    }
}
