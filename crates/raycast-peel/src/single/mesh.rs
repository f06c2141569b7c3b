//! The mesh on the device: what `reload` changes.

use std::sync::Arc;

use tetrascope_core::glam::Vec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh};
use tetrascope_f32::{Domain, Layout, Locality, Normalization, ScalarMap, longest_edge};
use tetrascope_gpu::passes::{TEXELS, group, write_texels};
use tetrascope_gpu::wgpu::{self, ShaderStages, TextureFormat, TextureUsages};
use tetrascope_gpu::{ComputeProgram, Gpu};
use tetrascope_shaders::raycast_peel::SCALARS;

/// In place of a scalar that is not a number, as WGSL promises nothing for NaN.
/// Mapped scalars stay below 10³⁰; shaders take anything from 10³⁴ on for this.
pub(crate) const TRANSPARENT_SCALAR: f32 = 1e38;

/// Position and scalar of a vertex.
const VERTEX: TextureFormat = TextureFormat::Rgba32Float;
const SCALAR: TextureFormat = TextureFormat::R32Float;

/// Where a field's scalars are on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// With the vertices.
    Vertices,
    /// One of each cell.
    Cells,
    /// Four of each cell, as the field jumps where cells touch.
    Corners,
}

impl Kind {
    pub(crate) fn of(mesh: &TetMesh) -> Kind {
        match mesh.scalars().association {
            Association::Cell => Kind::Cells,
            Association::Point if mesh.is_continuous() => Kind::Vertices,
            Association::Point => Kind::Corners,
        }
    }
}

/// A mesh in lists of texels, with 20 bytes per cell, 16 per vertex and 16 per boundary face; and 4 per
/// cell for cell data, 16 for a field that jumps.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) source: TetMesh,
    pub(crate) domain: Domain,
    pub(crate) normalization: Normalization,
    pub(crate) scalar_map: ScalarMap,
    pub(crate) layout: Arc<Layout>,
    /// The corners of each boundary face, normalized.
    pub(crate) faces: Arc<[[Vec3; 3]]>,
    /// No ray is longer in a cell than this, normalized.
    pub(crate) longest_edge: f32,
    /// Position, and scalar of point data.
    vertices: wgpu::Texture,
    /// Scalars of each cell, for cell data and fields that jump; else a texel that nobody reads.
    scalars: wgpu::Texture,
    sums: wgpu::Texture,
    neighbors: wgpu::Texture,
    boundary: wgpu::Texture,
}

impl Mesh {
    pub(crate) fn new(
        gpu: &Gpu,
        source: &TetMesh,
        domain: Domain,
        scalar_map: ScalarMap,
        locality: Locality,
    ) -> Result<Mesh, Error> {
        let normalization = Normalization::of(&domain.bounds);
        let (layout, cells) = Layout::new(source, locality, |sum, neighbors| (sum, neighbors));
        let (sums, neighbors): (Vec<u32>, Vec<[u32; 4]>) = cells.into_iter().unzip();
        let position = |&point: &u32| normalization.position(source.points()[point as usize]);
        let positions: Vec<Vec3> = layout.vertex_order.iter().map(position).collect();
        let corners = |face: &[u32; 4]| [0, 1, 2].map(|i| positions[face[i] as usize]);
        let of_vertices = match Kind::of(source) {
            Kind::Vertices => of_vertices(source, &scalar_map, &layout),
            _ => vec![0.0; positions.len()],
        };
        let vertices = positions.iter().zip(&of_vertices);
        let vertices: Vec<[f32; 4]> = vertices.map(|(p, &s)| p.extend(s).to_array()).collect();
        let ids = TextureFormat::Rgba32Uint;
        Ok(Mesh {
            longest_edge: longest_edge(source, &normalization),
            faces: layout.boundary.iter().map(corners).collect(),
            vertices: gpu.upload_texels("of vertices", VERTEX, &vertices)?,
            scalars: of_cells(gpu, source, &scalar_map, &layout)?,
            sums: gpu.upload_texels("of cells", TextureFormat::R32Uint, &sums)?,
            neighbors: gpu.upload_texels("of neighbors", ids, &neighbors)?,
            boundary: gpu.upload_texels("of boundary faces", ids, &layout.boundary)?,
            source: source.clone(),
            domain,
            normalization,
            layout: Arc::new(layout),
            scalar_map,
        })
    }

