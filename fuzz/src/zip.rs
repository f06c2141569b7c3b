//! Zip archives as NumPy writes them, whose directories may lie.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::DeflateEncoder;

/// A file in an archive.
pub struct Member<'a> {
    /// Its name in the archive.
    pub name: &'a str,
    /// Its bytes, unpacked.
    pub bytes: &'a [u8],
    /// Stored as they are if not.
    pub is_deflated: bool,
}

/// A member's entry in the directory.
pub struct Entry {
    /// 0 stored, 8 deflated.
    pub method: u16,
    /// Bytes in the archive.
    pub packed: u32,
    /// Bytes that they unpack to.
    pub unpacked: u32,
    /// Where the member's own header is.
    pub start: u32,
}

/// The archive of `members`; `lie` may change what the directory says of each, but not what
/// their own headers say. Checksums are 0, as nobody compares them.
pub fn zip(members: &[Member], mut lie: impl FnMut(usize, &mut Entry)) -> Vec<u8> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for (i, member) in members.iter().enumerate() {
        let packed = match member.is_deflated {
            true => deflated(member.bytes),
            false => member.bytes.to_vec(),
        };
        let mut entry = Entry {
            method: if member.is_deflated { 8 } else { 0 },
            packed: packed.len() as u32,
            unpacked: member.bytes.len() as u32,
            start: archive.len() as u32,
        };
        archive.extend(b"PK\x03\x04\x14\0");
        archive.extend(common(&entry, member.name));
        archive.extend(member.name.as_bytes());
        archive.extend(packed);
        lie(i, &mut entry);
        directory.extend(b"PK\x01\x02\x14\0\x14\0");
        directory.extend(common(&entry, member.name));
        // No comment, the first disk, no attributes.
        directory.extend([0; 10]);
        directory.extend(entry.start.to_le_bytes());
        directory.extend(member.name.as_bytes());
    }
    let count = (members.len() as u16).to_le_bytes();
    let (start, length) = (archive.len() as u32, directory.len() as u32);
    archive.extend(directory);
    archive.extend(b"PK\x05\x06\0\0\0\0");
    archive.extend([count, count].concat());
    archive.extend(length.to_le_bytes());
    archive.extend(start.to_le_bytes());
    archive.extend([0; 2]); // no comment
    archive
}

/// The bytes that a member's header and its entry have in common: from the flags to the extra length.
fn common(entry: &Entry, name: &str) -> Vec<u8> {
    let mut bytes = vec![0; 2]; // flags
    bytes.extend(entry.method.to_le_bytes());
    bytes.extend([0; 8]); // time and checksum
    bytes.extend(entry.packed.to_le_bytes());
    bytes.extend(entry.unpacked.to_le_bytes());
    bytes.extend((name.len() as u16).to_le_bytes());
    bytes.extend([0; 2]); // nothing extra
    bytes
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("memory can be written")
}
