//! Clip planes, depth cue and isosurfaces against the ground truth.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, CameraFit, ClipPlane, DepthCue, Knot, OpticalModel, Scalars, TransferFunction,
    Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::counters::CELL_VISITS;
use tetrascope_raycast_peel::{RaycastOptions, RaycastPeel};
use tetrascope_reference::Reference;
use tetrascope_testing::{
    self as testing, ImageError, fitted, is_explained, outside_and_inside, ramp, scale, split,
    stacked_plates, surfaces, tilted, truth,
};

use crate::common::{renderer, scene};

/// The error that `reference.rs` allows and why; cutting adds one rounding per end.
const RMSE: f64 = 2e-6;
const MAX: f64 = 1e-4;

fn new(gpu: &Gpu, volume: &Volume, appearance: &Appearance) -> (RaycastPeel, Reference) {
    let rays = renderer(gpu, volume, appearance, &RaycastOptions::default());
    (rays, truth(volume, appearance))
}

fn check(gpu: &Gpu, name: &str, volume: &Volume, appearance: &Appearance) {
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance {
            optical_model: model,
            ..appearance.clone()
        };
        let (rays, truth) = new(gpu, volume, &appearance);
        for view in outside_and_inside(volume, 40) {
            let frame = rays.render(&view).expect("a frame");
            let truth = truth.render_exact(&view).expect("a frame");
            let scale = scale(&truth.pixels);
            let ImageError { rmse, max, .. } = ImageError::against(&truth.pixels, &frame);
            println!("{name}, {}: rmse {rmse:.1e}, max {max:.1e}", model.name());
            assert!(
                rmse <= RMSE * scale && max <= MAX * scale,
                "{name}, {}, {:?}: {rmse:e} {max:e}",
                model.name(),
                view.camera.projection
            );
        }
    }
}

#[test]
fn clip_planes_and_cues_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("clip_planes_and_cues_agree_with_the_reference") else {
        return;
    };
    for (name, cells) in [("sphere", 3000), ("torus", 2000), ("graded", 2000)] {
        let (volume, mut appearance) = scene(name, cells);
        appearance.clip_planes = tilted(&volume);
        check(&gpu, &format!("{name}, clipped"), &volume, &appearance);
        appearance.depth_cue = Some(DepthCue { strength: 0.9 });
        check(&gpu, &format!("{name}, both"), &volume, &appearance);
    }
}

// One cell with a deep transfer function, in which the color times the cue is far from linear.
#[test]
fn a_cue_bends_colors_inside_a_cell() {
    let Some(gpu) = testing::gpu("a_cue_bends_colors_inside_a_cell") else {
        return;
    };
    let (volume, mut appearance) = scene("sphere", 5);
    // Its own field is the same at all corners.
    let Volume::Mesh(mesh) = volume else {
        panic!("a mesh")
    };
    let values = mesh.points().iter().map(|p| p.x + 0.5 * p.y - 0.2 * p.z);
    let scalars = Scalars {
        values: values.collect(),
        ..mesh.scalars().clone()
    };
    let volume = Volume::Mesh(mesh.with_scalars(scalars).expect("as many"));
    let (low, high) = volume.scalar_range().expect("a field");
    let knot = |scalar, color: [f64; 3], extinction| Knot {
        scalar,
        color: color.into(),
        extinction,
    };
    let ramp = vec![
        knot(low, [1.0, 0.0, 0.2], 0.5),
        knot(high, [0.0, 1.0, 0.4], 6.0),
    ];
    appearance.transfer_function = TransferFunction::new(ramp).expect("valid knots");
    appearance.depth_cue = Some(DepthCue { strength: 1.0 });
    check(&gpu, "five cells", &volume, &appearance);
}

#[test]
fn what_planes_cut_away_is_not_visited() {
    let Some(gpu) = testing::gpu("what_planes_cut_away_is_not_visited") else {
        return;
    };
    let (volume, mut appearance) = scene("sphere", 3000);
    let view = outside_and_inside(&volume, 40)[0];
    let (rays, _) = new(&gpu, &volume, &appearance);
    let whole = rays.render(&view).expect("a frame").stats.get(CELL_VISITS);
    // All but the part near the camera.
    appearance.clip_planes = vec![ClipPlane {
        point: volume.bounds().center() + 0.5 * DVec3::ONE.unit(),
        normal: DVec3::ONE,
    }];
    let (rays, _) = new(&gpu, &volume, &appearance);
    let near = rays.render(&view).expect("a frame").stats.get(CELL_VISITS);
    assert!(
        2 * near.expect("counted") < whole.expect("counted"),
        "{near:?} {whole:?}"
    );
}

#[test]
fn isosurfaces_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("isosurfaces_agree_with_the_reference") else {
        return;
    };
    for (name, cells) in [
        ("sphere", 3000),
        ("orbital", 3000),
        ("torus", 2000),
        ("graded", 2000),
    ] {
        let (volume, _) = scene(name, cells);
        let mut appearance = surfaces(&volume, ramp(&volume));
        for clip_planes in [Vec::new(), tilted(&volume)] {
            appearance.clip_planes = clip_planes;
            let (rays, reference) = new(&gpu, &volume, &appearance);
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
                    if errors.fold(0.0, f64::max) > 1e-3 || !same_depth {
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

/// A ray that meets a surface in the last cell of a path went on to the next path, and showed
/// the surface there.
#[test]
fn a_surface_in_the_last_cell_of_a_path_hides_what_follows() {
    let Some(gpu) = testing::gpu("a_surface_in_the_last_cell_of_a_path_hides_what_follows") else {
        return;
    };
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
        let (rays, _) = new(&gpu, &volume, &appearance);
        let depths = rays.render(&view).expect("a frame").depths;
        let nearest = volume.bounds().min.z - view.camera.position.z;
        let mut hits = 0;
        for depth in depths.expect("surfaces have depths") {
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

#[test]
fn surfaces_and_volume_follow_each_other() {
    let Some(gpu) = testing::gpu("surfaces_and_volume_follow_each_other") else {
        return;
    };
    let (volume, volumetric) = scene("sphere", 1000);
    let surfaces = surfaces(&volume, volumetric.clone());
    let view = outside_and_inside(&volume, 40)[0];
    let (mut rays, _) = new(&gpu, &volume, &volumetric);
    let before = rays.render(&view).expect("a frame");
    rays.restyle(&surfaces).expect("surfaces");
    let (fresh, _) = new(&gpu, &volume, &surfaces);
    let (again, first) = (rays.render(&view), fresh.render(&view));
    let (again, first) = (again.expect("a frame"), first.expect("a frame"));
    // Scalars mapped for the transfer function round otherwise: outlines may move.
    let differs = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).any(|c| (a[c] - b[c]).abs() > 1e-3);
    let different = again
        .pixels
        .iter()
        .zip(&first.pixels)
        .filter(|p| differs(*p));
    assert!(again.depths.is_some() && different.count() <= 4);
    rays.restyle(&volumetric).expect("a volume");
    let after = rays.render(&view).expect("a frame");
    assert!(after.pixels == before.pixels && after.depths.is_none());
}
