//! One DICOM file: the kind of its pixels, and where each of its frames lies.

use std::borrow::Cow;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use flate2::read::DeflateDecoder;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{Error, text};

use super::elements::{DataSet, Encoding, Fault, PixelPlace, data_set, meta};
use super::tags;
use crate::grid::MOST_FILES;
use crate::grid::number::Number;
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::source::{Endian, Source, format_error, format_error_with_help, open_file, read_at};

/// Bytes that are read first: elements before the pixels rarely take more.
const HEAD: usize = 1 << 17;

/// How the pixels are packed (PS3.5, annexes A and G, and PS3.6, table A-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    /// As they are.
    None,
    /// Runs of equal bytes, in planes of bytes.
    Runs,
    Jpeg,
    Jpeg2000,
}

/// The properties that frames of one volume have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kind {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Numbers of a pixel.
    pub(super) samples: usize,
    /// Those of a pixel are apart, in planes.
    pub(super) is_planar: bool,
    pub(super) number: Number,
    /// Numbers are single bits, without padding from frame to frame.
    pub(super) is_mask: bool,
    /// Bits of a number that count, and the highest of them.
    pub(super) bits: Option<[u32; 2]>,
    pub(super) photometric: String,
}

impl Kind {
    /// Numbers of a frame; each factor is below 2¹⁶.
    pub(super) fn count(&self) -> usize {
        self.columns * self.rows * self.samples
    }
}

/// A frame's place, and what its numbers mean; lengths in millimeters.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// The center of its first pixel.
    pub(super) position: Option<DVec3>,
    /// The directions in which columns and rows count up: unit vectors.
    pub(super) orientation: Option<[DVec3; 2]>,
    /// The distances of rows and of columns.
    pub(super) spacing: Option<[f64; 2]>,
    /// A stored number x means x · slope + intercept.
    pub(super) scale: Option<(f64, f64)>,
    /// Orders frames at the same place: the numbers that differ first decide.
    pub(super) order: [f64; 4],
}

/// A file with pixels.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) path: PathBuf,
    pub(super) kind: Kind,
    pub(super) packing: Packing,
    pub(super) endian: Endian,
    pub(super) frames: Vec<Frame>,
    /// Which series the image belongs to; empty if the file does not say.
    pub(super) series: String,
    pub(super) description: String,
    pub(super) modality: String,
    /// The unit of scaled numbers, as the file has it.
    pub(super) unit: Option<String>,
    /// The stored number that stands where there is no measurement.
    pub(super) padding: Option<u16>,
    /// The distance of slices that the file states apart from their places.
    pub(super) slice_distance: Option<f64>,
    /// Distances are those of the detector, not of the body.
    pub(super) is_projection: bool,
    /// Bytes of the file.
    pub(super) length: u64,
    pixels: PixelPlace,
    /// All behind the meta information is deflated.
    pub(super) is_deflated: bool,
}

/// Whether this is the beginning of a DICOM file.
pub(crate) fn is_dicom(head: &[u8]) -> bool {
    head.get(128..132) == Some(b"DICM")
}

/// A file's encoding and packing, and where its data set begins.
struct Syntax {
    encoding: Encoding,
    packing: Packing,
    is_deflated: bool,
    start: usize,
}

impl Image {
    /// Reads what stands before the pixels; `None` for a DICOM file without any.
    pub(super) fn open(path: &Path) -> Result<Option<Image>, Error> {
        let (_, length) = open_file(path)?;
        let head = read_at(path, 0, HEAD)?;
        if !is_dicom(&head) {
            return Err(format_error(
                path,
                "byte 128",
                "the letters DICM do not stand here, as they do in a DICOM file",
            ));
        }
        match Image::of(path, length, &head) {
            Err(Found::Fault(fault)) if fault.is_short && length > head.len() as u64 => {
                let whole = Source::open(path)?;
                Image::of(path, length, &whole.bytes)
            }
            other => other,
        }
        .map_err(|found| found.error(path))
    }

