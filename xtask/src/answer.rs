//! The answer of a comparison: which algorithm for which need.

use std::fmt::Write as _;

use serde::Serialize;

use crate::diagrams::{style, words};
use crate::panel::{STYLES, mark};
use crate::report::{Outcome, Report, SceneReport};

/// The errors (RMSE) within which the fastest setting is looked for.
pub const WITHIN: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The best settings of each scene and optical model.
#[derive(Debug, Serialize)]
pub struct Answer {
    /// How often which algorithm is best, a sentence for each need.
    pub sentences: Vec<String>,
    /// By scene and optical model.
    pub lines: Vec<AnswerLine>,
}

/// The best settings of one scene and optical model.
#[derive(Debug, Serialize)]
pub struct AnswerLine {
    /// The scene's place in the report, from 1, as the page counts.
    pub scene_number: usize,
    /// The scene's name.
    pub scene: String,
    /// The optical model.
    pub model: String,
    /// The fastest within each of [`WITHIN`], then the most exact; `None` where there is none.
    pub best: Vec<Option<Choice>>,
}

/// A setting that is best at something.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The algorithm.
    pub algorithm: String,
    /// The class of its color.
    pub class: String,
    /// Its marker, in SVG.
    pub mark: &'static str,
    /// The setting in few words.
    pub setting: String,
    /// The time of a frame, milliseconds.
    pub frame_ms: f64,
    /// The RMSE.
    pub rmse: f64,
}

impl Answer {
    /// The answer of a report; `None` where nothing is compared with a truth.
    pub fn of(report: &Report) -> Option<Answer> {
        let scenes = report.scenes.iter().enumerate();
        let lines: Vec<AnswerLine> = scenes.flat_map(|(s, scene)| lines(s + 1, scene)).collect();
        if lines.is_empty() {
            return None;
        }
        Some(Answer {
            sentences: sentences(&lines),
            lines,
        })
    }
}

fn lines(scene_number: usize, scene: &SceneReport) -> Vec<AnswerLine> {
    let mut lines = Vec::new();
    for model in &scene.models {
        let choices: Vec<Choice> = model
            .rows
            .iter()
            .filter_map(|row| {
                let Outcome::Drawn(drawn) = &row.outcome else {
                    return None;
                };
                Some(Choice {
                    algorithm: row.algorithm.clone(),
                    class: format!("s{}", style(&row.algorithm) % STYLES),
                    mark: mark(style(&row.algorithm)),
                    setting: words(&row.setting),
                    frame_ms: drawn.frame_ms,
                    rmse: drawn.error.as_ref()?.image.rmse,
                })
            })
            .collect();
        if choices.is_empty() {
            continue;
        }
        // What is within the truth's own error is equally exact: then the fastest is best.
        let floor = model.truth_bound.unwrap_or(0.0);
        let error = |choice: &Choice| choice.rmse.max(floor);
        let fastest = |within: f64| {
            let within = choices.iter().filter(|choice| choice.rmse <= within);
            within.min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms))
        };
        let most_exact = choices
            .iter()
            .filter(|c| c.rmse.is_finite())
            .min_by(|a, b| {
                let by_error = error(a).total_cmp(&error(b));
                by_error.then(a.frame_ms.total_cmp(&b.frame_ms))
            });
        let best = WITHIN.into_iter().map(fastest).chain([most_exact]);
        lines.push(AnswerLine {
            scene_number,
            scene: scene.name.clone(),
            model: model.model.clone(),
            best: best.map(Option::<&Choice>::cloned).collect(),
        });
    }
    lines
}

/// For each need, how many pictures each algorithm is best in, the most frequent first.
fn sentences(lines: &[AnswerLine]) -> Vec<String> {
    let needs = WITHIN.map(|within| format!("Fastest within an RMSE of {within:e}"));
    let needs = needs.into_iter().chain(["Most exact".into()]);
    needs
        .enumerate()
        .map(|(need, name)| {
            let mut counts: Vec<(&str, usize)> = Vec::new();
            for choice in lines.iter().map(|line| &line.best[need]) {
                let algorithm = choice.as_ref().map_or("none", |choice| &choice.algorithm);
                match counts.iter_mut().find(|(name, _)| *name == algorithm) {
                    Some((_, count)) => *count += 1,
                    None => counts.push((algorithm, 1)),
                }
            }
            // Stable: equal counts stay in the order of their first picture.
            counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
            let mut sentence = format!("{name}: ");
            for (i, (algorithm, count)) in counts.iter().enumerate() {
                let comma = if i > 0 { ", " } else { "" };
                _ = match i {
                    0 => write!(
                        sentence,
                        "{algorithm} in {count} of {} pictures",
                        lines.len()
                    ),
                    _ => write!(sentence, "{comma}{algorithm} in {count}"),
                };
            }
            sentence.push('.');
            sentence
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Row;
    use crate::report::tests::{drawn_with, report};

    fn with(rows: &[(&'static str, f64, f64)]) -> Report {
        let mut report = report("sphere");
        let model = &mut report.scenes[0].models[0];
        model.truth_bound = Some(1e-7);
        model.rows.truncate(1);
        for &(algorithm, rmse, frame_ms) in rows {
            model.rows.push(Row {
                algorithm: algorithm.into(),
                setting: String::new(),
                settings: String::new(),
                is_default: true,
                promise: tetrascope::Promise::Open,
                outcome: drawn_with(rmse, frame_ms),
            });
        }
        report
    }

    #[test]
    fn the_fastest_within_each_error_and_the_most_exact_are_named() {
        let report = with(&[
            ("slicing", 5e-3, 1.0),
            ("resample", 5e-4, 2.0),
            ("voxel-hw", 6e-4, 1.5),
            // Both are within the truth's own error.
            ("projection", 1e-8, 9.0),
            ("raycast-peel", 9e-8, 8.0),
        ]);
        let answer = Answer::of(&report).expect("five pictures");
        let best = answer.lines[0].best.iter().flatten();
        let names: Vec<String> = best.map(|choice| choice.algorithm.clone()).collect();
        assert_eq!(
            names,
            ["slicing", "voxel-hw", "raycast-peel", "raycast-peel"]
        );
        assert_eq!(
            answer.sentences[0],
            "Fastest within an RMSE of 1e-2: slicing in 1 of 1 pictures."
        );
    }

    #[test]
    fn where_nothing_is_good_enough_the_answer_says_none() {
        let report = with(&[("slicing", 5e-3, 1.0), ("resample", f64::INFINITY, 0.5)]);
        let answer = Answer::of(&report).expect("two pictures");
        assert_eq!(answer.lines[0].best[1], None);
        assert!(answer.sentences[1].ends_with("none in 1 of 1 pictures."));
        let exact = answer.lines[0].best[3].as_ref().expect("one is finite");
        assert_eq!(exact.algorithm, "slicing");
    }

    #[test]
    fn nothing_compared_is_no_answer() {
        assert!(Answer::of(&with(&[])).is_none());
    }
}
