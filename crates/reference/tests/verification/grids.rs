//! Regular grids: closed forms, quadrature made here, the mesh of the same field.

use crate::closed_forms::check;
use crate::scenes::*;
use tetrascope_core::Unit as _;
use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::grid::Samples;
use tetrascope_core::optics::{RayIntegral, Segment};
use tetrascope_core::{
    Appearance, Camera, ClipPlane, Error, Grid, Knot, OpticalModel, Projection, Ray, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_reference::counters::CELL_VISITS;
use tetrascope_reference::{Reference, ReferenceOptions};
use tetrascope_testing::{Place, grid};

/// The ground truth of a grid.
pub(crate) fn truth(grid: &Grid, look: &Appearance) -> Reference {
    tetrascope_testing::truth(&Volume::Grid(grid.clone()), look)
}

/// Stretched, flipped and turned, about as large as [0, 1]³ and around its middle.
pub(crate) fn skewed() -> Place {
    let turn = DMat3::from_quat(DQuat::from_euler(
        tetrascope_core::glam::EulerRot::XYZ,
        0.4,
        -0.7,
        1.1,
    ));
    let direction = turn * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    let (dims, spacing) = ([6, 9, 4], DVec3::new(0.15, 0.11, 0.3));
    let far = DVec3::from_array(dims.map(|d| (d - 1) as f64));
    Place {
        dims,
        origin: DVec3::splat(0.5) - direction * (spacing * far) * 0.5,
        spacing,
        direction,
    }
}

/// Where a ray enters and leaves the grid before its origin.
pub(crate) fn span(place: &Place, ray: &Ray) -> Option<(f64, f64)> {
    let turned = Ray {
        origin: place.direction.transpose() * (ray.origin - place.origin),
        direction: place.direction.transpose() * ray.direction,
    };
    let far = DVec3::from_array(place.dims.map(|d| (d - 1) as f64)) * place.spacing;
    box_interval(&turned, DVec3::ZERO, far)
}

/// Five knots with a step, a tent and slopes.
fn knots() -> Vec<Knot> {
    vec![
        knot(0.1, [0.9, 0.3, 0.1], 0.0),
        knot(0.35, [0.2, 0.8, 0.4], 3.0),
        knot(0.35, [0.7, 0.1, 0.9], 0.5),
        knot(0.6, [1.0, 1.0, 0.2], 0.5),
        knot(0.62, [0.0, 0.5, 1.0], 20.0),
        knot(0.64, [0.4, 0.2, 0.3], 1.0),
    ]
}

// Uniform σ and c: the same numbers as for a mesh, for any placement and sample type.
#[test]
fn a_uniform_grid() {
    let (color, sigma) = ([0.9, 0.5, 0.2], 1.7);
    for place in [Place::unit(4), skewed()] {
        let count = place.dims.iter().product();
        let kinds = [
            Samples::U8(vec![7; count]),
            Samples::U16(vec![7; count]),
            Samples::I16(vec![7; count]),
            Samples::F32(vec![7.0; count]),
        ];
        for (samples, model) in kinds.into_iter().zip(OpticalModel::VOLUMETRIC) {
            // The slope changes nothing but how the scalar is reached: c and σ at 7.
            let look = appearance(
                vec![
                    knot(6.0, color.map(|c| c / 2.0), 0.0),
                    knot(7.0, color, sigma),
                ],
                model,
            );
            let truth = truth(&place.grid(samples), &look);
            for view in views(24) {
                let image = truth.render_exact(&view).expect("a valid view");
                check(&image, &view, |ray| {
                    let tau = sigma * span(&place, ray).map_or(0.0, |(a, b)| b - a);
                    let alpha = -(-tau).exp_m1();
                    let light = color.map(|c| match model {
                        OpticalModel::EmissionAbsorption => c * alpha,
                        OpticalModel::Emission => c * tau,
                        OpticalModel::MaximumIntensity if tau > 0.0 => c,
                        _ => 0.0,
                    });
                    let alpha = match model {
                        OpticalModel::EmissionAbsorption | OpticalModel::Absorption => alpha,
                        _ => 0.0,
                    };
                    [light[0], light[1], light[2], alpha]
                });
            }
        }
    }
}

// A linear field is linear along a ray: one segment of `core::optics`, with knots, a tent
// and a step in it, however many cells there are. Coefficients and sizes are such that f32
// holds the samples exactly.
#[test]
fn a_linear_field_is_one_segment() {
    let field = |p: DVec3| 0.25 * p.x + 0.5 * p.y + 0.125 * p.z;
    for n in [1, 4, 16] {
        let place = Place::unit(n);
        let grid = grid(&place, field);
        for model in OpticalModel::VOLUMETRIC {
            let look = appearance(knots(), model);
            let truth = truth(&grid, &look);
            for view in views(16) {
                let image = truth.render_exact(&view).expect("a valid view");
                check(&image, &view, |ray| {
                    let mut integral = RayIntegral::new(&look.transfer_function, model);
                    if let Some((start, end)) = span(&place, ray) {
                        integral.add(&Segment {
                            front: field(ray.at(start)),
                            back: field(ray.at(end)),
                            length: end - start,
                        });
                    }
                    integral.over([0.0; 4])
                });
            }
        }
    }
}

// The same field on a mesh and on a grid, over two bounds.
#[test]
fn a_linear_field_looks_the_same_on_a_mesh() {
    let field = |p: DVec3| 0.25 * p.x + 0.5 * p.y + 0.125 * p.z;
    let grid = grid(&Place::unit(4), field);
    let mesh = mesh(kuhn(2, DVec3::ZERO, DVec3::ONE), field);
    for model in OpticalModel::VOLUMETRIC {
        let look = appearance(knots(), model);
        let (on_grid, on_mesh) = (truth(&grid, &look), reference(&mesh, &look));
        for view in views(24) {
            let view = View {
                background: [0.2, 0.4, 0.6, 0.5],
                ..view
            };
            let a = on_grid.render_exact(&view).expect("a valid view");
            let b = on_mesh.render_exact(&view).expect("a valid view");
            for i in 0..a.pixels.len() {
                let bound = a.error_bound[i] + b.error_bound[i];
                for (a, b) in a.pixels[i].iter().zip(b.pixels[i]) {
                    assert!(
                        (a - b).abs() <= bound,
                        "{model:?} {i}: {a} {b}, bound {bound:e}"
                    );
                    assert!((a - b).abs() < 1e-10, "{model:?} {i}: {a} {b}");
                }
            }
        }
    }
}

/// Nodes and weights of Gauss's 5-point rule on [−1, 1] (Abramowitz & Stegun 25.4.30).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// ∫ f over [from, to] by `panels` 5-point rules: order 10.
pub(crate) fn quadrature(from: f64, to: f64, panels: usize, f: &dyn Fn(f64) -> f64) -> f64 {
    let h = (to - from) / panels as f64;
    let panel = |i: usize| {
        let middle = from + (i as f64 + 0.5) * h;
        GAUSS
            .iter()
            .map(|(x, w)| w * f(middle + 0.5 * h * x))
            .sum::<f64>()
    };
    0.5 * h * (0..panels).map(panel).sum::<f64>()
}

// s = x y z is trilinear, so that any grid has it exactly, and a cubic along a ray. Where
// it stays between two knots the integrals are smooth: nested quadrature, in world space.
#[test]
fn a_product_of_coordinates_agrees_with_quadrature() {
    let field = |p: DVec3| p.x * p.y * p.z;
    let look = |model| {
        let knots = vec![
            knot(-1.0, [0.0, 1.0, 0.3], 0.5),
            knot(2.0, [1.0, 0.1, 0.7], 9.5),
        ];
        appearance(knots, model)
    };
    let place = Place::unit(4);
    let grid = grid(&place, field);
    for model in [
        OpticalModel::EmissionAbsorption,
        OpticalModel::Emission,
        OpticalModel::Absorption,
    ] {
        let look = look(model);
        let truth = truth(&grid, &look);
        for view in views(6) {
            let image = truth.render_exact(&view).expect("a valid view");
            check(&image, &view, |ray| {
                let Some((start, end)) = span(&place, ray) else {
                    return [0.0; 4];
                };
                let at = |t: f64| {
                    let sampled = look.transfer_function.sample(field(ray.at(t)));
                    sampled.expect("a number")
                };
                let depth = |t: f64| quadrature(start, t, 8, &|t| at(t).1);
                let tau = depth(end);
                let light = |channel: usize| {
                    quadrature(start, end, 12, &|t| {
                        let (color, extinction) = at(t);
                        let before = match model {
                            OpticalModel::EmissionAbsorption => (-depth(t)).exp(),
                            OpticalModel::Emission => 1.0,
                            _ => 0.0,
                        };
                        color[channel] * extinction * before
                    })
                };
                let alpha = if model == OpticalModel::Emission {
                    0.0
                } else {
                    -(-tau).exp_m1()
                };
                [light(0), light(1), light(2), alpha]
            });
        }
    }
}

// σ = 5 where s = x y z lies in [0.1, 0.4], and a tent around 0.6: τ is 5 times the
// length on which s is in the box, and for the tent ∫ of pieces between its knots.
// Seen along the diagonal s rises all the way, so that each knot is met once, where
// bisection finds it.
#[test]
fn boxes_and_tents_over_a_product() {
    let field = |p: DVec3| p.x * p.y * p.z;
    let knots = vec![
        knot(0.1, [1.0; 3], 0.0),
        knot(0.1, [1.0; 3], 5.0),
        knot(0.4, [1.0; 3], 5.0),
        knot(0.4, [1.0; 3], 0.0),
        knot(0.59, [1.0; 3], 0.0),
        knot(0.6, [1.0; 3], 40.0),
        knot(0.61, [1.0; 3], 0.0),
    ];
    let look = appearance(knots, OpticalModel::Absorption);
    for n in [1, 8] {
        let place = Place::unit(n);
        let truth = truth(&grid(&place, field), &look);
        let projection = Projection::Orthographic {
            parallel_scale: 0.7,
        };
        let view = view([-2.0; 3], [0.5; 3], [0.0, 0.0, 1.0], projection, 24);
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |ray| {
            let Some((start, end)) = span(&place, ray) else {
                return [0.0; 4];
            };
            let place_of = |scalar: f64| {
                let (mut low, mut high) = (start, end);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    if field(ray.at(middle)) < scalar {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                high
            };
            let [a, b, c, d, e] = [0.1, 0.4, 0.59, 0.6, 0.61].map(place_of);
            let tent = |t: f64| 40.0 * (1.0 - (field(ray.at(t)) - 0.6).abs() / 0.01);
            let tau = 5.0 * (b - a) + quadrature(c, d, 8, &tent) + quadrature(d, e, 8, &tent);
            [0.0, 0.0, 0.0, -(-tau).exp_m1()]
        });
    }
}

// The greatest color of a hill inside of a cell: s = x (1 − x) … on the way through a
// saddle. With samples 0 and 1 at alternate corners, s = x + y − 2 x y (z alike) has its
// maximum on the diagonal x = y at 1/2: s = 2 x − 2 x² ≤ 1/2, and no corner shows it.
#[test]
fn the_extremes_of_a_cubic_count() {
    let place = Place::unit(1);
    let samples = (0..8).map(|i: usize| ((i & 1) ^ (i >> 1 & 1)) as f32);
    let grid = place.grid(Samples::F32(samples.collect()));
    let look = appearance(
        vec![knot(0.0, [0.0; 3], 1.0), knot(1.0, [1.0; 3], 1.0)],
        OpticalModel::MaximumIntensity,
    );
    let ray = Ray {
        origin: DVec3::new(-1.0, -1.0, 0.3),
        direction: DVec3::new(1.0, 1.0, 0.0).unit(),
    };
    let trace = truth(&grid, &look).trace(&ray).expect("a valid ray");
    assert_eq!(trace.intervals.len(), 1);
    assert!(
        (trace.pixel[0] - 0.5).abs() <= trace.error_bound,
        "{trace:?}"
    );
    assert!(trace.error_bound < 1e-12);
}

/// The same view of a scene turned by `turn` about the origin and then moved.
fn turned(view: &View, turn: DMat3) -> View {
    let camera = view.camera;
    View {
        camera: Camera {
            position: turn * camera.position,
            focal_point: turn * camera.focal_point,
            view_up: turn * camera.view_up,
            projection: camera.projection,
        },
        ..*view
    }
}

pub(crate) fn lumps(p: DVec3) -> f64 {
    0.4 + 0.3 * (5.0 * p.x + p.y).sin() * (3.0 * p.z - 2.0 * p.y).cos() + 0.2 * p.x
}

/// That two images agree within their bounds, and bounds are small: where a ray touches
/// the surface of a step, the length within δs of it goes with √δs, some 1e-7.
fn assert_alike(
    a: &tetrascope_reference::ReferenceImage,
    b: &tetrascope_reference::ReferenceImage,
) {
    assert!(a.pixels.iter().any(|p| p[3] > 0.0 || p[0] > 0.0));
    for i in 0..a.pixels.len() {
        let bound = a.error_bound[i] + b.error_bound[i];
        assert!(bound < 1e-6, "{bound:e}");
        for (x, y) in a.pixels[i].iter().zip(b.pixels[i]) {
            assert!(
                (x - y).abs() <= bound,
                "pixel {i}: {x} {y}, bound {bound:e}"
            );
        }
    }
}

// A quarter turn of grid and camera moves numbers to other axes. Cameras are generic: on
// symmetric ones rounding decides about rays in the very surface.
#[test]
fn quarter_turns_change_nothing() {
    let place = Place {
        dims: [7, 5, 9],
        spacing: DVec3::new(0.15, 0.2, 0.11),
        ..Place::unit(1)
    };
    let grid_here = grid(&place, lumps);
    let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    let cycle = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    for turn in [quarter, cycle, quarter * cycle] {
        let there = Place {
            origin: turn * place.origin,
            direction: turn,
            ..place
        };
        let grid_there = there.grid(grid_here.samples().clone());
        for model in OpticalModel::VOLUMETRIC {
            let look = appearance(knots(), model);
            let view = views(20).swap_remove(0);
            let a = truth(&grid_here, &look)
                .render_exact(&view)
                .expect("a valid view");
            let b = truth(&grid_there, &look);
            let b = b.render_exact(&turned(&view, turn)).expect("a valid view");
            assert_alike(&a, &b);
        }
    }
}

// The same samples in another order: an axis flipped in memory and in the direction.
#[test]
fn the_order_of_samples_does_not_matter() {
    let place = skewed();
    let here = grid(&place, lumps);
    let [nx, ny, nz] = place.dims;
    for axis in 0..3 {
        let mut samples = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let mut at = [i, j, k];
                    at[axis] = place.dims[axis] - 1 - at[axis];
                    let index = at[0] + nx * (at[1] + ny * at[2]);
                    samples.push(here.samples().get(index) as f32);
                }
            }
        }
        let mut corner = DVec3::ZERO;
        corner[axis] = (place.dims[axis] - 1) as f64;
        let mut flip = DVec3::ONE;
        flip[axis] = -1.0;
        let there = Place {
            origin: here.world_from_lattice(corner),
            direction: place.direction * DMat3::from_diagonal(flip),
            ..place
        };
        let there = there.grid(Samples::F32(samples));
        for model in OpticalModel::VOLUMETRIC {
            let look = appearance(knots(), model);
            let view = views(20).swap_remove(1);
            let a = truth(&here, &look)
                .render_exact(&view)
                .expect("a valid view");
            let b = truth(&there, &look)
                .render_exact(&view)
                .expect("a valid view");
            assert_alike(&a, &b);
        }
    }
}

