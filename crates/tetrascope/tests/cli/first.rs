//! First pictures: all settings are defaults, and something is to be seen.

use super::program::Folder;

/// A NRRD file of 32-bit floats.
fn nrrd(dims: [usize; 3], spacing: [f64; 3], value: impl Fn([usize; 3]) -> f32) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    let [sx, sy, sz] = spacing;
    let header = format!(
        "NRRD0004\ntype: float\ndimension: 3\nsizes: {nx} {ny} {nz}\nspacings: {sx} {sy} {sz}\n\
         endian: little\nencoding: raw\n\n"
    );
    let mut bytes = header.into_bytes();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                bytes.extend(value([x, y, z]).to_le_bytes());
            }
        }
    }
    bytes
}

/// A `.vtu` file; each of `cells` is a type and its points.
fn vtu(points: &[[f64; 3]], cells: &[(u8, &[usize])], scalars: Option<&[f64]>) -> String {
    fn join<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
        let words = numbers.into_iter().map(|n| n.to_string());
        words.collect::<Vec<String>>().join(" ")
    }
    let mut end = 0;
    let offsets = cells.iter().map(|(_, points)| {
        end += points.len();
        end
    });
    let offsets = join(offsets.collect::<Vec<usize>>());
    let data = scalars.map_or(String::new(), |values| {
        format!(
            "<PointData><DataArray type=\"Float64\" Name=\"s\" format=\"ascii\">{}</DataArray></PointData>",
            join(values)
        )
    });
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"><UnstructuredGrid>\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">{data}\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points>\
         <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{}</DataArray>\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">{offsets}</DataArray>\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">{}</DataArray></Cells>\
         </Piece></UnstructuredGrid></VTKFile>",
        points.len(),
        cells.len(),
        join(points.iter().flatten()),
        join(cells.iter().flat_map(|(_, points)| points.iter())),
        join(cells.iter().map(|(kind, _)| kind)),
    )
}

/// The eight points of a box.
fn corners(size: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, z] = size;
    let face = |z| [[0.0, 0.0, z], [x, 0.0, z], [x, y, z], [0.0, y, z]];
    [face(0.0), face(z)].concat()
}

const HEXAHEDRON: (u8, &[usize]) = (12, &[0, 1, 2, 3, 4, 5, 6, 7]);

/// Draws `name` with defaults: the opacity of each pixel, and what was said.
fn first(folder: &Folder, name: &str) -> (Vec<f32>, String) {
    let run = folder
        .run(&format!("render {name} --size 64x64 -o out.npy"))
        .succeeded();
    let bytes = folder.read("out.npy");
    let start = bytes.len() - 64 * 64 * 16;
    let floats = bytes[start..].chunks_exact(4);
    let floats = floats.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    (floats.skip(3).step_by(4).collect(), run.stderr)
}

/// The part of all pixels that are more opaque than `least`.
fn covered(opacity: &[f32], least: f32) -> f64 {
    opacity.iter().filter(|a| **a > least).count() as f64 / opacity.len() as f64
}

#[test]
fn a_thin_slab_is_seen() {
    let folder = Folder::new();
    let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    for (size, least) in [
        ([1000.0, 1000.0, 1.0], 0.2),
        ([1.0, 2000.0, 2000.0], 0.2),
        ([3e-9, 3e-12, 3e-9], 0.2),
        // Degrees and meters: a needle, seen along its axis.
        ([0.5, 0.5, 4000.0], 0.5),
    ] {
        folder.write(
            "slab.vtu",
            vtu(&corners(size), &[HEXAHEDRON], Some(&values)),
        );
        let (opacity, said) = first(&folder, "slab.vtu");
        let part = covered(&opacity, 0.2);
        assert!(part > least, "{size:?}: {part} of the picture, {said}");
        assert!(!said.contains("warning"), "{said}");
        assert!(said.contains("--unit-distance changes it"), "{said}");
        assert!(!said.contains("0.00000"), "{said}");
    }
}

#[test]
fn far_apart_samples_are_seen() {
    let folder = Folder::new();
    let bytes = nrrd([12, 10, 8], [1.0, 1.0, 100.0], |[x, y, z]| {
        f32::from(u8::from(x > 3 && y > 3 && z > 2)) * 100.0
    });
    folder.write("far.nrrd", bytes);
    let (opacity, said) = first(&folder, "far.nrrd");
    assert!(covered(&opacity, 0.5) > 0.2, "{said}");
    assert!(said.contains("camera: fit+z, in parallel"), "{said}");
}

/// Whether `p` is in the ball of radius 3 around (x, 8, 8).
fn in_ball(p: [usize; 3], x: usize) -> bool {
    let d2 = |(a, b): (usize, usize)| a.abs_diff(b).pow(2);
    d2((p[0], x)) + d2((p[1], 8)) + d2((p[2], 8)) <= 9
}

