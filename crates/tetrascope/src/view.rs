//! An interactive viewer in the browser: a server that draws what a page shows.
//!
//! The page turns the camera and edits the look; all is drawn here, by any algorithm of the
//! registry, so that it works through a tunnel, on a machine without a screen and without a window
//! system.
//!
//! 1. `state` is all that a picture depends on, and what commands of a page make of it; `look` is
//!    the part with colors and opacities, `command` lists the commands.
//! 2. [`Session`] keeps the state and draws it, without any network: `shared` is what its threads
//!    have in common; `workers` draw quickly while a hand moves (`pace` finds the resolution, `quick`
//!    the algorithm), completely when it rests, and then compare with the truth (`judge`);
//!    `renderers` are kept between frames. A newer state replaces an older one that was not drawn
//!    yet: nothing is queued.
//! 3. `picture` is what a person saves: images, the scene, the command that draws it.
//! 4. `access` says who may ask, [`serve`] answers by HTTP and WebSocket; `client` is one page,
//!    `page` its files.
//!
//! Who knows the token in the address can see and change the scene, and nothing else: no command
//! names a file.

mod access;
mod client;
mod command;
mod describe;
mod encoded;
mod judge;
mod listener;
mod loader;
mod look;
mod pace;
mod page;
mod picture;
mod quick;
mod renderers;
mod server;
mod session;
mod shared;
mod state;
mod workers;

pub use access::{Access, Token};
pub use command::{Command, Message};
pub use encoded::{Encoded, Kind};
pub use judge::Estimate;
pub use pace::{BUDGET, Pace};
pub use picture::{PictureFormat, command_line};
pub use server::{Hub, Server, serve};
pub use session::{Event, Session, Start};
pub use state::{Field, Saved, State};
