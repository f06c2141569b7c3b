//! Scenes with a closed-form answer, drawn by every renderer in every optical model.
//!
//! All are cubes (or what is left of one) cut into tetrahedra, so that every ray's
//! way through them is known: a box and a line meet between the latest entry and
//! the earliest exit of three slabs (T. Kay, J. Kajiya, 1986).

use tetrascope::core::glam::DVec3;
use tetrascope::core::view::TRANSPARENT;
use tetrascope::core::{
    Appearance, Camera, Frame, FrameStats, Knot, OpticalModel, Projection, Ray, TetMesh,
    TransferFunction, View, Volume,
};
use tetrascope::{Algorithm, Promise};
use tetrascope_testing::{knot, kuhn, mesh};
use xtask::testing::{Failures, algorithms, draw, drawn_by, promised};

const SIDE: u32 = 48;

/// A piece of a ray: distances and scalars at both ends, front first.
#[derive(Clone, Copy)]
struct Piece {
    length: f64,
    front: f64,
    back: f64,
}

/// A scene in which the integral of a ray is known.
struct Case {
    name: &'static str,
    mesh: TetMesh,
    knots: Vec<Knot>,
    background: [f32; 4],
    /// The pieces of a ray in the mesh, front first.
    pieces: fn(&Ray) -> Vec<Piece>,
    /// ∫ σ dt and the light of a piece before anything hides it, in `Emission` (T = 1)
    /// and in `EmissionAbsorption`, and its greatest color.
    answer: fn(Piece) -> Answer,
}

struct Answer {
    depth: f64,
    emission: DVec3,
    emission_absorption: DVec3,
    greatest: DVec3,
}

const ORANGE: DVec3 = DVec3::new(0.9, 0.5, 0.1);
const TEAL: DVec3 = DVec3::new(0.1, 0.6, 0.7);

/// A scalar that no product with weights brings back but by luck.
const STEP: f64 = 0.7;

