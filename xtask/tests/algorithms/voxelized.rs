//! Meshes that are drawn by their voxels, against the ground truth, which has the mesh itself.

use tetrascope::core::grid::Lattice;
use tetrascope::core::{
    Appearance, CameraFit, Frame, OpticalModel, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope::datasets::wave;
use tetrascope::gpu::Gpu;
use tetrascope::voxel_hw::{
    Domain, Offsets, Textures, Voxelization, VoxelizationOptions, VoxelizerOptions,
};
use tetrascope_testing::{ImageError, data_set, fitted, gpu, ramp, surfaces, truth};

const SIDE: u32 = 32;

/// Voxels along the longest axis, samples along each of a voxel's, and textures.
fn options(voxels: usize, samples: u32, textures: Textures) -> VoxelizationOptions {
    let defaults = VoxelizationOptions::default();
    VoxelizationOptions {
        voxels,
        textures,
        voxelizer: VoxelizerOptions {
            offsets: Offsets::Regular(samples),
            ..defaults.voxelizer
        },
        ..defaults
    }
}

fn drawn(
    gpu: &Gpu,
    mesh: &TetMesh,
    options: &VoxelizationOptions,
    (look, view): (&Appearance, &View),
) -> Frame {
    let volume = Volume::Mesh(mesh.clone());
    let renderer = Voxelization::new(gpu, &volume, look, options);
    renderer.expect("a mesh").render(view).expect("a frame")
}

fn rmse(mesh: &TetMesh, look: &Appearance, view: &View, frame: &Frame) -> f64 {
    let truth = truth(&Volume::Mesh(mesh.clone()), look);
    let truth = truth.render(view).expect("a frame");
    ImageError::between(&truth, frame).rmse
}

/// The order at which the error falls with the size of voxels, from 12 to 96 of them along the longest
/// axis. Coverage makes the border's light right in sum: where faces lie between voxels, it is spread over
/// the two layers on both sides, so order 1.5 in the RMSE, as pixels at the border become fewer, and one
/// in stacks, whose slabs see no border between their planes. Where pixels jump at the border, it is how
/// many of them are wrong that falls at first order, and the RMSE by its root.
#[test]
fn the_error_falls_with_the_number_of_voxels() {
    let Some(gpu) = gpu("the_error_falls_with_the_number_of_voxels") else {
        return;
    };
    for (name, of_light, of_jumps) in [
        ("sphere", 1.35, 0.4),
        ("torus", 1.0, 0.4),
        ("graded", 1.35, 0.4),
    ] {
        let mesh = data_set(name, Some(5 * 7 * 7 * 7));
        let volume = Volume::Mesh(mesh.clone());
        for model in OpticalModel::ALL {
            let mut look = surfaces(&volume, ramp(&volume));
            look.optical_model = model;
            let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
            for (_, textures) in Textures::ALL {
                if textures == Textures::Stacks && model == OpticalModel::Isosurfaces {
                    continue;
                }
                let errors = [12, 24, 48, 96].map(|voxels| {
                    let options = options(voxels, 2, textures);
                    let frame = drawn(&gpu, &mesh, &options, (&look, &view));
                    rmse(&mesh, &look, &view, &frame)
                });
                let order = (errors[0] / errors[3]).log2() / 3.0;
                let context = format!(
                    "{name} {} {textures:?}: {errors:?}, order {order:.2}",
                    model.name()
                );
                eprintln!("{context}");
                let least = match model {
                    OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => of_jumps,
                    _ if textures == Textures::Stacks => 0.95,
                    _ => of_light,
                };
                assert!(order > least, "{context}");
            }
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
    let mut all = Domain::of(&steps[0]);
    for mesh in &steps[1..] {
        let other = Domain::of(mesh);
        all.bounds.min = all.bounds.min.min(other.bounds.min);
        all.bounds.max = all.bounds.max.max(other.bounds.max);
        let ranges = all.scalar_range.zip(other.scalar_range);
        all.scalar_range = ranges.map(|(a, b)| (a.0.min(b.0), a.1.max(b.1)));
    }
    for textures in [Textures::Volume, Textures::Stacks] {
        let following = options(40, 1, textures);
        let lattice = Lattice::over(&all.bounds, [40; 3]).expect("a box");
        let fixed = VoxelizationOptions {
            lattice: Some(lattice),
            domain: Some(all),
            ..following.clone()
        };
        for options in [fixed, following] {
            let renderer = Voxelization::new(&gpu, &volumes[0], &look, &options);
            let mut renderer = renderer.expect("a mesh");
            let mut frames: Vec<Frame> = Vec::new();
            for (mesh, volume) in steps.iter().zip(&volumes) {
                renderer.reload(volume).expect("it fits");
                let before = gpu.allocations();
                renderer.reload(volume).expect("it fits");
                if options.lattice.is_some() && textures == Textures::Volume {
                    assert_eq!(gpu.allocations(), before, "nothing is made anew");
                }
                let frame = renderer.render(&view).expect("a frame");
                let error = rmse(mesh, &look, &view, &frame);
                // Aliased voxels are half a voxel off at the surface: 8.4e-3 over the picture.
                assert!(error < 0.015, "{error}");
                frames.push(frame);
            }
            // The picture of another step is off more than ten times as far.
            for (i, mesh) in steps.iter().enumerate().skip(2) {
                let stale = rmse(mesh, &look, &view, &frames[0]);
                assert!(stale > 0.08, "{i}: {stale}");
            }
        }
    }
}
