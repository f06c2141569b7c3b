//! Time steps within one file.

use std::path::Path;

use tetrascope_core::Error;

use crate::read::Format;
use crate::source::{Source, count};

/// A time step of a file that holds several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepChoice {
    /// The step of this number, from 0.
    Number(usize),
    /// The step at this time, in the file's own unit, up to the rounding of either number to 64
    /// bits, or of both to 32 where the file's has no more.
    Time(f64),
}

/// The times of the steps that one file holds, in their order and in the file's own unit; none
/// for a file without steps, or of a format whose steps are not told apart. No field is read.
///
/// Exodus, VTKHDF, CGNS, XDMF and Gmsh files have steps. [`ReadOptions::step`](crate::ReadOptions::step)
/// chooses one. A list of files is a [`collection`](crate::collection) instead.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read, [`Error::Format`] when it makes no sense or is of
/// a format that is not read.
pub fn read_steps(path: &Path) -> Result<Vec<f64>, Error> {
    match Format::of_file(path)? {
        Format::Gmsh => crate::gmsh::steps(Source::open(path)?),
        #[cfg(feature = "exodus")]
        Format::Exodus => crate::exodus::steps(Source::open(path)?),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => crate::read::hdf5_steps(path),
        Format::Xdmf => crate::xdmf::steps(Source::open(path)?),
        _ => Ok(Vec::new()),
    }
}

/// The number of the step that is chosen of those at `times`: the first, without a choice.
/// `None` for a file without steps.
///
/// # Errors
/// [`Error::Invalid`] lists what there is.
pub(crate) fn choose(
    path: &Path,
    choice: Option<StepChoice>,
    times: &[f64],
) -> Result<Option<usize>, Error> {
    let Some(choice) = choice else {
        return Ok((!times.is_empty()).then_some(0));
    };
    let file = path.display();
    if times.is_empty() {
        return Err(without_steps(path));
    }
    let found = match choice {
        StepChoice::Number(number) => (number < times.len()).then_some(number),
        StepChoice::Time(time) => times.iter().position(|&other| is_same(time, other)),
    };
    if found.is_some() {
        return Ok(found);
    }
    let what = match choice {
        StepChoice::Number(number) => format!("time step {number} is not in {file}"),
        StepChoice::Time(time) => {
            let near = nearest(time, times);
            format!("{file} has no time step at {time}; the nearest are {near}")
        }
    };
    Err(Error::Invalid {
        what,
        help: Some(format!("it has {}", list(times))),
    })
}

/// The error of a choice where there is nothing to choose from.
pub(crate) fn without_steps(path: &Path) -> Error {
    Error::Invalid {
        what: format!(
            "a time step is chosen, and {} holds none that can be told apart",
            path.display()
        ),
        help: Some("leave out the step; the steps of a list of files are its files".into()),
    }
}

/// A note on step `number` of those at `times`, if it is not the only one.
pub(crate) fn note(times: &[f64], number: usize) -> Option<String> {
    let which = match number {
        0 => "the first".to_owned(),
        _ => format!("number {number}"),
    };
    let several = (times.len() > 1).then_some(times)?;
    Some(format!(
        "the file holds {} time steps: {which}, at {}, is read",
        several.len(),
        several.get(number)?
    ))
}

/// Whether two times differ by rounding alone; `stored` is a file's, which may have 32 bits.
fn is_same(time: f64, stored: f64) -> bool {
    let most = time.abs().max(stored.abs());
    let is_narrow = f64::from(stored as f32) == stored;
    (time - stored).abs() <= 4.0 * f64::EPSILON * most
        || (is_narrow && time as f32 == stored as f32)
}

/// "number 1 at 0.5 and number 2 at 1.5".
fn nearest(time: f64, times: &[f64]) -> String {
    let mut numbers: Vec<usize> = (0..times.len()).collect();
    let distance = |number: &usize| (times[*number] - time).abs();
    numbers.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    numbers.truncate(2);
    numbers.sort_unstable();
    let words = numbers
        .iter()
        .map(|&n| format!("number {n} at {}", times[n]));
    words.collect::<Vec<_>>().join(" and ")
}

/// "3 time steps, 0 to 2, at 0, 0.5, 1.5".
fn list(times: &[f64]) -> String {
    const MOST: usize = 8;
    let mut words: Vec<String> = times.iter().take(MOST).map(f64::to_string).collect();
    if let (true, Some(last)) = (times.len() > MOST, times.last()) {
        words.push(format!("… {last}"));
    }
    let steps = count(times.len() as u64, "time step");
    let last = times.len().saturating_sub(1);
    format!("{steps}, 0 to {last}, at {}", words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(choice: StepChoice, times: &[f64]) -> Result<Option<usize>, String> {
        let chosen = choose(Path::new("file"), Some(choice), times);
        chosen.map_err(|error| match error.help() {
            Some(help) => format!("{error}: {help}"),
            None => error.to_string(),
        })
    }

    #[test]
    fn a_time_is_that_of_a_step_but_for_rounding() {
        let times = [0.0, f64::from(0.1_f32), 0.1 + 0.2, 1e9 + 0.25];
        for (time, expected) in [(-0.0, 0), (0.1, 1), (0.3, 2), (1e9 + 0.25, 3)] {
            assert_eq!(chosen(StepChoice::Time(time), &times), Ok(Some(expected)));
        }
        let wrong = chosen(StepChoice::Time(0.25), &times).expect_err("it is between");
        assert!(wrong.contains("number 1 at 0.10000000149011612"), "{wrong}");
        assert!(wrong.contains("number 2 at 0.30000000000000004"), "{wrong}");
        assert!(chosen(StepChoice::Time(1e9), &times).is_err());
        assert!(chosen(StepChoice::Time(f64::NAN), &times).is_err());
    }

    #[test]
    fn a_number_is_one_of_those_listed() {
        assert_eq!(chosen(StepChoice::Number(2), &[0.0, 0.5, 1.5]), Ok(Some(2)));
        let wrong = chosen(StepChoice::Number(3), &[0.0, 0.5, 1.5]).expect_err("there are 3");
        assert!(
            wrong.contains("3 time steps, 0 to 2, at 0, 0.5, 1.5"),
            "{wrong}"
        );
        let many: Vec<f64> = (0..100).map(f64::from).collect();
        let wrong = chosen(StepChoice::Number(100), &many).expect_err("there are 100");
        assert!(wrong.contains("5, 6, 7, … 99"), "{wrong}");
        assert!(chosen(StepChoice::Number(0), &[]).is_err());
        assert_eq!(choose(Path::new("file"), None, &[]).ok(), Some(None));
        assert_eq!(note(&[1.0], 0), None);
    }
}
