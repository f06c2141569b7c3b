//! The history of measurements: one record per run, in a JSON file that `history.md` describes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use tetrascope::core::Error;

use super::criterion::Measurement;
use crate::machine::utc;
use crate::output::write;
use crate::report::Machine;

/// The version of the file's layout: it grows when a field goes or changes its meaning, and not
/// when one is added.
pub const HISTORY_VERSION: u32 = 1;

/// The share by which a median may change before it is said to be slower or faster, beside that
/// intervals must not overlap: criterion's intervals know of one run alone.
///
/// It is meant for a machine that does nothing else. Where others used both of two cores, the same
/// program's medians of a frame were 863, 418 and 483 ms in three runs, and the first two intervals
/// did not overlap: there, only what runs in turn can be compared ([`crate::bench`]).
pub const NOISE: f64 = 0.1;

/// All runs, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// [`HISTORY_VERSION`].
    pub version: u32,
    /// One for each time that something new was found.
    pub runs: Vec<Run>,
}

/// The measurements of one state of the sources, on one machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The git revision, with "-dirty" where files were changed.
    pub revision: Option<String>,
    /// When the last benchmark of the run ended, UTC, as in RFC 3339.
    pub date: String,
    /// The place where it ran.
    pub machine: Place,
    /// By benchmark.
    pub results: BTreeMap<String, Estimate>,
}

/// The facts on which times depend beside the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The operating system.
    pub os: String,
    /// The processor's architecture.
    pub architecture: String,
    /// The processor's name.
    pub processor: Option<String>,
    /// Threads that run at a time.
    pub threads: usize,
    /// The graphics adapter: name, kind, backend, driver.
    pub adapter: Option<String>,
}

/// A median with its confidence interval, in nanoseconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The median.
    pub median: f64,
    /// The interval's lower end.
    pub low: f64,
    /// The interval's upper end.
    pub high: f64,
    /// Its confidence, "0.95".
    pub confidence: f64,
    /// When it was measured, UTC, as in RFC 3339.
    pub measured: String,
}

/// How a benchmark's time has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Beyond noise.
    Slower,
    /// Beyond noise.
    Faster,
    /// Intervals overlap, or the change is small.
    Within,
}

impl From<&Machine> for Place {
    fn from(machine: &Machine) -> Place {
        Place {
            os: machine.os.clone(),
            architecture: machine.architecture.clone(),
            processor: machine.processor.clone(),
            threads: machine.threads,
            adapter: machine.adapter.clone(),
        }
    }
}

impl From<&Measurement> for Estimate {
    fn from(measurement: &Measurement) -> Estimate {
        Estimate {
            median: measurement.median.value,
            low: measurement.median.low,
            high: measurement.median.high,
            confidence: measurement.median.confidence,
            measured: utc(measurement.measured),
        }
    }
}

/// How `after` compares with `before`.
pub fn verdict(before: &Estimate, after: &Estimate) -> Verdict {
    let ratio = after.median / before.median;
    if after.low > before.high && ratio > 1.0 + NOISE {
        Verdict::Slower
    } else if after.high < before.low && ratio < 1.0 / (1.0 + NOISE) {
        Verdict::Faster
    } else {
        Verdict::Within
    }
}

impl Default for History {
    fn default() -> History {
        History {
            version: HISTORY_VERSION,
            runs: Vec::new(),
        }
    }
}

