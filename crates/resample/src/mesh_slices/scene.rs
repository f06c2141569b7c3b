//! The parts that `reload` and `restyle` replace: the mesh on the device, and a look.

use tetrascope_core::mesh::Association;
use tetrascope_core::{Appearance, Error, TetMesh, is_value};
use tetrascope_f32::{ANY_SCALAR, Domain, Normalization, ScalarMap, deepest, is_transparent};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, WRITE, group, look_constants, model_constant};
use tetrascope_gpu::pipelines::{ComputeProgram, RenderProgram};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_shaders::mesh_slices::{MESH_SLICE, VIEW_ELEMENTS};

use super::LABEL;
use super::options::{Evaluation, MeshSlicesOptions, Shading};
use crate::slabs::{Elements, Slabs};
use crate::weights::upload;
use tetrascope_gpu::tables::{TABLE, Table};

/// Stands for no scalar; `NO_VALUE` of `frame.wgsl` is below.
const NO_SCALAR: f32 = f32::MAX;

/// Pipelines and layouts.
#[derive(Debug)]
pub(super) struct Programs {
    pub(super) frame_layout: wgpu::BindGroupLayout,
    volume_layout: wgpu::BindGroupLayout,
    made_layout: wgpu::BindGroupLayout,
    drawn_layout: wgpu::BindGroupLayout,
    slice_layout: wgpu::BindGroupLayout,
    /// For fields of points, and for those of cells.
    pub(super) elements: [wgpu::ComputePipeline; 2],
    /// Entry points of the vertex and the fragment stage.
    entries: [&'static str; 2],
    /// T1 and T2, and how they are sampled.
    weights: Option<([wgpu::Texture; 2], wgpu::Sampler)>,
}

/// A mesh on the device.
#[derive(Debug)]
pub(super) struct Mesh {
    pub(super) mesh: TetMesh,
    pub(super) domain: Domain,
    pub(super) normalization: Normalization,
    pub(super) map: ScalarMap,
    pub(super) cell_count: u32,
    pub(super) cell_data: bool,
    vertices: Table,
    cells: Table,
    cell_scalars: wgpu::Buffer,
    pub(super) elements: Elements,
    /// Elements as they are made, and as they are drawn.
    pub(super) made: wgpu::BindGroup,
    pub(super) drawn: wgpu::BindGroup,
}

/// An appearance on the device.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    /// Whether nothing shows.
    pub(super) is_transparent: bool,
    /// The mesh and the transfer function, as the passes read them.
    pub(super) volume: wgpu::BindGroup,
    intervals: wgpu::Buffer,
    program: RenderProgram,
    pipeline: wgpu::RenderPipeline,
}

impl Programs {
    pub(super) fn new(
        gpu: &Gpu,
        options: &MeshSlicesOptions,
        slabs: &Slabs,
    ) -> Result<Programs, Error> {
        let (compute, fragment) = (ShaderStages::COMPUTE, ShaderStages::FRAGMENT);
        let all = compute | ShaderStages::VERTEX_FRAGMENT;
        let frame_layout = gpu.layout(LABEL, all, &[UNIFORM, UNIFORM, TEXELS])?;
        let volume_layout = gpu.layout(LABEL, all, &[TABLE, TABLE, READ, READ])?;
        let made_layout = gpu.layout(LABEL, compute, &[WRITE, WRITE])?;
        let mut drawn = vec![READ, READ];
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
        let weights = match options.evaluation {
            Evaluation::PerFragment => None,
            Evaluation::Textures { weights } => {
                drawn.extend([TEXELS, TEXELS, sampler]);
                Some(upload(gpu, weights)?)
            }
        };
        let stages = ShaderStages::VERTEX | fragment;
        let drawn_layout = gpu.layout(LABEL, stages, &drawn)?;
        let elements = |cell_data: f64| {
            gpu.compute_pipeline(&ComputeProgram {
                label: LABEL,
                source: VIEW_ELEMENTS,
                entry: None,
                constants: vec![("CELL_DATA", cell_data)],
                groups: [&frame_layout, &volume_layout, &made_layout]
                    .map(Clone::clone)
                    .to_vec(),
            })
        };
        let entries = match (options.shading, options.evaluation) {
            (Shading::Post, Evaluation::PerFragment) => ["vs_mesh_slice", "fs_mesh_slice"],
            (Shading::Post, Evaluation::Textures { .. }) => {
                ["vs_mesh_slice", "fs_mesh_slice_textured"]
            }
            (Shading::Pre, Evaluation::PerFragment) => ["vs_mesh_slice_pre", "fs_mesh_slice_pre"],
            (Shading::Pre, Evaluation::Textures { .. }) => {
                ["vs_mesh_slice_pre", "fs_mesh_slice_pre_textured"]
            }
        };
        Ok(Programs {
            entries,
            elements: [elements(0.0)?, elements(1.0)?],
            slice_layout: slabs.slice_layout().clone(),
            frame_layout,
            volume_layout,
            made_layout,
            drawn_layout,
            weights,
        })
    }
}

