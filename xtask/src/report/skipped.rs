//! The scenes that algorithms do not draw.

use serde::Serialize;

use super::{ModelReport, Outcome};

/// A scene that an algorithm does not draw, and why.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Skipped {
    pub(super) algorithm: String,
    /// Settings that are not drawn, and all.
    pub(super) settings: [usize; 2],
    pub(super) reasons: String,
}

/// One for each algorithm that does not draw all of its settings in `models`.
pub(super) fn skipped<'a>(models: impl Iterator<Item = &'a ModelReport>) -> Vec<Skipped> {
    let mut found: Vec<(&str, [usize; 2], Vec<&str>)> = Vec::new();
    for row in models.flat_map(|model| &model.rows) {
        let known = found.iter().position(|one| one.0 == row.algorithm);
        let index = known.unwrap_or_else(|| {
            found.push((&row.algorithm, [0, 0], Vec::new()));
            found.len() - 1
        });
        let (_, settings, reasons) = &mut found[index];
        settings[1] += 1;
        if let Outcome::Skipped(why) = &row.outcome {
            settings[0] += 1;
            if !reasons.contains(&why.as_str()) {
                reasons.push(why);
            }
        }
    }
    let found = found.into_iter().filter(|(_, settings, _)| settings[0] > 0);
    found
        .map(|(algorithm, settings, reasons)| Skipped {
            algorithm: algorithm.into(),
            settings,
            reasons: reasons.join("; "),
        })
        .collect()
}
