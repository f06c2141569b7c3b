//! Every ray to its end in one dispatch.
//!
//! By rates of change: [`mesh`], [`style`], [`frame`].

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tetrascope_core::{Appearance, Error, TetMesh, Volume};
use tetrascope_f32::{Domain, ScalarMap};
use tetrascope_gpu::memory::texture_bytes;
use tetrascope_gpu::wgpu::{self, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration};

use crate::entry::tetrahedra;
use crate::integral::sides_constant;
use crate::options::{Entries, RaycastOptions};

const LABEL: &str = "raycast-peel::cast";

mod budget;
mod cast;
mod frame;
mod layers;
mod mesh;
mod style;

pub(crate) use budget::Budget;
use layers::Peeling;
use mesh::Kind;
pub(crate) use mesh::{Mesh, TRANSPARENT_SCALAR};
use style::Style;

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub(crate) struct Single {
    gpu: Gpu,
    options: RaycastOptions,
    mesh: Mesh,
    style: Style,
    peeling: Option<Peeling>,
    /// The texture that is bound where there are no isosurfaces.
    no_distances: wgpu::Texture,
    /// Whether a frame had rays that one dispatch did not finish.
    is_long: Arc<AtomicBool>,
}

impl Single {
    /// A renderer of `volume`, which must be a mesh.
    ///
    /// # Errors
    /// A grid is unsupported; a mesh larger than the device's bindings is too large.
    pub(crate) fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<Single, Error> {
        let source = tetrahedra(volume)?;
        let domain = Domain::of(source).within(options.domain)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        let mesh = Mesh::new(gpu, source, domain, map, options.locality)?;
        Ok(Single {
            style: Style::new(gpu, &mesh, appearance, options, None)?,
            peeling: match options.entries {
                Entries::TileLists => None,
                Entries::PeeledLayers => Some(Peeling::new(gpu, sides_constant(gpu, options)?)?),
            },
            mesh,
            gpu: gpu.clone(),
            options: *options,
            no_distances: gpu.texture(
                "raycast-peel::no_distances",
                (1, 1),
                TextureFormat::R32Float,
                TextureUsages::STORAGE_BINDING,
            )?,
            is_long: Arc::default(),
        })
    }

    /// How and what is drawn, and its mesh.
    pub(crate) fn scene(&self) -> (&RaycastOptions, &Appearance, &TetMesh) {
        (&self.options, &self.style.appearance, &self.mesh.source)
    }

    /// Bytes on the device between frames, the image not counted.
    pub(crate) fn bytes_resident(&self) -> u64 {
        let textures = self
            .mesh
            .textures()
            .into_iter()
            .chain([&self.style.intervals]);
        textures.map(texture_bytes).sum::<u64>() + self.style.table.bytes()
    }

    pub(crate) fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let source = tetrahedra(volume)?;
        let (gpu, old) = (&self.gpu, &self.mesh);
        let appearance = &self.style.appearance;
        let domain = Domain::of(source).within(self.options.domain)?;
        let range = domain.scalar_range;
        let same_kind = Kind::of(source) == Kind::of(&old.source);
        let same_geometry = source.shares_geometry(&old.source) && same_kind;
        let keeps_map = same_geometry && old.scalar_map.suits_appearance(appearance, range);
        let map = match keeps_map {
            true => old.scalar_map,
            false => ScalarMap::of_appearance(appearance, range),
        };
        let mesh = match same_geometry {
            true => old.with_scalars(gpu, source, domain, map)?,
            false => Mesh::new(gpu, source, domain, map, self.options.locality)?,
        };
        // A table's program knows whether scalars leave it.
        let holds = keeps_map && self.style.holds_for(&mesh)?;
        if !holds || self.options.integration != Integration::Exact {
            let table = Some(&self.style.table);
            self.style = Style::new(gpu, &mesh, appearance, &self.options, table)?;
        }
        self.is_long = Arc::default();
        self.mesh = mesh;
        Ok(())
    }

    pub(crate) fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let (gpu, old) = (&self.gpu, &self.mesh);
        let range = old.domain.scalar_range;
        let mesh = match old.scalar_map.suits_appearance(appearance, range) {
            true => None,
            false => {
                let map = ScalarMap::of_appearance(appearance, range);
                Some(old.with_scalars(gpu, &old.source, old.domain, map)?)
            }
        };
        let drawn = mesh.as_ref().unwrap_or(old);
        let table = Some(&self.style.table);
        self.style = Style::new(gpu, drawn, appearance, &self.options, table)?;
        self.is_long = Arc::default();
        if let Some(mesh) = mesh {
            self.mesh = mesh;
        }
        Ok(())
    }
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod aimed;
