use std::path::Path;

use glam::DVec3;
use tetrascope_core::{Error, glam};

use super::even_steps;
use crate::read::{FileData, ReadOptions, read_file};
use crate::source::Source;
use crate::{GridData, MeshData, vtk, vtu};

fn fixture(name: &str) -> Result<FileData, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/structured");
    read_file(&folder.join(name), &ReadOptions::default())
}

fn read_text(text: &str) -> Result<FileData, Error> {
    let source = Source {
        path: "a.vts".into(),
        bytes: text.into(),
    };
    match text.starts_with("# vtk") {
        true => vtk::read(source),
        false => vtu::read(source),
    }
}

fn mesh(data: Result<FileData, Error>) -> MeshData {
    match data.expect("it is read") {
        FileData::Mesh(mesh) => mesh,
        FileData::Grid(_) | FileData::Clusters(_) => panic!("a grid"),
    }
}

fn grid(data: Result<FileData, Error>) -> GridData {
    match data.expect("it is read") {
        FileData::Grid(grid) => grid,
        FileData::Mesh(_) | FileData::Clusters(_) => panic!("a mesh"),
    }
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    let field = data.field(Some(name));
    field.unwrap_or_else(|e| panic!("{e}")).values
}

/// The field f of make.py.
fn f(points: &[DVec3]) -> Vec<f64> {
    points
        .iter()
        .map(|p| p.x + 10.0 * p.y + 100.0 * p.z)
        .collect()
}

