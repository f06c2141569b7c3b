//! Meshes whose samples `slicing` draws where they are: one crate makes the grid on the device, the
//! other draws it, and the ground truth has the mesh itself.

use tetrascope::core::grid::Lattice;
use tetrascope::core::{
    Appearance, CameraFit, Frame, OpticalModel, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope::datasets::wave;
use tetrascope::gpu::Gpu;
use tetrascope::resample::{MeshSlices, MeshSlicesOptions, Passes, Resampler, ResamplerOptions};
use tetrascope::slicing::{Slicing, SlicingOptions};
use tetrascope_testing::{ImageError, data_set, fitted, gpu, ramp, truth};

const SIDE: u32 = 32;

/// Samples of `mesh` inside of its box, so many along each axis.
fn lattice(mesh: &TetMesh, count: usize) -> Lattice {
    Lattice::over(&mesh.bounds(), [count; 3]).expect("a box")
}

fn resampler(gpu: &Gpu, mesh: &TetMesh, lattice: &Lattice) -> Resampler {
    let resampler = Resampler::new(gpu, mesh, lattice, &ResamplerOptions::default());
    let resampler = resampler.expect("it fits");
    resampler.resample().expect("samples");
    resampler
}

fn drawn(gpu: &Gpu, mesh: &TetMesh, count: usize, look: &Appearance, view: &View) -> Frame {
    let resampler = resampler(gpu, mesh, &lattice(mesh, count));
    let options = SlicingOptions::default();
    let slicing = Slicing::from_device(gpu, resampler.grid(), look, &options);
    slicing.expect("a grid").render(view).expect("a frame")
}

fn rmse(mesh: &TetMesh, look: &Appearance, view: &View, frame: &Frame) -> f64 {
    let truth = truth(&Volume::Mesh(mesh.clone()), look);
    let truth = truth.render(view).expect("a frame");
    ImageError::between(&truth, frame).rmse
}

/// The field is continuous and its gradient is not, the box is filled: the error of samples and
/// that of slices, whose distance follows the samples', both fall by the square of it.
#[test]
fn the_error_falls_with_the_number_of_samples() {
    let Some(gpu) = gpu("the_error_falls_with_the_number_of_samples") else {
        return;
    };
    let mesh = data_set("sphere", Some(5 * 7 * 7 * 7));
    let volume = Volume::Mesh(mesh.clone());
    for model in [
        OpticalModel::EmissionAbsorption,
        OpticalModel::Emission,
        OpticalModel::Absorption,
    ] {
        let mut look = ramp(&volume);
        look.optical_model = model;
        let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
        let errors = [12, 24, 48].map(|count| {
            let frame = drawn(&gpu, &mesh, count, &look, &view);
            rmse(&mesh, &look, &view, &frame)
        });
        eprintln!("{}: {errors:?}", model.name());
        // A sixteenth at second order, with room for what is left of coarser terms.
        assert!(errors[2] < errors[0] / 12.0, "{}: {errors:?}", model.name());
    }
}

/// In each step other points, other cells and another range of scalars, in one resampler and one
/// renderer.
#[test]
fn a_mesh_that_is_made_anew_is_drawn_anew() {
    let Some(gpu) = gpu("a_mesh_that_is_made_anew_is_drawn_anew") else {
        return;
    };
    let steps = [0, 1, 15, 30].map(|step| wave(6 * 6 * 6 * 6, step).expect("a valid size"));
    let volume = Volume::Mesh(steps[0].clone());
    let look = ramp(&volume);
    let view = fitted(&volume, CameraFit::PlusIso, true, SIDE);
    // The surface stays within 0.3 of the mean.
    let mut bounds = steps[0].bounds();
    bounds.max.z = 0.35;
    let lattice = Lattice::over(&bounds, [40; 3]).expect("a box");
    let mut resampler = resampler(&gpu, &steps[0], &lattice);
    let options = SlicingOptions::default();
    let slicing = Slicing::from_device(&gpu, resampler.grid(), &look, &options);
    let mut slicing = slicing.expect("a grid");
    let mut frames: Vec<Frame> = Vec::new();
    for mesh in &steps {
        resampler.reload(mesh).expect("it fits");
        resampler.resample().expect("samples");
        slicing.reload_device(resampler.grid()).expect("a grid");
        let frame = slicing.render(&view).expect("a frame");
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
