//! Writes clusters, one after the other.

use std::fs::File;
use std::io::{BufWriter, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::clusters::{CellSource, Cut, cut};
use tetrascope_core::mesh::Association;

use super::format::{ENTRY, Entry, HEADER, Header, checksum, encode};
use crate::whole_file::{cannot_write, check_writable, write_with};

/// The numbers of a file that was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packed {
    /// Tetrahedra.
    pub cells: u64,
    /// Points of all clusters: those that clusters have in common count in each.
    pub points: u64,
    /// Clusters.
    pub clusters: u64,
    /// Bytes of the file.
    pub bytes: u64,
}

/// About so many values are kept in the directory, so that a look can be chosen by them.
const PICKED: u64 = 1 << 16;

/// Refuses at once what [`write_tsc`] would refuse after the work is done: another extension,
/// a folder that does not exist or cannot be written to, and a folder in the file's place.
///
/// # Errors
/// [`Error::Unknown`] for the extension, [`Error::Io`].
pub fn check_path(path: &Path) -> Result<(), Error> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "tsc" => check_writable(path),
        other => Err(Error::Unknown {
            kind: "cluster format",
            name: other.into(),
            valid: vec!["tsc".into()],
        }),
    }
}

/// Writes cells as a `.tsc` file: whole or not at all, and the same cells give the same bytes, as long as
/// they are cut alike.
///
/// Needs [`Cut::memory`], some clusters and 88 bytes for each of all, whatever the number of cells.
///
/// # Errors
/// [`Error::Io`] when the file cannot be written, [`Error::Invalid`] for no cell at all, those of [`cut`].
pub fn write_tsc(path: &Path, source: &dyn CellSource, limits: &Cut) -> Result<Packed, Error> {
    let mut other = None;
    let mut packed = Packed::default();
    let written = write_with(path, |file| match write(path, file, source, limits) {
        Ok(numbers) => {
            packed = numbers;
            Ok(())
        }
        Err(Error::Io { source, .. }) => Err(source),
        Err(error) => {
            other = Some(error);
            Err(std::io::ErrorKind::Other.into())
        }
    });
    match other {
        Some(error) => Err(error),
        None => written.map(|()| packed),
    }
}

fn write(
    path: &Path,
    file: &mut File,
    source: &dyn CellSource,
    limits: &Cut,
) -> Result<Packed, Error> {
    let mut file = BufWriter::with_capacity(1 << 20, file);
    let put = |file: &mut BufWriter<&mut File>, bytes: &[u8]| {
        file.write_all(bytes).map_err(cannot_write(path))
    };
    put(&mut file, &[0; HEADER])?;
    let (name, association) = source.field();
    let of_cells = association == Association::Cell;
    let mut packed = Packed::default();
    let mut offset = HEADER as u64;
    let mut entries = Vec::new();
    let mut picked: Vec<f64> = Vec::new();
    let step = (source.cell_count() / if of_cells { 1 } else { 5 } / PICKED).max(1);
    cut(source, limits, &mut |part| {
        let cluster = part.cluster();
        let (bytes, flags) = encode(&part);
        Entry {
            offset,
            flags,
            checksum: checksum(&bytes),
            cluster,
        }
        .encode(&mut entries);
        picked.extend(part.values.iter().step_by(step as usize));
        packed.cells += u64::from(cluster.cells);
        packed.points += u64::from(cluster.points);
        packed.clusters += 1;
        offset += bytes.len() as u64;
        put(&mut file, &bytes)
    })?;
    if packed.cells == 0 {
        return Err(Error::invalid("a mesh without cells has no clusters"));
    }
    debug_assert_eq!(entries.len() as u64, ENTRY as u64 * packed.clusters);
    let mut directory = Vec::new();
    for length in [name.len(), picked.len()] {
        if u32::try_from(length).is_err() {
            return Err(Error::invalid(format!(
                "{length} bytes or values in a directory"
            )));
        }
    }
    directory.extend((name.len() as u32).to_le_bytes());
    directory.extend(name.as_bytes());
    directory.extend((picked.len() as u32).to_le_bytes());
    directory.extend(picked.iter().flat_map(|value| value.to_le_bytes()));
    directory.extend(entries);
    put(&mut file, &directory)?;
    let header = Header {
        of_cells,
        cells: packed.cells,
        clusters: packed.clusters,
        directory: offset,
        directory_bytes: directory.len() as u64,
        directory_checksum: checksum(&directory),
    };
    file.seek(SeekFrom::Start(0)).map_err(cannot_write(path))?;
    put(&mut file, &header.encode())?;
    file.flush().map_err(cannot_write(path))?;
    packed.bytes = offset + directory.len() as u64;
    Ok(packed)
}
