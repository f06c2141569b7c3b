//! As published: one step per pass, and the boundary peeled layer by layer.
//!
//! 1. [`mesh`] packs the mesh into three textures (section 4.1, figure 8).
//! 2. [`tiles`] cuts the image (3.3).
//! 3. [`passes`] records each phase (4.2, figure 7).
//! 4. [`frame`] runs them until no ray is left: it waits for occlusion queries. What rays have
//!    gathered then gets over the background as that of any renderer.

mod frame;
mod gpu_data;
mod mesh;
mod orientation;
mod passes;
mod style;
mod tiles;

use tetrascope_core::{Appearance, Error, TetMesh, Volume};
use tetrascope_f32::{Domain, ScalarMap};
use tetrascope_gpu::Gpu;

use crate::entry::tetrahedra;
use crate::options::RaycastOptions;
use mesh::Mesh;
use passes::Pipelines;
use style::Style;

/// Intervals of the transfer function in which one step integrates: their loop takes
/// three passes each, of at most 65 535 that llvmpipe allows (`single/budget.rs`).
const MOST_INTERVALS: usize = 1 << 14;

/// Refuses a transfer function of more intervals than one step integrates in.
pub(crate) fn check_intervals(appearance: &Appearance) -> Result<(), Error> {
    // Between the knots, before the first and behind the last.
    let count = appearance.transfer_function.knots().len() + 1;
    match count <= MOST_INTERVALS {
        true => Ok(()),
        false => Err(Error::TooLarge {
            what: "the transfer function with passes=ping-pong".into(),
            needed: count as u64,
            limit: MOST_INTERVALS as u64,
            unit: "intervals",
        }),
    }
}

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub(crate) struct PingPong {
    gpu: Gpu,
    options: RaycastOptions,
    passes: Pipelines,
    mesh: Mesh,
    style: Style,
}

impl PingPong {
    pub(crate) fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<PingPong, Error> {
        let map = ScalarMap::of(&appearance.transfer_function);
        let source = tetrahedra(volume)?;
        let domain = Domain::of(source).within(options.domain)?;
        let mesh = Mesh::new(gpu, source, domain, map, options)?;
        let passes = Pipelines::new(gpu, options)?;
        Ok(PingPong {
            style: Style::new(gpu, &passes, &mesh, appearance, options, None)?,
            passes,
            mesh,
            gpu: gpu.clone(),
            options: *options,
        })
    }

    fn new_style(&self, mesh: &Mesh, appearance: &Appearance) -> Result<Style, Error> {
        let last = Some(&self.style.table);
        Style::new(
            &self.gpu,
            &self.passes,
            mesh,
            appearance,
            &self.options,
            last,
        )
    }

    /// How and what is drawn, and its mesh.
    pub(crate) fn scene(&self) -> (&RaycastOptions, &Appearance, &TetMesh) {
        (&self.options, &self.style.appearance, &self.mesh.source)
    }

    pub(crate) fn bytes_resident(&self) -> u64 {
        self.mesh.bytes() + self.style.intervals.size() + self.style.table.bytes()
    }

    pub(crate) fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let source = tetrahedra(volume)?;
        let domain = Domain::of(source).within(self.options.domain)?;
        let (gpu, old) = (&self.gpu, &self.mesh);
        let same_kind = source.scalars().association == old.source.scalars().association;
        let mesh = match source.shares_geometry(&old.source) && same_kind {
            true => old.with_scalars(gpu, source, domain, old.scalar_map)?,
            false => {
                let map = ScalarMap::of(&self.style.appearance.transfer_function);
                Mesh::new(gpu, source, domain, map, &self.options)?
            }
        };
        self.style = self.new_style(&mesh, &self.style.appearance)?;
        self.mesh = mesh;
        Ok(())
    }

    pub(crate) fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let old = &self.mesh;
        let function = &appearance.transfer_function;
        let mesh = match old.scalar_map.suits(function) {
            true => None,
            false => {
                let map = ScalarMap::of(function);
                Some(old.with_scalars(&self.gpu, &old.source, old.domain, map)?)
            }
        };
        self.style = self.new_style(mesh.as_ref().unwrap_or(old), appearance)?;
        if let Some(mesh) = mesh {
            self.mesh = mesh;
        }
        Ok(())
    }
}
