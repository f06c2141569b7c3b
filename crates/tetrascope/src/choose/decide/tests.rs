use std::time::Duration;

use super::*;
use crate::choose::SampledError;

/// A made-up setting: its group, seconds and errors as expected and as they are.
#[derive(Clone, Copy)]
struct Setting {
    group: usize,
    seconds: [f64; 2],
    error: [f64; 2],
    bytes: [u64; 2],
}

const fn setting(group: usize, seconds: [f64; 2], error: [f64; 2]) -> Setting {
    Setting {
        group,
        seconds,
        error,
        bytes: [1000; 2],
    }
}

/// Fast and rough, in the middle, exact, and the truth.
const USUAL: [Setting; 4] = [
    setting(0, [0.01, 0.01], [1e-2, 1e-2]),
    setting(0, [0.03, 0.03], [1e-3, 1e-3]),
    setting(1, [0.10, 0.10], [1e-7, 1e-7]),
    setting(2, [2.00, 2.00], [3e-8, 3e-8]),
];

fn run(need: &Need, settings: &[Setting]) -> (Result<Decision, Error>, Vec<usize>) {
    let candidates = settings.iter().map(|s| Candidate {
        group: s.group,
        expected: Expected {
            seconds: s.seconds[0],
            spread: 1.5,
            bytes: s.bytes[0] as f64,
            error: [s.error[0] / 1.5, s.error[0] * 1.5],
        },
    });
    let candidates: Vec<Candidate> = candidates.collect();
    let mut order = Vec::new();
    let decision = decide(need, &candidates, &mut |index| {
        order.push(index);
        let Setting {
            seconds,
            error,
            bytes,
            ..
        } = settings[index];
        match seconds[1].is_finite() {
            true => Ok(Found {
                seconds: seconds[1],
                prepare: 0.0,
                bytes: bytes[1],
                error: SampledError {
                    sampled: 1,
                    pixels: 1,
                    rmse: error[1],
                    upper: error[1],
                    greatest: error[1],
                },
            }),
            false => Err(Error::invalid("it fails")),
        }
    });
    (decision, order)
}

fn chosen(need: &Need, settings: &[Setting]) -> (usize, Vec<GivesWay>) {
    let decision = run(need, settings).0.expect("something is chosen");
    (decision.chosen, decision.gives_way)
}

fn need(error: Option<f64>, milliseconds: Option<u64>) -> Need {
    Need {
        error,
        budget: milliseconds.map(Duration::from_millis),
        memory: None,
    }
}

#[test]
fn an_error_is_kept_by_the_fastest() {
    for (error, index) in [(5e-2, 0), (2e-3, 1), (1e-5, 2), (1e-7, 2), (5e-8, 3)] {
        assert_eq!(
            chosen(&need(Some(error), None), &USUAL),
            (index, vec![]),
            "{error}"
        );
    }
}

#[test]
fn a_budget_is_kept_by_the_most_exact() {
    for (budget, index) in [(15, 0), (50, 1), (150, 2), (5000, 2)] {
        // The truth is no more exact than rounding, so the faster exact one is taken.
        assert_eq!(
            chosen(&need(None, Some(budget)), &USUAL),
            (index, vec![]),
            "{budget} ms"
        );
    }
}

#[test]
fn where_both_cannot_be_kept_the_budget_gives_way() {
    assert_eq!(chosen(&need(Some(2e-3), Some(50)), &USUAL), (1, vec![]));
    let (index, gives_way) = chosen(&need(Some(1e-5), Some(50)), &USUAL);
    assert_eq!(index, 2);
    let late = GivesWay::Budget {
        wanted: 0.05,
        found: 0.1,
    };
    assert_eq!(gives_way, [late]);
}

#[test]
fn a_budget_that_nothing_keeps_gives_way_to_the_fastest() {
    let (index, gives_way) = chosen(&need(None, Some(1)), &USUAL);
    assert_eq!(index, 0);
    let late = GivesWay::Budget {
        wanted: 0.001,
        found: 0.01,
    };
    assert_eq!(gives_way, [late]);
}

