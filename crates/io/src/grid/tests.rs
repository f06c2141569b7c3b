mod cells;
#[cfg(feature = "dicom")]
mod dicom;
mod frames;
mod programs;
mod worlds;

use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use proptest::prelude::*;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::RawNumber;
use tetrascope_core::grid::{BrickSource, Interpolation, Region, SampleType};

use super::*;
use crate::{FileData, ReadOptions, read_file};

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    folder
}

fn read_with(path: &Path, options: &ReadOptions) -> Result<GridData, Error> {
    match read_file(path, options)? {
        FileData::Grid(grid) => Ok(grid),
        FileData::Mesh(_) | FileData::Clusters(_) => panic!("{} is not a mesh", path.display()),
    }
}

fn read(files: &[(&str, &[u8])]) -> Result<GridData, Error> {
    let folder = folder(files);
    read_with(&folder.path().join(files[0].0), &ReadOptions::default())
}

/// The first field of a grid that is fine.
fn first(files: &[(&str, &[u8])]) -> (Lattice, Samples) {
    let data = read(files).unwrap_or_else(|error| panic!("{error}"));
    loaded(&data, 0)
}

fn loaded(data: &GridData, field: usize) -> (Lattice, Samples) {
    match &data.fields[field].samples {
        FieldSamples::Loaded(samples) => (data.fields[field].lattice, samples.clone()),
        FieldSamples::Streamed(_) => panic!("small grids are read"),
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("in memory");
    encoder.finish().expect("in memory")
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("in memory");
    encoder.finish().expect("in memory")
}

fn join(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

/// 24 samples as little-endian bytes, and themselves.
fn shorts() -> (Vec<u8>, Samples) {
    let values: Vec<i16> = (0..24).map(|i| i * 91 - 1000).collect();
    let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    (bytes, Samples::I16(values))
}

const MHD: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\n\
    TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\n\
    ElementSpacing = 0.5 2 3\nDimSize = 2 3 4\nElementType = MET_SHORT\n";

#[test]
fn meta_images_in_one_file_and_two() {
    let (bytes, samples) = shorts();
    let local = join(&[MHD.as_bytes(), b"ElementDataFile = LOCAL\n", &bytes]);
    let beside = format!("{MHD}ElementDataFile = a.raw\n");
    let packed = join(&[
        MHD.as_bytes(),
        b"CompressedData = True\nElementDataFile = LOCAL\n",
        &zlib(&bytes),
    ]);
    let swapped: Vec<u8> = bytes.chunks(2).flat_map(|b| [b[1], b[0]]).collect();
    let big = format!("{MHD}BinaryDataByteOrderMSB = True\nElementDataFile = a.raw\n");
    let tail = format!("{MHD}HeaderSize = -1\nElementDataFile = a.raw\n");
    let text: String = (0..24).map(|i| format!("{} ", i * 91 - 1000)).collect();
    let words = format!("{MHD}BinaryData = False\nElementDataFile = LOCAL\n{text}");
    let cases: [&[(&str, &[u8])]; 6] = [
        &[("a.mha", &local)],
        &[("a.mhd", beside.as_bytes()), ("a.raw", &bytes)],
        &[("a.mha", &packed)],
        &[("a.mhd", big.as_bytes()), ("a.raw", &swapped)],
        &[
            ("a.mhd", tail.as_bytes()),
            ("a.raw", &join(&[b"header", &bytes])),
        ],
        &[("a.mha", words.as_bytes())],
    ];
    for files in cases {
        let (lattice, found) = first(files);
        assert_eq!(found, samples);
        assert_eq!(lattice.dims, [2, 3, 4]);
        assert_eq!(lattice.origin, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(lattice.spacing, DVec3::new(0.5, 2.0, 3.0));
        // The first three numbers are the direction of the first axis.
        let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        assert_eq!(lattice.direction, turn);
    }
    let data = read(&[("a.mhd", beside.as_bytes()), ("a.raw", &bytes)]).expect("fine");
    assert_eq!(data.files.len(), 2);
}

#[test]
fn nrrds_attached_detached_and_in_slices() {
    let (bytes, samples) = shorts();
    let fields = "type: short\ndimension: 3\nsizes: 2 3 4\nendian: little\n\
        space directions: (0.5,0,0) (0,-2,0) (0,0,3)\nspace origin: (1,2,3)\n";
    let attached = |encoding: &str, data: &[u8]| {
        let head = format!("NRRD0004\n# a comment\n{fields}encoding: {encoding}\nkey:=value\n\n");
        join(&[head.as_bytes(), data])
    };
    let text: String = (0..24).map(|i| format!("{}\n", i * 91 - 1000)).collect();
    let detached = |name: &str| format!("NRRD0005\n{fields}encoding: raw\ndata file: {name}\n");
    let slices: Vec<&[u8]> = bytes.chunks(12).collect();
    let listed = format!("NRRD0004\n{fields}encoding: gzip\ndata file: LIST\nx\ny\n");
    let (x, y) = (gzip(&bytes[..24]), gzip(&bytes[24..]));
    let raw = attached("raw", &bytes);
    let gz = attached("gzip", &gzip(&bytes));
    let words = attached("ascii", text.as_bytes());
    let tail = attached("raw\nbyte skip: -1", &join(&[b"  ", &bytes]));
    let skip = attached("raw\nbyte skip: 2", &join(&[b"  ", &bytes]));
    let skip_packed = attached("gz\nbyte skip: 2", &gzip(&join(&[b"  ", &bytes])));
    let pattern = detached("s.%02d 7 10 1");
    let beside = detached("b.raw");
    let cases: [&[(&str, &[u8])]; 9] = [
        &[("a.nrrd", &raw)],
        &[("a.nrrd", &gz)],
        &[("a.nrrd", &words)],
        &[("a.nrrd", &tail)],
        &[("a.nrrd", &skip)],
        &[("a.nrrd", &skip_packed)],
        &[("a.nhdr", beside.as_bytes()), ("b.raw", &bytes)],
        &[
            ("a.nhdr", pattern.as_bytes()),
            ("s.07", slices[0]),
            ("s.08", slices[1]),
            ("s.09", slices[2]),
            ("s.10", slices[3]),
        ],
        &[("a.nhdr", listed.as_bytes()), ("x", &x), ("y", &y)],
    ];
    for files in cases {
        let (lattice, found) = first(files);
        assert_eq!(found, samples, "{}", files[0].0);
        assert_eq!(lattice.spacing, DVec3::new(0.5, 2.0, 3.0));
        assert_eq!(lattice.direction.y_axis, DVec3::NEG_Y);
        assert_eq!(lattice.origin, DVec3::new(1.0, 2.0, 3.0));
    }
    // Components first, spacings in place of directions.
    let vector = b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 2 2\nspacings: nan 1 2 3\n\
        axis mins: nan 5 6 7\nencoding: raw\n\n\x03\x04\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01";
    let data = read(&[("a.nrrd", vector)]).expect("fine");
    let names: Vec<&str> = data.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["scalars-magnitude", "scalars-0", "scalars-1"]);
    let (lattice, magnitude) = loaded(&data, 0);
    assert_eq!((magnitude.get(0), magnitude.len()), (5.0, 8));
    assert_eq!(lattice.origin, DVec3::new(5.0, 6.0, 7.0));
    assert_eq!(lattice.spacing, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(loaded(&data, 2).1.get(0), 4.0);
}

/// A NIfTI header for 2×3×4 shorts, changed by `change`.
fn nifti(change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut header = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, size) in [3_i16, 2, 3, 4, 1].into_iter().enumerate() {
        put(40 + 2 * i, &size.to_le_bytes());
    }
    put(70, &4_i16.to_le_bytes());
    for (i, step) in [1.0_f32, 0.5, 2.0, 3.0].into_iter().enumerate() {
        put(76 + 4 * i, &step.to_le_bytes());
    }
    put(108, &352_f32.to_le_bytes());
    put(344, b"n+1\0");
    change(&mut header);
    header
}

#[test]
fn niftis_plain_packed_turned_and_scaled() {
    let (bytes, samples) = shorts();
    let float = |header: &mut [u8], at: usize, value: f32| {
        header[at..at + 4].copy_from_slice(&value.to_le_bytes());
    };
    let plain = join(&[&nifti(|_| {}), &bytes]);
    let (lattice, found) = first(&[("a.nii", &plain)]);
    assert_eq!(
        (lattice.spacing, found),
        (DVec3::new(0.5, 2.0, 3.0), samples.clone())
    );
    let (_, found) = first(&[("a.nii.gz", &gzip(&plain))]);
    assert_eq!(found, samples);

    // sform: the first axis leads to −y, the second to x.
    let turned = nifti(|h| {
        h[254] = 1;
        for (at, value) in [
            (284, 2.0),
            (292, 10.0),
            (296, -0.5),
            (308, 20.0),
            (320, 3.0),
        ] {
            float(h, at, value);
        }
    });
    let (lattice, _) = first(&[("a.nii", &join(&[&turned, &bytes]))]);
    // From RAS to LPS: x and y turned round.
    assert_eq!(
        lattice.direction,
        DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z)
    );
    assert_eq!(lattice.origin, DVec3::new(-10.0, -20.0, 0.0));

    // qform: half a turn about z, the third axis mirrored.
    let half = nifti(|h| {
        h[252] = 1;
        float(h, 264, 1.0);
        float(h, 268, 7.0);
        float(h, 76, -1.0);
    });
    let (lattice, _) = first(&[("a.nii", &join(&[&half, &bytes]))]);
    let mirrored = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    assert_eq!(lattice.direction, mirrored);
    assert_eq!(lattice.origin, DVec3::new(-7.0, 0.0, 0.0));

    let scaled = nifti(|h| {
        float(h, 112, 2.0);
        float(h, 116, -1.0);
    });
    let data = read(&[("a.nii", &join(&[&scaled, &bytes]))]).expect("fine");
    assert_eq!(loaded(&data, 0).1.get(3), samples.get(3) * 2.0 - 1.0);
    assert!(
        data.notes
            .contains(&"stored samples are scaled by 2 and moved by -1".into()),
        "{:?}",
        data.notes
    );
}

#[test]
fn vtk_images_in_one_piece_and_several() {
    let xml = |pieces: &str| {
        format!(
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
             <ImageData WholeExtent=\"1 2 0 1 -1 1\" Origin=\"10 20 30\" Spacing=\"1 2 3\" \
             Direction=\"0 -1 0 1 0 0 0 0 1\">{pieces}</ImageData></VTKFile>"
        )
    };
    let array = |text: &str| {
        format!(
            "<PointData Scalars=\"b\"><DataArray type=\"Float64\" Name=\"a\" format=\"ascii\">{text}\
             </DataArray><DataArray type=\"UInt16\" Name=\"b\" format=\"ascii\">{text}</DataArray></PointData>"
        )
    };
    let one = xml(&format!(
        "<Piece Extent=\"1 2 0 1 -1 1\">{}</Piece>",
        array("0 1 2 3 4 5 6 7 8 9 10 11")
    ));
    let two = xml(&format!(
        "<Piece Extent=\"1 2 0 1 -1 0\">{}</Piece><Piece Extent=\"1 2 0 1 0 1\">{}</Piece>",
        array("0 1 2 3 4 5 6 7"),
        array("4 5 6 7 8 9 10 11")
    ));
    for text in [one, two] {
        let data = read(&[("a.vti", text.as_bytes())]).unwrap_or_else(|e| panic!("{e}"));
        // The active array comes first, and keeps its type.
        assert_eq!(data.fields[0].name, "b");
        let (lattice, samples) = loaded(&data, 0);
        assert_eq!(samples, Samples::U16((0..12).collect()));
        assert_eq!(
            loaded(&data, 1).1,
            Samples::F32((0..12_u8).map(f32::from).collect())
        );
        assert_eq!(lattice.dims, [2, 2, 3]);
        // Rows of the matrix: x leads to y, and sample (1, 0, −1) is the first.
        assert_eq!(
            lattice.direction,
            DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z)
        );
        assert_eq!(lattice.origin, DVec3::new(10.0, 21.0, 27.0));
    }
    let cells = "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 2 0 2 0 2\"><Piece>\
        <CellData><DataArray type=\"UInt8\" Name=\"c\" format=\"ascii\">1 2 3 4 5 6 7 8</DataArray>\
        <DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">0 32 0 0 0 0 0 0</DataArray>\
        </CellData></Piece></ImageData></VTKFile>";
    let data = read(&[("a.vti", cells.as_bytes())]).unwrap_or_else(|e| panic!("{e}"));
    let (lattice, samples) = loaded(&data, 0);
    assert_eq!((lattice.dims, lattice.origin), ([2; 3], DVec3::splat(0.5)));
    assert_eq!(lattice.interpolation, Interpolation::Nearest);
    let whole = lattice.bounds();
    assert_eq!((whole.min, whole.max), (DVec3::ZERO, DVec3::splat(2.0)));
    assert_eq!(data.notes, ["1 cell hidden by vtkGhostType"]);
    assert!(samples.get(0) == 1.0 && samples.get(1).is_nan() && data.fields.len() == 1);
}

