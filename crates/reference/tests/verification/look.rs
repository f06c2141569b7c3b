//! Clip planes, depth cue and isosurfaces in closed form: in a box with a linear field,
//! whatever its cells, a ray is one segment.

use crate::scenes::*;
use tetrascope_core::appearance::clip_ray;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::optics::{self, RayIntegral, Segment};
use tetrascope_core::{
    Appearance, ClipPlane, DepthCue, DirectionalLight, Isosurface, Lighting, OpticalModel, Ray,
    Scalars, TetMesh, View, Volume,
};

const SLOPE: DVec3 = DVec3::new(0.5, -0.3, 0.7);

fn scalar(p: DVec3) -> f64 {
    0.1 + SLOPE.dot(p)
}

fn cube() -> TetMesh {
    mesh(kuhn(3, DVec3::ZERO, DVec3::ONE), scalar)
}

fn knots() -> Vec<tetrascope_core::Knot> {
    vec![
        knot(0.0, [0.9, 0.1, 0.3], 0.2),
        knot(0.5, [0.2, 0.8, 0.4], 5.0),
        knot(0.5, [0.7, 0.3, 1.0], 0.5),
        knot(1.2, [0.1, 0.6, 0.5], 9.0),
    ]
}

/// The stretch that is left of a ray in the unit cube.
fn stretch(look: &Appearance, ray: &Ray) -> Option<(f64, f64)> {
    let (t_in, t_out) = box_interval(ray, DVec3::ZERO, DVec3::ONE)?;
    let [near, far] = clip_ray(&look.clip_planes, ray);
    let (t_in, t_out) = (t_in.max(near), t_out.min(far));
    (t_in < t_out).then_some((t_in, t_out))
}

/// Compares with the whole ray's integral, to 1e-10 and to the image's own bound. A ray that
/// ends on a step of the transfer function has a maximum on either side; the bound knows.
fn check_volume(look: &Appearance) {
    let mesh = cube();
    let truth = reference(&mesh, look);
    let mut doubtful = Vec::new();
    for view in views(24) {
        let image = truth.render_exact(&view).expect("a valid view");
        let (_, _, forward) = view.camera.axes();
        let ramp = look
            .depth_cue
            .map(|cue| cue.ramp(view.camera.position, forward, &mesh.bounds()));
        for (i, got) in image.pixels.iter().enumerate() {
            let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
            let mut integral = RayIntegral::new(&look.transfer_function, look.optical_model);
            if let Some((t_in, t_out)) = stretch(look, &ray) {
                let at = |t: f64| ray.origin + t * ray.direction;
                let segment = Segment {
                    front: scalar(at(t_in)),
                    back: scalar(at(t_out)),
                    length: t_out - t_in,
                };
                let depth = |t: f64| forward.dot(at(t) - view.camera.position);
                let cue = ramp.map_or([1.0; 2], |r| [r.at(depth(t_in)), r.at(depth(t_out))]);
                integral.add_cued(&segment, cue);
            }
            let want = integral.over([0.0; 4]);
            for (got, want) in got.iter().zip(want) {
                let error = (got - want).abs();
                if error > 1e-10 && look.optical_model == OpticalModel::MaximumIntensity {
                    doubtful.push(i);
                    assert!(error <= image.error_bound[i], "pixel {i}");
                    continue;
                }
                assert!(
                    error <= image.error_bound[i] && error <= 1e-10,
                    "{:?}: pixel {i} is {got}, not {want}; bound {:e}",
                    look.optical_model,
                    image.error_bound[i]
                );
            }
        }
        assert_eq!(image.inconsistent_pixels, 0);
    }
    // Channels of 11 views with 576 pixels each.
    assert!(doubtful.len() <= 6, "{doubtful:?}");
}

fn tilted() -> Vec<ClipPlane> {
    let plane = |point: [f64; 3], normal: [f64; 3]| ClipPlane {
        point: point.into(),
        normal: normal.into(),
    };
    vec![
        plane([0.31, 0.4, 0.5], [2.0, 1.0, -0.5]),
        plane([0.77, 0.8, 0.9], [-1.0, -0.2, -3.0]),
    ]
}

