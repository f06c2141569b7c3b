//! Entries of algorithms, held to what these do.

use tetrascope::core::clusters::MeshClusters;
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

/// Draws small volumes in each model and with each setting, from where they are seen and from
/// where they are not, until these frames have counted all that is listed.
#[test]
fn frames_count_what_entries_list() {
    let cube = kuhn(2, DVec3::ZERO, DVec3::ONE, |_| true);
    let cells = mesh(cube, |p| p.x + p.y * p.z);
    let clusters = MeshClusters::of(&cells, 8).expect("parts of a mesh");
    let volumes = [
        Volume::Mesh(cells),
        Volume::Clusters(clusters),
        Volume::Grid(grid(&Place::unit(4), |p| p.x + p.y * p.z)),
    ];
    for algorithm in algorithms("frames_count_what_entries_list") {
        let mut missing: Vec<&str> = algorithm.counters.iter().map(|c| c.name).collect();
        for (volume, setting, model, is_seen) in frames(algorithm, &volumes) {
            if missing.is_empty() {
                break;
            }
            let mut view = fitted(volume, CameraFit::PlusIso, is_seen, 8);
            if !is_seen {
                let camera = &mut view.camera;
                camera.focal_point = 2.0 * camera.position - camera.focal_point;
            }
            let mut look = surfaces(volume, ramp(volume));
            look.optical_model = model;
            let frame = draw(algorithm, &setting, volume, &look, &view);
            let counts = frame.into_iter().flat_map(|frame| frame.stats.counts);
            let counted: Vec<&str> = counts.map(|count| count.counter.name).collect();
            missing.retain(|name| !counted.contains(name));
        }
        assert!(missing.is_empty(), "{}: {missing:?}", algorithm.name);
    }
}

/// Volumes, settings, models and whether the volume is in view: models first, as most counters are theirs.
fn frames<'a>(
    algorithm: &Algorithm,
    volumes: &'a [Volume],
) -> Vec<(&'a Volume, String, OpticalModel, bool)> {
    let mut frames = Vec::new();
    for is_seen in [true, false] {
        for volume in volumes {
            let models = OpticalModel::ALL.into_iter();
            frames.extend(models.map(|model| (volume, String::new(), model, is_seen)));
        }
    }
    for volume in volumes {
        let settings = pairs(algorithm).into_iter();
        let model = OpticalModel::EmissionAbsorption;
        frames.extend(settings.map(|setting| (volume, setting, model, true)));
    }
    frames
}
