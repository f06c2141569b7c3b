//! Clip planes, depth cue, isosurfaces and opaque things in the way.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, CameraFit, ClipPlane, DepthCue, OpticalModel, Volume, VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::CELL_VISITS;
use tetrascope_testing::{
    ImageError, fitted, is_explained, jumping, outside_and_inside, ramp, scale, split,
    stacked_plates, surfaces, tilted,
};

use crate::common::{MAX, RMSE, check, mesh, new, renderer, scene};

fn check_all(name: &str, volume: &Volume, appearance: &Appearance) {
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let name = format!("{name}, {}", model.name());
        let views = outside_and_inside(volume, 40).map(|view| ("outside and inside", view));
        check(&name, &new(volume, &appearance), views);
    }
}

#[test]
fn clip_planes_and_cues() {
    for (name, cells) in [("sphere", 3000), ("torus", 2000), ("graded", 2000)] {
        let (volume, mut appearance) = scene(name, cells);
        appearance.clip_planes = tilted(&volume);
        check_all(&format!("{name}, clipped"), &volume, &appearance);
        appearance.depth_cue = Some(DepthCue { strength: 0.9 });
        check_all(&format!("{name}, both"), &volume, &appearance);
        // Denser than one part of a piece takes.
        let knots = appearance.transfer_function.knots().iter();
        let knots = knots.map(|k| tetrascope_core::Knot {
            extinction: 50.0 * k.extinction,
            ..*k
        });
        appearance.transfer_function =
            tetrascope_core::TransferFunction::new(knots.collect()).expect("sorted");
        check_all(&format!("{name}, both, dense"), &volume, &appearance);
    }
}

#[test]
fn what_planes_cut_away_is_left_out_behind() {
    let (volume, mut appearance) = scene("sphere", 3000);
    let view = outside_and_inside(&volume, 40)[0];
    let visits = |appearance: &Appearance| {
        let frame = renderer(&volume, appearance).render(&view);
        frame
            .expect("a frame")
            .stats
            .get(CELL_VISITS)
            .expect("counted")
    };
    let whole = visits(&appearance);
    // All but the part near the camera.
    appearance.clip_planes = vec![ClipPlane {
        point: volume.bounds().center() + 0.5 * DVec3::ONE.unit(),
        normal: DVec3::ONE,
    }];
    let near = visits(&appearance);
    assert!(2 * near < whole, "{near} {whole}");
}

#[test]
fn isosurfaces() {
    for (name, cells) in [
        ("sphere", 3000),
        ("orbital", 3000),
        ("torus", 2000),
        ("graded", 2000),
        ("jumping", 0),
    ] {
        let volume = match name {
            "jumping" => jumping(&mesh("sphere", 1000).0),
            _ => scene(name, cells).0,
        };
        let mut appearance = surfaces(&volume, ramp(&volume));
        for clip_planes in [Vec::new(), tilted(&volume)] {
            appearance.clip_planes = clip_planes;
            appearance.depth_cue = Some(DepthCue { strength: 0.5 });
            let (rays, reference) = new(&volume, &appearance);
            for view in outside_and_inside(&volume, 40) {
                let frame = rays.render(&view).expect("a frame");
                let truth = reference.render_exact(&view).expect("a frame");
                let depths = frame.depths.as_ref().expect("surfaces have depths");
                let true_depths = truth.depths.as_ref().expect("surfaces have depths");
                let (mut hits, mut outliers) = (0, 0);
                let size = volume.bounds().diagonal();
                for (i, (got, want)) in frame.pixels.iter().zip(&truth.pixels).enumerate() {
                    let errors = (0..4).map(|c| (f64::from(got[c]) - want[c]).abs());
                    let same_depth = depths[i].is_infinite() == true_depths[i].is_infinite()
                        && (depths[i].is_infinite()
                            || (f64::from(depths[i]) - true_depths[i]).abs() <= 1e-4 * size);
                    hits += usize::from(depths[i].is_finite());
                    // 2⁻²⁴ of the mesh's size over the height of the thinnest cells.
                    if errors.fold(0.0, f64::max) > MAX || !same_depth {
                        outliers += 1;
                        assert!(
                            is_explained(&reference, &volume, &appearance, &view, i, *got),
                            "{name}, pixel {i}: {got:?} {}, truth {want:?} {}",
                            depths[i],
                            true_depths[i]
                        );
                    }
                }
                println!("{name}: {hits} hits, {outliers} on outlines");
                assert!(hits > 20, "{name}");
                assert!(outliers * 100 <= hits, "{name}: {outliers} of {hits}");
            }
        }
    }
}

/// A surface in the last cell of a path ends the ray.
#[test]
fn a_surface_in_the_last_cell_of_a_path_hides_what_follows() {
    let whole = stacked_plates(2);
    let Volume::Mesh(mesh) = &whole else {
        panic!("a mesh")
    };
    // Split, every cell is the last of a path, and the first.
    for (what, volume) in [("split", split(mesh)), ("whole", whole)] {
        let mut appearance = surfaces(&volume, ramp(&volume));
        appearance.isosurfaces.truncate(1);
        appearance.isosurfaces[0].value = 0.99;
        let view = fitted(&volume, CameraFit::MinusZ, true, 16);
        let frame = renderer(&volume, &appearance).render(&view);
        let nearest = volume.bounds().min.z - view.camera.position.z;
        let mut hits = 0;
        for depth in frame
            .expect("a frame")
            .depths
            .expect("surfaces have depths")
        {
            if depth.is_finite() {
                hits += 1;
                // In the first plate, by more than the depths' 2⁻²² of the distance.
                let far = f64::from(depth) - nearest;
                assert!(far < 0.001, "{what}: {depth} {nearest}");
            }
        }
        assert!(hits > 20, "{what}: {hits}");
    }
}

/// Rays end where opaque things are, before, in and behind the volume.
#[test]
fn opaque_things_end_rays() {
    let (volume, appearance) = scene("torus", 2000);
    let size = volume.bounds().diagonal();
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            ..surfaces(&volume, appearance.clone())
        };
        let (rays, reference) = new(&volume, &appearance);
        for view in outside_and_inside(&volume, 40) {
            let distance = (view.camera.position - volume.bounds().center()).length();
            let ends: Vec<f64> = (0..40 * 40)
                .map(|i| match i % 7 {
                    0 => f64::INFINITY,
                    1 => 0.0,
                    part => distance + size * (f64::from(part) / 8.0 - 0.5),
                })
                .collect();
            let frame = rays.render_before(&view, &ends).expect("a frame");
            let truth = reference.render_before(&view, &ends).expect("a frame");
            let scale = scale(&truth.pixels);
            let mut off = ImageError::against(&truth.pixels, &frame);
            if model == OpticalModel::Isosurfaces {
                // Surfaces within a rounding of an end.
                let pixels = frame.pixels.iter().zip(&truth.pixels);
                let pixels = pixels.filter(|(got, want)| {
                    (0..4).any(|c| (f64::from(got[c]) - want[c]).abs() > MAX)
                });
                let count = pixels.count();
                assert!(count <= 2, "{count} pixels");
                (off.rmse, off.max) = (0.0, 0.0);
            }
            assert!(
                off.rmse <= RMSE * scale && off.max <= MAX * scale,
                "{}: {off:?}",
                model.name()
            );
        }
        let wrong = rays.render_before(&outside_and_inside(&volume, 40)[0], &[1.0]);
        assert!(wrong.is_err());
    }
}
