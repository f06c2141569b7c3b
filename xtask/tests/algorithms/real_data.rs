//! Real meshes, where they are at hand: in the folder that `TETRASCOPE_DATA` names,
//! or in `../shared/data` beside the repository.

use std::path::PathBuf;

use tetrascope::Promise;
use tetrascope::core::OpticalModel;
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope_testing::file;
use xtask::limits::{ROUNDING, limit, outliers};
use xtask::testing::{Failures, algorithms, draw, drawn_by, promised, truth};

/// Pixels per side: the Blunt Fin's thinnest cells are far below a pixel at any size.
const SIDE: u32 = 96;

fn scene(path: PathBuf, field: Option<&str>) -> SceneFile {
    let mut file = SceneFile::new(VolumeSource {
        file: Some(path),
        field: field.map(String::from),
        ..VolumeSource::default()
    });
    (file.image.width, file.image.height) = (Some(SIDE), Some(SIDE));
    file
}

/// Every algorithm with every setting that promises something against the ground truth;
/// `rough` is the RMSE allowed where some cells may be in the wrong order, about twice what
/// was measured. Topological order is held to the same as every other: although these
/// meshes are not convex, its heuristic is right here.
fn compare(test: &str, file: &SceneFile, rough: f64) {
    let mut failures = Failures::default();
    let volume = tetrascope::volumes::load(&file.volume)
        .expect("a valid file")
        .volume;
    for model in OpticalModel::ALL {
        let scene = xtask::compare::resolve(file, model, &volume).expect("a valid scene");
        let expected = truth(&volume, &scene.appearance, &scene.view);
        assert!(
            expected.pixels.iter().any(|p| p[3] > 0.0),
            "{test}: an empty picture"
        );
        // A third of the smallest allowed error: the truth must not decide.
        let bound = expected.stats.error_bound.expect("the truth has a bound");
        assert!(
            bound < ROUNDING.1 / 3.0,
            "{test}: the truth is only known to {bound:.1e}"
        );
        for algorithm in algorithms(test) {
            for setting in (algorithm.sweep)(model) {
                let promise = promised(algorithm, setting);
                if promise == Promise::Open {
                    continue;
                }
                let frame = draw(algorithm, setting, &volume, &scene.appearance, &scene.view);
                let Some(frame) = frame else { continue };
                let name = format!(
                    "{} {setting}: {test}, {} ({})",
                    algorithm.name,
                    model.name(),
                    drawn_by(algorithm)
                );
                let limit = limit(promise, model, frame.stats.order_proven, Some(rough));
                let limit = limit.expect("a rough order has its bound");
                failures.compare_most(&name, &expected, &frame, limit, outliers(model));
            }
        }
    }
    failures.finish();
}

#[test]
fn the_blunt_fin_from_plot3d() {
    let Some(path) = file("the Blunt Fin", "bluntfinxyz.bin") else {
        return;
    };
    compare("the Blunt Fin", &scene(path, Some("density")), 3e-4);
}

// The same mesh was cut into 187 395 tetrahedra, 77 of them without volume, by other means;
// where diagonals differ
// the field between the points does, so only counts and ranges are compared.
#[test]
fn the_blunt_fin_has_the_field_of_its_other_file() {
    let (Some(plot3d), Some(vtu)) = (
        file("two files of one mesh", "bluntfinxyz.bin"),
        file("two files of one mesh", "bluntfin_tets.vtu"),
    ) else {
        return;
    };
    let load = |path| {
        tetrascope::volumes::load(&scene(path, Some("density")).volume)
            .expect("a valid file")
            .volume
    };
    let (a, b) = (load(plot3d), load(vtu));
    assert_eq!(b.cell_count(), 187_395 - 77);
    assert_eq!(a.bounds(), b.bounds());
    assert_eq!(a.scalar_range(), b.scalar_range());
}

#[test]
fn the_super_phoenix() {
    let Some(path) = file("SPX", "spx.vtu") else {
        return;
    };
    compare("SPX", &scene(path, None), 3e-4);
}
