//! Demands on the entries of algorithms.

use tetrascope_core::{
    Appearance, Entry, FrameStats, OpticalModel, Settings, Values, View, Volume,
};

/// Panics if a value of a setting does not change the options, alone or with what the sweep
/// sets beside it.
pub fn every_setting_arrives<O: PartialEq>(entry: &Entry, options: fn(&Settings) -> O) {
    let sweeps = OpticalModel::ALL.into_iter().flat_map(entry.sweep);
    let bases: Vec<&str> = sweeps.copied().chain([""]).collect();
    for setting in entry.settings {
        let values: Vec<String> = match setting.values {
            Values::Choice(words) => words.iter().map(|word| (*word).into()).collect(),
            Values::Integer { min, max } => vec![min.to_string(), max.to_string()],
            Values::Number { min, max } => vec![min.to_string(), max.to_string()],
        };
        let number = |text: &str| text.parse::<f64>().ok();
        let is_default = |value: &str| {
            value == setting.default
                || number(value).is_some_and(|x| number(setting.default) == Some(x))
        };
        for value in values.iter().filter(|value| !is_default(value)) {
            let with = |base: &str, value: &str| {
                let pair = format!("{}={value}", setting.name);
                let settings = Settings::parse(entry, base.split(',').chain([pair.as_str()]));
                options(&settings.expect("listed"))
            };
            let changes = |base: &&str| with(base, value) != with(base, setting.default);
            assert!(
                bases.iter().any(changes),
                "{}={value} changes nothing",
                setting.name
            );
        }
    }
}

/// Why `entry` refuses a scene with settings such as "key=value,key=value" before there is a
/// device; panics if it does not.
pub fn refusal(
    entry: &Entry,
    settings: &str,
    (volume, appearance, view): (&Volume, &Appearance, &View),
) -> String {
    let parsed = Settings::parse(entry, settings.split(',')).expect("valid settings");
    match (entry.supports)(volume, appearance, view, &parsed) {
        Ok(()) => panic!("'{settings}' is not refused"),
        Err(error) => error.to_string(),
    }
}

/// Panics if a frame counts what `entry` does not list.
pub fn check_counts(entry: &Entry, stats: &FrameStats) {
    for count in &stats.counts {
        let listed = entry.counters.contains(&count.counter);
        assert!(listed, "{} does not list {count:?}", entry.name);
    }
}
