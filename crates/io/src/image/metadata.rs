//! The metadata of images that were written here, read back.

use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use serde_json::{Map, Value};
use tetrascope_core::Error;

use super::{EXR_PREFIX, extension, sidecar, unknown_format};
use crate::source::open_file;

/// The most bytes of a file beside an array of numbers.
const MOST: u64 = 16 << 20;

/// The pairs of key and text that [`write_image`](super::write_image) was given for this image,
/// in no certain order.
///
/// # Errors
/// [`Error::Unknown`] for another extension, [`Error::Io`] when a file cannot be read, and
/// [`Error::Format`] when it is not whole or of another format.
pub fn read_metadata(path: &Path) -> Result<Vec<(String, String)>, Error> {
    let wrong = |path: &Path, error: String| Error::Format {
        path: path.to_owned(),
        at: "its metadata".into(),
        what: format!("the image cannot be read: {error}"),
        help: None,
    };
    let (file, _) = open_file(path)?;
    match extension(path).as_str() {
        "png" => png_texts(file).map_err(|error| wrong(path, error.to_string())),
        "exr" => exr_texts(file).map_err(|error| wrong(path, error.to_string())),
        "npy" => {
            let path = sidecar(path);
            let (file, _) = open_file(&path)?;
            let mut bytes = Vec::new();
            let read = file.take(MOST).read_to_end(&mut bytes);
            read.map_err(|error| wrong(&path, error.to_string()))?;
            let map: Map<String, Value> =
                serde_json::from_slice(&bytes).map_err(|error| wrong(&path, error.to_string()))?;
            let text = |(key, value): (String, Value)| Some((key, value.as_str()?.to_owned()));
            Ok(map.into_iter().filter_map(text).collect())
        }
        other => Err(unknown_format(other)),
    }
}

/// To the file's end, which shows that it is whole.
fn png_texts(file: File) -> Result<Vec<(String, String)>, png::DecodingError> {
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info()?;
    reader.finish()?;
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter();
    let mut texts: Vec<_> = latin
        .map(|chunk| (chunk.keyword.clone(), chunk.text.clone()))
        .collect();
    for chunk in &info.utf8_text {
        texts.push((chunk.keyword.clone(), chunk.get_text()?));
    }
    Ok(texts)
}

fn exr_texts(file: File) -> exr::error::Result<Vec<(String, String)>> {
    let image = MetaData::read_from_buffered(BufReader::new(file), false)?;
    let attributes = image.headers.iter().flat_map(|h| &h.own_attributes.other);
    let texts = attributes.filter_map(|(name, value)| {
        let AttributeValue::Text(text) = value else {
            return None;
        };
        // Text is bytes in an EXR file; ours is UTF-8.
        let utf8 = |text: &exr::prelude::Text| String::from_utf8(text.as_slice().to_vec()).ok();
        let key = utf8(name)?.strip_prefix(EXR_PREFIX)?.to_owned();
        Some((key, utf8(text)?))
    });
    Ok(texts.collect())
}
