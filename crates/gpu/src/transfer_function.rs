//! The transfer function on the device: no more knots than a shader's loop may have.

use tetrascope_core::{Error, TransferFunction};
use tetrascope_f32::{KnotPair, Normalization, ScalarMap, knots};
use tetrascope_shaders::loops::MOST_KNOTS;

/// Refuses more than [`MOST_KNOTS`] with [`Error::TooLarge`], as a shader's loop over them would
/// be too long.
pub fn check_knots(transfer_function: &TransferFunction) -> Result<(), Error> {
    let count = transfer_function.knots().len();
    match count <= MOST_KNOTS {
        true => Ok(()),
        false => Err(Error::TooLarge {
            what: "the transfer function on a GPU".into(),
            needed: count as u64,
            limit: MOST_KNOTS as u64,
            unit: "knots",
        }),
    }
}

/// [`knots::knot_pairs`] for a shader.
///
/// # Errors
/// As [`check_knots`] says.
pub fn knot_pairs(
    transfer_function: &TransferFunction,
    map: &ScalarMap,
    normalization: &Normalization,
) -> Result<Vec<KnotPair>, Error> {
    check_knots(transfer_function)?;
    Ok(knots::knot_pairs(transfer_function, map, normalization))
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Knot;
    use tetrascope_core::glam::DVec3;

    use super::*;

    #[test]
    fn more_knots_than_a_loop_may_have_are_refused() {
        let of = |count: usize| {
            let knot = |i: usize| Knot {
                scalar: i as f64,
                color: DVec3::ONE,
                extinction: 1.0,
            };
            let tf = TransferFunction::new((0..count).map(knot).collect()).expect("sorted");
            let unit = Normalization {
                center: DVec3::ZERO,
                scale: 1.0,
            };
            knot_pairs(&tf, &ScalarMap::of(&tf), &unit)
        };
        assert_eq!(of(MOST_KNOTS).expect("as many").len(), MOST_KNOTS + 1);
        let error = of(MOST_KNOTS + 1).expect_err("one more").to_string();
        assert!(error.contains("knots"), "{error}");
    }
}
