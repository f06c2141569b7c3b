//! Files of other programs, and what these read in them: see `make_grids.py` beside the fixtures.

use serde_json::{Map, Value};

use super::*;
use crate::MeshData;

fn fixture(name: &str) -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/grids");
    folder.join(name)
}

fn read_fixture(name: &str, options: &ReadOptions) -> GridData {
    read_with(&fixture(name), options).unwrap_or_else(|error| panic!("{error}"))
}

/// For each file, each field's samples, `[x, y, z, value]`.
fn expected() -> Map<String, Value> {
    let text = std::fs::read_to_string(fixture("expected.json")).expect("a fixture");
    let mut files: Map<String, Value> =
        serde_json::from_str(&text).expect("as the script writes it");
    assert!(files.len() > 60, "{} files", files.len());
    files.retain(|name, _| is_read(name));
    files
}

/// Whether the features that are on read the file of this name.
fn is_read(name: &str) -> bool {
    cfg!(feature = "tiff") || !name.ends_with(".tif")
}

/// Samples by position, ordered.
type Samples4 = Vec<[f64; 4]>;

fn ordered(mut samples: Samples4) -> Samples4 {
    // Positions of these files differ by a tenth and more, or by rounding.
    samples.sort_by_key(|[x, y, z, _]| [x, y, z].map(|c| (c * 20.0).round() as i64));
    samples
}

fn samples_of(field: &GridField) -> Samples4 {
    let [nx, ny, nz] = field.lattice.dims;
    let all = Region {
        low: [0; 3],
        size: [nx, ny, nz],
    };
    let samples = match &field.samples {
        FieldSamples::Loaded(samples) => samples.clone(),
        FieldSamples::Streamed(stream) => stream.source().read(all).expect("all are there"),
    };
    let sample = |i: usize| {
        let index = [i % nx, i / nx % ny, i / (nx * ny)].map(|n| n as f64);
        let [x, y, z] = field.lattice.point(DVec3::from_array(index)).to_array();
        [x, y, z, samples.get(i) + field.offset]
    };
    assert_eq!(samples.len(), nx * ny * nz);
    ordered((0..samples.len()).map(sample).collect())
}

/// The values of a mesh's field, at its points or at the means of its cells' corners. Pieces of a
/// mesh have points and cells of their own where they meet or overlap, which count once.
fn values_of(data: &MeshData, name: &str) -> Samples4 {
    let field = data.field(Some(name)).expect("it is listed");
    let center = |range: &[u64]| {
        let corners = &data.cells.connectivity[range[0] as usize..range[1] as usize];
        let sum: DVec3 = corners.iter().map(|i| data.points[*i as usize]).sum();
        sum / corners.len() as f64
    };
    let places: Vec<DVec3> = match field.association {
        Association::Point => data.points.clone(),
        Association::Cell => data.cells.offsets.windows(2).map(center).collect(),
    };
    assert_eq!(places.len(), field.values.len());
    let rows = places.iter().zip(&field.values);
    let mut rows = ordered(rows.map(|(p, value)| [p.x, p.y, p.z, *value]).collect());
    rows.dedup_by(|a, b| (0..4).all(|i| (a[i] - b[i]).abs() < 1e-9));
    rows
}

/// Compares what is read with what the file's own program reads, field by field.
pub(super) fn compare(data: &FileData, fields: &Value) -> Result<(), String> {
    let fields = fields.as_object().expect("fields");
    let own: Vec<(&str, Samples4)> = match data {
        FileData::Grid(data) => {
            let fields = data.fields.iter();
            fields.map(|f| (f.name.as_str(), samples_of(f))).collect()
        }
        FileData::Mesh(data) => {
            let names = ["p", "c"];
            assert_eq!(data.fields.len(), names.len());
            names.map(|field| (field, values_of(data, field))).into()
        }
        FileData::Clusters(_) => panic!("no other program writes clusters"),
    };
    let mut names: Vec<&str> = own.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    let mut others: Vec<&String> = fields.keys().collect();
    others.sort_unstable();
    if names != others {
        return Err(format!("fields {names:?} for {others:?}"));
    }
    for (field, own) in own {
        let rows = fields[field].as_array().expect("rows").iter();
        let row = |row: &Value| [0, 1, 2, 3].map(|i| row[i].as_f64().expect("a number"));
        let others = ordered(rows.map(row).collect());
        if own.len() != others.len() {
            return Err(format!(
                "{field}: {} samples for {}",
                own.len(),
                others.len()
            ));
        }
        for (own, other) in own.iter().zip(&others) {
            let near = (0..3).all(|i| (own[i] - other[i]).abs() < 1e-4);
            // Values that are scaled were rounded to 32-bit floats, all others are the same.
            let same = (own[3] - other[3]).abs() <= 1e-7 * other[3].abs();
            if !(near && same) {
                return Err(format!("{field}: {own:?} for {other:?}"));
            }
        }
    }
    Ok(())
}

