//! Arrays, maps and stacks: NumPy, MRC, TIFF, NIfTI in pairs.

use super::{Seed, bytes_of, fixture_folder, grids};
use crate::pack::{Part, Wrap};
use crate::zip::{Member, zip};

pub(super) const NPY_WORDS: &[&str] = &[
    "NUMPY\u{1}\0",
    "NUMPY\u{2}\0",
    "NUMPY\u{3}\0",
    "'descr': ",
    "'fortran_order': ",
    "'shape': ",
    "True",
    "False",
    "'<f4'",
    "'>f8'",
    "'|u1'",
    "'|b1'",
    "'<i2'",
    "'<i8'",
    "'<u8'",
    "'<f2'",
    "'<c8'",
    "'|O'",
    "[('a', '<f4')]",
    "(2, 2, 3), ",
    "(2, 2, 2, 3), ",
    "(3L, 2L, 2L), ",
    "()",
    "-1",
    "{",
    "}",
    "\n",
];

pub(super) const NPZ_WORDS: &[&str] = &[
    "PK\u{1}\u{2}",
    "PK\u{3}\u{4}",
    "PK\u{5}\u{6}",
    "PK\u{6}\u{6}",
    "PK\u{6}\u{7}",
    ".npy",
    "\u{8}\0",
    "\0\0\0\0",
    "../",
    "'shape': (2, 2, 3), ",
    "'descr': '<f4'",
];

pub(super) const MRC_WORDS: &[&str] = &[
    "MAP ",
    "DD\0\0",
    "\u{11}\u{11}\0\0",
    "IMOD",
    "\u{1}\0\0\0\u{2}\0\0\0\u{3}\0\0\0",
    "\u{3}\0\0\0\u{2}\0\0\0\u{1}\0\0\0",
    "\u{6}\0\0\0",
    "\u{c}\0\0\0",
    "\0\0\u{b4}B",
];

pub(super) const TIFF_WORDS: &[&str] = &[
    "II*\0",
    "MM\0*",
    "II+\0\u{8}\0\0\0",
    "\0\u{1}\u{4}\0",
    "\u{1}\u{1}\u{4}\0",
    "\u{2}\u{1}\u{3}\0",
    "\u{3}\u{1}\u{3}\0",
    "\u{11}\u{1}\u{4}\0",
    "\u{15}\u{1}\u{3}\0",
    "\u{16}\u{1}\u{4}\0",
    "\u{17}\u{1}\u{4}\0",
    "\u{1c}\u{1}\u{3}\0",
    "=\u{1}\u{3}\0",
    "B\u{1}\u{3}\0",
    "S\u{1}\u{3}\0",
    "ImageJ=1.53t\n",
    "images=2\n",
    "slices=2\n",
    "channels=2\n",
    "frames=2\n",
    "hyperstack=true\n",
    "spacing=2\n",
    "unit=um\n",
    "{\"shape\": [2, 3, 4]}",
    "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\">",
    "<TiffData IFD=\"1\" FirstZ=\"1\" PlaneCount=\"1\"/>",
    "PhysicalSizeX=\"2\" ",
    "SizeZ=\"2\" ",
];

pub(super) const PAIR_WORDS: &[&str] = &["n+1\0", "ni1\0", "ni2\0", "\u{1}\u{5c}", "\u{2}\u{1c}"];

/// An array with its header.
fn array(kind: &str, order: &str, shape: &str, numbers: Vec<u8>) -> Vec<u8> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}");
    text.push('\n');
    let length = (text.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\0"[..], &length, text.as_bytes(), &numbers].concat()
}

fn floats(count: usize) -> Vec<u8> {
    bytes_of(count, |v| (v as f32).to_le_bytes())
}

/// Arrays in both orders, with channels, frames and complex numbers.
fn arrays() -> [Vec<u8>; 5] {
    let shorts = |count| bytes_of(count, |v| (v as i16).to_be_bytes());
    [
        array("<f4", "False", "(2, 2, 3)", floats(12)),
        array(">i2", "True", "(2, 2, 3)", shorts(12)),
        array("|u1", "False", "(2, 2, 2, 3)", bytes_of(24, |v| [v as u8])),
        array("<f4", "True", "(2, 2, 2, 5)", floats(40)),
        array("<c8", "False", "(2, 2, 2)", floats(16)),
    ]
}