impl Mesh {
    /// Uploads `mesh`. Elements, which every frame makes anew, are in the buffers of `old` where
    /// those are large enough; what `old` has of its mesh is left alone.
    pub(super) fn new(
        gpu: &Gpu,
        programs: &Programs,
        slabs: &Slabs,
        mesh: &TetMesh,
        (domain, map): (Domain, ScalarMap),
        old: Option<&Mesh>,
    ) -> Result<Mesh, Error> {
        let normalization = Normalization::of(&domain.bounds);
        let values = &mesh.scalars().values;
        let cell_data = mesh.scalars().association == Association::Cell;
        let stored = |scalar: f64| match is_value(scalar) {
            true => map.scalar(scalar),
            false => NO_SCALAR,
        };
        let vertex = |(index, point)| {
            let [x, y, z] = normalization.position(point).to_array();
            let scalar = if cell_data {
                0.0
            } else {
                stored(values[index])
            };
            [x, y, z, scalar]
        };
        let points = mesh.points().iter().copied().enumerate();
        let vertices: Vec<[f32; 4]> = points.map(vertex).collect();
        let cell_scalars: Vec<f32> = match cell_data {
            true => {
                let cells = 0..mesh.cell_count();
                cells.map(|c| stored(values[mesh.source_cell(c)])).collect()
            }
            false => Vec::new(),
        };
        let count = mesh.cell_count();
        let elements = Elements::new(gpu, slabs, old.map(|o| &o.elements), count)?;
        let groups = gpu.checked(LABEL, 0, || {
            let resources = [&elements.elements, &elements.spans].map(|b| b.as_entire_binding());
            let made = group(gpu, LABEL, &programs.made_layout, &resources);
            let resources = [&elements.elements, &elements.list].map(|b| b.as_entire_binding());
            let mut resources = resources.to_vec();
            let views = programs.weights.as_ref().map(|(textures, sampler)| {
                let views = [0, 1].map(|i| textures[i].create_view(&Default::default()));
                (views, sampler)
            });
            if let Some((views, sampler)) = &views {
                resources.extend(views.iter().map(wgpu::BindingResource::TextureView));
                resources.push(wgpu::BindingResource::Sampler(sampler));
            }
            (made, group(gpu, LABEL, &programs.drawn_layout, &resources))
        })?;
        elements.set_count(gpu, count as u32)?;
        let table = |label: &str, texels: &[u8]| -> Result<Table, Error> {
            let table = Table::new(gpu, label, texels.len() / 16, None)?;
            table.write(gpu, texels)?;
            Ok(table)
        };
        let label = "mesh slices::cell scalars";
        Ok(Mesh {
            vertices: table("mesh slices::vertices", bytemuck::cast_slice(&vertices))?,
            cells: table(
                "mesh slices::cells",
                bytemuck::cast_slice(mesh.tetrahedra()),
            )?,
            cell_scalars: gpu.upload(label, &cell_scalars, BufferUsages::STORAGE)?,
            elements,
            made: groups.0,
            drawn: groups.1,
            mesh: mesh.clone(),
            domain,
            normalization,
            map,
            cell_count: count as u32,
            cell_data,
        })
    }

    pub(super) fn bytes(&self) -> u64 {
        let tables = self.vertices.bytes() + self.cells.bytes();
        tables + self.cell_scalars.size() + self.elements.bytes()
    }
}

impl Style {
    pub(super) fn new(
        gpu: &Gpu,
        programs: &Programs,
        mesh: &Mesh,
        appearance: &Appearance,
    ) -> Result<Style, Error> {
        let model = appearance.optical_model;
        let knots = knot_pairs(
            &appearance.transfer_function,
            &mesh.map,
            &mesh.normalization,
        )?;
        let range = mesh.domain.scalar_range;
        let scalars = range.map_or(ANY_SCALAR, |range| mesh.map.range(Some(range)));
        // Of any length: whether there is any.
        let deepest = deepest(&knots, scalars, 1.0);
        let intervals = gpu.upload("mesh slices::knots", &knots, BufferUsages::STORAGE)?;
        let volume = gpu.checked(LABEL, 0, || {
            let views = [&mesh.vertices, &mesh.cells].map(Table::view);
            let [vertices, cells] = &views;
            let resources = [
                wgpu::BindingResource::TextureView(vertices),
                wgpu::BindingResource::TextureView(cells),
                mesh.cell_scalars.as_entire_binding(),
                intervals.as_entire_binding(),
            ];
            group(gpu, LABEL, &programs.volume_layout, &resources)
        })?;
        let mut constants = look_constants(appearance).to_vec();
        constants.push(model_constant(model));
        let [vertex, fragment] = programs.entries;
        let program = RenderProgram {
            label: LABEL,
            source: MESH_SLICE,
            vertex,
            vertex_constants: vec![("CELL_DATA", f64::from(u8::from(mesh.cell_data)))],
            fragment: Some(fragment),
            constants,
            targets: vec![Some(wgpu::ColorTargetState {
                format: gathered_format(gpu, model),
                blend: Some(blend(model)),
                write_mask: wgpu::ColorWrites::ALL,
            })],
            groups: vec![
                programs.frame_layout.clone(),
                programs.volume_layout.clone(),
                programs.drawn_layout.clone(),
                programs.slice_layout.clone(),
            ],
            // Fans are counterclockwise; what rounding turns over is covered by the rest of the fan.
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        };
        Ok(Style {
            appearance: appearance.clone(),
            is_transparent: is_transparent(model, deepest),
            volume,
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