impl History {
    /// Reads a history; an empty one where there is no such file.
    ///
    /// # Errors
    /// A file that cannot be read, is not a history, or is one of another version.
    pub fn read(path: &Path) -> Result<History, Error> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(History::default());
            }
            Err(source) => {
                return Err(Error::Io {
                    action: "cannot read",
                    path: path.into(),
                    source,
                });
            }
        };
        let wrong = |at: String, what: String| Error::Format {
            path: path.into(),
            at,
            what,
            help: Some("choose another file with `--history`, or delete this one".into()),
        };
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let place =
            |error: &serde_json::Error| format!("line {}, column {}", error.line(), error.column());
        let parsed: Result<Version, _> = serde_json::from_slice(&bytes);
        let Version { version } =
            parsed.map_err(|e| wrong(place(&e), format!("not a history of measurements: {e}")))?;
        if version != HISTORY_VERSION {
            let what =
                format!("a history of version {version}, this program reads {HISTORY_VERSION}");
            return Err(wrong("field 'version'".into(), what));
        }
        let history: Result<History, _> = serde_json::from_slice(&bytes);
        let history =
            history.map_err(|e| wrong(place(&e), format!("not a history of measurements: {e}")))?;
        history
            .check()
            .map_err(|(id, what)| wrong(format!("benchmark '{id}'"), what))?;
        Ok(history)
    }

    /// Whether times are positive numbers within their intervals: pages divide by them.
    fn check(&self) -> Result<(), (String, String)> {
        for (id, e) in self.runs.iter().flat_map(|run| &run.results) {
            let is_plain = e.low > 0.0 && e.high.is_finite();
            let is_within = e.low <= e.median && e.median <= e.high;
            if !(is_plain && is_within) {
                let what = format!("a median of {} ns in {} to {}", e.median, e.low, e.high);
                return Err((id.clone(), what));
            }
        }
        Ok(())
    }

    /// Writes the history.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let mut json = serde_json::to_string_pretty(self).expect("a history is plain data");
        json.push('\n');
        write(path, json)
    }

    /// Adds a run with those measurements that are in no run yet; how many these are.
    pub fn add(
        &mut self,
        revision: Option<String>,
        machine: Place,
        measurements: &[Measurement],
    ) -> usize {
        let known: BTreeSet<(&str, &str, u64)> = self
            .runs
            .iter()
            .flat_map(|run| &run.results)
            .map(|(id, e)| (id.as_str(), e.measured.as_str(), e.median.to_bits()))
            .collect();
        let mut results = BTreeMap::new();
        let mut last = SystemTime::UNIX_EPOCH;
        for measurement in measurements {
            let estimate = Estimate::from(measurement);
            let bits = estimate.median.to_bits();
            if !known.contains(&(&measurement.id, &estimate.measured, bits)) {
                last = last.max(measurement.measured);
                results.insert(measurement.id.clone(), estimate);
            }
        }
        let count = results.len();
        if count > 0 {
            self.runs.push(Run {
                revision,
                date: utc(last),
                machine,
                results,
            });
        }
        count
    }

    /// The estimates of a benchmark on a machine, oldest first, each with its run.
    pub fn of<'a>(
        &'a self,
        id: &'a str,
        machine: &'a Place,
    ) -> impl Iterator<Item = (&'a Run, &'a Estimate)> {
        let runs = self.runs.iter().filter(move |run| run.machine == *machine);
        runs.filter_map(move |run| Some((run, run.results.get(id)?)))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::dashboard::criterion::Interval;
    use std::time::Duration;

    pub(crate) fn place(adapter: &str) -> Place {
        Place {
            os: "linux".into(),
            architecture: "x86_64".into(),
            processor: Some("of a test".into()),
            threads: 2,
            adapter: Some(adapter.into()),
        }
    }

    /// A measurement whose interval reaches a twentieth to both sides.
    pub(crate) fn measured(id: &str, milliseconds: f64, second: u64) -> Measurement {
        let median = 1e6 * milliseconds;
        let (group, _) = id.rsplit_once('/').expect("a group");
        Measurement {
            id: id.into(),
            group: group.into(),
            value: None,
            elements: None,
            median: Interval {
                value: median,
                low: 0.95 * median,
                high: 1.05 * median,
                confidence: 0.95,
            },
            measured: SystemTime::UNIX_EPOCH + Duration::from_secs(second),
        }
    }

    fn estimate(median: f64, reach: f64) -> Estimate {
        Estimate {
            median,
            low: median - reach,
            high: median + reach,
            confidence: 0.95,
            measured: String::new(),
        }
    }

    const ID: &str = "projection/sphere/149k cells/build";

    #[test]
    fn a_history_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deep").join("history.json");
        let mut history = History::read(&path).expect("nothing is an empty history");
        assert_eq!(history, History::default());
        let revision = || Some("abc".into());
        assert_eq!(
            history.add(revision(), place("a"), &[measured(ID, 0.1, 9)]),
            1
        );
        history.write(&path).expect("writable");
        assert_eq!(History::read(&path).expect("a history"), history);
        assert_eq!(history.runs[0].date, "1970-01-01T00:00:09Z");
    }

    #[test]
    fn the_same_measurement_is_not_added_twice() {
        let mut history = History::default();
        let first = measured(ID, 5.0, 10);
        let other = measured("slicing/ball/8/frame", 5.0, 10);
        assert_eq!(
            history.add(None, place("a"), std::slice::from_ref(&first)),
            1
        );
        assert_eq!(
            history.add(Some("b".into()), place("a"), std::slice::from_ref(&first)),
            0
        );
        assert_eq!(history.runs.len(), 1);
        // Beside a new one, the old one is left out; measured again, it is new.
        assert_eq!(history.add(None, place("a"), &[first, other]), 1);
        assert_eq!(history.runs[1].results.len(), 1);
        assert_eq!(history.add(None, place("a"), &[measured(ID, 5.0, 11)]), 1);
    }

    #[test]
    fn only_what_is_beyond_noise_and_intervals_is_slower_or_faster() {
        let before = estimate(100.0, 2.0);
        assert_eq!(verdict(&before, &estimate(120.0, 3.0)), Verdict::Slower);
        assert_eq!(verdict(&before, &estimate(80.0, 3.0)), Verdict::Faster);
        // Intervals overlap.
        assert_eq!(verdict(&before, &estimate(120.0, 18.0)), Verdict::Within);
        assert_eq!(verdict(&before, &estimate(80.0, 18.0)), Verdict::Within);
        // They do not, and the change is small.
        assert_eq!(verdict(&before, &estimate(109.0, 1.0)), Verdict::Within);
        assert_eq!(verdict(&before, &estimate(92.0, 1.0)), Verdict::Within);
    }

    #[test]
    fn another_machine_is_not_compared() {
        let mut history = History::default();
        for (second, adapter) in [(1, "a"), (2, "b"), (3, "a")] {
            history.add(None, place(adapter), &[measured(ID, second as f64, second)]);
        }
        let of = |adapter| -> Vec<f64> {
            let place = place(adapter);
            history
                .of(ID, &place)
                .map(|(_, e)| e.median / 1e6)
                .collect()
        };
        assert_eq!(of("a"), [1.0, 3.0]);
        assert_eq!(of("b"), [2.0]);
        assert!(of("c").is_empty());
    }

    #[test]
    fn a_file_that_is_no_history_is_refused_in_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("history.json");
        let bad = r#"{"version":1,"runs":[{"revision":null,"date":"","machine":{"os":"","architecture":"",
            "processor":null,"threads":1,"adapter":null},"results":{"x/y":{"median":0,"low":0,"high":0,
            "confidence":0.95,"measured":""}}}]}"#;
        for (text, words) in [
            ("", "not a history"),
            ("[]", "not a history"),
            ("{\"version\": 1}", "not a history"),
            ("{\"version\": 99, \"runs\": []}", "version 99"),
            (bad, "x/y"),
        ] {
            std::fs::write(&path, text).expect("written");
            let error = History::read(&path).expect_err(text).to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        let folder = History::read(folder.path());
        assert!(folder.is_err_and(|error| error.to_string().contains("cannot read")));
    }

    #[test]
    fn every_field_is_described() {
        let mut history = History::default();
        history.add(Some("abc".into()), place("a"), &[measured(ID, 1.0, 1)]);
        let json = serde_json::to_value(&history).expect("plain data");
        let run = &json["runs"][0];
        let description = include_str!("../../history.md");
        for object in [&json, run, &run["machine"], &run["results"][ID]] {
            for name in object.as_object().expect("an object").keys() {
                assert!(description.contains(&format!("`{name}`")), "{name}");
            }
        }
        let title = format!("# history.json, version {HISTORY_VERSION}\n");
        assert!(description.starts_with(&title));
    }
}
