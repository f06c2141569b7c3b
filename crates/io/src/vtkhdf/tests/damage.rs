//! Files that are cut off or changed.

use super::*;

const SMALL: &[&str] = &[
    "lattice-zlib.vtkhdf",
    "polyhedra.vtkhdf",
    "image.vtkhdf",
    "blanked.vtkhdf",
    "even.vtkhdf",
    "by-hand.hdf",
    "cycle.hdf",
    "images.vtkhdf",
    #[cfg(feature = "exodus")]
    "steps.e",
];

/// Reads all that a file gives, whatever it is.
fn read_all(path: &Path) -> Result<(), Error> {
    read_steps(path)?;
    match read_file(path, &ReadOptions::default())? {
        FileData::Mesh(data) => {
            for field in 0..data.fields.len() {
                data.scalars(field)?;
            }
            data.into_mesh(None).map(drop)
        }
        FileData::Grid(data) => data.into_volume(None).map(drop),
    }
}

fn check(path: &Path) {
    let Err(error) = read_all(path) else { return };
    let words = error.to_string();
    assert_eq!(words.lines().count(), 1, "{words}");
    assert!(words.len() < 700, "{words}");
}

#[test]
fn a_file_that_is_cut_off_is_an_error() {
    let files = Files::of(&[]);
    for name in SMALL {
        let whole = bytes(name);
        let path = files.put(name, &whole);
        read_all(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        for length in (1..whole.len()).step_by(89) {
            files.put(name, &whole[..length]);
            assert!(read_all(&path).is_err(), "{name}: {length}");
            check(&path);
        }
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    let files = Files::of(&[]);
    // A linear congruential generator, so that each run changes the same.
    let mut state = 1_u64;
    let mut random = move |most: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % most
    };
    for name in SMALL {
        let whole = bytes(name);
        // Most of a small file is room for more: change what is there.
        let used: Vec<usize> = (0..whole.len()).filter(|&at| whole[at] != 0).collect();
        for _ in 0..300 {
            let mut changed = whole.clone();
            for _ in 0..=random(3) {
                let at = used[random(used.len())];
                changed[at] = [0, 1, 0x7f, 0xff, random(256) as u8][random(5)];
            }
            let path = files.put(name, &changed);
            check(&path);
        }
    }
}
