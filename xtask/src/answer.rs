//! The answer of a comparison: which algorithm for which need.

use std::fmt::Write as _;

use serde::Serialize;
use tetrascope::choose::Need;

use crate::diagrams::{style, words};
use crate::panel::{STYLES, mark};
use crate::report::{ModelReport, Outcome, Report, SceneReport, milliseconds, scientific};

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

/// The winner for a need in one scene and model, as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Winner {
    /// Scene and optical model.
    pub of: String,
    /// The fastest within the error or, where none was asked, the most exact within the time; `None`
    /// where nothing was drawn, or nothing within the error.
    pub choice: Option<Choice>,
    /// Whether its frames take longer than asked, as none within the error is as fast.
    pub is_late: bool,
}

/// The winner of each scene and model. Times are those until pixels are in memory.
pub fn winners(report: &Report, need: &Need) -> Vec<Winner> {
    let models = report
        .scenes
        .iter()
        .flat_map(|scene| scene.models.iter().map(move |model| (scene, model)));
    models
        .map(|(scene, model)| {
            let budget = need.budget.map_or(f64::INFINITY, |b| b.as_secs_f64() * 1e3);
            let all = choices(model);
            let within: Vec<&(Choice, f64)> = all
                .iter()
                .filter(|(choice, _)| choice.rmse <= need.error.unwrap_or(f64::INFINITY))
                .collect();
            let in_time = within.iter().filter(|(_, wall_ms)| *wall_ms <= budget);
            let fastest = within.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let best = match need.error {
                Some(_) => fastest,
                // Where none is in time, the fastest is the nearest to it.
                None => in_time
                    .min_by(|a, b| a.0.rmse.total_cmp(&b.0.rmse))
                    .or(fastest),
            };
            Winner {
                of: format!("{} {}", scene.name, model.model),
                choice: best.map(|best| best.0.clone()),
                is_late: best.is_some_and(|best| best.1 > budget),
            }
        })
        .collect()
}

impl Winner {
    /// In words.
    pub fn says(&self) -> String {
        let Some(choice) = &self.choice else {
            return format!("{}: nothing is as exact", self.of);
        };
        let late = if self.is_late {
            ", later than asked"
        } else {
            ""
        };
        format!(
            "{}: {} {}, RMSE {}, {} ms{late}",
            self.of,
            choice.algorithm,
            choice.setting,
            scientific(choice.rmse),
            milliseconds(choice.frame_ms)
        )
    }
}

/// The settings that were compared in a model, each with its wall time in milliseconds.
fn choices(model: &ModelReport) -> Vec<(Choice, f64)> {
    let rows = model.rows.iter().filter_map(|row| {
        let Outcome::Drawn(drawn) = &row.outcome else {
            return None;
        };
        let choice = Choice {
            algorithm: row.algorithm.clone(),
            class: format!("s{}", style(&row.algorithm) % STYLES),
            mark: mark(style(&row.algorithm)),
            setting: words(&row.setting),
            frame_ms: drawn.frame_ms,
            rmse: drawn.error.as_ref()?.image.rmse,
        };
        Some((choice, drawn.wall_ms))
    });
    rows.collect()
}

fn lines(scene_number: usize, scene: &SceneReport) -> Vec<AnswerLine> {
    let mut lines = Vec::new();
    for model in &scene.models {
        let choices: Vec<Choice> = choices(model).into_iter().map(|c| c.0).collect();
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

    #[test]
    fn needs_are_met_where_they_can_be() {
        // Wall times are 5 ms in all.
        let report = with(&[
            ("slicing", 5e-3, 1.0),
            ("projection", 1e-6, 9.0),
            ("raycast-peel", 1e-5, 8.0),
        ]);
        let winner = |error, milliseconds: Option<u64>| {
            let need = Need {
                error,
                budget: milliseconds.map(std::time::Duration::from_millis),
                ..Need::default()
            };
            let winners = winners(&report, &need);
            assert_eq!(winners.len(), 1);
            winners[0].says()
        };
        let of = "sphere emission-absorption: ";
        for (need, says) in [
            (
                (Some(1e-5), None),
                "projection default, RMSE 1.00e-6, 9.00 ms",
            ),
            ((Some(1e-7), None), "nothing is as exact"),
            ((None, Some(6)), "projection default, RMSE 1.00e-6, 9.00 ms"),
            (
                (None, Some(4)),
                "slicing default, RMSE 5.00e-3, 1.00 ms, later than asked",
            ),
        ] {
            assert_eq!(winner(need.0, need.1), format!("{of}{says}"));
        }
    }
}
