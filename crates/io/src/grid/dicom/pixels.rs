//! Pixels of DICOM files as numbers: native, in runs, JPEG and JPEG 2000.
//!
//! Frames are checked before memory is taken for them: they have the size that the elements state, and
//! [`memory`] says how much that is in all.

use std::borrow::Cow;
use std::io::Cursor;

use hayro_jpeg2000::{DecodeSettings, DecoderContext};
use jpeg_decoder::{ColorTransform, PixelFormat};
use tetrascope_core::Error;

use super::elements::{Fault, fragments};
use super::image::{Image, Kind, Packing};
use crate::grid::number::Numbers;
use crate::grid::payload::most_unpacked;
use crate::source::{Endian, format_error_with_help};

/// The help of an error about packed pixels.
const UNPACKED: &str = "write the files without compression, with `gdcmconv --raw` or pydicom, if other programs read them";

/// How a JPEG and a JPEG 2000 image begin.
const STARTS: [&[u8]; 3] = [b"\xff\xd8", b"\xff\x4f\xff\x51", b"\0\0\0\x0cjP"];

/// The most bytes that reading `images` takes, those of decoders included, and the most that their files may
/// hold if any is packed.
pub(super) fn memory(images: &[Image]) -> (u64, Option<u64>) {
    let bytes = |image: &Image| {
        let of_number = match image.packing {
            // A float for the number, and one for the wavelets.
            Packing::Jpeg2000 => 8,
            _ => image.kind.number.size(),
        };
        let frame = image.kind.count() as u64 * of_number as u64;
        frame.saturating_mul(image.frames.len() as u64)
    };
    let all = images.iter().map(bytes).fold(0, u64::saturating_add);
    let is_packed = images
        .iter()
        .any(|image| image.packing != Packing::None || image.is_deflated);
    let length = images
        .iter()
        .map(|image| image.length)
        .fold(0, u64::saturating_add);
    (all, is_packed.then(|| most_unpacked(length)))
}

/// The numbers of each frame of `image`, in the file's order; those of a pixel stand together, or in
/// planes if the kind says so.
pub(super) fn read(image: &Image) -> Result<Vec<Numbers>, Error> {
    let kind = &image.kind;
    let wrong = |what: String| {
        format_error_with_help(
            &image.path,
            "the pixels",
            what,
            "the file is truncated or damaged; copy or export it again",
        )
    };
    let frame = kind.count() as u64 * kind.number.size() as u64;
    let count = image.frames.len();
    let needed = frame.saturating_mul(count as u64);
    let (bytes, place) = image.pixels()?;
    if image.packing == Packing::None {
        let end = place
            .length
            .map_or(0, |length| place.start.saturating_add(length));
        let value = bytes
            .get(place.start..end.min(bytes.len()))
            .unwrap_or_default();
        let needed = match kind.is_mask {
            true => needed.div_ceil(8),
            false => needed,
        };
        if (value.len() as u64) < needed {
            return Err(wrong(format!(
                "{count} frames of {}×{} pixels take {needed} bytes, and {} stand there",
                kind.columns,
                kind.rows,
                value.len()
            )));
        }
        let value = match place.is_words && image.endian == Endian::Big && kind.number.size() == 1 {
            true => Cow::Owned(swapped(value)),
            false => Cow::Borrowed(value),
        };
        if kind.is_mask {
            let bit = |i: usize| value[i / 8] >> (i % 8) & 1;
            let of_frame = |f: usize| (f * kind.count()..(f + 1) * kind.count()).map(bit);
            return Ok((0..count)
                .map(|f| Numbers::U8(of_frame(f).collect()))
                .collect());
        }
        let frames = value.chunks_exact(frame as usize).take(count);
        return frames
            .map(|bytes| numbers(image, bytes, image.endian))
            .collect();
    }
    if kind.is_mask {
        return Err(wrong("packed pixels of one bit are not read".into()));
    }
    if place.length.is_some() {
        return Err(wrong("packed pixels are not in fragments".into()));
    }
    let fault = |fault: Fault| fault.error(&image.path);
    let found = fragments(&bytes, place.start).map_err(fault)?;
    let packed = packed_frames(&found, count).ok_or_else(|| {
        wrong(format!(
            "{} fragments do not divide among {count} frames",
            found.len().saturating_sub(1)
        ))
    })?;
    let each = packed.iter().zip(1..).map(|(packed, number)| {
        let unpacked = match image.packing {
            Packing::Jpeg => jpeg(kind, packed),
            Packing::Jpeg2000 => jpeg2000(kind, packed),
            _ => runs(kind, packed),
        };
        let unpacked = unpacked.map_err(|what| {
            format_error_with_help(&image.path, format!("frame {number}"), what, UNPACKED)
        })?;
        numbers(image, &unpacked, Endian::Little)
    });
    each.collect()
}

