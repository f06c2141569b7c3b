//! Images out: PNG for people, EXR and NPY for measuring.
//!
//! | file | texels | metadata |
//! |---|---|---|
//! | PNG | 8-bit sRGB, straight alpha | text chunks |
//! | EXR | 32-bit linear floats, premultiplied | attributes named `tetrascope.KEY` |
//! | NPY | 32-bit linear floats, premultiplied | `NAME.npy.json` beside it |

mod metadata;

use std::borrow::Cow;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::prelude::WritableImage as _;
use rayon::prelude::*;
use tetrascope_core::colormap::linear_to_srgb;
use tetrascope_core::{Error, Frame};

pub use self::metadata::read_metadata;
pub use crate::whole_file::write_file;
use crate::whole_file::{check_writable, write_files};

/// Writes `frame` in the format that the extension names: `.png`, `.exr` or `.npy`.
///
/// `metadata` is pairs of key and text. A file of that name is replaced only
/// by a complete one, and of NPY's two files both are or none. The same frame and metadata
/// give the same bytes.
///
/// # Errors
/// [`Error::Unknown`] for another extension, [`Error::Io`] when the file cannot
/// be written, [`Error::Invalid`] for an empty frame or a key that the format
/// cannot hold.
pub fn write_image(path: &Path, frame: &Frame, metadata: &[(String, String)]) -> Result<(), Error> {
    match extension(path).as_str() {
        "png" => write_file(path, &encode_png(frame, metadata)?),
        "exr" => write_file(path, &encode_exr(frame, metadata)?),
        "npy" => write_files(&[
            (path, &encode_npy(frame)?),
            (&sidecar(path), &encode_texts(metadata)),
        ]),
        other => Err(unknown_format(other)),
    }
}

/// Refuses at once what [`write_image`] would refuse after the work is done: an
/// unknown extension, a folder that does not exist or cannot be written to, and a
/// folder in the file's place.
///
/// # Errors
/// As [`write_image`].
pub fn check_path(path: &Path) -> Result<(), Error> {
    let extension = extension(path);
    if !FORMATS.contains(&extension.as_str()) {
        return Err(unknown_format(&extension));
    }
    let beside = sidecar(path);
    let mut paths = vec![path];
    if extension == "npy" {
        paths.push(&beside);
    }
    paths.into_iter().try_for_each(check_writable)
}

/// The extensions of the formats that are written.
const FORMATS: [&str; 3] = ["png", "exr", "npy"];

fn unknown_format(extension: &str) -> Error {
    Error::Unknown {
        kind: "image format",
        name: extension.into(),
        valid: FORMATS.map(String::from).into(),
    }
}

/// The frame as a PNG file: 8-bit RGBA in sRGB, straight alpha, rounded to the
/// nearest level; values outside [0, 1] are clamped and NaN is 0.
///
/// A texel that sends more light than its opacity can carry (pure emission has
/// opacity 0) is given the opacity of its brightest component, so that it looks
/// right over black; straight alpha could not show it otherwise.
///
/// # Errors
/// [`Error::Invalid`] for a frame without texels, or a key that is not 1 to 79
/// Latin-1 characters.
pub fn encode_png(frame: &Frame, metadata: &[(String, String)]) -> Result<Vec<u8>, Error> {
    encode_png_by(frame, metadata, None)
}

/// The same texels, compressed fast: for pictures that are looked at once.
///
/// # Errors
/// [`Error::Invalid`] for a frame without texels.
pub fn encode_png_fast(frame: &Frame) -> Result<Vec<u8>, Error> {
    encode_png_by(frame, &[], Some(png::Compression::Fast))
}

fn encode_png_by(
    frame: &Frame,
    metadata: &[(String, String)],
    compression: Option<png::Compression>,
) -> Result<Vec<u8>, Error> {
    check(frame)?;
    let texels = straight_srgb8(frame);
    let encode = || -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, frame.width, frame.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        if let Some(compression) = compression {
            encoder.set_compression(compression);
        }
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        for (key, text) in metadata {
            if text.is_ascii() {
                encoder.add_text_chunk(key.clone(), text.clone())?;
            } else {
                encoder.add_itxt_chunk(key.clone(), text.clone())?;
            }
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(texels.as_flattened())?;
        writer.finish()?;
        Ok(file)
    };
    encode().map_err(|error| Error::invalid(format!("cannot make a PNG file: {error}")))
}

/// Before each of our keys in an EXR file.
const EXR_PREFIX: &str = "tetrascope.";

/// The frame as an EXR file: linear premultiplied RGBA in 32-bit floats,
/// losslessly compressed.
///
/// # Errors
/// [`Error::Invalid`] for a frame without texels or with more than the format holds.
pub fn encode_exr(frame: &Frame, metadata: &[(String, String)]) -> Result<Vec<u8>, Error> {
    use exr::prelude::{
        AttributeValue, Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, Vec2,
    };
    check(frame)?;
    let size = (frame.width as usize, frame.height as usize);
    // Text is bytes in an EXR file; ours is UTF-8. The prefix keeps clear of
    // the names that the format gives a meaning.
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let mut attributes = LayerAttributes::default();
    for (key, value) in metadata {
        attributes.other.insert(
            text(&format!("{EXR_PREFIX}{key}")),
            AttributeValue::Text(text(value)),
        );
    }
    let channels = SpecificChannels::rgba(|Vec2(column, row): Vec2<usize>| {
        let [r, g, b, a] = frame.pixels[row * size.0 + column];
        (r, g, b, a)
    });
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut file)
        .map_err(|error| Error::invalid(format!("cannot make an EXR file: {error}")))?;
    let mut file = file.into_inner();
    sort_attributes(&mut file);
    Ok(file)
}

