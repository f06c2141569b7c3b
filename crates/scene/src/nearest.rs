//! The name that was meant.

use tetrascope_core::text;

/// The candidate that `name` is most likely a misspelling of, if any is near.
///
/// Damerau-Levenshtein similarity, letter case aside; 0.6 accepts about two slips
/// in a word of five letters and refuses unrelated words of the same length. Names from files
/// that are longer than a message shows are nobody's misspelling, and would take long.
pub fn nearest<'a, S: AsRef<str>>(name: &str, candidates: &'a [S]) -> Option<&'a str> {
    let is_short = |text: &str| text.chars().nth(text::LONGEST_NAME).is_none();
    if !is_short(name) {
        return None;
    }
    let name = name.to_lowercase();
    candidates
        .iter()
        .map(AsRef::as_ref)
        .filter(|candidate| is_short(candidate))
        .map(|candidate| {
            let likeness = strsim::normalized_damerau_levenshtein(&name, &candidate.to_lowercase());
            (likeness, candidate)
        })
        .filter(|(likeness, _)| *likeness >= 0.6)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelling_finds_its_word_and_a_stranger_none() {
        let names = ["sphere", "orbital", "heat-sink"];
        assert_eq!(nearest("shpere", &names), Some("sphere"));
        assert_eq!(nearest("Heatsink", &names), Some("heat-sink"));
        assert_eq!(nearest("fin.vtu", &names), None);
    }
}
