//! Valid files of every format, small, to begin from: the fixtures of the readers' own
//! tests, and others made here.

mod collections;
mod grids;
mod meshes;
mod scenes;

use std::path::{Path, PathBuf};

use tetrascope::scene::VolumeSource;

use crate::pack::Part;

/// A family of files that one reader reads.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) seeds: Vec<Seed>,
    /// Small files that hold much: they take long, so they are chosen seldom.
    pub(crate) heavy: Vec<Seed>,
    /// Words that mean something in the format.
    pub(crate) words: &'static [&'static str],
}

/// Files that belong together.
#[derive(Clone)]
pub(crate) struct Seed {
    /// The first is the one that is opened.
    pub(crate) files: Vec<(&'static str, Vec<Part>)>,
    pub(crate) entry: Entry,
}

/// What is done with the first file.
#[derive(Clone)]
pub(crate) enum Entry {
    /// Loaded as a volume; the source says more than its name for raw files.
    Volume(Box<VolumeSource>),
    /// Parsed as a scene, completed, and its file loaded.
    Scene,
    /// Read as a list of files, which are not.
    Collection,
}

impl Seed {
    fn of(files: Vec<(&'static str, Vec<Part>)>) -> Seed {
        Seed {
            files,
            entry: Entry::Volume(Box::default()),
        }
    }

    fn single(name: &'static str, parts: Vec<Part>) -> Seed {
        Seed::of(vec![(name, parts)])
    }
}

/// All kinds, in the order in which inputs take turns.
pub(crate) fn kinds() -> std::io::Result<Vec<Kind>> {
    let mut vtu = fixtures("vtu", "mesh.vtu")?;
    vtu.extend(meshes::packed_vtu()?);
    let mut vtk = fixtures("vtk", "mesh.vtk")?;
    vtk.extend(meshes::legacy());
    let kind = |name, seeds, words| Kind {
        name,
        seeds,
        heavy: Vec::new(),
        words,
    };
    let mut kinds = vec![
        kind("vtu", vtu, meshes::XML_WORDS),
        kind("vtk", vtk, meshes::LEGACY_WORDS),
        kind("vti", grids::vti(), meshes::XML_WORDS),
        kind("plot3d", meshes::plot3d(), &["\0\0\0\u{2}", "\u{2}\0\0\0"]),
        kind("metaimage", grids::meta_image(), grids::META_WORDS),
        kind("nrrd", grids::nrrd(), grids::NRRD_WORDS),
        kind(
            "nifti",
            grids::nifti(),
            &["n+1\0", "ni1\0", "\u{1}\u{5c}", "\u{5c}\u{1}"],
        ),
        kind("raw", grids::raw(), &["\0", "\u{ff}"]),
        kind("scene", scenes::scenes(), scenes::WORDS),
        kind("pvd", collections::pvd(), collections::PVD_WORDS),
        kind("series", collections::series(), collections::SERIES_WORDS),
    ];
    kinds[0].heavy = meshes::heavy_vtu();
    kinds[5].heavy = vec![grids::heavy_nrrd()];
    Ok(kinds)
}

/// MetaImage files.
pub(crate) fn meta_images() -> Vec<Seed> {
    grids::meta_image()
}

/// NIfTI files.
pub(crate) fn niftis() -> Vec<Seed> {
    grids::nifti()
}

/// Where the readers' tests keep their files.
fn fixture_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/io/tests/fixtures")
}

/// Every fixture with `extension`, each to be read under `name`.
fn fixtures(extension: &str, name: &'static str) -> std::io::Result<Vec<Seed>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(fixture_folder())? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == extension) {
            paths.push(path);
        }
    }
    paths.sort(); // the order of a folder is not the same everywhere
    let seed = |path: &PathBuf| Ok(Seed::single(name, vec![Part::plain(std::fs::read(path)?)]));
    paths.iter().map(seed).collect()
}

/// The bytes of `count` samples that rise and fall.
fn bytes_of<const N: usize>(count: usize, encode: impl Fn(f64) -> [u8; N]) -> Vec<u8> {
    let value = |i: usize| (i * 37 % 101) as f64;
    (0..count).flat_map(|i| encode(value(i))).collect()
}
