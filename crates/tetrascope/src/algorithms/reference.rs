//! The ground truth's entry.

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer};
use tetrascope_reference::{NAME, Reference, ReferenceOptions, supports};

use super::{Algorithm, Promise};
use crate::{Progress, Renderer};

pub(super) const ALGORITHM: Algorithm = Algorithm {
    name: NAME,
    title: "exact BVH ray casting, the ground truth",
    paper: "N. Max, \"Optical Models for Direct Volume Rendering\", IEEE Transactions on \
            Visualization and Computer Graphics 1(2), 1995, pp. 99-108, doi:10.1109/2945.468400",
    draws: "any mesh, non-convex, cyclic or overlapping too, and any regular grid in memory, in \
            every optical model, with depth cue and clip planes, in f64 with an error bound",
    needs_gpu: false,
    settings: &[],
    sweep: |_| &[""],
    promise: |_| Promise::Exact,
    supports: |volume, appearance, _| supports(volume, appearance),
    build: |context, volume, appearance, _| {
        let reference = Reference::new(volume, appearance, &ReferenceOptions::default())?;
        Ok(Renderer::Cpu(match context.progress() {
            Some(progress) => Box::new(Telling {
                reference,
                progress: progress.clone(),
            }),
            None => Box::new(reference),
        }))
    },
};

/// The reference, telling its progress.
struct Telling {
    reference: Reference,
    progress: Progress,
}

impl VolumeRenderer for Telling {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        self.reference.reload(volume)
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        self.reference.restyle(appearance)
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        let image = self.reference.render_with_progress(view, &*self.progress)?;
        Ok(image.to_frame())
    }
}
