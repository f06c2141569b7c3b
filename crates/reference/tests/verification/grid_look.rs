//! Isosurfaces and depth cue on regular grids: closed forms, and searches made here.

use crate::closed_forms::check;
use crate::grids::{lumps, quadrature, skewed, span, truth};
use crate::scenes::*;
use tetrascope_core::appearance::clip_ray;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::optics::{self, RayIntegral, Segment};
use tetrascope_core::{
    Appearance, Bounds, ClipPlane, DepthCue, DirectionalLight, Grid, Isosurface, Lighting,
    OpticalModel, Ray, View,
};
use tetrascope_testing::{Place, grid};

fn surfaces(values: &[(f64, [f64; 3])]) -> Appearance {
    let mut look = appearance(vec![knot(0.0, [0.0; 3], 0.0)], OpticalModel::Isosurfaces);
    let surface = |&(value, color): &(f64, [f64; 3])| Isosurface {
        value,
        color: color.into(),
    };
    look.isosurfaces = values.iter().map(surface).collect();
    let light = |toward, color| DirectionalLight { toward, color };
    look.lighting = Lighting {
        ambient: 0.1,
        lights: vec![
            light(DVec3::new(1.0, -2.0, -1.0), DVec3::new(0.5, 0.6, 0.7)),
            light(DVec3::new(-3.0, 1.0, 2.0), DVec3::new(0.9, 0.1, 0.4)),
        ],
    };
    look
}

/// The stretch that is left of a ray in the grid.
fn stretch(place: &Place, look: &Appearance, ray: &Ray) -> Option<(f64, f64)> {
    let (start, end) = span(place, ray)?;
    let [near, far] = clip_ray(&look.clip_planes, ray);
    let (start, end) = (start.max(near), end.min(far));
    (start < end).then_some((start, end))
}

/// A field in world space: the scalar and its gradient at a point.
type Field<'a> = &'a dyn Fn(DVec3) -> (f64, DVec3);

/// Draws `grid` and compares with the first of `STEPS` steps of each ray on which the field
/// passes a value, and bisection there. Returns how many hits were compared.
///
/// Left out, and at most one ray in a hundred, is what differs where the bound says that
/// the hit is in doubt, or where the field may turn back within a step of a value.
fn check_surfaces(place: &Place, grid: &Grid, look: &Appearance, field: Field) -> usize {
    const STEPS: usize = 2000;
    let truth = truth(grid, look);
    let (mut hits, mut left_out, mut rays) = (0, 0, 0);
    for view in views(24) {
        let view = View {
            background: [0.2, 0.5, 0.7, 0.5],
            ..view
        };
        let image = truth.render_exact(&view).expect("a valid view");
        let depths = image.depths.as_ref().expect("surfaces have depths");
        let (_, _, forward) = view.camera.axes();
        let lights = look.lighting.resolved(forward);
        let ramp = look
            .depth_cue
            .map(|cue| cue.ramp(view.camera.position, forward, &grid.bounds()));
        for (i, got) in image.pixels.iter().enumerate() {
            let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
            let mut met: Option<(usize, f64)> = None;
            if let Some((start, end)) = stretch(place, look, &ray) {
                rays += 1;
                let at = |step: usize| start + (end - start) * (step as f64 / STEPS as f64);
                let scalar = |t: f64| field(ray.at(t)).0;
                let mut before = scalar(start);
                for step in 0..STEPS {
                    let after = scalar(at(step + 1));
                    for (index, surface) in look.isosurfaces.iter().enumerate() {
                        let below = |s: f64| s < surface.value;
                        if below(before) == below(after) {
                            continue;
                        }
                        let (mut low, mut high) = (at(step), at(step + 1));
                        for _ in 0..100 {
                            let middle = 0.5 * (low + high);
                            if below(scalar(middle)) == below(before) {
                                low = middle;
                            } else {
                                high = middle;
                            }
                        }
                        if met.is_none_or(|(_, t)| high < t) {
                            met = Some((index, high));
                        }
                    }
                    if met.is_some() {
                        break;
                    }
                    before = after;
                }
            }
            let t = met.map_or(f64::INFINITY, |(_, t)| t);
            let bound = image.error_bound[i];
            let doubtful = bound >= 1e-6 || (depths[i] - t).abs() > 1e-3;
            if (depths[i] != t) && doubtful {
                left_out += 1;
                continue;
            }
            let behind = view.premultiplied_background();
            let mut want = behind;
            if let Some((index, t)) = met {
                hits += 1;
                // The search's own scalars are rounded otherwise, which moves the hit where
                // a ray grazes a surface, as the bound says.
                assert!(
                    (depths[i] - t).abs() < 1e-11 + 100.0 * bound,
                    "pixel {i}: {} {t}",
                    depths[i]
                );
                let color = look.isosurfaces[index].color;
                // Before a face between cells: the gradient there is another one.
                let normal = field(ray.at(t - 1e-9)).1;
                let mut lit = look.lighting.shade(&lights, color, normal, ray.direction);
                if let Some(ramp) = ramp {
                    lit *= ramp.at(t * ray.direction.dot(forward));
                }
                want = optics::over(look.optical_model, lit, f64::INFINITY, behind);
            }
            for (got, want) in got.iter().zip(want) {
                let error = (got - want).abs();
                // 1e-9 before the surface the gradient differs by 1e-9 of its own change.
                assert!(
                    error <= bound + 1e-7,
                    "pixel {i} is {got}, not {want}; bound {bound:e}"
                );
            }
        }
    }
    assert!(left_out * 100 <= rays, "{left_out} of {rays}");
    hits
}

