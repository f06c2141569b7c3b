//! How a mesh is cut.

use tetrascope_core::Error;

use crate::options::check_weights;

/// Options of [`MeshSlices`](crate::MeshSlices).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshSlicesOptions {
    /// Planes through the depth of the mesh's box as it is seen, from 1 to 16384. A picture's error
    /// falls with their number.
    pub planes: u32,
    /// What is interpolated in a cell.
    pub shading: Shading,
    /// How it is interpolated.
    pub evaluation: Evaluation,
    /// Parts of the depth, from 1 on, each of which has a list of the cells that meet it; no
    /// more than planes. It changes nothing in the picture.
    pub slabs: u32,
}

/// What is interpolated in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// The scalar, whose color and extinction the transfer function has.
    #[default]
    Post,
    /// Colors and extinctions of vertices: what the transfer function does between their scalars
    /// is not seen.
    Pre,
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
const MOST_PLANES: u32 = 1 << 14;

impl Default for MeshSlicesOptions {
    fn default() -> Self {
        MeshSlicesOptions {
            planes: 256,
            shading: Shading::default(),
            evaluation: Evaluation::default(),
            slabs: 40,
        }
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
}
