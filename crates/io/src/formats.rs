//! The formats that are read and written, and how much of each.

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileFormat {
    /// Its name, for people.
    pub name: &'static str,
    /// The extensions of its files, in lower case. A file is told by its first bytes before its
    /// extension.
    pub extensions: &'static [&'static str],
    /// Whether its files hold meshes, grids or either.
    pub holds: Holds,
    /// Whether it is written, too.
    pub is_written: bool,
    /// Whether [`ReadOptions::step`](crate::ReadOptions::step) chooses one of its time steps.
    pub has_steps: bool,
    /// Whether meshes stay in their file; whether grids can ([`ReadOptions::stream_above`](crate::ReadOptions)),
    /// if their samples stand there as they are.
    pub streams: bool,
    /// The cargo feature that it needs.
    pub feature: Option<&'static str>,
    /// Whether that feature is on, or none is needed.
    pub is_read: bool,
    /// The parts of the format that are read, and those that are not.
    pub limits: &'static str,
}

/// The kinds of data that files hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Unstructured meshes.
    Meshes,
    /// Regular grids.
    Grids,
    /// Either.
    Both,
    /// The names of files of other formats, one for each time.
    Series,
}

impl Holds {
    /// "meshes", "grids", "meshes and grids", "lists of files".
    pub fn name(self) -> &'static str {
        match self {
            Holds::Meshes => "meshes",
            Holds::Grids => "grids",
            Holds::Both => "meshes and grids",
            Holds::Series => "lists of files",
        }
    }
}

const fn format(
    name: &'static str,
    extensions: &'static [&'static str],
    holds: Holds,
    limits: &'static str,
) -> FileFormat {
    FileFormat {
        name,
        extensions,
        holds,
        is_written: false,
        has_steps: false,
        streams: false,
        feature: None,
        is_read: true,
        limits,
    }
}

impl FileFormat {
    const fn written(mut self) -> FileFormat {
        self.is_written = true;
        self
    }

    const fn with_steps(mut self) -> FileFormat {
        self.has_steps = true;
        self
    }

    const fn streamed(mut self) -> FileFormat {
        self.streams = true;
        self
    }

    const fn with(mut self, feature: &'static str, is_on: bool) -> FileFormat {
        self.feature = Some(feature);
        self.is_read = is_on;
        self
    }
}

/// Every format, meshes first.
pub const FORMATS: [FileFormat; 21] = [
    format(
        "VTK XML unstructured grids",
        &["vtu"],
        Holds::Meshes,
        "every encoding (LZMA by the feature `lzma`), polyhedra; curved cells to order 6, pyramids to order 2, others by their corners; of several time steps the first",
    )
    .written(),
    format(
        "VTK XML structured and rectilinear grids",
        &["vts", "vtr"],
        Holds::Both,
        "as .vtu; pieces by extent, blanking; evenly spaced .vtr are grids",
    ),
    format(
        "VTK XML lists of pieces and blocks",
        &["pvtu", "pvts", "pvtr", "pvti", "vtm", "vtmb"],
        Holds::Both,
        "joined to one mesh or grid, without ghosts; blocks of .vtm that are no meshes are left out",
    ),
    format(
        "legacy VTK",
        &["vtk"],
        Holds::Both,
        "unstructured, structured and rectilinear grids, structured points; no polyhedra",
    )
    .streamed(),
    format(
        "VTKHDF",
        &["vtkhdf", "hdf"],
        Holds::Both,
        "all grids and images, the meshes of collections as one; no AMR, no hypertrees",
    )
    .with_steps()
    .with("hdf5", cfg!(feature = "hdf5")),
    format(
        "Exodus II",
        &["e", "exo", "ex2", "exii"],
        Holds::Meshes,
        "in netCDF classic files, and with the feature `hdf5` in HDF5; blocks of volumes of order 1 and 2",
    )
    .with_steps()
    .with("exodus", cfg!(feature = "exodus")),
    format(
        "XDMF",
        &["xdmf", "xmf"],
        Holds::Both,
        "versions 2 and 3; numbers in XML, binary files, and with the feature `hdf5` in HDF5; curved cells of order 2, others by their corners; no polyhedra, no functions of finite elements",
    )
    .with_steps(),
    format(
        "CGNS",
        &["cgns"],
        Holds::Meshes,
        "in HDF5, not ADF; volumes of order 1 and 2, polyhedra, structured zones; solutions at vertices and in cells, without Rind; of moving meshes the first coordinates",
    )
    .with_steps()
    .with("hdf5", cfg!(feature = "hdf5")),
    format(
        "Gmsh",
        &["msh"],
        Holds::Meshes,
        "versions 2 and 4.1, text and binary; curved elements of order 2, tetrahedra and hexahedra to order 6, others by their corners",
    )
    .with_steps(),
    format(
        "Plot3D",
        &["bin", "xyz", "x", "g", "grd", "p3d"],
        Holds::Meshes,
        "single and multiple blocks, C and Fortran binary, IBLANK; fields from .q or .f files beside it; no text",
    ),
    format(
        "Tetrascope clusters",
        &["tsc"],
        Holds::Meshes,
        "tetrahedra in clusters that are read when they are drawn; one field; made by `pack`",
    )
    .written()
    .streamed(),
    format(
        "VTK XML images",
        &["vti"],
        Holds::Grids,
        "every encoding (LZMA by the feature `lzma`); direction, pieces, hidden points and cells",
    )
    .written()
    .streamed(),
    format(
        "MetaImage",
        &["mha", "mhd"],
        Holds::Grids,
        "raw, zlib and text, in one file or in slices; frames are fields",
    )
    .streamed(),
    format(
        "NRRD",
        &["nrrd", "nhdr"],
        Holds::Grids,
        "raw, gzip and text, attached and detached; no bzip2",
    )
    .streamed(),
    format(
        "NIfTI and Analyze 7.5",
        &["nii", "nii.gz", "hdr"],
        Holds::Grids,
        "versions 1 and 2, in one file or with .img; volumes, colors and complex numbers are fields",
    )
    .streamed(),
    format(
        "NumPy",
        &["npy", "npz"],
        Holds::Grids,
        "arrays a[z, y, x] of any type of numbers, with frames or channels; spacing and origin are given",
    )
    .streamed(),
    format(
        "MRC and CCP4 maps",
        &["mrc", "map", "ccp4", "rec", "st"],
        Holds::Grids,
        "modes 0 to 4, 6 and 12, also packed with gzip; right-angled cells",
    )
    .streamed(),
    format(
        "TIFF stacks",
        &["tif", "tiff"],
        Holds::Grids,
        "8 to 64 bits, tiles, BigTIFF, what ImageJ, OME and tifffile say; one file, no JPEG, no palettes",
    )
    .with("tiff", cfg!(feature = "tiff")),
    format(
        "DICOM series",
        &["dcm", "dicom", "ima"],
        Holds::Grids,
        "a folder, one of its files, or one file of several frames; evenly spaced parallel slices; native, RLE, JPEG and JPEG 2000; no JPEG-LS, no video",
    )
    .with("dicom", cfg!(feature = "dicom")),
    format(
        "raw samples",
        &["raw", "dat"],
        Holds::Grids,
        "of any name, if dims and type are given",
    )
    .streamed(),
    format(
        "ParaView collections",
        &["pvd", "series"],
        Holds::Series,
        "drawn as a series: one file for each time",
    ),
];

