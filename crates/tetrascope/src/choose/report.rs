//! The choice and its reasons, in words.

use std::fmt;

use super::{Choice, Expected, Found, GivesWay, SampledError, Trial};

impl Choice {
    /// The choice and its reasons, the expectations and the findings, one line each; a demand that
    /// [gives way](Choice::gives_way) says so itself.
    pub fn report(&self) -> Vec<String> {
        let mut lines = vec![
            format!("chose {}: {}", self.trial.name, self.why()),
            format!("  expected {}", self.trial.expected),
            format!("  came out {}", self.trial.found),
        ];
        let others = self.trials.iter().filter(|t| t.name != self.trial.name);
        lines.extend(others.map(|trial| format!("  tried {}: {}", trial.name, trial.short())));
        lines.extend(
            self.failures
                .iter()
                .map(|why| format!("  not drawn: {why}")),
        );
        lines
    }

    /// The number of settings of which it is the best, and in which way.
    fn why(&self) -> String {
        let of = |count: usize| match count {
            1 => "the only setting there is".into(),
            _ => format!("of {count} settings, {} tried,", self.trials.len()),
        };
        let of = of(self.considered);
        let error = self.need.error.map(|e| format!("{e:e}"));
        match (error, self.gives_way.first()) {
            (Some(error), Some(GivesWay::Error { .. })) => {
                format!("{of} none is known to keep an RMSE of {error}, and this is the nearest")
            }
            (Some(error), _) => format!("{of} the fastest found to keep an RMSE of {error}"),
            (None, Some(_)) => format!("{of} the fastest"),
            (None, None) => match self.need.budget {
                Some(budget) => {
                    let budget = seconds(budget.as_secs_f64());
                    format!("{of} the most exact found within {budget}")
                }
                None => format!("{of} the most exact found"),
            },
        }
    }
}

impl Trial {
    fn short(&self) -> String {
        let Found {
            seconds: s, error, ..
        } = &self.found;
        format!(
            "{} (expected {}), RMSE {:.1e}",
            seconds(*s),
            seconds(self.expected.seconds),
            error.rmse
        )
    }
}

/// In one line.
impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = (self.seconds / self.spread, self.seconds * self.spread);
        let [least, greatest] = self.error;
        write!(
            f,
            "{} ({} to {}), RMSE {least:.0e} to {greatest:.0e}, {}",
            seconds(self.seconds),
            seconds(low),
            seconds(high),
            bytes(self.bytes)
        )
    }
}

/// In one line.
impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} after {} to prepare, {}, {}",
            seconds(self.seconds),
            seconds(self.prepare),
            self.error,
            bytes(self.bytes as f64)
        )
    }
}

/// In one line.
impl fmt::Display for SampledError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SampledError {
            sampled,
            pixels,
            rmse,
            upper,
            greatest,
        } = self;
        write!(f, "RMSE {rmse:.1e}")?;
        if sampled < pixels {
            write!(
                f,
                " (below {upper:.1e} at 95 %, by the truth in {sampled} of {pixels} pixels)"
            )?;
        }
        write!(f, ", at most {greatest:.1e} there")
    }
}

/// In one line.
impl fmt::Display for GivesWay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GivesWay::Error { wanted, found } => {
                write!(
                    f,
                    "the error gives way: RMSE {found:.1e} in place of {wanted:e}"
                )
            }
            GivesWay::Budget { wanted, found } => write!(
                f,
                "the budget gives way: {} in place of {}, {:.1} times as long",
                seconds(*found),
                seconds(*wanted),
                found / wanted
            ),
        }
    }
}

/// A time with three digits.
fn seconds(seconds: f64) -> String {
    let (number, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    format!("{} {unit}", three_digits(number))
}

/// A size with three digits, in decimal units.
pub(crate) fn bytes(bytes: f64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB"];
    let mut number = bytes;
    let mut unit = 0;
    while number >= 999.5 && unit + 1 < units.len() {
        number /= 1e3;
        unit += 1;
    }
    format!("{} {}", three_digits(number), units[unit])
}

fn three_digits(number: f64) -> String {
    let decimals = match number {
        n if n < 9.995 => 2,
        n if n < 99.95 => 1,
        _ => 0,
    };
    format!("{number:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_a_unit() {
        for (number, text) in [
            (0.0123, "12.3 ms"),
            (1.5, "1.50 s"),
            (123.4, "123 s"),
            (4.5e-5, "45.0 µs"),
        ] {
            assert_eq!(seconds(number), text);
        }
        for (number, text) in [
            (12.0, "12.0 B"),
            (999.7, "1.00 kB"),
            (2.5e9, "2.50 GB"),
            (512e6, "512 MB"),
        ] {
            assert_eq!(bytes(number), text);
        }
    }

    #[test]
    fn what_gives_way_says_by_how_much() {
        let budget = GivesWay::Budget {
            wanted: 0.016,
            found: 0.04,
        };
        assert_eq!(
            budget.to_string(),
            "the budget gives way: 40.0 ms in place of 16.0 ms, 2.5 times as long"
        );
        let error = GivesWay::Error {
            wanted: 1e-9,
            found: 2e-8,
        };
        assert_eq!(
            error.to_string(),
            "the error gives way: RMSE 2.0e-8 in place of 1e-9"
        );
    }
}
