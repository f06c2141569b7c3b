//! Files as lists of parts, so that mutations reach what lies behind a compression.

use std::io::{self, Read as _, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

/// Bytes as they are before a file's own packing.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) bytes: Vec<u8>,
    /// So many zeros follow the bytes of a compressed part: much to read from a small file.
    pub(crate) zeros: usize,
    pub(crate) wrap: Wrap,
}

/// How a part stands in its file.
#[derive(Clone)]
pub(crate) enum Wrap {
    Plain,
    Gzip,
    Zlib,
    /// An inline array of a VTK XML file, with a header of 32-bit words; `edit` puts another
    /// number in place of one of them.
    Vtk {
        compressor: Option<Compressor>,
        edit: Option<(usize, u32)>,
    },
}

#[derive(Clone, Copy)]
pub(crate) enum Compressor {
    Zlib,
    Lz4,
}

/// Bytes of a block of compressed VTK data, small so that arrays have several; with many
/// zeros there are several in any case.
const BLOCK: usize = 64;
const BLOCK_OF_ZEROS: usize = 1 << 20;

impl Part {
    pub(crate) fn plain(bytes: impl Into<Vec<u8>>) -> Part {
        Part::wrapped(bytes, Wrap::Plain)
    }

    pub(crate) fn wrapped(bytes: impl Into<Vec<u8>>, wrap: Wrap) -> Part {
        Part {
            bytes: bytes.into(),
            zeros: 0,
            wrap,
        }
    }

    fn write(&self, file: &mut Vec<u8>) {
        match &self.wrap {
            Wrap::Plain => file.extend_from_slice(&self.bytes),
            Wrap::Gzip => {
                let encoder = GzEncoder::new(file, Compression::fast());
                let finish = |encoder: GzEncoder<_>| encoder.finish();
                self.copy_to(encoder).and_then(finish).expect(MEMORY);
            }
            Wrap::Zlib => {
                let encoder = ZlibEncoder::new(file, Compression::fast());
                let finish = |encoder: ZlibEncoder<_>| encoder.finish();
                self.copy_to(encoder).and_then(finish).expect(MEMORY);
            }
            Wrap::Vtk { compressor, edit } => {
                file.extend(self.vtk_array(*compressor, *edit).into_bytes());
            }
        }
    }

    fn copy_to<W: Write>(&self, mut writer: W) -> io::Result<W> {
        writer.write_all(&self.bytes)?;
        io::copy(&mut io::repeat(0).take(self.zeros as u64), &mut writer)?;
        Ok(writer)
    }

    /// Base64 of a header and of the data, each by itself where the data is compressed.
    fn vtk_array(&self, compressor: Option<Compressor>, edit: Option<(usize, u32)>) -> String {
        let Some(compressor) = compressor else {
            let mut length = self.bytes.len() as u32;
            if let Some((_, number)) = edit {
                length = number;
            }
            return BASE64.encode([&length.to_le_bytes()[..], &self.bytes].concat());
        };
        let size = match self.zeros {
            0 => BLOCK,
            _ => BLOCK_OF_ZEROS,
        };
        // One block at a time: all of the zeros would be much memory.
        let length = self.bytes.len() + self.zeros;
        let mut plain = self.bytes.chain(io::repeat(0)).take(length as u64);
        let (mut lengths, mut data) = (Vec::new(), Vec::new());
        for start in (0..length).step_by(size) {
            let mut block = vec![0; size.min(length - start)];
            plain.read_exact(&mut block).expect(MEMORY);
            let packed = compressor.pack(&block);
            lengths.push(packed.len() as u32);
            data.extend(packed);
        }
        let mut header = vec![lengths.len() as u32, size as u32, (length % size) as u32];
        header.extend(lengths);
        if let Some((place, number)) = edit {
            let place = place % header.len();
            header[place] = number;
        }
        let header: Vec<u8> = header.into_iter().flat_map(u32::to_le_bytes).collect();
        BASE64.encode(header) + &BASE64.encode(data)
    }
}

impl Compressor {
    pub(crate) fn pack(self, block: &[u8]) -> Vec<u8> {
        match self {
            Compressor::Zlib => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
                let written = encoder.write_all(block).and_then(|()| encoder.finish());
                written.expect(MEMORY)
            }
            Compressor::Lz4 => lz4_flex::block::compress(block),
        }
    }
}

const MEMORY: &str = "memory can be read and written";

/// The file that consists of `parts`.
pub(crate) fn pack(parts: &[Part]) -> Vec<u8> {
    let mut file = Vec::new();
    for part in parts {
        part.write(&mut file);
    }
    file
}
