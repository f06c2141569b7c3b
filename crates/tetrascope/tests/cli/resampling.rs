//! Tests of the files that `resample` and `slice` write.

use tetrascope::io::{FileData, ReadOptions, read_file};

use super::program::{Folder, Run};

/// A cube [0, 2]³ of five cells with x + 2y − z at the points, the cells' numbers, and another field
/// of cells that is called as that of the points.
const CUBE: &str = "\
# vtk DataFile Version 3.0
cube
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 8 double
0 0 0  2 0 0  0 2 0  2 2 0  0 0 2  2 0 2  0 2 2  2 2 2
CELLS 5 25
4 0 5 3 6
4 0 1 3 5
4 0 3 2 6
4 0 6 4 5
4 3 6 5 7
CELL_TYPES 5
10 10 10 10 10
POINT_DATA 8
SCALARS plane double 1
LOOKUP_TABLE default
0 2 4 6 -2 0 2 4
CELL_DATA 5
SCALARS number double 1
LOOKUP_TABLE default
0 1 2 3 4
SCALARS plane double 1
LOOKUP_TABLE default
7 7 7 7 7
";

pub(crate) fn cube() -> Folder {
    let folder = Folder::new();
    folder.write("cube.vtk", CUBE);
    folder
}

/// Whether the run ended for want of an adapter, which only matters where there must be one.
fn lacks_adapter(run: &Run) -> bool {
    let lacks = run.code == 4 && run.stderr.contains("no suitable graphics adapter");
    assert!(!lacks || std::env::var_os("CI").is_none(), "{}", run.stderr);
    lacks
}

/// The dims of a `.vti` file and its arrays of floats.
pub(crate) fn arrays(folder: &Folder, name: &str) -> ([usize; 3], Vec<(String, Vec<f32>)>) {
    let read = read_file(&folder.path(name), &ReadOptions::default()).expect("a valid file");
    let FileData::Grid(data) = read else {
        panic!("{name} is a grid");
    };
    let names: Vec<String> = data.fields.iter().map(|field| field.name.clone()).collect();
    let mut dims = [0; 3];
    let arrays = names.into_iter().map(|name| {
        let (volume, _) = data.clone().into_volume(Some(&name)).expect("a field");
        let tetrascope::core::Volume::Grid(grid) = volume else {
            panic!("a small file is read at once");
        };
        dims = grid.lattice().dims;
        let samples = grid.samples();
        let numbers = (0..samples.len()).map(|i| samples.get(i) as f32);
        (name, numbers.collect())
    });
    let arrays = arrays.collect();
    (dims, arrays)
}

#[test]
fn samples_of_all_fields_are_written() {
    let folder = cube();
    let run = folder.run("resample cube.vtk --dims 5 --all-fields --json");
    if lacks_adapter(&run) {
        return;
    }
    let report = run.succeeded().json();
    assert_eq!(report["dims"], serde_json::json!([5, 5, 5]));
    assert_eq!(report["samples_inside"], 125);
    assert_eq!(folder.files(), ["cube.vti", "cube.vtk"]);
    let (dims, arrays) = arrays(&folder, "cube.vti");
    assert_eq!(dims, [5; 3]);
    let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["plane", "number", "plane (cell)", "vtkValidPointMask"]
    );
    // From half a millionth of the size to as much before the end.
    let at = |i: usize| 1e-6 + 0.5 * i as f64 * (1.0 - 1e-6);
    for (i, sample) in arrays[0].1.iter().enumerate() {
        let [x, y, z] = [i % 5, i / 5 % 5, i / 25].map(at);
        let expected = x + 2.0 * y - z;
        // A few roundings of numbers up to 6.
        assert!(
            (f64::from(*sample) - expected).abs() < 3e-6,
            "{i}: {sample} {expected}"
        );
    }
    assert!(
        arrays[1]
            .1
            .iter()
            .all(|n| [0.0, 1.0, 2.0, 3.0, 4.0].contains(n))
    );
    assert!(arrays[2].1.iter().all(|n| *n == 7.0));
    assert!(arrays[3].1.iter().all(|n| *n == 1.0));
}

#[test]
fn samples_may_be_drawn_as_published() {
    let folder = cube();
    for passes in ["one", "two"] {
        let line = format!("resample cube.vtk --dims 5 --passes {passes} --weights 1024 --slabs 3");
        let run = folder.run(&line);
        if lacks_adapter(&run) {
            return;
        }
        run.succeeded();
        let (_, arrays) = arrays(&folder, "cube.vti");
        let at = |i: usize| 1e-6 + 0.5 * i as f64 * (1.0 - 1e-6);
        for (i, sample) in arrays[0].1.iter().enumerate() {
            let [x, y, z] = [i % 5, i / 5 % 5, i / 25].map(at);
            let off = (f64::from(*sample) - (x + 2.0 * y - z)).abs();
            // 1/1024 of a cell's range, of which the cube has 4.
            assert!(off < 0.004, "{passes}, {i}: {sample}");
        }
        assert!(arrays[1].1.iter().all(|n| *n == 1.0), "all are inside");
    }
    let run = folder.run("resample cube.vtk --passes one --weights 33 -q");
    let (error, _) = run.failed(2);
    assert!(error.contains("even numbers"), "{error}");
}

