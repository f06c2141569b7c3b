//! All that can be chosen: each algorithm with its defaults, and with what its entry has compared.

use tetrascope_core::{OpticalModel, VolumeKind};

use super::Effort;
use crate::{Algorithm, Settings, algorithms};

/// An algorithm with its settings.
#[derive(Clone)]
pub(crate) struct Setup {
    pub(crate) algorithm: &'static Algorithm,
    /// As the sweep has it, "key=value,key=value"; empty for the defaults.
    pub(crate) setting: &'static str,
    pub(crate) settings: Settings,
}

impl Setup {
    /// In words.
    pub(crate) fn name(&self) -> String {
        match self.setting {
            "" => self.algorithm.name.into(),
            setting => format!("{} {setting}", self.algorithm.name),
        }
    }
}

/// The candidates under an optical model for a kind of volume, those whose settings come to the same there once.
pub(crate) fn candidates(model: OpticalModel, kind: VolumeKind, effort: Effort) -> Vec<Setup> {
    let mut setups: Vec<Setup> = Vec::new();
    for algorithm in algorithms() {
        let sweep: &[&str] = match effort {
            Effort::Full => (algorithm.sweep)(model),
            Effort::Quick => &[],
        };
        for setting in [""].into_iter().chain(sweep.iter().copied()) {
            let settings = Settings::parse(algorithm, setting.split(','));
            let settings = settings.expect("a test parses every sweep");
            let matter = |settings: &Settings| settings.that_matter(algorithm, kind);
            let same = |s: &Setup| {
                s.algorithm.name == algorithm.name && matter(&s.settings) == matter(&settings)
            };
            if !setups.iter().any(same) {
                setups.push(Setup {
                    algorithm,
                    setting,
                    settings,
                });
            }
        }
    }
    setups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_of_a_sweep_is_there_once() {
        for model in OpticalModel::ALL {
            for kind in [VolumeKind::Mesh, VolumeKind::Grid] {
                let setups = candidates(model, kind, Effort::Full);
                for algorithm in algorithms() {
                    let of = setups.iter().filter(|s| s.algorithm.name == algorithm.name);
                    let of: Vec<&Settings> = of.map(|setup| &setup.settings).collect();
                    assert!(of.contains(&&Settings::defaults(algorithm)));
                    let matter = |settings: &Settings| settings.that_matter(algorithm, kind);
                    for setting in (algorithm.sweep)(model) {
                        let settings = Settings::parse(algorithm, setting.split(','));
                        let wanted = matter(&settings.expect("valid"));
                        let same = of.iter().filter(|s| matter(s) == wanted);
                        assert_eq!(same.count(), 1, "{setting}");
                    }
                    let once = algorithm.sweep_of(model, kind).len();
                    assert!(of.len() == once || of.len() == once + 1);
                }
                let few = candidates(model, kind, Effort::Quick);
                assert_eq!(few.len(), algorithms().len());
            }
        }
    }

    // The tolerance of its segments is that of grids.
    #[test]
    fn a_setting_for_grids_is_nothing_to_choose_for_meshes() {
        let count = |kind| {
            let setups = candidates(OpticalModel::EmissionAbsorption, kind, Effort::Full);
            let of_grids = setups.iter().filter(|s| s.setting.contains("tolerance"));
            of_grids.count()
        };
        assert_eq!(count(VolumeKind::Mesh), 0);
        assert!(count(VolumeKind::Grid) > 0);
    }
}
