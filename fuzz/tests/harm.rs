//! Input that means harm: what guided fuzzing has kept, and what people have thought of, read
//! on a stable toolchain and in counted memory.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tetrascope::core::Error;
use tetrascope::io::{ReadOptions, is_collection, read_collection, read_file};
use tetrascope::scene::SceneFile;
use tetrascope_fuzz::targets::{Bench, TARGETS};
use tetrascope_fuzz::{PeakAlloc, allowed};

#[path = "harm/grids.rs"]
mod grids;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Memory is counted for the whole process, so that one test at a time may use it.
static TURN: Mutex<()> = Mutex::new(());

/// No input is so large that it may take longer, even where the processor has much else to do.
const LIMIT: Duration = Duration::from_secs(10);

#[test]
fn kept_inputs_are_read_or_refused_in_one_line_and_in_bounded_memory() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let bench = Bench::new().expect("a folder for files");
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpora");
    let mut total = 0;
    for target in &TARGETS {
        let folder = fs::read_dir(corpora.join(target.name)).expect(target.name);
        let mut files: Vec<PathBuf> = folder.map(|file| file.expect("a file").path()).collect();
        files.sort();
        let (mut read, mut refused) = (0, 0);
        for file in &files {
            let bytes = fs::read(file).expect("it is there");
            total += bytes.len();
            let started = Instant::now();
            match bench.run(target, &bytes) {
                Ok(true) => read += 1,
                Ok(false) => refused += 1,
                Err(wrong) => panic!("{}: {wrong}", file.display()),
            }
            assert!(started.elapsed() < LIMIT, "{}: too slow", file.display());
        }
        // Else the target itself is broken.
        let (name, least) = (target.name, 1);
        assert!(read >= least, "{name}: {read} read, {refused} refused");
        assert!(refused >= least, "{name}: {read} read, {refused} refused");
    }
    // Whoever adds to the corpora minimises them: `cargo xtask fuzz --minimise`.
    assert!(total < 1_500_000, "{total} bytes of corpora");
}

// Were memory not counted, the tests here could not fail by it.
#[test]
fn memory_is_counted() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    drop(std::hint::black_box(vec![1u8; 1 << 20]));
    assert!(MEMORY.peak_usage() - before >= 1 << 20);
}

/// Files that belong together; the first is opened.
type Files<'a> = Vec<(&'a str, Vec<u8>)>;

fn open(path: &Path) -> Result<(), Error> {
    let extension = path.extension().unwrap_or_default();
    if is_collection(path) {
        read_collection(path).map(drop)
    } else if extension == "toml" || extension == "json" {
        SceneFile::read(path)?.volume.raw_layout().map(drop)
    } else {
        read_file(path, &ReadOptions::default()).map(drop)
    }
}

/// Checks that `files` are refused in words that hold `words`, in one line, at once and in
/// the memory that is allowed for them.
fn refused(files: &Files, words: &str) {
    let (answer, length, memory) = measured(files);
    assert!(memory <= allowed(length), "{words}: {memory} bytes");
    let error = answer.expect_err(words);
    let text = error.to_string();
    assert!(text.contains(words), "'{words}' is not in: {text}");
    let texts = [Some(text), tetrascope::help(&error)];
    for text in texts.into_iter().flatten() {
        assert!(!text.contains(char::is_control), "{text}");
        assert!(text.chars().count() < 1000, "{text}");
    }
}

/// The answer to opening `files`, which comes at once; their bytes, and those of memory.
fn measured(files: &Files) -> (Result<(), Error>, usize, u64) {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().expect("a folder");
    let mut length = 0;
    for (name, bytes) in files {
        length += bytes.len();
        fs::write(folder.path().join(name), bytes).expect("written");
    }
    let path = folder.path().join(files[0].0);
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let started = Instant::now();
    let answer = open(&path);
    let memory = (MEMORY.peak_usage() - before) as u64;
    assert!(started.elapsed() < LIMIT, "{}: too slow", path.display());
    (answer, length, memory)
}

fn text(name: &str, text: impl Into<String>) -> Files<'_> {
    vec![(name, text.into().into_bytes())]
}

/// 2⁶³ and what overflows when it is multiplied.
const HUGE: [&str; 4] = [
    "9223372036854775807",
    "9223372036854775808",
    "4611686018427387905",
    "18446744073709551615",
];

