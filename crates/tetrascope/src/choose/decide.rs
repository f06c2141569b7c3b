//! Which setting is tried next, and which is taken: no clock, no device.
//!
//! Expectations order the candidates; trials decide. A trial also corrects
//! what is expected of the algorithm's other settings.

use tetrascope_core::Error;

use super::{Expected, Found, GivesWay, Need};

/// An RMSE below which errors do not tell settings apart: rounding in f32.
pub(crate) const EXACT: f64 = 1e-5;

/// Trials of settings that may keep an error and then do not; after these, only those that
/// kept it whenever they were measured.
const DOUBTFUL: usize = 4;

/// Trials once a setting keeps all, for one that is better still.
const MORE: usize = 4;

/// Trials of settings that may be within a budget and then are not.
const LATE: usize = 5;

/// How many times faster than expected, beside its spread, a setting may be: what was measured on
/// a busy day was seen to err by more.
const SURPRISE: f64 = 2.0;

/// By how much an error has to be less to be worth another trial.
const CLEARLY: f64 = 1.5;

/// How much more memory a setting may be expected to take and yet be tried.
const DOUBTFUL_MEMORY: f64 = 1.25;

/// Something that can be chosen.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// The algorithm's index: what is found out about a setting tells of the others.
    pub(crate) group: usize,
    pub(crate) expected: Expected,
}

/// The decision.
#[derive(Debug)]
pub(crate) struct Decision {
    pub(crate) chosen: usize,
    pub(crate) gives_way: Vec<GivesWay>,
    /// All that was tried, in order.
    pub(crate) trials: Vec<(usize, Found)>,
    /// Candidates that could not be drawn, and why.
    pub(crate) failures: Vec<(usize, Error)>,
}

/// Chooses among `candidates`; `attempt` draws one.
///
/// # Errors
/// [`Error::Usage`] where nothing fits into the memory; the last trial's error where none
/// succeeds.
pub(crate) fn decide(
    need: &Need,
    candidates: &[Candidate],
    attempt: &mut dyn FnMut(usize) -> Result<Found, Error>,
) -> Result<Decision, Error> {
    let mut search = Search {
        need,
        candidates,
        attempt,
        trials: Vec::new(),
        failures: Vec::new(),
    };
    let kept = match need.error {
        Some(error) => search.keep_error(error),
        None => search.keep_budget(),
    };
    let chosen = kept.or_else(|| search.nearest());
    let Some(chosen) = chosen else {
        return Err(search.nothing());
    };
    let found = search.found(chosen).expect("what is chosen was tried");
    let mut gives_way = Vec::new();
    if let Some(wanted) = need.error.filter(|wanted| !found.error.keeps(*wanted)) {
        gives_way.push(GivesWay::Error {
            wanted,
            found: found.error.rmse,
        });
    }
    if let Some(wanted) = need.budget.map(|b| b.as_secs_f64())
        && found.seconds > wanted
    {
        gives_way.push(GivesWay::Budget {
            wanted,
            found: found.seconds,
        });
    }
    Ok(Decision {
        chosen,
        gives_way,
        trials: search.trials,
        failures: search.failures,
    })
}

struct Search<'a> {
    need: &'a Need,
    candidates: &'a [Candidate],
    attempt: &'a mut dyn FnMut(usize) -> Result<Found, Error>,
    trials: Vec<(usize, Found)>,
    failures: Vec<(usize, Error)>,
}

