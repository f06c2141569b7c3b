//! The registry: every algorithm, what it draws, its settings, and how to build it.
//!
//! The command line, the comparison, the benchmarks and the tests iterate over
//! [`algorithms`] and know no algorithm by name. An algorithm is in the list if its
//! cargo feature is on.

use tetrascope_core::{Appearance, Error, OpticalModel, View, Volume};

use crate::{Context, Renderer, Setting, Settings};

#[cfg(feature = "projection")]
mod projection;
#[cfg(feature = "raycast-peel")]
mod raycast_peel;
#[cfg(feature = "reference")]
mod reference;
#[cfg(feature = "slicing")]
mod slicing;

/// An algorithm: one paper, one crate.
pub struct Algorithm {
    /// The name on the command line and of the cargo feature.
    pub name: &'static str,
    /// What it is, a few words.
    pub title: &'static str,
    /// The paper, in full.
    pub paper: &'static str,
    /// What it draws, one line.
    pub draws: &'static str,
    /// Whether building it needs a graphics adapter.
    pub needs_gpu: bool,
    /// Its quality settings.
    pub settings: &'static [Setting],
    /// The settings that a comparison tries under an optical model, each as
    /// "key=value,key=value"; what is left out is at its default.
    pub sweep: fn(OpticalModel) -> &'static [&'static str],
    /// How near to the truth its picture is with these settings.
    pub promise: fn(&Settings) -> Promise,
    /// Whether it draws this scene; [`Error::Unsupported`] says why not. Needs no device.
    pub supports: fn(&Volume, &Appearance, &View) -> Result<(), Error>,
    /// Prepares it for a volume and an appearance, so that it can render.
    pub build: Build,
}

/// How near to the truth a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Promise {
    /// Each ray's integral, but for rounding.
    Exact,
    /// Exact where the optical model commutes, and where the frame says that the order of
    /// cells is proven ([`FrameStats::order_proven`](tetrascope_core::FrameStats::order_proven)).
    ExactIfProven,
    /// Exact where the optical model commutes; else some cells may be blended in the
    /// wrong order.
    RoughOrder,
    /// A channel is changed by at most this by design, for colors of at most 1.
    Within(f64),
    /// An error that depends on the scene.
    Open,
}

/// Builds a renderer: makes the device if it needs one, uploads the volume.
pub type Build = fn(&Context, &Volume, &Appearance, &Settings) -> Result<Renderer, Error>;

const ALL: &[Algorithm] = &[
    #[cfg(feature = "reference")]
    reference::ALGORITHM,
    #[cfg(feature = "projection")]
    projection::ALGORITHM,
    #[cfg(feature = "raycast-peel")]
    raycast_peel::ALGORITHM,
    #[cfg(feature = "slicing")]
    slicing::ALGORITHM,
];

/// The value that setting `name` chooses among an option's `all`.
#[cfg(feature = "gpu")]
fn choice<T: Copy>(settings: &Settings, name: &str, all: &[(&str, T)]) -> T {
    let value = settings.get(name);
    let found = all.iter().find(|(word, _)| *word == value);
    found.expect("the entry lists what the crate offers").1
}

/// What entries are tested with: the words that they offer, and those of the crates.
#[cfg(all(test, feature = "gpu"))]
mod words {
    use super::Algorithm;
    use crate::settings::Values;

    pub(super) fn offered(algorithm: &Algorithm, name: &str) -> Vec<&'static str> {
        let setting = algorithm.settings.iter().find(|s| s.name == name);
        match setting.map(|s| &s.values) {
            Some(Values::Choice(words)) => words.to_vec(),
            other => panic!("{name}: {other:?}"),
        }
    }

    pub(super) fn of<T>(all: &[(&'static str, T)]) -> Vec<&'static str> {
        all.iter().map(|(word, _)| *word).collect()
    }
}

/// Every algorithm that was compiled in, the ground truth first.
pub fn algorithms() -> &'static [Algorithm] {
    ALL
}

/// The algorithm called `name`; an unknown name is refused with those that exist.
pub fn algorithm(name: &str) -> Result<&'static Algorithm, Error> {
    let found = ALL.iter().find(|algorithm| algorithm.name == name);
    found.ok_or_else(|| Error::Unknown {
        kind: "algorithm",
        name: name.into(),
        valid: ALL.iter().map(|algorithm| algorithm.name.into()).collect(),
    })
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::Values;

    /// An algorithm with a setting of each kind, to test settings with.
    pub(crate) const FAKE: Algorithm = Algorithm {
        name: "fake",
        title: "",
        paper: "",
        draws: "",
        needs_gpu: false,
        settings: &[
            Setting {
                name: "order",
                about: "",
                values: Values::Choice(&["exact", "fast"]),
                default: "exact",
            },
            Setting {
                name: "samples",
                about: "",
                values: Values::Integer { min: 1, max: 64 },
                default: "4",
            },
            Setting {
                name: "bias",
                about: "",
                values: Values::Number { min: 0.0, max: 1.0 },
                default: "0.5",
            },
        ],
        sweep: |_| &[""],
        promise: |_| Promise::Exact,
        supports: |_, _, _| Ok(()),
        build: |_, _, _, _| Err(Error::invalid("it draws nothing")),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_complete_and_consistent() {
        for (i, a) in algorithms().iter().enumerate() {
            assert!(algorithms()[..i].iter().all(|b| b.name != a.name));
            for text in [a.title, a.paper, a.draws] {
                assert!(!text.is_empty() && !text.contains('\n'), "{}", a.name);
            }
            for setting in a.settings {
                assert!(setting.values.contain(setting.default), "{}", setting.name);
            }
            for model in OpticalModel::ALL {
                let sweep = (a.sweep)(model);
                assert!(!sweep.is_empty(), "{} has nothing to compare", a.name);
                for quality in sweep {
                    Settings::parse(a, quality.split(',')).expect("the sweep is valid");
                }
            }
        }
    }

    #[test]
    fn an_unknown_algorithm_lists_those_that_exist() {
        let error = algorithm("refrence").err().expect("misspelt").to_string();
        for a in algorithms() {
            assert!(error.contains(a.name), "{error}");
            assert_eq!(algorithm(a.name).expect("listed").name, a.name);
        }
    }
}
