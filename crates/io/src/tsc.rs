//! `.tsc`: tetrahedral meshes in clusters, for meshes that need not fit in memory.
//!
//! [`write_tsc`] cuts cells along a Hilbert curve and writes cluster after cluster, in bounded memory;
//! [`open_tsc`] reads what is known of the clusters, and each when it is asked for.
//!
//! # Layout, version 1
//! All numbers are little-endian. A header of 56 bytes, the clusters one behind the other from byte 56 on, and
//! behind them the directory, which is the end of the file: no byte is in two parts, and none in no part.
//!
//! | byte | type | header |
//! |---|---|---|
//! | 0 | 8 bytes | `89 54 53 43 0D 0A 1A 0A` |
//! | 8 | u32 | the version, 1 |
//! | 12 | u32 | 0 where values are at points, 1 where they are in cells |
//! | 16 | u64 | tetrahedra |
//! | 24 | u64 | clusters |
//! | 32 | u64 | where the directory begins |
//! | 40 | u64 | bytes of the directory |
//! | 48 | u32 | checksum of the directory |
//! | 52 | u32 | checksum of the bytes before |
//!
//! The directory is the field's name (u32 bytes, and UTF-8), some of its values evenly spread (u32, and so many f64),
//! and 88 bytes for each cluster:
//!
//! | type | cluster |
//! |---|---|
//! | u64 | where it begins |
//! | u32 | tetrahedra, at least 1 |
//! | u32 | points |
//! | u32 | bit 0: positions are f32 and not f64; bit 1: values are |
//! | u32 | checksum of its bytes |
//! | 6 f64 | the box around its points: least x, y, z, greatest x, y, z |
//! | 2 f64 | its least and greatest finite value; NaN where there is none |
//!
//! A cluster is its points (x, y, z each), its values, one for each point or for each tetrahedron, and its tetrahedra,
//! four indices of its points each (u32). Floats are of 32 bits where those hold all of a cluster's numbers
//! exactly. Points that clusters have in common are in each of them, with the same bits. A value that is not finite is none.
//! Checksums are CRC-32 (that of zlib and PNG).
//!
//! A tetrahedron takes 16 bytes, and 4 or 8 more for a value of its own; a point 16 to 32.

mod format;
mod open;
#[cfg(test)]
mod tests;
mod write;

pub use open::open_tsc;
pub use write::{Packed, check_path, write_tsc};

pub(crate) use format::MAGIC;