impl Search<'_> {
    /// The fastest that keeps the error, or else a most exact one that does.
    fn keep_error(&mut self, target: f64) -> Option<usize> {
        let mut best = self.fastest(target);
        for _ in 0..2 {
            if best.is_some() {
                break;
            }
            let next = least(self.open(), |i| self.error(i)[1].max(f64::MIN_POSITIVE))?;
            let found = self.attempt(next);
            best = found.filter(|f| f.error.keeps(target)).map(|_| next);
        }
        best
    }

    /// The fastest of those that are likely to keep the error.
    fn fastest(&mut self, target: f64) -> Option<usize> {
        let kept = self.trials.iter();
        let kept = kept.filter(|(_, f)| f.error.keeps(target) && self.fits(f));
        let kept = kept.min_by(|(_, a), (_, b)| a.seconds.total_cmp(&b.seconds));
        let mut best = kept.map(|(index, _)| *index);
        let (mut misses, mut more) = (0, 0);
        loop {
            let limit = best.and_then(|best| Some(self.found(best)?.seconds));
            let may = |i: usize| {
                let [least, greatest] = self.error(i);
                let keeps = least <= target && (misses < DOUBTFUL || greatest <= target);
                keeps && limit.is_none_or(|limit| self.at_best(i) < limit)
            };
            let next = match more < MORE {
                true => least(self.open().filter(|i| may(*i)), |i| self.seconds(i)),
                false => None,
            };
            let Some(next) = next else { break };
            let found = self.attempt(next);
            more += usize::from(best.is_some());
            match found {
                Some(found) if found.error.keeps(target) => {
                    if limit.is_none_or(|limit| found.seconds < limit) {
                        best = Some(next);
                    }
                }
                _ => misses += 1,
            }
        }
        best
    }

    /// The most exact within the budget, and of those that are equally exact the fastest.
    fn keep_budget(&mut self) -> Option<usize> {
        let budget = self.need.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        let (mut best, mut late, mut more) = (None::<(usize, Found)>, 0, 0);
        while late < LATE && more < MORE {
            let limit = best.as_ref().map(|(_, found)| found.error.rmse);
            let may = |i: usize| match limit {
                None => true,
                Some(error) => error > EXACT && self.error(i)[0] * CLEARLY < error,
            };
            // What is expected to be in time comes first, then what may be.
            let likely = self.open().filter(|i| may(*i));
            let likely = likely.filter(|i| self.seconds(*i) <= budget);
            let mut next = least(likely, |i| self.rank(i));
            if next.is_none() {
                let doubtful = self.open().filter(|i| may(*i));
                let doubtful = doubtful.filter(|i| self.at_best(*i) <= budget);
                next = least(doubtful, |i| self.seconds(i));
            }
            let Some(next) = next else { break };
            more += usize::from(best.is_some());
            match self.attempt(next) {
                Some(found) if found.seconds <= budget => {
                    if limit.is_none_or(|error| found.error.rmse < error) {
                        best = Some((next, found));
                    }
                }
                _ => late += 1,
            }
        }
        if best.is_none() {
            // The fastest of all, whatever its error.
            let fastest = self.fastest(f64::INFINITY)?;
            let found = self.found(fastest)?;
            return (found.seconds <= budget).then_some(fastest);
        }
        best.map(|(index, _)| index)
    }

    /// The trial that misses by least what the need asks for.
    fn nearest(&self) -> Option<usize> {
        let miss = |found: &Found| match self.need.error {
            Some(_) => found.error.rmse,
            None => found.seconds,
        };
        let fitting = self.trials.iter().filter(|(_, found)| self.fits(found));
        let nearest = fitting.min_by(|(_, a), (_, b)| miss(a).total_cmp(&miss(b)));
        nearest.map(|(index, _)| *index)
    }

    /// Why nothing was chosen.
    fn nothing(&mut self) -> Error {
        let expected = self.candidates.iter().map(|c| c.expected.bytes);
        let found = self.trials.iter().map(|(_, found)| found.bytes as f64);
        let least = expected.chain(found).fold(f64::INFINITY, f64::min);
        match (self.need.memory, self.failures.pop()) {
            (_, Some((_, error))) => error,
            (Some(memory), None) if !self.candidates.is_empty() => Error::Usage {
                what: format!(
                    "no setting is expected to hold this volume in {}; the least takes about {}",
                    super::bytes(memory as f64),
                    super::bytes(least),
                ),
                help: Some("allow more `memory`, or draw fewer cells".into()),
            },
            _ => Error::Usage {
                what: "no algorithm draws this scene".into(),
                help: None,
            },
        }
    }

    /// Draws a candidate; `None` if it fails or takes more memory than there is.
    fn attempt(&mut self, index: usize) -> Option<Found> {
        match (self.attempt)(index) {
            Ok(found) => {
                self.trials.push((index, found.clone()));
                self.fits(&found).then_some(found)
            }
            Err(error) => {
                self.failures.push((index, error));
                None
            }
        }
    }

    /// Candidates that were not tried and may fit.
    fn open(&self) -> impl Iterator<Item = usize> + '_ {
        let memory = self.need.memory.map_or(f64::INFINITY, |m| m as f64);
        (0..self.candidates.len()).filter(move |i| {
            let tried = self.found(*i).is_some() || self.failures.iter().any(|(f, _)| f == i);
            !tried && self.candidates[*i].expected.bytes <= memory * DOUBTFUL_MEMORY
        })
    }

    fn fits(&self, found: &Found) -> bool {
        self.need.memory.is_none_or(|memory| found.bytes <= memory)
    }

    fn found(&self, index: usize) -> Option<&Found> {
        let trial = self.trials.iter().find(|(tried, _)| *tried == index);
        trial.map(|(_, found)| found)
    }

    /// Expected, after what trials of the same algorithm took.
    fn seconds(&self, index: usize) -> f64 {
        let of = |expected: &Expected, found: &Found| (found.seconds, expected.seconds);
        self.candidates[index].expected.seconds * self.correction(index, 1, of)
    }

    /// As little as it may take.
    fn at_best(&self, index: usize) -> f64 {
        self.seconds(index) / (self.candidates[index].expected.spread * SURPRISE)
    }

    /// Expected, least and greatest, after the errors of trials of the same algorithm.
    fn error(&self, index: usize) -> [f64; 2] {
        let of = |expected: &Expected, found: &Found| {
            let middle = expected.middle_error();
            // Rounding tells nothing.
            match middle > EXACT && found.error.rmse > EXACT {
                true => (found.error.rmse, middle),
                false => (1.0, 1.0),
            }
        };
        let expected = self.candidates[index].expected.error;
        match expected[0] > EXACT {
            true => expected.map(|error| error * self.correction(index, 0, of)),
            false => expected,
        }
    }

    /// The geometric mean of quotients over trials of the same algorithm, and of `ones` more that
    /// are 1: a single time may be off by chance.
    fn correction(
        &self,
        index: usize,
        ones: usize,
        of: impl Fn(&Expected, &Found) -> (f64, f64),
    ) -> f64 {
        let group = self.candidates[index].group;
        let same = self
            .trials
            .iter()
            .filter(|(tried, _)| self.candidates[*tried].group == group);
        let logs = same.map(|(tried, found)| {
            let (found, expected) = of(&self.candidates[*tried].expected, found);
            (found / expected).ln()
        });
        let logs: Vec<f64> = logs.filter(|log| log.is_finite()).collect();
        let count = (logs.len() + ones).max(1);
        (logs.iter().sum::<f64>() / count as f64).exp()
    }

    /// Errors in order, and times among those that are exact: these are far below any error.
    fn rank(&self, index: usize) -> f64 {
        let [least, greatest] = self.error(index);
        let middle = (least * greatest).sqrt(); // corrected, unlike `Expected::middle_error`
        match middle > EXACT {
            true => middle,
            false => EXACT * (self.seconds(index) / (1.0 + self.seconds(index))),
        }
    }
}

/// The index with the least value.
fn least(indices: impl Iterator<Item = usize>, of: impl Fn(usize) -> f64) -> Option<usize> {
    indices.min_by(|a, b| of(*a).total_cmp(&of(*b)))
}

#[cfg(test)]
mod tests;
