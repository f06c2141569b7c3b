//! Which reader the file of a grid needs, where its bytes say so.

use std::io::Read as _;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use tetrascope_core::Error;

#[cfg(feature = "dicom")]
use super::dicom;
use super::payload::open_unpacked;
#[cfg(feature = "tiff")]
use super::tiff;
use super::{GridData, mrc, nifti, npy, npz};
use crate::ReadOptions;

/// A format of grids that begins with bytes of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GridFormat {
    Nifti,
    Mrc,
    Npy,
    Npz,
    #[cfg(feature = "dicom")]
    Dicom,
    #[cfg(feature = "tiff")]
    Tiff,
}

/// How a file begins that is packed with gzip.
pub(crate) const GZIP: &[u8] = b"\x1f\x8b";

/// Bytes that are unpacked to find out the format: more than any header's.
const UNPACKED: u64 = 1024;

impl GridFormat {
    /// By the first bytes of the file at `path`, packed or not, whose name is `name` in lower
    /// case; `None` if they are of none of these formats.
    pub(crate) fn of(head: &[u8], path: &Path, name: &str) -> Option<GridFormat> {
        let is_packed = head.starts_with(GZIP);
        let mut unpacked = Vec::new();
        if is_packed {
            // The packed bytes end somewhere: what was unpacked before that counts.
            let _ = MultiGzDecoder::new(head)
                .take(UNPACKED)
                .read_to_end(&mut unpacked);
        }
        let head = if is_packed { &unpacked } else { head };
        if nifti::is_nifti(head) || name.ends_with(".nii") || name.ends_with(".nii.gz") {
            return Some(GridFormat::Nifti);
        }
        if (name.ends_with(".img") || name.ends_with(".img.gz")) && has_header(path) {
            return Some(GridFormat::Nifti);
        }
        if mrc::is_mrc(head) {
            return Some(GridFormat::Mrc);
        }
        if is_packed {
            return None;
        }
        if head.starts_with(npy::MAGIC) {
            return Some(GridFormat::Npy);
        }
        if npz::is_npz(head, name) {
            return Some(GridFormat::Npz);
        }
        #[cfg(feature = "dicom")]
        if dicom::is_dicom(head) {
            return Some(GridFormat::Dicom);
        }
        #[cfg(feature = "tiff")]
        if tiff::is_tiff(head) {
            return Some(GridFormat::Tiff);
        }
        None
    }

    /// Whether files of this format leave it to [`ReadOptions`] where samples lie.
    pub(crate) fn takes_spacing(self) -> bool {
        match self {
            GridFormat::Nifti | GridFormat::Mrc => false,
            #[cfg(feature = "dicom")]
            GridFormat::Dicom => false,
            _ => true,
        }
    }

    pub(crate) fn read(self, path: &Path, options: &ReadOptions) -> Result<GridData, Error> {
        let above = options.stream_above;
        match self {
            GridFormat::Nifti => {
                let header = nifti::header_of(path);
                let header = header.as_deref().unwrap_or(path);
                nifti::read(header)?.read(header, above)
            }
            GridFormat::Mrc => mrc::read(path)?.read(path, above),
            GridFormat::Npy => npy::read(path, options)?.read(path, above),
            GridFormat::Npz => npz::read(path, options),
            #[cfg(feature = "dicom")]
            GridFormat::Dicom => dicom::read(path),
            #[cfg(feature = "tiff")]
            GridFormat::Tiff => tiff::read(path, options),
        }
    }
}

/// Whether the header of a NIfTI pair is beside the samples at `path`.
fn has_header(path: &Path) -> bool {
    let begins = |header: &Path| {
        let (reader, _) = open_unpacked(header).ok()?;
        let mut head = Vec::new();
        reader.take(UNPACKED).read_to_end(&mut head).ok()?;
        Some(nifti::is_nifti(&head))
    };
    nifti::header_of(path).is_some_and(|header| begins(&header) == Some(true))
}