#[test]
fn structured_points_in_words_and_bytes() {
    let head = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\n\
        DIMENSIONS 2 3 2\nORIGIN 1 2 3\nSPACING 0.5 -1 2\nPOINT_DATA 12\nSCALARS s short\n\
        LOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\n";
    let (lattice, samples) = first(&[("a.vtk", head.as_bytes())]);
    assert_eq!(samples, Samples::I16((0..12).collect()));
    assert_eq!(lattice.spacing, DVec3::new(0.5, 1.0, 2.0));
    assert_eq!(lattice.direction.y_axis, DVec3::NEG_Y);
    let head = head
        .replace("ASCII", "BINARY")
        .replace("SPACING", "ASPECT_RATIO");
    let (head, _) = head.split_once("0 1 2 3").expect("the numbers");
    let bytes: Vec<u8> = (0..12_i16).flat_map(i16::to_be_bytes).collect();
    let (again, samples) = first(&[("a.vtk", &join(&[head.as_bytes(), &bytes]))]);
    assert_eq!(samples, Samples::I16((0..12).collect()));
    assert_eq!(lattice, again);
}

fn layout(number: RawNumber) -> RawLayout {
    RawLayout {
        lattice: Lattice {
            dims: [2, 3, 4],
            origin: DVec3::ZERO,
            spacing: DVec3::new(1.0, 1.0, 2.0),
            direction: DMat3::IDENTITY,
            interpolation: Interpolation::Linear,
        },
        number,
        offset: 3,
        byte_order: ByteOrder::Little,
    }
}

