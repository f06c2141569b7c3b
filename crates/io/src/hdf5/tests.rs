use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::*;

pub(crate) fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// The bytes of a file of make_hdf.py, or make_cgns.py.
pub(crate) fn bytes(name: &str) -> Vec<u8> {
    let folder = if name.ends_with(".cgns") {
        "cgns"
    } else {
        "hdf"
    };
    let packed = fs::read(fixtures().join(format!("{folder}/{name}.gz")));
    let packed = packed.unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut bytes = Vec::new();
    let mut unpack = flate2::read::GzDecoder::new(&packed[..]);
    unpack.read_to_end(&mut bytes).expect("gzip");
    bytes
}

/// A folder with files of make_hdf.py.
pub(crate) struct Files(TempDir);

impl Files {
    pub(crate) fn of(names: &[&str]) -> Files {
        let files = Files(tempfile::tempdir().expect("a folder"));
        for name in names {
            files.put(name, &bytes(name));
        }
        files
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("written");
        path
    }
}

#[test]
fn parts_begin_and_end_with_chunks() {
    let files = Files::of(&["lattice-zlib.vtkhdf", "image.vtkhdf"]);
    let root = open(&files.path("lattice-zlib.vtkhdf")).expect("HDF5");
    let group = root.group("VTKHDF").expect("whole").expect("there");
    let dataset = group
        .dataset("Connectivity")
        .expect("whole")
        .expect("there");
    let view = dataset.view(&[], 5..160).expect("inside");
    let all = view.indices().expect("whole");
    assert_eq!((view.count(), view.bytes(), all.len()), (155, 1240, 155));
    let floats = dataset.all(160).expect("whole");
    let expected: Vec<u64> = floats[5..].iter().map(|&x| x as u64).collect();
    assert_eq!(all, expected);
    assert!(dataset.all(159).is_err());
    for (places, rows) in [(&[][..], 5..161), (&[0], 0..1), (&[160], 0..0)] {
        assert!(dataset.view(places, rows).is_err());
    }
    assert!(group.dataset("PointData").expect("whole").is_none());
    assert!(group.group("Connectivity").expect("whole").is_none());
}
