//! From what was drawn to numbers, and from promises to what is demanded of them.

use tetrascope::core::{Frame, OpticalModel};
use tetrascope::scene::Scene;
use tetrascope_testing::ImageError;

use super::contender::Contender;
use crate::limits::{ROUGH_ORDER, limit, outliers, rmse_with_outliers};
use crate::report::{Check, ErrorSource, ModelReport, Outcome, Row, SceneReport};

/// All that a model's contenders have come to.
pub(super) fn model_report(
    scene: &Scene,
    model: OpticalModel,
    contenders: &[Contender],
) -> ModelReport {
    let truth = truth_of(contenders).map(|(_, frame)| frame);
    let rows = contenders.iter().map(|contender| Row {
        algorithm: contender.algorithm.name.into(),
        setting: contender.setting.into(),
        settings: contender.settings.to_string(),
        is_default: contender.is_default(),
        promise: (contender.algorithm.promise)(&contender.settings),
        outcome: contender.outcome(truth),
    });
    ModelReport {
        model: model.name().into(),
        scene: scene.to_toml(),
        defaults: scene.defaults.clone(),
        size: [scene.view.width, scene.view.height],
        truth_bound: truth.and_then(|frame| frame.stats.error_bound),
        rows: rows.collect(),
        sources: sources(contenders),
    }
}

/// The pairs that tell the sources of each algorithm's error apart, where all of them were drawn.
fn sources(contenders: &[Contender]) -> Vec<ErrorSource> {
    let of_one = |settings: &[Contender]| {
        let algorithm = settings[0].algorithm;
        let drawn = |setting: &str| {
            let contender = settings.iter().find(|c| c.setting == setting)?;
            let name = format!("{} {setting}", algorithm.name);
            Some((name, contender.frame.as_ref()?))
        };
        let compared = algorithm.sources.iter().map(|source| {
            let (with, frame) = drawn(source.with)?;
            let (against, right) = match source.without {
                Some(setting) => drawn(setting)?,
                None => truth_of(contenders)?,
            };
            Some(ErrorSource {
                source: source.name.into(),
                with,
                against,
                error: ImageError::between(right, frame),
            })
        });
        // Where one is not drawn, the others say nothing about a whole.
        compared.collect::<Option<Vec<_>>>().unwrap_or_default()
    };
    let by_algorithm = contenders.chunk_by(|a, b| a.algorithm.name == b.algorithm.name);
    by_algorithm.flat_map(of_one).collect()
}

/// The truth's name and picture.
pub(super) fn truth_of(contenders: &[Contender]) -> Option<(String, &Frame)> {
    let truth = contenders.iter().find(|c| c.algorithm.is_truth())?;
    Some((truth.algorithm.name.into(), truth.frame.as_ref()?))
}