/// The bytes of each of `count` frames of `fragments`, the first of which is the table of offsets;
/// `None` if it cannot be said which fragment belongs to which frame.
fn packed_frames(fragments: &[&[u8]], count: usize) -> Option<Vec<Vec<u8>>> {
    let (table, fragments) = fragments.split_first()?;
    if fragments.len() == count {
        return Some(fragments.iter().map(|f| f.to_vec()).collect());
    }
    if count == 1 {
        return Some(vec![fragments.concat()]);
    }
    // Offsets count from the first fragment's item, whose tag and length take 8 bytes.
    let offsets: Vec<u64> = table
        .chunks_exact(4)
        .map(|bytes| Endian::Little.u32(bytes).into())
        .collect();
    let mut frames: Vec<Vec<u8>> = Vec::new();
    let mut at = 0u64;
    for fragment in fragments {
        let begins = match offsets.is_empty() {
            false => offsets.contains(&at),
            true => STARTS.iter().any(|start| fragment.starts_with(start)),
        };
        match frames.last_mut() {
            Some(last) if !begins => last.extend(*fragment),
            _ => frames.push(fragment.to_vec()),
        }
        at += 8 + fragment.len() as u64;
    }
    (frames.len() == count).then_some(frames)
}

/// Bytes with those of each word of 16 bits in the other order.
fn swapped(bytes: &[u8]) -> Vec<u8> {
    let words = bytes.chunks(2);
    words.flat_map(|word| word.iter().rev()).copied().collect()
}

/// A frame's numbers of its `bytes`, which are long enough.
fn numbers(image: &Image, mut bytes: &[u8], endian: Endian) -> Result<Numbers, Error> {
    let kind = &image.kind;
    let numbers = kind.number.read(&mut bytes, endian, kind.count());
    let numbers = numbers.map_err(|source| Error::Io {
        action: "cannot read",
        path: image.path.clone(),
        source,
    })?;
    Ok(match kind.bits {
        Some(bits) => stored(numbers, bits),
        None => numbers,
    })
}

/// The numbers that the `stored` bits up to the `highest` are; others may hold anything.
fn stored(numbers: Numbers, [stored, highest]: [u32; 2]) -> Numbers {
    /// Moves the highest stored bit to the top and back, which extends the sign if there is one.
    macro_rules! cut {
        ($kind:ident, $of:ty, $numbers:expr) => {{
            let up = <$of>::BITS - 1 - highest;
            let down = <$of>::BITS - stored;
            Numbers::$kind($numbers.into_iter().map(|x| (x << up) >> down).collect())
        }};
    }
    match numbers {
        Numbers::U8(n) => cut!(U8, u8, n),
        Numbers::U16(n) => cut!(U16, u16, n),
        Numbers::I16(n) => cut!(I16, i16, n),
        Numbers::U32(n) => cut!(U32, u32, n),
        Numbers::I32(n) => cut!(I32, i32, n),
        other => other,
    }
}

