//! Tests of the files that `voxelize` writes, and of the words of `machine`.

use super::resampling::{arrays, cube};

#[test]
fn voxels_are_written_with_their_coverage() {
    let folder = cube();
    let run = folder.run("voxelize cube.vtk --dims 4 --samples 2 --json -o voxels.vti");
    let report = run.succeeded().json();
    assert_eq!(report["dims"], serde_json::json!([4, 4, 4]));
    assert_eq!(report["cells"], 5);
    // Each of eight samples of each of 64 voxels, once.
    assert_eq!(report["writes"], 512);
    assert_eq!(report["overlaps"], 0);
    assert_eq!(folder.files(), ["cube.vtk", "voxels.vti"]);
    let (dims, arrays) = arrays(&folder, "voxels.vti");
    assert_eq!(dims, [4; 3]);
    let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["plane", "coverage"]);
    let at = |i: usize| 0.25 + 0.5 * i as f64;
    for (i, scalar) in arrays[0].1.iter().enumerate() {
        let [x, y, z] = [i % 4, i / 4 % 4, i / 16].map(at);
        let off = (f64::from(*scalar) - (x + 2.0 * y - z)).abs();
        // Scalars of vertices are rounded to 2^-24 of a range of 8.
        assert!(off < 2e-6, "{i}: {scalar}");
    }
    assert!(arrays[1].1.iter().all(|share| *share == 1.0));
}

#[test]
fn a_machine_says_what_voxels_take() {
    let folder = cube();
    let seen = |options: &str| {
        let run = folder.run(&format!("machine cube.vtk --dims 4 --json {options}"));
        run.succeeded().json()
    };
    let (few, many) = (seen("--generators 5"), seen("--generators 20"));
    for report in [&few, &many] {
        assert_eq!(report["passes"], 5);
        assert_eq!(report["voxels"], 64);
        assert_eq!(report["texels"], 64);
    }
    let busiest = |report: &serde_json::Value| report["cycles"]["scan_conversion"]["max"].as_u64();
    assert!(busiest(&few) > busiest(&many));
    let fast = seen("--config clock_mhz=100,geometry_engines=24");
    let rate = |report: &serde_json::Value| report["volumes_per_second"][1].as_f64();
    assert!(rate(&fast) > rate(&many));
    let readback = seen("--readback");
    assert_eq!(readback["bytes"]["merge_host"], 2 * 64 * 4);
    let moved = seen("--sensitivity");
    let names = moved["sensitivity"].as_array().map(Vec::len);
    assert!(names > Some(10), "{moved}");
    let run = folder.run("machine cube.vtk --dims 4");
    assert!(run.succeeded().stdout.contains("volumes per second"));
}

#[test]
fn what_cannot_be_voxelized_is_refused() {
    let folder = cube();
    for (line, code, words) in [
        ("voxelize cube.vtk --dims 0 -q", 3, "1 to 1024 voxels"),
        (
            "voxelize cube.vtk --dims 4 --samples 99 -q",
            3,
            "samples per voxel",
        ),
        (
            "machine cube.vtk --generators 0 -q",
            2,
            "fragment generators",
        ),
        (
            "machine cube.vtk --config clock_mzh=100 -q",
            2,
            "no number of a machine 'clock_mzh'; valid: clock_mhz",
        ),
        (
            "voxelize cube.vtk --dims 4 -o voxels.png -q",
            2,
            "valid: vti",
        ),
    ] {
        let run = folder.run(line);
        let (error, help) = run.failed(code);
        assert!(
            format!("{error} {help:?}").contains(words),
            "{line}: {error}"
        );
    }
    assert_eq!(folder.files(), ["cube.vtk"]);
}