#[test]
fn clip_planes_cut_cells_exactly() {
    for model in OpticalModel::VOLUMETRIC {
        let mut look = appearance(knots(), model);
        look.clip_planes = tilted();
        check_volume(&look);
        // Along faces of cells, and of the box.
        look.clip_planes = ClipPlane::of_box(&tetrascope_core::Bounds {
            min: DVec3::splat(1.0 / 3.0),
            max: DVec3::ONE,
        })
        .to_vec();
        check_volume(&look);
    }
}

#[test]
fn a_depth_cue_dims_what_is_far() {
    for model in OpticalModel::VOLUMETRIC {
        let mut look = appearance(knots(), model);
        look.depth_cue = Some(DepthCue { strength: 0.8 });
        check_volume(&look);
        look.clip_planes = tilted();
        check_volume(&look);
    }
}

#[test]
fn nothing_is_left_behind_all_planes() {
    let mut look = appearance(knots(), OpticalModel::EmissionAbsorption);
    look.clip_planes = vec![ClipPlane {
        point: DVec3::splat(2.0),
        normal: DVec3::X,
    }];
    let image = reference(&cube(), &look).render_exact(&views(8)[0]);
    let image = image.expect("a valid view");
    assert!(image.pixels.iter().all(|p| *p == [0.0; 4]));
    assert_eq!(image.cell_visits, 0);
}

// Two planes that keep nothing, nearer to each other than cells are wide: a ray's end is
// before its beginning, both in one cell.
#[test]
fn nothing_is_left_between_planes_that_look_away() {
    let plane = |x: f64, normal| ClipPlane {
        point: DVec3::splat(x),
        normal,
    };
    let mut look = surfaces();
    look.clip_planes = vec![plane(0.52, DVec3::ONE), plane(0.48, DVec3::NEG_ONE)];
    for view in views(16) {
        let image = reference(&cube(), &look).render_exact(&view);
        let image = image.expect("a valid view");
        assert!(image.pixels.iter().all(|p| *p == [0.0; 4]));
        assert_eq!(image.cell_visits, 0);
    }
}

fn surfaces() -> Appearance {
    let mut look = appearance(knots(), OpticalModel::Isosurfaces);
    let surface = |value, color: [f64; 3]| Isosurface {
        value,
        color: color.into(),
    };
    look.isosurfaces = vec![
        surface(0.61, [1.0, 0.2, 0.1]),
        surface(0.234, [0.1, 0.9, 0.4]),
        surface(5.0, [1.0; 3]),
    ];
    look.lighting = Lighting {
        ambient: 0.1,
        lights: vec![
            DirectionalLight {
                toward: DVec3::new(1.0, -2.0, -1.0),
                color: DVec3::new(0.5, 0.6, 0.7),
            },
            DirectionalLight {
                toward: DVec3::new(-3.0, 1.0, 2.0),
                color: DVec3::new(0.9, 0.1, 0.4),
            },
        ],
    };
    look
}

/// The nearest plane of a surface on a ray, and where; `None` for none. Rays that pass
/// within 1e-9 of where a surface ends are left out: `Err`.
fn met(look: &Appearance, ray: &Ray) -> Result<Option<(usize, f64)>, ()> {
    let Some((t_in, t_out)) = stretch(look, ray) else {
        return Ok(None);
    };
    let mut nearest = None;
    for (index, surface) in look.isosurfaces.iter().enumerate() {
        let t = (surface.value - scalar(ray.origin)) / SLOPE.dot(ray.direction);
        if (t - t_in).abs() < 1e-9 || (t - t_out).abs() < 1e-9 {
            return Err(());
        }
        if t > t_in && t < t_out && nearest.is_none_or(|(_, n)| t < n) {
            nearest = Some((index, t));
        }
    }
    Ok(nearest)
}

