//! Meshes in clusters: `pack`, and what is done with its files.

use serde_json::Value;

use super::program::Folder;

fn json(folder: &Folder, line: &str) -> Value {
    let run = folder.run(&format!("{line} --json"));
    assert_eq!(run.code, 0, "{line}: {}", run.stderr);
    serde_json::from_str(&run.stdout).expect("JSON")
}

#[test]
fn a_packed_mesh_is_described_and_drawn() {
    let folder = Folder::new();
    // Cells that are told one by one, and a mesh in memory.
    for (name, cells) in [("sphere", 5 * 12 * 12 * 12), ("heat-sink", 3000)] {
        let packed = json(
            &folder,
            &format!("pack {name} --cells {cells} --cluster-cells 200"),
        );
        assert_eq!(packed["output"], format!("{name}.tsc"));
        let info = json(&folder, &format!("info {name}.tsc"));
        for key in ["tetrahedra", "clusters", "points"] {
            assert_eq!(info[key], packed[key], "{key}");
        }
        let of_mesh = json(&folder, &format!("info {name} --cells {cells}"));
        for key in ["tetrahedra", "bounds", "field"] {
            assert_eq!(info[key], of_mesh[key], "{name}: {key}");
        }
        assert_eq!(info["fields"][0]["range"], of_mesh["fields"][0]["range"]);
        let clusters = info["clusters"].as_u64().expect("a number");
        assert!(clusters > 10, "{clusters}");
        let text = folder.run(&format!("info {name}.tsc")).succeeded().stdout;
        let (_, most) = text
            .split_once("of at most ")
            .expect("it says how large clusters are");
        let most: u64 = most
            .split(' ')
            .next()
            .and_then(|n| n.parse().ok())
            .expect("a number");
        assert!((100..=200).contains(&most), "{text}");

        let line = format!("render {name}.tsc --size 64 --memory 50MB -o {name}.npy");
        let report = json(&folder, &line);
        let count = |key: &str| report["statistics"][key].as_u64().expect("counted");
        let kinds = ["drawn", "hidden", "outside", "covered"];
        let sum: u64 = kinds
            .iter()
            .map(|kind| count(&format!("clusters_{kind}")))
            .sum();
        assert_eq!(sum, clusters);
        assert_eq!(count("lost_rays"), 0);
        assert_eq!(report["settings"]["memory"], "50");
    }
    // A scene of it is complete, and draws the same.
    let scene = folder.run("print-scene sphere.tsc").succeeded().stdout;
    folder.write("scene.toml", scene);
    let line = "render --scene scene.toml --size 64 -o again.npy";
    folder.run(line).succeeded();
    assert!(folder.read("again.npy") == folder.read("sphere.npy"));
}

#[test]
fn what_cannot_be_packed_or_drawn_is_refused_with_a_way_out() {
    let folder = Folder::new();
    folder.run("pack sphere --cells 300 -o s.tsc").succeeded();
    folder.write("grid.raw", [0; 8]);
    let packed = folder.read("s.tsc");
    folder.write("cut.tsc", &packed[..packed.len() / 2]);
    for (line, code, words) in [
        ("pack sphere -o s.vtu", 2, "valid: tsc"),
        ("pack sphere -o missing/s.tsc", 1, "missing"),
        ("pack s.tsc -o t.tsc", 3, "in clusters already"),
        (
            "pack angiography --cells 1000 -o t.tsc",
            2,
            "with `tetrascope render`",
        ),
        ("pack grid.raw --dims 2x2x2 -o t.tsc", 2, "--dims"),
        ("pack sphere --field heat -o t.tsc", 3, "distance"),
        ("pack sphere --cells 99999999999 -o t.tsc", 2, "10000000000"),
        (
            "pack sphere --cluster-cells 0 -o t.tsc",
            2,
            "--cluster-cells",
        ),
        ("pack sphere --memory 2 -o t.tsc", 2, "--memory"),
        ("info cut.tsc", 3, "the header says"),
        ("render cut.tsc", 3, "pack the mesh again"),
        ("render s.tsc --field heat", 3, "distance"),
        ("render s.tsc --curved 1e-3", 3, "curved"),
        ("render s.tsc --error 1e-3", 2, "leave out --error"),
        (
            "render s.tsc --budget 1s --memory 1GB",
            2,
            "leave out --error",
        ),
        ("render s.tsc --memory 2MB", 2, "memory"),
        ("render s.tsc --algorithm reference", 2, "stays in its file"),
        ("convert s.tsc -o s.vtu", 2, "convert the file"),
        ("info s.tsc --step 1", 3, "time step"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["cut.tsc", "grid.raw", "s.tsc"]);
}