/// The trilinear interpolant of `grid`, by a formula of its own, and its gradient.
fn interpolant(grid: &Grid) -> impl Fn(DVec3) -> (f64, DVec3) + '_ {
    let turn = grid.direction().transpose();
    let [nx, ny, nz] = grid.dims();
    move |p: DVec3| {
        let local = turn * (p - grid.origin()) / grid.spacing();
        let last = DVec3::new((nx - 2) as f64, (ny - 2) as f64, (nz - 2) as f64);
        let cell = local.floor().clamp(DVec3::ZERO, last);
        let f = local - cell;
        let [i, j, k] = cell.to_array().map(|c| c as usize);
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for corner in 0..8 {
            let bits = [corner & 1, corner >> 1 & 1, corner >> 2];
            let index = i + bits[0] + nx * (j + bits[1] + ny * (k + bits[2]));
            let sample = grid.samples().get(index);
            let weight = |a: usize| if bits[a] == 1 { f[a] } else { 1.0 - f[a] };
            let sign = |a: usize| if bits[a] == 1 { 1.0 } else { -1.0 };
            value += sample * weight(0) * weight(1) * weight(2);
            slope += sample
                * DVec3::new(
                    sign(0) * weight(1) * weight(2),
                    weight(0) * sign(1) * weight(2),
                    weight(0) * weight(1) * sign(2),
                );
        }
        (value, grid.direction() * (slope / grid.spacing()))
    }
}

// The samples are exact in f32, so that the surfaces are planes whatever the cells.
#[test]
fn isosurfaces_of_a_linear_field_are_planes() {
    const SLOPE: DVec3 = DVec3::new(0.25, 0.5, 0.125);
    let look = surfaces(&[
        (0.61, [1.0, 0.2, 0.1]),
        (0.234, [0.1, 0.9, 0.4]),
        (5.0, [1.0; 3]),
    ]);
    for n in [1, 4] {
        let place = Place::unit(n);
        let grid = grid(&place, |p| SLOPE.dot(p));
        let truth = truth(&grid, &look);
        let mut hits = 0;
        for view in views(24) {
            let image = truth.render_exact(&view).expect("a valid view");
            let depths = image.depths.as_ref().expect("surfaces have depths");
            let lights = look.lighting.resolved(view.camera.axes().2);
            for (i, got) in image.pixels.iter().enumerate() {
                let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
                let (start, end) = span(&place, &ray).unwrap_or((0.0, 0.0));
                let nearest = |met: Option<(usize, f64)>, index: usize| {
                    let value = look.isosurfaces[index].value;
                    let t = (value - SLOPE.dot(ray.origin)) / SLOPE.dot(ray.direction);
                    let nearer = met.is_none_or(|(_, n)| t < n);
                    (t > start && t < end && nearer)
                        .then_some((index, t))
                        .or(met)
                };
                let want = match (0..3).fold(None, nearest) {
                    None => {
                        assert_eq!(depths[i], f64::INFINITY, "pixel {i}");
                        [0.0; 4]
                    }
                    Some((index, t)) => {
                        hits += 1;
                        // An ulp of scalars below 1, over the least slope of these rays.
                        assert!((depths[i] - t).abs() < 1e-12, "pixel {i}");
                        let color = look.isosurfaces[index].color;
                        let lit = look.lighting.shade(&lights, color, SLOPE, ray.direction);
                        optics::over(look.optical_model, lit, f64::INFINITY, [0.0; 4])
                    }
                };
                for (got, want) in got.iter().zip(want) {
                    let error = (got - want).abs();
                    assert!(error <= image.error_bound[i] + 1e-16 && error < 1e-12);
                }
            }
        }
        assert!(hits > 500, "{hits}");
    }
}

