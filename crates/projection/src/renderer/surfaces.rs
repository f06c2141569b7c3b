//! Isosurfaces: how they are drawn, alone and among an application's own geometry.

use std::sync::PoisonError;

use tetrascope_core::glam::{DMat4, DVec3};
use tetrascope_core::{Appearance, Error, FrameStats, OpticalModel, View};
use tetrascope_gpu::{Gpu, wgpu};

use super::Projection;
use crate::options::ProjectionOptions;
use crate::passes::cell::{CellPass, FrameData};
use crate::passes::surface::{SurfacePass, SurfaceTextures};

/// An application's depth buffer, in which isosurfaces are hidden and hide.
#[derive(Clone, Copy, Debug)]
pub struct DepthTarget<'a> {
    /// A view of a texture of the view's size and of [`ProjectionOptions::depth_format`].
    pub view: &'a wgpu::TextureView,
    /// From world space to clip space, as for the depths that are there already. It must
    /// see what the view's camera sees, as pixels are the camera's; depths are its own.
    pub clip_from_world: DMat4,
}

impl Projection {
    /// Records isosurfaces into `target`, as [`Projection::encode`] does, but over what is
    /// there, and hidden by what `depth` has in front of them; the depths of those that
    /// show are written.
    ///
    /// [`Error::Invalid`] without [`ProjectionOptions::depth_format`], and where another
    /// optical model is drawn, which has no depth.
    pub fn encode_among(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        target: &wgpu::TextureView,
        depth: &DepthTarget,
    ) -> Result<FrameStats, Error> {
        view.validate()?;
        let Some(pass) = self
            .surface_pass
            .as_ref()
            .filter(|_| self.scene.surfaces.is_some())
        else {
            return Err(Error::invalid(
                "a depth target, but no isosurfaces are drawn",
            ));
        };
        let normalization = &self.scene.geometry.normalization;
        let uniform = self.frame(view)?;
        self.record_transform(encoder, &uniform, None)?;
        let textures = self.record_surfaces(encoder, view, &uniform)?;
        let from_normalized = uniform.plane.camera_from_normalized();
        let scale = DVec3::splat(normalization.scale);
        let world_from_normalized =
            DMat4::from_translation(normalization.center) * DMat4::from_scale(scale);
        let clip =
            depth.clip_from_world * world_from_normalized * DMat4::from(from_normalized.inverse());
        let into = (target, depth.view);
        pass.record_among(&self.gpu, encoder, (&uniform.frame, &clip), &textures, into)?;
        let mut stats = self.stats(false);
        stats.passes += 3;
        Ok(stats)
    }

    /// Records the nearest isosurfaces; those textures are kept for the next frame.
    pub(super) fn record_surfaces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        uniform: &FrameData,
    ) -> Result<SurfaceTextures, Error> {
        let (gpu, scene) = (&self.gpu, &self.scene);
        let (Some(pass), Some(data)) = (&self.surface_pass, &scene.surfaces) else {
            return Err(Error::invalid("no isosurfaces are drawn"));
        };
        let size = (view.width, view.height);
        let mut kept = self.surfaces.lock().unwrap_or_else(PoisonError::into_inner);
        let textures = match kept.take().filter(|textures| textures.fits(size)) {
            Some(textures) => textures,
            None => SurfaceTextures::new(gpu, size)?,
        };
        *kept = Some(textures.clone());
        let look = pass.look_group(gpu, uniform, data)?;
        gpu.checked("projection::surface", 0, || {
            let cells = (&self.cell_pass, &scene.cell);
            pass.record(gpu, encoder, (uniform, &look), cells, &textures);
        })?;
        Ok(textures)
    }
}

/// The pass that draws isosurfaces, compiled if `appearance` has them and it is not.
pub(super) fn prepared(
    pass: Option<SurfacePass>,
    gpu: &Gpu,
    options: &ProjectionOptions,
    cells: &CellPass,
    appearance: &Appearance,
) -> Result<Option<SurfacePass>, Error> {
    if pass.is_some() || appearance.optical_model != OpticalModel::Isosurfaces {
        return Ok(pass);
    }
    SurfacePass::new(gpu, cells, options.target_format, options.depth_format).map(Some)
}