#[test]
fn objects_in_a_background_are_seen_and_not_their_box() {
    let folder = Folder::new();
    let objects = |p, a: f32, b: f32, air: f32| match (in_ball(p, 4), in_ball(p, 11)) {
        (true, _) => a,
        (_, true) => b,
        _ => air,
    };
    let noisy = |p: [usize; 3]| (p[0] * 7 + p[1] * 3 + p[2] * 5) % 7;
    type Field<'a> = &'a dyn Fn([usize; 3]) -> f32;
    let cases: [(&str, Field, &str); 5] = [
        ("signed", &|p| objects(p, 4.0, -4.0, 0.0), "opacity: 0 at 0"),
        (
            "air",
            &|p| objects(p, 250.0, 0.0, 72.0 + noisy(p) as f32),
            "of the volume",
        ),
        (
            "outlier",
            &|p| match p {
                [2, 8, 8] => 1e7,
                _ => objects(p, 200.0 + noisy(p) as f32, 250.0, 0.0),
            },
            "without 1 of 4096 values",
        ),
        (
            "padding",
            &|p| match p[2] {
                0..4 => -32768.0,
                _ => objects(p, 900.0 + noisy(p) as f32, 3000.0, 0.0),
            },
            "what is below is clear",
        ),
        (
            "fill",
            &|p| match p[2] {
                0..4 => 1e36,
                _ => objects(p, 290.0 + noisy(p) as f32, 310.0, 270.0),
            },
            "1e36 is a mark of that",
        ),
    ];
    for (name, field, words) in cases {
        let file = format!("{name}.nrrd");
        folder.write(&file, nrrd([16; 3], [1.0; 3], field));
        let (opacity, said) = first(&folder, &file);
        assert!(said.contains(words), "{name}: {said}");
        assert!(said.contains("--range"), "{name}: {said}");
        // Two balls of radius 3 in a cube of 15; its shadow is 0.7 of the picture.
        let seen = covered(&opacity, 0.3);
        assert!((0.05..0.4).contains(&seen), "{name}: {seen}");
        let clear = 1.0 - covered(&opacity, 0.05);
        assert!(clear > 0.45, "{name}: {clear} is clear");
    }
}

#[test]
fn a_mesh_of_one_value_but_for_outliers_is_seen() {
    let folder = Folder::new();
    // A bar of 99 cells, of which every third point has a value of its own.
    let mut points = Vec::new();
    let mut values = Vec::new();
    for i in 0..100_u8 {
        let x = f64::from(i) / 10.0;
        points.extend([[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 1.0], [x, 0.0, 1.0]]);
        values.extend(
            [match i % 3 {
                0 => f64::from(i),
                _ => 0.0,
            }; 4],
        );
    }
    values[17] = -1e9;
    let cells: Vec<Vec<usize>> = (0..99).map(|i| (4 * i..4 * i + 8).collect()).collect();
    let cells: Vec<(u8, &[usize])> = cells.iter().map(|c| (12, &c[..])).collect();
    folder.write("bar.vtu", vtu(&points, &cells, Some(&values)));
    let (opacity, said) = first(&folder, "bar.vtu");
    let line = "range: [0, 99], without 1 of 400 values: the field's is [-1000000000, 99]";
    assert!(said.contains(line), "{said}");
    assert!(covered(&opacity, 0.3) > 0.03, "{said}");
    assert!(opacity.iter().any(|a| *a > 0.5));
}

#[test]
fn a_faint_picture_is_warned_of() {
    let folder = Folder::new();
    let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    folder.write(
        "cube.vtu",
        vtu(&corners([1.0; 3]), &[HEXAHEDRON], Some(&values)),
    );
    let run = folder
        .run("render cube.vtu --size 16 --unit-distance 100 -o out.png")
        .succeeded();
    assert!(
        run.stderr.contains("warning: the picture is faint"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("--unit-distance"), "{}", run.stderr);
}

#[test]
fn info_describes_meshes_that_cannot_be_drawn() {
    let folder = Folder::new();
    let points = corners([2e-9, 1e-9, 1e-9]);
    folder.write("bare.vtu", vtu(&points, &[HEXAHEDRON], None));
    let text = folder.run("info bare.vtu").succeeded().stdout;
    for line in [
        "  hexahedron × 1",
        "points         8",
        "  no fields",
        "bounds         [0, 0, 0] to [2e-9, 1e-9, 1e-9]",
        "volume         2e-27",
        "12 triangles, convex, closed, one part",
        "the mesh has no fields: there is nothing to draw",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let json = folder.run("info bare.vtu --json").succeeded().json();
    assert_eq!(json["field"], serde_json::Value::Null);
    assert_eq!(json["fields"], serde_json::json!([]));
    assert_eq!(json["boundary"]["convex"], true);
    let (error, help) = folder.run("render bare.vtu -o out.png").failed(3);
    assert!(
        error.contains("no scalar field") && !help.is_empty(),
        "{error}"
    );

    let surface: &[(u8, &[usize])] = &[(5, &[0, 1, 2]), (3, &[0, 6])];
    let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    folder.write("surface.vtu", vtu(&points, surface, Some(&values)));
    let text = folder.run("info surface.vtu").succeeded().stdout;
    for line in [
        "  line × 1",
        "  triangle × 1",
        "tetrahedra     0",
        "points         8",
        "bounds         [0, 0, 0] to [2e-9, 1e-9, 1e-9]",
        "no volume cells that can be drawn: there is nothing to draw",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert!(!text.contains(", drawn"), "{text}");
    let json = folder.run("info surface.vtu --json").succeeded().json();
    assert_eq!(json["tetrahedra"], 0);
    assert_eq!(json["boundary"], serde_json::Value::Null);
}
