//! The passes of [`Passes::Two`] and [`Passes::One`]: `elements.wgsl` and `section.wgsl`.

use tetrascope_core::Error;
use tetrascope_gpu::memory::texture_bytes;
use tetrascope_gpu::passes::{READ, TEXELS, WRITE, group};
use tetrascope_gpu::pipelines::{ComputeProgram, Constant, RenderProgram};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages, TextureFormat, TextureUsages};
use tetrascope_gpu::{DeviceGrid, Gpu};
use tetrascope_shaders::resample::{ELEMENTS, SECTION};

use crate::direct::Tuning;
use crate::gpu_data::Work;
use crate::options::{Passes, ResamplerOptions};
use crate::placed::Placed;
use crate::slabs::{Drawn, Elements, Slabs, compute};
use crate::weights::upload;
use tetrascope_gpu::tables::{TABLE, Table, grown, holds};

const LABEL: &str = "resample::textured";

/// Scalar and coverage of a slice.
const SLICE_FORMAT: TextureFormat = TextureFormat::Rg32Float;
const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Pipelines and buffers.
#[derive(Debug)]
pub(crate) struct Textured {
    gpu: Gpu,
    passes: Passes,
    layouts: Layouts,
    pipelines: Pipelines,
    targets: Targets,
    grid: wgpu::Texture,
    slabs: Slabs,
    weights: wgpu::BindGroup,
    /// The same for the second pass where it reads what the first has drawn.
    reading: wgpu::BindGroup,
    buffers: Buffers,
    cell_count: u32,
    cell_data: bool,
}

#[derive(Debug)]
struct Layouts {
    mesh: wgpu::BindGroupLayout,
    made: wgpu::BindGroupLayout,
    drawn: wgpu::BindGroupLayout,
    weights: wgpu::BindGroupLayout,
}

/// For fields of points, and for those of cells.
#[derive(Debug)]
struct Pipelines {
    elements: [wgpu::ComputePipeline; 2],
    sections: [Sections; 2],
}

#[derive(Debug)]
struct Sections {
    first: wgpu::RenderPipeline,
    /// The second pipeline of [`Passes::Two`].
    second: Option<wgpu::RenderPipeline>,
}

/// The targets of a slice.
#[derive(Debug)]
struct Targets {
    slice: wgpu::Texture,
    /// Where the device cannot add 32-bit floats, the second pass is drawn into another target.
    second: Option<wgpu::Texture>,
    depth: wgpu::Texture,
}

/// Buffers that hold a mesh, and what is made of it. They grow, and never shrink.
#[derive(Debug)]
struct Buffers {
    work: wgpu::Buffer,
    vertices: Table,
    cells: Table,
    cell_scalars: wgpu::Buffer,
    elements: Elements,
    groups: Groups,
}

#[derive(Debug)]
struct Groups {
    mesh: wgpu::BindGroup,
    made: wgpu::BindGroup,
    drawn: wgpu::BindGroup,
}

impl Textured {
    /// Compiles the passes and uploads the mesh.
    pub(crate) fn new(
        gpu: &Gpu,
        grid: &DeviceGrid,
        placed: &Placed,
        cells: &[[u32; 4]],
        options: &ResamplerOptions,
        tuning: Tuning,
    ) -> Result<Textured, Error> {
        let passes = options.passes;
        let layouts = Layouts::new(gpu)?;
        let slabs = Slabs::new(gpu, options.slabs, grid.lattice().dims[2] as u32)?;
        let groups = layouts.of_sections(&slabs);
        let pipelines = Pipelines::new(gpu, &layouts, &groups, passes, tuning)?;
        let targets = Targets::new(gpu, grid, passes == Passes::Two && !tuning.adds)?;
        let [weights, reading] = bound_weights(gpu, &layouts, options.weights, &targets)?;
        let buffers = Buffers::new(gpu, &layouts, &slabs, None, [0; 3])?;
        let mut textured = Textured {
            gpu: gpu.clone(),
            passes,
            layouts,
            pipelines,
            targets,
            grid: grid.texture().clone(),
            slabs,
            weights,
            reading,
            buffers,
            cell_count: 0,
            cell_data: false,
        };
        textured.upload(placed, cells)?;
        Ok(textured)
    }

