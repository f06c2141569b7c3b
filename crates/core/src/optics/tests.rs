use proptest::prelude::*;

use super::*;
use crate::Knot;

/// Rows of a, b, w_f, w_b, 1 − e^(−(a+b)/2), made by `exact_values.py`.
fn exact_values() -> impl Iterator<Item = [f64; 5]> {
    include_str!("exact_values.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let mut numbers = line.split(',').map(|x| x.parse().expect("a number"));
            std::array::from_fn(|_| numbers.next().expect("five columns"))
        })
}

fn grey(knots: &[(f64, f64, f64)]) -> TransferFunction {
    let knot = |&(scalar, color, extinction): &(f64, f64, f64)| Knot {
        scalar,
        color: DVec3::splat(color),
        extinction,
    };
    TransferFunction::new(knots.iter().map(knot).collect()).expect("valid knots")
}

fn segment(front: f64, back: f64, length: f64) -> Segment {
    Segment {
        front,
        back,
        length,
    }
}

fn ray(tf: &TransferFunction, model: OpticalModel, segments: &[Segment]) -> (f64, f64) {
    let mut ray = RayIntegral::new(tf, model);
    for s in segments {
        ray.add(s);
    }
    (ray.light().x, ray.optical_depth())
}

const EA: OpticalModel = OpticalModel::EmissionAbsorption;

#[track_caller]
fn assert_near(actual: f64, expected: f64, relative: f64) {
    assert!(
        (actual - expected).abs() <= relative * expected.abs(),
        "{actual:e} is not {expected:e}, off by {:e}",
        (actual / expected - 1.0).abs()
    );
}

// 4e-15 is twice what was measured, 2.1e-15 for the weights; below 2e-323 = 4
// times the smallest number there are no digits to compare.
#[test]
fn weights_agree_with_exact_values() {
    let mut rows = 0;
    for [a, b, front, back, alpha] in exact_values() {
        let (w_f, w_b) = segment_weights(a, b);
        let opacity = -(-weights::depth(a, b)).exp_m1();
        for (actual, exact) in [
            (w_f, front),
            (w_b, back),
            (opacity, alpha),
            (w_f + w_b, alpha),
        ] {
            let error = (actual - exact).abs();
            assert!(
                error <= 4e-15 * exact || error <= 2e-323,
                "a = {a:e}, b = {b:e}: {actual:e} is not {exact:e}"
            );
        }
        rows += 1;
    }
    assert!(rows > 1000);
}

// The same through the transfer function: σ = s, c = 1 + s, one unit long, so
// that C = (1 + a) w_f + (1 + b) w_b, all terms positive.
#[test]
fn segments_agree_with_exact_values() {
    let top = 1e9;
    let tf = grey(&[(0.0, 1.0, 0.0), (top, 1.0 + top, top)]);
    for [a, b, front, back, _] in exact_values().filter(|row| row[0].max(row[1]) < top) {
        if a.min(b) < 1e-280 {
            continue; // x = s / width underflows
        }
        let (light, depth) = ray(&tf, EA, &[segment(a, b, 1.0)]);
        // Weights 4e-15; a and b are off by 4 ε, which moves T by 4 ε m.
        let tolerance = 6e-15 + 1e-15 * (0.5 * (a + b)).min(40.0);
        assert_near(light, (1.0 + a) * front + (1.0 + b) * back, tolerance);
        assert_near(depth, 0.5 * (a + b), 2e-15);
    }
}

#[test]
fn nothing_finite_gives_nan() {
    let values = [
        0.0,
        5e-324,
        1e-310,
        1e-30,
        1.0,
        746.0,
        1e30,
        1e200,
        1e308,
        f64::MAX,
    ];
    for a in values {
        for b in values {
            let (w_f, w_b) = segment_weights(a, b);
            assert!(
                w_f >= 0.0 && w_b >= 0.0 && w_f + w_b <= 1.0 + 1e-15,
                "{a} {b}"
            );
            let tf = grey(&[(0.0, 0.25, a), (1.0, 0.75, b)]);
            for model in OpticalModel::ALL {
                for length in [5e-324, 1.0, f64::MAX, f64::INFINITY] {
                    let (light, depth) = ray(&tf, model, &[segment(-1.0, 2.0, length); 3]);
                    assert!(light >= 0.0 && depth >= 0.0, "{a} {b} {model:?} {length}");
                    if model == EA {
                        assert!(light <= 0.75 + 1e-15);
                    }
                }
            }
        }
    }
    // Opaque at once: the front color alone.
    let tf = grey(&[(0.0, 0.25, f64::MAX), (1.0, 0.75, f64::MAX)]);
    assert_eq!(
        ray(&tf, EA, &[segment(0.0, 1.0, 9.0)]),
        (0.25, f64::INFINITY)
    );
}

