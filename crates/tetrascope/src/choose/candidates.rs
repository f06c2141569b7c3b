//! All that can be chosen: each algorithm with its defaults, and with what its entry has compared.

use tetrascope_core::OpticalModel;

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

/// The candidates under an optical model, those with the same settings once.
pub(crate) fn candidates(model: OpticalModel, effort: Effort) -> Vec<Setup> {
    let mut setups: Vec<Setup> = Vec::new();
    for algorithm in algorithms() {
        let sweep: &[&str] = match effort {
            Effort::Full => (algorithm.sweep)(model),
            Effort::Quick => &[],
        };
        for setting in [""].into_iter().chain(sweep.iter().copied()) {
            let settings = Settings::parse(algorithm, setting.split(','));
            let settings = settings.expect("a test parses every sweep");
            let same = |s: &Setup| s.algorithm.name == algorithm.name && s.settings == settings;
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
            let setups = candidates(model, Effort::Full);
            for algorithm in algorithms() {
                let of = setups.iter().filter(|s| s.algorithm.name == algorithm.name);
                let of: Vec<&Settings> = of.map(|setup| &setup.settings).collect();
                assert!(of.contains(&&Settings::defaults(algorithm)));
                for setting in (algorithm.sweep)(model) {
                    let settings = Settings::parse(algorithm, setting.split(',')).expect("valid");
                    assert_eq!(
                        of.iter().filter(|s| ***s == settings).count(),
                        1,
                        "{setting}"
                    );
                }
            }
            let few = candidates(model, Effort::Quick);
            assert_eq!(few.len(), algorithms().len());
        }
    }
}
