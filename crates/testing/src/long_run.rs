//! A test that runs for as long as it is asked to, and goes on where it was.

use std::fs;
use std::path::PathBuf;

/// How many rays are asked for.
const RAYS: &str = "TETRASCOPE_RAYS";

/// A file that keeps how many were cast, and where to go on.
const TALLY: &str = "TETRASCOPE_RAYS_TALLY";

/// Calls `cast` with one seed after another until so many rays are cast as the environment variable
/// TETRASCOPE_RAYS says, or `most` without it. It returns how many it has cast, and panics where one is lost.
///
/// The file that TETRASCOPE_RAYS_TALLY names keeps how many were cast, and the next seed: a later run goes
/// on from there.
///
/// # Panics
/// If a variable or the file says something else.
pub fn cast_many(most: u64, mut cast: impl FnMut(u64) -> u64) {
    let wanted = std::env::var(RAYS).map_or(most as f64, |n| n.parse().expect("a number"));
    let tally = std::env::var_os(TALLY).map(PathBuf::from);
    let (mut rays, mut seed) = tally.as_ref().map_or((0, FIRST_SEED), |file| {
        fs::read_to_string(file).map_or((0, FIRST_SEED), |text| parsed(&text))
    });
    while (rays as f64) < wanted {
        rays += cast(seed);
        seed += 1;
        if let Some(file) = &tally {
            // Whole or not at all, whenever this ends.
            let new = file.with_extension("new");
            fs::write(&new, format!("{rays} rays, next seed {seed}\n")).expect("it can be written");
            fs::rename(&new, file).expect("it can be written");
        }
        crate::say(&format!("{rays} rays, none lost"));
    }
}

/// Short tests have others.
const FIRST_SEED: u64 = 1000;

fn parsed(text: &str) -> (u64, u64) {
    let numbers = text.split(|c: char| !c.is_ascii_digit());
    let mut numbers = numbers.filter_map(|word| word.parse().ok());
    let numbers = numbers.next().zip(numbers.next());
    numbers.unwrap_or_else(|| panic!("no tally: {text:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tally_is_read_as_it_is_written() {
        assert_eq!(parsed("123 rays, next seed 45\n"), (123, 45));
    }

    #[test]
    #[should_panic(expected = "no tally")]
    fn what_is_no_tally_is_refused() {
        parsed("nothing yet");
    }
}
