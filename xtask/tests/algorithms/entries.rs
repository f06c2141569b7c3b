//! What an algorithm says about itself, held to what it does.

use tetrascope::core::glam::DVec3;
use tetrascope::core::{CameraFit, OpticalModel, Volume};
use tetrascope::{Algorithm, Values};
use tetrascope_testing::{Place, fitted, grid, kuhn, mesh, ramp, surfaces};
use xtask::testing::{algorithms, draw};

/// Each value of each setting, and with nothing set.
fn pairs(algorithm: &Algorithm) -> Vec<String> {
    let mut pairs = vec![String::new()];
    for setting in algorithm.settings {
        if let Values::Choice(words) = setting.values {
            pairs.extend(words.iter().map(|word| format!("{}={word}", setting.name)));
        }
    }
    pairs
}

/// Draws small volumes with each setting and in each model, from where they are seen and from
/// where they are not: together these frames count all that is listed, and nothing else.
#[test]
fn frames_count_what_entries_list() {
    let cube = kuhn(2, DVec3::ZERO, DVec3::ONE, |_| true);
    let volumes = [
        Volume::Mesh(mesh(cube, |p| p.x + p.y * p.z)),
        Volume::Grid(grid(&Place::unit(4), |p| p.x + p.y * p.z)),
    ];
    for algorithm in algorithms("frames_count_what_entries_list") {
        let mut counted = Vec::new();
        for volume in &volumes {
            let seen = fitted(volume, CameraFit::PlusIso, true, 8);
            let mut unseen = fitted(volume, CameraFit::PlusIso, false, 8);
            let camera = &mut unseen.camera;
            camera.focal_point = 2.0 * camera.position - camera.focal_point;
            let mut count = |setting: &str, model, view| {
                let mut look = surfaces(volume, ramp(volume));
                look.optical_model = model;
                let frame = draw(algorithm, setting, volume, &look, view);
                let counts = frame.into_iter().flat_map(|frame| frame.stats.counts);
                counted.extend(counts.map(|count| count.counter.name));
            };
            for setting in pairs(algorithm) {
                count(&setting, OpticalModel::EmissionAbsorption, &seen);
            }
            for model in OpticalModel::ALL {
                count("", model, &seen);
                count("", model, &unseen);
            }
        }
        for counter in algorithm.counters {
            let name = counter.name;
            assert!(counted.contains(&name), "{}: {name}", algorithm.name);
        }
    }
}
