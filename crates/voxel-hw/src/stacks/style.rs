//! The data that `restyle` replaces: an appearance on the device.

use tetrascope_core::grid::coverage::fades;
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{ANY_SCALAR, ScalarMap, deepest, is_transparent};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, deep, group, look_constants, model_constant};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{Gpu, RenderProgram};
use tetrascope_shaders::stacks::RECTANGLE;

use super::volume::{LAYERS, Layers};
use super::{Integration, LABEL, StacksOptions};

/// Layouts of bind groups.
#[derive(Debug)]
pub(super) struct Layouts {
    pub(super) frame: wgpu::BindGroupLayout,
    volume: wgpu::BindGroupLayout,
}

/// An appearance on the device.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    pub(super) map: ScalarMap,
    /// The base and the unit of `map`, in f32.
    pub(super) scale: (f32, f32),
    /// Whether nothing shows.
    pub(super) is_transparent: bool,
    /// The transfer function with each of the stacks.
    pub(super) volumes: [wgpu::BindGroup; 3],
    intervals: wgpu::Buffer,
    program: RenderProgram,
    pipeline: wgpu::RenderPipeline,
}

impl Layouts {
    pub(super) fn new(gpu: &Gpu) -> Result<Layouts, Error> {
        let stages = ShaderStages::VERTEX_FRAGMENT;
        Ok(Layouts {
            frame: gpu.layout(LABEL, stages, &[UNIFORM, UNIFORM, TEXELS])?,
            volume: gpu.layout(LABEL, ShaderStages::FRAGMENT, &[READ, LAYERS])?,
        })
    }
}

impl Style {
    pub(super) fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        layers: &Layers,
        appearance: &Appearance,
        options: &StacksOptions,
    ) -> Result<Style, Error> {
        let (grid, model) = (&layers.grid, appearance.optical_model);
        let transfer_function = &appearance.transfer_function;
        let map = ScalarMap::of(transfer_function).in_f32();
        let knots = knot_pairs(transfer_function, &map, &layers.normalization)?;
        let range = grid.scalar_range();
        let scalars = range.map_or(ANY_SCALAR, |range| map.range(Some(range)));
        // A ray along the planes may be in one slab all the way.
        let longest = grid.lattice().bounds().diagonal() / layers.normalization.scale;
        let deepest = deepest(&knots, scalars, longest as f32);
        let intervals = gpu.upload("stacks::knots", &knots, BufferUsages::STORAGE)?;
        let volumes = gpu.checked(LABEL, 0, || {
            [0, 1, 2].map(|axis| {
                let stack = &layers.stacks[axis].texture;
                let view = stack.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                });
                let resources = [
                    intervals.as_entire_binding(),
                    wgpu::BindingResource::TextureView(&view),
                ];
                group(gpu, LABEL, &layouts.volume, &resources)
            })
        })?;
        let yes = |condition: bool| f64::from(u8::from(condition));
        let slabs = ("SLABS", yes(options.integration == Integration::Slabs));
        let covered = grid.texels() == Texels::Covered;
        let mut constants = look_constants(appearance).to_vec();
        constants.extend([
            model_constant(model),
            deep(deepest),
            ("COVERED", yes(covered)),
            ("ALL_OR_NOTHING", yes(covered && !fades(model))),
        ]);
        let program = RenderProgram {
            label: LABEL,
            source: RECTANGLE,
            vertex: "vs_rectangle",
            vertex_constants: vec![slabs],
            fragment: Some(match options.integration {
                Integration::Slices => "fs_slice",
                Integration::Slabs => "fs_slab",
            }),
            constants,
            targets: vec![Some(wgpu::ColorTargetState {
                format: gathered_format(gpu, model),
                blend: Some(blend(model)),
                write_mask: wgpu::ColorWrites::ALL,
            })],
            groups: vec![layouts.frame.clone(), layouts.volume.clone()],
            ..Default::default()
        };
        Ok(Style {
            appearance: appearance.clone(),
            scale: (map.low() as f32, map.unit() as f32),
            map,
            is_transparent: is_transparent(model, deepest),
            volumes,
            intervals,
            pipeline: gpu.render_pipeline(&program)?,
            program,
        })
    }

    /// With `ends` for rays that end before an application's geometry.
    pub(super) fn pipeline(&self, gpu: &Gpu, ends: bool) -> Result<wgpu::RenderPipeline, Error> {
        if !ends {
            return Ok(self.pipeline.clone());
        }
        let mut program = self.program.clone();
        program.constants.push(("ENDS", 1.0));
        gpu.render_pipeline(&program)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.intervals.size()
    }
}