    /// Uploads another mesh. Buffers are made anew only where they are too small.
    pub(crate) fn upload(&mut self, placed: &Placed, cells: &[[u32; 4]]) -> Result<(), Error> {
        let gpu = &self.gpu;
        if cells.len() > MOST_CELLS {
            return Err(Error::TooLarge {
                what: "the mesh".into(),
                needed: cells.len() as u64,
                limit: MOST_CELLS as u64,
                unit: "cells in drawn slices",
            });
        }
        let needed = [
            placed.vertices.len(),
            cells.len(),
            placed.cell_scalars.len(),
        ];
        if !self.buffers.fit(needed) {
            let old = Some(&self.buffers);
            self.buffers = Buffers::new(gpu, &self.layouts, &self.slabs, old, needed)?;
        }
        let buffers = &self.buffers;
        let vertices = bytemuck::cast_slice(&placed.vertices);
        buffers.vertices.write(gpu, vertices)?;
        buffers.cells.write(gpu, bytemuck::cast_slice(cells))?;
        gpu.write(LABEL, &buffers.cell_scalars, &placed.cell_scalars)?;
        let size = self.grid.size();
        let work = Work {
            high: [size.width as i32, size.height as i32],
            end: size.depth_or_array_layers as i32,
            cell_count: cells.len() as u32,
            along: [0, 0, 1],
            across_x: [1, 0, 0],
            across_y: [0, 1, 0],
            ..Work::default()
        };
        gpu.write(LABEL, &buffers.work, &[work])?;
        buffers.elements.set_count(gpu, work.cell_count)?;
        self.cell_count = work.cell_count;
        self.cell_data = !placed.cell_scalars.is_empty();
        Ok(())
    }

    /// Records the passes.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let kind = usize::from(self.cell_data);
        let Buffers {
            groups, elements, ..
        } = &self.buffers;
        let pipeline = &self.pipelines.elements[kind];
        let made = [&groups.mesh, &groups.made];
        self.slabs.clear(encoder);
        compute(encoder, self.cell_count, pipeline, &made);
        for slab in 0..self.slabs.count() {
            self.slabs.list(encoder, elements, self.cell_count, slab);
            for slice in self.slabs.slices(slab) {
                self.draw(encoder, slab, slice);
            }
        }
    }

    /// Records one slice, and its copy into the grid.
    fn draw(&self, encoder: &mut wgpu::CommandEncoder, slab: usize, slice: u32) {
        let Targets {
            slice: target,
            second,
            depth,
        } = &self.targets;
        let sections = &self.pipelines.sections[usize::from(self.cell_data)];
        let depth_view = depth.create_view(&Default::default());
        let passes: Vec<(&wgpu::Texture, Vec<&wgpu::RenderPipeline>)> = match second {
            None => {
                let pipelines = [&sections.first].into_iter().chain(&sections.second);
                vec![(target, pipelines.collect())]
            }
            Some(other) => {
                let second = sections.second.iter().collect();
                vec![(target, vec![&sections.first]), (other, second)]
            }
        };
        for (index, (target, pipelines)) in passes.iter().enumerate() {
            let view = target.create_view(&Default::default());
            let load = match index {
                0 => wgpu::LoadOp::Clear(1.0),
                _ => wgpu::LoadOp::Load,
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(LABEL),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_view,
                    depth_ops: Some(wgpu::Operations {
                        load,
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            for pipeline in pipelines {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &self.buffers.groups.mesh, &[]);
                pass.set_bind_group(1, &self.buffers.groups.drawn, &[]);
                pass.set_bind_group(2, self.slabs.slice(slice), &[]);
                let weights = match index {
                    0 => &self.weights,
                    _ => &self.reading,
                };
                pass.set_bind_group(3, weights, &[]);
                self.slabs.draw(&mut pass, slab);
            }
        }
        let (drawn, _) = passes.last().expect("one pass at least");
        let to = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d {
                z: slice,
                ..Default::default()
            },
            ..self.grid.as_image_copy()
        };
        encoder.copy_texture_to_texture(drawn.as_image_copy(), to, drawn.size());
    }

    /// How much was drawn by the last submission.
    pub(crate) fn drawn(&self) -> Result<Drawn, Error> {
        let times = match self.passes {
            Passes::Two => 2,
            _ => 1,
        };
        self.slabs.drawn(&self.gpu, times)
    }

    /// Bytes of buffers and targets, the mesh among them.
    pub(crate) fn bytes(&self) -> u64 {
        let b = &self.buffers;
        let Targets {
            slice,
            second,
            depth,
        } = &self.targets;
        let targets = [slice, depth].into_iter().chain(second);
        targets.map(texture_bytes).sum::<u64>()
            + b.vertices.bytes()
            + b.cells.bytes()
            + b.cell_scalars.size()
            + b.elements.bytes()
    }
}

