//! Files in and out: meshes and grids from many formats, images as PNG, EXR and NPY, grids as
//! `.vti` and meshes as `.vtu`.
//!
//! [`read_file`] finds out the format and returns [`MeshData`], which is points, cells,
//! every scalar field, and what was noticed on the way, or [`GridData`], which is samples
//! and where they lie. [`read_steps`] lists the time steps of one file, [`read_collection`] the
//! files of a series. [`write_image`] writes a frame with its metadata, [`write_grid`] and
//! [`write_vti`] the samples of a grid, [`write_vtu`] a mesh with all its fields, [`write_tsc`] one in clusters, whole or not at all.
//!
//! [`FORMATS`] lists these for programs.
//!
//! | format | what is read |
//! |---|---|
//! | Plot3D | single and multiple blocks, C and Fortran binary, both byte orders, 32 and 64 bits, IBLANK; see [`plot3d`] |
//! | `.vtu` | VTK XML unstructured grids in every encoding; polyhedra; see [`vtu`] |
//! | `.vts`, `.vtr` | VTK XML structured and rectilinear grids, as `.vtu`; pieces by extent, blanking; evenly spaced `.vtr` as images; see [`vtu`] |
//! | `.pvtu`, `.pvts`, `.pvtr` | the pieces that it lists as one mesh, without ghosts; see [`vtu`] |
//! | `.pvti`, `.pvtr` | the pieces that it lists as one image, if evenly spaced; see [`vtu`] |
//! | `.vtm` | VTK XML blocks, nested or not: the meshes among them as one; see [`vtu`] |
//! | `.vti` | VTK XML images, as `.vtu`; cell data, `Direction`, pieces, hidden points and cells; see [`vtu`] |
//! | `.vtk` | legacy VTK unstructured, structured and rectilinear grids, structured points; see [`vtk`] |
//! | `.vtkhdf`, `.hdf` | VTKHDF: unstructured, structured and rectilinear grids, images, and the meshes of collections; time steps; see [`vtkhdf`] |
//! | `.msh` | Gmsh 2 and 4.1, text and binary, both byte orders; fields at nodes and of elements; time steps; see [`gmsh`] |
//! | `.e`, `.exo`, `.ex2` | Exodus II in netCDF classic and HDF5 files; variables at nodes and of elements; time steps; see [`exodus`] |
//! | `.xdmf`, `.xmf` | XDMF 2 and 3: meshes and grids with numbers in XML, binary and HDF5 files; collections, time steps; see [`xdmf`] |
//! | `.tsc` | Tetrascope's own: meshes in clusters, which stay in the file; see [`tsc`] |
//! | `.cgns` | CGNS in HDF5: unstructured zones with polyhedra, structured zones; solutions, time steps; see [`cgns`] |
//! | `.mha`, `.mhd` | MetaImage: raw, zlib and text, in one file or in slices; frames; see [`grid`] |
//! | `.nrrd`, `.nhdr` | NRRD: raw, gzip and text, attached and detached; `kinds`, `space`; see [`grid`] |
//! | `.nii`, `.nii.gz`, `.hdr` with `.img` | NIfTI-1 and NIfTI-2 with all of their volumes, complex numbers and colors; Analyze 7.5; see [`grid`] |
//! | `.npy`, `.npz` | NumPy arrays `a[z, y, x]` with frames and channels; spacing by [`ReadOptions::spacing`]; see [`grid`] |
//! | `.mrc`, `.map`, `.ccp4`, `.rec`, `.st` | MRC and CCP4 maps, modes 0 to 4, 6 and 12, also packed with gzip; see [`grid`] |
//! | `.tif`, `.tiff` | TIFF and BigTIFF stacks, with what ImageJ, OME and tifffile say of them; see [`grid`] |
//! | any | raw samples, described by [`ReadOptions::raw`] |
//! | `.pvd`, `.series` | the files of a series and their times; see [`collection`] |
//!
//! Samples of grids stay 8- and 16-bit integers or 32-bit floats, as they are stored;
//! other types become 32-bit floats, with a note if that rounds, less an offset where they
//! would lose what varies. A sample that is not finite, or is beyond 32-bit floats, or is a
//! mark of no value, is NaN; notes count them.
//!
//! Exodus is read with the feature `exodus`; VTKHDF, CGNS and what XDMF has in HDF5 with `hdf5`;
//! Exodus in HDF5 with both; TIFF with `tiff`; VTK files packed with LZMA with `lzma`. All are on
//! by default.
//!
//! # Fields of meshes
//! They have the file's names, also for components: `Velocity-magnitude`, `stress-XY`; a
//! component without a name has its number. [`MeshData::choose`] says what a name means.
//! Values are decoded when they are asked for, so that a file of many fields needs the
//! memory of one.
//!
//! # Hostile files
//! Meshes and VTK files are read to memory, HDF5 files, clusters and samples of other grids a part at a
//! time, and every
//! count in them is checked against the bytes that are there before anything is allocated by
//! it. What is wrong is an [`Error::Format`](tetrascope_core::Error::Format) of one line that
//! says what and where.
//!
//! Memory is bounded by the bytes n of all files that are read:
//!
//! | what | at most |
//! |---|---|
//! | anything, with what [`MeshData`] and [`GridData`] make of it | 200 MB + 60 n, and what is packed |
//! | points and cells of a packed mesh | 32 MB + 32 n: points that no cell uses are left out beyond that, and cells that are more repeat each other and are refused |
//! | a variable of Exodus in HDF5, and the cells | as points and cells of a packed mesh |
//! | chunks of HDF5 that are held while a part is read | 16 MiB, and one chunk: 256 MiB, and 1 GiB + 64 n |
//! | points and cells of a rectilinear grid, which three axes stand for | 1 GiB + 64 n |
//! | samples of a packed grid, in the type in which they are stored | 1 GiB + 64 n, and 1032 n: deflate makes no more of a byte; 2560 n of LZW, 7100 n of LZMA. What is more is refused. Five times that for a moment where samples become floats |
//! | a scene, a collection or list of files, a header of a grid | 1 MiB, 4 MiB, 1 MiB: what is longer is none |
//!
//! A file that names others (`.mhd`, `.nhdr`, `.pvd`, `.series`, `.pvtu`, `.pvti` and the like, `.vtm`, `.xdmf`) names each once, `.xdmf` as often as it likes, and in its own
//! folder or below: `..` and absolute names are refused. HDF5 files name no others: what is in
//! other files is refused. Arrays of a VTK file may not all lie at one place, and neither arrays
//! of an `.npz` nor strips and directories of a TIFF may overlap. Tests hold every reader to this,
//! and so does `cargo xtask fuzz`, but of XDMF and HDF5 files, for which it is argued from the code.
//!
//! # A file in, a file out
//! ```
//! use tetrascope_core::{Frame, FrameStats, Volume};
//! use tetrascope_io::{FileData, ReadOptions, read_file, write_image};
//!
//! # let folder = tempfile::tempdir().expect("a folder for files");
//! # let path = folder.path().join("mesh.vtk");
//! # std::fs::write(&path, "# vtk DataFile Version 3.0\none cell\nASCII\n\
//! #     DATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0  1 0 0  0 1 0  0 0 1\n\
//! #     CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n\
//! #     SCALARS height float\nLOOKUP_TABLE default\n0 0 0 1\n").expect("written");
//! let data = read_file(&path, &ReadOptions::default())?; // "mesh.vtk", or any other format
//! let volume = match data {
//!     FileData::Mesh(mesh) => {
//!         assert_eq!(mesh.field_list(), ["height [0, 1] (point)"]);
//!         Volume::Mesh(mesh.into_mesh(Some("height"))?)
//!     }
//!     FileData::Grid(grid) => grid.into_volume(None)?.0, // its first field
//!     FileData::Clusters(clusters) => Volume::Clusters(clusters),
//! };
//! assert_eq!(volume.cell_count(), 1);
//!
//! // A renderer makes frames; this one is half transparent red. The metadata is in the file.
//! let frame = Frame::new((2, 1), vec![[0.5, 0.0, 0.0, 0.5]; 2], FrameStats::default());
//! let picture = path.with_extension("png"); // or "exr", or "npy"
//! write_image(&picture, &frame, &[("Title".into(), "red".into())])?;
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