#[test]
fn raw_files_whole_and_streamed() {
    let (bytes, samples) = shorts();
    let folder = folder(&[("a.raw", &join(&[b"abc", &bytes, b"more"]))]);
    let path = folder.path().join("a.raw");
    let mut options = ReadOptions {
        raw: Some(layout(RawNumber::I16)),
        ..ReadOptions::default()
    };
    let data = read_with(&path, &options).expect("fine");
    assert_eq!(loaded(&data, 0).1, samples);
    assert!(data.notes[0].contains("4 bytes"), "{:?}", data.notes);

    options.stream_above = 47;
    let data = read_with(&path, &options).expect("fine");
    let FieldSamples::Streamed(stream) = &data.fields[0].samples else {
        panic!("48 bytes are too many");
    };
    assert_eq!(stream.scalar_range(), samples.range());
    assert_eq!(stream.source().sample_type(), SampleType::I16);
    let region = Region {
        low: [1, 1, 2],
        size: [1, 2, 2],
    };
    let part = stream.source().read(region).expect("inside");
    let all = [15, 17, 21, 23].map(|i| samples.get(i) as i16);
    assert_eq!(part, Samples::I16(all.to_vec()));
    let (volume, _) = data.into_volume(None).expect("one field");
    assert_eq!(volume.cell_count(), 6);

    options.raw = Some(layout(RawNumber::F64));
    let error = read_with(&path, &options)
        .expect_err("too short")
        .to_string();
    assert!(
        error.contains("192 bytes") || error.contains("195 bytes"),
        "{error}"
    );
}

