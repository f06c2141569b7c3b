//! Cell data, hidden points and cells, and colors of VTK's images.

use super::*;

fn image(extent: &str, data: &str) -> Vec<u8> {
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"{extent}\" Origin=\"1 0 0\" \
         Spacing=\"2 1 1\"><Piece Extent=\"{extent}\">{data}</Piece></ImageData></VTKFile>"
    )
    .into_bytes()
}

fn array(kind: &str, name: &str, values: &[u8]) -> String {
    let words: Vec<String> = values.iter().map(u8::to_string).collect();
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{}</DataArray>",
        words.join(" ")
    )
}

fn missing(data: &GridData, field: usize) -> Vec<usize> {
    let (_, samples) = loaded(data, field);
    (0..samples.len())
        .filter(|i| samples.get(*i).is_nan())
        .collect()
}

// The same cells in both formats; one layer is enough.
#[test]
fn cell_data_fill_whole_cells() {
    let values: Vec<u8> = (0..6).collect();
    let vti = image(
        "0 3 0 2 0 1",
        &format!("<CellData>{}</CellData>", array("UInt8", "c", &values)),
    );
    let vtk = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n\
        DIMENSIONS 4 3 2\nORIGIN 1 0 0\nSPACING 2 1 1\nCELL_DATA 6\nSCALARS c unsigned_char 1\n\
        LOOKUP_TABLE default\n0 1 2 3 4 5\n";
    for (name, file) in [("a.vti", vti.as_slice()), ("a.vtk", vtk.as_bytes())] {
        let data = read(&[(name, file)]).unwrap_or_else(|error| panic!("{error}"));
        let (lattice, samples) = loaded(&data, 0);
        assert_eq!(samples, Samples::U8(values.clone()));
        assert_eq!(data.fields[0].association, Association::Cell);
        assert_eq!((lattice.dims, lattice.cells()), ([3, 2, 1], [3, 2, 1]));
        let bounds = lattice.bounds();
        assert_eq!(bounds.min, DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(bounds.max, DVec3::new(7.0, 2.0, 1.0));
    }
}

#[test]
fn hidden_cells_and_points_are_not_drawn_and_counted() {
    // 3×2×2 cells on 4×3×3 points; cell (0, 0, 0) is hidden, and one that others refine.
    let points: Vec<u8> = (0..36).collect();
    let mut marks = [0; 12];
    (marks[0], marks[11]) = (32, 8);
    let file = image(
        "0 3 0 2 0 2",
        &format!(
            "<PointData>{}</PointData><CellData>{}{}</CellData>",
            array("UInt8", "p", &points),
            array("UInt8", "c", &points[..12]),
            array("UInt8", "vtkGhostType", &marks)
        ),
    );
    let data = read(&[("a.vti", &file)]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(missing(&data, 1), [0, 11]);
    // The corners of both: (0|1, 0|1, 0|1) and (2|3, 1|2, 1|2).
    let at = |x: usize, y: usize, z: usize| x + 4 * (y + 3 * z);
    let mut corners = Vec::new();
    for i in 0..8 {
        let (x, y, z) = (i & 1, i >> 1 & 1, i >> 2);
        corners.extend([at(x, y, z), at(2 + x, 1 + y, 1 + z)]);
    }
    corners.sort_unstable();
    assert_eq!(missing(&data, 0), corners);
    assert_eq!(data.notes[0], "2 cells hidden by vtkGhostType");
    // Each of the 10 others touches a corner of one of the two.
    assert!(
        data.notes[1].ends_with("10 cells beside"),
        "{:?}",
        data.notes
    );

    // A hidden point hides itself and the cells around it.
    let mut marks = [0; 36];
    marks[at(1, 1, 1)] = 2;
    let file = image(
        "0 3 0 2 0 2",
        &format!(
            "<PointData>{}{}</PointData><CellData>{}</CellData>",
            array("UInt8", "p", &points),
            array("UInt8", "vtkGhostType", &marks),
            array("UInt8", "c", &points[..12])
        ),
    );
    let data = read(&[("a.vti", &file)]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(data.notes, ["1 point hidden by vtkGhostType"]);
    assert_eq!(missing(&data, 0), [at(1, 1, 1)]);
    assert_eq!(missing(&data, 1), [0, 1, 3, 4, 6, 7, 9, 10]);
}

#[test]
fn colors_are_bytes_and_each_channel_is_a_field() {
    let head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n\
        DIMENSIONS 2 2 2\nPOINT_DATA 8\n";
    // As VTK writes scalars that are bytes: 100 is 0.392157.
    let fractions = "0 1 0.392157 0.00392157 0.5 0 0 0";
    let file = format!("{head}COLOR_SCALARS s 1\n{fractions}\n");
    let (_, samples) = first(&[("a.vtk", file.as_bytes())]);
    assert_eq!(samples, Samples::U8(vec![0, 255, 100, 1, 128, 0, 0, 0]));
    let pixels = "0 0.2 0.4 1 ".repeat(8);
    let file = format!("{head}COLOR_SCALARS rgba 4\n{pixels}\n");
    let data = read(&[("a.vtk", file.as_bytes())]).expect("fine");
    let names: Vec<&str> = data.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["rgba-0", "rgba-1", "rgba-2", "rgba-3"]);
    assert_eq!(loaded(&data, 2).1.get(7), 102.0);
    assert!(data.notes[0].contains("colors"), "{:?}", data.notes);
    // In bytes they are what they are.
    let head = head.replace("ASCII", "BINARY");
    let head = format!("{head}COLOR_SCALARS s 1\n");
    let file = join(&[head.as_bytes(), &[7, 6, 5, 4, 3, 2, 1, 0]]);
    let (_, samples) = first(&[("a.vtk", &file)]);
    assert_eq!(samples, Samples::U8(vec![7, 6, 5, 4, 3, 2, 1, 0]));
}