/// The formats that are read, in a sentence.
pub(crate) fn in_words() -> String {
    let read = FORMATS.iter().filter(|format| format.is_read).count();
    format!(
        "meshes are read from .vtu, .vtk, .msh and others, grids from .vti, .nii, .nrrd and others; the list of formats has all {read}"
    )
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;
    use crate::{FileData, ReadOptions, is_collection, read_file};

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            match path.is_dir() {
                true => found.extend(files(&path)),
                false => found.push(path),
            }
        }
        found
    }

    // A format that is new is listed, and says rightly what it holds.
    #[test]
    fn whatever_is_read_is_listed() {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
        let mut seen = [false; FORMATS.len()];
        for path in files(&fixtures) {
            let Ok(data) = read_file(&path, &ReadOptions::default()) else {
                continue; // scripts, parts of others, and what is refused
            };
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let is_it = |format: &FileFormat| {
                let mut extensions = format.extensions.iter();
                extensions.any(|e| name.ends_with(&format!(".{e}")))
            };
            // Some headers and their samples have names of their own.
            if name.ends_with(".img") || name.ends_with(".gz") {
                continue;
            }
            let index = FORMATS.iter().position(is_it);
            let index = index.unwrap_or_else(|| panic!("{} is not listed", path.display()));
            let holds = FORMATS[index].holds;
            let is_right = match data {
                FileData::Mesh(_) => matches!(holds, Holds::Meshes | Holds::Both),
                FileData::Grid(_) => matches!(holds, Holds::Grids | Holds::Both),
                FileData::Clusters(_) => holds == Holds::Meshes,
            };
            assert!(is_right, "{}: {holds:?}", path.display());
            seen[index] = true;
        }
        let unseen = FORMATS
            .iter()
            .zip(seen)
            .filter(|(format, seen)| !seen && format.is_read && format.holds != Holds::Series);
        let unseen: Vec<&str> = unseen.map(|(format, _)| format.name).collect();
        // Fixtures of these are made by their tests.
        let made = [
            "VTKHDF",
            "Tetrascope clusters",
            "CGNS",
            "Plot3D",
            "VTK XML images",
            "MetaImage",
            "NRRD",
            "raw samples",
        ];
        assert!(unseen.iter().all(|name| made.contains(name)), "{unseen:?}");
    }

    #[test]
    fn no_extension_is_listed_twice() {
        let extensions: Vec<&str> = FORMATS.iter().flat_map(|f| f.extensions).copied().collect();
        for (i, extension) in extensions.iter().enumerate() {
            assert!(!extensions[..i].contains(extension), "{extension}");
        }
        for named in ["vtu", "vtk", "vti", "nrrd"] {
            assert!(extensions.contains(&named) && in_words().contains(named));
        }
        assert!(is_collection(Path::new("a.pvd")));
    }
}