/// [`compare`] for all files, with these options; `each` sees the grids among them.
fn compare_all(options: &ReadOptions, mut each: impl FnMut(&str, &GridData)) {
    let mut wrong = Vec::new();
    for (name, fields) in expected() {
        let data = match read_file(&fixture(&name), options) {
            Ok(data) => data,
            Err(error) => {
                wrong.push(error.to_string());
                continue;
            }
        };
        if let Err(what) = compare(&data, &fields) {
            wrong.push(format!("{name}: {what}"));
        }
        if let FileData::Grid(data) = data {
            each(&name, &data);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_are_read_as_their_programs_read_them() {
    compare_all(&ReadOptions::default(), |_, _| {});
}

// What stands in its file as it is stays there, and is the same.
#[test]
fn files_that_stay_where_they_are_are_read_alike() {
    let streamed = [
        "pair.hdr",
        "c.npy",
        "fortran.npy",
        "frames-C.npy",
        "types.npz",
        "mode-1.mrc",
        "mode-2.mrc",
        "origin.map",
        "volumes.mrc",
        "axes.ccp4",
        "big.mrc",
        "imagej.tif",
        "imagej-truncated.tif",
        "ome.ome.tif",
        "plain-uint16.tif",
        "white-plain.tif",
        "bigtiff.tif",
        "shaped.tif",
    ];
    let options = ReadOptions {
        stream_above: 0,
        ..ReadOptions::default()
    };
    compare_all(&options, |name, data| {
        let is_streamed = |f: &GridField| matches!(f.samples, FieldSamples::Streamed(_));
        let any = data.fields.iter().any(is_streamed);
        assert!(any || !streamed.contains(&name), "{name}");
    });
}

#[test]
fn small_numbers_keep_their_types() {
    for (name, sample_type) in [
        ("mode-0.mrc", SampleType::I16),
        ("mode-6.mrc", SampleType::U16),
        ("mode-12.mrc", SampleType::F32),
        ("imagej.tif", SampleType::U16),
        ("plain-uint8.tif", SampleType::U8),
        ("plain-int16.tif", SampleType::I16),
        ("frames-C.npy", SampleType::I16),
        ("channels-F.npy", SampleType::U8),
    ] {
        if !is_read(name) {
            continue;
        }
        let data = read_fixture(name, &ReadOptions::default());
        assert_eq!(loaded(&data, 0).1.sample_type(), sample_type, "{name}");
    }
}

#[test]
fn spacing_and_origin_are_given_where_files_do_not_say_them() {
    let options = ReadOptions {
        spacing: Some(DVec3::new(0.5, 2.0, 3.0)),
        origin: Some(DVec3::new(7.0, 8.0, 9.0)),
        ..ReadOptions::default()
    };
    for name in [
        "c.npy",
        "fortran.npy",
        "types.npz",
        "plain-uint8.tif",
        "imagej.tif",
    ] {
        if !is_read(name) {
            continue;
        }
        let data = read_fixture(name, &options);
        let lattice = data.fields[0].lattice;
        let last = DVec3::from_array(lattice.dims.map(|n| n as f64 - 1.0));
        let [x, y, z] = [3.0, 2.0, 1.0]; // of [z, y, x] = [2, 3, 4] samples
        assert_eq!(lattice.origin, DVec3::new(7.0, 8.0, 9.0), "{name}");
        let far = DVec3::new(7.0 + 0.5 * x, 8.0 + 2.0 * y, 9.0 + 3.0 * z);
        assert_eq!(lattice.point(last), far, "{name}");
    }
    for name in ["mode-1.mrc", "pair.hdr"] {
        let error = read_with(&fixture(name), &options).expect_err("it says so itself");
        assert!(error.to_string().contains("says itself"), "{error}");
    }
    let zero = ReadOptions {
        spacing: Some(DVec3::ZERO),
        ..ReadOptions::default()
    };
    assert!(read_with(&fixture("c.npy"), &zero).is_err());
    assert!(read_with(&fixture("types.npz"), &zero).is_err());
}

// What is not in the samples is said.
#[test]
fn notes_say_what_was_chosen() {
    for (name, words) in [
        ("analyze.hdr", "Analyze 7.5, which does not say"),
        ("two.nii", "stored samples are scaled by 2 and moved by -1"),
        ("two.nii", "lengths are in millimeters"),
        (
            "frames-C.npy",
            "first axis of [3, 2, 3, 5] is taken for that of frames",
        ),
        (
            "channels-C.npy",
            "last axis of [2, 3, 4, 3] is taken for that of channels",
        ),
        ("channels-C.npy", "holds colors"),
        ("types.npz", "array 'line' of shape [3] left out"),
        ("c.npy", "how far apart samples are: 1 is taken"),
        (
            "axes.ccp4",
            "columns run along z, rows along x, sections along y",
        ),
        ("origin.map", "lengths are in ångström"),
        ("imagej.tif", "lengths are in micron"),
        ("imagej-truncated.tif", "the file has one page"),
        (
            "plain-uint8.tif",
            "how far apart samples are along x and y and z: 1 is taken",
        ),
        ("rgb.tif", "holds colors"),
        ("image.pvti", "3 pieces joined"),
        ("even.pvtr", "the coordinates are evenly spaced"),
    ] {
        if !is_read(name) {
            continue;
        }
        let data = read_fixture(name, &ReadOptions::default());
        let found = data.notes.iter().any(|note| note.contains(words));
        assert!(found, "{name}: {:?}", data.notes);
    }
}

/// A fixture in which the first of `old` is `new`, of as many bytes.
fn changed(name: &str, old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut bytes = std::fs::read(fixture(name)).expect("a fixture");
    let at = bytes.windows(old.len()).position(|window| window == old);
    let at = at.expect("it is there");
    bytes[at..at + old.len()].copy_from_slice(new);
    bytes
}

/// A fixture with other bytes at a place.
fn with(name: &str, at: usize, new: &[u8]) -> Vec<u8> {
    let mut bytes = std::fs::read(fixture(name)).expect("a fixture");
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

#[test]
fn what_is_wrong_with_files_of_programs_is_said() {
    let whole = |name: &str| std::fs::read(fixture(name)).expect("a fixture");
    let packed = whole("types-packed.npz");
    for (name, bytes, words) in [
        (
            "a.npy",
            changed("c.npy", b"'<f4'", b"'|O4'"),
            "numbers of type '|O4'",
        ),
        (
            "a.npy",
            changed("c.npy", b"'<f4'", b"[('a'"),
            "they are records",
        ),
        (
            "a.npy",
            changed("c.npy", b"(2, 3, 4)", b"(2, 12)  "),
            "two axes",
        ),
        (
            "a.npy",
            changed("c.npy", b"(2, 3, 4)", b"(2, 3, 5)"),
            "the file ends",
        ),
        (
            "a.npy",
            changed("c.npy", b"(2, 3, 4)", b"(2, 3,-4)"),
            "'shape' is",
        ),
        (
            "a.npz",
            changed("types.npz", b"(2, 3, 4)", b"(9, 3, 4)"),
            "the array needs",
        ),
        (
            "a.npz",
            packed[..packed.len() / 2].to_vec(),
            "the archive is damaged",
        ),
        ("a.npz", whole("c.npy")[..9].to_vec(), "cut off"),
        ("a.mrc", with("mode-2.mrc", 12, &[101]), "MRC mode 101"),
        (
            "a.mrc",
            with("mode-2.mrc", 60, &60_f32.to_le_bytes()),
            "shear",
        ),
        (
            "a.mrc",
            with("mode-2.mrc", 64, &[2, 0, 0, 0, 2]),
            "along [2, 2, 3]",
        ),
        (
            "a.mrc",
            with("mode-2.mrc", 92, &(-8_i32).to_le_bytes()),
            "an extended header of -8",
        ),
        ("a.mrc", with("mode-2.mrc", 8, &[200]), "the file ends"),
        (
            "a.mrc",
            with("mode-2.mrc", 0, &[0xff; 4]),
            "a volume of -1 samples",
        ),
        ("a.hdr", whole("pair.hdr"), "(.img), which is not there"),
        ("a.nii", with("two.nii", 12, &[99]), "NIfTI type 99"),
        ("a.nii", with("two.nii", 4, b"n+9"), "no NIfTI magic"),
        ("a.img", whole("pair.img"), "a file of samples alone"),
    ] {
        let error = read(&[(name, &bytes)]).expect_err(words).to_string();
        assert!(error.contains(words), "{name}: {error} for {words}");
    }
}

#[test]
fn pieces_that_are_missing_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(fixture("image.pvti")).expect("a fixture");
    let list = folder.path().join("image.pvti");
    for piece in ["image-0.vti", "image-1.vti"] {
        std::fs::copy(fixture(piece), folder.path().join(piece)).expect("copied");
    }
    std::fs::write(&list, &text).expect("written");
    let read = |list: &Path| read_file(list, &ReadOptions::default());
    let error = read(&list).expect_err("it is not there").to_string();
    assert!(error.contains("'image-2.vti' is not there"), "{error}");
    // Neither are samples there that no piece has, though those that are there are enough.
    std::fs::copy(fixture("image-1.vti"), folder.path().join("image-2.vti")).expect("copied");
    let error = read(&list).expect_err("samples are missing").to_string();
    let words = "pieces with 76 samples where 100 are needed";
    assert!(error.contains(words), "{error}");
    // Nor cells.
    let text = std::fs::read_to_string(fixture("curved.pvts")).expect("a fixture");
    let list = folder.path().join("curved.pvts");
    std::fs::copy(fixture("curved-0.vts"), folder.path().join("curved-0.vts")).expect("copied");
    let lines = text
        .lines()
        .filter(|line| !line.contains("curved-1") && !line.contains("curved-2"));
    let fewer: Vec<&str> = lines.collect();
    std::fs::write(&list, fewer.join("\n")).expect("written");
    let error = read(&list).expect_err("cells are missing").to_string();
    assert!(
        error.contains("pieces with 12 cells where 48 are needed"),
        "{error}"
    );
}

// Every file that was cut or changed is read or refused; nothing else happens.
#[test]
fn damaged_files_of_programs_are_read_or_refused() {
    let names: Vec<String> = expected().keys().cloned().collect();
    let mut random = 1_u64;
    let mut next = move |most: usize| {
        // Xorshift (Marsaglia 2003).
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % most as u64) as usize
    };
    // With all of them, as some name others.
    let folder = tempfile::tempdir().expect("a folder");
    for entry in std::fs::read_dir(fixture("")).expect("fixtures") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name");
        std::fs::copy(&path, folder.path().join(name)).expect("copied");
    }
    let mut read = 0;
    for name in names {
        let whole = std::fs::read(fixture(&name)).expect("a fixture");
        let path = folder.path().join(&name);
        for round in 0..60 {
            let mut bytes = whole.clone();
            if round % 2 == 0 {
                bytes.truncate(next(whole.len()));
            } else {
                for _ in 0..=next(4) {
                    // Half of the changes are where headers are, which say more than samples.
                    let most = if next(2) == 0 {
                        whole.len().min(400)
                    } else {
                        whole.len()
                    };
                    bytes[next(most)] = [0, 1, 0x7f, 0xff, next(256) as u8][next(5)];
                }
            }
            std::fs::write(&path, &bytes).expect("written");
            for above in [0, u64::MAX] {
                let options = ReadOptions {
                    stream_above: above,
                    ..ReadOptions::default()
                };
                if let Ok(FileData::Grid(data)) = read_file(&path, &options) {
                    for field in &data.fields {
                        let samples = field.lattice.validate().expect("checked");
                        if let FieldSamples::Loaded(loaded) = &field.samples {
                            assert_eq!(samples, loaded.len(), "{name}");
                        }
                    }
                    read += 1;
                }
            }
        }
        std::fs::write(&path, &whole).expect("written");
    }
    assert!(read > 100, "{read} files were read");
}
