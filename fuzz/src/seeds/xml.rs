//! VTK XML meshes besides `.vtu`: structured and rectilinear grids, polyhedra, lists of files.

use super::Seed;
use crate::pack::Part;

pub(super) const STRUCTURED_WORDS: &[&str] = &[
    "StructuredGrid",
    "RectilinearGrid",
    "<Piece Extent=\"0 1 0 1 0 1\">",
    "</Piece>",
    "WholeExtent=\"0 2 0 1 0 1\"",
    "0 -1 0 0 0 0",
    "<Coordinates>",
    "</Coordinates>",
    "<Points>",
    "</Points>",
    "<PointData>",
    "</PointData>",
    "<CellData>",
    "</CellData>",
    "<DataArray type=\"Float32\" format=\"ascii\">",
    "</DataArray>",
    "<DataArray type=\"UInt8\" Name=\"vtkGhostType\">",
    "NumberOfComponents=\"3\"",
    "32",
    "nan",
    "1e999",
];

pub(super) const LIST_WORDS: &[&str] = &[
    "<Piece Source=\"a.vtu\"/>",
    "<Piece Source=\"b.vtu\"/>",
    "<PUnstructuredGrid GhostLevel=\"1\">",
    "</PUnstructuredGrid>",
    "<DataSet index=\"0\" file=\"a.vtu\"/>",
    "<DataSet file=\"b.vtu\"/>",
    "<DataSet index=\"1\"/>",
    "<Block index=\"1\">",
    "</Block>",
    "<Piece>",
    "</Piece>",
    "PUnstructuredGrid",
    "vtkMultiBlockDataSet",
    "vtkHierarchicalBoxDataSet",
    "<Piece Extent=\"0 1 0 1 0 1\" Source=\"a.vti\"/>",
    "<Piece Extent=\"1 2 0 1 0 1\" Source=\"b.vti\"/>",
    "<PImageData WholeExtent=\"0 2 0 1 0 1\">",
    "PImageData",
    "PStructuredGrid",
    "PRectilinearGrid",
    "WholeExtent=\"0 2 0 1 0 1\"",
    "&#97;.vtu",
    "../a.vtu",
    "./",
];

const CORNERS: &str = "0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1";

fn array(kind: &str, name: &str, numbers: &str) -> String {
    format!("<DataArray type=\"{kind}\" Name=\"{name}\">{numbers}</DataArray>")
}

fn points(numbers: &str) -> String {
    format!(
        "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">{numbers}</DataArray></Points>"
    )
}

fn file(kind: &str, version: &str, body: &str) -> String {
    format!("<VTKFile type=\"{kind}\" version=\"{version}\"><{kind}{body}</{kind}></VTKFile>\n")
}

/// A tetrahedron with the field `s`, moved along x.
pub(crate) fn tetrahedron(x: i32, ghosts: &str) -> Vec<u8> {
    let corners = format!("{x} 0 0 {} 0 0 {x} 1 0 {x} 0 1", x + 1);
    let body = format!(
        "><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData>{}</PointData>\
         <CellData>{ghosts}</CellData>{}<Cells>{}{}{}</Cells></Piece>",
        array("Float64", "s", "0 1 2 3"),
        points(&corners),
        array("Int64", "connectivity", "0 1 2 3"),
        array("Int64", "offsets", "4"),
        array("UInt8", "types", "10"),
    );
    file("UnstructuredGrid", "0.1", &body).into_bytes()
}

/// A cube and a pyramid on it, in both layouts of polyhedra.
pub(super) fn polyhedra() -> Vec<Seed> {
    let cells = |faces: String| {
        let body = format!(
            "><Piece NumberOfPoints=\"9\" NumberOfCells=\"2\"><PointData>{}</PointData>{}<Cells>\
             {}{}{}{faces}</Cells></Piece>",
            array("Float32", "s", "0 1 2 3 4 5 6 7 8"),
            points(&format!("{CORNERS} 0.5 0.5 2")),
            array("Int64", "connectivity", "0 1 2 3 4 5 6 7 4 5 6 7 8"),
            array("Int64", "offsets", "8 13"),
            array("UInt8", "types", "42 42"),
        );
        let text = file("UnstructuredGrid", "2.3", &body);
        Seed::single("mesh.vtu", vec![Part::plain(text)])
    };
    let old = "6 4 0 2 3 1 4 4 5 7 6 4 0 1 5 4 4 2 6 7 3 4 0 4 6 2 4 1 3 7 5 \
               5 4 4 6 7 5 3 4 5 8 3 5 7 8 3 7 6 8 3 6 4 8";
    let corners = "0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5 \
                   4 6 7 5 4 5 8 5 7 8 7 6 8 6 4 8";
    vec![
        cells(array("Int64", "faces", old) + &array("Int64", "faceoffsets", "31 53")),
        cells(
            array("Int64", "face_connectivity", corners)
                + &array("Int64", "face_offsets", "4 8 12 16 20 24 28 31 34 37 40")
                + &array("Int64", "polyhedron_to_faces", "0 1 2 3 4 5 6 7 8 9 10")
                + &array("Int64", "polyhedron_offsets", "6 11"),
        ),
    ]
}

