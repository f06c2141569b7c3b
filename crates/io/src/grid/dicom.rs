//! Series of DICOM images: folders of `.dcm` files, or one file with several frames.
//!
//! *DICOM PS3 2025*. A folder's series with the most slices is read; a file of one frame stands for its series in its folder. Frames are
//! ordered by their places along the slices' normal ([`slices`]), which must be evenly spaced: a missing
//! slice and a tilted gantry are refused. Frames at the same places are fields: times, echoes,
//! weightings. Numbers are scaled as the files say (`RescaleSlope`), so that those of CT are
//! Hounsfield units.
//!
//! Pixels: native in either byte order, deflated, in runs, JPEG of 8 bits and lossless JPEG of up to 16
//! (crate `jpeg-decoder`), JPEG 2000 (`hayro-jpeg2000`). JPEG-LS and JPEG XL are refused: no decoder in Rust
//! alone is at hand for the one, and the other is new to DICOM.

mod elements;
mod image;
mod pixels;
mod slices;
mod tags;

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tetrascope_core::{Error, text};

pub(crate) use self::image::is_dicom;

use self::image::Image;
use self::slices::Stack;
use super::number::{Number, Numbers};
use super::payload::{Encoding, Payload, UNPACK};
use super::{Description, Entries, Extra, GridData, MOST_FILES};
use crate::source::{Endian, count, format_error_with_help, read_at};

/// Reads the series at `path`: a folder or a file.
pub(crate) fn read(path: &Path) -> Result<GridData, Error> {
    let mut notes = Vec::new();
    let images = images(path, &mut notes)?;
    if let (needed, Some(most)) = pixels::memory(&images)
        && needed > most
    {
        let length: u64 = images.iter().map(|image| image.length).sum();
        let what = format!("reading {length} packed bytes takes {needed}, which is refused");
        return Err(format_error_with_help(path, "the pixels", what, UNPACK));
    }
    let stack = Stack::new(path, &images, &mut notes)?;
    describe(&images, &stack, notes).read_from(&images[0].path, &mut |length, parts| {
        numbers(&images, &stack, length, parts)
    })
}

/// The images of one series, in the order of their names.
fn images(path: &Path, notes: &mut Vec<String>) -> Result<Vec<Image>, Error> {
    let is_folder = path.is_dir();
    let mut wanted = None;
    if !is_folder {
        let image = Image::open(path)?.ok_or_else(|| {
            format_error_with_help(
                path,
                "the elements",
                "this DICOM file holds no pixels",
                "give the folder that holds the series, or one of its images",
            )
        })?;
        if image.frames.len() > 1 || image.series.is_empty() {
            return Ok(vec![image]);
        }
        wanted = Some(image.series);
    }
    let folder = match is_folder {
        true => path,
        false => match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        },
    };
    let files = files(folder)?;
    let opened: Vec<(PathBuf, Result<Option<Image>, Error>)> = files
        .into_par_iter()
        .filter(|file| begins_as_dicom(file))
        .map(|file| {
            let image = Image::open(&file);
            (file, image)
        })
        .collect();
    let (mut images, mut refused) = (Vec::new(), Vec::new());
    for (file, image) in opened {
        match image {
            Ok(image) => images.extend(image),
            Err(error) => refused.push((file, error)),
        }
    }
    if images.is_empty() {
        return Err(match refused.into_iter().next() {
            Some((_, error)) => error,
            None => format_error_with_help(
                path,
                "",
                "a folder is read as a DICOM series, and none of the files here is a DICOM image",
                match inner_series(path) {
                    Some(inner) => format!("give the folder {}, which holds some", inner.display()),
                    None => "give a file, or the folder that holds the images themselves".into(),
                },
            ),
        });
    }
    let names = series(&images);
    let chosen = match wanted {
        Some(name) => name,
        None => most_slices(&images, &names),
    };
    if names.len() > 1 {
        let shown = |name: &String| {
            let of_series = images.iter().filter(|image| image.series == *name);
            let first = of_series.clone().next();
            let frames: usize = of_series.map(|image| image.frames.len()).sum();
            let what = first.map_or("", |image| &image.description);
            let file = first.and_then(|image| image.path.file_name());
            let file = file.map(|name| name.to_string_lossy().into_owned());
            let file = text::name(&file.unwrap_or_default()).into_owned();
            format!("'{what}' ({}, as in {file})", count(frames as u64, "slice"))
        };
        const MOST: usize = 6;
        let mut list: Vec<String> = names.iter().take(MOST).map(shown).collect();
        if names.len() > MOST {
            list.push(format!("{} more", names.len() - MOST));
        }
        notes.push(format!(
            "the folder holds {} series: {}; {} is read, and a file of another stands for that",
            names.len(),
            list.join(", "),
            shown(&chosen)
        ));
    }
    images.retain(|image| image.series == chosen);
    // It might be one of the slices; among four or more, the gap that it leaves is refused.
    if let Some((file, error)) = refused.first() {
        let name = file.file_name().map(|name| name.to_string_lossy());
        notes.push(format!(
            "{} left out as unreadable, such as {}: {error}",
            count(refused.len() as u64, "DICOM file"),
            text::name(&name.unwrap_or_default())
        ));
    }
    if !is_folder && images.len() > 1 {
        notes.push(format!(
            "the file is one of the {} images of its series, which is read",
            images.len()
        ));
    }
    Ok(images)
}

