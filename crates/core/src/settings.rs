//! The quality settings of an algorithm, as text: `order=centroid`.

use std::fmt;

use crate::{Entry, Error, VolumeKind};

/// A quality setting that an algorithm offers.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Kebab-case.
    pub name: &'static str,
    /// Its effect, in one line.
    pub about: &'static str,
    /// The values that it takes.
    pub values: Values,
    /// Its value unless it is set; one of `values`.
    pub default: &'static str,
    /// The one kind of volume for which it changes anything; `None` if it does for all that are drawn.
    pub only: Option<VolumeKind>,
}

/// The values that a [`Setting`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A whole number from `min` to `max`.
    Integer {
        /// The least.
        min: i64,
        /// The greatest.
        max: i64,
    },
    /// A number from `min` to `max`.
    Number {
        /// The least.
        min: f64,
        /// The greatest.
        max: f64,
    },
}

/// Gives enums `ALL` choices with their words, for settings.
///
/// ```
/// #[derive(Debug, PartialEq)]
/// pub enum Storage {
///     Auto,
///     Bricks,
/// }
/// tetrascope_core::choices! {
///     Storage: "auto" = Auto, "bricks" = Bricks;
/// }
/// assert_eq!(Storage::ALL[1], ("bricks", Storage::Bricks));
/// ```
#[macro_export]
macro_rules! choices {
    ($($choice:ident: $($word:literal = $variant:ident $(($value:expr))?),+;)+) => {
        $(impl $choice {
            /// Every choice, with its word in settings.
            pub const ALL: [(&'static str, $choice); [$($word),+].len()] =
                [$(($word, $choice::$variant $(($value))?)),+];
        })+
    };
}

/// The words of all choices, for [`Values::Choice`].
pub const fn words<T, const N: usize>(all: &[(&'static str, T); N]) -> [&'static str; N] {
    let mut words = [""; N];
    let mut i = 0;
    while i < N {
        words[i] = all[i].0;
        i += 1;
    }
    words
}

impl Setting {
    /// One of `words`, by [`words`].
    pub const fn choice(
        name: &'static str,
        words: &'static [&'static str],
        default: &'static str,
    ) -> Setting {
        Setting::of(name, Values::Choice(words), default)
    }

    /// A whole number in a range.
    pub const fn integer(
        name: &'static str,
        [min, max]: [i64; 2],
        default: &'static str,
    ) -> Setting {
        Setting::of(name, Values::Integer { min, max }, default)
    }

    /// A number in a range.
    pub const fn number(
        name: &'static str,
        [min, max]: [f64; 2],
        default: &'static str,
    ) -> Setting {
        Setting::of(name, Values::Number { min, max }, default)
    }

    const fn of(name: &'static str, values: Values, default: &'static str) -> Setting {
        let about = "";
        Setting {
            name,
            about,
            values,
            default,
            only: None,
        }
    }

    /// The same; for other kinds of volume it changes nothing.
    pub const fn only(self, kind: VolumeKind) -> Setting {
        Setting {
            only: Some(kind),
            ..self
        }
    }

    /// Whether it may change anything for this kind of volume.
    pub fn matters_for(&self, kind: VolumeKind) -> bool {
        self.only.is_none_or(|only| only == kind)
    }

    /// The same, and what it changes.
    pub const fn about(self, about: &'static str) -> Setting {
        Setting { about, ..self }
    }
}

impl Values {
    /// Whether `text` is one of them.
    pub fn contain(&self, text: &str) -> bool {
        match self {
            Values::Choice(words) => words.contains(&text),
            Values::Integer { min, max } => {
                text.parse().is_ok_and(|n: i64| (*min..=*max).contains(&n))
            }
            Values::Number { min, max } => {
                text.parse().is_ok_and(|x: f64| (*min..=*max).contains(&x))
            }
        }
    }
}

/// The words, or the range as `1…64`.
impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Values::Choice(words) => f.write_str(&words.join(", ")),
            Values::Integer { min, max } => write!(f, "{min}…{max}"),
            Values::Number { min, max } => write!(f, "{min}…{max}"),
        }
    }
}

/// A value for every setting of one algorithm.
///
/// `Display` writes them as [`Settings::parse`] reads them, comma-separated.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    values: Vec<(&'static str, String)>,
}

