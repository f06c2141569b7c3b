//! The world that grid files share: left, posterior, superior.
//!
//! x grows to a patient's left, y to the back and z to the head (LPS), which is what DICOM
//! and ITK mean, what MetaImage files are in, and nearly all NRRD files that have a
//! `space`. NIfTI is in RAS. Files that do not say what their axes mean stay as they are.

use tetrascope_core::glam::DVec3;

/// The name of the world, where a file says how it lies in it.
pub(crate) const WORLD: &str = "LPS";

/// The meaning of a file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    /// A coordinate of the world is one of the file times this.
    pub(crate) signs: DVec3,
    /// Whether the directions are those of a body.
    pub(crate) anatomical: bool,
}

/// Right, anterior, superior: NIfTI's.
pub(crate) const RAS: Space = Space {
    signs: DVec3::new(-1.0, -1.0, 1.0),
    anatomical: true,
};

/// A vector of a file in the world, without zeros below zero.
pub(crate) fn turned(vector: DVec3, signs: DVec3) -> DVec3 {
    vector * signs + DVec3::ZERO
}

impl Space {
    /// The space that NRRD calls `name`, short or long, with or without time.
    pub(crate) fn of(name: &str) -> Option<Space> {
        let name = name.to_ascii_lowercase();
        let name = name.strip_suffix("-time").unwrap_or(&name);
        let general = |signs| Space {
            signs,
            anatomical: false,
        };
        match name {
            "scanner-xyz" | "scannerxyz" | "3d-right-handed" | "3dr" | "3d-right-handed-time" => {
                return Some(general(DVec3::ONE));
            }
            // One axis is turned round, so that what is left stays left.
            "3d-left-handed" | "3dl" => return Some(general(DVec3::new(1.0, -1.0, 1.0))),
            _ => {}
        }
        let words: Vec<&str> = name.split('-').collect();
        let letters: Vec<&str> = match words[..] {
            [short] if short.is_ascii() && matches!(short.len(), 3 | 4) => {
                let (letters, time) = short.split_at(3);
                if !matches!(time, "" | "t") {
                    return None;
                }
                (0..3).map(|i| &letters[i..=i]).collect()
            }
            _ => words,
        };
        let sign = |word: &str, along: [&str; 2], against: [&str; 2]| {
            if along.contains(&word) {
                Some(1.0)
            } else if against.contains(&word) {
                Some(-1.0)
            } else {
                None
            }
        };
        let [x, y, z] = letters[..] else {
            return None;
        };
        Some(Space {
            signs: DVec3::new(
                sign(x, ["l", "left"], ["r", "right"])?,
                sign(y, ["p", "posterior"], ["a", "anterior"])?,
                sign(z, ["s", "superior"], ["i", "inferior"])?,
            ),
            anatomical: true,
        })
    }

    /// Whether its axes are the mirror image of the world's.
    pub(crate) fn is_left_handed(&self) -> bool {
        self.signs.element_product() < 0.0
    }

    /// Notes on a file whose space has this `name`.
    pub(crate) fn notes(&self, name: &str) -> Vec<String> {
        let turned: Vec<&str> = (0..3)
            .filter(|axis| self.signs[*axis] < 0.0)
            .map(|axis| ["x", "y", "z"][axis])
            .collect();
        if turned.is_empty() {
            return Vec::new();
        }
        let world = match self.anatomical {
            true => format!("from {name} to {WORLD}"),
            false => format!("from {name} to a right-handed space"),
        };
        let handed = match self.is_left_handed() {
            true => ", as the file's space is left-handed: nothing is mirrored",
            false => "",
        };
        let turned = turned.join(" and ");
        vec![format!(
            "positions are converted {world}: {turned} turned round{handed}"
        )]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_have_short_and_long_names() {
        let signs = |name| Space::of(name).map(|space| space.signs.to_array());
        for (names, expected) in [
            (["LPS", "left-posterior-superior"], [1.0, 1.0, 1.0]),
            (["RAS", "right-anterior-superior"], [-1.0, -1.0, 1.0]),
            (["LAST", "left-anterior-superior-time"], [1.0, -1.0, 1.0]),
            (["3D-left-handed", "3DL"], [1.0, -1.0, 1.0]),
            (["scanner-xyz", "scanner-xyz-time"], [1.0, 1.0, 1.0]),
        ] {
            for name in names {
                assert_eq!(signs(name), Some(expected), "{name}");
            }
        }
        for wrong in ["", "LP", "LPSX", "PLS", "left-posterior", "äöü"] {
            assert_eq!(signs(wrong), None, "{wrong}");
        }
        assert!(Space::of("LAS").is_some_and(|s| s.is_left_handed()));
        assert!(!RAS.is_left_handed());
    }
}
