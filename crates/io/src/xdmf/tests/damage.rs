//! Files that are cut off, changed, or say what cannot be.

use super::*;
use crate::damage::read_all;

/// A tetrahedron with a field.
const WHOLE: &str = r#"<Xdmf Version="3.0"><Domain><Grid Name="a"><Topology TopologyType="Tetrahedron" NumberOfElements="1">
<DataItem Dimensions="1 4" NumberType="Int" Format="XML">0 1 2 3</DataItem></Topology><Geometry GeometryType="XYZ">
<DataItem Dimensions="4 3" Format="XML">0 0 0 1 0 0 0 1 0 0 0 1</DataItem></Geometry><Attribute Name="s" Center="Node">
<DataItem Dimensions="4" Format="XML">1 2 3 4</DataItem></Attribute></Grid></Domain></Xdmf>"#;

fn read_text(text: &[u8]) -> Result<(), Error> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.xdmf");
    fs::write(&path, text).expect("written");
    read_all(&path)
}

fn words(error: &Error) -> String {
    let words = format!("{error}; {}", error.help().unwrap_or_default());
    assert_eq!(words.lines().count(), 1, "{words}");
    assert!(words.len() < 700, "{words}");
    words
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    read_text(WHOLE.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    for (old, new, said) in [
        (">0 1 2 3<", ">0 1 2 4<", "has 4 points"),
        (">0 1 2 3<", ">0 1 2 -3<", "-3 is not a whole number"),
        (">0 1 2 3<", ">0 1 2<", "4 numbers cannot be in 5 bytes"),
        (
            ">0 1 2 3<",
            ">0 1   2<",
            "there are 3 numbers, and 4 are needed",
        ),
        (">0 1 2 3<", ">0 1 2 3 0<", "more than the 4 numbers"),
        ("\"1 4\"", "\"1 4000000000000\"", "cannot be in"),
        ("\"1 4\"", "\"99999999999 99999999999\"", "cannot be in"),
        ("\"4\" Format", "\"3\" Format", "3 numbers for 4 points"),
        (
            "Dimensions=\"4\" Format=\"XML\">1 2 3 4",
            "Dimensions=\"3\" Format=\"XML\">1 2 3",
            "3 numbers for 4 points",
        ),
        (">1 2 3 4<", ">1 2 x 4<", "'x' is not a number"),
        (
            "Tetrahedron",
            "Tetrahedra",
            "cells of the type 'tetrahedra' are not read",
        ),
        ("Tetrahedron", "Mixed", "cell 0 is of type 0"),
        (">0 1 2 3<", ">6 1 2 3<", "is point 6, but the piece has 4"),
        ("Tetrahedron", "Triangle", "none has cells with a volume"),
        ("\"XYZ\"", "\"XY\"", "none has cells with a volume"),
        ("\"XYZ\"", "\"VXVYVZ\"", "geometry of the type VXVYVZ"),
        (
            "NumberType=\"Int\"",
            "NumberType=\"Compact\"",
            "numbers of the type compact",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"Binary\">../a.bin",
            "not in the folder",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"Binary\">/etc/passwd",
            "not in the folder",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"Binary\">b.bin",
            "is not there",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"Binary\">a.xdmf",
            "but the piece has 4",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"Binary\" Seek=\"900\">a.xdmf",
            "are not in 'a.xdmf'",
        ),
        #[cfg(feature = "hdf5")]
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"HDF\">../a.h5:/x",
            "not in the folder",
        ),
        #[cfg(feature = "hdf5")]
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"HDF\">a.xdmf:/x",
            "HDF5 header",
        ),
        (
            "Format=\"XML\">0 1 2 3",
            "Format=\"TIFF\">0 1 2 3",
            "the format TIFF is not read",
        ),
        (
            ">0 1 2 3<",
            " ItemType=\"Function\">$0 + $1<",
            "a DataItem of the type Function",
        ),
        (">0 1 2 3<", ">&#48; 1 2 3<", "there is an entity"),
        (
            "<Topology ",
            "<Topology Reference=\"/Xdmf/Domain/Grid[2]\" ",
            "has no element",
        ),
        (
            "<Topology ",
            "<Topology Reference=\"/Xdmf/Domain/Grid[1]/Topology\" ",
            "more than 8 references",
        ),
        (
            "<Topology ",
            "<Topology Reference=\"id('a')\" ",
            "is not read",
        ),
        (
            "<Grid ",
            "<Grid GridType=\"SubSet\" ",
            "a grid of the type SubSet",
        ),
        ("<Grid ", "<Grid GridType=\"Tree\" ", "has no <Grid>"),
        ("Domain", "Domains", "there is no <Domain>"),
        ("</Grid></Domain></Xdmf>", "", "truncated"),
    ] {
        let changed = WHOLE.replace(old, new);
        assert_ne!(changed, WHOLE, "{old}");
        let error = read_text(changed.as_bytes());
        let words = words(&error.expect_err(new));
        assert!(words.contains(said), "{new}: {words}");
    }
}

/// Copies the fixtures, so that one of them can be changed.
fn copies() -> tempfile::TempDir {
    let copies = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(folder()).expect("fixtures") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, copies.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    copies
}

const SMALL: &[&str] = &[
    "lattice-xml.xdmf",
    "lattice-binary.xdmf",
    "fenics.xdmf",
    "tree.xdmf",
    "vtk-image.xdmf",
    "vtk-mixed.xdmf",
    #[cfg(feature = "hdf5")]
    "dolfinx.xdmf",
    #[cfg(feature = "hdf5")]
    "forms.xdmf",
];

#[test]
fn a_file_that_is_cut_off_is_an_error() {
    let copies = copies();
    for name in SMALL {
        let path = copies.path().join(name);
        let whole = fs::read(&path).expect("a fixture");
        let end = whole.trim_ascii_end().len();
        read_all(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        for length in (1..end).step_by(89) {
            fs::write(&path, &whole[..length]).expect("written");
            words(&read_all(&path).expect_err(name));
        }
        fs::write(&path, &whole).expect("written");
    }
    #[cfg(feature = "hdf5")]
    for (name, binary) in [
        ("lattice-hdf.xdmf", "lattice-hdf.h5"),
        ("lattice-binary.xdmf", "lattice-binary1.bin"),
    ] {
        let path = copies.path().join(binary);
        let whole = fs::read(&path).expect("a fixture");
        for length in (1..whole.len()).step_by(389) {
            fs::write(&path, &whole[..length]).expect("written");
            words(&read_all(&copies.path().join(name)).expect_err(name));
        }
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    let copies = copies();
    // A linear congruential generator, so that each run changes the same.
    let mut state = 1_u64;
    let mut random = move |most: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % most
    };
    for name in SMALL {
        let path = copies.path().join(name);
        let whole = fs::read(&path).expect("a fixture");
        for _ in 0..300 {
            let mut changed = whole.clone();
            for _ in 0..=random(3) {
                let at = random(changed.len());
                changed[at] = [b'0', b'9', b'-', b'/', b'"', random(256) as u8][random(6)];
            }
            fs::write(&path, &changed).expect("written");
            if let Err(error) = read_all(&path) {
                words(&error);
            }
        }
        fs::write(&path, &whole).expect("written");
    }
}
