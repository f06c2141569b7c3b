//! The renderer, whichever way it takes its steps.

use tetrascope_core::{Appearance, Error, Frame, TetMesh, View, Volume, VolumeRenderer};
use tetrascope_gpu::{Canvas, Commands, Draw, Gpu, Recorded, Target, draw};

use crate::entry::check;
use crate::options::{Passes, RaycastOptions};
use crate::ping_pong::PingPong;
use crate::single::Single;

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct RaycastPeel {
    canvas: Canvas,
    form: Form,
}

#[derive(Debug)]
enum Form {
    Single(Box<Single>),
    PingPong(Box<PingPong>),
}

impl Form {
    /// How it steps, what it draws, and the mesh.
    fn scene(&self) -> (&RaycastOptions, &Appearance, &TetMesh) {
        match self {
            Form::Single(single) => single.scene(),
            Form::PingPong(ping_pong) => ping_pong.scene(),
        }
    }
}

impl RaycastPeel {
    /// A renderer of `volume`, which must be a mesh.
    ///
    /// # Errors
    /// A grid is unsupported; a mesh larger than the device's bindings is too large; an
    /// option out of its range is invalid.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<RaycastPeel, Error> {
        check(volume, appearance, options)?;
        let form = match options.passes {
            Passes::Single => {
                Form::Single(Box::new(Single::new(gpu, volume, appearance, options)?))
            }
            Passes::PingPong => {
                Form::PingPong(Box::new(PingPong::new(gpu, volume, appearance, options)?))
            }
        };
        Ok(RaycastPeel {
            canvas: Canvas::new(gpu)?,
            form,
        })
    }

    /// Bytes on the device between frames, images and traversal state not counted.
    pub fn bytes_resident(&self) -> u64 {
        match &self.form {
            Form::Single(single) => single.bytes_resident(),
            Form::PingPong(ping_pong) => ping_pong.bytes_resident(),
        }
    }
}

#[cfg(test)]
impl RaycastPeel {
    /// A renderer that draws with `single`.
    pub(crate) fn with(gpu: &Gpu, single: Single) -> RaycastPeel {
        RaycastPeel {
            canvas: Canvas::new(gpu).expect("one texel"),
            form: Form::Single(Box::new(single)),
        }
    }
}

impl VolumeRenderer for RaycastPeel {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let (options, appearance, _) = self.form.scene();
        check(volume, appearance, options)?;
        match &mut self.form {
            Form::Single(single) => single.reload(volume),
            Form::PingPong(ping_pong) => ping_pong.reload(volume),
        }
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let (options, _, mesh) = self.form.scene();
        options.check(appearance, &mesh.bounds())?;
        match &mut self.form {
            Form::Single(single) => single.restyle(appearance),
            Form::PingPong(ping_pong) => ping_pong.restyle(appearance),
        }
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for RaycastPeel {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// Into a caller's encoder, sixteen dispatches are recorded for each part of the picture, as
    /// nobody reads in between whether rays are left; those that find none are empty. Only rays
    /// through some ten thousand cells, or some thousand parts of the mesh, need more; those that
    /// are not done are counted as lost. [`VolumeRenderer::render`] goes on until all are.
    ///
    /// # Errors
    /// More pairs of tile and boundary face than 32 bits count. In a caller's encoder
    /// [`Passes::PingPong`] is unsupported: how many passes a frame takes is known only from
    /// occlusion queries that the CPU reads in between, and a bound that needs none, the
    /// number of cells, is hundreds of times what rays take. So is
    /// [`Entries::PeeledLayers`](crate::Entries), where they tell how many layers there are.
    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        match &self.form {
            Form::Single(single) => single.record(&self.canvas, commands, view, target),
            Form::PingPong(ping_pong) => ping_pong.record(&self.canvas, commands, view, target),
        }
    }
}
