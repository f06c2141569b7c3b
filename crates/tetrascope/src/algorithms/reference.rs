//! How to build the ground truth: it tells its progress.

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer};
use tetrascope_reference::{ENTRY, Reference, ReferenceOptions};

use super::Algorithm;
use crate::{Progress, Renderer};

pub(super) const ALGORITHM: Algorithm = Algorithm {
    entry: ENTRY,
    needs_gpu: false,
    build: |context, volume, appearance, _| {
        let reference = Reference::new(volume, appearance, &ReferenceOptions::default())?;
        let reference = reference.with_stop(context.stop().clone());
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
