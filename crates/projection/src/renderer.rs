//! The renderer: a mesh, an appearance, and frames of them.

mod frame;
mod style;
mod surfaces;
#[cfg(test)]
mod tests;

use tetrascope_core::{Appearance, Error, Frame, TetMesh, View, Volume, VolumeRenderer};
use tetrascope_f32::{Domain, ScalarMap};
use tetrascope_gpu::{Canvas, Commands, Draw, Gpu, Recorded, Target, draw};

use self::style::{Parts, Sorter, Style};
use self::surfaces::prepared;
use crate::entry::check;
use crate::mesh::{Field, Geometry, mesh_of};
use crate::options::{ExitSearch, ProjectionOptions};
use crate::passes::cell::CellPass;
use crate::passes::faces::FacePass;
use crate::passes::surface::SurfacePass;
use crate::passes::transform::TransformPass;
use crate::{ABILITIES, NAME};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct CellProjection {
    canvas: Canvas,
    options: ProjectionOptions,
    transform_pass: TransformPass,
    cell_pass: CellPass,
    sorter: Sorter,
    style: Style,
    /// Compiled when isosurfaces are first drawn.
    surface_pass: Option<SurfacePass>,
    /// Compiled where ray parameters are computed at vertices.
    face_pass: Option<FacePass>,
}

impl CellProjection {
    /// Uploads the mesh in `volume` and compiles what `appearance` needs.
    ///
    /// [`Error::Unsupported`] for a grid, [`Error::TooLarge`] and
    /// [`Error::OutOfMemory`] if the device does not hold the mesh.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &ProjectionOptions,
    ) -> Result<CellProjection, Error> {
        let mesh = check(volume, appearance, options)?;
        let transform_pass = TransformPass::new(gpu)?;
        let cell_pass = CellPass::new(gpu)?;
        let mut sorter = Sorter::default();
        let domain = Domain::of(mesh).within(options.domain)?;
        let geometry = Geometry::upload(gpu, mesh, domain)?;
        let model = appearance.optical_model;
        sorter.prepare(gpu, options, &cell_pass, model, &geometry)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        let field = Field::upload(gpu, &geometry, mesh, map, options.cell_layout)?;
        let face_pass = match options.exit_search {
            ExitSearch::PerFragment => None,
            _ => Some(FacePass::new(gpu, options, &cell_pass)?),
        };
        let surface_pass = prepared(None, gpu, &cell_pass, appearance)?;
        let parts = Parts {
            gpu,
            options,
            transform_pass: &transform_pass,
            cell_pass: &cell_pass,
            sorter: &sorter,
            surface_pass: surface_pass.as_ref(),
            face_pass: face_pass.as_ref(),
        };
        let style = parts.style(appearance, geometry, field, None)?;
        Ok(CellProjection {
            canvas: Canvas::new(gpu)?,
            options: options.clone(),
            transform_pass,
            cell_pass,
            sorter,
            style,
            surface_pass,
            face_pass,
        })
    }

    fn parts(&self) -> Parts<'_> {
        Parts {
            gpu: self.canvas.gpu(),
            options: &self.options,
            transform_pass: &self.transform_pass,
            cell_pass: &self.cell_pass,
            sorter: &self.sorter,
            surface_pass: self.surface_pass.as_ref(),
            face_pass: self.face_pass.as_ref(),
        }
    }

    fn reload_mesh(&mut self, mesh: &TetMesh) -> Result<(), Error> {
        let old = &self.style.geometry;
        let domain = Domain::of(mesh).within(self.options.domain)?;
        let geometry = if old.mesh.shares_geometry(mesh) {
            Geometry {
                mesh: mesh.clone(),
                domain,
                ..old.clone()
            }
        } else {
            Geometry::upload(self.canvas.gpu(), mesh, domain)?
        };
        let (map, range) = (self.style.field.map, domain.scalar_range);
        let map = match map.suits_appearance(&self.style.appearance, range) {
            true => map,
            false => ScalarMap::of_appearance(&self.style.appearance, range),
        };
        let layout = self.options.cell_layout;
        let field = Field::upload(self.canvas.gpu(), &geometry, mesh, map, layout)?;
        let appearance = &self.style.appearance;
        let model = appearance.optical_model;
        self.sorter.prepare(
            self.canvas.gpu(),
            &self.options,
            &self.cell_pass,
            model,
            &geometry,
        )?;
        let last = Some(&self.style.classified);
        self.style = self.parts().style(appearance, geometry, field, last)?;
        Ok(())
    }
}

impl VolumeRenderer for CellProjection {
    /// Uploads scalars alone where the geometry is the same.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        ABILITIES.check(NAME, &self.style.appearance, &volume.bounds())?;
        self.reload_mesh(mesh_of(volume)?)
    }

    /// Uploads the transfer function and which cells it leaves to draw; scalars only
    /// if its range moved so far that f32 would run out of digits.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let mesh = &self.style.geometry.mesh;
        ABILITIES.check(NAME, appearance, &mesh.bounds())?;
        let model = appearance.optical_model;
        self.options.validate(appearance)?;
        let geometry = self.style.geometry.clone();
        self.sorter.prepare(
            self.canvas.gpu(),
            &self.options,
            &self.cell_pass,
            model,
            &geometry,
        )?;
        let range = geometry.domain.scalar_range;
        let field = if self.style.field.map.suits_appearance(appearance, range) {
            self.style.field.clone()
        } else {
            let map = ScalarMap::of_appearance(appearance, range);
            let layout = self.options.cell_layout;
            Field::upload(self.canvas.gpu(), &geometry, &geometry.mesh, map, layout)?
        };
        let pass = self.surface_pass.clone();
        self.surface_pass = prepared(pass, self.canvas.gpu(), &self.cell_pass, appearance)?;
        let last = Some(&self.style.classified);
        let style = self.parts().style(appearance, geometry, field, last)?;
        // Uploads begin now, so that the room for them is free again when the next ones come: else
        // it grows with each edit until a frame is drawn.
        let gpu = self.canvas.gpu();
        gpu.checked("projection::restyle", 0, || gpu.queue().submit([]))?;
        self.style = style;
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for CellProjection {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        self.record_frame(commands, view, target)
    }
}