#[test]
fn a_structured_grid_is_hexahedra_without_those_that_are_hidden() {
    let data = mesh(fixture("blanked.vts"));
    assert_eq!(data.points.len(), 27);
    assert_eq!(data.cells.types, [12; 6]);
    assert_eq!(values(&data, "c"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(values(&data, "f"), f(&data.points));
    assert_eq!(data.cells.connectivity[..8], [1, 2, 5, 4, 10, 11, 14, 13]);
    let words = "2 cells left out: they are ghosts (duplicate or hidden)";
    assert_eq!(data.notes, [words]);
}

#[test]
fn pieces_by_extent_have_no_seams() {
    let data = mesh(fixture("pieces.vts"));
    assert_eq!(data.cells.types, [12; 3 * 2 * 2]);
    let words =
        "3 pieces joined: 18 points lie exactly where others are, and neighbors share faces there";
    assert_eq!(data.notes, [words]);
    let mesh = data.into_mesh(None).expect("a mesh");
    assert!((mesh.volume() - 12.0).abs() < 1e-12);
    // Two triangles for each square of the box around 3 × 2 × 2 cubes.
    assert_eq!(mesh.boundary_faces().len(), 2 * 2 * (6 + 6 + 4));
    assert!(mesh.is_continuous());
}

#[test]
fn a_rectilinear_grid_is_a_mesh_if_it_is_stretched() {
    for name in [
        "stretched.vtr",
        "stretched-ascii.vtk",
        "stretched-binary.vtk",
    ] {
        let data = mesh(fixture(name));
        assert_eq!(data.points.len(), 18, "{name}");
        // Numbers that were floats, and the same as text.
        let far = data.points[17] - DVec3::new(3.0, 1.0, 0.4);
        assert!(far.abs().max_element() < 1e-8, "{name}");
        assert_eq!(data.cells.types, [12; 4], "{name}");
        assert_eq!(values(&data, "c"), [0.0, 1.0, 2.0, 3.0], "{name}");
        let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-6;
        assert!(
            values(&data, "f")
                .into_iter()
                .zip(f(&data.points))
                .all(near),
            "{name}"
        );
        let volume = data.into_mesh(Some("f")).expect("a mesh").volume();
        assert!((volume - 3.0 * 2.0 * 0.3).abs() < 1e-7, "{name}: {volume}");
    }
}

#[test]
fn a_rectilinear_grid_is_regular_if_it_is_evenly_spaced() {
    for name in ["even.vtr", "even-ascii.vtk", "even-binary.vtk"] {
        let data = grid(fixture(name));
        let [point, cell] = &data.fields[..] else {
            panic!("{name}: {} fields", data.fields.len());
        };
        assert_eq!(
            (point.name.as_str(), cell.name.as_str()),
            ("f", "c"),
            "{name}"
        );
        assert_eq!(
            (point.lattice.dims, cell.lattice.dims),
            ([3, 3, 2], [2, 2, 1]),
            "{name}"
        );
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-7;
        assert!(
            near(point.lattice.origin, DVec3::new(0.1, -1.0, 0.1)),
            "{name}"
        );
        assert!(
            near(point.lattice.spacing, DVec3::new(0.1, 1.0, 0.3)),
            "{name}"
        );
        let words = "of a step: the grid is regular";
        assert!(
            data.notes.iter().any(|n| n.ends_with(words)),
            "{:?}",
            data.notes
        );
    }
}

#[test]
fn even_coordinates_are_even_to_the_rounding_of_their_numbers() {
    let single = f64::from(f32::EPSILON);
    let even = |x: &[f64], epsilon| even_steps(x, epsilon).is_some();
    assert!(even(&[0.0, 1.0, 2.0], 0.0));
    assert!(even(&[2.0, 1.0, 0.0], 0.0));
    assert!(even(&[0.1, 0.2, 0.30000001], single));
    // Numbers of six digits; one more of them is not even.
    assert!(even(&[0.0, 0.333333, 0.666667, 1.0], f64::EPSILON));
    assert!(!even(&[0.0, 0.3331, 0.6669, 1.0], f64::EPSILON));
    // So far from 0, floats are a sixteenth apart.
    assert!(even(&[1e6, 1e6 + 0.4375, 1e6 + 0.8125], single));
    assert!(!even(&[1e6, 1e6 + 0.4375, 1e6 + 0.8125], f64::EPSILON));
    // But not if they are the same for it.
    assert!(!even(&[1e8, 1e8, 1e8 + 8.0], single));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(!even(&[0.0, bad, 2.0], single) && !even(&[0.0, 1.0, bad], single));
    }
    assert!(!even(&[1.0, 1.0], single) && !even(&[1.0], single) && !even(&[], single));
}

/// Two cells along x in two pieces: a structured grid if `kind` says so.
fn pieces(kind: &str, extents: [&str; 2]) -> String {
    let piece = |(extent, xs): (&str, [u32; 2])| {
        let points: String = (0..8)
            .map(|i| format!("{} {} {} ", xs[i & 1] * xs[i & 1], i >> 1 & 1, i >> 2))
            .collect();
        let array = |text: &str, n: u32| {
            format!(
                r#"<DataArray type="Float64" Name="a" NumberOfComponents="{n}" format="ascii">{text}</DataArray>"#
            )
        };
        let xs = format!("{} {}", xs[0] * xs[0], xs[1] * xs[1]);
        let place = match kind {
            "StructuredGrid" => format!("<Points>{}</Points>", array(&points, 3)),
            _ => format!(
                "<Coordinates>{}{}{}</Coordinates>",
                array(&xs, 1),
                array("0 1", 1),
                array("0 1", 1)
            ),
        };
        let data = array("0 1 2 3 4 5 6 7", 1);
        format!(r#"<Piece Extent="{extent}"><PointData>{data}</PointData>{place}</Piece>"#)
    };
    let pieces: String = extents
        .into_iter()
        .zip([[0, 1], [1, 2]])
        .map(piece)
        .collect();
    format!(
        r#"<VTKFile type="{kind}"><{kind} WholeExtent="4 6 0 1 0 1">{pieces}</{kind}></VTKFile>"#
    )
}

const EXTENTS: [&str; 2] = ["4 5 0 1 0 1", "5 6 0 1 0 1"];

#[test]
fn both_kinds_are_joined_from_pieces() {
    for kind in ["StructuredGrid", "RectilinearGrid"] {
        let data = mesh(read_text(&pieces(kind, EXTENTS)));
        assert_eq!(data.cells.types, [12, 12], "{kind}");
        let volume = data.into_mesh(None).expect("a mesh").volume();
        assert!((volume - 4.0).abs() < 1e-14, "{kind}: {volume}");
    }
    // Evenly spaced across both pieces.
    let even = pieces("RectilinearGrid", EXTENTS).replace(">1 4<", ">1 2<");
    let data = grid(read_text(&even));
    assert_eq!(data.fields[0].lattice.dims, [3, 2, 2]);
    assert_eq!(data.fields[0].lattice.origin, DVec3::ZERO);
    // Pieces that do not agree about a plane are no regular grid.
    let off = even.replace(">1 2<", ">1.5 2<");
    assert_eq!(mesh(read_text(&off)).cells.types, [12, 12]);
}

#[test]
fn wrong_extents_are_refused() {
    let huge = "0 9000000000000000000 0 9000000000000000000 0 1";
    for kind in ["StructuredGrid", "RectilinearGrid"] {
        for (extents, words) in [
            (
                ["4 5 0 1 0 1", "5 7 0 1 0 1"],
                "[5, 7, 0, 1, 0, 1] is not in the whole",
            ),
            (["4 5 0 1 0 1", "3 4 0 1 0 1"], "is not in the whole"),
            (
                ["4 5 0 1 0 1", "6 5 0 1 0 1"],
                "pieces with 1 cells where 2 are needed",
            ),
            (
                ["4 5 0 1 0 1", "5 5 0 1 0 1"],
                "pieces with 1 cells where 2 are needed",
            ),
            (["4 6 0 1 0 1", "5 6 0 1 0 1"], "values where"),
            (["4 5 0 1 0 1", huge], "cannot be"),
            (["4 5 0 1 0 1", "5 6 0 1 0"], "not 6 numbers"),
        ] {
            let error = read_text(&pieces(kind, extents)).expect_err(words);
            assert!(error.to_string().contains(words), "{kind}: {error}");
        }
        let text = pieces(kind, EXTENTS);
        for (from, to, words) in [
            (
                "WholeExtent=\"4 6 0 1 0 1\"",
                "",
                "a grid without WholeExtent",
            ),
            (
                "WholeExtent=\"4 6 0 1 0 1\"",
                "WholeExtent=\"4 4 0 1 0 1\"",
                "is not in the whole",
            ),
            (
                "WholeExtent=\"4 6",
                "WholeExtent=\"-9223372036854775808 9223372036854775807",
                "cannot be",
            ),
            (
                "5 6 0 1 0 1",
                "-9223372036854775808 9223372036854775807 0 1 0 1",
                "cannot be",
            ),
            (&format!("</{kind}></VTKFile>"), "", "the file ends before"),
        ] {
            assert!(text.contains(from), "{from}");
            let error = read_text(&text.replace(from, to)).expect_err(words);
            assert!(error.to_string().contains(words), "{kind}: {error}");
        }
        let flat = text.replace("0 1 0 1\"", "0 1 0 0\"");
        let error = read_text(&flat).expect_err("a surface");
        assert!(
            error.to_string().contains("3×2×1 points has no volume"),
            "{error}"
        );
    }
    let text = pieces("RectilinearGrid", EXTENTS);
    let two = text.replacen("<DataArray type=\"Float64\" Name=\"a\" NumberOfComponents=\"1\" format=\"ascii\">0 1</DataArray></C", "</C", 1);
    let error = read_text(&two).expect_err("two axes");
    assert!(error.to_string().contains("needs three arrays"), "{error}");
}

/// Three axes that imply a thousand million cells.
#[test]
fn cells_are_implied_to_a_bound() {
    let axis: String = (0..1000).map(|i| format!("{} ", i * i)).collect();
    let array = format!(r#"<DataArray type="Float64" format="ascii">{axis}</DataArray>"#);
    let text = format!(
        r#"<VTKFile type="RectilinearGrid"><RectilinearGrid WholeExtent="0 999 0 999 0 999">
<Piece><Coordinates>{array}{array}{array}</Coordinates></Piece></RectilinearGrid></VTKFile>"#
    );
    let error = read_text(&text).expect_err("too many").to_string();
    assert!(error.contains("997002999 cells"), "{error}");
    let legacy = format!(
        "# vtk DataFile Version 3.0\nmany\nASCII\nDATASET RECTILINEAR_GRID\n\
         DIMENSIONS 1000 1000 1000\nX_COORDINATES 1000 double\n{axis}\n\
         Y_COORDINATES 1000 double\n{axis}\nZ_COORDINATES 1000 double\n{axis}\n"
    );
    let error = read_text(&legacy).expect_err("too many").to_string();
    assert!(
        error.contains("1000×1000×1000 points takes more than"),
        "{error}"
    );
    for (from, to, words) in [
        (
            "DIMENSIONS 1000",
            "DIMENSIONS 999",
            "not what DIMENSIONS says",
        ),
        ("Z_COORDINATES 1000", "Z_COORDINATES 2000", "values"),
        (
            "Z_COORDINATES 1000",
            "Z_COORDINATES 9000000000000000000",
            "points along an axis",
        ),
        ("Z_COORDINATES 1000", "Y_COORDINATES 1000", "0 points takes"),
        ("RECTILINEAR_GRID", "STRUCTURED_GRID", "no RECTILINEAR_GRID"),
    ] {
        let error = read_text(&legacy.replace(from, to))
            .expect_err(words)
            .to_string();
        if words == "0 points takes" || words == "values" {
            println!("{error}");
            continue;
        }
        assert!(error.contains(words), "{error}");
    }
}