/// A structured grid whole, and in two pieces.
pub(super) fn structured() -> Vec<Seed> {
    let piece = |extent: &str, x: f32| {
        let points = points(&CORNERS.replace('1', &x.to_string()));
        let fields = array("Float32", "s", "0 1 2 3 4 5 6 7");
        format!(
            "<Piece Extent=\"{extent}\"><PointData>{fields}</PointData><CellData>{}</CellData>\
             {points}</Piece>",
            array("Int16", "c", "5"),
        )
    };
    let one = format!(" WholeExtent=\"0 1 0 1 0 1\">{}", piece("0 1 0 1 0 1", 1.0));
    let two = format!(
        " WholeExtent=\"0 2 0 1 0 1\">{}{}",
        piece("0 1 0 1 0 1", 1.0),
        piece("1 2 0 1 0 1", 2.0)
    );
    let seed = |body: &str| {
        let text = file("StructuredGrid", "0.1", body);
        Seed::single("grid.vts", vec![Part::plain(text)])
    };
    vec![seed(&one), seed(&two)]
}

/// A rectilinear grid, stretched and even.
pub(super) fn rectilinear() -> Vec<Seed> {
    let seed = |x: &str| {
        let body = format!(
            " WholeExtent=\"0 2 0 1 0 1\"><Piece Extent=\"0 2 0 1 0 1\"><PointData>{}</PointData>\
             <CellData>{}</CellData><Coordinates>{}{}{}</Coordinates></Piece>",
            array("Float32", "s", "0 1 2 3 4 5 6 7 8 9 10 11"),
            array("UInt8", "vtkGhostType", "0 32"),
            array("Float64", "x", x),
            array("Float64", "y", "0 1"),
            array("Float64", "z", "0 1"),
        );
        let text = file("RectilinearGrid", "0.1", &body);
        Seed::single("grid.vtr", vec![Part::plain(text)])
    };
    vec![seed("0 1 3"), seed("0 1 2")]
}

/// Two pieces, the first of which an input may change.
pub(super) fn pieces() -> Vec<Seed> {
    let body = " GhostLevel=\"1\"><PPointData><PDataArray type=\"Float64\" Name=\"s\"/>\
                </PPointData><Piece Source=\"a.vtu\"/><Piece Source=\"b.vtu\"/>";
    listed("mesh.pvtu", file("PUnstructuredGrid", "0.1", body))
}

/// The kinds of grids whose pieces have extents.
const EXTENTS: [&str; 3] = ["ImageData", "StructuredGrid", "RectilinearGrid"];

/// A piece of two samples along each axis, the first or the second along x.
fn piece_of(kind: &str, second: bool) -> Vec<u8> {
    let (extent, x) = match second {
        false => ("0 1 0 1 0 1", "0 1"),
        true => ("1 2 0 1 0 1", "1 2"),
    };
    let place = match kind {
        "ImageData" => String::new(),
        "StructuredGrid" => points(&match second {
            false => CORNERS.to_owned(),
            true => "1 0 0 2 0 0 1 1 0 2 1 0 1 0 1 2 0 1 1 1 1 2 1 1".to_owned(),
        }),
        _ => format!(
            "<Coordinates>{}{}{}</Coordinates>",
            array("Float64", "x", x),
            array("Float64", "y", "0 1"),
            array("Float64", "z", "0 1"),
        ),
    };
    let body = format!(
        " WholeExtent=\"{extent}\"><Piece Extent=\"{extent}\"><PointData>{}</PointData>\
         {place}</Piece>",
        array("Float32", "s", "0 1 2 3 4 5 6 7"),
    );
    file(kind, "0.1", &body).into_bytes()
}

/// Names of second pieces, in the order of [`EXTENTS`].
const SECOND: [&str; 3] = ["b.vti", "b.vts", "b.vtr"];

pub(super) fn second_pieces() -> [(&'static str, Vec<u8>); 3] {
    [0, 1, 2].map(|i| (SECOND[i], piece_of(EXTENTS[i], true)))
}

/// Lists of two pieces, the first of which an input may change; it is always called `a.vti`.
pub(super) fn extents() -> Vec<Seed> {
    let seed = |(kind, second): (&str, &'static str)| {
        let list_kind = format!("P{kind}");
        let body = format!(
            " WholeExtent=\"0 2 0 1 0 1\" GhostLevel=\"0\"><PPointData>\
             <PDataArray type=\"Float32\" Name=\"s\"/></PPointData>\
             <Piece Extent=\"0 1 0 1 0 1\" Source=\"a.vti\"/>\
             <Piece Extent=\"1 2 0 1 0 1\" Source=\"{second}\"/>"
        );
        let list = file(&list_kind, "0.1", &body);
        Seed::of(vec![
            ("grid.pvti", vec![Part::plain(list)]),
            ("a.vti", vec![Part::plain(piece_of(kind, false))]),
            (second, vec![Part::plain(piece_of(kind, true))]),
        ])
    };
    EXTENTS.into_iter().zip(SECOND).map(seed).collect()
}

/// Two blocks, nested.
pub(super) fn blocks() -> Vec<Seed> {
    let body = "><DataSet index=\"0\" file=\"a.vtu\"/><Block index=\"1\" name=\"in\">\
                <DataSet index=\"0\" file=\"b.vtu\"/><DataSet index=\"1\"/></Block>";
    listed("mesh.vtm", file("vtkMultiBlockDataSet", "1.0", body))
}

fn listed(name: &'static str, list: String) -> Vec<Seed> {
    let ghosts = array("UInt8", "vtkGhostType", "0");
    let files = [&ghosts, ""].map(|ghosts| {
        vec![
            (name, vec![Part::plain(list.clone())]),
            ("a.vtu", vec![Part::plain(tetrahedron(0, ghosts))]),
            ("b.vtu", vec![Part::plain(tetrahedron(1, ""))]),
        ]
    });
    files.map(Seed::of).into()
}