/// The regular files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let failed = |source| Error::Io {
        action: "cannot read",
        path: folder.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_file() {
            files.push(path);
        }
        if files.len() > MOST_FILES {
            return Err(format_error_with_help(
                folder,
                "",
                format!("more than {MOST_FILES} files"),
                "move the series to a folder of its own",
            ));
        }
    }
    files.sort();
    Ok(files)
}

/// The first folder within `folder` that holds a DICOM file, at most two deep: exports have one for each series, and
/// some one for each patient or study around them.
fn inner_series(folder: &Path) -> Option<PathBuf> {
    /// Folders and files that are looked at.
    const MOST_LOOKED_AT: usize = 1000;
    let mut looked_at = 0;
    let mut folders = vec![(folder.to_owned(), 0)];
    let mut next = 0;
    while let Some((folder, depth)) = folders.get(next).cloned() {
        next += 1;
        let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        let mut entries: Vec<PathBuf> = entries.take(MOST_LOOKED_AT).map(|e| e.path()).collect();
        entries.sort();
        for entry in entries {
            looked_at += 1;
            if looked_at > MOST_LOOKED_AT {
                return None;
            }
            if entry.is_dir() && depth < 2 {
                folders.push((entry, depth + 1));
            } else if depth > 0 && entry.is_file() && begins_as_dicom(&entry) {
                return Some(folder);
            }
        }
    }
    None
}

fn begins_as_dicom(file: &Path) -> bool {
    read_at(file, 0, 132).is_ok_and(|head| is_dicom(&head))
}

/// The series of `images`, in the order in which they come.
fn series(images: &[Image]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for image in images {
        if !names.contains(&image.series) {
            names.push(image.series.clone());
        }
    }
    names
}

/// The series with the most frames, the first of equals.
fn most_slices(images: &[Image], names: &[String]) -> String {
    let frames = |name: &String| -> usize {
        let of_series = images.iter().filter(|image| image.series == *name);
        of_series.map(|image| image.frames.len()).sum()
    };
    let mut best = &names[0];
    for name in names {
        if frames(name) > frames(best) {
            best = name;
        }
    }
    best.clone()
}

