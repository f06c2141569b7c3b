//! Axes that are perpendicular but for rounding, or nearly.

use tetrascope_core::Error;
use tetrascope_core::Unit;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};

/// Samples may move by this share of the least spacing without further question.
const MOST_MOVED: f64 = 0.5;

/// Written numbers with fewer digits than this explain nothing.
const MOST_ROUNDED: f64 = 0.02;

/// The lattice with these axes; where they are not perpendicular, with the nearest that are,
/// and a note of how far that is.
///
/// Refused is shear that moves any sample by half a voxel or more, unless `rounding`, how far
/// the numbers of each axis may be off as they were written, explains it.
pub(crate) fn lattice(
    dims: [usize; 3],
    origin: DVec3,
    axes: [DVec3; 3],
    rounding: [f64; 3],
    interpolation: Interpolation,
    notes: &mut Vec<String>,
) -> Result<Lattice, Error> {
    let of = |axes| Lattice::from_axes(dims, origin, axes, interpolation);
    let as_they_are = of(axes);
    let Some(near) = perpendicular(axes).filter(|_| as_they_are.is_err()) else {
        return as_they_are;
    };
    let lattice = of(near)?;
    let moves = [0, 1, 2].map(|i| (axes[i] - near[i]).length());
    let off = (0..3)
        .map(|i| (moves[i] / axes[i].length()).powi(2))
        .sum::<f64>()
        .sqrt();
    // The true axes are perpendicular and no number of theirs is off by more, so that each
    // axis is off by √3 of it; the nearest axes are not farther away than the true ones.
    let share = |i: usize| 3.0 * (rounding[i] / axes[i].length()).powi(2);
    let explained = (0..3).map(share).sum::<f64>().sqrt();
    let moved: f64 = (0..3).map(|i| moves[i] * (dims[i] - 1) as f64).sum();
    let is_rounding = off <= 1.01 * explained && off <= MOST_ROUNDED;
    if is_rounding {
        notes.push(format!(
            "axes are perpendicular but for {off:.1e}, as rounding leaves them: the nearest \
             perpendicular ones are drawn"
        ));
    } else if moved < MOST_MOVED * lattice.spacing.min_element() {
        notes.push(format!(
            "axes have a shear of {off:.1e}: the nearest perpendicular ones are drawn, which \
             moves samples by {moved:.1e} at most"
        ));
    } else {
        return Err(Error::Invalid {
            what: format!("the grid's axes have a shear of {off:.1e}, which is not drawn"),
            help: Some("resample the volume to perpendicular axes".into()),
        });
    }
    Ok(lattice)
}

/// The nearest axes that are perpendicular, by their directions; `None` if there are none.
fn perpendicular(axes: [DVec3; 3]) -> Option<[DVec3; 3]> {
    let directions = axes.map(Unit::unit);
    let mut near = DMat3::from_cols_array_2d(&directions.map(|d| d.to_array()));
    // The orthogonal factor of the polar decomposition, by Newton's method (Higham 1986):
    // it converges from any regular matrix, quadratically near the end.
    for _ in 0..100 {
        let inverse = near.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let next = (near + inverse.transpose()) * 0.5;
        let change = (next - near).to_cols_array();
        near = next;
        if change.iter().all(|c| c.abs() < 1e-15) {
            break;
        }
    }
    let along = |i: usize| near.col(i) * axes[i].dot(near.col(i));
    near.is_finite().then(|| [along(0), along(1), along(2)])
}