/// Sorts the attributes of an EXR file with one header by their names: the encoder takes
/// them from a hash map, in another order in each run.
///
/// The header is a list of name, 0, type, 0, length (32 bits, little-endian) and value; an
/// empty name ends it ("OpenEXR File Layout"). Its length stays, so no offset changes.
fn sort_attributes(file: &mut [u8]) {
    /// Magic number and version.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut at = START;
    while file[at] != 0 {
        let name = at;
        for _ in 0..2 {
            let end = file[at..].iter().position(|byte| *byte == 0);
            at += end.expect("the encoder ends its texts") + 1;
        }
        let length: [u8; 4] = file[at..at + 4].try_into().expect("four bytes");
        at += 4 + u32::from_le_bytes(length) as usize;
        attributes.push(file[name..at].to_vec());
    }
    attributes.sort();
    file[START..at].copy_from_slice(&attributes.concat());
}

/// The frame as a NumPy file, format 1.0: an array of shape (height, width, 4)
/// of little-endian 32-bit floats in C order, linear premultiplied RGBA, top row
/// first.
///
/// # Errors
/// [`Error::Invalid`] for a frame without texels.
pub fn encode_npy(frame: &Frame) -> Result<Vec<u8>, Error> {
    check(frame)?;
    let shape = format!("({}, {}, 4)", frame.height, frame.width);
    Ok(npy(&shape, frame.pixels.iter().flatten()))
}

/// Writes numbers, rows of `width`, as a NumPy file of shape (height, width), as
/// [`write_image`] does; NaN is where there is none.
///
/// # Errors
/// [`Error::Io`] when a file cannot be written, [`Error::Invalid`] for no rows, or some that are
/// not full.
pub fn write_npy(
    path: &Path,
    width: usize,
    numbers: &[f32],
    metadata: &[(String, String)],
) -> Result<(), Error> {
    if numbers.is_empty() || width == 0 || !numbers.len().is_multiple_of(width) {
        return Err(Error::invalid(format!(
            "{} numbers in rows of {width} cannot be written",
            numbers.len()
        )));
    }
    let shape = format!("({}, {width})", numbers.len() / width);
    write_files(&[
        (path, &npy(&shape, numbers.iter())),
        (&sidecar(path), &encode_texts(metadata)),
    ])
}

/// A NumPy file, format 1.0.
fn npy<'a>(shape: &str, numbers: impl Iterator<Item = &'a f32>) -> Vec<u8> {
    let dictionary = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version, a 16-bit length, the dictionary, spaces and a newline:
    // in all a multiple of 64 bytes (NumPy Enhancement Proposal 1).
    let unpadded = 10 + dictionary.len() + 1;
    let header = unpadded.next_multiple_of(64);
    let mut file = Vec::with_capacity(header + 4 * numbers.size_hint().0);
    file.extend_from_slice(b"\x93NUMPY\x01\x00");
    file.extend_from_slice(&((header - 10) as u16).to_le_bytes());
    file.extend_from_slice(dictionary.as_bytes());
    file.resize(header - 1, b' ');
    file.push(b'\n');
    numbers.for_each(|number| file.extend_from_slice(&number.to_le_bytes()));
    file
}

/// The metadata as a JSON object of texts, as [`write_image`] writes it beside an NPY file.
pub fn encode_texts(metadata: &[(String, String)]) -> Vec<u8> {
    let map: serde_json::Map<String, serde_json::Value> = metadata
        .iter()
        .map(|(key, text)| (key.clone(), text.as_str().into()))
        .collect();
    let mut json = serde_json::to_vec_pretty(&map).expect("a map of texts is JSON");
    json.push(b'\n');
    json
}

/// `NAME.npy.json` for `NAME.npy`.
fn sidecar(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// In lower case; empty when there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension()
        .map_or(Cow::Borrowed(""), |e| e.to_string_lossy())
        .to_ascii_lowercase()
}

fn check(frame: &Frame) -> Result<(), Error> {
    let texels = u64::from(frame.width) * u64::from(frame.height);
    if texels == 0 || texels != frame.pixels.len() as u64 {
        return Err(Error::invalid(format!(
            "an image of {}×{} with {} texels cannot be written",
            frame.width,
            frame.height,
            frame.pixels.len()
        )));
    }
    Ok(())
}

/// The texels of [`encode_png`]: 8-bit RGBA in sRGB, straight alpha, row-major, top row first.
pub fn straight_srgb8(frame: &Frame) -> Vec<[u8; 4]> {
    frame.pixels.par_iter().map(|&p| straight_srgb(p)).collect()
}

/// Premultiplied linear floats to straight sRGB bytes.
fn straight_srgb(pixel: [f32; 4]) -> [u8; 4] {
    // `max` passes over NaN.
    let [r, g, b, a] = pixel.map(|value| f64::from(value).max(0.0));
    let opacity = a.max(r).max(g).max(b).min(1.0);
    let level = |value: f64| (255.0 * value).round() as u8;
    let color = |value: f64| {
        if opacity > 0.0 {
            level(linear_to_srgb((value / opacity).min(1.0)))
        } else {
            0
        }
    };
    [color(r), color(g), color(b), level(opacity)]
}

#[cfg(test)]
mod tests;