/// The demands on a scene's errors, by what each algorithm promises. Without a truth, that one
/// is there.
pub(super) fn checks(scene: &SceneReport) -> Vec<Check> {
    let mut checks = Vec::new();
    for model in &scene.models {
        let named = OpticalModel::ALL
            .into_iter()
            .find(|m| m.name() == model.model)
            .expect("the report names models");
        let subject = format!("{} {}", scene.name, model.model);
        if model.truth().is_none() {
            checks.push(Check::without_truth(subject));
            continue;
        }
        for row in &model.rows {
            let Outcome::Drawn(drawn) = &row.outcome else {
                continue;
            };
            let convex = scene.convex == Some(true);
            let rough = convex.then_some(ROUGH_ORDER);
            let limit = limit(row.promise, named, drawn.stats.order_proven, rough);
            // What the frame itself says that it may be off by.
            let said = drawn.stats.error_bound.unwrap_or(0.0);
            let limit = limit.map(|(rmse, greatest)| (rmse + said, greatest + said));
            let (Some(limit), Some(error)) = (limit, &drawn.error) else {
                continue;
            };
            let subject = format!("{subject} {} {}", row.algorithm, row.setting);
            let found = (error.image.rmse, error.max_without(outliers(named)));
            let limit = (rmse_with_outliers(limit, named, model.size), limit.1);
            checks.push(Check::new(subject.trim_end().into(), found, limit));
        }
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Errors;
    use crate::metrics::tests::frame;
    use tetrascope::Promise;

    /// The checks of one row whose RMSE is 1.5e-4, in emission and absorption.
    fn checks_of(promise: Promise, convex: bool) -> Vec<Check> {
        let mut report = crate::report::tests::report("sphere");
        let scene = &mut report.scenes[0];
        scene.convex = Some(convex);
        scene.models[0].rows[1].promise = promise;
        checks(scene)
    }

    #[test]
    fn what_is_promised_is_demanded() {
        for (promise, convex, passed) in [
            (Promise::Exact, false, false),
            (Promise::Within(1e-3), false, true),
            (Promise::RoughOrder, true, true),
        ] {
            let checks = checks_of(promise, convex);
            assert_eq!(checks.len(), 1, "{promise:?}");
            assert_eq!(checks[0].passed, passed, "{promise:?}");
        }
    }

    #[test]
    fn nothing_is_demanded_where_nothing_is_promised() {
        assert!(checks_of(Promise::Open, true).is_empty());
        assert!(checks_of(Promise::RoughOrder, false).is_empty());
    }

    /// A report on a picture of 256×256 pixels that an exact algorithm changed so, judged.
    fn judged(change: impl Fn(&mut Frame)) -> crate::report::Report {
        let truth = frame(256, vec![[0.25, 0.5, 0.125, 0.75]; 256 * 256]);
        let mut image = truth.clone();
        change(&mut image);
        let mut report = crate::report::tests::report("sphere");
        let model = &mut report.scenes[0].models[0];
        model.size = [256, 256];
        let Outcome::Drawn(drawn) = &mut model.rows[1].outcome else {
            panic!("it is drawn");
        };
        drawn.error = Some(Errors::between(&truth, &image));
        report.checks = checks(&report.scenes[0]);
        report
    }

    #[test]
    fn identical_pictures_pass() {
        let report = judged(|_| ());
        assert_eq!(report.checks.len(), 1);
        assert!(report.passed());
    }

    /// Its RMSE is 1e-3 / √(4 · 256²) = 2e-6, which rounding may reach; 1e-3 it may not.
    #[test]
    fn one_pixel_that_differs_fails() {
        let report = judged(|image| image.pixels[9][1] += 1e-3);
        let check = &report.checks[0];
        assert!(check.rmse < Some(check.limit) && !report.passed());
    }

    #[test]
    fn a_difference_in_alpha_alone_fails() {
        assert!(!judged(|image| image.pixels.iter_mut().for_each(|p| p[3] += 1e-3)).passed());
    }

    #[test]
    fn not_a_number_fails() {
        assert!(!judged(|image| image.pixels[9][2] = f32::NAN).passed());
    }

    #[test]
    fn a_missing_truth_fails() {
        let mut report = judged(|_| ());
        report.scenes[0].models[0].rows[0].outcome = Outcome::Skipped("too large".into());
        report.checks = checks(&report.scenes[0]);
        assert_eq!(report.checks.len(), 1);
        assert!(!report.passed());
        report.scenes[0].models[0].rows.remove(0);
        report.checks = checks(&report.scenes[0]);
        assert!(!report.passed());
        assert!(report.checks[0].found().contains("no ground truth"));
    }

    #[test]
    fn no_check_at_all_fails() {
        let mut report = judged(|_| ());
        report.checks.clear();
        assert!(!report.passed());
        assert!(report.verdict().contains("nothing was checked"));
        // Where nothing is promised there is nothing to check.
        report.scenes[0].models[0].rows[1].promise = Promise::Open;
        assert!(report.passed());
        assert!(report.verdict().contains("no picture"));
    }
}
