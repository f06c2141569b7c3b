//! DICOM: one file of several frames, in every packing.

use super::{Seed, fixture_folder};
use crate::pack::Part;

pub(super) const WORDS: &[&str] = &[
    "DICM",
    "UI\u{14}\0",
    "1.2.840.10008.1.2\0",
    "1.2.840.10008.1.2.1\0",
    "1.2.840.10008.1.2.5\0",
    "1.2.840.10008.1.2.4.70\0",
    "1.2.840.10008.1.2.4.90\0",
    "SQ\0\0",
    "UN\0\0",
    "OW\0\0",
    "US\u{2}\0",
    "DS\u{2}\0",
    "IS\u{2}\0",
    "(\0\u{8}\0",
    "(\0\u{10}\0",
    "(\0\u{11}\0",
    "(\0\0\u{1}",
    "1\\0\\0\\0\\1\\0",
    "-1",
    "1e308",
    "nan",
];

pub(super) fn seeds() -> std::io::Result<Vec<Seed>> {
    let files = [
        "frames.dcm",
        "frames-jpeg.dcm",
        "frames-jpeg2000.dcm",
        "times-runs.dcm",
        "dose.dcm",
        "mask.dcm",
        "implicit/a.dcm",
        "big/a.dcm",
        "deflated/a.dcm",
    ];
    let seed = |file: &&str| {
        let bytes = std::fs::read(fixture_folder().join("dicom").join(file))?;
        Ok(Seed::single("grid.dcm", vec![Part::plain(bytes)]))
    };
    files.iter().map(seed).collect()
}