impl Settings {
    /// The defaults of `algorithm`, changed by `pairs` of the form `key=value`.
    ///
    /// The last of several values for one key counts, and empty pairs are passed
    /// over, so that a comma-separated list can be split and given. An unknown key
    /// or value is an [`Error::Unknown`] that lists the valid ones.
    pub fn parse<'a>(
        algorithm: &Entry,
        pairs: impl IntoIterator<Item = &'a str>,
    ) -> Result<Settings, Error> {
        let mut settings = Settings::defaults(algorithm);
        for pair in pairs.into_iter().map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
            let unknown = |valid| Error::Unknown {
                kind: "setting",
                name: pair.into(),
                valid,
            };
            let place = algorithm.settings.iter().position(|s| s.name == key);
            let Some(place) = place else {
                return Err(unknown(valid_pairs(algorithm)));
            };
            let setting = &algorithm.settings[place];
            if !setting.values.contain(value) {
                return Err(unknown(valid_values(setting)));
            }
            settings.values[place].1 = value.into();
        }
        Ok(settings)
    }

    /// Every setting of `algorithm` at its default.
    pub fn defaults(algorithm: &Entry) -> Settings {
        let values = algorithm.settings.iter();
        Settings {
            values: values.map(|s| (s.name, s.default.into())).collect(),
        }
    }

    /// Those that matter for this kind of volume, which the algorithm must have: where these are equal,
    /// pictures are.
    pub fn that_matter(&self, algorithm: &Entry, kind: VolumeKind) -> Settings {
        let matters = |name: &str| {
            let setting = algorithm.settings.iter().find(|s| s.name == name);
            setting.is_some_and(|setting| setting.matters_for(kind))
        };
        let values = self.values.iter().filter(|(name, _)| matters(name));
        Settings {
            values: values.cloned().collect(),
        }
    }

    /// Those that are not at their defaults, and change nothing for this kind of volume all the same: a
    /// sentence each.
    pub fn idle(&self, algorithm: &Entry, kind: VolumeKind) -> Vec<String> {
        let settings = algorithm.settings.iter();
        let idle = settings.filter_map(|setting| {
            let only = setting.only.filter(|only| *only != kind)?;
            let is_set = self.get(setting.name) != setting.default;
            is_set.then(|| {
                let name = setting.name;
                format!("`{name}` is for {}, and changes nothing here", only.name())
            })
        });
        idle.collect()
    }

    /// Names and values, in the algorithm's order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.values
            .iter()
            .map(|(name, value)| (*name, value.as_str()))
    }

    /// The value of `name`, which the algorithm must have: its entry lists what it reads.
    pub fn get(&self, name: &str) -> &str {
        let found = self.values.iter().find(|(n, _)| *n == name);
        &found.expect("the entry lists this setting").1
    }

    /// The choice of setting `name` among `all`, whose [`words`] it takes.
    pub fn choice<T: Copy>(&self, name: &str, all: &[(&str, T)]) -> T {
        let value = self.get(name);
        let found = all.iter().find(|(word, _)| *word == value);
        found.expect("checked by `parse`").1
    }

    /// The value of `name`, a [`Values::Integer`].
    pub fn integer(&self, name: &str) -> i64 {
        self.get(name).parse().expect("checked by `parse`")
    }

    /// The value of `name`, a [`Values::Number`].
    pub fn number(&self, name: &str) -> f64 {
        self.get(name).parse().expect("checked by `parse`")
    }
}

impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (name, value)) in self.values.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{name}={value}")?;
        }
        Ok(())
    }
}

/// `key=value` for every value of every setting.
fn valid_pairs(algorithm: &Entry) -> Vec<String> {
    if algorithm.settings.is_empty() {
        return vec![format!("none, as {} has no settings", algorithm.name)];
    }
    algorithm.settings.iter().flat_map(valid_values).collect()
}

fn valid_values(setting: &Setting) -> Vec<String> {
    match setting.values {
        Values::Choice(words) => words
            .iter()
            .map(|word| format!("{}={word}", setting.name))
            .collect(),
        range => vec![format!("{}={range}", setting.name)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Promise;

    const ORDERS: [(&str, u8); 2] = [("exact", 0), ("fast", 1)];

    /// An algorithm with a setting of each kind.
    const FAKE: Entry = Entry {
        name: "fake",
        title: "",
        paper: "",
        draws: "",
        settings: &[
            Setting::choice("order", &words(&ORDERS), "exact"),
            Setting::integer("samples", [1, 64], "4"),
            Setting::number("bias", [0.0, 1.0], "0.5"),
        ],
        sweep: |_| &[""],
        sources: &[],
        figures: None,
        counters: &[],
        promise: |_| Promise::Exact,
        supports: |_, _, _, _| Ok(()),
    };

    #[test]
    fn settings_start_from_defaults_and_print_as_they_parse() {
        let settings = Settings::parse(&FAKE, ["", "samples=8", "order=fast", "samples=9"])
            .expect("valid settings");
        assert_eq!(settings.to_string(), "order=fast,samples=9,bias=0.5");
        assert_eq!(settings.get("order"), "fast");
        assert_eq!(settings.choice("order", &ORDERS), 1);
        assert_eq!(settings.integer("samples"), 9);
        assert_eq!(settings.number("bias"), 0.5);
        let text = settings.to_string();
        assert_eq!(
            Settings::parse(&FAKE, text.split(',')).expect("as printed"),
            settings
        );
    }

    #[test]
    fn a_wrong_setting_lists_the_valid_ones() {
        let error = |pair| {
            Settings::parse(&FAKE, [pair])
                .expect_err("a wrong setting")
                .to_string()
        };
        let every = "order=exact, order=fast, samples=1…64, bias=0…1";
        assert_eq!(
            error("odrer=fast"),
            format!("no setting 'odrer=fast'; valid: {every}")
        );
        assert_eq!(
            error("order=slow"),
            "no setting 'order=slow'; valid: order=exact, order=fast"
        );
        for wrong in ["samples=0", "samples=65", "samples=1.5", "samples"] {
            assert_eq!(
                error(wrong),
                format!("no setting '{wrong}'; valid: samples=1…64")
            );
        }
        for wrong in ["bias=nan", "bias=inf", "bias=-0.1", "bias="] {
            assert_eq!(
                error(wrong),
                format!("no setting '{wrong}'; valid: bias=0…1")
            );
        }
    }
}
