//! The renderer, whichever way it takes its steps.

use tetrascope_core::{
    Abilities, Appearance, Bounds, Error, Frame, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::{Gpu, wgpu};

use crate::options::{Passes, RaycastOptions};
use crate::ping_pong::PingPong;
use crate::single::Single;
use crate::{ABILITIES, NAME};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub struct RaycastPeel {
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
        Ok(RaycastPeel { form })
    }

    /// Bytes on the device between frames, images and traversal state not counted.
    pub fn bytes_resident(&self) -> u64 {
        match &self.form {
            Form::Single(single) => single.bytes_resident(),
            Form::PingPong(ping_pong) => ping_pong.bytes_resident(),
        }
    }

    /// Records one frame into `image`, an Rgba32Float storage texture, and where there are
    /// isosurfaces their depths into `depths`, R32Float: along the ray, world units, 3e38
    /// for none. Both are as large as the view; the caller submits. What the frame
    /// did is in the buffer returned, once the commands have run: six `u32`, the number of
    /// cells passed (its lower half first), paths, rays that cross the boundary an odd number
    /// of times, rays that were lost, and rays that were not done.
    ///
    /// Sixteen dispatches are recorded for each part of the picture, as nobody reads in
    /// between whether rays are left; those that find none are empty. Only rays
    /// through some ten thousand cells, or some thousand parts of the mesh, need
    /// more: [`VolumeRenderer::render`] goes on until all are done.
    ///
    /// # Errors
    /// A view that is no view, and more pairs of tile and boundary face than 32 bits count.
    /// [`Passes::PingPong`] is unsupported: how many passes a frame takes is known only from
    /// occlusion queries that the CPU reads in between, and a bound that needs none, the
    /// number of cells, is hundreds of times what rays take. So is
    /// [`Entries::PeeledLayers`](crate::Entries), where they tell how many layers there are.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        image: &wgpu::TextureView,
        depths: Option<&wgpu::TextureView>,
    ) -> Result<wgpu::Buffer, Error> {
        match &self.form {
            Form::Single(single) => single.encode(encoder, view, image, depths),
            Form::PingPong(_) => Err(Error::Unsupported {
                renderer: NAME,
                what: "a step a pass into the caller's encoder".into(),
                reason: "the CPU reads between passes whether rays are left".into(),
            }),
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
        match &self.form {
            Form::Single(single) => single.render(view),
            Form::PingPong(ping_pong) => ping_pong.render(view),
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