// s = x y z is trilinear, so that every grid has it exactly: a cubic along a ray.
#[test]
fn isosurfaces_of_a_product_are_roots_of_cubics() {
    let field = |p: DVec3| (p.x * p.y * p.z, DVec3::new(p.y * p.z, p.x * p.z, p.x * p.y));
    let mut look = surfaces(&[(0.3, [1.0, 0.2, 0.1]), (0.05, [0.1, 0.9, 0.4])]);
    for n in [1, 4] {
        let place = Place::unit(n);
        let grid = grid(&place, |p| field(p).0);
        assert!(check_surfaces(&place, &grid, &look, &field) > 1000);
    }
    look.depth_cue = Some(DepthCue { strength: 0.7 });
    look.clip_planes = vec![
        ClipPlane {
            point: DVec3::splat(0.9),
            normal: DVec3::new(-1.0, -0.2, -0.3),
        },
        ClipPlane {
            point: DVec3::new(0.3, 0.2, 0.4),
            normal: DVec3::new(0.1, 0.3, 1.0),
        },
    ];
    look.lighting = Lighting::default();
    let grid = grid(&Place::unit(2), |p| field(p).0);
    assert!(check_surfaces(&Place::unit(2), &grid, &look, &field) > 300);
}

// |p − m|² sampled on a lattice: each coordinate's square becomes a chain of chords, so that
// a ray meets the surface where a sum of three piecewise linear functions does.
#[test]
fn isosurfaces_of_a_sampled_ball() {
    let place = Place::unit(8);
    let field = |p: DVec3| (p - DVec3::splat(0.5)).length_squared();
    let grid = grid(&place, field);
    let chord = |x: f64| {
        let cell = (8.0 * x).floor().clamp(0.0, 7.0);
        let ends = [cell, cell + 1.0].map(|c| (c / 8.0 - 0.5) * (c / 8.0 - 0.5));
        let f = 8.0 * x - cell;
        (ends[0] * (1.0 - f) + ends[1] * f, 8.0 * (ends[1] - ends[0]))
    };
    let sampled = |p: DVec3| {
        let [x, y, z] = p.to_array().map(chord);
        (x.0 + y.0 + z.0, DVec3::new(x.1, y.1, z.1))
    };
    let look = surfaces(&[(0.2, [1.0, 0.2, 0.1]), (0.1, [0.1, 0.9, 0.4])]);
    assert!(check_surfaces(&place, &grid, &look, &sampled) > 1000);
}

// Stretched, flipped and turned, every sample type, many surfaces.
#[test]
fn isosurfaces_of_any_grid_are_what_a_search_finds() {
    let place = skewed();
    let count: usize = place.dims.iter().product();
    let wave = |i: usize| ((i * 7919) % 97) as f64 / 97.0 + (i as f64 / 30.0).sin();
    let look = surfaces(&[
        (40.3, [1.0, 0.2, 0.1]),
        (60.7, [0.1, 0.9, 0.4]),
        (20.1, [0.3, 0.4, 1.0]),
    ]);
    let floats: Vec<f64> = (0..count).map(|i| 40.0 + 25.0 * wave(i)).collect();
    for samples in [
        Samples::F32(floats.iter().map(|v| *v as f32).collect()),
        Samples::U8(floats.iter().map(|v| *v as u8).collect()),
        Samples::I16(floats.iter().map(|v| *v as i16).collect()),
    ] {
        let grid = place.grid(samples);
        let hits = check_surfaces(&place, &grid, &look, &interpolant(&grid));
        assert!(hits > 1000, "{hits}");
    }
}