/// Parts of every shape, whichever way they are read: in one piece, layer by layer with what
/// lies between rows, or row by row.
#[test]
fn streamed_parts_are_those_of_the_whole() {
    let dims = [100, 5, 4];
    let bytes: Vec<u8> = (0..2000_u32).map(|i| (i * 7 % 251) as u8).collect();
    let folder = folder(&[("a.raw", &bytes)]);
    let lattice = Lattice {
        dims,
        origin: DVec3::ZERO,
        spacing: DVec3::ONE,
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Linear,
    };
    let path = folder.path().join("a.raw");
    let file = RawFile::open(&path, 0, lattice, SampleType::U8, ByteOrder::Little);
    let file = file.expect("long enough");
    let grid = Grid::on(lattice, Samples::U8(bytes)).expect("as many as needed");
    for (low, size) in [
        ([0, 0, 1], [100, 5, 2]),
        ([0, 2, 3], [100, 2, 1]),
        ([0, 1, 1], [100, 3, 2]),
        ([7, 1, 0], [20, 3, 4]),
        ([99, 4, 1], [1, 1, 3]),
        ([98, 0, 0], [2, 5, 4]),
    ] {
        let region = Region { low, size };
        let part = file.read(region).expect("inside");
        assert_eq!(
            part,
            BrickSource::read(&grid, region).expect("inside"),
            "{region:?}"
        );
    }
}