fn check_surfaces(look: &Appearance, background: [f32; 4]) {
    let mesh = cube();
    let truth = reference(&mesh, look);
    let (mut hits, mut left_out) = (0, 0);
    for view in views(24) {
        let view = View { background, ..view };
        let image = truth.render_exact(&view).expect("a valid view");
        let depths = image.depths.as_ref().expect("surfaces have depths");
        let (_, _, forward) = view.camera.axes();
        let lights = look.lighting.resolved(forward);
        let ramp = look
            .depth_cue
            .map(|cue| cue.ramp(view.camera.position, forward, &mesh.bounds()));
        for (i, got) in image.pixels.iter().enumerate() {
            let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
            let Ok(met) = met(look, &ray) else {
                left_out += 1;
                continue;
            };
            let behind = view.premultiplied_background();
            let mut want = behind;
            match met {
                None => assert_eq!(depths[i], f64::INFINITY, "pixel {i}"),
                Some((index, t)) => {
                    hits += 1;
                    assert!(
                        (depths[i] - t).abs() < 1e-12,
                        "pixel {i}: {} {t}",
                        depths[i]
                    );
                    let color = look.isosurfaces[index].color;
                    let mut lit = look.lighting.shade(&lights, color, SLOPE, ray.direction);
                    if let Some(ramp) = ramp {
                        lit *= ramp.at(t * ray.direction.dot(forward));
                    }
                    let model = OpticalModel::Isosurfaces;
                    want = optics::over(model, lit, f64::INFINITY, behind);
                }
            }
            for (got, want) in got.iter().zip(want) {
                let error = (got - want).abs();
                let bound = image.error_bound[i];
                assert!(
                    error <= bound + 1e-16,
                    "pixel {i} is {got}, not {want}; bound {bound:e}"
                );
                assert!(error < 1e-12, "pixel {i} is {got}, not {want}");
            }
        }
    }
    assert!(hits > 500 && left_out < hits / 10, "{hits} {left_out}");
}

#[test]
fn isosurfaces_of_a_linear_field_are_planes() {
    let look = surfaces();
    check_surfaces(&look, [0.0; 4]);
    check_surfaces(&look, [0.2, 0.5, 0.7, 0.5]);
    let mut turned = look.clone();
    turned.isosurfaces.reverse();
    check_surfaces(&turned, [0.0; 4]);
}

#[test]
fn surfaces_are_cut_and_cued() {
    let mut look = surfaces();
    look.clip_planes = tilted();
    check_surfaces(&look, [0.0; 4]);
    look.depth_cue = Some(DepthCue { strength: 0.6 });
    look.lighting = Lighting::default();
    check_surfaces(&look, [0.0; 4]);
}

// What is constant in each cell crosses no value in any.
#[test]
fn cell_data_has_no_isosurfaces() {
    let mesh = cube();
    let values = (0..mesh.cell_count()).map(|cell| cell as f64 / 100.0);
    let scalars = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values: values.collect(),
    };
    let mesh = mesh.with_scalars(scalars).expect("one for each cell");
    let truth = reference(&mesh, &surfaces());
    let image = truth.render_exact(&views(16)[0]).expect("a valid view");
    assert!(image.pixels.iter().all(|p| *p == [0.0; 4]));
}

// A surface whose value is the field's at vertices that rays meet is in doubt, and says so.
#[test]
fn a_surface_along_faces_is_in_doubt() {
    let flat = mesh(kuhn(2, DVec3::ZERO, DVec3::ONE), |p| (p.z - 0.5).max(0.0));
    let mut look = surfaces();
    look.isosurfaces[0].value = 0.0;
    look.isosurfaces.truncate(1);
    let image = reference(&flat, &look).render_exact(&views(16)[0]);
    let image = image.expect("a valid view");
    assert!(image.worst_error_bound() >= 1.0);
}

#[test]
fn an_appearance_that_is_none_is_refused() {
    let volume = Volume::Mesh(cube());
    let mut look = surfaces();
    look.isosurfaces[0].value = f64::NAN;
    let options = tetrascope_reference::ReferenceOptions::default();
    let error = tetrascope_reference::Reference::new(&volume, &look, &options);
    assert!(error.is_err());
}
