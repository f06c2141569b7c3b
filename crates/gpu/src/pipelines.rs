//! Compiled pipelines. A device compiles equal programs once, whoever asks: so a renderer that is
//! restyled, or built again, compiles only what differs.

use std::sync::{MutexGuard, PoisonError};

use tetrascope_core::Error;
use wgpu::{
    BindGroupLayout, BindingType, ColorTargetState, ComputePipeline, DepthStencilState,
    RenderPipeline, ShaderModule, ShaderStages, VertexBufferLayout,
};

use crate::Gpu;

/// Programs of each kind that a device keeps; then those that were used longest ago go.
const MOST: usize = 128;

/// The name of an `override` and its value.
pub type Constant = (&'static str, f64);

/// The source of a render pipeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderProgram {
    /// For the driver's messages.
    pub label: &'static str,
    /// WGSL.
    pub source: &'static str,
    /// The entry point of the vertex stage.
    pub vertex: &'static str,
    /// The constants of that stage.
    pub vertex_constants: Vec<Constant>,
    /// Its buffers.
    pub buffers: Vec<Option<VertexBufferLayout<'static>>>,
    /// The entry point of the fragment stage, if there is one.
    pub fragment: Option<&'static str>,
    /// The constants of that stage.
    pub constants: Vec<Constant>,
    /// The targets that it writes.
    pub targets: Vec<Option<ColorTargetState>>,
    /// Layouts of bind groups, from group 0 on; empty for what the program declares.
    pub groups: Vec<BindGroupLayout>,
    /// The depth test.
    pub depth: Option<DepthStencilState>,
    /// Which triangles are left out.
    pub cull_mode: Option<wgpu::Face>,
}

/// The source of a compute pipeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComputeProgram {
    /// For the driver's messages.
    pub label: &'static str,
    /// WGSL.
    pub source: &'static str,
    /// The entry point; the only one if `None`.
    pub entry: Option<&'static str>,
    /// The entry point's constants.
    pub constants: Vec<Constant>,
    /// Layouts of bind groups, from group 0 on; empty for what the program declares.
    pub groups: Vec<BindGroupLayout>,
}

/// The programs that a device has compiled.
#[derive(Debug, Default)]
pub(crate) struct Compiled {
    modules: Kept<&'static str, ShaderModule>,
    layouts: Kept<(ShaderStages, Vec<BindingType>), BindGroupLayout>,
    render: Kept<RenderProgram, RenderPipeline>,
    compute: Kept<ComputeProgram, ComputePipeline>,
    count: u64,
}

/// Pairs, the one used last at the end.
#[derive(Debug)]
struct Kept<K, V>(Vec<(K, V)>);

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Kept(Vec::new())
    }
}

impl<K: PartialEq, V: Clone> Kept<K, V> {
    fn get(&mut self, key: &K) -> Option<V> {
        let place = self.0.iter().rposition(|(k, _)| k == key)?;
        self.0[place..].rotate_left(1);
        self.0.last().map(|(_, value)| value.clone())
    }

    fn keep(&mut self, key: K, value: &V) {
        if self.0.len() == MOST {
            self.0.remove(0);
        }
        self.0.push((key, value.clone()));
    }
}