#[test]
fn what_is_not_there_adds_nothing() {
    let tf = grey(&[(0.0, 1.0, 1.0), (1.0, 1.0, 3.0)]);
    for model in OpticalModel::ALL {
        for (f, b, l) in [
            (f64::NAN, 0.5, 1.0),
            (0.5, f64::NAN, 1.0),
            (0.5, 0.5, 0.0),
            (0.5, 0.5, -1.0),
            (0.5, 0.5, f64::NAN),
            (f64::NEG_INFINITY, f64::INFINITY, 1.0),
            (0.5, f64::INFINITY, 1.0),
            (f64::INFINITY, 0.5, 1.0),
            (f64::INFINITY, f64::INFINITY, 1.0),
            (f64::NEG_INFINITY, f64::NEG_INFINITY, 1.0),
        ] {
            assert_eq!(ray(&tf, model, &[segment(f, b, l)]), (0.0, 0.0));
        }
    }
}

#[test]
fn a_constant_scalar_on_a_step_takes_the_mean() {
    let tf = grey(&[
        (0.0, 0.0, 1.0),
        (1.0, 0.0, 1.0),
        (1.0, 1.0, 3.0),
        (2.0, 1.0, 3.0),
    ]);
    assert_eq!(ray(&tf, EA, &[segment(1.0, 1.0, 0.5)]).1, 1.0);
    let max = OpticalModel::MaximumIntensity;
    assert_eq!(ray(&tf, max, &[segment(1.0, 1.0, 0.5)]).0, 0.5);
    // Approached from one side, that side's limit, whatever came before.
    for before in [0.5, 1.5] {
        let first = segment(before, before, 1.0);
        let depth = |f, b| ray(&tf, EA, &[first, segment(f, b, 1.0)]).1 - ray(&tf, EA, &[first]).1;
        assert_eq!(depth(0.5, 1.0), 1.0);
        assert_eq!(depth(1.0, 1.5), 3.0);
        assert_eq!(depth(1.5, 1.0), 3.0);
        assert_eq!(depth(1.0, 0.5), 1.0);
    }
}

// σ = σ₀ on [s₁, s₂]: τ = σ₀ (s₂ − s₁) / |ds/dt|; a tent of half-width e and
// height 1/e: τ = 1 / |ds/dt|, for any number of pieces. Each piece's length
// and depth is within 10 ε, and all are positive.
#[test]
fn box_and_tent_transfer_functions() {
    let cut = |pieces: u32, length: f64, rising: bool| -> Vec<Segment> {
        let at = |i: u32| {
            let x = f64::from(i) / f64::from(pieces);
            if rising { x } else { 1.0 - x }
        };
        (0..pieces)
            .map(|i| segment(at(i), at(i + 1), length / f64::from(pieces)))
            .collect()
    };
    let (s1, s2) = (0.25, 0.375);
    let boxed = grey(&[
        (s1, 1.0, 0.0),
        (s1, 1.0, 8.0),
        (s2, 1.0, 8.0),
        (s2, 1.0, 0.0),
    ]);
    for pieces in [1, 2, 8, 64] {
        for rising in [true, false] {
            let (light, depth) = ray(&boxed, EA, &cut(pieces, 3.0, rising));
            assert_near(depth, 3.0, 3e-15);
            assert_near(light, -(-3.0_f64).exp_m1(), 1e-14);
            for e in [1e-2, 1e-6, 1e-12] {
                let (low, high) = (0.5 - e, 0.5 + e);
                let tent = grey(&[(low, 1.0, 0.0), (0.5, 1.0, 1.0 / e), (high, 1.0, 0.0)]);
                let (_, depth) = ray(&tent, EA, &cut(pieces, 2.0, rising));
                // As wide as the rounded knots make it.
                assert_near(depth, 2.0 * 0.5 * (high - low) / e, 3e-15);
            }
        }
    }
}