mod appended;
#[cfg(feature = "hdf5")]
pub mod cgns;
pub mod collection;
#[cfg(test)]
mod damage;
#[cfg(feature = "exodus")]
pub mod exodus;
mod fields;
mod formats;
pub mod gmsh;
pub mod grid;
#[cfg(feature = "hdf5")]
mod hdf5;
mod higher_order;
pub mod image;
pub mod lists;
mod mesh_data;
mod pieces;
pub mod plot3d;
mod polyhedra;
mod read;
mod source;
mod steps;
pub mod tsc;
pub mod vti;
pub mod vtk;
#[cfg(feature = "hdf5")]
pub mod vtkhdf;
pub mod vtu;
mod whole_file;
pub mod xdmf;

pub use appended::Compression;
pub use collection::{Step, is_collection, read_collection};
pub use formats::{FORMATS, FileFormat, Holds};
pub use grid::{FieldSamples, GridData, GridField, RawFile};
pub use image::{encode_exr, encode_npy, encode_png, write_file, write_image};
pub use mesh_data::{MeshData, MeshField};
pub use read::{FileData, ReadOptions, read_file, read_mesh};
pub use steps::{StepChoice, read_steps};
pub use tsc::{open_tsc, write_tsc};
pub use vti::{COVERAGE, write_grid, write_vti};
pub(crate) use vtk::parse_float;
pub use vtu::write_vtu;
pub use whole_file::{TemporaryFolder, remove_temporary_files_and};
