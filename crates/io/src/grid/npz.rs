//! Archives of NumPy arrays, `.npz`: a zip file of `.npy` files, stored or deflated.
//!
//! Each array of three axes or more is a field, or several; see [`npy`] for the order of axes.
//! Checksums are not compared, so that arrays that are stored can stay in the file. Arrays whose
//! bytes overlap are refused.
//!
//! The directory is read by `rawzip`: it has no dependencies and no unsafe code, says where
//! a member's bytes stand, and leaves the unpacking to us; `zip` brings its own way to unpack
//! and does not read members in parts.

use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};
use tetrascope_core::Error;

use super::npy::{Header, Place};
use super::payload::{Encoding, UNPACK, most_unpacked};
use super::{GridData, MOST_FILES, MOST_NOTES};
use crate::ReadOptions;
use crate::source::open_file;

/// How a zip file begins that has a member.
const MAGIC: &[u8] = b"PK\x03\x04";

/// Whether this is the beginning of an archive of arrays, by its name or its first member's.
pub(crate) fn is_npz(head: &[u8], name: &str) -> bool {
    let first = || {
        // A member's header has its name's length at byte 26, and the name at 30.
        let length = head.get(26..28)?;
        let length = u16::from_le_bytes([length[0], length[1]]);
        Some(head.get(30..30 + usize::from(length))?.ends_with(b".npy"))
    };
    head.starts_with(MAGIC) && (name.ends_with(".npz") || first().unwrap_or(false))
}

/// An array in an archive.
struct Member {
    name: String,
    encoding: Encoding,
    /// Where its packed bytes are.
    start: u64,
    end: u64,
    /// Bytes that they unpack to, as the directory says.
    length: u64,
}

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<GridData, Error> {
    let mut data = GridData {
        fields: Vec::new(),
        space: None,
        notes: Vec::new(),
        files: vec![path.to_owned()],
    };
    let (mut left_out, mut noted) = (Vec::new(), Vec::new());
    let (_, file_length) = open_file(path)?;
    let mut unpacked = 0u64;
    for member in members(path)? {
        let at = format!("array '{}'", member.name);
        let wrong = |what: String, help: Option<&str>| Error::Format {
            path: path.to_owned(),
            at: at.clone(),
            what,
            help: help.map(String::from),
        };
        let header = member.header(path)?.map_err(|what| wrong(what, None))?;
        if header.shape.len() < 3 {
            left_out.push(format!("'{}' of shape {:?}", member.name, header.shape));
            continue;
        }
        // So that no bytes of other members are read.
        let needed = header.bytes().unwrap_or(u64::MAX);
        if needed > member.length {
            return Err(wrong(
                format!(
                    "the array needs {needed} bytes, but {} are in the archive",
                    member.length
                ),
                Some("the file is truncated or damaged; copy or write it again"),
            ));
        }
        unpacked = unpacked.saturating_add(needed);
        if unpacked > most_unpacked(file_length) {
            let what =
                format!("{unpacked} bytes of samples are in {file_length}, which is refused");
            return Err(wrong(what, Some(UNPACK)));
        }
        let place = Place {
            path,
            start: member.start,
            encoding: member.encoding,
            name: &member.name,
        };
        let array = header.description(&place, options)?;
        let array = array.read(path, options.stream_above)?;
        data.fields.extend(array.fields);
        noted.extend(array.notes);
    }
    if data.fields.is_empty() {
        return Err(Error::Format {
            path: path.to_owned(),
            at: "the archive".into(),
            what: "there is no array of three axes or more".into(),
            help: None,
        });
    }
    for note in noted {
        if !data.notes.contains(&note) && data.notes.len() < MOST_NOTES {
            data.notes.push(note);
        }
    }
    if let Some(first) = left_out.first() {
        let others = match left_out.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        data.notes.push(format!(
            "array {first}{others} left out: a volume has three axes"
        ));
    }
    Ok(data)
}

/// The arrays of an archive, in the directory's order.
fn members(path: &Path) -> Result<Vec<Member>, Error> {
    let damaged = |error: rawzip::Error| Error::Format {
        path: path.to_owned(),
        at: "the archive's directory".into(),
        what: format!("the archive is damaged: {error}"),
        help: Some("the file is truncated or damaged; copy or write it again".into()),
    };
    let refuse = |what: String| Error::Format {
        path: path.to_owned(),
        at: "the archive's directory".into(),
        what,
        help: Some("write the arrays again, by numpy.savez".into()),
    };
    let (file, file_length) = open_file(path)?;
    let mut buffer = vec![0; rawzip::RECOMMENDED_BUFFER_SIZE];
    let archive = ZipArchive::from_file(file, &mut buffer).map_err(damaged)?;
    let mut entries = archive.entries(&mut buffer);
    let mut members = Vec::new();
    while let Some(entry) = entries.next_entry().map_err(damaged)? {
        let name = String::from_utf8_lossy(entry.file_path().as_bytes()).into_owned();
        let Some(name) = name.strip_suffix(".npy") else {
            continue;
        };
        let encoding = match entry.compression_method() {
            CompressionMethod::STORE => Encoding::Raw,
            CompressionMethod::DEFLATE => Encoding::Deflate,
            other => return Err(refuse(format!("'{name}' is packed by {other:?}"))),
        };
        if entry.flags().is_encrypted() {
            return Err(refuse(format!("'{name}' is encrypted")));
        }
        let wayfinder = entry.wayfinder();
        let length = wayfinder.uncompressed_size_hint();
        let (start, end) = archive
            .get_entry(wayfinder)
            .map_err(damaged)?
            .compressed_data_range();
        let is_there = start <= end && end <= file_length;
        if !is_there || (encoding == Encoding::Raw && end - start < length) {
            return Err(refuse(format!("'{name}' is not where its header says")));
        }
        if members.len() == MOST_FILES {
            return Err(refuse(format!("more than {MOST_FILES} arrays")));
        }
        members.push(Member {
            name: name.to_owned(),
            encoding,
            start,
            end,
            length,
        });
    }
    // Else a few bytes would be the samples of many arrays.
    let mut places: Vec<&Member> = members.iter().collect();
    places.sort_by_key(|member| (member.start, member.end));
    if let Some(pair) = places.windows(2).find(|pair| pair[1].start < pair[0].end) {
        let what = format!("'{}' overlaps '{}'", pair[1].name, pair[0].name);
        return Err(refuse(what));
    }
    Ok(members)
}

impl Member {
    /// The array's header, or what is wrong with it.
    fn header(&self, path: &Path) -> Result<Result<Header, String>, Error> {
        let (mut file, _) = open_file(path)?;
        let sought = file.seek(SeekFrom::Start(self.start));
        sought.map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        let mut packed = BufReader::new(file.take(self.end - self.start));
        Ok(match self.encoding {
            Encoding::Deflate => Header::read(&mut DeflateDecoder::new(packed)),
            _ => Header::read(&mut packed),
        })
    }
}