// A ray into a row of cells that rise to the value and fall again: it touches the surface at
// a sample, and meets it there; one that falls to the value and rises again does not.
#[test]
fn a_surface_that_is_touched() {
    let place = Place {
        dims: [3, 2, 2],
        ..Place::unit(1)
    };
    let row = |values: [f32; 3]| {
        let samples = (0..4).flat_map(|_| values).collect();
        place.grid(Samples::F32(samples))
    };
    let look = surfaces(&[(0.5, [1.0; 3])]);
    let ray = Ray {
        origin: DVec3::new(-1.0, 0.3, 0.7),
        direction: DVec3::X,
    };
    let depth = |grid: &Grid| truth(grid, &look).trace(&ray).expect("a ray").surface_depth;
    assert_eq!(depth(&row([0.0, 0.5, 0.0])), 2.0);
    assert_eq!(depth(&row([1.0, 0.5, 1.0])), f64::INFINITY);
    assert_eq!(depth(&row([0.0, 0.5, 1.0])), 2.0);
    assert_eq!(depth(&row([1.0, 0.5, 0.0])), 2.0);
    assert_eq!(depth(&row([0.5, 0.5, 0.5])), f64::INFINITY);
    // Nothing joins what a hole tears apart, and none ends in a surface.
    assert_eq!(depth(&row([0.0, f32::NAN, 1.0])), f64::INFINITY);
    assert_eq!(depth(&row([0.0, 0.25, f32::INFINITY])), f64::INFINITY);
}

// Rays along the lattice's planes and edges meet a surface once, with doubt in the bound
// where the normal is that of one cell or another.
#[test]
fn rays_in_faces_meet_surfaces_too() {
    let place = Place::unit(4);
    let grid = grid(&place, |p| (p - DVec3::splat(0.5)).length());
    let look = surfaces(&[(0.3, [1.0; 3])]);
    let truth = truth(&grid, &look);
    for (y, z) in [(0.5, 0.5), (0.25, 0.5), (0.5, 0.4), (0.5, 0.25)] {
        let ray = Ray {
            origin: DVec3::new(-1.0, y, z),
            direction: DVec3::X,
        };
        let trace = truth.trace(&ray).expect("a ray");
        assert!((1.0..1.5).contains(&trace.surface_depth), "{y} {z}");
        assert!(trace.error_bound >= 1.0 && trace.pixel[3] == 1.0);
    }
}

fn cued(model: OpticalModel, knots: Vec<tetrascope_core::Knot>) -> Appearance {
    Appearance {
        depth_cue: Some(DepthCue { strength: 0.8 }),
        ..appearance(knots, model)
    }
}

/// The factor of light at a distance of `t` along a ray of `view`.
fn fade(look: &Appearance, view: &View, bounds: &Bounds) -> impl Fn(&Ray, f64) -> f64 + use<> {
    let (_, _, forward) = view.camera.axes();
    let cue = look.depth_cue.expect("there is one");
    let ramp = cue.ramp(view.camera.position, forward, bounds);
    move |ray: &Ray, t: f64| ramp.at(t * ray.direction.dot(forward))
}

// A linear field is one segment, which core integrates in closed form.
#[test]
fn a_depth_cue_dims_what_is_far() {
    let field = |p: DVec3| 0.25 * p.x + 0.5 * p.y + 0.125 * p.z;
    let knots = || {
        vec![
            knot(0.0, [0.9, 0.1, 0.3], 0.2),
            knot(0.5, [0.2, 0.8, 0.4], 5.0),
            knot(0.5, [0.7, 0.3, 1.0], 0.5),
            knot(0.8, [0.1, 0.6, 0.5], 9.0),
        ]
    };
    for n in [1, 4] {
        let place = Place::unit(n);
        let grid = grid(&place, field);
        for model in OpticalModel::VOLUMETRIC {
            let look = cued(model, knots());
            let truth = truth(&grid, &look);
            for view in views(16) {
                let image = truth.render_exact(&view).expect("a valid view");
                let fade = fade(&look, &view, &grid.bounds());
                check(&image, &view, |ray| {
                    let mut integral = RayIntegral::new(&look.transfer_function, model);
                    if let Some((start, end)) = span(&place, ray) {
                        let segment = Segment {
                            front: field(ray.at(start)),
                            back: field(ray.at(end)),
                            length: end - start,
                        };
                        integral.add_cued(&segment, [fade(ray, start), fade(ray, end)]);
                    }
                    integral.over([0.0; 4])
                });
            }
        }
    }
}

