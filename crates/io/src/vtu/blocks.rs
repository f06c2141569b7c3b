//! Compressed blocks, several at a time.

use std::borrow::Cow;
use std::io::Read as _;

use flate2::read::ZlibDecoder;
use flate2::{Decompress, FlushDecompress, Status};
use rayon::prelude::*;
use tetrascope_core::Error;

use super::decode::{CHUNK, Sink};
use super::document::Compressor;
#[cfg(feature = "lzma")]
use super::xz;
use crate::source::room;

/// Decompressed bytes of blocks that are worth the threads. VTK's blocks have 32 KiB.
const ENOUGH: usize = 2 << 20;

/// As many blocks are enough, however small they are.
const MOST: usize = 1024;

/// Larger blocks are decompressed by themselves, in parts.
const LARGEST: usize = 256 << 10;

/// Blocks of an array that wait to be decompressed.
pub(super) struct Blocks<'a> {
    compressor: &'a Compressor,
    waiting: Vec<Block<'a>>,
    /// The decompressed bytes of neighbors; at most [`ENOUGH`] and [`LARGEST`] together.
    bytes: Vec<u8>,
}

struct Block<'a> {
    number: u64,
    compressed: Cow<'a, [u8]>,
    /// Decompressed.
    size: usize,
}

impl<'a> Blocks<'a> {
    pub(super) fn new(compressor: &'a Compressor) -> Blocks<'a> {
        Blocks {
            compressor,
            waiting: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// Adds the next block of the array, which must hold `size` bytes.
    pub(super) fn push(&mut self, number: u64, compressed: Cow<'a, [u8]>, size: usize) {
        self.waiting.push(Block {
            number,
            compressed,
            size,
        });
    }

    /// Whether it is time to decompress them.
    pub(super) fn are_enough(&self) -> bool {
        let sizes = self.waiting.iter().map(|block| block.size);
        self.waiting.len() >= MOST || sizes.fold(0, usize::saturating_add) >= ENOUGH
    }

    /// Calls `sink` with the bytes of all blocks, in order; then none is waiting.
    ///
    /// Stops at a block that holds anything else than it must: gives its number and what its
    /// size should be.
    pub(super) fn decompress(&mut self, sink: Sink) -> Result<Option<(u64, usize)>, Error> {
        let waiting = std::mem::take(&mut self.waiting);
        for blocks in waiting.chunk_by(|a, b| a.size.max(b.size) <= LARGEST) {
            let broken = match blocks {
                [block] => (!in_parts(self.compressor, block, sink)?).then_some(block),
                _ => self.side_by_side(blocks, sink)?,
            };
            if let Some(block) = broken {
                return Ok(Some((block.number, block.size)));
            }
        }
        Ok(None)
    }

    /// Decompresses small blocks in parallel; gives the first that is broken, before which
    /// `sink` gets all bytes.
    fn side_by_side<'b>(
        &mut self,
        blocks: &'b [Block<'a>],
        sink: Sink,
    ) -> Result<Option<&'b Block<'a>>, Error> {
        let total = blocks.iter().map(|block| block.size).sum();
        self.bytes.resize(total, 0);
        let mut rest = self.bytes.as_mut_slice();
        let mut places = Vec::with_capacity(blocks.len());
        for block in blocks {
            let (place, others) = rest.split_at_mut(block.size);
            places.push(place);
            rest = others;
        }
        let compressor = self.compressor;
        let fill = |inflate: &mut Decompress, (block, place): (&Block, &mut [u8])| match compressor
        {
            Compressor::None | Compressor::Unknown(_) => false,
            Compressor::Zlib => {
                inflate.reset(true);
                let end = inflate.decompress(&block.compressed, place, FlushDecompress::Finish);
                matches!(end, Ok(Status::StreamEnd)) && inflate.total_out() == place.len() as u64
            }
            Compressor::Lz4 => fill_lz4(&block.compressed, place),
            #[cfg(feature = "lzma")]
            Compressor::Lzma => xz::fill(&block.compressed, place),
        };
        let pairs = blocks.par_iter().zip(places);
        let whole = pairs.map_init(|| Decompress::new(true), fill);
        let whole: Vec<bool> = whole.collect();
        let good = whole.iter().take_while(|whole| **whole).count();
        let bytes = blocks[..good].iter().map(|block| block.size).sum();
        sink(&self.bytes[..bytes])?;
        Ok(blocks.get(good))
    }
}

/// Calls `sink` with the bytes of a block of any size, in parts; false if it holds anything
/// else than it must.
fn in_parts(compressor: &Compressor, block: &Block, sink: Sink) -> Result<bool, Error> {
    let size = block.size;
    match compressor {
        Compressor::None | Compressor::Unknown(_) => Ok(false),
        Compressor::Zlib => {
            let mut decoder = ZlibDecoder::new(&*block.compressed);
            let mut part = vec![0; CHUNK.min(size + 1)];
            let mut left = size;
            loop {
                match decoder.read(&mut part) {
                    Ok(0) => return Ok(left == 0),
                    Ok(read) if read <= left => {
                        left -= read;
                        sink(&part[..read])?;
                    }
                    _ => return Ok(false),
                }
            }
        }
        Compressor::Lz4 => whole(fill_lz4, block, sink),
        #[cfg(feature = "lzma")]
        Compressor::Lzma => whole(xz::fill, block, sink),
    }
}

/// Calls `sink` with all bytes of a block, which `fill` writes to a place for them; false if it
/// holds anything else than it must.
fn whole(fill: fn(&[u8], &mut [u8]) -> bool, block: &Block, sink: Sink) -> Result<bool, Error> {
    let mut bytes = room(block.size)?;
    bytes.resize(block.size, 0);
    if !fill(&block.compressed, &mut bytes) {
        return Ok(false);
    }
    sink(&bytes)?;
    Ok(true)
}

/// Whether a block holds just the bytes for a place, which it then fills.
fn fill_lz4(compressed: &[u8], place: &mut [u8]) -> bool {
    let written = lz4_flex::block::decompress_into(compressed, place);
    written.is_ok_and(|written| written == place.len())
}