fn vtu(points: &str, cells: &str, arrays: &str, tail: &str) -> Files<'static> {
    text(
        "a.vtu",
        format!(
            "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt64\"{tail}>\n<UnstructuredGrid>\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">{arrays}</Piece>\
             </UnstructuredGrid></VTKFile>\n"
        ),
    )
}

const TETRAHEDRON: &str = "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">\
    0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>\
    <DataArray type=\"Int64\" Name=\"connectivity\">0 1 2 3</DataArray>\
    <DataArray type=\"Int64\" Name=\"offsets\">4</DataArray>\
    <DataArray type=\"UInt8\" Name=\"types\">10</DataArray></Cells>";

/// A tetrahedron in Gmsh's format 2.2, of which counts may lie.
fn gmsh_22(nodes: &str, elements: &str) -> String {
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
         4 0 0 1\n$EndNodes\n$Elements\n{elements}\n1 4 2 0 1 1 2 3 4\n$EndElements\n"
    )
}

/// The same in format 4.1, with the count in the head of a section and in its block.
fn gmsh_41(nodes: &str, elements: &str) -> String {
    format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {nodes} 1 {nodes}\n3 1 0 {nodes}\n1\n2\n\
         3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 {elements} 1 {elements}\n\
         3 1 4 {elements}\n1 1 2 3 4\n$EndElements\n"
    )
}

// Were these refused as they should be, too, the counts would not be what is refused.
#[test]
fn files_whose_counts_are_right_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, file) in [("a.msh", gmsh_22("4", "1")), ("b.msh", gmsh_41("4", "1"))] {
        fs::write(folder.path().join(name), file).expect("written");
        open(&folder.path().join(name)).expect(name);
    }
}