// The same over a product of coordinates, a cubic, by nested quadrature in world space.
#[test]
fn a_depth_cue_over_a_cubic_agrees_with_quadrature() {
    let field = |p: DVec3| p.x * p.y * p.z;
    // One color; then two, on the same extinctions.
    for far in [[0.0, 1.0, 0.3], [1.0, 0.1, 0.7]] {
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
            let knots = vec![knot(-1.0, [0.0, 1.0, 0.3], 0.5), knot(2.0, far, 9.5)];
            let look = cued(model, knots);
            let place = Place::unit(4);
            let grid = grid(&place, field);
            let truth = truth(&grid, &look);
            for view in views(6) {
                let image = truth.render_exact(&view).expect("a valid view");
                let fade = fade(&look, &view, &grid.bounds());
                check(&image, &view, |ray| {
                    let Some((start, end)) = span(&place, ray) else {
                        return [0.0; 4];
                    };
                    let at = |t: f64| {
                        let sampled = look.transfer_function.sample(field(ray.at(t)));
                        sampled.expect("a number")
                    };
                    let absorbs = model == OpticalModel::EmissionAbsorption;
                    let depth = |t: f64| match absorbs {
                        true => quadrature(start, t, 8, &|t| at(t).1),
                        false => 0.0,
                    };
                    let light = |channel: usize| {
                        quadrature(start, end, 12, &|t| {
                            let (color, extinction) = at(t);
                            fade(ray, t) * color[channel] * extinction * (-depth(t)).exp()
                        })
                    };
                    [light(0), light(1), light(2), -(-depth(end)).exp_m1()]
                });
            }
        }
    }
}

// The greatest cued color, searched for on 20001 places of each ray. A maximum between two
// of them is higher by at most (h/2)²/2 of the second derivative: h ≤ √3/20000, and the
// field's second derivative along a ray is below 60 (12 waves of 0.5), times the colors'
// slope of 4: 60 · 4 · 9.4e-10 = 2.3e-7; at a knot the color turns at once, so that it is
// higher by at most 4 times the field's slope of 12 times h/2: 2e-3.
#[test]
fn the_greatest_cued_color_is_what_a_search_finds() {
    let place = skewed();
    let grid = grid(&place, lumps);
    let at = interpolant(&grid);
    let knots = vec![
        knot(0.2, [0.0, 0.2, 0.9], 1.0),
        knot(0.4, [0.3, 0.8, 0.1], 1.0),
        knot(0.7, [0.9, 0.1, 0.5], 1.0),
    ];
    let look = cued(OpticalModel::MaximumIntensity, knots);
    let truth = truth(&grid, &look);
    let mut shown = 0;
    for view in views(8) {
        let image = truth.render_exact(&view).expect("a valid view");
        let fade = fade(&look, &view, &grid.bounds());
        for (i, got) in image.pixels.iter().enumerate() {
            let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
            let Some((start, end)) = span(&place, &ray) else {
                continue;
            };
            let mut most = DVec3::ZERO;
            for step in 0..=20000 {
                let t = start + (end - start) * (f64::from(step) / 20000.0);
                let scalar = at(ray.at(t)).0;
                let sampled = look.transfer_function.sample(scalar).expect("a number");
                most = most.max(sampled.0 * fade(&ray, t));
            }
            for channel in 0..3 {
                let over = got[channel] - most[channel];
                assert!(
                    (-1e-9..2e-3).contains(&over),
                    "pixel {i}: {} {}",
                    got[channel],
                    most[channel]
                );
            }
            shown += 1;
        }
    }
    assert!(shown > 100, "{shown}");
}
