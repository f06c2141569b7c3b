//! The files in which criterion keeps its results.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Deserialize;
use serde::de::DeserializeOwned;

/// All results in a folder.
#[derive(Debug, Default)]
pub struct Results {
    /// Measurements, by id.
    pub measurements: Vec<Measurement>,
    /// Counts beside times, by id.
    pub counted: BTreeMap<String, f64>,
    /// Files that are not criterion's, or of another version of it.
    pub unreadable: Vec<PathBuf>,
}

/// Criterion's findings of one benchmark.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// "projection/sphere/149k cells/build".
    pub id: String,
    /// "projection/sphere/149k cells".
    pub group: String,
    /// The parameter, where it has one.
    pub value: Option<String>,
    /// Cells that one iteration goes through, where the benchmark says it.
    pub elements: Option<u64>,
    /// Time of one iteration.
    pub median: Interval,
    /// When the result was written.
    pub measured: SystemTime,
}

/// A number and the ends of its confidence interval; in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// "0.95".
    pub confidence: f64,
}

#[derive(Deserialize)]
struct Benchmark {
    group_id: String,
    value_str: Option<String>,
    full_id: String,
    throughput: Option<Throughput>,
}

#[derive(Deserialize)]
enum Throughput {
    Elements(u64),
    #[serde(untagged)]
    Other(serde::de::IgnoredAny),
}

#[derive(Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    point_estimate: f64,
    confidence_interval: ConfidenceInterval,
}

#[derive(Deserialize)]
struct ConfidenceInterval {
    confidence_level: f64,
    lower_bound: f64,
    upper_bound: f64,
}

/// Folders in folders: group, function and parameter, and "new".
const DEPTH: usize = 4;

/// The results in criterion's folder, sorted by id; none where there is no such folder.
pub fn read(folder: &Path) -> Results {
    let mut results = Results {
        counted: tetrascope_benches::results::kept(folder),
        ..Results::default()
    };
    let mut level = vec![folder.to_path_buf()];
    for _ in 0..DEPTH {
        level = level.iter().flat_map(|folder| folders(folder)).collect();
        for place in level.iter().filter(|path| path.ends_with("new")) {
            match result(place) {
                Some(found) => results.measurements.push(found),
                None => results.unreadable.push(place.clone()),
            }
        }
    }
    results.measurements.sort_by(|a, b| a.id.cmp(&b.id));
    results
}

/// The folders in a folder, or none.
fn folders(of: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(of) else {
        return Vec::new();
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.is_dir()).collect()
}

fn result(folder: &Path) -> Option<Measurement> {
    let estimates = folder.join("estimates.json");
    let benchmark: Benchmark = json(&folder.join("benchmark.json"))?;
    let Estimates { median } = json(&estimates)?;
    let interval = Interval {
        value: median.point_estimate,
        low: median.confidence_interval.lower_bound,
        high: median.confidence_interval.upper_bound,
        confidence: median.confidence_interval.confidence_level,
    };
    let is_plain = interval.low > 0.0 && interval.high.is_finite();
    let is_ordered = interval.low <= interval.value && interval.value <= interval.high;
    (is_plain && is_ordered).then_some(())?;
    Some(Measurement {
        id: benchmark.full_id,
        group: benchmark.group_id,
        value: benchmark.value_str,
        elements: match benchmark.throughput {
            Some(Throughput::Elements(elements)) => Some(elements),
            _ => None,
        },
        median: interval,
        measured: estimates.metadata().and_then(|m| m.modified()).ok()?,
    })
}

fn json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A result as criterion lays it out: the last part of `id` is a parameter if `has_value`.
    pub(crate) fn write(folder: &Path, id: &str, has_value: bool, nanoseconds: f64) {
        let (group, last) = id.rsplit_once('/').expect("a group and a function");
        let place = folder.join(group.replace('/', "_")).join(last).join("new");
        std::fs::create_dir_all(&place).expect("made");
        let (function, value) = match has_value {
            true => ("null".to_owned(), format!("\"{last}\"")),
            false => (format!("\"{last}\""), "null".to_owned()),
        };
        let benchmark = format!(
            r#"{{"group_id":"{group}","function_id":{function},"value_str":{value},
                "throughput":{{"Elements":1000}},"full_id":"{id}","directory_name":"","title":""}}"#
        );
        let (low, high) = (0.9 * nanoseconds, 1.1 * nanoseconds);
        let estimate = format!(
            r#"{{"confidence_interval":{{"confidence_level":0.95,"lower_bound":{low},
                "upper_bound":{high}}},"point_estimate":{nanoseconds},"standard_error":1}}"#
        );
        let estimates = format!(r#"{{"mean":{estimate},"median":{estimate},"slope":null}}"#);
        std::fs::write(place.join("benchmark.json"), benchmark).expect("written");
        std::fs::write(place.join("estimates.json"), estimates).expect("written");
    }

    #[test]
    fn results_are_read_and_what_is_broken_is_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(folder.path(), "slicing/figure 4/ball/16", true, 2e9);
        write(folder.path(), "projection/ball/1k cells/build", false, 1e6);
        let broken = folder.path().join("broken").join("build").join("new");
        std::fs::create_dir_all(&broken).expect("made");
        std::fs::write(broken.join("benchmark.json"), "{").expect("written");
        std::fs::create_dir_all(folder.path().join("report")).expect("made");
        let results = read(folder.path());
        let ids: Vec<&str> = results.measurements.iter().map(|m| m.id.as_str()).collect();
        assert_eq!(
            ids,
            ["projection/ball/1k cells/build", "slicing/figure 4/ball/16"]
        );
        let built = &results.measurements[0];
        assert_eq!((built.value.as_ref(), built.elements), (None, Some(1000)));
        assert_eq!((built.median.value, built.median.low), (1e6, 9e5));
        assert_eq!(built.median.confidence, 0.95);
        assert_eq!(results.measurements[1].value.as_deref(), Some("16"));
        assert_eq!(results.unreadable, [broken]);
        assert!(read(&folder.path().join("nothing")).measurements.is_empty());
    }

    #[test]
    fn estimates_that_make_no_sense_are_unreadable() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(folder.path(), "a/b/c/build", false, -1.0);
        let results = read(folder.path());
        assert!(results.measurements.is_empty());
        assert_eq!(results.unreadable.len(), 1);
    }
}
