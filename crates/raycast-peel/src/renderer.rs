//! The renderer, whichever way it takes its steps.

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer};
use tetrascope_gpu::{Gpu, wgpu};

use crate::options::RaycastOptions;
use crate::single::Single;
use crate::{ABILITIES, NAME};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct RaycastPeel {
    single: Single,
}

impl RaycastPeel {
    /// A renderer of `volume`, which must be a mesh.
    ///
    /// # Errors
    /// A grid is unsupported; a mesh larger than the device's bindings is too large.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<RaycastPeel, Error> {
        ABILITIES.check(NAME, appearance)?;
        Ok(RaycastPeel {
            single: Single::new(gpu, volume, appearance, options)?,
        })
    }

    /// Bytes on the device between frames, the image not counted.
    pub fn bytes_resident(&self) -> u64 {
        self.single.bytes_resident()
    }

    /// Records one frame into `image`, an Rgba32Float storage texture, and where there are
    /// isosurfaces their depths into `depths`, R32Float: along the ray, world units, 3e38
    /// for none. Both are as large as the view; the caller submits. What the frame
    /// did is in the buffer returned, once the commands have run.
    ///
    /// # Errors
    /// A view that is no view, and more pairs of tile and boundary face than 32 bits count.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        image: &wgpu::TextureView,
        depths: Option<&wgpu::TextureView>,
    ) -> Result<wgpu::Buffer, Error> {
        self.single.encode(encoder, view, image, depths)
    }
}

impl VolumeRenderer for RaycastPeel {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        self.single.reload(volume)
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        ABILITIES.check(NAME, appearance)?;
        self.single.restyle(appearance)
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        self.single.render(view)
    }
}
