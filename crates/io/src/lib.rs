//! Files in and out: meshes from Plot3D and VTK files, images as PNG, EXR and NPY.
//!
//! [`read_mesh`] finds out the format and returns [`MeshData`]: points, cells,
//! every scalar field, and what was noticed on the way. [`write_image`] writes
//! a frame with its metadata, whole or not at all.
//!
//! | format | what is read |
//! |---|---|
//! | Plot3D | single and multiple blocks, C and Fortran binary, both byte orders, 32 and 64 bits, IBLANK; see [`plot3d`] |
//! | `.vtu` | VTK XML unstructured grids in every encoding but lzma; see [`vtu`] |
//! | `.vtk` | legacy VTK unstructured and structured grids; see [`vtk`] |
//!
//! # Hostile files
//! Files are read to memory and every count in them is checked against the
//! bytes that are there before anything is allocated by it. What is wrong is an
//! [`Error::Format`](tetrascope_core::Error::Format) that says what and where.

mod fields;
pub mod image;
mod mesh_data;
pub mod plot3d;
mod read;
mod source;
pub mod vtk;
pub mod vtu;

pub use image::{encode_exr, encode_npy, encode_png, write_file, write_image};
pub use mesh_data::MeshData;
pub use read::{ReadOptions, read_mesh};