#[test]
fn samples_outside_are_what_is_asked_for() {
    let folder = cube();
    let line =
        "resample cube.vtk --dims 4x3x2 --region -0.5,2.5,0.5,1.5,0.5,1.5 --outside -9 -o a.vti";
    let run = folder.run(line);
    if lacks_adapter(&run) {
        return;
    }
    run.succeeded();
    let (dims, written) = arrays(&folder, "a.vti");
    assert_eq!(dims, [4, 3, 2]);
    // x is −0.5, 0.5, 1.5 and 2.5.
    for (i, (sample, inside)) in written[0].1.iter().zip(&written[1].1).enumerate() {
        let is_inside = i % 4 == 1 || i % 4 == 2;
        assert_eq!(*inside == 1.0, is_inside, "{i}");
        assert_eq!(*sample == -9.0, !is_inside, "{i}: {sample}");
    }
    let (error, help) = folder.run("resample a.vti -q").failed(3);
    assert!(error.contains("a regular grid already"), "{error}");
    assert!(help.contains("as it is"), "{help}");
    let run = folder.run("resample cube.vtk --dims 3 --region 5,6,5,6,5,6 --compress -o b.vti");
    let stderr = run.succeeded().stderr;
    assert!(stderr.contains("no sample is in the mesh"), "{stderr}");
    let (_, written) = arrays(&folder, "b.vti");
    assert!(written[0].1.iter().all(|sample| sample.is_nan()));
}

#[test]
fn a_section_is_a_picture_or_numbers() {
    let folder = cube();
    let run = folder.run("slice cube.vtk --plane 1,1,1,0,0,1 --size 8 -o a.npy");
    if lacks_adapter(&run) {
        return;
    }
    run.succeeded();
    let bytes = folder.read("a.npy");
    let (header, numbers) = bytes.split_at(bytes.len() - 4 * 64);
    let header = String::from_utf8_lossy(header);
    assert!(header.contains("(8, 8)"), "{header}");
    for (i, bytes) in numbers.chunks(4).enumerate() {
        let number = f32::from_le_bytes(bytes.try_into().expect("four"));
        // The top row first, seen from +z.
        let [x, y] = [i % 8, 7 - i / 8].map(|i| (i as f64 + 0.5) / 4.0);
        let expected = x + 2.0 * y - 1.0;
        assert!(
            (f64::from(number) - expected).abs() < 2e-6,
            "{i}: {number} {expected}"
        );
    }
    let report = folder
        .run("slice cube.vtk --field number --size 9 --json")
        .succeeded()
        .json();
    assert_eq!(report["output"], "cube-slice.png");
    assert_eq!(report["field"], "number");
    folder
        .run("slice cube.vtk --plane 1,1,1,1,1,1 --size 16 -o c.vti")
        .succeeded();
    let (dims, written) = arrays(&folder, "c.vti");
    assert_eq!(dims[2], 1);
    // A hexagon in its bounding rectangle: three quarters.
    let inside = written[1].1.iter().sum::<f32>() / written[1].1.len() as f32;
    assert!((0.68..0.82).contains(&inside), "{inside}");
}

#[test]
fn what_cannot_be_sampled_is_one_line() {
    let folder = cube();
    for (line, code, words) in [
        ("resample cube.vtk --dims 1", 2, "2 or more"),
        ("resample cube.vtk --dims 0x4x4", 2, "2 or more"),
        ("resample cube.vtk --region 1,0,0,1,0,1", 2, "less than"),
        ("resample cube.vtk --outside 1e99", 2, "32-bit"),
        ("resample cube.vtk -o cube.vtu", 2, "vti"),
        ("resample cube.vtk -o none/cube.vti", 1, "none"),
        ("resample cube.vtk --field heat", 3, "heat"),
        ("resample missing.vtk", 3, "missing.vtk"),
        ("resample spher", 2, "sphere"),
        ("slice cube.vtk --plane 9,9,9,1,0,0", 3, "does not cut"),
        ("slice cube.vtk --plane 1,1,1,0,0,0", 2, "normal"),
        ("slice cube.vtk -o cube.jpg", 2, "jpg"),
    ] {
        let run = folder.run(line);
        let stderr = run.stderr.clone();
        assert_eq!(run.code, code, "{line}: {stderr}");
        assert!(stderr.contains(words), "{line}: {stderr}");
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
    }
    assert_eq!(folder.files(), ["cube.vtk"]);
}
