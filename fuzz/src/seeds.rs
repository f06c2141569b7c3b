//! Valid files of every format, small, to begin from: the fixtures of the readers' own
//! tests, and others made here.

mod arrays;
mod collections;
mod dicom;
mod gmsh;
mod grids;
mod meshes;
mod scenes;
mod xml;

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

/// The use of the first file.
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
    vtu.extend(xml::polyhedra());
    let mut vtk = fixtures("vtk", "mesh.vtk")?;
    vtk.extend(meshes::legacy());
    let mut gmsh = fixtures("msh", "mesh.msh")?;
    gmsh.extend(gmsh::gmsh());
    let exodus = fixtures("e", "mesh.e")?;
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
            arrays::niftis()?,
            &[
                "n+1\0",
                "ni1\0",
                "\u{1}\u{5c}",
                "\u{5c}\u{1}",
                "n+2\0\r\n\u{1a}\n",
                "\u{2}\u{1c}",
                "\u{1c}\u{2}",
            ],
        ),
        kind("raw", grids::raw(), &["\0", "\u{ff}"]),
        kind("scene", scenes::scenes(), scenes::WORDS),
        kind("pvd", collections::pvd(), collections::PVD_WORDS),
        kind("series", collections::series(), collections::SERIES_WORDS),
        kind("vts", xml::structured(), xml::STRUCTURED_WORDS),
        kind("vtr", xml::rectilinear(), xml::STRUCTURED_WORDS),
        kind("pvtu", xml::pieces(), xml::LIST_WORDS),
        kind("vtm", xml::blocks(), xml::LIST_WORDS),
        kind("gmsh", gmsh, gmsh::WORDS),
        kind("exodus", exodus, EXODUS_WORDS),
        kind("npy", arrays::npy(), arrays::NPY_WORDS),
        kind("npz", arrays::npz(), arrays::NPZ_WORDS),
        kind("mrc", arrays::mrc()?, arrays::MRC_WORDS),
        kind("tiff", arrays::tiff()?, arrays::TIFF_WORDS),
        kind("dicom", dicom::seeds()?, dicom::WORDS),
        kind("nifti-pair", arrays::pairs()?, arrays::PAIR_WORDS),
        kind("pvti", xml::extents(), xml::LIST_WORDS),
    ];
    kinds[0].heavy = meshes::heavy_vtu();
    kinds[5].heavy = vec![grids::heavy_nrrd()];
    Ok(kinds)
}

/// A mesh of one tetrahedron for lists to name.
pub(crate) fn listed_mesh() -> Vec<u8> {
    xml::tetrahedron(1, "")
}

/// The second pieces of lists of extents: of an image, a structured and a rectilinear grid.
pub(crate) fn listed_extents() -> [(&'static str, Vec<u8>); 3] {
    xml::second_pieces()
}

/// Names and tags of a netCDF file in which there is a mesh.
const EXODUS_WORDS: &[&str] = &[
    "CDF\u{1}",
    "CDF\u{2}",
    "CDF\u{5}",
    "\0\0\0\u{a}",
    "\0\0\0\u{b}",
    "\0\0\0\u{c}",
    "num_nodes",
    "num_elem",
    "num_el_blk",
    "num_el_in_blk1",
    "num_nod_per_el1",
    "num_nod_var",
    "num_elem_var",
    "time_step",
    "time_whole",
    "len_string",
    "coord",
    "coordx",
    "connect1",
    "elem_type",
    "TETRA",
    "HEX8",
    "TETRA10",
    "name_nod_var",
    "vals_nod_var",
    "vals_nod_var1",
    "name_elem_var",
    "vals_elem_var1eb1",
    "eb_prop1",
    "eb_status",
    "floating_point_word_size",
    "file_size",
];

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
