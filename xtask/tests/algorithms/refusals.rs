//! Appearances whose pictures f32 cannot hold, given to renderers without a scene: every
//! renderer refuses them, and stays as it was.

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::grid::Samples;
use tetrascope::core::{
    Appearance, Camera, CameraFit, Error, Grid, Knot, OpticalModel, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope::{Algorithm, Settings};
use tetrascope_testing::{kuhn, mesh};
use xtask::testing::{algorithms, context};

fn look(color: f64, extinction: f64, optical_model: OpticalModel) -> Appearance {
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::splat(color),
        extinction,
    };
    let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]);
    Appearance::new(function.expect("valid knots"), optical_model)
}

/// A cube of this side, as a mesh and as a grid.
fn cubes(side: f64) -> [Volume; 2] {
    let mesh = mesh(kuhn(1, DVec3::ZERO, DVec3::splat(side), |_| true), |p| {
        p.x / side
    });
    let samples = Samples::F32(vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    let spacing = DVec3::splat(side);
    let grid = Grid::new([2; 3], DVec3::ZERO, spacing, DMat3::IDENTITY, samples);
    [Volume::Mesh(mesh), Volume::Grid(grid.expect("a grid"))]
}

fn refused<T>(what: &str, result: Result<T, Error>) {
    match result {
        Err(Error::Invalid { .. }) => {}
        Err(error) => panic!("{what}: {error}"),
        Ok(_) => panic!("{what}: not refused"),
    }
}

fn check(algorithm: &Algorithm, setting: &str, volume: &Volume, huge: &Volume) {
    let valid = look(0.5, 1.0, OpticalModel::EmissionAbsorption);
    let view = View {
        camera: Camera::fit(&volume.bounds(), CameraFit::PlusIso, true, 1.0),
        width: 4,
        height: 4,
        background: [0.0; 4],
    };
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    if (algorithm.supports)(volume, &valid, &view, &settings).is_err() {
        return;
    }
    let build =
        |appearance: &Appearance| (algorithm.build)(context(), volume, appearance, &settings);
    let mut renderer = build(&valid).expect("a valid scene");
    let before = renderer.render(&view).expect("a picture");
    let name = format!("{} {setting}", algorithm.name);
    for appearance in [
        look(0.5, 1e39, OpticalModel::EmissionAbsorption),
        look(0.5, 1e39, OpticalModel::Emission),
        // Each fits, and their product does not.
        look(1e30, 1e30, OpticalModel::Emission),
    ] {
        refused(&name, build(&appearance));
        refused(&name, renderer.restyle(&appearance));
    }
    // Depths of 1 in each unit, in a volume that is 1e39 of them wide.
    refused(&name, renderer.reload(huge));
    let after = renderer.render(&view).expect("a picture");
    assert!(before.pixels == after.pixels, "{name}");
}

#[test]
fn pictures_beyond_floats_are_refused() {
    for algorithm in algorithms("pictures_beyond_floats_are_refused") {
        for setting in (algorithm.sweep)(OpticalModel::EmissionAbsorption) {
            for (volume, huge) in cubes(1.0).iter().zip(&cubes(1e39)) {
                check(algorithm, setting, volume, huge);
            }
        }
    }
}
