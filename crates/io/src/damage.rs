//! Tests of readers share these checks of files that are cut off or changed.

use std::fs;
use std::path::Path;

use tetrascope_core::Error;

use crate::{FileData, ReadOptions, read_file, read_steps};

/// Reads all that a file gives, whatever it is.
pub(crate) fn read_all(path: &Path) -> Result<(), Error> {
    read_steps(path)?;
    match read_file(path, &ReadOptions::default())? {
        FileData::Mesh(data) => {
            for field in 0..data.fields.len() {
                data.scalars(field)?;
            }
            data.into_mesh(None).map(drop)
        }
        FileData::Grid(data) => data.into_volume(None).map(drop),
        FileData::Clusters(clusters) => {
            let source = clusters.source();
            (0..source.clusters().len()).try_for_each(|i| source.read(i).map(drop))
        }
    }
}

/// Checks that what is wrong with a file, if anything is, is said in a line.
fn check(path: &Path) {
    let Err(error) = read_all(path) else { return };
    let words = error.to_string();
    assert_eq!(words.lines().count(), 1, "{words}");
    assert!(words.len() < 700, "{words}");
}

/// Checks that the beginnings of the file `name` are refused, one every `step` bytes, and the
/// `whole` is read.
pub(crate) fn check_cut_off(name: &str, whole: &[u8], step: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, whole).expect("written");
    read_all(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
    for length in (1..whole.len()).step_by(step) {
        fs::write(&path, &whole[..length]).expect("written");
        assert!(read_all(&path).is_err(), "{name}: {length}");
        check(&path);
    }
}

/// Checks that copies of the file `name` with a few other bytes are read, or refused in a line.
pub(crate) fn check_changed(name: &str, whole: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    // A linear congruential generator, so that each run changes the same.
    let mut state = 1_u64;
    let mut random = move |most: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % most
    };
    // Most of a small HDF5 file is room for more: change what is there.
    let used: Vec<usize> = (0..whole.len()).filter(|&at| whole[at] != 0).collect();
    for _ in 0..300 {
        let mut changed = whole.to_vec();
        for _ in 0..=random(3) {
            let at = used[random(used.len())];
            changed[at] = [0, 1, 0x7f, 0xff, random(256) as u8][random(5)];
        }
        fs::write(&path, changed).expect("written");
        check(&path);
    }
}
