//! The page: what has changed, trends, work-precision diagrams and the papers' tables.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::history::{Estimate, History, NOISE, Place, Run, Verdict, verdict};
use super::papers::ShownPaper;
use super::precision::Precision;
use super::trend::{self, Point};
use crate::diagrams::style;
use crate::page::html;
use crate::panel::STYLES;

/// The data of the template.
#[derive(Serialize)]
struct Page<'a> {
    /// The last run: trends are of its machine.
    last: &'a Run,
    runs: usize,
    elsewhere: usize,
    noise: String,
    slower: Vec<Changed>,
    faster: Vec<Changed>,
    algorithms: Vec<Section>,
    precision: Option<&'a Precision>,
    papers: &'a [ShownPaper],
}

/// The benchmarks of an algorithm.
#[derive(Serialize)]
struct Section {
    algorithm: String,
    scenes: Vec<(String, Vec<Trend>)>,
}

/// One benchmark over the runs.
#[derive(Serialize)]
struct Trend {
    what: String,
    svg: String,
    runs: usize,
    median: String,
    interval: String,
    change: Option<Change>,
}

/// From the run before.
#[derive(Clone, Serialize)]
struct Change {
    percent: String,
    verdict: Verdict,
    since: String,
}

/// A benchmark that is slower or faster.
#[derive(Serialize)]
struct Changed {
    id: String,
    change: Change,
}

/// The page as HTML that needs no other file; `None` where the history is empty.
pub fn to_html(
    history: &History,
    precision: Option<&Precision>,
    papers: &[ShownPaper],
) -> Option<String> {
    let last = history.runs.last()?;
    let machine = &last.machine;
    let here = history.runs.iter().filter(|run| run.machine == *machine);
    let runs = here.clone().count();
    let ids: BTreeSet<&String> = here.flat_map(|run| run.results.keys()).collect();
    let mut sections: BTreeMap<&str, BTreeMap<String, Vec<Trend>>> = BTreeMap::new();
    let (mut slower, mut faster) = (Vec::new(), Vec::new());
    for id in ids {
        let [algorithm, scene, what] = parts(id);
        let trend = trend(history, id, machine, what)?;
        if let Some(change) = &trend.change {
            let changed = Changed {
                id: id.clone(),
                change: change.clone(),
            };
            match change.verdict {
                Verdict::Slower => slower.push(changed),
                Verdict::Faster => faster.push(changed),
                Verdict::Within => {}
            }
        }
        let scenes = sections.entry(algorithm).or_default();
        scenes.entry(scene.to_owned()).or_default().push(trend);
    }
    let sections = sections.into_iter().map(|(algorithm, scenes)| Section {
        algorithm: algorithm.into(),
        scenes: scenes.into_iter().collect(),
    });
    let page = Page {
        last,
        runs,
        elsewhere: history.runs.len() - runs,
        noise: format!("{:.0} %", 100.0 * NOISE),
        slower,
        faster,
        algorithms: sections.collect(),
        precision,
        papers,
    };
    Some(page.to_html())
}

/// Algorithm, scene with size, and what was timed.
fn parts(id: &str) -> [&str; 3] {
    let split = |text: &'_ str| text.find('/').map(|at| (at, at + 1));
    let Some((end, rest)) = split(id) else {
        return [id, "", id];
    };
    let (algorithm, rest) = (&id[..end], &id[rest..]);
    // "sphere/149k cells/frame/emission": two parts are the scene, where a third follows.
    let slashes: Vec<usize> = rest.match_indices('/').map(|(at, _)| at).collect();
    match slashes[..] {
        [] => [algorithm, "", rest],
        [one] => [algorithm, &rest[..one], &rest[one + 1..]],
        [_, two, ..] => [algorithm, &rest[..two], &rest[two + 1..]],
    }
}

fn trend(history: &History, id: &str, machine: &Place, what: &str) -> Option<Trend> {
    let all: Vec<(&Run, &Estimate)> = history.of(id, machine).collect();
    let label = |run: &Run| {
        let revision = run.revision.as_deref().unwrap_or("unknown revision");
        format!("{revision}, {}", run.date)
    };
    let points: Vec<Point> = all
        .iter()
        .map(|(run, estimate)| Point {
            label: label(run),
            estimate,
        })
        .collect();
    let (_, now) = all.last()?;
    let change = all.len().checked_sub(2).map(|before| {
        let (run, before) = all[before];
        Change {
            percent: format!("{:+.1} %", 100.0 * (now.median / before.median - 1.0)),
            verdict: verdict(before, now),
            since: label(run),
        }
    });
    let class = tetrascope::algorithm(parts(id)[0]).map_or(STYLES - 1, |a| style(a.name));
    Some(Trend {
        what: what.into(),
        svg: trend::svg(&points, class % STYLES)?,
        runs: all.len(),
        median: milliseconds(now.median),
        interval: format!("{} to {}", milliseconds(now.low), milliseconds(now.high)),
        change,
    })
}

