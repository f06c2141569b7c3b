mod blocks;
mod memory;
mod names;

use std::fs;

use super::*;
#[cfg(feature = "lzma")]
use crate::FieldSamples;

fn read_named(name: &str, bytes: &[u8]) -> Error {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("it is writable");
    read_mesh(&path, &ReadOptions::default()).expect_err("it is not a mesh")
}

#[test]
fn unknown_files_are_refused_with_the_formats_that_are_read() {
    let listed = in_words();
    for (name, bytes, words) in [
        (
            "a.png",
            b"\x89PNG\r\n".as_slice(),
            "not a mesh or a grid in a format that is read",
        ),
        ("a.msh", b"hello", "Gmsh"),
        ("a.pvti", b"pieces", "as a .pvti file does"),
        ("a.pvtu", b"pieces", "as a .pvtu file does"),
        ("a.vtu", b"no xml", "does not begin with an XML element"),
        ("a.vtk", b"no vtk", "# vtk DataFile"),
        ("a.html", b"<html></html>", "no <VTKFile> element"),
        ("a.vtu", b"\x1f\x8b\x08", "gzip"),
    ] {
        let error = read_named(name, bytes);
        assert!(error.to_string().contains(words), "{name}: {error}");
        assert!(
            !error.to_string().contains(" at "),
            "of the whole file: {error}"
        );
        assert_eq!(error.help().as_deref(), Some(&*listed));
    }
    for (name, words, help) in [
        ("a.case", "EnSight", "save it as .vtu"),
        ("a.stl", "a surface", "fill it with tetrahedra"),
        (
            "a.img",
            "a file of samples alone",
            "say what is in it with `dims`",
        ),
        ("a.hdf", "not an HDF5 file", "copy or write it again"),
        (
            "a.xdmf",
            "not XML with an <Xdmf> element",
            "copy or write it again",
        ),
    ] {
        let error = read_named(name, b"hello");
        assert!(error.to_string().contains(words), "{name}: {error}");
        assert!(
            error.help().is_some_and(|text| text.starts_with(help)),
            "{name}"
        );
    }
    let error = read_named("a.vtu", b"");
    assert!(error.to_string().contains("the file is empty"), "{error}");
}

#[test]
fn a_missing_file_and_a_folder_are_errors() {
    let missing = read_mesh(Path::new("nowhere.vtu"), &ReadOptions::default());
    assert!(matches!(missing, Err(Error::Io { .. })));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = read_mesh(folder.path(), &ReadOptions::default()).expect_err("a folder");
    assert!(
        folder
            .to_string()
            .contains("a folder is read as a DICOM series"),
        "{folder}"
    );
}

fn fixtures() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(&folder)
        .expect("the fixtures are there")
        .map(|entry| entry.expect("it is readable").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|e| e == "vtu" || e == "vtk" || e == "msh")
        })
        .map(|path| {
            let name = path
                .file_name()
                .expect("it is a file")
                .to_string_lossy()
                .into_owned();
            (name, fs::read(&path).expect("it is readable"))
        })
        .collect();
    files.sort();
    assert!(files.len() >= 47, "{} fixtures", files.len());
    files
}

fn read_bytes(name: &str, bytes: Vec<u8>) -> Result<MeshData, Error> {
    let source = Source {
        path: name.into(),
        bytes,
    };
    let data = if name.ends_with("vtu") {
        vtu::read(source)?
    } else if name.ends_with("msh") {
        FileData::Mesh(gmsh::read(source, None)?)
    } else {
        vtk::read(source)?
    };
    match data {
        FileData::Mesh(mesh) => Ok(mesh),
        // A damaged byte may make it another kind of file.
        FileData::Grid(_) | FileData::Clusters(_) => Err(Error::invalid("a grid")),
    }
}

fn fixture(name: &str) -> Result<MeshData, Error> {
    let (_, bytes) = fixtures()
        .into_iter()
        .find(|(n, _)| n == name)
        .expect("it is a fixture");
    read_bytes(name, bytes)
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    data.field(Some(name))
        .unwrap_or_else(|e| panic!("{e}"))
        .values
}

/// As tests/fixtures/make.py makes it.
fn assert_is_lattice(name: &str, data: &MeshData) {
    assert_eq!(data.points.len(), 27, "{name}");
    assert_eq!(data.cells.types, [10; 40], "{name}");
    assert_eq!(
        data.cells.offsets,
        (0..=40).map(|c| 4 * c).collect::<Vec<u64>>(),
        "{name}"
    );
    assert_eq!(
        data.cells.connectivity[..8],
        [0, 1, 3, 4, 1, 2, 3, 6].map(|p: u64| [0, 1, 4, 3, 9, 10, 13, 12][p as usize]),
        "{name}"
    );
    assert_eq!(data.points[13].to_array(), [1.25, 1.0, 0.75], "{name}");
    let f: Vec<f64> = data
        .points
        .iter()
        .map(|p| p.x + 10.0 * p.y + 100.0 * p.z)
        .collect();
    assert_eq!(values(data, "f"), f, "{name}");
    let vz: Vec<f64> = data.points.iter().map(|p| -p.z).collect();
    assert_eq!(values(data, "v-z"), vz, "{name}");
    let c: Vec<f64> = (0..40).map(f64::from).collect();
    assert_eq!(values(data, "c"), c, "{name}");
    assert_eq!(data.field(None).expect("it has fields").name, "f", "{name}");
}

