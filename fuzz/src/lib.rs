//! Input that means harm, in two ways.
//!
//! 1. [`targets`]: what libFuzzer calls, guided by coverage, once for each input; see
//!    `guided/`. The inputs that it has found worth keeping lie in `corpora/`, and the tests
//!    read them all.
//! 2. `campaign`: mutated files. An input is a valid file (`seeds`) with a few changes
//!    (`mutate`), some of them made before compression (`pack`). Worker processes (`worker`)
//!    read inputs (`reader`) and are watched: no input may panic, end the process, take
//!    longer than a time limit or more memory than [`allowed`], or leave a message that is
//!    not one printable line. A seed and an index stand for an input, everywhere and always
//!    as long as fixtures and mutations stay the same.

mod campaign;
mod cli;
mod mutate;
mod pack;
mod random;
mod reader;
mod seeds;
pub mod targets;
mod worker;
pub mod zip;

pub use cli::main;
pub use peak_alloc::PeakAlloc;

/// Memory that reading a file may take: this and [`PER_BYTE`] times the file, bytes.
pub(crate) const MEMORY: u64 = 200_000_000;
/// See [`MEMORY`].
pub(crate) const PER_BYTE: u64 = 60;

/// The most memory that reading a file of `length` bytes may take, bytes.
pub fn allowed(length: usize) -> u64 {
    MEMORY + PER_BYTE * length as u64
}