impl Page<'_> {
    fn to_html(&self) -> String {
        html(include_str!("page.html"), self, |_| ())
    }
}

/// Nanoseconds as milliseconds: "0.123 ms".
pub(crate) fn milliseconds(nanoseconds: f64) -> String {
    format!("{} ms", short(nanoseconds / 1e6))
}

/// Three digits or so.
pub(crate) fn short(number: f64) -> String {
    match number.abs() {
        size if size >= 100.0 => format!("{number:.0}"),
        size if size >= 10.0 => format!("{number:.1}"),
        size if size >= 1.0 => format!("{number:.2}"),
        size if size >= 0.01 => format!("{number:.3}"),
        _ => format!("{number:.5}"),
    }
}

/// Text for XML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dashboard::criterion::Results;
    use crate::dashboard::history::tests::{measured, place};
    use crate::dashboard::papers;

    #[test]
    fn ids_have_an_algorithm_a_scene_and_what_was_timed() {
        let id = "projection/sphere/149k cells/frame/emission";
        assert_eq!(
            parts(id),
            ["projection", "sphere/149k cells", "frame/emission"]
        );
        assert_eq!(
            parts("voxel-hw/fin 8x8x8/float"),
            ["voxel-hw", "fin 8x8x8", "float"]
        );
        assert_eq!(parts("a/b"), ["a", "", "b"]);
        assert_eq!(parts("a"), ["a", "", "a"]);
    }

    #[test]
    fn numbers_have_three_digits() {
        let words = [0.001234, 0.0456, 1.234, 12.34, 1234.4, -200.0].map(short);
        assert_eq!(words, ["0.00123", "0.046", "1.23", "12.3", "1234", "-200"]);
    }

    #[test]
    fn the_page_flags_what_is_beyond_noise_and_needs_no_other_file() {
        let (slow, fast, same) = (
            "projection/<sphere>/1k cells/build",
            "projection/ball/1k cells/build",
            "slicing/ball/8 samples/frame",
        );
        let mut history = History::default();
        let first = [slow, fast, same].map(|id| measured(id, 10.0, 1));
        history.add(Some("aaa".into()), place("x"), &first);
        let other = [slow, fast, same].map(|id| measured(id, 99.0, 2));
        history.add(Some("bbb".into()), place("another adapter"), &other);
        let second = [(slow, 20.0), (fast, 5.0), (same, 10.5)].map(|(id, t)| measured(id, t, 3));
        history.add(Some("c<c".into()), place("x"), &second);
        let papers = papers::shown(&Results::default());
        let page = to_html(&history, None, &papers).expect("there are runs");
        let flagged = |heading: &str| {
            let start = page
                .find(heading)
                .unwrap_or_else(|| panic!("{heading}: {page}"));
            let list = &page[start..];
            list[..list.find("</ul>").expect("a list")].to_owned()
        };
        let slower = flagged("Slower");
        assert!(
            slower.contains("&lt;sphere&gt;") && slower.contains("+100.0 %"),
            "{slower}"
        );
        assert!(!slower.contains("ball"), "{slower}");
        let faster = flagged("Faster");
        assert!(
            faster.contains("projection&#x2f;ball") && faster.contains("-50.0 %"),
            "{faster}"
        );
        assert!(page.contains("1 slower") && page.contains("1 faster"));
        // The change is against the run on the same machine.
        assert!(page.contains("+5.0 %") && page.contains("1 run on other machines"));
        assert!(!page.contains("<sphere>") && !page.contains("c<c"));
        assert!(!page.contains("<script") && !page.contains("src=") && !page.contains("http"));
        for words in [
            "GeForce3, 64 MB",
            "Radeon 9700 Pro",
            "SGI Onyx IR2",
            "GeForce6",
            "no measurement",
        ] {
            assert!(page.contains(words), "{words}");
        }
    }

    #[test]
    fn nothing_measured_is_no_page() {
        assert!(to_html(&History::default(), None, &[]).is_none());
    }
}
