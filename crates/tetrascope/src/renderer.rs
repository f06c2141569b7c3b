//! A renderer that the registry has built, whatever draws.

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer};
#[cfg(feature = "gpu")]
use tetrascope_gpu::Draw;

/// A renderer of one volume.
pub enum Renderer {
    /// It draws on the CPU.
    Cpu(Box<dyn VolumeRenderer>),
    /// It draws on a GPU, into an application's textures too.
    #[cfg(feature = "gpu")]
    Gpu(Box<dyn Draw>),
}

impl Renderer {
    /// The part that records frames into an application's commands; `None` if it draws on the CPU.
    #[cfg(feature = "gpu")]
    pub fn as_draw(&self) -> Option<&dyn Draw> {
        match self {
            Renderer::Cpu(_) => None,
            Renderer::Gpu(renderer) => Some(&**renderer),
        }
    }

    fn get(&self) -> &dyn VolumeRenderer {
        match self {
            Renderer::Cpu(renderer) => &**renderer,
            #[cfg(feature = "gpu")]
            Renderer::Gpu(renderer) => &**renderer,
        }
    }

    fn get_mut(&mut self) -> &mut dyn VolumeRenderer {
        match self {
            Renderer::Cpu(renderer) => &mut **renderer,
            #[cfg(feature = "gpu")]
            Renderer::Gpu(renderer) => &mut **renderer,
        }
    }
}

impl VolumeRenderer for Renderer {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        self.get_mut().reload(volume)
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        self.get_mut().restyle(appearance)
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        self.get().render(view)
    }
}
