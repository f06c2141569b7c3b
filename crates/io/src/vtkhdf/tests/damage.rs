//! Files that are cut off or changed.

use super::*;
use crate::damage::{check_changed, check_cut_off};

const SMALL: &[&str] = &[
    "lattice-zlib.vtkhdf",
    "polyhedra.vtkhdf",
    "image.vtkhdf",
    "blanked.vtkhdf",
    "even.vtkhdf",
    "by-hand.hdf",
    "cycle.hdf",
    "images.vtkhdf",
    #[cfg(feature = "exodus")]
    "steps.e",
];

#[test]
fn a_file_that_is_cut_off_is_an_error() {
    for name in SMALL {
        check_cut_off(name, &bytes(name), 89);
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    for name in SMALL {
        check_changed(name, &bytes(name));
    }
}
