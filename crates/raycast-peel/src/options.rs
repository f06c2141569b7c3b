//! Options of ray casting.

use tetrascope_core::{Abilities, Appearance, Bounds, Error, OpticalModel, Settings};
pub use tetrascope_f32::Domain;
pub use tetrascope_gpu::Integration;
use tetrascope_gpu::preintegration::OfSide;
use tetrascope_gpu::transfer_function::check_knots;

use crate::ping_pong::check_intervals;
use crate::single::Budget;
use crate::{ABILITIES, ENTRY, NAME};

pub use tetrascope_f32::Locality;

/// How rays are cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaycastOptions {
    /// How many of a ray's steps one pass takes.
    pub passes: Passes,
    /// How a ray's segment in a cell is integrated. Tables know no depth cue, and
    /// isosurfaces need none.
    pub integration: Integration,
    /// The opacity at which a ray stops, in (0, 1]: what lies behind then adds less
    /// than 1 − this of its light. 1 is exact; the paper stops at 0.95.
    pub stop_opacity: f32,
    /// In which order the mesh lies in memory.
    pub locality: Locality,
    /// The box and range to which positions, scalars of isosurfaces and the depth cue are relative, for parts of a
    /// mesh or steps of a time series that are to agree; `None` for the volume's own.
    pub domain: Option<Domain>,
    /// How a ray finds the boundary faces that it crosses. [`Passes::Single`] only.
    pub entries: Entries,
    /// Whether the walk compares products as integers on every device. Otherwise it does
    /// where products of floats are not rounded to nearest, which is slower and changes
    /// nothing else. Where rays cross [`Crossings::Planes`] there are no such products.
    pub integer_sides: bool,
    /// Tiles along each side of the image, 1 to 8. [`Passes::PingPong`] only.
    pub tiles: u32,
    /// Passes between two occlusion queries, at least 1; the paper's k.
    /// [`Passes::PingPong`] only.
    pub query_interval: u32,
    /// By how much a layer of boundary faces must lie behind the one before, in parts
    /// of the mesh's greatest extent, 0 or more. [`Passes::PingPong`] only.
    ///
    /// The paper has 0.1 in its meshes' own unit: 0.0045 of the Blunt Fin's extent.
    /// A part thinner than this, between two entries of a ray, is not seen. Only where
    /// rays cross [`Crossings::Planes`].
    pub peel_bias: f32,
    /// How a ray's way through cells is found. [`Passes::PingPong`] only.
    pub crossings: Crossings,
}

/// How one step per pass finds where a ray comes into the mesh and leaves each cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossings {
    /// By the sides on which edges pass, with scalars from positive weights, as
    /// [`Passes::Single`] does; layers are in the order of depth and cell, without a bias.
    Sides,
    /// As published: by the planes of faces, with scalars from a cell's gradient; boundary
    /// faces are rasterized, and a layer is behind the one before by a bias.
    Planes,
}

/// How one dispatch finds where rays cross the boundary. Pictures are the same bit for bit.
///
/// CPU seconds a frame of 512x512, emission and absorption, medians of nine frames drawn in turn
/// on llvmpipe (Mesa 22.3.6, a busy machine), loading not included:
///
/// | | lists | layers | full layers |
/// |---|---|---|---|
/// | Blunt Fin | 0.70 | 0.86 | 4 |
/// | SPX | 0.24 | 0.38 | 6 |
/// | post | 0.67 | 1.12 | 6 |
/// | angular sector | 0.27 | 0.71 | 14 |
/// | torus | 0.44 | 0.67 | 6 |
/// | sphere | 0.84 | 1.03 | 2 |
///
/// Each layer, and an empty one to see that it is the last, asks all faces of all their pixels
/// again; a list is searched once by the 64 rays of a tile together.
/// `benches/raycast_peel.rs` measures wall times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// Each ray searches the list of its tile, which the CPU makes for each frame.
    TileLists,
    /// Layers of boundary faces are peeled before, front to back by (t, face), until one
    /// is empty. A ray in more layers than memory is spent on searches lists.
    PeeledLayers,
}

/// How many of a ray's steps one pass takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// All of them: one dispatch follows each ray to its end.
    Single,
    /// One, as published: each pass reads what the last one wrote, and the boundary is
    /// peeled layer by layer.
    PingPong,
}

tetrascope_core::choices! {
    Crossings: "sides" = Sides, "planes" = Planes;
    Entries: "lists" = TileLists, "layers" = PeeledLayers;
    Passes: "single" = Single, "ping-pong" = PingPong;
}

/// Every integration, with its name in settings.
pub const INTEGRATIONS: [(&str, OfSide); 4] = {
    let [exact, two, three] = Integration::ALL;
    [exact, two, Integration::FIXED, three]
};

/// The most tiles along a side of the image.
pub const MAX_TILES: u32 = 8;

/// The defaults of [`ENTRY`]'s settings.
impl Default for RaycastOptions {
    fn default() -> RaycastOptions {
        RaycastOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

impl RaycastOptions {
    /// The optical depth beyond which a ray stops.
    ///
    /// At 100 transmittance is 4e-44, which f32 cannot tell from 0.
    pub(crate) fn stop_depth(&self) -> f32 {
        (-(-self.stop_opacity).ln_1p()).min(100.0)
    }

    /// Refuses numbers out of range, and an appearance of a volume in `bounds` that is not drawn
    /// like this.
    pub(crate) fn check(&self, appearance: &Appearance, bounds: &Bounds) -> Result<(), Error> {
        ABILITIES.check(NAME, appearance, bounds)?;
        self.validate()?;
        check_knots(&appearance.transfer_function)?;
        let model = appearance.optical_model;
        self.integration.check(NAME, model, true)?;
        let fades = appearance.depth_cue.is_some() && model != OpticalModel::Isosurfaces;
        if fades && self.integration != Integration::Exact {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "a depth cue with a table of integrals".into(),
                reason: "the cue differs from place to place, the table does not".into(),
            });
        }
        match self.passes {
            Passes::Single => Budget::new(appearance).map(drop),
            Passes::PingPong => {
                published(appearance, bounds)?;
                match self.integration {
                    Integration::Exact => check_intervals(appearance),
                    _ => Ok(()),
                }
            }
        }
    }

    /// Refuses numbers out of range.
    fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String, help: &str| {
            Err(Error::Invalid {
                what,
                help: Some(help.into()),
            })
        };
        if !(self.stop_opacity > 0.0 && self.stop_opacity <= 1.0) {
            let what = format!("a stop opacity of {}", self.stop_opacity);
            return wrong(what, "give more than 0 and at most 1, which is exact");
        }
        if !(1..=MAX_TILES).contains(&self.tiles) {
            let what = format!("{} tiles along a side", self.tiles);
            return wrong(what, "give 1 to 8");
        }
        if self.query_interval == 0 {
            return wrong(
                "an occlusion query every 0 passes".into(),
                "give at least 1",
            );
        }
        if !(self.peel_bias >= 0.0 && self.peel_bias.is_finite()) {
            let what = format!("a peel bias of {}", self.peel_bias);
            return wrong(what, "give 0 or more, in parts of the mesh's extent");
        }
        Ok(())
    }
}

/// Refuses what the paper does not have, which ends with the volumetric optical models.
fn published(appearance: &Appearance, bounds: &Bounds) -> Result<(), Error> {
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