pub(super) fn npy() -> Vec<Seed> {
    let seed = |bytes| Seed::single("grid.npy", vec![Part::plain(bytes)]);
    arrays().map(seed).into()
}

/// Archives, stored and deflated, one of them with an array of two axes.
pub(super) fn npz() -> Vec<Seed> {
    let [first, second, colors, ..] = arrays();
    let flat = array("<f4", "False", "(2, 3)", floats(6));
    let all = [("a.npy", first), ("b.npy", second), ("c.npy", flat)];
    let archive = |files: &[(&str, Vec<u8>)], is_deflated: bool| {
        let members = files.iter().map(|(name, bytes)| Member {
            name,
            bytes,
            is_deflated,
        });
        let bytes = zip(&members.collect::<Vec<_>>(), |_, _| {});
        Seed::single("grid.npz", vec![Part::plain(bytes)])
    };
    vec![
        archive(&all[..1], false),
        archive(&all, false),
        archive(&all, true),
        archive(&[("colors.npy", colors)], true),
    ]
}

/// A file of the readers' tests.
fn fixture(name: &str) -> std::io::Result<Vec<u8>> {
    std::fs::read(fixture_folder().join("grids").join(name))
}

/// Files of the readers' tests, each to be read as `name`.
fn fixtures(name: &'static str, files: &[&str]) -> std::io::Result<Vec<Seed>> {
    let seed = |file: &&str| Ok(Seed::single(name, vec![Part::plain(fixture(file)?)]));
    files.iter().map(seed).collect()
}

pub(super) fn mrc() -> std::io::Result<Vec<Seed>> {
    let plain = [
        "mode-0.mrc",
        "mode-2.mrc",
        "mode-4.mrc",
        "mode-12.mrc",
        "big.mrc",
        "axes.ccp4",
        "origin.map",
        "volumes.mrc",
    ];
    let mut seeds = fixtures("grid.mrc", &plain)?;
    let packed = Part::wrapped(fixture("mode-6.mrc")?, Wrap::Gzip);
    seeds.push(Seed::single("grid.mrc", vec![packed]));
    Ok(seeds)
}

pub(super) fn tiff() -> std::io::Result<Vec<Seed>> {
    let files = [
        "plain-uint8.tif",
        "plain-float32.tif",
        "bigtiff.tif",
        "strips.tif",
        "tiles.tif",
        "planar.tif",
        "planar-packed.tif",
        "rgb.tif",
        "rgb-packed.tif",
        "lzw.tif",
        "packbits.tif",
        "white.tif",
        "imagej.tif",
        "imagej-hyper.tif",
        "imagej-truncated.tif",
        "ome.ome.tif",
        "channels.ome.tif",
        "shaped.tif",
    ];
    fixtures("grid.tif", &files)
}

/// Pairs of NIfTI of both versions, and of Analyze.
pub(super) fn pairs() -> std::io::Result<Vec<Seed>> {
    let pair = |header: &str, samples: &str| {
        Ok(Seed::of(vec![
            ("grid.hdr", vec![Part::plain(fixture(header)?)]),
            ("grid.img", vec![Part::plain(fixture(samples)?)]),
        ]))
    };
    [
        ("pair.hdr", "pair.img"),
        ("pair-two.hdr", "pair-two.img"),
        ("pair-half.hdr", "pair-half.img.gz"),
        ("pair-packed.hdr.gz", "pair-packed.img.gz"),
        ("analyze.hdr", "analyze.img"),
    ]
    .into_iter()
    .map(|(header, samples)| pair(header, samples))
    .collect()
}

/// NIfTI files of the first version, which are made here, and of the second.
pub(super) fn niftis() -> std::io::Result<Vec<Seed>> {
    let mut seeds = grids::nifti();
    seeds.extend(fixtures(
        "grid.nii",
        &["two.nii", "two-big.nii", "rgb.nii"],
    )?);
    Ok(seeds)
}