#[test]
fn netcdf_files_whose_dimensions_cannot_be_true_are_refused() {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fixture = fixture.join("../crates/io/tests/fixtures/lattice-axes.e");
    let whole = fs::read(fixture).expect("a fixture");
    // The length of a dimension comes after its name, padded to 4 bytes.
    for dimension in ["num_nodes", "num_el_in_blk1", "num_nod_per_el1"] {
        let name = dimension.as_bytes();
        let length = (name.len() as u32).to_be_bytes();
        let key = [&length[..], name].concat();
        let at = whole.windows(key.len()).position(|window| window == key);
        let at = (at.expect(dimension) + key.len()).next_multiple_of(4);
        for huge in [u32::MAX, 1 << 31, i32::MAX as u32] {
            let mut file = whole.clone();
            file[at..at + 4].copy_from_slice(&huge.to_be_bytes());
            refused(&vec![("a.e", file)], "a.e at ");
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.e");
    for length in (0..whole.len()).step_by(5) {
        fs::write(&path, &whole[..length]).expect("written");
        open(&path).expect_err("it is truncated");
    }
}

#[test]
fn counts_of_2_to_the_63_are_refused() {
    for huge in HUGE {
        refused(&vtu(huge, "1", TETRAHEDRON, ""), "a.vtu at ");
        refused(&vtu("4", huge, TETRAHEDRON, ""), "a.vtu at ");
        let ends = TETRAHEDRON.replace("\"offsets\">4", &format!("\"offsets\">{huge}"));
        refused(&vtu("4", "1", &ends, ""), "a.vtu at ");
        let corner = TETRAHEDRON.replace("0 1 2 3", &format!("0 1 2 {huge}"));
        refused(&vtu("4", "1", &corner, ""), "a.vtu at ");
        let components = TETRAHEDRON.replace("Components=\"3\"", &format!("Components=\"{huge}\""));
        refused(&vtu("4", "1", &components, ""), "components");
        for section in [
            format!("POINTS {huge} float\n0 0 0\n"),
            format!("POINTS 1 float\n0 0 0\nCELLS {huge} 5\n4 0 0 0 0\n"),
            format!("POINTS 1 float\n0 0 0\nCELLS 1 {huge}\n4 0 0 0 0\n"),
            format!("POINTS 1 float\n0 0 0\nCELLS 1 5\n4 0 0 0 0\nCELL_TYPES {huge}\n10\n"),
            format!(
                "POINTS 1 float\n0 0 0\nCELLS 1 2\n1 0\nCELL_TYPES 1\n10\nPOINT_DATA {huge}\n\
                 SCALARS s float\nLOOKUP_TABLE default\n0\n"
            ),
        ] {
            for kind in ["ASCII", "BINARY"] {
                let head = "# vtk DataFile Version 3.0\nt\n";
                let file = format!("{head}{kind}\nDATASET UNSTRUCTURED_GRID\n{section}");
                refused(&text("a.vtk", file), "a.vtk at ");
            }
        }
        for dims in [format!("{huge} 2 2"), format!("2 2 {huge}")] {
            let file = format!(
                "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n\
                 DIMENSIONS {dims}\nPOINT_DATA {huge}\nSCALARS s float\nLOOKUP_TABLE default\n"
            );
            refused(&text("a.vtk", file), "a.vtk at ");
            let file = format!(
                "ObjectType = Image\nNDims = 3\nDimSize = {dims}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
            );
            refused(&text("a.mha", file), "a.mha at ");
            let file = format!(
                "NRRD0004\ntype: short\ndimension: 3\nsizes: {dims}\nendian: little\nencoding: raw\n\n"
            );
            refused(&text("a.nrrd", file), "a.nrrd at ");
            let scene = format!(
                "version = 1\n[volume]\nfile = \"a.raw\"\ntype = \"f64\"\ndims = [{}]\n",
                dims.replace(' ', ", ")
            );
            refused(&text("a.toml", scene), "");
        }
        let extent = format!("0 {huge} 0 {huge} 0 1");
        let file = format!(
            "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"{extent}\"><Piece Extent=\
             \"{extent}\"><PointData><DataArray type=\"UInt8\" Name=\"s\">0</DataArray>\
             </PointData></Piece></ImageData></VTKFile>"
        );
        refused(&text("a.vti", file), "a.vti at ");
        let skip = format!(
            "NRRD0004\ntype: uchar\nsizes: 2 2 2\nencoding: raw\nbyte skip: {huge}\n\n01234567"
        );
        refused(&text("a.nrrd", skip), "a.nrrd at ");
        let skip = format!(
            "NRRD0004\ntype: uchar\nsizes: 2 2 2\nencoding: raw\nline skip: {huge}\n\n01234567"
        );
        refused(&text("a.nrrd", skip), "a.nrrd at ");
    }
    for huge in HUGE {
        for (nodes, elements) in [(huge, "1"), ("4", huge)] {
            refused(&text("a.msh", gmsh_22(nodes, elements)), "a.msh at ");
            refused(&text("a.msh", gmsh_41(nodes, elements)), "a.msh at ");
        }
        let extent = format!("0 {huge} 0 {huge} 0 {huge}");
        let axes = "<DataArray type=\"UInt8\">0 1</DataArray>".repeat(3);
        let file = format!(
            "<VTKFile type=\"RectilinearGrid\"><RectilinearGrid WholeExtent=\"{extent}\">\
             <Piece Extent=\"{extent}\"><Coordinates>{axes}</Coordinates></Piece>\
             </RectilinearGrid></VTKFile>"
        );
        refused(&text("a.vtr", file), "a.vtr at ");
        let file = format!(
            "<VTKFile type=\"StructuredGrid\"><StructuredGrid WholeExtent=\"{extent}\">\
             <Piece Extent=\"{extent}\"><Points><DataArray type=\"UInt8\" \
             NumberOfComponents=\"3\">0 0 0</DataArray></Points></Piece></StructuredGrid></VTKFile>"
        );
        refused(&text("a.vts", file), "a.vts at ");
        let polyhedron = TETRAHEDRON.replace(">10<", ">42<").replace("</Cells>", "");
        for faces in [
            format!("{huge} 3 0 1 2"),
            format!("4 {huge} 0 1 2"),
            format!("4 3 0 1 {huge} 3 0 1 3 3 1 2 3 3 0 2 3"),
        ] {
            let faces = format!(
                "<DataArray type=\"Int64\" Name=\"faces\">{faces}</DataArray>\
                 <DataArray type=\"Int64\" Name=\"faceoffsets\">17</DataArray></Cells>"
            );
            let file = vtu("4", "1", &format!("{polyhedron}{faces}"), "");
            refused(&file, "a.vtu at ");
        }
    }
    let below = "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"-9223372036854775808 \
        9223372036854775807 0 1 0 1\"><Piece/></ImageData></VTKFile>";
    refused(&text("a.vti", below), "a.vti at ");
}

#[test]
fn counts_of_32_bits_that_overflow_together_are_refused() {
    let words = |numbers: &[i32]| -> Vec<u8> {
        let bytes = numbers.iter().flat_map(|n| n.to_le_bytes());
        bytes.chain([0; 96]).collect()
    };
    for numbers in [
        &[i32::MAX; 3][..],
        &[i32::MAX, i32::MAX, i32::MAX, i32::MAX],
        &[i32::MIN, 2, 2],
        &[1, i32::MAX, i32::MAX, i32::MAX],
        &[-1, -1, -1],
    ] {
        refused(&vec![("a.xyz", words(numbers))], "a.xyz at ");
    }
    let mut nifti = vec![0u8; 352];
    nifti[..4].copy_from_slice(&348i32.to_le_bytes());
    for (i, size) in [
        7,
        i16::MAX,
        i16::MAX,
        i16::MAX,
        i16::MAX,
        i16::MAX,
        i16::MAX,
        i16::MAX,
    ]
    .into_iter()
    .enumerate()
    {
        nifti[40 + 2 * i..][..2].copy_from_slice(&size.to_le_bytes());
    }
    nifti[70] = 64;
    nifti[72] = 64;
    nifti[108..112].copy_from_slice(&352f32.to_le_bytes());
    nifti[344..348].copy_from_slice(b"n+1\0");
    refused(&vec![("a.nii", nifti.clone())], "a.nii at ");
    // Where samples begin, beyond all files.
    nifti[40..48].copy_from_slice(&[3, 0, 2, 0, 2, 0, 2, 0]);
    nifti[108..112].copy_from_slice(&f32::MAX.to_le_bytes());
    refused(&vec![("a.nii", nifti)], "a.nii at ");
}

/// A grid of as many samples along each axis, with appended data, which is `data`.
fn appended(samples: usize, arrays: &str, compressor: &str, data: &[u8]) -> Files<'static> {
    let last = samples - 1;
    let extent = format!("0 {last} 0 {last} 0 {last}");
    let head = format!(
        "<VTKFile type=\"ImageData\" header_type=\"UInt64\"{compressor}><ImageData WholeExtent=\
         \"{extent}\"><Piece Extent=\"{extent}\"><PointData>{arrays}\
         </PointData></Piece></ImageData><AppendedData encoding=\"raw\">_"
    );
    let mut file = head.into_bytes();
    file.extend(data);
    file.extend(b"</AppendedData></VTKFile>");
    vec![("a.vti", file)]
}

const ZLIB: &str = " compressor=\"vtkZLibDataCompressor\"";

fn array(name: usize, offset: u64, kind: &str) -> String {
    format!("<DataArray type=\"{kind}\" Name=\"a{name}\" format=\"appended\" offset=\"{offset}\"/>")
}

#[test]
fn headers_of_binary_data_are_refused_where_they_cannot_be_true() {
    let words =
        |numbers: &[u64]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let samples = 1u64 << 30;
    let one = array(0, 0, "UInt8");
    for length in [u64::MAX, 1 << 63, samples, 0] {
        refused(&appended(1024, &one, "", &words(&[length])), "array 'a0'");
    }
    for header in [
        [u64::MAX, 1, 0, 0],
        [1 << 63, 2, 0, 0],
        [2, 1 << 63, 0, 0],
        [2, samples - 1, 1, u64::MAX],
        [1, samples, 0, 1 << 63],
        [1, samples, 0, 9],
        [samples, 1, 0, 1],
    ] {
        refused(&appended(1024, &one, ZLIB, &words(&header)), "array 'a0'");
    }
    for offset in [1, 1 << 63, u64::MAX] {
        refused(
            &appended(1024, &array(0, offset, "UInt8"), "", &[0]),
            "array 'a0'",
        );
    }
}

#[test]
fn arrays_that_all_lie_at_one_place_are_refused() {
    // A thousand bytes, named a thousand times.
    let arrays: String = (0..1000).map(|i| array(i, 0, "UInt8")).collect();
    let mut data = 1000u64.to_le_bytes().to_vec();
    data.extend([7; 1000]);
    refused(&appended(10, &arrays, "", &data), "array 'a");
    let one = appended(10, &array(0, 0, "UInt8"), "", &data);
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.vti"), &one[0].1).expect("written");
    open(&folder.path().join("a.vti")).expect("one array is right");
}

/// Lists of pieces and of blocks that name `files`.
fn lists(files: &[&str]) -> [(&'static str, Vec<u8>); 5] {
    let entries = |before: &str| -> String {
        let entry = |file: &&str| format!("<{before}=\"{file}\"/>");
        files.iter().map(entry).collect()
    };
    let list = |kind: &str, entries: String| {
        format!("<VTKFile type=\"{kind}\"><{kind}>{entries}</{kind}></VTKFile>").into_bytes()
    };
    let pieces = list("PUnstructuredGrid", entries("Piece Source"));
    let blocks = list("vtkMultiBlockDataSet", entries("DataSet file"));
    let extents = |kind: &str| {
        let entries = entries("Piece Extent=\"0 1 0 1 0 1\" Source");
        let list = list(kind, entries);
        let text = String::from_utf8_lossy(&list);
        let whole = format!("<{kind} WholeExtent=\"0 1 0 1 0 1\">");
        text.replacen(&format!("<{kind}>"), &whole, 1).into_bytes()
    };
    [
        ("a.pvtu", pieces),
        ("a.vtm", blocks),
        ("a.pvti", extents("PImageData")),
        ("a.pvts", extents("PStructuredGrid")),
        ("a.pvtr", extents("PRectilinearGrid")),
    ]
}

#[test]
fn files_that_are_named_again_are_refused() {
    let samples = || ("s.raw", vec![7u8; 4]);
    let mhd = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n";
    let nhdr = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
    for second in ["s.raw", "./s.raw", "././s.raw"] {
        let file = format!("{mhd}ElementDataFile = LIST\ns.raw\n{second}\n");
        let files = vec![("a.mhd", file.into_bytes()), samples()];
        refused(&files, "names this file twice");
        let file = format!("{nhdr}data file: LIST\ns.raw\n{second}\n");
        let files = vec![("a.nhdr", file.into_bytes()), samples()];
        refused(&files, "names this file twice");
    }
    // Lists of lists, and of themselves.
    let entry = "<DataSet timestep=\"0\" file=\"a.pvd\"/>";
    let file = format!("<VTKFile type=\"Collection\"><Collection>{entry}</Collection></VTKFile>");
    refused(&text("a.pvd", file), "lists other files itself");
    let file = "{\"files\": [{\"name\": \"a.series\", \"time\": 0}]}";
    refused(&text("a.series", file), "lists other files itself");
    let mesh = vtu("4", "1", TETRAHEDRON, "").remove(0).1;
    for second in ["s.vtu", "./s.vtu", "././s.vtu"] {
        for (name, list) in lists(&["s.vtu", second]) {
            let files = vec![(name, list), ("s.vtu", mesh.clone())];
            refused(&files, "is listed twice");
        }
    }
    for (name, list) in lists(&["a.pvtu"]).into_iter().take(2) {
        refused(
            &vec![("a.pvtu", list)],
            if name == "a.pvtu" { "" } else { "no mesh" },
        );
    }
}

#[test]
fn names_that_lead_out_of_a_folder_are_refused() {
    let names = [
        "../s1.raw",
        "./../s1.raw",
        "b/../../s1.raw",
        "/dev/zero",
        "/etc/passwd",
        "//s1.raw",
    ];
    let mhd = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n";
    let nhdr = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
    for name in names {
        let words = format!("'{name}' is not in the header's folder");
        for value in [name.to_owned(), format!("LIST\n{name}\n")] {
            let file = format!("{mhd}ElementDataFile = {value}\n");
            refused(&text("a.mhd", file), &words);
            let file = format!("{nhdr}data file: {value}\n");
            refused(&text("a.nhdr", file), &words);
        }
        let numbered = name.replace("s1", "s%d");
        if numbered != name {
            let file = format!("{mhd}ElementDataFile = {numbered} 1 2 1\n");
            refused(&text("a.mhd", file), &words);
            let file = format!("{nhdr}data file: {numbered} 1 2 1\n");
            refused(&text("a.nhdr", file), &words);
        }
        let words = format!("'{name}' is not in the collection's folder");
        let file = format!("{{\"files\": [{{\"name\": \"{name}\"}}]}}");
        refused(&text("a.series", file), &words);
        let entry = format!("<DataSet file=\"{name}\"/>");
        let file =
            format!("<VTKFile type=\"Collection\"><Collection>{entry}</Collection></VTKFile>");
        refused(&text("a.pvd", file), &words);
        for list in lists(&[name]) {
            refused(
                &vec![list],
                "is not in the folder of the file that lists it",
            );
        }
    }
}

/// Two million bytes that could hold 2 GB.
fn packed(head: impl Into<Vec<u8>>) -> Vec<u8> {
    let mut file = head.into();
    file.resize(file.len() + 2_000_000, 0);
    file
}

#[test]
fn small_files_that_would_unpack_to_very_much_are_refused() {
    let words = "which is refused";
    let nrrd = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1250 1250 1250\nencoding: gzip\n\n";
    refused(&vec![("a.nrrd", packed(nrrd))], words);
    let mha = "ObjectType = Image\nNDims = 3\nDimSize = 1250 1250 1250\nElementType = MET_UCHAR\n\
        CompressedData = True\nElementDataFile = LOCAL\n";
    refused(&vec![("a.mha", packed(mha))], words);
    // In several files, each of which holds less.
    let list = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1250 1250 1250\nencoding: gzip\n\
        data file: LIST\ns1.gz\ns2.gz\n";
    let part = || vec![0u8; 1_000_000];
    let files = vec![
        ("a.nhdr", list.as_bytes().to_vec()),
        ("s1.gz", part()),
        ("s2.gz", part()),
    ];
    refused(&files, words);
    // Each array for itself is little enough.
    let header = |blocks: u64| -> Vec<u8> {
        let numbers = [blocks, (1 << 30) / blocks, 0];
        let sizes = vec![1_100_000 / blocks; blocks as usize];
        let numbers = numbers.into_iter().chain(sizes);
        numbers.flat_map(u64::to_le_bytes).collect()
    };
    let arrays = array(0, 0, "UInt8") + &array(1, 0, "UInt8");
    let file = appended(1024, &arrays, ZLIB, &packed(header(1)));
    refused(&file, "array 'a0'");
    let wide = appended(1024, &array(0, 0, "UInt16"), ZLIB, &packed(header(1)));
    refused(&wide, words);
    // An entity that is made of entities that are made of entities.
    let entities = "<!DOCTYPE a [<!ENTITY b \"cccccccc\"><!ENTITY d \"&b;&b;&b;&b;\">]>";
    let file = vtu("&d;", "1", TETRAHEDRON, "");
    let file = [entities.as_bytes(), &file[0].1].concat();
    refused(&vec![("a.vtu", file)], "damaged");
    // Nesting, of which a parser may run out of its stack.
    refused(&text("a.json", "[".repeat(1 << 19)), "");
    refused(&text("a.toml", format!("a = {}", "[".repeat(1 << 19))), "");
    refused(&text("a.toml", format!("[{}a]", "a.".repeat(1 << 18))), "");
    refused(&text("a.series", "[".repeat(1 << 19)), "");
    let elements = "<a>".repeat(1 << 18);
    refused(&vtu("4", "1", &elements, ""), "a.vtu at ");
}

// The blocks of an array are `.xz` files, whose dictionary may be 4 GiB by what they say.
#[test]
fn dictionaries_of_lzma_are_no_larger_than_what_is_unpacked() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/io/tests/fixtures");
    let mut file = fs::read(fixtures.join("lzma.vtu")).expect("a fixture");
    let magic = b"\xfd7zXZ\0";
    let begins = |at: &usize| file[*at..].starts_with(magic);
    let blocks: Vec<usize> = (0..file.len()).filter(begins).collect();
    assert!(blocks.len() > 5, "{} blocks", blocks.len());
    for at in blocks {
        let header = at + 12;
        let length = 4 * usize::from(file[header]);
        let filter = file[header..header + length]
            .windows(2)
            .position(|w| w == [0x21, 1]);
        file[header + filter.expect("LZMA2") + 2] = 40;
        let mut sum = flate2::Crc::new();
        sum.update(&file[header..header + length]);
        file[header + length..][..4].copy_from_slice(&sum.sum().to_le_bytes());
    }
    let (answer, length, memory) = measured(&vec![("a.vtu", file)]);
    answer.expect("a mesh");
    assert!(memory <= allowed(length), "{memory} bytes");
}

// Three axes of some thousand numbers stand for as many points as their product.
#[test]
fn axes_that_stand_for_very_many_points_are_refused() {
    for samples in [600, 5000] {
        // Not even, so that the grid is a mesh.
        let numbers: Vec<String> = (0..samples).map(|i| (i * i).to_string()).collect();
        let axis = format!(
            "<DataArray type=\"Float32\">{}</DataArray>",
            numbers.join(" ")
        );
        let last = samples - 1;
        let extent = format!("0 {last} 0 {last} 0 {last}");
        let file = format!(
            "<VTKFile type=\"RectilinearGrid\"><RectilinearGrid WholeExtent=\"{extent}\">\
             <Piece Extent=\"{extent}\"><Coordinates>{}</Coordinates></Piece>\
             </RectilinearGrid></VTKFile>",
            axis.repeat(3)
        );
        refused(&text("a.vtr", file), "a.vtr at ");
    }
}
