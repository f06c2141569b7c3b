//! The description of an algorithm, which needs no device.

use crate::{
    Appearance, Counter, Error, OpticalModel, Setting, Settings, View, Volume, VolumeKind,
};

/// An algorithm: one paper, one crate.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name on the command line and of the cargo feature.
    pub name: &'static str,
    /// The kind of algorithm, in a few words.
    pub title: &'static str,
    /// The paper, in full.
    pub paper: &'static str,
    /// The volumes and looks that it draws, in one line.
    pub draws: &'static str,
    /// Its quality settings.
    pub settings: &'static [Setting],
    /// The settings that a comparison tries under an optical model, each as
    /// "key=value,key=value"; what is left out is at its default.
    pub sweep: fn(OpticalModel) -> &'static [&'static str],
    /// Pairs of the sweep that tell sources of its error apart.
    pub sources: &'static [Source],
    /// The figures of the paper that its benchmark measures, one line.
    pub figures: Option<&'static str>,
    /// How near to the truth its picture is with these settings.
    pub promise: fn(&Settings) -> Promise,
    /// All that its frames may count.
    pub counters: &'static [Counter],
    /// Whether it draws this scene with these settings, as far as that can be said without a
    /// device; [`Error::Unsupported`] says why not.
    pub supports: fn(&Volume, &Appearance, &View, &Settings) -> Result<(), Error>,
}

/// How near to the truth a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Promise {
    /// The truth itself, which others are measured by: the picture says how wrong it may be
    /// ([`FrameStats::error_bound`](crate::FrameStats::error_bound)).
    Truth,
    /// Each ray's integral, but for rounding.
    Exact,
    /// Exact where the optical model commutes, and where the frame says that the order of
    /// cells is proven ([`FrameStats::order_proven`](crate::FrameStats::order_proven)).
    ExactIfProven,
    /// Exact where the optical model commutes; else some cells may be blended in the
    /// wrong order.
    RoughOrder,
    /// A channel is changed by at most this by design, for colors of at most 1.
    Within(f64),
    /// An error that depends on the scene.
    Open,
}

/// A source of an algorithm's error: the difference between two of its pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// The cause, in words.
    pub name: &'static str,
    /// The entry of the sweep that has it.
    pub with: &'static str,
    /// The entry of the sweep that has not; `None` for the truth.
    pub without: Option<&'static str>,
}

impl Entry {
    /// The settings that a comparison tries under an optical model on this kind of volume: those of
    /// [`Entry::sweep`] but for such as differ in nothing that matters for it.
    pub fn sweep_of(&self, model: OpticalModel, kind: VolumeKind) -> Vec<&'static str> {
        let mut seen: Vec<Settings> = Vec::new();
        let mut sweep = Vec::new();
        for &setting in (self.sweep)(model) {
            let settings = Settings::parse(self, setting.split(','));
            let settings = settings.map(|s| s.that_matter(self, kind));
            if let Ok(settings) = &settings {
                if seen.contains(settings) {
                    continue;
                }
                seen.push(settings.clone());
            }
            sweep.push(setting);
        }
        sweep
    }

    /// Whether others are measured by its pictures.
    pub fn is_truth(&self) -> bool {
        (self.promise)(&Settings::defaults(self)) == Promise::Truth
    }
}
