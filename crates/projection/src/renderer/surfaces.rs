//! Isosurfaces: how they are drawn.

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_gpu::{Gpu, Sums, wgpu};

use super::CellProjection;
use crate::passes::cell::{CellPass, FrameData};
use crate::passes::surface::{SurfaceData, SurfacePass};

impl CellProjection {
    /// Records the nearest isosurfaces.
    pub(super) fn record_surfaces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        uniform: &FrameData,
        data: &SurfaceData,
        sums: &Sums,
    ) -> Result<(), Error> {
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let pass = self.surface_pass.as_ref().expect("prepared for the style");
        let look = pass.look_group(gpu, uniform, data)?;
        gpu.checked("projection::surface", 0, || {
            let cells = (&self.cell_pass, &style.cell);
            pass.record(gpu, encoder, (uniform, &look), cells, sums)
        })?
    }
}

/// The pass that draws isosurfaces, compiled if `appearance` has them and it is not.
pub(super) fn prepared(
    pass: Option<SurfacePass>,
    gpu: &Gpu,
    cells: &CellPass,
    appearance: &Appearance,
) -> Result<Option<SurfacePass>, Error> {
    if pass.is_some() || appearance.optical_model != OpticalModel::Isosurfaces {
        return Ok(pass);
    }
    SurfacePass::new(gpu, cells).map(Some)
}
