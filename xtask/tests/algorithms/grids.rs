//! A regular grid through the comparison: slicing against the exact picture.

use tetrascope::core::glam::DVec3;
use tetrascope::core::{Bounds, Camera, CameraFit};
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope::{projection, slicing, truth};
use xtask::compare;

/// 17³ samples of a ball, as a raw file of f32 with a scene beside it.
fn scene(folder: &std::path::Path, depth_cue: Option<f64>) -> std::path::PathBuf {
    let n = 17;
    let mut bytes = Vec::new();
    for i in 0..n * n * n {
        let [x, y, z] = [i % n, i / n % n, i / n / n].map(|c| c as f32 / (n - 1) as f32 - 0.5);
        let value = (-(x * x + y * y + z * z) / 0.08).exp();
        bytes.extend(value.to_le_bytes());
    }
    std::fs::write(folder.join("ball.raw"), bytes).expect("written");
    let mut file = SceneFile::new(VolumeSource {
        file: Some("ball.raw".into()),
        dims: Some([n; 3]),
        number: Some(tetrascope::core::grid::RawNumber::F32),
        ..VolumeSource::default()
    });
    (file.image.width, file.image.height) = (Some(48), Some(48));
    // Some background is in the picture, whatever the default.
    let bounds = Bounds {
        min: DVec3::ZERO,
        max: DVec3::splat((n - 1) as f64),
    };
    let camera = Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0);
    file.camera.position = Some(camera.position);
    file.camera.focal_point = Some(camera.focal_point);
    file.camera.view_up = Some(camera.view_up);
    file.appearance.unit_distance = Some(4.0);
    file.appearance.depth_cue = depth_cue;
    let path = folder.join("ball.json");
    let text = serde_json::to_string(&file).expect("a scene is JSON");
    std::fs::write(&path, text).expect("written");
    path
}

/// The rows of a comparison of the ball.
fn compared(algorithms: &[&str], model: &str, depth_cue: Option<f64>) -> Vec<serde_json::Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let options = compare::Options {
        scenes: vec![
            scene(folder.path(), depth_cue)
                .to_string_lossy()
                .into_owned(),
        ],
        field: None,
        algorithms: algorithms.iter().map(|a| a.to_string()).collect(),
        models: vec![model.into()],
        size: None,
        orthographic: false,
        repeat: 1,
        out: Some(folder.path().join("out")),
        check: false,
        error: None,
        budget: None,
        peer: None,
        scaling: false,
        memory: false,
        json: false,
    };
    assert!(compare::run(&options).expect("compared"));
    let text = std::fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let rows = &report["scenes"][0]["models"][0]["rows"];
    rows.as_array().expect("rows").clone()
}

/// Errors of slicing, setting by setting.
fn errors(rows: &[serde_json::Value]) -> Vec<f64> {
    let of_slicing = rows.iter().filter(|row| row["algorithm"] == slicing::NAME);
    of_slicing
        .filter_map(|row| row["outcome"]["drawn"]["error"]["rmse"].as_f64())
        .collect()
}

// Smooth and at two slices per voxel: under 1e-3 (see slicing's tests of convergence), and
// falling from setting to setting of the sweep.
#[test]
fn compare_lists_slicing_against_the_reference() {
    let rows = compared(
        &[slicing::NAME, projection::NAME],
        "emission-absorption",
        None,
    );
    let of = |name: &'static str| rows.iter().filter(move |row| row["algorithm"] == name);
    assert!(
        of(truth().expect("compiled in").name).any(|row| row["outcome"].get("drawn").is_some()),
        "{rows:#?}"
    );
    // It draws meshes, and says so.
    assert!(
        of(projection::NAME).all(|row| row["outcome"].get("skipped").is_some()),
        "{rows:#?}"
    );
    let errors = errors(&rows);
    if errors.is_empty() {
        println!("skipped: no graphics adapter");
        return;
    }
    assert!(errors[1] <= 1e-3, "{errors:?}");
    assert!(errors.windows(2).take(2).all(|e| e[1] < e[0]), "{errors:?}");
}

// In cells, at any distance of slices, a surface is where it is: what is left are pixels on
// its outline, of which none of 48² may be wrong by more than f32 decides, 2/48 for one. With
// the published gradient or straight lines between slices the error is another.
#[test]
fn compare_covers_isosurfaces_of_grids() {
    let rows = compared(&[slicing::NAME], "isosurfaces", Some(0.5));
    let errors = errors(&rows);
    if errors.is_empty() {
        println!("skipped: no graphics adapter");
        return;
    }
    let [
        cells,
        cells_of_1,
        _,
        line_of_1,
        line_of_2,
        line_of_8,
        central,
    ] = errors[..]
    else {
        panic!("{errors:?}");
    };
    assert!(cells < 1e-5 && cells_of_1 < 1e-5, "{errors:?}");
    assert!(
        line_of_1 > line_of_2 && line_of_2 > line_of_8 && line_of_8 > cells,
        "{errors:?}"
    );
    assert!(central > 1e-3, "{errors:?}");
}

// The bars without a cue hold with one.
#[test]
fn compare_covers_the_depth_cue_on_grids() {
    for model in ["emission-absorption", "emission"] {
        let rows = compared(&[slicing::NAME], model, Some(0.8));
        let errors = errors(&rows);
        if errors.is_empty() {
            println!("skipped: no graphics adapter");
            return;
        }
        assert!(errors[1] <= 1e-3, "{model}: {errors:?}");
        let pairs = errors.windows(2).take(2);
        assert!(
            pairs.into_iter().all(|e| e[1] < e[0]),
            "{model}: {errors:?}"
        );
    }
}