// Emission: ∫ c σ dt with c = σ = s on [0, 1] over length 3 is 3 ∫ s² ds = 1.
#[test]
fn the_other_models() {
    let tf = grey(&[(0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)]);
    for (f, b) in [(0.0, 1.0), (1.0, 0.0)] {
        let whole = segment(f, b, 3.0);
        let (light, depth) = ray(&tf, OpticalModel::Emission, &[whole]);
        assert_near(light, 1.0, 1e-15);
        assert_eq!(depth, 0.0);
        let (light, depth) = ray(&tf, OpticalModel::Absorption, &[whole]);
        assert_eq!((light, depth), (0.0, 1.5));
        // Knots inside count: a tent of color.
        let tent = grey(&[(0.25, 0.0, 0.0), (0.5, 0.75, 0.0), (0.75, 0.0, 0.0)]);
        assert_eq!(ray(&tent, OpticalModel::MaximumIntensity, &[whole]).0, 0.75);
    }
}

// Formulas in differences of squares lose up to 0.1 here. ∂w/∂b is at most 1/2,
// so the weights may differ from those of b = a by m |b/a − 1| / 2, and by rounding.
#[test]
fn nearly_constant_extinction_is_no_special_case() {
    for m in [0.01, 0.1, 0.9, 1.0, 1.1, 3.0, 10.0] {
        let (constant_front, constant_back) = segment_weights(m, m);
        for gap in [1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
            for b in [m * (1.0 + gap), m * (1.0 - gap)] {
                let (front, back) = segment_weights(m, b);
                let most = 0.5 * m * gap + 4e-15;
                assert!((front - constant_front).abs() <= most, "{m} {gap}");
                assert!((back - constant_back).abs() <= most, "{m} {gap}");
            }
        }
    }
}

/// Random transfer functions over [0, 1], some with steps.
fn transfer_functions() -> impl Strategy<Value = TransferFunction> {
    prop::collection::vec((0..64_u32, 0.0..1.0_f64, 0.0..1.0_f64), 1..9).prop_flat_map(|knots| {
        (Just(knots), -3.0..2.0_f64).prop_map(|(mut knots, strength)| {
            knots.sort_by_key(|k| k.0);
            let mut kept: Vec<(f64, f64, f64)> = Vec::new();
            for (at, color, extinction) in knots {
                let at = f64::from(at) / 64.0;
                if kept.iter().filter(|k| k.0 == at).count() < 2 {
                    kept.push((at, color, extinction * 10_f64.powf(strength)));
                }
            }
            grey(&kept)
        })
    })
}

fn rays() -> impl Strategy<Value = Vec<Segment>> {
    prop::collection::vec((-0.2..1.2_f64, -0.2..1.2_f64, 0.01..2.0_f64), 1..8)
        .prop_map(|s| s.iter().map(|&(f, b, l)| segment(f, b, l)).collect())
}

/// How far depth, or light of colors up to 1, may move by rounding the scalars inside `segments`.
///
/// A scalar in [−0.2, 1.2] that is computed is off by e ≤ 4 ε. Knots are 1/64
/// apart or more, so extinction follows by 64 e σ; a step between is met e / |Δs|
/// of the length too early or late.
fn scalar_rounding(tf: &TransferFunction, segments: &[Segment]) -> f64 {
    let extinction = tf.max_extinction(-1.0, 2.0);
    let off = |s: &Segment| {
        2.0 * f64::EPSILON * extinction * s.length * (64.0 + 1.0 / (s.back - s.front).abs())
    };
    segments.iter().map(off).sum()
}