/// A frame in runs of bytes (PS3.5, annex G), as little-endian numbers.
fn runs(kind: &Kind, packed: &[u8]) -> Result<Vec<u8>, String> {
    let size = kind.number.size();
    let pixels = kind.columns * kind.rows;
    let words = packed
        .get(..64)
        .ok_or("the table of its segments is cut off")?;
    let words: Vec<usize> = words
        .chunks_exact(4)
        .map(|bytes| Endian::Little.u32(bytes) as usize)
        .collect();
    let segments = kind.samples * size;
    if words[0] != segments {
        return Err(format!(
            "{} segments of bytes, {segments} are needed",
            words[0]
        ));
    }
    let mut unpacked = vec![0; pixels * segments];
    for segment in 0..segments {
        let start = *words
            .get(1 + segment)
            .ok_or("it has more than 15 segments")?;
        let bytes = packed.get(start..).unwrap_or_default();
        // Planes of bytes: the highest of the first sample first.
        let (sample, byte) = (segment / size, size - 1 - segment % size);
        let (first, step) = match kind.is_planar {
            true => (sample * pixels * size + byte, size),
            false => (sample * size + byte, segments),
        };
        let plane = segment_bytes(bytes, pixels)
            .map_err(|found| format!("segment {} ends after {found} pixels", segment + 1))?;
        for (pixel, byte) in plane.into_iter().enumerate() {
            unpacked[first + pixel * step] = byte;
        }
    }
    Ok(unpacked)
}

/// `count` bytes of a segment of runs; how many there are if these are fewer.
fn segment_bytes(packed: &[u8], count: usize) -> Result<Vec<u8>, usize> {
    let mut bytes = packed.iter().copied();
    let mut found = Vec::with_capacity(count + 128);
    while found.len() < count {
        match bytes.next().ok_or(found.len())? as i8 {
            // That many and one more as they are.
            literal @ 0.. => {
                for _ in 0..=literal {
                    found.push(bytes.next().ok_or(found.len())?);
                }
            }
            i8::MIN => {}
            repeated => {
                let byte = bytes.next().ok_or(found.len())?;
                found.extend((0..=-i16::from(repeated)).map(|_| byte));
            }
        }
    }
    found.truncate(count);
    Ok(found)
}

/// A JPEG image, as little-endian numbers.
fn jpeg(kind: &Kind, packed: &[u8]) -> Result<Vec<u8>, String> {
    let mut decoder = jpeg_decoder::Decoder::new(Cursor::new(packed));
    let refuse = |error: jpeg_decoder::Error| format!("its JPEG image is not read: {error}");
    decoder.read_info().map_err(refuse)?;
    let info = decoder.info().ok_or("its JPEG image has no header")?;
    check_size(kind, info.width.into(), info.height.into())?;
    if kind.photometric == "RGB" {
        decoder.set_color_transform(ColorTransform::None);
    }
    let (samples, size) = match info.pixel_format {
        PixelFormat::L8 => (1, 1),
        PixelFormat::L16 => (1, 2),
        PixelFormat::RGB24 => (3, 1),
        PixelFormat::CMYK32 => (4, 1),
    };
    if samples != kind.samples || size > kind.number.size() || kind.number.size() > 2 {
        return Err(format!(
            "its JPEG image has {samples} numbers of {size} bytes per pixel"
        ));
    }
    let bytes = decoder.decode().map_err(refuse)?;
    if bytes.len() != kind.count() * size {
        return Err(format!("its JPEG image holds {} bytes", bytes.len()));
    }
    let together = match (size, kind.number.size()) {
        (1, 2) => bytes.into_iter().flat_map(|byte| [byte, 0]).collect(),
        // The decoder's numbers are in this machine's order.
        (2, _) => bytes
            .chunks_exact(2)
            .flat_map(|pair| u16::from_ne_bytes([pair[0], pair[1]]).to_le_bytes())
            .collect(),
        _ => bytes,
    };
    Ok(apart(kind, together))
}

