//! Curved cells, cut into straight ones.

use super::program::Folder;

/// A quadratic tetrahedron with an edge that is bent outwards by 0.3: its map is
/// z + 4 a x (1 − x − y − z), whose determinant is 1 − 4 a x with a = −0.3, so that its volume is
/// (1 − a) / 6. The field is x².
const BENT: &str = "# vtk DataFile Version 3.0
one cell
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 10 double
0 0 0  1 0 0  0 1 0  0 0 1
0.5 0 -0.3  0.5 0.5 0  0 0.5 0  0 0 0.5  0.5 0 0.5  0 0.5 0.5
CELLS 1 11
10 0 1 2 3 4 5 6 7 8 9
CELL_TYPES 1
24
POINT_DATA 10
SCALARS s double 1
LOOKUP_TABLE default
0 1 0 0 0.25 0.25 0 0 0.25 0
";

fn info(folder: &Folder, options: &str) -> serde_json::Value {
    let run = folder.run(&format!("info bent.vtk {options} --json"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).expect("JSON")
}

#[test]
fn the_tolerance_bounds_what_is_left() {
    let folder = Folder::new();
    folder.write("bent.vtk", BENT);
    let volume = |facts: &serde_json::Value| facts["volume"].as_f64().expect("a volume");
    let straight = info(&folder, "--curved 1");
    assert!((volume(&straight) - 1.0 / 6.0).abs() < 1e-12, "{straight}");
    let note = straight["notes"][0].as_str().expect("a note");
    assert!(
        note.starts_with("1 curved cell is drawn by the corners: "),
        "{note}"
    );
    assert_eq!(
        straight["notes"].as_array().map(Vec::len),
        Some(1),
        "{straight}"
    );
    for (options, tolerance) in [("--curved 1e-2", 1e-2), ("", 1e-3)] {
        let facts = info(&folder, options);
        // The surface, below 3, is off by at most so many parts of the diagonal, below 2.
        let off = (volume(&facts) - 1.3 / 6.0).abs();
        assert!(off < 3.0 * 2.0 * tolerance && off > 0.0, "{facts}");
        let note = facts["notes"][0].as_str().expect("a note");
        assert!(note.starts_with("1 curved cell is cut into "), "{note}");
    }
}

#[test]
fn a_scene_keeps_the_tolerance_and_convert_the_cells() {
    let folder = Folder::new();
    folder.write("bent.vtk", BENT);
    let run = folder.run("print-scene bent.vtk --curved 0.01");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("curved = 0.01"), "{}", run.stdout);
    let run = folder.run("convert bent.vtk -o bent.vtu");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = folder.run("info bent.vtu --curved 1 --json");
    let facts: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let note = facts["notes"][0].as_str().expect("a note");
    assert!(note.starts_with("1 curved cell is "), "{note}");
    let run = folder.run("convert bent.vtk --curved 0.1");
    assert_eq!(run.code, 2, "{}", run.stderr);
}