// A power of two only moves exponents: bit for bit, as long as nothing under- or overflows.
#[test]
fn the_scale_is_arbitrary() {
    let place = skewed();
    for exponent in [-40, 3, 60] {
        let factor = 2f64.powi(exponent);
        let large = Place {
            origin: place.origin * factor,
            spacing: place.spacing * factor,
            ..place
        };
        let here = grid(&place, lumps);
        let there = large.grid(here.samples().clone());
        for view in views(12) {
            let mut far = view;
            far.camera.position *= factor;
            far.camera.focal_point *= factor;
            if let Projection::Orthographic { parallel_scale } = &mut far.camera.projection {
                *parallel_scale *= factor;
            }
            let thin = |k: &Knot| Knot {
                extinction: k.extinction / factor,
                ..*k
            };
            let look = appearance(knots(), OpticalModel::EmissionAbsorption);
            let thin = appearance(knots().iter().map(thin).collect(), look.optical_model);
            let a = truth(&here, &look)
                .render_exact(&view)
                .expect("a valid view");
            let b = truth(&there, &thin)
                .render_exact(&far)
                .expect("a valid view");
            assert_eq!(a.pixels, b.pixels, "{exponent}");
        }
    }
}

// Cells with a NaN or an infinity at a corner are as if they were not there, also where
// infinities of both signs are neighbors.
#[test]
fn cells_without_a_value_are_not_there() {
    let place = Place::unit(8);
    let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39];
    let solid = |p: DVec3| match p.x > 0.51 {
        true => none[(8.0 * (p.x + p.y + p.z)).round() as usize % none.len()],
        false => 0.8,
    };
    let half = Place {
        dims: [5, 9, 9],
        ..place
    };
    for model in OpticalModel::VOLUMETRIC {
        let look = appearance(
            vec![knot(0.0, [0.1; 3], 0.0), knot(1.0, [0.9; 3], 4.0)],
            model,
        );
        let with_gaps = truth(&grid(&place, solid), &look);
        let without = truth(&grid(&half, |_| 0.8), &look);
        for view in views(16) {
            let a = with_gaps.render_exact(&view).expect("a valid view");
            let b = without.render_exact(&view).expect("a valid view");
            for (i, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
                let off = a
                    .iter()
                    .zip(b)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                assert!(off < 1e-12, "{model:?} {view:?} {i}: {off:e}");
            }
        }
    }
}

