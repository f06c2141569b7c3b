//! Clip planes and depth cue against the ground truth, in every optical model.

use tetrascope_core::{
    Appearance, DepthCue, Error, Isosurface, OpticalModel, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_projection::{CellProjection, ExitSearch, Integration, Order, ProjectionOptions};
use tetrascope_testing::{self as testing, outside_and_inside, tilted};

use crate::common::scene;

/// A segment in f32 errs by 6e-7 of its opacity, and a sum of some hundred by as many
/// roundings; where a ray grazes an edge or a plane, lengths err by 2⁻²⁴ over the sine
/// of its angle.
const RMSE: f64 = 2e-6;
const MAX: f64 = 1e-4;

fn dressed(name: &str, cells: u64) -> (Volume, Appearance) {
    let (volume, transfer_function) = scene(name, cells);
    let model = OpticalModel::EmissionAbsorption;
    (volume, Appearance::new(transfer_function, model))
}

/// Pixels that are off by more than [`MAX`], and the RMSE of the others.
fn errors(gpu: &Gpu, volume: &Volume, look: &Appearance, order: Order) -> Vec<(usize, f64)> {
    let options = ProjectionOptions {
        order,
        ..ProjectionOptions::default()
    };
    let renderer = CellProjection::new(gpu, volume, look, &options).expect("it draws all");
    let truth = testing::truth(volume, look);
    let of_view = |view: View| {
        let frame = renderer.render(&view).expect("a frame");
        let truth = truth.render_exact(&view).expect("a frame");
        let brightest = truth.pixels.iter().flatten();
        let scale = brightest.fold(1.0, |a: f64, b| a.max(*b));
        let (mut outliers, mut sum) = (0, 0.0);
        for (got, want) in frame.pixels.iter().zip(&truth.pixels) {
            let errors = (0..4).map(|c| (f64::from(got[c]) - want[c]).abs() / scale);
            let error = errors.fold(0.0, f64::max);
            if error > MAX {
                outliers += 1;
            } else {
                sum += error * error;
            }
        }
        (outliers, (sum / truth.pixels.len() as f64).sqrt())
    };
    outside_and_inside(volume, 32).map(of_view).to_vec()
}

#[test]
fn clip_planes_and_cues_agree_with_the_reference() {
    let Some(gpu) = testing::gpu("clip_planes_and_cues_agree_with_the_reference") else {
        return;
    };
    // By MPVO where cells are convex together, and sorted in each pixel where they are not.
    for (name, cells, order) in [
        ("sphere", 2000, Order::Mpvo),
        ("torus", 1500, Order::PerPixel),
    ] {
        let (volume, appearance) = dressed(name, cells);
        for model in OpticalModel::VOLUMETRIC {
            for cued in [false, true] {
                let look = Appearance {
                    optical_model: model,
                    clip_planes: tilted(&volume),
                    depth_cue: cued.then_some(DepthCue { strength: 0.9 }),
                    ..appearance.clone()
                };
                for (outliers, rmse) in errors(&gpu, &volume, &look, order) {
                    let what = format!("{name}, {}, cued: {cued}", model.name());
                    assert!(outliers == 0 && rmse <= RMSE, "{what}: {outliers} {rmse:e}");
                }
            }
        }
    }
}

// Rays along a surface's outline may see it or not: f32 moves them by some 1e-4 pixels.
#[test]
fn surfaces_are_cut_and_cued() {
    let Some(gpu) = testing::gpu("surfaces_are_cut_and_cued") else {
        return;
    };
    let (volume, appearance) = dressed("sphere", 2000);
    let surface = |value, color: [f64; 3]| Isosurface {
        value,
        color: color.into(),
    };
    let look = Appearance {
        optical_model: OpticalModel::Isosurfaces,
        isosurfaces: vec![
            surface(0.717, [1.0, 0.3, 0.1]),
            surface(0.4, [0.2, 0.5, 1.0]),
        ],
        clip_planes: tilted(&volume),
        depth_cue: Some(DepthCue { strength: 0.9 }),
        ..appearance
    };
    for (outliers, rmse) in errors(&gpu, &volume, &look, Order::Unsorted) {
        assert!(outliers <= 1 && rmse <= MAX, "{outliers} {rmse:e}");
    }
}

#[test]
fn modes_that_cannot_say_why() {
    let Some(gpu) = testing::gpu("modes_that_cannot_say_why") else {
        return;
    };
    let (volume, mut look) = dressed("sphere", 5);
    let refused = |look: &Appearance, options: &ProjectionOptions| {
        let error = CellProjection::new(&gpu, &volume, look, options).err();
        matches!(error, Some(Error::Unsupported { .. }))
    };
    let per_vertex = ProjectionOptions {
        exit_search: ExitSearch::PerVertex,
        ..ProjectionOptions::default()
    };
    let table = ProjectionOptions {
        integration: Integration::Table3d { n: 8 },
        ..ProjectionOptions::default()
    };
    look.clip_planes = tilted(&volume);
    assert!(refused(&look, &per_vertex) && !refused(&look, &table));
    look.clip_planes.clear();
    look.depth_cue = Some(DepthCue { strength: 0.5 });
    assert!(refused(&look, &per_vertex) && refused(&look, &table));
}
