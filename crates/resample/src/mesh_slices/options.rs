//! How a mesh is cut.

use tetrascope_core::Error;
use tetrascope_f32::{Domain, ImagePlane};

use crate::NAME;
use crate::options::{ResamplingOptions, check_weights};

/// Options of [`MeshSlices`](crate::MeshSlices).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSlicesOptions {
    /// Planes through the depth of the mesh's box as it is seen, from 1 to 16384. A picture's error
    /// falls with their number.
    pub planes: u32,
    /// The quantity that is interpolated in a cell.
    pub shading: Shading,
    /// How it is interpolated.
    pub evaluation: Evaluation,
    /// Parts of the depth, from 1 on, each of which has a list of the cells that meet it; no
    /// more than planes. It changes nothing in the picture.
    pub slabs: u32,
    /// Where and of which scalars all is that is to be drawn alike, such as the steps of a series;
    /// the mesh's own if there is none.
    pub domain: Option<Domain>,
}

/// The quantity that is interpolated in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// The scalar, whose color and extinction the transfer function has.
    #[default]
    Post,
    /// Colors and extinctions of vertices: what the transfer function does between their scalars
    /// is not seen.
    Pre,
}

/// Made for textures of so many weights.
type OfWeights = fn(u32) -> Evaluation;

/// Ways to interpolate.
pub(crate) const EVALUATIONS: [(&str, OfWeights); 2] = [
    ("per-fragment", |_| Evaluation::PerFragment),
    ("textures", |weights| Evaluation::Textures { weights }),
];

tetrascope_core::choices! {
    Shading: "post" = Post, "pre" = Pre;
}

/// How scalars or colors between a cell's corners are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Evaluation {
    /// In each fragment, between the points where its ray meets the cell's faces; in perspective, too.
    #[default]
    PerFragment,
    /// By two textures of weights, as published; along parallel rays only.
    Textures {
        /// Width and height of the textures, an even number from 32 to 1024.
        weights: u32,
    },
}

/// The most planes.
pub(crate) const MOST_PLANES: u32 = 1 << 14;

/// The defaults of [`ENTRY`](crate::ENTRY)'s settings.
impl Default for MeshSlicesOptions {
    fn default() -> Self {
        ResamplingOptions::default().mesh_slices
    }
}

impl MeshSlicesOptions {
    /// # Errors
    /// A number that is out of range.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let usage = |what: String| Err(Error::Usage { what, help: None });
        if !(1..=MOST_PLANES).contains(&self.planes) {
            return usage(format!(
                "{} planes; valid are 1 to {MOST_PLANES}",
                self.planes
            ));
        }
        if self.slabs == 0 {
            return usage("no slabs; valid are 1 and more".into());
        }
        match self.evaluation {
            Evaluation::Textures { weights } => check_weights(weights),
            Evaluation::PerFragment => Ok(()),
        }
    }

    /// Refuses perspective with textures.
    pub(super) fn check_plane(&self, plane: &ImagePlane) -> Result<(), Error> {
        match (self.evaluation, plane.is_perspective) {
            (Evaluation::Textures { .. }, true) => Err(Error::Unsupported {
                renderer: NAME,
                what: "perspective with weights from textures".into(),
                reason: "their coordinates are distances along parallel rays".into(),
            }),
            _ => Ok(()),
        }
    }
}