#[test]
fn a_grid_goes_through_the_trait() {
    let place = Place::unit(6);
    let (one, other) = (grid(&place, lumps), grid(&place, |p| p.y));
    let look = appearance(knots(), OpticalModel::EmissionAbsorption);
    let view = views(20).swap_remove(0);
    let options = ReferenceOptions { threads: Some(1) };
    let mut single = Reference::new(&Volume::Grid(one.clone()), &look, &options).expect("drawn");
    let frame = single.render(&view).expect("drawn");
    assert_eq!(
        frame.pixels,
        truth(&one, &look).render(&view).expect("drawn").pixels
    );
    assert_eq!(frame.stats.bytes_resident, 7 * 7 * 7 * 4);
    assert!(frame.stats.get(CELL_VISITS).expect("counted") > 100);
    assert!(frame.stats.error_bound.expect("known") < 1e-7);
    single.reload(&Volume::Grid(other.clone())).expect("a grid");
    let again = single.render(&view).expect("drawn");
    assert_eq!(
        again.pixels,
        truth(&other, &look).render(&view).expect("drawn").pixels
    );
    assert_eq!(single.bvh_builds(), 0);
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::ONE), |p| p.y);
    single.reload(&Volume::Mesh(mesh)).expect("a mesh");
    assert_eq!(single.bvh_builds(), 1);

    let nowhere = Ray {
        origin: DVec3::ZERO,
        direction: DVec3::ZERO,
    };
    let truth = truth(&one, &look);
    assert!(truth.trace(&nowhere).is_err());
    let away = Ray {
        origin: DVec3::splat(1e308),
        direction: DVec3::X,
    };
    assert!(matches!(truth.trace(&away), Err(Error::Invalid { .. })));
    // Intervals lie end to end, through corners too.
    let diagonal = Ray {
        origin: DVec3::splat(-1.0),
        direction: DVec3::ONE,
    };
    let trace = truth.trace(&diagonal).expect("a valid ray");
    assert_eq!(trace.intervals.len(), 6);
    assert!(trace.intervals.windows(2).all(|p| p[0].t_out == p[1].t_in));
    assert!(
        trace
            .intervals
            .windows(2)
            .all(|p| (p[0].scalar_out - p[1].scalar_in).abs() < 1e-14)
    );
}

