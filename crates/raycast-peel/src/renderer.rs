//! The renderer, whichever way it takes its steps.

use tetrascope_core::{
    Abilities, Appearance, Bounds, Error, Frame, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::{Canvas, Commands, Draw, Gpu, Recorded, Target, draw};

use crate::options::{Passes, RaycastOptions};
use crate::ping_pong::PingPong;
use crate::single::Single;
use crate::{ABILITIES, NAME};

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
    fn scene(&self) -> (Passes, &Appearance, &TetMesh) {
        match self {
            Form::Single(single) => {
                let (appearance, mesh) = single.scene();
                (Passes::Single, appearance, mesh)
            }
            Form::PingPong(ping_pong) => {
                let (appearance, mesh) = ping_pong.scene();
                (Passes::PingPong, appearance, mesh)
            }
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
        check(options.passes, appearance, &volume.bounds())?;
        options.validate()?;
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
    /// What draws with `single`.
    pub(crate) fn with(gpu: &Gpu, single: Single) -> RaycastPeel {
        RaycastPeel {
            canvas: Canvas::new(gpu).expect("one texel"),
            form: Form::Single(Box::new(single)),
        }
    }
}

impl VolumeRenderer for RaycastPeel {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let (passes, appearance, _) = self.form.scene();
        check(passes, appearance, &volume.bounds())?;
        match &mut self.form {
            Form::Single(single) => single.reload(volume),
            Form::PingPong(ping_pong) => ping_pong.reload(volume),
        }
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let (passes, _, mesh) = self.form.scene();
        check(passes, appearance, &mesh.bounds())?;
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

/// Refuses what this many steps a pass do not draw: the paper ends with the volumetric
/// optical models.
fn check(passes: Passes, appearance: &Appearance, bounds: &Bounds) -> Result<(), Error> {
    ABILITIES.check(NAME, appearance, bounds)?;
    if passes == Passes::Single {
        return Ok(());
    }
    let refused = Abilities::default().check(NAME, appearance, bounds);
    refused.map_err(|error| match error {
        Error::Unsupported { renderer, what, .. } => Error::Unsupported {
            renderer,
            what: format!("{what} with passes=ping-pong"),
            reason: "that is as published, with the volumetric models alone; passes=single has it"
                .into(),
        },
        error => error,
    })
}

/// The mesh of `volume`.
pub(crate) fn tetrahedra(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "a grid".into(),
            reason: "it walks from tetrahedron to tetrahedron".into(),
        }),
    }
}