    fn of(path: &Path, length: u64, bytes: &[u8]) -> Result<Option<Image>, Found> {
        let syntax = Syntax::of(path, bytes)?;
        if syntax.is_deflated && length > bytes.len() as u64 {
            return Err(Found::Fault(Fault {
                at: bytes.len(),
                what: String::new(),
                is_short: true,
            }));
        }
        let (bytes, start) = syntax.data_set(path, bytes)?;
        let (set, pixels) = data_set(&bytes, start, syntax.encoding)?;
        let Some(pixels) = pixels else {
            return Ok(None);
        };
        let wrong = |what: String| Found::Error(format_error(path, "the elements", what));
        let kind = Kind::of(&set, pixels).map_err(wrong)?;
        let frames = frames(&set).map_err(wrong)?;
        let words = |tag| clipped(set.text(tag).unwrap_or_default(), 64);
        let slice_distance = set
            .decimal(tags::SPACING_BETWEEN_SLICES)
            .or_else(|| set.decimal(tags::SLICE_THICKNESS))
            .map(f64::abs);
        Ok(Some(Image {
            path: path.to_owned(),
            kind,
            packing: syntax.packing,
            endian: syntax.encoding.endian,
            frames,
            series: words(tags::SERIES),
            description: words(tags::SERIES_DESCRIPTION),
            modality: words(tags::MODALITY),
            unit: set.text(tags::RESCALE_TYPE).map(|unit| clipped(unit, 16)),
            padding: set.short(tags::PADDING),
            slice_distance: slice_distance.filter(|distance| *distance > 0.0),
            is_projection: set.text(tags::PIXEL_SPACING).is_none()
                && set.text(tags::IMAGER_PIXEL_SPACING).is_some(),
            length,
            pixels,
            is_deflated: syntax.is_deflated,
        }))
    }

    /// The bytes of the file behind which the pixels stand, and where these begin.
    pub(super) fn pixels(&self) -> Result<(Vec<u8>, PixelPlace), Error> {
        let bytes = Source::open(&self.path)?.bytes;
        if !self.is_deflated {
            return Ok((bytes, self.pixels));
        }
        let syntax = Syntax::of(&self.path, &bytes).map_err(|found| found.error(&self.path))?;
        let (bytes, _) = syntax
            .data_set(&self.path, &bytes)
            .map_err(|found| found.error(&self.path))?;
        Ok((bytes.into_owned(), self.pixels))
    }
}

/// Why a file is not an image.
enum Found {
    Fault(Fault),
    Error(Error),
}

impl From<Fault> for Found {
    fn from(fault: Fault) -> Found {
        Found::Fault(fault)
    }
}

impl Found {
    fn error(self, path: &Path) -> Error {
        match self {
            Found::Fault(fault) => fault.error(path),
            Found::Error(error) => error,
        }
    }
}

impl Fault {
    pub(super) fn error(self, path: &Path) -> Error {
        format_error_with_help(
            path,
            format!("byte {}", self.at),
            self.what,
            "the file is truncated or damaged; copy or export it again",
        )
    }
}

impl Syntax {
    fn of(path: &Path, bytes: &[u8]) -> Result<Syntax, Found> {
        let (set, start) = meta(bytes, 132)?;
        let name = set.text(tags::TRANSFER_SYNTAX).unwrap_or_default();
        let (mut endian, mut explicit, mut is_deflated) = (Endian::Little, true, false);
        let refuse = |what: &str| {
            Err(Found::Error(format_error_with_help(
                path,
                "the transfer syntax",
                format!("{what} is not read"),
                "convert the files to explicit little endian, with `dcmdjpls` or `dcmdjpeg` of DCMTK, `gdcmconv --raw` or pydicom",
            )))
        };
        let packing = match name.strip_prefix("1.2.840.10008.1.2") {
            Some("") => {
                explicit = false;
                Packing::None
            }
            Some(".1" | ".1.98") => Packing::None,
            Some(".1.99") => {
                is_deflated = true;
                Packing::None
            }
            Some(".2") => {
                endian = Endian::Big;
                Packing::None
            }
            Some(".5") => Packing::Runs,
            Some(".4.50" | ".4.51" | ".4.57" | ".4.70") => Packing::Jpeg,
            Some(".4.90" | ".4.91") => Packing::Jpeg2000,
            Some(".4.80" | ".4.81") => return refuse("JPEG-LS"),
            Some(".4.201" | ".4.202" | ".4.203") => return refuse("High-Throughput JPEG 2000"),
            Some(".4.110" | ".4.111" | ".4.112") => return refuse("JPEG XL"),
            Some(video) if video.starts_with(".4.1") => return refuse("video"),
            _ if name.is_empty() => return refuse("a file that names none"),
            _ => return refuse(&clipped(name, 64)),
        };
        Ok(Syntax {
            encoding: Encoding { endian, explicit },
            packing,
            is_deflated,
            start,
        })
    }

