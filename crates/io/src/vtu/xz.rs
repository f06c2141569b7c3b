//! Blocks packed with LZMA, each of which is a whole `.xz` file.
//!
//! *The .xz File Format*, version 1.2.1, <https://tukaani.org/xz/xz-file-format.txt>: a header,
//! blocks of LZMA2, an index, a footer. What VTK writes has one block, of the filter LZMA2 alone.
//! The container is read here, and LZMA2 by `lzma-rust2`, as much of it as a block may hold. The
//! dictionary, which a file may ask to be 4 GiB, is never larger than that.
//!
//! CRC-32, which VTK writes, is compared. Other checks are passed over, and so are the index
//! and the footer, which say nothing that is not known by then.

use std::io::Read as _;

use flate2::Crc;
use lzma_rust2::Lzma2Reader;

/// How a file begins; two bytes of flags and their checksum follow.
const MAGIC: &[u8] = b"\xfd7zXZ\0";
const HEADER: usize = 12;

/// The filter LZMA2.
const LZMA2: u8 = 0x21;

/// The smallest dictionary, bytes.
const SMALLEST: usize = 1 << 12;

/// Whether a `.xz` file holds just the bytes for a place, which it then fills.
pub(super) fn fill(file: &[u8], place: &mut [u8]) -> bool {
    unpack(file, place) == Some(())
}

/// `None` for a file that is damaged or holds anything else.
fn unpack(file: &[u8], mut left: &mut [u8]) -> Option<()> {
    let (header, mut rest) = file.split_at_checked(HEADER)?;
    // By the kind of check: nothing, CRC-32, CRC-64, SHA-256.
    let check_length = match header.strip_prefix(MAGIC)? {
        [0, 0, ..] => 0,
        [0, 1, ..] => 4,
        [0, 4, ..] => 8,
        [0, 10, ..] => 32,
        _ => return None,
    };
    // A block begins with the length of its header; 0 is the index, which follows the last one.
    while *rest.first()? != 0 {
        let (header, body) = rest.split_at_checked(4 * (usize::from(rest[0]) + 1))?;
        let dictionary = dictionary(header)?.min(left.len()).max(SMALLEST);
        let mut reader = Lzma2Reader::new(body, u32::try_from(dictionary).ok()?, None);
        let mut filled = 0;
        while filled < left.len() {
            match reader.read(&mut left[filled..]).ok()? {
                0 => break,
                read => filled += read,
            }
        }
        if filled == left.len() && reader.read(&mut [0]).ok()? > 0 {
            return None;
        }
        let (content, after) = std::mem::take(&mut left).split_at_mut(filled);
        let packed = body.len() - reader.into_inner().len();
        let padded = packed.next_multiple_of(4); // headers are multiples of 4, too
        let check = body.get(padded..padded + check_length)?;
        let is_wrong = check_length == 4 && check != checksum(content);
        if is_wrong || body[packed..padded].iter().any(|byte| *byte != 0) {
            return None;
        }
        (rest, left) = (&body[padded + check_length..], after);
    }
    left.is_empty().then_some(())
}

/// The size of the dictionary in the header of a block whose only filter is LZMA2.
fn dictionary(header: &[u8]) -> Option<usize> {
    let (header, check) = header.split_at_checked(header.len() - 4)?;
    let [_, flags, fields @ ..] = header else {
        return None;
    };
    let mut fields = fields;
    // Lengths of packed and unpacked bytes, with 7 bits in each byte, are found out anyway.
    for is_there in [flags & 0x40 != 0, flags & 0x80 != 0] {
        if is_there {
            let end = fields.iter().position(|byte| byte & 0x80 == 0)?;
            fields = &fields[end + 1..];
        }
    }
    let more_filters = flags & 0x3f != 0;
    let size = match fields {
        // 4 KiB, 6 KiB, 8 KiB, 12 KiB and so on.
        [LZMA2, 1, bits @ 0..40, ..] => (2 | usize::from(bits & 1)) << (bits / 2 + 11),
        [LZMA2, 1, 40, ..] => u32::MAX as usize,
        _ => return None,
    };
    (!more_filters && check == checksum(header)).then_some(size)
}

fn checksum(bytes: &[u8]) -> [u8; 4] {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum().to_le_bytes()
}

#[cfg(test)]
mod tests;