/// A JPEG 2000 image, as little-endian numbers.
fn jpeg2000(kind: &Kind, packed: &[u8]) -> Result<Vec<u8>, String> {
    let settings = DecodeSettings {
        resolve_palette_indices: false,
        strict: true,
        target_resolution: None,
    };
    let refuse =
        |error: hayro_jpeg2000::DecodeError| format!("its JPEG 2000 image is not read: {error}");
    // Boxes around the image, which DICOM does not have, say nothing that its elements do not.
    let start = packed.windows(SIZES.len()).position(|w| w == SIZES);
    let packed = &packed[start.ok_or("its JPEG 2000 image has no beginning")?..];
    let image = hayro_jpeg2000::Image::new(packed, &settings).map_err(refuse)?;
    check_size(kind, image.width(), image.height())?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(refuse)?;
    let components = decoded.components();
    let pixels = kind.columns * kind.rows;
    let is_whole = components.iter().all(|part| part.samples().len() == pixels);
    if components.len() != kind.samples || !is_whole {
        return Err(format!(
            "its JPEG 2000 image has {} parts, and {} are needed",
            components.len(),
            kind.samples
        ));
    }
    // Exact to 2²⁴ in the decoder's floats.
    if components.iter().any(|part| part.bit_depth() > 24) {
        return Err("its JPEG 2000 image has numbers of more than 24 bits".into());
    }
    let size = kind.number.size();
    let signed = signed_parts(packed, components.len());
    let mut bytes = Vec::with_capacity(pixels * kind.samples * size);
    for pixel in 0..pixels {
        for (part, is_signed) in components.iter().zip(&signed) {
            let middle = i64::from(*is_signed) << (part.bit_depth() - 1);
            let number = part.samples()[pixel].round() as i64 - middle;
            bytes.extend(&number.to_le_bytes()[..size]);
        }
    }
    Ok(apart(kind, bytes))
}

/// How a JPEG 2000 image begins: with its first marker and that of its sizes.
const SIZES: &[u8] = b"\xff\x4f\xff\x51";

/// Whether each of `count` parts of a JPEG 2000 image has signed numbers (ISO/IEC 15444-1, A.5.1); the
/// decoder takes all for unsigned, half their range too high.
fn signed_parts(packed: &[u8], count: usize) -> Vec<bool> {
    let part = |i: usize| packed.get(42 + 3 * i).copied();
    (0..count)
        .map(|i| part(i).is_some_and(|precision| precision & 0x80 != 0))
        .collect()
}

fn check_size(kind: &Kind, width: u32, height: u32) -> Result<(), String> {
    if (width as usize, height as usize) == (kind.columns, kind.rows) {
        return Ok(());
    }
    Err(format!(
        "its image of {width}×{height} pixels is not of {}×{}",
        kind.columns, kind.rows
    ))
}

/// Bytes of numbers that stand together for each pixel, in planes if the kind says so.
fn apart(kind: &Kind, together: Vec<u8>) -> Vec<u8> {
    if !kind.is_planar {
        return together;
    }
    let size = kind.number.size();
    let of_pixel = kind.samples * size;
    let plane = |sample: usize| {
        let pixels = together.chunks_exact(of_pixel);
        pixels.flat_map(move |pixel| &pixel[sample * size..(sample + 1) * size])
    };
    (0..kind.samples).flat_map(plane).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_belong_to_frames_by_offsets_or_by_how_images_begin() {
        let parts: [&[u8]; 4] = [b"", b"\xff\xd8ab", b"cd", b"\xff\xd8ef"];
        let frames = packed_frames(&parts, 2).unwrap();
        assert_eq!(frames, [b"\xff\xd8abcd".to_vec(), b"\xff\xd8ef".to_vec()]);
        // The table says otherwise.
        let table = [0u32, 12].map(u32::to_le_bytes).concat();
        let frames = packed_frames(&[&table, parts[1], parts[2], parts[3]], 2).unwrap();
        assert_eq!(frames, [b"\xff\xd8ab".to_vec(), b"cd\xff\xd8ef".to_vec()]);
        assert_eq!(packed_frames(&parts, 1).unwrap().len(), 1);
        assert_eq!(packed_frames(&parts, 4), None);
        assert_eq!(packed_frames(&[], 1), None);
    }

    #[test]
    fn bits_that_are_not_stored_do_not_count() {
        let numbers = stored(Numbers::U16(vec![0xF801, 0x0FFF]), [12, 11]);
        assert_eq!(numbers, Numbers::U16(vec![0x0801, 0x0FFF]));
        let numbers = stored(Numbers::I16(vec![0x0801, 0x07FF]), [12, 11]);
        assert_eq!(numbers, Numbers::I16(vec![-0x07FF, 0x07FF]));
        let numbers = stored(Numbers::U16(vec![0x1230]), [12, 15]);
        assert_eq!(numbers, Numbers::U16(vec![0x123]));
    }
}