impl Gpu {
    /// The pipeline of `program`, compiled unless it was.
    ///
    /// # Errors
    /// Refusals of the device.
    pub fn render_pipeline(&self, program: &RenderProgram) -> Result<RenderPipeline, Error> {
        let known = self.known().render.get(program);
        if let Some(pipeline) = known {
            return Ok(pipeline);
        }
        let module = self.module(program.label, program.source)?;
        let with = |constants| wgpu::PipelineCompilationOptions {
            constants,
            ..Default::default()
        };
        let pipeline = self.checked(program.label, 0, || {
            let layout = self.pipeline_layout(program.label, &program.groups);
            let descriptor = wgpu::RenderPipelineDescriptor {
                label: Some(program.label),
                layout: layout.as_ref(),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(program.vertex),
                    compilation_options: with(&program.vertex_constants),
                    buffers: &program.buffers,
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: program.cull_mode,
                    ..Default::default()
                },
                depth_stencil: program.depth.clone(),
                multisample: Default::default(),
                fragment: program.fragment.map(|entry| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: with(&program.constants),
                    targets: &program.targets,
                }),
                multiview_mask: None,
                cache: None,
            };
            self.device().create_render_pipeline(&descriptor)
        })?;
        let mut known = self.known();
        known.count += 1;
        known.render.keep(program.clone(), &pipeline);
        Ok(pipeline)
    }

    /// The pipeline of `program`, compiled unless it was.
    ///
    /// # Errors
    /// Refusals of the device.
    pub fn compute_pipeline(&self, program: &ComputeProgram) -> Result<ComputePipeline, Error> {
        let known = self.known().compute.get(program);
        if let Some(pipeline) = known {
            return Ok(pipeline);
        }
        let module = self.module(program.label, program.source)?;
        let pipeline = self.checked(program.label, 0, || {
            let layout = self.pipeline_layout(program.label, &program.groups);
            let descriptor = wgpu::ComputePipelineDescriptor {
                label: Some(program.label),
                layout: layout.as_ref(),
                module: &module,
                entry_point: program.entry,
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &program.constants,
                    ..Default::default()
                },
                cache: None,
            };
            self.device().create_compute_pipeline(&descriptor)
        })?;
        let mut known = self.known();
        known.count += 1;
        known.compute.keep(program.clone(), &pipeline);
        Ok(pipeline)
    }

    /// The layout of a bind group that stages `visibility` see: one buffer, or other resource, for
    /// each of `types`.
    ///
    /// # Errors
    /// Refusals of the device.
    pub fn layout(
        &self,
        label: &str,
        visibility: ShaderStages,
        types: &[BindingType],
    ) -> Result<BindGroupLayout, Error> {
        let key = (visibility, types.to_vec());
        let known = self.known().layouts.get(&key);
        if let Some(layout) = known {
            return Ok(layout);
        }
        let entries: Vec<_> = (0..)
            .zip(types)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility,
                ty: *ty,
                count: None,
            })
            .collect();
        let layout = self.checked(label, 0, || {
            let descriptor = wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            };
            self.device().create_bind_group_layout(&descriptor)
        })?;
        self.known().layouts.keep(key, &layout);
        Ok(layout)
    }

    /// How many pipelines were compiled on this device.
    pub fn compiled_pipelines(&self) -> u64 {
        self.known().count
    }

    fn module(&self, label: &str, source: &'static str) -> Result<ShaderModule, Error> {
        let known = self.known().modules.get(&source);
        if let Some(module) = known {
            return Ok(module);
        }
        let module = self.checked(label, 0, || {
            let descriptor = wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            };
            self.device().create_shader_module(descriptor)
        })?;
        self.known().modules.keep(source, &module);
        Ok(module)
    }

    fn pipeline_layout(
        &self,
        label: &str,
        groups: &[BindGroupLayout],
    ) -> Option<wgpu::PipelineLayout> {
        let groups: Vec<_> = groups.iter().map(Some).collect();
        let descriptor = wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        };
        let layout = || self.device().create_pipeline_layout(&descriptor);
        (!groups.is_empty()).then(layout)
    }

    fn known(&self) -> MutexGuard<'_, Compiled> {
        let known = self.compiled().lock();
        known.unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::WRITE;

    const SOURCE: &str = "override FACTOR: u32 = 1u;
        @group(0) @binding(0) var<storage, read_write> x: array<u32>;
        @compute @workgroup_size(1) fn cs_multiply() { x[0] *= FACTOR; }";

    #[test]
    fn equal_programs_are_compiled_once() {
        let Some(gpu) = crate::testing::gpu("equal_programs_are_compiled_once") else {
            return;
        };
        let with = |factor: f64| ComputeProgram {
            label: "multiply",
            source: SOURCE,
            constants: vec![("FACTOR", factor)],
            groups: vec![
                gpu.layout("multiply", ShaderStages::COMPUTE, &[WRITE])
                    .expect("one buffer"),
            ],
            ..Default::default()
        };
        let before = gpu.compiled_pipelines();
        let first = gpu.compute_pipeline(&with(2.0)).expect("compiles");
        assert_eq!(gpu.compute_pipeline(&with(2.0)).expect("is there"), first);
        assert_eq!(gpu.compiled_pipelines(), before + 1);
        assert_ne!(gpu.compute_pipeline(&with(3.0)).expect("compiles"), first);
        assert_eq!(gpu.compiled_pipelines(), before + 2);
        // What is refused is not kept.
        let mut wrong = with(2.0);
        wrong.entry = Some("cs_divide");
        for _ in 0..2 {
            assert!(gpu.compute_pipeline(&wrong).is_err());
        }
        assert_eq!(gpu.compiled_pipelines(), before + 2);
    }

    #[test]
    fn what_was_used_longest_ago_goes_first() {
        let mut kept = Kept::default();
        for key in 0..MOST {
            kept.keep(key, &key);
        }
        assert_eq!(kept.get(&0), Some(0));
        kept.keep(MOST, &MOST);
        assert_eq!(kept.get(&1), None);
        assert_eq!(kept.get(&0), Some(0));
        assert_eq!(kept.0.len(), MOST);
    }
}