// A uniform grid behind planes: the chord that planes and box leave, in every model.
#[test]
fn clip_planes_cut_a_grid() {
    let place = Place::unit(4);
    let (color, sigma) = ([0.9, 0.5, 0.2], 1.7);
    let planes = vec![
        ClipPlane {
            point: DVec3::splat(0.4),
            normal: DVec3::new(1.0, 2.0, -0.5),
        },
        ClipPlane {
            point: DVec3::new(0.8, 0.7, 0.9),
            normal: DVec3::new(-3.0, 0.1, 0.2),
        },
    ];
    for model in OpticalModel::VOLUMETRIC {
        let look = Appearance {
            clip_planes: planes.clone(),
            ..appearance(vec![knot(0.0, color, sigma)], model)
        };
        let truth = truth(&grid(&place, |p| p.x), &look);
        for view in views(24) {
            let image = truth.render_exact(&view).expect("a valid view");
            check(&image, &view, |ray| {
                let [mut near, mut far] = span(&place, ray).map_or([1.0, 0.0], |s| [s.0, s.1]);
                for plane in &planes {
                    let (height, rise) = (
                        plane.normal.dot(ray.origin - plane.point),
                        plane.normal.dot(ray.direction),
                    );
                    match rise > 0.0 {
                        true => near = near.max(-height / rise),
                        false => far = far.min(-height / rise),
                    }
                }
                let tau = sigma * (far - near).max(0.0);
                let alpha = -(-tau).exp_m1();
                let light = color.map(|c| match model {
                    OpticalModel::EmissionAbsorption => c * alpha,
                    OpticalModel::Emission => c * tau,
                    OpticalModel::MaximumIntensity if tau > 0.0 => c,
                    _ => 0.0,
                });
                let alpha = match model {
                    OpticalModel::EmissionAbsorption | OpticalModel::Absorption => alpha,
                    _ => 0.0,
                };
                [light[0], light[1], light[2], alpha]
            });
        }
    }
}