/// Light and depth by Gauss-Legendre quadrature of the definition, on panels
/// short in scalar and in depth, with no part of the code under test but `limit`.
fn by_quadrature(tf: &TransferFunction, segments: &[Segment]) -> (f64, f64) {
    // Six points: Abramowitz & Stegun, table 25.4.
    const NODES: [(f64, f64); 3] = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_35),
    ];
    let (mut light, mut depth) = (0.0, 0.0);
    for s in segments {
        let at = |t: f64| s.front + (s.back - s.front) * t;
        let mut cuts: Vec<f64> = tf
            .knots()
            .iter()
            .map(|k| (k.scalar - s.front) / (s.back - s.front))
            .filter(|t| *t > 0.0 && *t < 1.0)
            .collect();
        cuts.extend([0.0, 1.0]);
        cuts.sort_by(f64::total_cmp);
        for piece in cuts.windows(2) {
            // Inside a piece all is linear: extinction by its ends just inside.
            let most = tf.max_extinction(-1.0, 2.0) * s.length * (piece[1] - piece[0]);
            let panels = (4.0 * most).ceil().max(1.0) as usize;
            for i in 0..panels {
                let width = (piece[1] - piece[0]) / panels as f64;
                let start = piece[0] + width * i as f64;
                let points: Vec<(f64, f64)> = NODES
                    .iter()
                    .flat_map(|&(x, w)| [(0.5 - 0.5 * x, 0.5 * w), (0.5 + 0.5 * x, 0.5 * w)])
                    .collect();
                let sample = |t: f64| tf.sample(at(t)).expect("a number");
                // ∫σ from the panel's start by the same rule, exact for linear σ.
                let depth_to = |x: f64| -> f64 {
                    let sum = points
                        .iter()
                        .map(|&(y, w)| w * sample(start + width * x * y).1);
                    sum.sum::<f64>() * width * x * s.length
                };
                for &(x, w) in &points {
                    let (c, sigma) = sample(start + width * x);
                    light += w * width * s.length * c.x * sigma * (-(depth + depth_to(x))).exp();
                }
                depth += depth_to(1.0);
            }
        }
    }
    (light, depth)
}

