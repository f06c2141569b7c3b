//! The trait that every algorithm implements.

use crate::{Appearance, Error, Frame, View, Volume};

/// A renderer of one volume.
///
/// Data changes at three rates, and each has its method: the volume rarely, its
/// appearance now and then, the view every frame. A renderer that exists can
/// render: constructors take volume and appearance. It can be handed to another thread.
pub trait VolumeRenderer: Send {
    /// Takes a volume whose geometry or scalars changed, such as the next time step.
    ///
    /// On an error the renderer keeps what it had.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error>;

    /// Takes a new transfer function or optical model; touches no geometry.
    ///
    /// On an error the renderer keeps what it had.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error>;

    /// Draws one frame.
    fn render(&self, view: &View) -> Result<Frame, Error>;
}