#[test]
fn every_encoding_gives_the_same_mesh() {
    let mut read = 0;
    for (name, bytes) in fixtures() {
        if name.starts_with("lattice-") {
            let data = read_bytes(&name, bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_is_lattice(&name, &data);
            read += 1;
        }
    }
    assert!(read >= 32, "{read} files");
}

#[test]
fn tetrahedra_of_the_lattice_fill_it() {
    let mesh = fixture("lattice-appended-raw-none-64.vtu")
        .and_then(|data| data.into_mesh(None))
        .expect("it is a mesh");
    assert_eq!(mesh.cell_count(), 40);
    // Moving the middle point leaves the 2×2×2 cube's volume; 40 terms of f64.
    assert!((mesh.volume() - 8.0).abs() < 1e-13);
}

#[test]
fn every_linear_cell_is_read() {
    for name in ["mixed.vtu", "mixed.vtk"] {
        let data = fixture(name).expect("it is a mesh");
        assert_eq!(data.cells.types, [10, 14, 13, 12, 11, 5], "{name}");
        assert_eq!(data.cells.offsets, [0, 4, 9, 15, 23, 31, 34], "{name}");
        assert_eq!(data.cell_counts()[0], (5, 1));
        let mesh = data.into_mesh(Some("x")).expect("it is a mesh");
        // 1/6 + 1/3 + 1/2 + 1 + 1.
        assert!((mesh.volume() - 3.0).abs() < 1e-14, "{name}");
    }
    let curved = fixture("quadratic.vtu").expect("it is a mesh");
    assert_eq!(curved.cells.types, [24]);
    let structured = fixture("structured.vtk").expect("it is a mesh");
    assert_eq!(structured.cells.types, [12; 8]);
    assert_eq!(
        structured.cells.connectivity[..8],
        [0, 1, 4, 3, 9, 10, 13, 12]
    );
}

#[cfg(feature = "lzma")]
#[test]
fn blocks_of_lzma_are_read() {
    assert_is_lattice("lzma.vtu", &fixture("lzma.vtu").expect("it is a mesh"));
    // Two blocks, of which the first is larger than what is unpacked side by side.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let image = read_file(&folder.join("lzma.vti"), &ReadOptions::default());
    let FileData::Grid(grid) = image.expect("it is an image") else {
        panic!("it is not a mesh");
    };
    assert_eq!(grid.fields[0].lattice.dims, [100, 80, 64]);
    let FieldSamples::Loaded(samples) = &grid.fields[0].samples else {
        panic!("it is small");
    };
    for i in 0..samples.len() {
        let [x, y, z] = [i % 100, i / 100 % 80, i / 8000];
        assert_eq!(samples.get(i), ((x + 2 * y + 3 * z) % 251) as f64, "{i}");
    }
}

#[test]
fn what_is_not_read_is_said() {
    let bytes = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/ghosts.vtu"));
    let mut text = String::from_utf8_lossy(&bytes.expect("a fixture")).into_owned();
    text = text.replacen("vtkZLibDataCompressor", "vtkOtherCompressor", 1);
    let error = read_bytes("a.vtu", text.into_bytes()).expect_err("not read");
    let words = "compression with vtkOtherCompressor is not read";
    assert!(error.to_string().contains(words), "{error}");
    let help = "save the file with zlib, LZ4 or no compression";
    assert_eq!(error.help().as_deref(), Some(help));
}

#[test]
fn ghosts_are_left_out() {
    let data = fixture("ghosts.vtu").expect("it is a mesh");
    // Cells 0 and 1 are marked; point 26 is a corner of the last cube alone.
    let all = fixture("lattice-ascii.vtu").expect("it is a mesh");
    let touching = all
        .cells
        .connectivity
        .chunks_exact(4)
        .filter(|c| c.contains(&26))
        .count();
    assert!(touching > 0);
    assert_eq!(data.cells.types.len(), 38 - touching);
    assert_eq!(values(&data, "c")[0], 2.0);
    assert_eq!(
        data.notes,
        [format!(
            "{} cells left out: they are ghosts (duplicate or hidden)",
            2 + touching
        )]
    );
    assert!(data.fields.iter().all(|f| !f.name.contains("Ghost")));
}

#[test]
fn legacy_names_are_decoded_and_texts_passed_over() {
    for name in ["42-ascii", "42-binary", "51-ascii", "51-binary"] {
        let name = format!("identifiers-{name}.vtk");
        let data = fixture(&name).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_is_lattice(&name, &data);
        let numbers: Vec<f64> = (0..27).map(f64::from).collect();
        assert_eq!(values(&data, "my id"), numbers, "{name}");
        assert_eq!(values(&data, "100% of it"), numbers, "{name}");
    }
}

/// A file with every trap of hand-written ones.
const TRAPS: &str = r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">
<PointData Scalars="scalars"><DataArray type="Float32" Name="scalar" Format="ascii">0 1 nan 3</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" Format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" Format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" Format="ascii">4</DataArray>
<DataArray type="Int32" Name="types" Format="ascii">10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>"#;

#[test]
fn hand_written_files_are_read() {
    let data = read_bytes("a.vtu", TRAPS.into()).expect("it is a mesh");
    assert_eq!(data.field(None).expect("it has a field").name, "scalar");
    assert!(values(&data, "scalar")[2].is_nan());
}

#[test]
fn pieces_are_joined() {
    let (start, end) = (
        TRAPS.find("<Piece").expect("it has one"),
        TRAPS.find("</Unst").expect("it ends"),
    );
    let piece = &TRAPS[start..end];
    let empty = r#"<Piece NumberOfPoints="0" NumberOfCells="0"/>"#;
    let other = piece.replace("0 1 nan 3", "5 6 7 8");
    let extra = other.replace(
        "</PointData>",
        r#"<DataArray type="Int8" Name="more" format="ascii">1 2 3 4</DataArray></PointData>"#,
    );
    let text = TRAPS.replace(piece, &format!("{piece}{empty}{extra}"));
    let data = read_bytes("a.vtu", text.into()).expect("it is a mesh");
    assert_eq!(data.cells.connectivity, [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(data.cells.offsets, [0, 4, 8]);
    assert_eq!(values(&data, "scalar")[4..], [5.0, 6.0, 7.0, 8.0]);
    assert_eq!(
        data.notes,
        [
            "2 pieces joined: 4 points lie exactly where others are, and neighbors share faces there",
            "array 'more' left out: piece 1 of 2 has no such array of 1 component"
        ]
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let edited = |from: &str, to: &str| {
        assert!(TRAPS.contains(from), "{from}");
        read_bytes("a.vtu", TRAPS.replace(from, to).into())
            .expect_err(to)
            .to_string()
    };
    for (from, to, words) in [
        (
            ">0 1 2 3<",
            ">0 1 2 9<",
            "value 3 is point 9, but the piece has 4 points, in a.vtu at array 'connectivity'",
        ),
        (
            ">0 1 2 3<",
            ">0 1 2 -3<",
            "value 3 is -3, and indices begin at 0",
        ),
        (">0 1 2 3<", ">0 1 2<", "3 values where 4 are needed"),
        (
            "0 1 nan 3",
            "0 1 nan",
            "3 values where 4 are needed, in a.vtu at array 'scalar'",
        ),
        ("0 1 nan 3", "0 1 x 3", "value 2 is 'x'"),
        (">4<", ">5<", "4 values where 5 are needed"),
        (
            ">0 0 0 1",
            ">0 0 inf 1",
            "its point 0 is at (0, 0, inf), in a.vtu at cell 0",
        ),
        (
            "NumberOfPoints=\"4\"",
            "NumberOfPoints=\"18446744073709551615\"",
            "cannot be",
        ),
        (
            "NumberOfPoints=\"4\"",
            "NumberOfPoints=\"1000000000000\"",
            "12 values where 3000000000000 are needed",
        ),
        (
            "NumberOfPoints=\"4\"",
            "NumberOfPoints=\"four\"",
            "numberofpoints is 'four'",
        ),
        (
            "NumberOfCells=\"1\"",
            "NumberOfCells=\"0\"",
            "the mesh has no cells",
        ),
        (
            "Name=\"types\"",
            "Name=\"kinds\"",
            "there is no array 'types'",
        ),
        ("</VTKFile>", "</Other>", "the XML is damaged"),
        (
            "</Piece></UnstructuredGrid></VTKFile>",
            "",
            "the file ends before </UnstructuredGrid>",
        ),
        (
            "UnstructuredGrid\" version",
            "PolyData\" version",
            "holds a PolyData",
        ),
        ("Float32\" Name=\"scalar", "Float16\" Name=\"scalar", ""),
        (
            "NumberOfComponents=\"3\"",
            "NumberOfComponents=\"99999\"",
            "99999 components; 1 to 64 are read",
        ),
    ] {
        if words.is_empty() {
            // A field of an unknown type is left out with a note.
            let data = read_bytes("a.vtu", TRAPS.replace(from, to).into()).expect("still a mesh");
            assert_eq!(
                data.notes,
                ["array 'scalar' left out: it is of type 'Float16'"]
            );
            assert!(data.fields.is_empty());
            continue;
        }
        let message = edited(from, to);
        assert!(message.contains(words), "{to}: {message}");
    }
}

#[test]
fn arrays_cannot_share_their_bytes() {
    // A thousand arrays of the same bytes would need a thousand times the memory.
    let text = String::from_utf8_lossy(TRAPS.as_bytes()).replace(
        "</PointData>",
        &format!(
            "{}</PointData>",
            (0..1000)
                .map(|i| format!(
                    r#"<DataArray type="UInt8" Name="a{i}" format="appended" offset="0"/>"#
                ))
                .collect::<String>()
        ),
    );
    let text = text.replace(r#"NumberOfPoints="4""#, r#"NumberOfPoints="4096""#);
    let text = text
        .replace("0 1 nan 3", &"0 ".repeat(4096))
        .replace("0 0 0 1 0 0 0 1 0 0 0 1", &"0 0 1 ".repeat(4096));
    let mut bytes = text
        .replace("</VTKFile>", "<AppendedData encoding=\"raw\">_")
        .into_bytes();
    bytes.extend(4096_u32.to_le_bytes());
    bytes.extend([1; 4096]);
    let error = read_bytes("a.vtu", bytes)
        .expect_err("too much")
        .to_string();
    assert!(
        error.contains("its data overlaps that of other arrays"),
        "{error}"
    );
}

#[test]
fn a_compressed_block_cannot_grow_beyond_its_format() {
    let head = TRAPS
        .replace(
            "byte_order",
            "compressor=\"vtkZLibDataCompressor\" byte_order",
        )
        .replace("NumberOfPoints=\"4\"", "NumberOfPoints=\"300000000\"")
        .replace(
            r#"Format="ascii">0 0 0 1 0 0 0 1 0 0 0 1<"#,
            r#"format="appended" offset="0"><"#,
        )
        .replace("</VTKFile>", "<AppendedData encoding=\"raw\">_");
    let mut bytes = head.into_bytes();
    for word in [1_u32, 3_600_000_000, 0, 12] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([0; 12]);
    let error = read_bytes("a.vtu", bytes).expect_err("a bomb").to_string();
    assert!(error.contains("cannot hold 3600000000 bytes"), "{error}");
}

#[test]
fn every_truncation_is_an_error_or_the_whole_mesh() {
    for (name, bytes) in fixtures() {
        let Ok(whole) = read_bytes(&name, bytes.clone()) else {
            continue;
        };
        for length in 0..bytes.len() {
            match read_bytes(&name, bytes[..length].into()) {
                Err(Error::Format { .. }) => {}
                Err(error) => panic!("{name} cut to {length}: {error}"),
                // What is missing may be closing tags, blanks, or, in legacy
                // files, whole arrays or the last digits: the format has no end mark.
                Ok(data) if name.ends_with("vtu") => {
                    let same = data.points == whole.points && data.cells == whole.cells;
                    assert!(same, "{name} cut to {length}");
                    assert_eq!(data.fields, whole.fields, "{name} cut to {length}");
                }
                Ok(data) => assert_eq!(
                    data.cells.types.len(),
                    whole.cells.types.len(),
                    "{name} cut to {length}"
                ),
            }
        }
    }
}

/// A small generator of numbers that look random (Steele, Lea and Flood 2014).
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[test]
fn damaged_files_never_panic_and_keep_the_promises() {
    let mut state = 7;
    let (mut refused, mut read) = (0, 0);
    for (name, bytes) in fixtures() {
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + split_mix(&mut state) % 4 {
                let at = split_mix(&mut state) as usize % damaged.len();
                damaged[at] = match split_mix(&mut state) % 4 {
                    0 => 0xff,
                    1 => b'9',
                    2 => damaged[at] ^ (1 << (split_mix(&mut state) % 8)),
                    _ => split_mix(&mut state) as u8,
                };
            }
            match read_bytes(&name, damaged) {
                Err(Error::Format { what, .. }) => {
                    assert!(!what.is_empty());
                    refused += 1;
                }
                Err(other) => panic!("{name}: {other}"),
                Ok(data) => {
                    // Whatever it is, a mesh can be asked for without a panic.
                    let _ = data.field_list();
                    let _ = data.into_mesh(None);
                    read += 1;
                }
            }
        }
    }
    // Neither is the damage harmless nor everything refused.
    assert!(
        refused > 1000 && read > 1000,
        "{refused} refused, {read} read"
    );
}
