//! Names of components, colors, pieces, time steps and encodings.

use super::*;

fn names(data: &MeshData) -> Vec<&str> {
    data.fields.iter().map(|f| f.name.as_str()).collect()
}

#[test]
fn components_have_the_names_that_vtk_wrote() {
    for name in [
        "components.vtu",
        "components-ascii.vtk",
        "components-binary.vtk",
    ] {
        let data = fixture(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (component, value) in [("XX", 1.0), ("YZ", 23.0), ("XZ", 13.0), ("XY", 12.0)] {
            let field = format!("stress-{component}");
            assert_eq!(
                values(&data, &field),
                [0.0, 0.25, 0.5, 0.75].map(|more| value + more),
                "{name}: {field}"
            );
        }
        // VTK's order is a guess, and this file says something else.
        assert!(data.field(Some("stress-xy")).is_err(), "{name}");
        for field in [
            "part-a b", "part-1", "part-é%", "part-3", "part-4", "part-f",
        ] {
            assert!(names(&data).contains(&field), "{name}: {:?}", names(&data));
        }
        let (index, note) = data.choose(Some("v-z")).expect("a guess");
        assert_eq!(data.fields[index].name, "v-2", "{name}");
        assert!(note.is_some_and(|note| note.contains("a guess")), "{name}");
        let (index, note) = data.choose(Some("v")).expect("its magnitude");
        assert_eq!(data.fields[index].name, "v-magnitude", "{name}");
        assert!(note.is_some(), "{name}");
    }
}

/// VTK writes 100 as 0.392157 to text and reads 100 again; its reader is the measure.
#[test]
fn colors_are_bytes_in_text_too_and_are_noted() {
    for name in [
        "components.vtu",
        "components-ascii.vtk",
        "components-binary.vtk",
    ] {
        let data = fixture(name).expect("it is a mesh");
        assert_eq!(values(&data, "rgb-0"), [0.0, 1.0, 4.0, 7.0], "{name}");
        assert_eq!(values(&data, "rgb-green"), [100.0, 2.0, 5.0, 8.0], "{name}");
        assert_eq!(values(&data, "rgb-b"), [255.0, 3.0, 6.0, 9.0], "{name}");
        let note =
            "'rgb' holds colors, which are drawn as numbers: a channel, or the magnitude of three";
        assert!(
            data.notes.iter().any(|n| n == note),
            "{name}: {:?}",
            data.notes
        );
    }
}

#[test]
fn a_name_at_points_and_in_cells_reaches_both() {
    let text = TRAPS.replace(
        "</PointData>",
        r#"</PointData><CellData><DataArray type="Float32" Name="scalar" format="ascii">9</DataArray></CellData>"#,
    );
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    assert_eq!(names(&data), ["scalar", "scalar"]);
    assert_eq!(values(&data, "scalar").len(), 4);
    for name in ["scalar (cell)", "cell:scalar"] {
        assert_eq!(values(&data, name), [9.0], "{name}");
    }
    assert_eq!(values(&data, "point:scalar").len(), 4);
}

#[test]
fn a_field_that_one_piece_lacks_is_named_with_the_piece() {
    let start = TRAPS.find("<Piece").expect("it has one");
    let end = TRAPS.find("</Unst").expect("it ends");
    let piece = &TRAPS[start..end];
    let fields = piece.find("<PointData").expect("it has fields")
        ..piece.find("<Points>").expect("it has points");
    let bare = piece.replace(&piece[fields], "");
    let text = TRAPS.replace(piece, &format!("{piece}{bare}"));
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    for name in [None, Some("scalar")] {
        let error = data.field(name).expect_err("not everywhere").to_string();
        assert_eq!(
            error,
            "array 'scalar' cannot be drawn: piece 2 of 2 has no such array of 1 component"
        );
    }
    let other = data.field(Some("scal")).expect_err("no such field");
    assert!(other.to_string().contains("no scalar field"), "{other}");
}

#[test]
fn the_first_of_several_time_steps_is_read_and_the_others_are_noted() {
    let array = r#"<DataArray type="Float32" Name="scalar" Format="ascii">0 1 nan 3</DataArray>"#;
    let second = array.replace("0 1 nan 3", "5 6 7 8");
    let text = TRAPS.replace(array, &format!("{array}{second}{second}"));
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    assert_eq!(names(&data), ["scalar"]);
    assert_eq!(values(&data, "scalar")[3], 3.0);
    assert_eq!(
        data.notes,
        ["the file holds 3 time steps: the first is read"]
    );
    // Arrays without a name are not the same one again.
    let text = TRAPS.replace(
        array,
        &format!("{array}{second}{second}").replace(r#"Name="scalar""#, r#"Name="""#),
    );
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    assert_eq!(names(&data), ["unnamed-0", "unnamed-1", "unnamed-2"]);
    assert!(data.notes.is_empty());
}

#[test]
fn text_is_not_compressed_whatever_the_file_says() {
    let text = TRAPS.replace(
        "byte_order",
        r#"compressor="vtkLZMADataCompressor" byte_order"#,
    );
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    assert_eq!(values(&data, "scalar")[1], 1.0);
}

#[test]
fn xml_in_latin_1_is_read_with_its_names() {
    let text = TRAPS.replace("Name=\"scalar\"", "Name=\"T ?\"");
    let mut bytes =
        b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<!-- L\xf6sung -->\n".to_vec();
    bytes.extend(text.bytes().map(|b| if b == b'?' { 0xb0 } else { b }));
    let data = read_bytes("a.vtu", bytes.clone()).expect("it is a mesh");
    assert_eq!(names(&data), ["T °"]);
    assert_eq!(values(&data, "T °")[1], 1.0);
    let undeclared = bytes.split_off(45);
    let error = read_bytes("a.vtu", undeclared).expect_err("which encoding?");
    assert!(
        error.to_string().contains("does not name its encoding"),
        "{error}"
    );
    let wide: Vec<u8> = TRAPS.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = read_named("a.vtu", &wide);
    assert!(error.to_string().contains("UTF-16"), "{error}");
}

#[test]
fn files_that_list_others_name_one_of_them() {
    let text = r#"<VTKFile type="PPolyData"><PPolyData><Piece Source="a_0.vtp"/><Piece Source="a_1.vtp"/></PPolyData></VTKFile>"#;
    let error = read_named("a.pvtp", text.as_bytes());
    let words = "holds a PPolyData, which only lists 2 other files, the first of them 'a_0.vtp'";
    assert!(error.to_string().contains(words), "{error}");
    assert!(
        error
            .help()
            .is_some_and(|help| help.contains("give one of these files"))
    );
}

const LEGACY: &str = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n\
    POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n\
    POINT_DATA 4\nSCALARS t float 1\nLOOKUP_TABLE default\n0 1 2 3\n";

#[test]
fn indices_below_0_are_named_as_such() {
    let text = LEGACY.replace("4 0 1 2 3", "4 0 1 2 -1");
    let error = read_bytes("a.vtk", text.into())
        .expect_err("no such point")
        .to_string();
    let words = "the cell uses point -1, but the mesh has points 0 to 3, in a.vtk at cell 0";
    assert!(error.contains(words), "{error}");
}

#[test]
fn bytes_that_are_no_text_end_no_legacy_file_in_silence() {
    let whole = read_bytes("a.vtk", LEGACY.into()).expect("it is a mesh");
    assert_eq!(names(&whole), ["t"]);
    // In place of POINT_DATA: without a word, the field would be missing.
    let at = LEGACY.find("POINT_DATA").expect("it is there");
    let mut bytes = LEGACY.as_bytes().to_vec();
    bytes[at] = 0xff;
    let error = read_bytes("a.vtk", bytes).expect_err("damaged").to_string();
    let words =
        format!("the bytes ff 4f 49 4e 54 5f 44 41 where a word is needed, in a.vtk at byte {at}");
    assert!(error.contains(&words), "{error}");
    // A name may be in any encoding.
    let mut bytes = LEGACY.as_bytes().to_vec();
    bytes[LEGACY.find(" t float").expect("it is there") + 1] = 0xb0;
    assert_eq!(
        names(&read_bytes("a.vtk", bytes).expect("a mesh")),
        ["\u{fffd}"]
    );
}

#[test]
fn structured_grids_have_two_points_along_each_axis() {
    for dimensions in [
        "2 0 3",
        "0 0 0",
        "2 1 3",
        "4294967296 4294967296 4294967296",
    ] {
        let text = format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS {dimensions}\nPOINTS 0 float\n"
        );
        let error = read_bytes("a.vtk", text.into())
            .expect_err("no volume")
            .to_string();
        assert!(error.contains("is no volume"), "{dimensions}: {error}");
    }
}

#[test]
fn fields_are_read_again_from_the_file_in_memory() {
    let data = fixture("lattice-appended-base64-zlib-64.vtu").expect("it is a mesh");
    let array = data
        .arrays
        .iter()
        .find(|a| a.name == "v")
        .expect("it has v");
    let mut numbers = Vec::new();
    array
        .numbers
        .each(&mut |v| numbers.push(v))
        .expect("read before");
    assert_eq!(numbers.len(), 81);
    let z = data.field(Some("v-2")).expect("it has v").values;
    assert!(numbers.chunks_exact(3).map(|v| v[2]).eq(z));
}
