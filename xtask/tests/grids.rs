//! A regular grid through the comparison: slicing against the exact picture.

use tetrascope::core::SceneFile;
use tetrascope::core::scene::VolumeSource;
use xtask::compare;

/// 17³ samples of a ball, as a raw file of f32 with a scene beside it.
fn scene(folder: &std::path::Path) -> std::path::PathBuf {
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
        number: Some(tetrascope::core::scene::RawNumber::F32),
        ..VolumeSource::default()
    });
    (file.image.width, file.image.height) = (Some(48), Some(48));
    file.appearance.unit_distance = Some(4.0);
    let path = folder.join("ball.json");
    let text = serde_json::to_string(&file).expect("a scene is JSON");
    std::fs::write(&path, text).expect("written");
    path
}

// Smooth and at two slices a voxel: under 1e-3 (see slicing's tests of convergence), and
// falling from setting to setting of the sweep.
#[test]
fn compare_lists_slicing_against_the_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = compare::Options {
        scenes: vec![scene(folder.path()).to_string_lossy().into_owned()],
        field: None,
        algorithms: vec!["slicing".into(), "projection".into()],
        models: Vec::new(),
        size: None,
        orthographic: false,
        repeat: 1,
        out: Some(folder.path().join("out")),
        json: false,
    };
    assert!(compare::run(&options).expect("compared"));
    let text = std::fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let rows = report["scenes"][0]["models"][0]["rows"]
        .as_array()
        .expect("rows");
    let of = |name: &'static str| rows.iter().filter(move |row| row["algorithm"] == name);
    assert!(
        of("reference").any(|row| row["outcome"].get("drawn").is_some()),
        "{rows:#?}"
    );
    // It draws meshes, and says so.
    assert!(
        of("projection").all(|row| row["outcome"].get("skipped").is_some()),
        "{rows:#?}"
    );
    let errors: Vec<f64> = of("slicing")
        .filter_map(|row| row["outcome"]["drawn"]["error"]["rmse"].as_f64())
        .collect();
    if errors.is_empty() {
        println!("skipped: no graphics adapter");
        return;
    }
    assert!(errors[1] <= 1e-3, "{errors:?}");
    assert!(errors.windows(2).take(2).all(|e| e[1] < e[0]), "{errors:?}");
}