/// By how much the numbers among `words` may be off if they were rounded when they were
/// written: half a unit of the last digit, of the decimals or of the digits that count, as
/// many as any of them has.
pub(crate) fn rounding<'a>(words: impl Iterator<Item = &'a str>) -> f64 {
    let (mut decimals, mut digits, mut most) = (0, 0, 0.0f64);
    for word in words {
        let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
        let Some(number) = number else {
            continue;
        };
        most = most.max(number.abs());
        let mantissa = word.split(['e', 'E']).next().unwrap_or("");
        let exponent: i32 = word[mantissa.len()..]
            .trim_start_matches(['e', 'E'])
            .parse()
            .unwrap_or(0);
        let behind = mantissa
            .split_once('.')
            .map_or(0, |(_, behind)| behind.len());
        decimals = decimals.max((behind as i32).saturating_sub(exponent));
        let counting = mantissa
            .bytes()
            .filter(u8::is_ascii_digit)
            .skip_while(|b| *b == b'0');
        digits = digits.max(counting.count() as i32);
    }
    let ahead = if most > 0.0 {
        most.log10().floor() as i32 + 1
    } else {
        0
    };
    let unit = |places: i32| 0.5 * 10f64.powi(places.saturating_neg());
    unit(decimals).max(unit(digits - ahead))
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DQuat;

    use super::*;

    fn turned() -> [DVec3; 3] {
        let turn = DMat3::from_quat(DQuat::from_euler(
            tetrascope_core::glam::EulerRot::XYZ,
            0.3,
            -0.5,
            0.9,
        ));
        [turn.x_axis, turn.y_axis * 2.0, turn.z_axis * 0.5]
    }

    fn read(axes: [DVec3; 3], rounding: f64) -> (Result<Lattice, Error>, Vec<String>) {
        let mut notes = Vec::new();
        let linear = Interpolation::Linear;
        let lattice = lattice(
            [9, 8, 7],
            DVec3::ONE,
            axes,
            [rounding; 3],
            linear,
            &mut notes,
        );
        (lattice, notes)
    }

    #[test]
    fn the_nearest_axes_undo_rounding() {
        for decimals in [3, 4, 6] {
            let unit = 10f64.powi(decimals);
            let rounded = turned().map(|a| (a * unit).round() / unit);
            let (lattice, notes) = read(rounded, 0.5 / unit);
            let lattice = lattice.expect("explained");
            for (axis, true_axis) in turned().into_iter().enumerate() {
                let found = lattice.direction.col(axis) * lattice.spacing[axis];
                // √3 half units for each axis, 2 for the least spacing.
                assert!(
                    (found - true_axis).length() < 4.0 / unit,
                    "{decimals} {axis}"
                );
            }
            assert_eq!(notes.len(), usize::from(decimals < 5), "{notes:?}");
        }
    }

    #[test]
    fn shear_is_small_or_refused() {
        let sheared = |by: f64| {
            let [x, y, z] = turned();
            [x, y + x * by, z]
        };
        let (lattice, notes) = read(sheared(1e-2), 0.0);
        let off = (lattice.expect("small").linear()
            - DMat3::from_cols_array_2d(&turned().map(|a| a.to_array())))
        .to_cols_array();
        assert!(off.iter().all(|x| x.abs() < 1e-2));
        assert!(notes[0].contains("shear of"), "{notes:?}");
        let (lattice, _) = read(sheared(0.2), 0.0);
        let error = lattice.expect_err("large").to_string();
        assert!(error.contains("shear of"), "{error}");
        // Few digits explain no shear.
        assert!(
            read([DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z], 0.5)
                .0
                .is_err()
        );
        assert!(read([DVec3::X, DVec3::X, DVec3::Z], 0.5).0.is_err());
    }

    #[test]
    fn what_rounding_explains_is_told_by_digits() {
        let of = |text: &str| rounding(text.split(' '));
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
        assert!(near(of("0.9363 0.2751 -0.2184"), 5e-5));
        assert!(near(of("0.936 0.00123 0"), 5e-4));
        assert!(near(of("12.345 0.1 -7"), 5e-4));
        // Four digits of numbers up to 1: the last may be a thousandth.
        assert!(near(of("9.363e-01 1"), 5e-4));
        assert!(near(of("9.363e-01 2.751e-01"), 5e-5));
        assert!(near(of("1 0 0"), 0.5));
        assert!(of("0.70710678118654757 1") < 1e-15);
    }

    #[test]
    fn numbers_beyond_floats_say_nothing_of_rounding() {
        assert_eq!(
            rounding(["1e999", "-inf", "nan"].into_iter()),
            rounding([].into_iter())
        );
        assert_eq!(
            rounding(["0.25", "1e999"].into_iter()),
            rounding(["0.25"].into_iter())
        );
    }
}
