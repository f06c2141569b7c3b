//! DICOM series, and what SimpleITK reads in them: see `make_dicom.py` beside the fixtures.

use serde_json::{Map, Value};

use super::programs::compare;
use super::*;
use crate::damage::{check_changed, check_cut_off};

fn fixture(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/dicom");
    folder.join(name)
}

fn read_series(path: &Path) -> Result<GridData, Error> {
    read_with(path, &ReadOptions::default())
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(fixture(name)).expect("a fixture")
}

#[test]
fn series_are_read_as_other_programs_read_them() {
    let text = std::fs::read_to_string(fixture("expected.json")).expect("a fixture");
    let expected: Map<String, Value> = serde_json::from_str(&text).expect("as the script writes");
    assert!(expected.len() > 25, "{} series", expected.len());
    for (name, fields) in expected {
        let data = read_series(&fixture(&name)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(data.space, Some("LPS"), "{name}");
        let compared = compare(&FileData::Grid(data), &fields);
        compared.unwrap_or_else(|what| panic!("{name}: {what}"));
    }
}

#[test]
fn what_files_say_is_said() {
    for (name, notes) in [
        ("explicit", &["Hounsfield"][..]),
        ("explicit/b.dcm", &["one of the 3 images of its series"]),
        (
            "two",
            &[
                "holds 2 series: 'series 21' (2 slices, as in 00.dcm), 'series 20' (3 slices, as in a.dcm)",
                "'series 20' (3 slices, as in a.dcm) is read",
            ],
        ),
        ("scaled", &["in each slice by its own factors"]),
        ("colors-1", &["holds colors"]),
    ] {
        let data = read_series(&fixture(name)).unwrap_or_else(|error| panic!("{error}"));
        for note in notes {
            let is_said = data.notes.iter().any(|said| said.contains(note));
            assert!(is_said, "{name}: {:?}", data.notes);
        }
    }
}

#[test]
fn what_is_no_lattice_is_refused() {
    for (name, what) in [
        ("gap", "slices 2 and 3 are 3 apart, and most others 1.5"),
        ("tilted", "shifted by up to 1.20 pixels"),
        ("turned", "not parallel"),
    ] {
        let error = read_series(&fixture(name)).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let one = folder(&[("a.dcm", &bytes("explicit/a.dcm"))]);
    let error = read_series(one.path()).unwrap_err().to_string();
    assert!(error.contains("one slice, which is a picture"), "{error}");
    // One echo of a slice is missing.
    let names = ["00", "01", "10", "11", "20"];
    let files = names.map(|name| bytes(&format!("echoes/{name}.dcm")));
    let files: Vec<(&str, &[u8])> = names
        .into_iter()
        .zip(files.iter().map(Vec::as_slice))
        .collect();
    let error = read_series(folder(&files).path()).unwrap_err().to_string();
    let what = "2 frames at the first place, and 1 at place 3";
    assert!(error.contains(what), "{error}");
    let none = folder(&[("a.txt", b"no image")]);
    let error = read_series(none.path()).unwrap_err().to_string();
    assert!(
        error.contains("none of the files here is a DICOM image"),
        "{error}"
    );
}

#[test]
fn an_unreadable_image_is_counted() {
    let whole = bytes("explicit/b.dcm");
    let cut = &whole[..whole.len() / 3];
    let (first, last) = (bytes("explicit/a.dcm"), bytes("explicit/c.dcm"));
    let files = folder(&[("a.dcm", &first), ("b.dcm", cut), ("c.dcm", &last)]);
    let data = read_series(files.path()).unwrap_or_else(|error| panic!("{error}"));
    let is_said =
        |note: &String| note.starts_with("1 DICOM file left out as unreadable, such as b.dcm");
    assert!(data.notes.iter().any(is_said), "{:?}", data.notes);
    assert_eq!(data.fields[0].lattice.dims[2], 2);
}

#[test]
fn syntaxes_that_are_not_read_say_so() {
    let change = |from: &[u8], to: &[u8]| {
        let mut whole = bytes("frames.dcm");
        let at = whole.windows(from.len()).position(|w| w == from);
        let at = at.expect("it is there");
        whole[at..at + from.len()].copy_from_slice(to);
        let folder = folder(&[("a.dcm", &whole)]);
        read_series(&folder.path().join("a.dcm"))
            .unwrap_err()
            .to_string()
    };
    for (syntax, what) in [
        (b"1.2.840.10008.1.2.4\0", "1.2.840.10008.1.2.4 is not read"),
        (b"1.2.840.10008.1.2.7\0", "1.2.840.10008.1.2.7 is not read"),
    ] {
        let error = change(b"1.2.840.10008.1.2.1\0", syntax);
        assert!(error.contains(what), "{error}");
    }
    // Runs and images need fragments.
    let error = change(b"1.2.840.10008.1.2.1\0", b"1.2.840.10008.1.2.5\0");
    assert!(error.contains("not in fragments"), "{error}");
}

#[test]
fn damaged_images_are_refused() {
    for name in [
        "frames.dcm",
        "frames-jpeg.dcm",
        "frames-jpeg2000.dcm",
        "times-runs.dcm",
        "dose.dcm",
    ] {
        check_cut_off("a.dcm", &bytes(name), 61);
        check_changed("a.dcm", &bytes(name));
    }
    // As files of series, without the others.
    for name in ["implicit", "deflated"] {
        check_changed("a.dcm", &bytes(&format!("{name}/a.dcm")));
    }
}

// Files that are deflated are bounded together: many small ones could unpack to more than there is memory for.
#[test]
fn deflated_pixels_are_bounded_by_their_files() {
    use crate::grid::dicom::memory_of;

    let (_, plain) = memory_of(&fixture("explicit/a.dcm"));
    assert_eq!(plain, None);
    let (needed, most) = memory_of(&fixture("deflated/a.dcm"));
    let length = std::fs::metadata(fixture("deflated/a.dcm"))
        .expect("a fixture")
        .len();
    assert_eq!((needed, most), (5 * 4 * 2, Some(length * 64 + (1 << 30))));
}

// Six frames of 65535 pixels squared in a small file are refused before there is memory for them.
#[test]
fn packed_pixels_are_bounded_by_their_file() {
    let mut whole = bytes("times-runs.dcm");
    for tag in [[0x28, 0, 0x10, 0], [0x28, 0, 0x11, 0]] {
        let at = whole
            .windows(4)
            .position(|w| w == tag)
            .expect("it is there");
        whole[at + 8..at + 10].copy_from_slice(&[0xFF, 0xFF]);
    }
    let folder = folder(&[("a.dcm", &whole)]);
    let error = read_series(&folder.path().join("a.dcm")).unwrap_err();
    assert!(error.to_string().contains("which is refused"), "{error}");
}