/// Where a ray is in the box from `min` to `max`, in front of the eye.
fn chord(ray: &Ray, min: DVec3, max: DVec3) -> Option<(f64, f64)> {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        if direction == 0.0 {
            if origin < min[axis] || origin > max[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = (
            (min[axis] - origin) / direction,
            (max[axis] - origin) / direction,
        );
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (near < far).then_some((near, far))
}

/// The piece from `near` to `far` of a ray on which the scalar is x.
fn piece(ray: &Ray, (near, far): (f64, f64)) -> Piece {
    Piece {
        length: far - near,
        front: ray.at(near).x,
        back: ray.at(far).x,
    }
}

fn in_cube(ray: &Ray) -> Vec<Piece> {
    let whole = chord(ray, DVec3::splat(-1.0), DVec3::ONE);
    whole
        .map(|interval| piece(ray, interval))
        .into_iter()
        .collect()
}

/// Where |x| ≤ ½, between the two steps of the box transfer function.
fn in_slab(ray: &Ray) -> Vec<Piece> {
    let (min, max) = (DVec3::new(-0.5, -1.0, -1.0), DVec3::new(0.5, 1.0, 1.0));
    chord(ray, min, max)
        .map(|interval| piece(ray, interval))
        .into_iter()
        .collect()
}

/// Outside the hollow: up to two pieces.
fn around_hollow(ray: &Ray) -> Vec<Piece> {
    let Some((near, far)) = chord(ray, DVec3::splat(-1.0), DVec3::ONE) else {
        return Vec::new();
    };
    let third = DVec3::splat(1.0 / 3.0);
    let intervals = match chord(ray, -third, third) {
        Some((enter, leave)) => vec![(near, enter), (leave, far)],
        None => vec![(near, far)],
    };
    let in_front = intervals.into_iter().filter(|(near, far)| near < far);
    in_front.map(|interval| piece(ray, interval)).collect()
}

// Uniform σ and c: τ = σ l; light c τ, and c (1 − e^(−τ)) where it hides itself.
fn uniform(piece: Piece) -> Answer {
    let depth = 0.8 * piece.length;
    constant_color(depth, ORANGE)
}

fn constant_color(depth: f64, color: DVec3) -> Answer {
    Answer {
        depth,
        emission: color * depth,
        emission_absorption: color * -(-depth).exp_m1(),
        greatest: if depth > 0.0 { color } else { DVec3::ZERO },
    }
}

// Where the scalar is constant and on a step both sides count half: σ = (0.3 + 1.3)/2. One
// rounding of a scalar, where a ray begins inside of a cell or crosses a face, would make it
// one side's.
fn half_of_both(piece: Piece) -> Answer {
    constant_color(0.8 * piece.length, 0.5 * (ORANGE + TEAL))
}

// σ = 1 + x and a constant color: τ = l (1 + mean of x), as σ is linear along the ray.
fn linear_extinction(piece: Piece) -> Answer {
    constant_color(
        piece.length * (1.0 + (piece.front + piece.back) / 2.0),
        ORANGE,
    )
}

// σ = 0.8 and c from orange at x = −1 to teal at x = 1, linear along the ray. With
// m = σ l the weights of both ends are 1 − (1−e^(−m))/m and (1−e^(−m))/m − e^(−m)
// (`segment_weights` for a = b); they are m/2 − m²/6 and m/2 − m²/3 for small m.
fn linear_color(piece: Piece) -> Answer {
    let color = |x: f64| ORANGE.lerp(TEAL, (x + 1.0) / 2.0);
    let (front, back) = (color(piece.front), color(piece.back));
    let m = 0.8 * piece.length;
    let mean = if m > 1e-6 {
        -(-m).exp_m1() / m
    } else {
        1.0 - m / 2.0
    };
    let weights = if m > 1e-3 {
        (1.0 - mean, mean - (-m).exp())
    } else {
        (
            m / 2.0 - m * m / 6.0 + m.powi(3) / 24.0,
            m / 2.0 - m * m / 3.0 + m.powi(3) / 8.0,
        )
    };
    Answer {
        depth: m,
        emission: (front + back) * (m / 2.0),
        emission_absorption: front * weights.0 + back * weights.1,
        greatest: front.max(back),
    }
}

// A tent of half-width 1/10 over x = 0, height 10: τ = l (F(back) − F(front)) / (back − front)
// with F the tent's integral, whatever the cells; l σ(x) where x does not change.
fn tent(piece: Piece) -> Answer {
    let integral = |x: f64| {
        let x = (x / 0.1).clamp(-1.0, 1.0);
        if x < 0.0 {
            (1.0 + x).powi(2) / 2.0
        } else {
            1.0 - (1.0 - x).powi(2) / 2.0
        }
    };
    let rise = piece.back - piece.front;
    let mean = if rise.abs() > 1e-9 {
        (integral(piece.back) - integral(piece.front)) / rise
    } else {
        10.0 * (1.0 - (piece.front / 0.1).abs()).max(0.0)
    };
    let answer = constant_color(piece.length * mean, TEAL);
    // MIP sees color wherever the ray is: extinction plays no part in it.
    Answer {
        greatest: TEAL,
        ..answer
    }
}

fn cases() -> Vec<Case> {
    let cube = |n| mesh(kuhn(n, DVec3::NEG_ONE, DVec3::ONE, |_| true), |p| p.x);
    let case = |name, mesh, knots, pieces, answer| Case {
        name,
        mesh,
        knots,
        background: TRANSPARENT,
        pieces,
        answer,
    };
    vec![
        case(
            "uniform cube",
            cube(4),
            vec![knot(0.0, ORANGE, 0.8)],
            in_cube,
            uniform,
        ),
        case(
            "linear extinction",
            cube(4),
            vec![knot(-1.0, ORANGE, 0.0), knot(1.0, ORANGE, 2.0)],
            in_cube,
            linear_extinction,
        ),
        case(
            "linear color",
            cube(4),
            vec![knot(-1.0, ORANGE, 0.8), knot(1.0, TEAL, 0.8)],
            in_cube,
            linear_color,
        ),
        case(
            "two steps",
            cube(3),
            vec![
                knot(-0.5, DVec3::ZERO, 0.0),
                knot(-0.5, ORANGE, 0.8),
                knot(0.5, ORANGE, 0.8),
                knot(0.5, DVec3::ZERO, 0.0),
            ],
            in_slab,
            uniform,
        ),
        case(
            "narrow tent",
            cube(3),
            vec![
                knot(-0.1, TEAL, 0.0),
                knot(0.0, TEAL, 10.0),
                knot(0.1, TEAL, 0.0),
            ],
            in_cube,
            tent,
        ),
        case(
            "hollow cube",
            mesh(
                kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |c| c != [1, 1, 1]),
                |p| p.x,
            ),
            vec![knot(0.0, ORANGE, 0.8)],
            around_hollow,
            uniform,
        ),
        // c = 1 before a background of 1: every pixel is 1, in whatever order cells come.
        Case {
            name: "white furnace",
            mesh: cube(4),
            knots: vec![knot(-1.0, DVec3::ONE, 0.5), knot(1.0, DVec3::ONE, 4.0)],
            background: [1.0; 4],
            pieces: in_cube,
            answer: |piece| {
                let depth = piece.length * (2.25 + 1.75 * (piece.front + piece.back) / 2.0);
                constant_color(depth, DVec3::ONE)
            },
        },
    ]
}

/// From outside in perspective, from outside in parallel, and from inside.
fn views(background: [f32; 4]) -> Vec<(&'static str, View)> {
    let perspective = Projection::Perspective { view_angle: 40.0 };
    let orthographic = Projection::Orthographic {
        parallel_scale: 1.6,
    };
    let wide = Projection::Perspective { view_angle: 80.0 };
    let view = |position, focal_point, projection| View {
        camera: Camera {
            position,
            focal_point,
            view_up: DVec3::Z,
            projection,
        },
        width: SIDE,
        height: SIDE,
        background,
    };
    vec![
        (
            "perspective",
            view(DVec3::new(3.1, -2.3, 1.7), DVec3::ZERO, perspective),
        ),
        (
            "orthographic",
            view(DVec3::new(-2.3, 3.1, 1.3), DVec3::ZERO, orthographic),
        ),
        (
            "along an axis",
            view(DVec3::new(4.0, 0.0, 0.0), DVec3::ZERO, orthographic),
        ),
        (
            "inside",
            view(
                DVec3::new(0.71, 0.13, -0.37),
                DVec3::new(-1.0, 0.2, 0.1),
                wide,
            ),
        ),
    ]
}

/// The pixels of a case, by its formulas.
fn expected(case: &Case, model: OpticalModel, view: &View) -> Frame {
    let behind = view.premultiplied_background();
    let mut pixels = Vec::new();
    for row in 0..view.height {
        for column in 0..view.width {
            let (mut light, mut depth) = (DVec3::ZERO, 0.0f64);
            for piece in (case.pieces)(&view.ray(column, row)) {
                let answer = (case.answer)(piece);
                match model {
                    OpticalModel::EmissionAbsorption => {
                        light += answer.emission_absorption * (-depth).exp()
                    }
                    OpticalModel::Emission => light += answer.emission,
                    OpticalModel::MaximumIntensity => light = light.max(answer.greatest),
                    _ => {}
                }
                depth += answer.depth;
            }
            let through = (-depth).exp();
            let back = DVec3::new(behind[0], behind[1], behind[2]);
            let covered = 1.0 - through * (1.0 - behind[3]);
            let (color, alpha) = match model {
                OpticalModel::EmissionAbsorption => (light + through * back, covered),
                OpticalModel::Absorption => (through * back, covered),
                OpticalModel::Emission => (light + back, behind[3]),
                _ => (light.max(back), behind[3]),
            };
            pixels.push([color.x, color.y, color.z, alpha].map(|x| x as f32));
        }
    }
    Frame::new((view.width, view.height), pixels, FrameStats::default())
}

/// The root mean square and the greatest difference that rounding explains.
///
/// The reference: half an ulp of f32 in values up to 4 for the pixel and as much
/// for the expected one, 2 · 2⁻²³.
///
/// Elsewhere every ray decides for itself which cells it crosses, wherever the rasterizer
/// puts their vertices. What is left is f32: ends of segments are known to 2⁻²³ of
/// the mesh's half diagonal, some 4 roundings each, so that the optical depth of one errs by
/// σ · √3 · 2⁻²¹; over the 14 cells on the longest ray half of that is gone
/// by what they share. The root mean square is no greater than a quarter, as errors of
/// either sign cancel.
fn tolerance(algorithm: &Algorithm, knots: &[Knot]) -> (f64, f64) {
    if algorithm.is_truth() {
        let rounding = 2.0 / f64::from(1 << 23);
        return (rounding, rounding);
    }
    let extinction = knots.iter().map(|knot| knot.extinction).fold(0.0, f64::max);
    let max = extinction.max(1.0) * 3f64.sqrt() * 7.0 / f64::from(1 << 21);
    (max / 4.0, max)
}

/// Whether cells in the wrong order change a picture: not where all have one color.
fn order_shows(case: &Case, model: OpticalModel) -> bool {
    let first = case.knots.first().map(|knot| knot.color);
    let one_color = case.knots.iter().all(|knot| Some(knot.color) == first);
    !(model.commutes() || one_color)
}

/// The change by neighbors that a sort by centers has swapped, at most: twice what was measured:
/// the product of their opacities (0.1 each where their chords are short, as
/// they are where centers mislead) times the difference of their colors (0.2).
const ROUGH_ORDER: (f64, f64) = (4e-4, 3e-3);

#[test]
fn every_renderer_agrees_with_the_closed_forms() {
    check(&cases());
}

// What rounding on one side of a step does is not small, so renderers may not leave it to
// rounding.
#[test]
fn a_constant_on_a_step_stays_on_it() {
    let case = Case {
        name: "constant on a step",
        mesh: mesh(kuhn(3, DVec3::NEG_ONE, DVec3::ONE, |_| true), |_| STEP),
        knots: vec![
            knot(-1.0, ORANGE, 0.3),
            knot(STEP, ORANGE, 0.3),
            knot(STEP, TEAL, 1.3),
            knot(2.3, TEAL, 1.3),
        ],
        background: TRANSPARENT,
        pieces: in_cube,
        answer: half_of_both,
    };
    check(&[case]);
}

fn check(cases: &[Case]) {
    let mut failures = Failures::default();
    for algorithm in algorithms("closed forms") {
        for case in cases {
            let volume = Volume::Mesh(case.mesh.clone());
            for model in OpticalModel::VOLUMETRIC {
                let appearance = Appearance::new(
                    TransferFunction::new(case.knots.clone()).expect("valid knots"),
                    model,
                );
                for (from, view) in views(case.background) {
                    let expected = expected(case, model, &view);
                    for setting in (algorithm.sweep)(model) {
                        let (rmse, max) = tolerance(algorithm, &case.knots);
                        let (rmse, max) = match promised(algorithm, setting) {
                            Promise::Open => continue,
                            Promise::Within(change) => (rmse + change, max + change),
                            Promise::RoughOrder if order_shows(case, model) => ROUGH_ORDER,
                            _ => (rmse, max),
                        };
                        let Some(frame) = draw(algorithm, setting, &volume, &appearance, &view)
                        else {
                            continue;
                        };
                        let name = format!(
                            "{} {setting}: {}, {}, {from} ({})",
                            algorithm.name,
                            case.name,
                            model.name(),
                            drawn_by(algorithm)
                        );
                        failures.compare(&name, &expected, &frame, rmse, max);
                    }
                }
            }
        }
    }
    failures.finish();
}

// In parallel rays the pixels' lengths times their area sum to the volume; on a grid
// of n² pixels the sum errs at the silhouette alone, O(1/n).
#[test]
fn lengths_sum_to_the_volume() {
    let side = 192;
    let mesh = mesh(
        kuhn(2, DVec3::NEG_ONE, DVec3::ONE, |c| c != [1, 1, 1]),
        |p| p.x,
    );
    let truth = mesh.volume();
    let volume = Volume::Mesh(mesh);
    let (_, view) = views([0.0, 0.0, 0.0, 1.0]).swap_remove(1);
    let view = View {
        width: side,
        height: side,
        ..view
    };
    let appearance = Appearance::new(
        TransferFunction::new(vec![knot(0.0, DVec3::ONE, 1.0)]).expect("valid"),
        OpticalModel::Emission,
    );
    let pixel_area = (2.0 * 1.6 / f64::from(side)).powi(2);
    for algorithm in algorithms("volume") {
        let Some(frame) = draw(algorithm, "", &volume, &appearance, &view) else {
            continue;
        };
        let sum: f64 = frame.pixels.iter().map(|p| f64::from(p[0])).sum();
        let error = (sum * pixel_area / truth - 1.0).abs();
        // The length vanishes at a convex silhouette, so most of O(1/n) is O(1/n²); the
        // rim of the notch, of length 6 at most, jumps by 1 over half a pixel's width.
        let limit = 6.0 * pixel_area.sqrt() / 2.0 / truth;
        assert!(
            error < limit,
            "{}: {error:.2e}, at most {limit:.2e}",
            algorithm.name
        );
    }
}