    /// The bytes that hold the data set, and where in them it begins.
    fn data_set<'a>(&self, path: &Path, bytes: &'a [u8]) -> Result<(Cow<'a, [u8]>, usize), Found> {
        if !self.is_deflated {
            return Ok((Cow::Borrowed(bytes), self.start));
        }
        let most = most_unpacked(bytes.len() as u64);
        let mut unpacked = Vec::new();
        let read = DeflateDecoder::new(&bytes[self.start..])
            .take(most)
            .read_to_end(&mut unpacked);
        let at = format!("byte {}", self.start);
        let read =
            read.map_err(|error| Found::Error(format_error(path, &at, error.to_string())))?;
        if read as u64 == most {
            let what = format!("{most} bytes and more are packed in {}", bytes.len());
            return Err(Found::Error(format_error_with_help(path, at, what, UNPACK)));
        }
        Ok((Cow::Owned(unpacked), 0))
    }
}

impl Kind {
    fn of(set: &DataSet, pixels: PixelPlace) -> Result<Kind, String> {
        let need = |tag, name: &str| {
            let number = set.short(tag).filter(|number| *number > 0);
            number.ok_or_else(|| format!("the file does not say {name}"))
        };
        let samples = set.short(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
        if !(1..=4).contains(&samples) {
            return Err(format!("{samples} numbers per pixel; 1 to 4 are read"));
        }
        let mut bits = None;
        let mut is_mask = false;
        let number = match pixels.tag {
            tags::FLOAT_PIXELS => Number::F32,
            tags::DOUBLE_PIXELS => Number::F64,
            _ => {
                let allocated = need(tags::BITS_ALLOCATED, "how many bits a number takes")?;
                let is_signed = set.short(tags::REPRESENTATION).unwrap_or(0) == 1;
                let stored = set.short(tags::BITS_STORED).unwrap_or(allocated);
                let highest = set
                    .short(tags::HIGH_BIT)
                    .unwrap_or(stored.saturating_sub(1));
                if stored == 0 || stored > allocated || highest >= allocated || highest + 1 < stored
                {
                    return Err(format!(
                        "{stored} bits up to bit {highest} of {allocated} are stored"
                    ));
                }
                is_mask = allocated == 1;
                if stored < allocated {
                    bits = Some([stored.into(), highest.into()]);
                }
                match (allocated, is_signed) {
                    (1 | 8, false) => Number::U8,
                    (8, true) => Number::I8,
                    (16, false) => Number::U16,
                    (16, true) => Number::I16,
                    (32, false) => Number::U32,
                    (32, true) => Number::I32,
                    _ => return Err(format!("numbers of {allocated} bits are not read")),
                }
            }
        };
        Ok(Kind {
            columns: need(tags::COLUMNS, "how many columns it has")?.into(),
            rows: need(tags::ROWS, "how many rows it has")?.into(),
            samples: samples.into(),
            is_planar: samples > 1 && set.short(tags::PLANAR) == Some(1),
            number,
            is_mask,
            bits,
            photometric: clipped(set.text(tags::PHOTOMETRIC).unwrap_or_default(), 16),
        })
    }
}

/// Text of a file for messages, of `most` characters.
fn clipped(text: &str, most: usize) -> String {
    text::clip(text, most).into_owned()
}

/// The frames of a file, in its order.
fn frames(set: &DataSet) -> Result<Vec<Frame>, String> {
    let count = set.decimal(tags::FRAMES).unwrap_or(1.0);
    if !(count >= 1.0 && count <= MOST_FILES as f64) {
        return Err(format!("{count} frames; 1 to {MOST_FILES} are read"));
    }
    let count = count as usize;
    let shared = set.items(tags::SHARED_GROUPS).first();
    let of_frames = set.items(tags::FRAME_GROUPS);
    let offsets = set.decimals(tags::FRAME_OFFSETS);
    (0..count)
        .map(|i| {
            let own = of_frames.get(i);
            let groups: Vec<&DataSet> = own.into_iter().chain(shared).collect();
            let mut frame = frame(set, &groups)?;
            // Dose: frames lie this far along the normal (PS3.3, C.8.8.3.2).
            if let (Some(offset), Some(position), Some([x, y])) = (
                offsets.as_ref().and_then(|offsets| offsets.get(i)),
                &mut frame.position,
                frame.orientation,
            ) {
                *position += x.cross(y) * *offset;
            }
            Ok(frame)
        })
        .collect()
}

/// A frame that its own functional `groups` describe, those that it shares, or the file's `set`.
fn frame(set: &DataSet, groups: &[&DataSet]) -> Result<Frame, String> {
    // The first place that has the element.
    let find = |sequence, tag| {
        let places = groups.iter().flat_map(|group| group.items(sequence));
        let mut places = places.chain([set]).chain(set.items(tags::DETECTORS));
        places.find_map(|place| place.decimals(tag))
    };
    let vector = |n: &[f64]| DVec3::new(n[0], n[1], n[2]);
    let position = find(tags::PLANE_POSITION, tags::POSITION);
    let position = position.filter(|n| n.len() == 3).map(|n| vector(&n));
    let mut orientation = None;
    if let Some(numbers) = find(tags::PLANE_ORIENTATION, tags::ORIENTATION).filter(|n| n.len() == 6)
    {
        let [x, y] = [vector(&numbers[..3]), vector(&numbers[3..])];
        // Cosines are written with few digits.
        let is_good = (x.length() - 1.0).abs() < 1e-2
            && (y.length() - 1.0).abs() < 1e-2
            && x.dot(y).abs() < 1e-2;
        if !is_good {
            return Err(format!(
                "rows and columns run along {numbers:?}, which are not two right-angled directions"
            ));
        }
        // Both get length 1 and a right angle, but for rounding.
        let x = x / x.length();
        let y = y - x * x.dot(y);
        orientation = Some([x, y / y.length()]);
    }
    let spacing = find(tags::PIXEL_MEASURES, tags::PIXEL_SPACING)
        .or_else(|| set.decimals(tags::IMAGER_PIXEL_SPACING))
        .filter(|n| n.len() == 2 && n.iter().all(|step| *step > 0.0));
    let slope = find(tags::PIXEL_VALUES, tags::SLOPE).and_then(|n| n.first().copied());
    let intercept = find(tags::PIXEL_VALUES, tags::INTERCEPT).and_then(|n| n.first().copied());
    let scale = match (slope, intercept, set.decimal(tags::DOSE_SCALING)) {
        (None, None, None) => None,
        (None, None, Some(dose)) => Some((dose, 0.0)),
        (slope, intercept, _) => Some((slope.unwrap_or(1.0), intercept.unwrap_or(0.0))),
    };
    if scale.is_some_and(|(slope, _)| slope == 0.0) {
        return Err("numbers are scaled by 0".into());
    }
    let content = groups
        .iter()
        .flat_map(|group| group.items(tags::FRAME_CONTENT));
    let temporal = content
        .filter_map(|content| content.longs(tags::TEMPORAL_INDEX)?.first().copied())
        .next();
    let temporal = temporal.map(f64::from);
    let plain = |tag| set.decimal(tag).unwrap_or(0.0);
    Ok(Frame {
        position,
        orientation,
        spacing: spacing.map(|n| [n[0], n[1]]),
        scale: scale.filter(|scale| *scale != (1.0, 0.0)),
        order: [
            temporal.unwrap_or_else(|| plain(tags::TEMPORAL_POSITION)),
            plain(tags::TRIGGER_TIME) + set.double(tags::B_VALUE).unwrap_or(0.0),
            plain(tags::ECHO_TIME),
            plain(tags::INSTANCE_NUMBER),
        ],
    })
}