proptest! {
    // Six points on a panel of depth ≤ 1/4 err by (1/4)^12 / 13! ≪ 1e-16 of it;
    // 1e-13 is for the sums of up to 1e4 panels.
    #[test]
    fn agrees_with_quadrature(tf in transfer_functions(), segments in rays()) {
        let (light, depth) = ray(&tf, EA, &segments);
        let (expected_light, expected_depth) = by_quadrature(&tf, &segments);
        let tolerance = 1e-13 * (1.0 + expected_depth) + scalar_rounding(&tf, &segments);
        prop_assert!((light - expected_light).abs() <= tolerance, "{light} {expected_light}");
        prop_assert!((depth - expected_depth).abs() <= tolerance, "{depth} {expected_depth}");
    }

    // The scalar at the cut is rounded; colors follow by 64 e < 1e-13.
    #[test]
    fn splitting_changes_nothing(tf in transfer_functions(), segments in rays(), cut in 0.0..1.0_f64) {
        for model in OpticalModel::ALL {
            let mut split = Vec::new();
            for s in &segments {
                let middle = s.front * (1.0 - cut) + s.back * cut;
                split.push(segment(s.front, middle, s.length * cut));
                split.push(segment(middle, s.back, s.length * (1.0 - cut)));
            }
            let (whole, halves) = (ray(&tf, model, &segments), ray(&tf, model, &split));
            let tolerance = 1e-13 * (1.0 + whole.1 + whole.0) + scalar_rounding(&tf, &segments);
            prop_assert!((whole.0 - halves.0).abs() <= tolerance, "{whole:?} {halves:?} {model:?}");
            prop_assert!((whole.1 - halves.1).abs() <= tolerance, "{whole:?} {halves:?} {model:?}");
        }
    }

    #[test]
    fn the_way_back_is_as_opaque(tf in transfer_functions(), segments in rays()) {
        let back: Vec<_> = segments.iter().rev().map(|s| segment(s.back, s.front, s.length)).collect();
        let (there, again) = (ray(&tf, EA, &segments).1, ray(&tf, EA, &back).1);
        prop_assert!((there - again).abs() <= 4e-15 * there);
    }

    // c = 1 before a background of 1: 1, however thick, within the stated bound.
    #[test]
    fn white_furnace(tf in transfer_functions(), segments in rays()) {
        let white: Vec<_> = tf.knots().iter().map(|k| (k.scalar, 1.0, k.extinction)).collect();
        let tf = grey(&white);
        let mut ray = RayIntegral::new(&tf, EA);
        segments.iter().for_each(|s| ray.add(s));
        for channel in ray.over([1.0; 4]) {
            prop_assert!((channel - 1.0).abs() <= ray.rounding_bound(), "{channel}");
        }
    }

    // A power of two only moves exponents, so not a bit may change.
    #[test]
    fn scale_is_arbitrary(tf in transfer_functions(), segments in rays(), k in -60..60_i32) {
        let factor = 2_f64.powi(k);
        let thin: Vec<_> = tf.knots().iter().map(|n| (n.scalar, n.color.x, n.extinction / factor)).collect();
        let long: Vec<_> = segments.iter().map(|s| segment(s.front, s.back, s.length * factor)).collect();
        for model in OpticalModel::ALL {
            prop_assert_eq!(ray(&tf, model, &segments), ray(&grey(&thin), model, &long));
        }
    }

    // More extinction never lowers the depth; more segments never lower it nor
    // the light. Rounding: 10 ε.
    #[test]
    fn more_is_not_less(tf in transfer_functions(), segments in rays(), k in 1.0..4.0_f64) {
        let thick: Vec<_> = tf.knots().iter().map(|n| (n.scalar, n.color.x, n.extinction * k)).collect();
        let (light, depth) = ray(&tf, EA, &segments);
        prop_assert!(ray(&grey(&thick), EA, &segments).1 >= depth * (1.0 - 3e-15));
        let fewer = ray(&tf, EA, &segments[..segments.len() - 1]);
        prop_assert!(fewer.0 <= light && fewer.1 <= depth * (1.0 + 3e-15));
    }

    // A knot on the line between its neighbors; its values are rounded, 2 ε.
    #[test]
    fn a_redundant_knot_changes_nothing(tf in transfer_functions(), segments in rays(), at in 0.0..1.0_f64) {
        let mut knots: Vec<_> = tf.knots().to_vec();
        if knots.iter().any(|k| k.scalar == at) {
            return Ok(());
        }
        let (color, extinction) = tf.sample(at).expect("a number");
        let place = knots.partition_point(|k| k.scalar < at);
        knots.insert(place, Knot { scalar: at, color, extinction });
        let finer = TransferFunction::new(knots).expect("valid knots");
        for model in OpticalModel::ALL {
            let (before, after) = (ray(&tf, model, &segments), ray(&finer, model, &segments));
            let tolerance = 1e-14 * (1.0 + before.1 + before.0);
            prop_assert!((before.0 - after.0).abs() <= tolerance, "{before:?} {after:?}");
            prop_assert!((before.1 - after.1).abs() <= tolerance, "{before:?} {after:?}");
        }
    }
}

// Composite Gauss-Legendre with 2 points on 4096 parts, of order 4: its error is
// about (1/4096)⁴ = 4e-15 of the largest derivative, some 10 here.
fn brute_force(tf: &TransferFunction, segment: &Segment, cue: [f64; 2]) -> (f64, f64) {
    const PARTS: usize = 4096;
    let h = segment.length / PARTS as f64;
    let at = |s: f64| {
        let scalar = segment.front * (1.0 - s) + segment.back * s;
        let (color, extinction) = tf.sample(scalar).expect("a number");
        (color.x * mix(cue, s), extinction)
    };
    let (mut light, mut depth) = (0.0, 0.0);
    for part in 0..PARTS {
        // T inside of a part, by Simpson's rule from its start: exact for linear σ.
        let s0 = part as f64 / PARTS as f64;
        let start = at(s0).1;
        for node in [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()] {
            let (color, extinction) = at(s0 + node / PARTS as f64);
            let inner = 0.5 * (start + extinction) * node * h;
            light += 0.5 * h * color * extinction * (-depth - inner).exp();
        }
        depth += 0.5 * (start + at(s0 + 1.0 / PARTS as f64).1) * h;
    }
    (light, depth)
}