/// A description of the fields of `images` that lie as `stack` says.
fn describe(images: &[Image], stack: &Stack, mut notes: Vec<String>) -> Description {
    let first = &images[0];
    let kind = &first.kind;
    let mut extras = Vec::new();
    if kind.samples > 1 {
        let is_rgb = matches!(kind.photometric.as_str(), "RGB" | "YBR_RCT" | "YBR_ICT")
            || first.packing != image::Packing::None;
        extras.push(Extra {
            before: if kind.is_planar { 2 } else { 0 },
            size: kind.samples,
            entries: match is_rgb {
                true => Entries::Colors,
                false => Entries::Numbered,
            },
        });
        if !is_rgb {
            notes.push(format!(
                "pixels are '{}': their numbers are fields as they are",
                kind.photometric
            ));
        }
    }
    if stack.repeats > 1 {
        extras.push(Extra {
            before: 3,
            size: stack.repeats,
            entries: Entries::Numbered,
        });
    }
    match kind.photometric.as_str() {
        "MONOCHROME1" => notes.push("the files show small numbers bright (MONOCHROME1)".into()),
        "PALETTE COLOR" => notes.push("numbers are those of a palette, which is not read".into()),
        _ => {}
    }
    if let Some(unit) = &first.unit {
        notes.push(match unit.as_str() {
            "HU" => "numbers are Hounsfield units".into(),
            unit => format!("the unit of numbers is '{unit}'"),
        });
    } else if first.modality == "CT" {
        notes.push("numbers are Hounsfield units".into());
    }
    if let Some(padding) = first.padding {
        let padding = match kind.number {
            Number::I8 | Number::I16 | Number::I32 => f64::from(padding as i16),
            _ => f64::from(padding),
        };
        let (slope, shift) = stack.scale.unwrap_or((1.0, 0.0));
        notes.push(format!(
            "where nothing was measured, the files hold {}, which is drawn like other numbers",
            padding * slope + shift
        ));
    }
    let name = match first.modality.as_str() {
        "" => "scalars".to_owned(),
        modality => modality.to_owned(),
    };
    Description {
        lattice: stack.lattice,
        is_placed: stack.is_placed,
        payload: Payload {
            files: images.iter().map(|image| image.path.clone()).collect(),
            start: 0,
            lines: 0,
            skip: None,
            encoding: Encoding::Raw,
            number: match stack.is_scaled_alike {
                true => kind.number,
                false => Number::F64,
            },
            endian: Endian::Little,
        },
        extras,
        scale: stack.scale,
        name,
        notes,
    }
}

/// `parts` runs of `length` numbers each, in the order of `stack`.
fn numbers(
    images: &[Image],
    stack: &Stack,
    length: usize,
    parts: usize,
) -> Result<Vec<Numbers>, Error> {
    let of_frame = images[0].kind.count();
    // Slices of the stack by image: where in the result each frame goes.
    let mut places = vec![Vec::new(); images.len()];
    for (place, slice) in stack.order.iter().enumerate() {
        places[slice.image].push((slice.frame, place));
    }
    let mut runs: Vec<Option<Numbers>> = (0..parts).map(|_| None).collect();
    // A few images at a time, as their packed bytes and their numbers are in memory.
    let at_once = rayon::current_num_threads().max(1);
    for batch in (0..images.len()).collect::<Vec<_>>().chunks(at_once) {
        let read: Vec<_> = batch
            .par_iter()
            .map(|&i| pixels::read(&images[i]).map(|frames| (i, frames)))
            .collect::<Result<_, _>>()?;
        for (i, frames) in read {
            for &(frame, place) in &places[i] {
                let mut numbers = frames[frame].clone();
                if !stack.is_scaled_alike {
                    let (slope, shift) = images[i].frames[frame].scale.unwrap_or((1.0, 0.0));
                    numbers = numbers.scaled(slope, shift);
                }
                let run =
                    runs[place * of_frame / length].get_or_insert_with(|| numbers.blank(length));
                run.put(place * of_frame % length, &numbers, 0..of_frame);
            }
        }
    }
    Ok(runs.into_iter().flatten().collect())
}

/// [`pixels::memory`] of one file.
#[cfg(test)]
pub(super) fn memory_of(path: &Path) -> (u64, Option<u64>) {
    let image = Image::open(path).expect("an image").expect("with pixels");
    pixels::memory(&[image])
}