    /// Other scalars of the same kind on the same geometry; they alone are uploaded.
    pub(crate) fn with_scalars(
        &self,
        gpu: &Gpu,
        source: &TetMesh,
        domain: Domain,
        scalar_map: ScalarMap,
    ) -> Result<Mesh, Error> {
        let mut mesh = Mesh {
            source: source.clone(),
            domain,
            scalar_map,
            ..self.clone()
        };
        match Kind::of(source) {
            Kind::Vertices => {
                let scalars = of_vertices(source, &scalar_map, &self.layout);
                let scalars = gpu.upload_texels("of scalars", SCALAR, &scalars)?;
                mesh.vertices = merged(gpu, &self.vertices, &scalars)?;
            }
            _ => mesh.scalars = of_cells(gpu, source, &scalar_map, &self.layout)?,
        }
        Ok(mesh)
    }

    /// The domain's least and greatest scalar, mapped.
    pub(crate) fn scalars(&self) -> (f32, f32) {
        self.scalar_map.range(self.domain.scalar_range)
    }

    /// The textures of group 1 of `march.wgsl`.
    pub(crate) fn textures(&self) -> [&wgpu::Texture; 5] {
        [
            &self.vertices,
            &self.scalars,
            &self.sums,
            &self.neighbors,
            &self.boundary,
        ]
    }
}

/// A scalar as shaders know it.
fn mapped(map: &ScalarMap, value: f64) -> f32 {
    match value {
        value if value.is_nan() => TRANSPARENT_SCALAR,
        value => map.scalar(value),
    }
}

/// The scalars of vertices.
fn of_vertices(source: &TetMesh, map: &ScalarMap, layout: &Layout) -> Vec<f32> {
    let values = &source.scalars().values;
    let order = layout.vertex_order.iter();
    order
        .map(|&point| mapped(map, values[point as usize]))
        .collect()
}

/// The scalars of cells.
fn of_cells(
    gpu: &Gpu,
    source: &TetMesh,
    map: &ScalarMap,
    layout: &Layout,
) -> Result<wgpu::Texture, Error> {
    let label = "of scalars";
    match Kind::of(source) {
        Kind::Vertices => gpu.upload_texels(label, SCALAR, &[0.0_f32]),
        Kind::Cells => {
            let values = &source.scalars().values;
            let order = layout.cell_order.iter();
            let cell = |&cell: &u32| mapped(map, values[source.source_cell(cell as usize)]);
            gpu.upload_texels(label, SCALAR, &order.map(cell).collect::<Vec<_>>())
        }
        Kind::Corners => {
            let cell = |cell: u32| source.cell_scalars(cell as usize).map(|s| mapped(map, s));
            gpu.upload_texels(label, VERTEX, &layout.of_corners(source, cell))
        }
    }
}

/// `vertices` with these scalars, by `scalars.wgsl`.
fn merged(
    gpu: &Gpu,
    vertices: &wgpu::Texture,
    scalars: &wgpu::Texture,
) -> Result<wgpu::Texture, Error> {
    let label = "raycast-peel::scalars";
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
    let size = (vertices.width(), vertices.height());
    let merged = gpu.texture("of vertices", size, VERTEX, usage)?;
    let views =
        [vertices, scalars, &merged].map(|texture| texture.create_view(&Default::default()));
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let types = [TEXELS, TEXELS, write_texels(VERTEX)];
    let bindings = gpu.layout(label, ShaderStages::COMPUTE, &types)?;
    let pipeline = gpu.compute_pipeline(&ComputeProgram {
        label,
        source: SCALARS,
        groups: vec![bindings.clone()],
        ..Default::default()
    })?;
    gpu.checked(label, 0, || {
        let resources = views.each_ref().map(wgpu::BindingResource::TextureView);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group(gpu, label, &bindings, &resources), &[]);
        pass.dispatch_workgroups(size.0.div_ceil(64), size.1, 1);
    })?;
    gpu.finish(encoder)?;
    Ok(merged)
}