/// VTK's images, raw and of one piece, whole and streamed; others are read whole.
#[test]
fn vtk_images_stay_in_their_files() {
    let (little, samples) = shorts();
    let big: Vec<u8> = little.chunks(2).flat_map(|b| [b[1], b[0]]).collect();
    let xml = |order: &str, header: &str, more: &str| {
        format!(
            "<VTKFile type=\"ImageData\" byte_order=\"{order}\" header_type=\"{header}\">\
             <ImageData WholeExtent=\"1 2 0 2 0 3\" Origin=\"5 6 7\" Spacing=\"1 2 3\">\
             <Piece Extent=\"1 2 0 2 0 3\"><PointData Scalars=\"s\">\
             <DataArray type=\"Int16\" Name=\"t\" format=\"appended\" offset=\"OTHER\"/>\
             <DataArray type=\"Int16\" Name=\"s\" format=\"appended\" offset=\"0\"/>\
             </PointData>{more}</Piece></ImageData><AppendedData encoding=\"raw\">\n _"
        )
    };
    let zeros = [0; 48];
    let wide = xml("LittleEndian", "UInt64", "").replace("OTHER", "56");
    let narrow = xml("BigEndian", "UInt32", "").replace("OTHER", "52");
    let cells = "<CellData><DataArray type=\"UInt8\" Name=\"c\" format=\"ascii\">1 2 3 4 5 6\
                 </DataArray></CellData>";
    let with_cells = xml("LittleEndian", "UInt64", cells).replace("OTHER", "56");
    let count = 48_u64.to_le_bytes();
    let of_wide = [&count[..], &little, &count, &zeros].concat();
    let count = 48_u32.to_be_bytes();
    let of_narrow = [&count[..], &big, &count, &zeros].concat();
    let vtk = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 4\n\
               ORIGIN 6 6 7\nSPACING 1 2 3\nPOINT_DATA 24\nSCALARS s short\nLOOKUP_TABLE default\n";
    let two = [
        vtk.as_bytes(),
        &big,
        b"\nSCALARS u short\nLOOKUP_TABLE default\n",
        &zeros,
    ]
    .concat();
    let metadata = "\nMETADATA\nCOMPONENT_NAMES 0\n\n";
    for (name, contents, streams) in [
        ("a.vti", [wide.as_bytes(), &of_wide].concat(), true),
        ("b.vti", [narrow.as_bytes(), &of_narrow].concat(), true),
        ("c.vti", [with_cells.as_bytes(), &of_wide].concat(), false),
        ("d.vtk", [vtk.as_bytes(), &big].concat(), true),
        (
            "e.vtk",
            [vtk.as_bytes(), &big, metadata.as_bytes()].concat(),
            true,
        ),
        ("f.vtk", two, false),
    ] {
        let folder = folder(&[(name, &contents)]);
        let path = folder.path().join(name);
        let read = |stream_above| {
            let options = ReadOptions {
                stream_above,
                ..ReadOptions::default()
            };
            read_with(&path, &options).unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        let (whole, parts) = (read(1 << 20), read(47));
        let field = &parts.fields[0];
        assert_eq!(
            (field.name.as_str(), &parts.files),
            ("s", &vec![path.clone()])
        );
        assert_eq!(field.lattice.origin, DVec3::new(6.0, 6.0, 7.0), "{name}");
        assert_eq!(field.lattice, whole.fields[0].lattice, "{name}");
        assert_eq!(parts.fields.len(), whole.fields.len(), "{name}");
        assert_eq!(loaded(&whole, 0).1, samples, "{name}");
        match &field.samples {
            FieldSamples::Streamed(stream) => {
                assert!(streams, "{name}");
                let region = Region {
                    low: [0; 3],
                    size: [2, 3, 4],
                };
                assert_eq!(
                    stream.source().read(region).expect("inside"),
                    samples,
                    "{name}"
                );
            }
            FieldSamples::Loaded(_) => assert!(!streams, "{name}"),
        }
        // A file that ends too soon says so, as when it is read whole.
        std::fs::write(&path, &contents[..contents.len() - 60]).expect("written");
        let options = ReadOptions {
            stream_above: 47,
            ..ReadOptions::default()
        };
        assert!(read_with(&path, &options).is_err(), "{name}");
    }
}

#[test]
fn mistakes_are_one_line_that_says_where() {
    let (bytes, _) = shorts();
    let of = |files: &[(&str, &[u8])]| {
        let error = read(files).expect_err("a mistake").to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    };
    let local = |head: &str| join(&[head.as_bytes(), b"ElementDataFile = LOCAL\n", &bytes]);
    let mhd = |from: &str, to: &str| of(&[("a.mha", &local(&MHD.replace(from, to)))]);
    assert!(mhd("2 3 4", "2 3").contains("'DimSize' has 2 numbers"));
    assert!(mhd("2 3 4", "2 3 5").contains("60 bytes"));
    assert!(mhd("2 3 4", "2 3 1").contains("at least 2 samples"));
    assert!(mhd("2 3 4", "99999999 99999999 99999999").contains("a.mha"));
    assert!(mhd("MET_SHORT", "MET_STRING").contains("line 8"));
    assert!(mhd("NDims = 3", "NDims = 2").contains("'DimSize' has 3 numbers"));
    let picture = MHD
        .replace("NDims = 3", "NDims = 2")
        .replace("2 3 4", "2 3");
    assert!(of(&[("a.mha", &local(&picture))]).contains("two spatial axes"));
    assert!(mhd("0 1 0 -1 0 0 0 0 1", "1 1 0 0 1 0 0 0 1").contains("shear"));
    assert!(
        of(&[(
            "a.mhd",
            format!("{MHD}ElementDataFile = no.raw\n").as_bytes()
        )])
        .contains("no.raw")
    );
    // A few bytes that claim to be 2⁴⁰ samples, packed.
    let bomb = b"NRRD0004\ntype: uchar\nsizes: 16384 16384 4096\nencoding: gzip\n\nabc";
    assert!(of(&[("a.nrrd", bomb)]).contains("1099511627776"));
    let sheared = b"NRRD0004\ntype: uchar\nsizes: 2 2 2\nspace directions: (1,0,0) (1,1,0) (0,0,1)\nencoding: raw\n\n12345678";
    assert!(of(&[("a.nrrd", sheared)]).contains("shear"));
    let wild = b"NRRD0004\ntype: uchar\nsizes: 2 2 2\nencoding: raw\ndata file: x%d 1 99999999 1\n";
    assert!(of(&[("a.nhdr", wild)]).contains("files from 1"));
    assert!(of(&[("a.nii", &nifti(|h| h[70] = 99))]).contains("type 99"));
    assert!(of(&[("a.nii", &nifti(|_| {}))]).contains("48 bytes"));
    assert!(of(&[("a.raw", &bytes)]).contains("a file of samples alone"));
    let unreadable = Path::new("/no/such.mha");
    assert!(matches!(
        read_with(unreadable, &ReadOptions::default()),
        Err(Error::Io { .. })
    ));
}

/// Files of each format, small and whole.
fn whole() -> Vec<(&'static str, Vec<u8>)> {
    let (bytes, _) = shorts();
    let nrrd = b"NRRD0004\ntype: short\nsizes: 2 3 4\nendian: little\nencoding: gzip\n\n";
    let vtk = b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 4\nPOINT_DATA 24\nSCALARS s short\nLOOKUP_TABLE default\n";
    let vti = "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\" Spacing=\"1 1 1\"><Piece Extent=\"0 1 0 1 0 1\"><PointData><DataArray type=\"UInt8\" Name=\"c\" format=\"ascii\">1 2 3 4 5 6 7 8</DataArray></PointData></Piece></ImageData></VTKFile>";
    vec![
        (
            "a.mha",
            join(&[MHD.as_bytes(), b"ElementDataFile = LOCAL\n", &bytes]),
        ),
        ("a.nrrd", join(&[nrrd, &gzip(&bytes)])),
        ("a.nii", join(&[&nifti(|_| {}), &bytes])),
        ("a.nii.gz", gzip(&join(&[&nifti(|_| {}), &bytes]))),
        ("a.vtk", join(&[vtk, &bytes])),
        ("a.vti", vti.as_bytes().to_vec()),
    ]
}

proptest! {
    // Every file that was cut or changed is read or refused; nothing else happens.
    #[test]
    fn damaged_files_are_read_or_refused(
        file in 0..6_usize,
        cut in 0.0..1.2_f64,
        changes in proptest::collection::vec((0.0..1.0_f64, any::<u8>()), 0..6),
    ) {
        let (name, mut bytes) = whole().swap_remove(file);
        for (place, byte) in changes {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        if let Ok(data) = read(&[(name, &bytes)]) {
            let (lattice, samples) = loaded(&data, 0);
            prop_assert_eq!(lattice.validate().expect("checked"), samples.len());
        }
    }
}

#[test]
fn whole_files_are_read() {
    for (name, bytes) in whole() {
        let (_, samples) = first(&[(name, &bytes)]);
        assert!(samples.len() == 24 || name == "a.vti", "{name}");
    }
}