/// The most cells: half of the floats from 2⁻⁶⁴ to 1, which are their depths.
const MOST_CELLS: usize = 1 << 28;

impl Layouts {
    fn new(gpu: &Gpu) -> Result<Layouts, Error> {
        let compute = ShaderStages::COMPUTE;
        let (vertex, fragment) = (ShaderStages::VERTEX, ShaderStages::FRAGMENT);
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
        Ok(Layouts {
            mesh: gpu.layout(LABEL, compute | vertex, &[READ, TABLE, TABLE, READ])?,
            made: gpu.layout(LABEL, compute, &[WRITE, WRITE])?,
            drawn: gpu.layout(LABEL, vertex, &[READ, READ])?,
            weights: gpu.layout(LABEL, fragment, &[TEXELS, TEXELS, sampler, TEXELS])?,
        })
    }

    /// Those of `section.wgsl`.
    fn of_sections(&self, slabs: &Slabs) -> [wgpu::BindGroupLayout; 4] {
        let Layouts {
            mesh,
            drawn,
            weights,
            ..
        } = self;
        [mesh, drawn, slabs.slice_layout(), weights].map(Clone::clone)
    }
}

impl Pipelines {
    fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        of_sections: &[wgpu::BindGroupLayout],
        passes: Passes,
        tuning: Tuning,
    ) -> Result<Pipelines, Error> {
        let elements = |cell_data: f64| {
            gpu.compute_pipeline(&ComputeProgram {
                label: LABEL,
                source: ELEMENTS,
                entry: None,
                constants: vec![("CELL_DATA", cell_data)],
                groups: vec![layouts.mesh.clone(), layouts.made.clone()],
            })
        };
        let rounded = ("ROUNDED", tuning.rounded);
        let section = |cell_data: Constant, fragment, blend, compare, writes| {
            gpu.render_pipeline(&RenderProgram {
                label: LABEL,
                source: SECTION,
                vertex: "vs_section",
                vertex_constants: vec![cell_data, rounded],
                fragment: Some(fragment),
                constants: vec![rounded],
                targets: vec![Some(wgpu::ColorTargetState {
                    format: SLICE_FORMAT,
                    blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
                groups: of_sections.to_vec(),
                depth: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(writes),
                    depth_compare: Some(compare),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                // Fans are counterclockwise with y upwards; rows of a target go down. What rounding
                // turns over is covered by the rest of the fan.
                cull_mode: Some(wgpu::Face::Front),
                ..Default::default()
            })
        };
        let sections = |cell_data: f64| -> Result<Sections, Error> {
            let cell_data = ("CELL_DATA", cell_data);
            let less = wgpu::CompareFunction::Less;
            Ok(match passes {
                Passes::Two => {
                    let (fragment, blend) = match tuning.adds {
                        true => ("fs_back", Some(ADDED)),
                        false => ("fs_back_added", None),
                    };
                    let equal = wgpu::CompareFunction::Equal;
                    Sections {
                        first: section(cell_data, "fs_front", None, less, true)?,
                        second: Some(section(cell_data, fragment, blend, equal, false)?),
                    }
                }
                _ => Sections {
                    first: section(cell_data, "fs_both", None, less, true)?,
                    second: None,
                },
            })
        };
        Ok(Pipelines {
            elements: [elements(0.0)?, elements(1.0)?],
            sections: [sections(0.0)?, sections(1.0)?],
        })
    }
}

/// Incoming fragments are added to what is there.
const ADDED: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
};

impl Targets {
    fn new(gpu: &Gpu, grid: &DeviceGrid, with_second: bool) -> Result<Targets, Error> {
        let size = (grid.texture().width(), grid.texture().height());
        let usage = TextureUsages::RENDER_ATTACHMENT;
        let read = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let slice = || gpu.texture("resample::slice", size, SLICE_FORMAT, usage | read);
        Ok(Targets {
            slice: slice()?,
            second: with_second.then(slice).transpose()?,
            depth: gpu.texture("resample::slice depth", size, DEPTH_FORMAT, usage)?,
        })
    }
}

/// T1, T2 and how they are sampled, and the first pass's target where the second reads it: first
/// without, then with that.
fn bound_weights(
    gpu: &Gpu,
    layouts: &Layouts,
    side: u32,
    targets: &Targets,
) -> Result<[wgpu::BindGroup; 2], Error> {
    let ([of_back, of_front], nearest) = upload(gpu, side)?;
    let usage = TextureUsages::TEXTURE_BINDING;
    // Not to be read.
    let none = gpu.texture("resample::no slice", (1, 1), SLICE_FORMAT, usage)?;
    let first = match &targets.second {
        Some(_) => targets.slice.clone(),
        None => none.clone(),
    };
    gpu.checked(LABEL, 0, || {
        [none, first].map(|first| {
            let views = [&of_back, &of_front, &first].map(|t| t.create_view(&Default::default()));
            let [of_back, of_front, first] = &views;
            let resources = [
                wgpu::BindingResource::TextureView(of_back),
                wgpu::BindingResource::TextureView(of_front),
                wgpu::BindingResource::Sampler(&nearest),
                wgpu::BindingResource::TextureView(first),
            ];
            group(gpu, LABEL, &layouts.weights, &resources)
        })
    })
}

impl Buffers {
    /// Buffers for so many vertices, cells and scalars of cells, or a little more than `old` has
    /// where that is not enough.
    fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        slabs: &Slabs,
        old: Option<&Buffers>,
        [vertices, cells, cell_scalars]: [usize; 3],
    ) -> Result<Buffers, Error> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = |label: &str, size: (usize, usize), old: Option<&wgpu::Buffer>| {
            grown(gpu, label, size, usage, old)
        };
        let table =
            |label: &str, texels: usize, old: Option<&Table>| Table::new(gpu, label, texels, old);
        let old_vertices = old.map(|o| &o.vertices);
        let old_scalars = old.map(|o| &o.cell_scalars);
        let vertices = table("resample::vertices", 2 * vertices, old_vertices)?;
        let cell_scalars = (cell_scalars, 4);
        let cell_scalars = buffer("resample::cell scalars", cell_scalars, old_scalars)?;
        let elements = Elements::new(gpu, slabs, old.map(|o| &o.elements), cells)?;
        let cells = table("resample::cells", cells, old.map(|o| &o.cells))?;
        let work = gpu.buffer("resample::work", size_of::<Work>() as u64, usage)?;
        let groups = gpu.checked(LABEL, 0, || {
            let views = [&vertices, &cells].map(Table::view);
            let [vertices, cells] = &views;
            let resources = [
                work.as_entire_binding(),
                wgpu::BindingResource::TextureView(vertices),
                wgpu::BindingResource::TextureView(cells),
                cell_scalars.as_entire_binding(),
            ];
            let mesh = group(gpu, LABEL, &layouts.mesh, &resources);
            let resources = [&elements.elements, &elements.spans].map(|b| b.as_entire_binding());
            let made = group(gpu, LABEL, &layouts.made, &resources);
            let resources = [&elements.elements, &elements.list].map(|b| b.as_entire_binding());
            let drawn = group(gpu, LABEL, &layouts.drawn, &resources);
            Groups { mesh, made, drawn }
        })?;
        Ok(Buffers {
            work,
            vertices,
            cells,
            cell_scalars,
            elements,
            groups,
        })
    }

    fn fit(&self, [vertices, cells, cell_scalars]: [usize; 3]) -> bool {
        self.vertices.texels() >= 2 * vertices as u64
            && self.cells.texels() >= cells as u64
            && self.elements.fit(cells)
            && holds(&self.cell_scalars, (cell_scalars, 4))
    }
}