#[test]
fn a_cued_segment_agrees_with_brute_force() {
    for peak in [1e-3, 0.4, 1.0, 3.0, 20.0] {
        let tf = grey(&[(0.0, 0.2, 0.1 * peak), (1.0, 1.0, peak)]);
        for (front, back) in [(0.0, 1.0), (1.0, 0.0), (0.3, 0.3), (0.9, 0.2)] {
            for cue in [[1.0, 0.0], [0.9, 0.4], [0.0, 1.0]] {
                let segment = segment(front, back, 1.5);
                let mut ray = RayIntegral::new(&tf, EA);
                ray.add_cued(&segment, cue);
                let (light, depth) = brute_force(&tf, &segment, cue);
                assert!(
                    (ray.light().x - light).abs() < 1e-12,
                    "{peak} {front} {back} {cue:?}: {} {light}",
                    ray.light().x
                );
                assert_near(ray.optical_depth(), depth, 1e-13);
            }
        }
    }
}

#[test]
fn a_cue_does_not_depend_on_where_a_segment_is_divided() {
    let tf = grey(&[
        (0.0, 0.2, 0.1),
        (0.4, 1.0, 3.0),
        (0.4, 0.3, 1.0),
        (1.0, 0.0, 8.0),
    ]);
    for model in OpticalModel::VOLUMETRIC {
        let mut whole = RayIntegral::new(&tf, model);
        whole.add_cued(&segment(0.1, 0.9, 2.0), [1.0, 0.2]);
        let mut parts = RayIntegral::new(&tf, model);
        for i in 0..7 {
            let at = |i: i32| f64::from(i) / 7.0;
            let scalar = |i: i32| 0.1 + 0.8 * at(i);
            let cue = |i: i32| 1.0 - 0.8 * at(i);
            parts.add_cued(
                &segment(scalar(i), scalar(i + 1), 2.0 / 7.0),
                [cue(i), cue(i + 1)],
            );
        }
        assert!(
            (whole.light().x - parts.light().x).abs() < 1e-14,
            "{model:?}"
        );
        assert!((whole.optical_depth() - parts.optical_depth()).abs() < 1e-13);
    }
}

// The color 2 s times the cue 1 − s is greatest in the middle, 1/2.
#[test]
fn the_maximum_of_a_cued_segment_lies_inside() {
    let tf = grey(&[(0.0, 0.0, 1.0), (1.0, 2.0, 1.0)]);
    let mut ray = RayIntegral::new(&tf, OpticalModel::MaximumIntensity);
    ray.add_cued(&segment(0.0, 1.0, 1.0), [1.0, 0.0]);
    assert_near(ray.light().x, 0.5, 1e-15);
}

#[test]
fn a_cued_segment_beyond_all_bounds_shows_its_front() {
    for extinction in [1e3, 1e20, 1e300] {
        let tf = grey(&[(0.0, 0.5, extinction)]);
        let mut ray = RayIntegral::new(&tf, EA);
        ray.add_cued(&segment(0.0, 0.0, 1e10), [0.8, 0.2]);
        // At the depth 1 the cue has lost 0.6 / (extinction 1e10).
        assert!((ray.light().x - 0.4).abs() < 1e-12, "{extinction}");
        assert!(ray.is_opaque());
    }
}

#[test]
fn a_layer_without_length_has_its_greatest_value_and_nothing_else() {
    let peak = grey(&[(0.0, 0.1, 1.0), (0.5, 0.9, 1.0), (1.0, 0.1, 1.0)]);
    let layer = [segment(0.2, 0.8, 0.0)];
    let most = ray(&peak, OpticalModel::MaximumIntensity, &layer);
    assert_near(most.0, 0.9, 1e-15);
    for model in [OpticalModel::Emission, OpticalModel::Absorption, EA] {
        assert_eq!(ray(&peak, model, &layer), (0.0, 0.0), "{model:?}");
    }
    // A ray that touches a cell sees nothing of it.
    let touched = [segment(0.5, 0.5, 0.0)];
    assert_eq!(ray(&peak, OpticalModel::MaximumIntensity, &touched).0, 0.0);
}
