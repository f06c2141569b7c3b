//! Opens a file and reads its clusters.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tetrascope_core::clusters::{Cluster, ClusterSource, MeshClusters};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh};

use super::format::{ENTRY, Entry, HEADER, Header, Reader, association, checksum, decode};
use crate::source::{format_error_with_help, open_file};

/// A file of clusters. It is kept open, so that it stays the same when another takes its name.
#[derive(Debug)]
struct Clusters {
    path: PathBuf,
    file: Mutex<File>,
    of_cells: bool,
    /// The checksum of the directory, which has those of the clusters.
    checksum: u32,
    field: String,
    picked: Vec<f64>,
    entries: Vec<Entry>,
    clusters: Vec<Cluster>,
}

/// Opens a `.tsc` file: reads the header and the directory, and no cluster.
///
/// # Errors
/// [`Error::Io`] when it cannot be read, [`Error::Format`] when header or directory make no sense: damaged,
/// cut off, of another version, or with clusters that are not one behind the other. A cluster that is damaged is an
/// error when it is read.
pub fn open_tsc(path: &Path) -> Result<MeshClusters, Error> {
    MeshClusters::new(Arc::new(Clusters::open(path)?))
}

/// The help for a damaged file.
const HELP: &str = "copy the file again, or pack the mesh again";

impl Clusters {
    fn open(path: &Path) -> Result<Clusters, Error> {
        let wrong =
            |at: u64, what: String| format_error_with_help(path, format!("byte {at}"), what, HELP);
        let (mut file, length) = open_file(path)?;
        if length < HEADER as u64 {
            return Err(wrong(length, "the file ends within its header".into()));
        }
        let mut header = [0; HEADER];
        read_exact(&mut file, path, 0, &mut header)?;
        let header = Header::decode(&header).map_err(|(at, what)| wrong(at as u64, what))?;
        let end = header.directory.checked_add(header.directory_bytes);
        if end != Some(length) || header.directory < HEADER as u64 {
            let what = format!(
                "the header says that the directory's {} bytes end the file at byte {}, which has {length}",
                header.directory_bytes,
                end.unwrap_or(u64::MAX)
            );
            return Err(wrong(32, what));
        }
        // No more than the file has.
        let mut directory = vec![0; usize::try_from(header.directory_bytes).unwrap_or(usize::MAX)];
        read_exact(&mut file, path, header.directory, &mut directory)?;
        if checksum(&directory) != header.directory_checksum {
            let what = "the directory is damaged: its checksum is another".into();
            return Err(wrong(header.directory, what));
        }
        let (field, picked, entries) =
            parts(&directory).map_err(|what| wrong(header.directory, what))?;
        let count = entries.len() / ENTRY;
        if entries.len() % ENTRY != 0 || count as u64 != header.clusters || count == 0 {
            let what = format!(
                "the directory has {} bytes for {} clusters, where each takes {ENTRY}",
                entries.len(),
                header.clusters
            );
            return Err(wrong(24, what));
        }
        let entries: Vec<Entry> = entries.chunks_exact(ENTRY).map(Entry::decode).collect();
        let first = length - (ENTRY * count) as u64;
        let (mut next, mut cells) = (HEADER as u64, 0_u64);
        for (number, entry) in (0..).zip(&entries) {
            let at = first + number * ENTRY as u64;
            let length = entry.length(header.of_cells);
            let (Some(length), true) = (length, entry.is_sound()) else {
                return Err(wrong(
                    at,
                    format!("cluster {number} has numbers that make no sense"),
                ));
            };
            if entry.offset != next {
                let what = format!(
                    "cluster {number} begins at byte {}, where byte {next} is next",
                    entry.offset
                );
                return Err(wrong(at, what));
            }
            // At most 2³⁶ bytes each.
            next = next.saturating_add(length);
            cells += u64::from(entry.cluster.cells);
        }
        if next != header.directory || cells != header.cells {
            let what = format!(
                "{count} clusters have {cells} cells and end at byte {next}, where the header says {} and {}",
                header.cells, header.directory
            );
            return Err(wrong(16, what));
        }
        Ok(Clusters {
            path: path.to_owned(),
            file: Mutex::new(file),
            of_cells: header.of_cells,
            checksum: header.directory_checksum,
            field,
            picked,
            clusters: entries.iter().map(|entry| entry.cluster).collect(),
            entries,
        })
    }

    fn wrong(&self, cluster: usize, what: String) -> Error {
        let at = format!("byte {} (cluster {cluster})", self.entries[cluster].offset);
        format_error_with_help(&self.path, at, what, HELP)
    }
}

impl ClusterSource for Clusters {
    fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    fn field(&self) -> (&str, Association) {
        (&self.field, association(self.of_cells))
    }

    fn picked(&self) -> &[f64] {
        &self.picked
    }

    fn checksum(&self) -> Option<u32> {
        Some(self.checksum)
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        let entry = &self.entries[cluster];
        let length = entry.length(self.of_cells).unwrap_or(0);
        let mut bytes = vec![0; usize::try_from(length).unwrap_or(usize::MAX)];
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            read_exact(&mut file, &self.path, entry.offset, &mut bytes)?;
        }
        if checksum(&bytes) != entry.checksum {
            let what = "the cluster is damaged: its checksum is another".into();
            return Err(self.wrong(cluster, what));
        }
        let part = decode(&bytes, entry, self.of_cells);
        drop(bytes);
        if part.cluster() != entry.cluster {
            let what = "the cluster's box or values are not those that the directory has".into();
            return Err(self.wrong(cluster, what));
        }
        let mesh = part.into_mesh(self.field.clone());
        mesh.map_err(|error| self.wrong(cluster, error.to_string()))
    }
}

/// The field's name, values that were picked, and what is left: the entries.
fn parts(directory: &[u8]) -> Result<(String, Vec<f64>, &[u8]), String> {
    let cut_off = || "the directory ends within the field's name or values".to_owned();
    let mut reader = Reader(directory);
    let length = |reader: &mut Reader, width: usize| {
        if reader.0.len() < 4 {
            return Err(cut_off());
        }
        let count = reader.u32() as usize;
        let fits = count
            .checked_mul(width)
            .is_some_and(|bytes| bytes <= reader.0.len());
        if fits { Ok(count) } else { Err(cut_off()) }
    };
    let bytes = length(&mut reader, 1)?;
    let name = String::from_utf8_lossy(reader.take(bytes)).into_owned();
    let count = length(&mut reader, 8)?;
    let picked = (0..count).map(|_| reader.f64()).collect();
    Ok((name, picked, reader.0))
}

fn read_exact(file: &mut File, path: &Path, offset: u64, bytes: &mut [u8]) -> Result<(), Error> {
    let read = file
        .seek(SeekFrom::Start(offset))
        .and_then(|_| file.read_exact(bytes));
    read.map_err(|source| match source.kind() {
        // It was longer when it was opened.
        std::io::ErrorKind::UnexpectedEof => format_error_with_help(
            path,
            format!("byte {offset}"),
            format!("the file ends within {} bytes", bytes.len()),
            HELP,
        ),
        _ => Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        },
    })
}
