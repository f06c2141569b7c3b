//! Scalars that floats hold badly or not at all.

use tetrascope::core::glam::DVec3;
use tetrascope_testing::knot;

use super::case::{Case, Group, Shot};
use super::scenes::{ORANGE, Pieces, along_x, down_x, look, one_color, plain, waves, whole};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        not_finite("NaN at vertices", f64::NAN),
        not_finite("infinity at vertices", f64::INFINITY),
        not_finite("−infinity at vertices", f64::NEG_INFINITY),
        not_finite("values beyond f32 at vertices", 1e39),
        constant(),
        function_elsewhere("a transfer function far above the range", 1e9),
        function_elsewhere("a transfer function far below the range", -1e9),
    ];
    cases.extend([
        field("values of 1e38", 1e38, -1e38),
        field("values of 1e-300", 1e-300, 0.0),
        field("denormal values", 1e-310, 0.0),
        // Doubles hold steps of 2⁻³⁶ there: those of the waves are 2⁻²⁰ of the range.
        field("101325 ± 1e-3", 2f64.powi(-9), 101_325.0 - 2f64.powi(-10)),
    ]);
    cases.push(one_ulp());
    cases
}

/// Values at some vertices are none: their cells are not seen, and their neighbors are as without
/// them.
fn not_finite(name: &str, value: f64) -> Case {
    let pieces = Pieces::cube(4, 0.2, waves);
    let is_chosen = |point: u32| point % 17 == 5;
    let mut without = pieces.clone();
    without
        .cells
        .retain(|cell| !cell.iter().any(|&p| is_chosen(p)));
    let view = whole(&pieces.clone().volume());
    let mut with = pieces;
    for (point, scalar) in (0..).zip(&mut with.values) {
        if is_chosen(point) {
            *scalar = value;
        }
    }
    let shots = [without, with].map(|pieces| Shot::new(pieces.volume(), plain(), view));
    Case::same(Group::Values, name, shots.into())
}

fn constant() -> Case {
    let knots = [0.0, 1.0].map(|s| knot(s, ORANGE, 3.0 * s));
    let shot = Shot::new(
        Pieces::cube(4, 0.2, |_| 0.25).volume(),
        look(knots.into()),
        down_x(),
    );
    Case::known(Group::Values, "a constant field", shot, |_| {
        one_color(ORANGE, 1.5)
    })
}

/// All of the field lies beyond the last knot, or before the first.
fn function_elsewhere(name: &str, at: f64) -> Case {
    let (first, last) = (DVec3::new(0.2, 0.3, 0.9), ORANGE);
    let appearance = look(vec![knot(at, first, 0.5), knot(at + 1.0, last, 0.7)]);
    let seen = if at > 0.0 { (first, 1.0) } else { (last, 1.4) };
    let shot = Shot::new(Pieces::cube(4, 0.2, waves).volume(), appearance, down_x());
    Case::known(Group::Values, name, shot, move |_| {
        one_color(seen.0, seen.1)
    })
}

/// The waves as they are, and in other units.
fn field(name: &str, factor: f64, offset: f64) -> Case {
    let steps = f64::from(1 << 20);
    let pieces = Pieces::cube(4, 0.2, |p| (waves(p) * steps).round() / steps);
    let view = whole(&pieces.clone().volume());
    let shots = [(1.0, 0.0), (factor, offset)].map(|(factor, offset)| {
        let mut pieces = pieces.clone();
        for scalar in &mut pieces.values {
            *scalar = offset + factor * *scalar;
        }
        // At places that both have to the last bit.
        let at = |share: f64, color: [f64; 3], extinction: f64| {
            knot(offset + factor * share, color, extinction)
        };
        let appearance = look(vec![
            at(0.0, [0.1, 0.2, 0.8], 0.1),
            at(0.375, [0.2, 0.9, 0.4], 0.6),
            at(1.0, [1.0, 0.3, 0.1], 4.0),
        ]);
        Shot::new(pieces.volume(), appearance, view)
    });
    Case::same(Group::Values, name, shots.into()).for_each()
}

/// Two values that are neighbors in f64, and the same picture with 0 and 1. No knot fits between them.
fn one_ulp() -> Case {
    let shots = [(0.0, 1.0), (1.0, 1.0_f64.next_up())].map(|(low, high)| {
        let pieces = Pieces::cube(4, 0.2, |p| if along_x(p) < 0.5 { low } else { high });
        let volume = pieces.volume();
        let view = whole(&volume);
        let appearance = look(vec![
            knot(low, [0.1, 0.2, 0.8], 0.1),
            knot(high, [1.0, 0.3, 0.1], 2.0),
        ]);
        Shot::new(volume, appearance, view)
    });
    Case::same(Group::Values, "a range of one ulp", shots.into()).for_each()
}