#[test]
fn an_error_that_nothing_keeps_gives_way_to_the_most_exact() {
    let (index, gives_way) = chosen(&need(Some(1e-12), None), &USUAL);
    assert_eq!(index, 3);
    let wrong = GivesWay::Error {
        wanted: 1e-12,
        found: 3e-8,
    };
    assert_eq!(gives_way, [wrong]);
}

#[test]
fn an_error_that_is_greater_than_expected_is_found_out() {
    let mut settings = USUAL;
    settings[1].error[1] = 8e-3;
    assert_eq!(chosen(&need(Some(2e-3), None), &settings).0, 2);
}

/// The findings of a trial about one setting hold for the algorithm's others, too.
#[test]
fn a_trial_corrects_the_other_settings_of_its_algorithm() {
    let settings = [
        setting(0, [0.010, 4.000], [1e-7, 1e-7]),
        setting(0, [0.011, 4.400], [1e-7, 1e-7]),
        setting(0, [0.012, 4.800], [1e-7, 1e-7]),
        setting(1, [0.030, 0.030], [1e-7, 1e-7]),
    ];
    let (decision, order) = run(&need(Some(1e-3), None), &settings);
    assert_eq!(decision.expect("it is chosen").chosen, 3);
    assert_eq!(order, [0, 3], "the others of group 0 are slow, too");
    // Errors, too: the second of group 0 would be within 3e-3 but for what the first shows.
    let settings = [
        setting(0, [0.01, 0.01], [4e-3, 4e-2]),
        setting(0, [0.02, 0.02], [2e-3, 2e-2]),
        setting(1, [0.05, 0.05], [1e-7, 1e-7]),
    ];
    let (decision, order) = run(&need(Some(3e-3), None), &settings);
    assert_eq!(decision.expect("it is chosen").chosen, 2);
    assert_eq!(order, [0, 2]);
}

#[test]
fn a_time_that_was_misjudged_is_found_out_where_it_may_matter() {
    // Expected to be slower than the first, but within the spread of 1.5 and a surprise.
    let mut settings = [
        setting(0, [0.010, 0.012], [1e-7, 1e-7]),
        setting(1, [0.013, 0.009], [1e-7, 1e-7]),
    ];
    assert_eq!(chosen(&need(Some(1e-3), None), &settings).0, 1);
    // Out of reach: it is not even tried.
    settings[1].seconds[0] = 0.1;
    assert_eq!(run(&need(Some(1e-3), None), &settings).1, [0]);
}

#[test]
fn what_takes_longer_than_the_budget_is_not_taken() {
    let mut settings = USUAL;
    settings[2].seconds[1] = 0.2;
    let (decision, order) = run(&need(None, Some(150)), &settings);
    assert_eq!((decision.expect("one is").chosen, order), (1, vec![2, 1]));
}

#[test]
fn memory_never_gives_way() {
    let mut settings = USUAL;
    for (index, bytes) in [[5000, 5000], [900, 1500], [900, 900], [10, 10]]
        .into_iter()
        .enumerate()
    {
        settings[index].bytes = bytes;
    }
    let mut need = need(Some(2e-2), None);
    need.memory = Some(1000);
    // The first is not tried, the second takes more than expected.
    let (decision, order) = run(&need, &settings);
    assert_eq!((decision.expect("one is").chosen, order), (2, vec![1, 2]));
    need.memory = Some(5);
    let error = run(&need, &settings).0.expect_err("nothing fits");
    assert!(error.to_string().contains("10.0 B"), "{error}");
    assert!(error.help().is_some_and(|help| help.contains("`memory`")));
}

#[test]
fn what_fails_is_passed_over_and_named() {
    let mut settings = USUAL;
    settings[2].seconds[1] = f64::NAN;
    let decision = run(&need(Some(1e-6), None), &settings)
        .0
        .expect("the truth is left");
    assert_eq!((decision.chosen, decision.failures.len()), (3, 1));
    let all = USUAL.map(|s| setting(s.group, [s.seconds[0], f64::NAN], s.error));
    for need in [need(Some(1e-6), None), need(None, Some(100))] {
        let error = run(&need, &all).0.expect_err("nothing is drawn");
        assert_eq!(error.to_string(), "it fails");
    }
    assert!(run(&need(None, Some(100)), &[]).0.is_err());
}
