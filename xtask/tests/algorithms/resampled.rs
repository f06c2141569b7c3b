//! Meshes that are drawn by their samples, against the ground truth, which has the mesh itself.

use tetrascope::core::grid::Lattice;
use tetrascope::core::{
    Appearance, CameraFit, Frame, OpticalModel, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope::datasets::wave;
use tetrascope::gpu::Gpu;
use tetrascope::resample::{
    Domain, MeshSlices, MeshSlicesOptions, Passes, Resampler, ResamplerOptions, Resampling,
    ResamplingOptions,
};
use tetrascope::slicing::{Slicing, SlicingOptions};
use tetrascope_testing::{ImageError, data_set, fitted, gpu, ramp, surfaces, truth};

const SIDE: u32 = 32;

fn drawn(gpu: &Gpu, mesh: &TetMesh, samples: usize, look: &Appearance, view: &View) -> Frame {
    let options = ResamplingOptions {
        samples,
        ..Default::default()
    };
    let volume = Volume::Mesh(mesh.clone());
    let renderer = Resampling::new(gpu, &volume, look, &options);
    renderer.expect("a mesh").render(view).expect("a frame")
}

fn rmse(mesh: &TetMesh, look: &Appearance, view: &View, frame: &Frame) -> f64 {
    let truth = truth(&Volume::Mesh(mesh.clone()), look);
    let truth = truth.render(view).expect("a frame");
    ImageError::between(&truth, frame).rmse
}

/// The order at which the error falls with the distance of samples, from 12 to 96 of them. Where the
/// mesh fills its box and the field bends at the faces of cells alone, it is the second. Elsewhere
/// the border is off by up to a sample, and light by as much. Where pixels jump there, it is how
/// many of them are wrong that falls at first order, and the RMSE by its root.
#[test]
fn the_error_falls_with_the_number_of_samples() {
    let Some(gpu) = gpu("the_error_falls_with_the_number_of_samples") else {
        return;
    };
    for (name, of_light, of_jumps) in [
        ("sphere", 1.9, 1.0),
        ("torus", 1.0, 0.4),
        ("graded", 1.0, 0.4),
    ] {
        let mesh = data_set(name, Some(5 * 7 * 7 * 7));
        let volume = Volume::Mesh(mesh.clone());
        for model in OpticalModel::ALL {
            let mut look = surfaces(&volume, ramp(&volume));
            look.optical_model = model;
            let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
            let errors = [12, 24, 48, 96].map(|samples| {
                let frame = drawn(&gpu, &mesh, samples, &look, &view);
                rmse(&mesh, &look, &view, &frame)
            });
            let order = (errors[0] / errors[3]).log2() / 3.0;
            let context = format!("{name} {}: {errors:?}, order {order:.2}", model.name());
            eprintln!("{context}");
            let least = match model {
                OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => of_jumps,
                _ => of_light,
            };
            assert!(order > least, "{context}");
        }
    }
}

/// In each step other points, other cells and another range of scalars, in one renderer: over a
/// lattice of its own, with one domain for all, which makes nothing anew, and over the mesh's box.
#[test]
fn a_mesh_that_is_made_anew_is_drawn_anew() {
    let Some(gpu) = gpu("a_mesh_that_is_made_anew_is_drawn_anew") else {
        return;
    };
    let steps = [0, 1, 15, 30].map(|step| wave(6 * 6 * 6 * 6, step).expect("a valid size"));
    let volumes = steps.clone().map(Volume::Mesh);
    let look = ramp(&volumes[0]);
    let view = fitted(&volumes[0], CameraFit::PlusIso, true, SIDE);
    let mut bounds = steps[0].bounds();
    for mesh in &steps[1..] {
        let other = mesh.bounds();
        bounds.min = bounds.min.min(other.min);
        bounds.max = bounds.max.max(other.max);
    }
    let ranges = volumes.iter().map(|v| v.scalar_range().expect("scalars"));
    let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let fixed = ResamplingOptions {
        lattice: Some(Lattice::over(&bounds, [40; 3]).expect("a box")),
        domain: Some(Domain {
            bounds,
            scalar_range: range,
        }),
        ..Default::default()
    };
    let following = ResamplingOptions {
        samples: 40,
        ..Default::default()
    };
    for options in [fixed, following] {
        let renderer = Resampling::new(&gpu, &volumes[0], &look, &options);
        let mut renderer = renderer.expect("a mesh");
        let mut frames: Vec<Frame> = Vec::new();
        for (mesh, volume) in steps.iter().zip(&volumes) {
            renderer.reload(volume).expect("it fits");
            let before = gpu.allocations();
            renderer.reload(volume).expect("it fits");
            if options.lattice.is_some() {
                assert_eq!(gpu.allocations(), before, "nothing is made anew");
            }
            let frame = renderer.render(&view).expect("a frame");
            let error = rmse(mesh, &look, &view, &frame);
            // Samples miss up to half a voxel at the surface: 4.4e-3 over the picture.
            assert!(error < 0.01, "{error}");
            frames.push(frame);
        }
        // The picture of another step is off some thirty times as far: 0.11 and 0.13.
        for (i, mesh) in steps.iter().enumerate().skip(2) {
            let stale = rmse(mesh, &look, &view, &frames[0]);
            assert!(stale > 0.08, "{i}: {stale}");
        }
    }
}

/// Samples that are drawn, and pictures without any.
#[test]
fn slices_of_a_mesh_that_is_made_anew_are_drawn_anew() {
    let Some(gpu) = gpu("slices_of_a_mesh_that_is_made_anew_are_drawn_anew") else {
        return;
    };
    let steps = [0, 1, 15].map(|step| wave(6 * 6 * 6 * 6, step).expect("a valid size"));
    let volumes = steps.clone().map(Volume::Mesh);
    let look = ramp(&volumes[0]);
    let view = fitted(&volumes[0], CameraFit::PlusIso, true, SIDE);
    let mut bounds = steps[0].bounds();
    bounds.max.z = 0.35;
    let lattice = Lattice::over(&bounds, [40; 3]).expect("a box");
    let [mut two, mut one] = [Passes::Two, Passes::One].map(|passes| {
        let options = ResamplerOptions {
            passes,
            ..ResamplerOptions::default()
        };
        Resampler::new(&gpu, &steps[0], &lattice, &options).expect("it fits")
    });
    let options = MeshSlicesOptions::default();
    let mut slices = MeshSlices::new(&gpu, &volumes[0], &look, &options).expect("it fits");
    let slicing = SlicingOptions::default();
    for (mesh, volume) in steps.iter().zip(&volumes) {
        let [two, one] = [&mut two, &mut one].map(|resampler| {
            resampler.reload(mesh).expect("it fits");
            resampler.resample().expect("samples");
            let slicing = Slicing::from_device(&gpu, resampler.grid(), &look, &slicing);
            slicing.expect("a grid").render(&view).expect("a frame")
        });
        let errors = [
            rmse(mesh, &look, &view, &one),
            ImageError::between(&one, &two).rmse,
        ];
        eprintln!("{errors:?}");
        // As where samples are computed; two passes round twice.
        assert!(errors[0] < 0.01 && errors[1] < 1e-6, "{errors:?}");
        slices.reload(volume).expect("it fits");
        let frame = slices.render(&view).expect("a frame");
        let error = rmse(mesh, &look, &view, &frame);
        eprintln!("{error} without samples");
        assert!(error < 0.01, "{error}");
    }
}
