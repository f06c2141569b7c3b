//! Stacks of TIFF pages, also BigTIFF: `.tif`, `.tiff`.
//!
//! *TIFF Revision 6.0*, Adobe 1992, by the crate `tiff`: strips and tiles, without compression,
//! with LZW, deflate or PackBits; whole numbers of 8 to 64 bits and floats of 16, 32 and 64.
//! Pages become slices, the first with the least z; the first row has the least y. Pages of
//! another size or type than the first's, such as previews, are left out. Channels
//! of a pixel are fields.
//!
//! [`stack`] reads what ImageJ, OME and tifffile write into the first page's description: which pages are
//! slices, channels and frames, and how far apart samples are. Without that, distances are 1;
//! resolutions in dots per inch say how a page is printed.
//!
//! Pages that stand in the file one behind the other and are not compressed can stay there.
//! Strips or tiles that overlap are refused, and so are samples that their bytes cannot hold.

mod stack;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};
use tiff::decoder::ifd::Value;
use tiff::decoder::{ChunkType, Decoder, Limits};
use tiff::tags::{ByteOrder, Tag};
use tiff::{ColorType, TiffError};

use self::stack::{PageAxis, Stack};
use super::number::{Number, Numbers};
use super::payload::{DEFLATE, Encoding, Payload, UNPACK, most_unpacked};
use super::{Description, Entries, Extra, GridData, MOST_FILES};
use crate::ReadOptions;
use crate::source::{Endian, Source, count, open_file};

/// Bytes that a page's tiles may have beyond the page.
const MOST_PADDING: u64 = 1 << 26;

/// The version of BigTIFF.
const BIG: u16 = 43;

/// The most bytes that a byte of LZW becomes: a code of 12 bits stands for up to 3838 bytes, as each
/// of the 4096 codes but the first 258 is one longer than another.
const LZW: u64 = 2560;

/// The most bytes that a byte of PackBits becomes: 128 bytes in two.
const PACK_BITS: u64 = 64;

/// Whether this is the beginning of a TIFF file.
pub(crate) fn is_tiff(head: &[u8]) -> bool {
    let marks = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
    marks.iter().any(|mark| head.starts_with(*mark))
}

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<GridData, Error> {
    let mut file = TiffFile::open(path)?;
    let mut notes = Vec::new();
    let pages = file.pages(&mut notes)?;
    let description = file.description(pages[0].index)?;
    let stack = Stack::new(&file.source, &description, pages.len(), &mut notes)?;
    let plain = file.plain_start(&pages, &stack);
    let description = file.describe(&pages[0].kind, &stack, plain, options, notes)?;
    if plain.is_some() {
        return description.read(path, options.stream_above);
    }
    let order = match &stack.pages {
        Some(order) => order.clone(),
        None => (0..pages.len()).collect(),
    };
    let kind = pages[0].kind;
    file.check_packed(&kind, &pages, order.len())?;
    let numbers: Vec<usize> = order.iter().map(|i| pages[*i].index).collect();
    description.read_from(path, &mut |length, parts| {
        file.decode(&kind, &numbers, length, parts)
    })
}

/// An open file.
struct TiffFile {
    source: Source,
    decoder: Decoder<BufReader<File>>,
    length: u64,
    /// Whether this is BigTIFF.
    is_big: bool,
}

/// The properties that pages of one stack have in common.
#[derive(Clone, Copy, PartialEq)]
struct Kind {
    width: u32,
    height: u32,
    /// Numbers of a pixel.
    samples: usize,
    /// Those of a pixel are apart, each in an image of its own.
    planar: bool,
    number: Number,
    colors: bool,
    /// The crate turns these numbers round, which we undo.
    inverted: bool,
}

impl Kind {
    /// Bytes of a page; the file's numbers are below 2³², so that they can be multiplied.
    fn bytes(&self) -> u64 {
        let pixels = u64::from(self.width) * u64::from(self.height);
        pixels.saturating_mul((self.samples * self.number.size()) as u64)
    }
}

/// A page that is a slice.
struct Page {
    /// Its place among all pages of the file.
    index: usize,
    kind: Kind,
    /// Where its bytes begin, if they stand there as they are.
    start: Option<u64>,
    /// Bytes of its strips or tiles.
    packed: u64,
    /// The most bytes of samples that these hold.
    most: u64,
}

impl TiffFile {
    fn open(path: &Path) -> Result<TiffFile, Error> {
        let (file, length) = open_file(path)?;
        let source = Source {
            path: path.to_owned(),
            bytes: Vec::new(),
        };
        let mut limits = Limits::default();
        // A value in memory takes 32 bytes, for one or more in the file.
        let of_file = usize::try_from(length.saturating_mul(32)).unwrap_or(usize::MAX);
        limits.decoding_buffer_size = limits.decoding_buffer_size.min(of_file);
        limits.intermediate_buffer_size = usize::try_from(length).unwrap_or(usize::MAX);
        let refuse = |error: TiffError| refused(&source, 0, &error);
        let decoder = Decoder::new(BufReader::new(file)).map_err(refuse)?;
        let mut decoder = decoder.with_limits(limits);
        let version = decoder
            .goto_offset_u64(2)
            .and_then(|()| decoder.read_short());
        Ok(TiffFile {
            is_big: version.map_err(|error| refuse(error.into()))? == BIG,
            decoder,
            source,
            length,
        })
    }

    /// The pages like the first.
    fn pages(&mut self, notes: &mut Vec<String>) -> Result<Vec<Page>, Error> {
        let mut pages: Vec<Page> = Vec::new();
        let (mut others, mut described) = (0, 0u64);
        for index in 0.. {
            if index == MOST_FILES {
                let what = format!("more than {MOST_FILES} pages");
                return Err(self.source.error(format!("page {index}"), what));
            }
            // Else a few bytes that many directories share would take long.
            described = described.saturating_add(self.directory_bytes());
            if described > self.length {
                let what = format!(
                    "directories of {described} bytes are in a file of {}: they overlap",
                    self.length
                );
                return Err(self.source.error(format!("page {index}"), what));
            }
            let kind = self.kind(index);
            match (kind, pages.first()) {
                (Err(error), None) => return Err(error),
                (Ok(kind), first) if first.is_none_or(|first| first.kind == kind) => {
                    let start = self.start(&kind);
                    let [_, lengths] = self.chunks();
                    let packed = lengths.into_iter().fold(0, u64::saturating_add);
                    pages.push(Page {
                        index,
                        kind,
                        start,
                        packed,
                        most: packed.saturating_mul(self.growth()),
                    });
                }
                _ => others += 1,
            }
            if !self.decoder.more_images() {
                break;
            }
            let next = self.decoder.next_image();
            next.map_err(|error| refused(&self.source, index + 1, &error))?;
        }
        if others > 0 {
            notes.push(format!(
                "{} left out: of another size or type than the first",
                count(others, "page")
            ));
        }
        Ok(pages)
    }

    /// The kind of the page that the decoder is at.
    fn kind(&mut self, page: usize) -> Result<Kind, Error> {
        let refuse = |error: TiffError| refused(&self.source, page, &error);
        let (width, height) = self.decoder.dimensions().map_err(refuse)?;
        let color = self.decoder.colortype().map_err(refuse)?;
        let tag = |decoder: &mut Decoder<_>, tag, other: u16| {
            decoder.find_tag_unsigned(tag).map(|v| v.unwrap_or(other))
        };
        let inverted = tag(&mut self.decoder, Tag::PhotometricInterpretation, 1).map_err(refuse)?;
        let planar = tag(&mut self.decoder, Tag::PlanarConfiguration, 1).map_err(refuse)?;
        let formats = self
            .decoder
            .find_tag_unsigned_vec::<u16>(Tag::SampleFormat)
            .map_err(refuse)?;
        let format = formats.and_then(|f| f.first().copied()).unwrap_or(1);
        let number = number_of(format, color.bit_depth());
        let wrong = |what: String| self.source.error(format!("page {page}"), what);
        let number = number.ok_or_else(|| {
            let bits = color.bit_depth();
            wrong(format!(
                "samples of {bits} bits in format {format} are not read"
            ))
        })?;
        let layout = self.decoder.image_buffer_layout().map_err(refuse)?;
        let pixels = u64::from(width) * u64::from(height);
        let samples = layout.complete_len as u64 / pixels / number.size() as u64;
        let kind = Kind {
            width,
            height,
            samples: samples as usize,
            planar: planar == 2 && samples > 1,
            number,
            colors: matches!(color, ColorType::RGB(_) | ColorType::RGBA(_)),
            inverted: inverted == 0,
        };
        if samples == 0 || kind.bytes() != layout.complete_len as u64 {
            return Err(wrong(format!("pixels of {color:?} are not read")));
        }
        if kind.inverted && !matches!(number, Number::U8 | Number::U16 | Number::U32 | Number::U64)
        {
            return Err(wrong(
                "white is zero, and numbers have signs or are floats".into(),
            ));
        }
        let (across, down) = self.decoder.chunk_dimensions();
        let of_chunk = u64::from(across) * u64::from(down);
        if of_chunk.saturating_mul(samples * number.size() as u64) > kind.bytes() + MOST_PADDING {
            let what = format!("tiles of {across}×{down} in a page of {width}×{height}");
            return Err(wrong(what));
        }
        Ok(kind)
    }

    /// Offsets and lengths of the strips or tiles of the decoder's page.
    fn chunks(&mut self) -> [Vec<u64>; 2] {
        let tags = match self.decoder.get_chunk_type() {
            ChunkType::Strip => [Tag::StripOffsets, Tag::StripByteCounts],
            ChunkType::Tile => [Tag::TileOffsets, Tag::TileByteCounts],
        };
        tags.map(|tag| self.decoder.get_tag_u64_vec(tag).unwrap_or_default())
    }

    /// The fewest bytes of the decoder's page's directory, and of where its strips or tiles are.
    fn directory_bytes(&mut self) -> u64 {
        let place = self.decoder.ifd_pointer().map_or(0, |place| place.0);
        let count = self.decoder.goto_offset_u64(place).and_then(|()| {
            Ok(match self.is_big {
                true => self.decoder.read_long8()?.saturating_mul(20),
                false => u64::from(self.decoder.read_short()?) * 12,
            })
        });
        let [offsets, _] = self.chunks();
        count.unwrap_or(0).saturating_add(2 * offsets.len() as u64)
    }

    /// The most bytes that a byte of the decoder's page becomes.
    fn growth(&mut self) -> u64 {
        let compression = self.decoder.find_tag_unsigned::<u32>(Tag::Compression);
        match compression.ok().flatten().unwrap_or(1) {
            1 => 1,
            8 | 32946 => DEFLATE,
            32773 => PACK_BITS,
            _ => LZW,
        }
    }

    /// Where the numbers of the decoder's page begin, if they stand there as they are.
    fn start(&mut self, kind: &Kind) -> Option<u64> {
        let mut tag = |tag| self.decoder.find_tag_unsigned::<u16>(tag).ok();
        let compression = tag(Tag::Compression)?.unwrap_or(1);
        let predictor = tag(Tag::Predictor)?.unwrap_or(1);
        let is_strips = self.decoder.get_chunk_type() == ChunkType::Strip;
        if (compression, predictor, is_strips) != (1, 1, true) {
            return None;
        }
        let [offsets, lengths] = self.chunks();
        let start = *offsets.first()?;
        let mut end = start;
        for (offset, length) in offsets.into_iter().zip(lengths) {
            if offset != end {
                return None;
            }
            end = end.checked_add(length)?;
        }
        (end - start == kind.bytes()).then_some(start)
    }

    /// The `ImageDescription` of a page, empty if there is none.
    fn description(&mut self, page: usize) -> Result<String, Error> {
        let refuse = |error: TiffError| refused(&self.source, page, &error);
        self.decoder.seek_to_image(page).map_err(refuse)?;
        let mut ifd = self.decoder.image_ifd();
        let Some(entry) = ifd.find_entry(Tag::ImageDescription) else {
            return Ok(String::new());
        };
        let mut bytes = vec![0; entry.count().min(self.length) as usize];
        let read = ifd.find_tag_bytes(Tag::ImageDescription, &mut bytes, 0);
        read.map_err(refuse)?;
        // Programs write UTF-8 or Latin-1 there, for the signs of units.
        let text = String::from_utf8_lossy(&bytes);
        Ok(text.trim_end_matches('\0').to_owned())
    }

    /// The distances of pixels that the resolution of the first page means, without their unit.
    fn resolution(&mut self) -> [Option<f64>; 2] {
        [Tag::XResolution, Tag::YResolution].map(|tag| {
            let Value::Rational(pixels, units) = self.decoder.get_tag(tag).ok()? else {
                return None;
            };
            let per_unit = f64::from(pixels) / f64::from(units);
            Some(1.0 / per_unit).filter(|step| *step > 0.0 && step.is_finite())
        })
    }

    /// Where the samples of all pages begin, if they stand one behind the other as they are.
    fn plain_start(&self, pages: &[Page], stack: &Stack) -> Option<u64> {
        let start = pages[0].start?;
        let bytes = pages[0].kind.bytes();
        let follows = |(page, i): (&Page, u64)| {
            page.start?
                .checked_sub(start)
                .filter(|at| Some(*at) == bytes.checked_mul(i))
        };
        let all_follow = pages.iter().zip(0..).all(|pair| follows(pair).is_some());
        (all_follow && stack.pages.is_none()).then_some(start)
    }

    /// A description of the pages, and of where their samples stand: from byte `plain` on, or packed.
    fn describe(
        &mut self,
        kind: &Kind,
        stack: &Stack,
        plain: Option<u64>,
        options: &ReadOptions,
        mut notes: Vec<String>,
    ) -> Result<Description, Error> {
        if plain.is_none() && stack.is_truncated {
            let what = "the samples of further slices should follow those of the first page, \
                        which are packed";
            return Err(self.source.error("page 0", what));
        }
        let slices = stack.size(PageAxis::Slices);
        if slices < 2 {
            return Err(self.source.error_with_help(
                "the pages",
                "there is one slice, which is a picture; a volume has several",
                "save all slices as the pages of one file",
            ));
        }
        let lattice = Lattice {
            dims: [kind.width as usize, kind.height as usize, slices],
            origin: options.origin.unwrap_or(DVec3::ZERO),
            spacing: match options.spacing {
                Some(spacing) => spacing,
                None => self.spacing(stack, &mut notes),
            },
            direction: DMat3::IDENTITY,
            interpolation: Interpolation::Linear,
        };
        let mut extras = Vec::new();
        if kind.samples > 1 {
            extras.push(Extra {
                before: if kind.planar { 2 } else { 0 },
                size: kind.samples,
                entries: match kind.colors {
                    true => Entries::Colors,
                    false => Entries::Numbered,
                },
            });
        }
        let mut before = 2;
        for &(axis, size) in &stack.axes {
            match axis {
                PageAxis::Slices => before = 3,
                _ if size > 1 => extras.push(Extra {
                    before,
                    size,
                    entries: Entries::Numbered,
                }),
                _ => {}
            }
        }
        Ok(Description {
            lattice,
            is_placed: false,
            payload: Payload {
                files: vec![self.source.path.clone()],
                start: 0,
                lines: 0,
                skip: Some(plain.unwrap_or(0)),
                encoding: Encoding::Raw,
                number: kind.number,
                endian: match self.decoder.byte_order() {
                    ByteOrder::LittleEndian => Endian::Little,
                    ByteOrder::BigEndian => Endian::Big,
                },
            },
            extras,
            scale: None,
            name: "scalars".into(),
            notes,
        })
    }

    /// How far apart samples are.
    fn spacing(&mut self, stack: &Stack, notes: &mut Vec<String>) -> DVec3 {
        let [mut x, mut y, z] = stack.spacing;
        if stack.has_resolution {
            [x, y] = self.resolution();
        }
        let is_good = |step: &f64| *step > 0.0 && step.is_finite();
        let steps = [x, y, z].map(|step| step.filter(is_good));
        let missing: Vec<&str> = (0..3)
            .filter(|i| steps[*i].is_none())
            .map(|i| ["x", "y", "z"][i])
            .collect();
        if !missing.is_empty() {
            notes.push(format!(
                "the file does not say how far apart samples are along {}: 1 is taken",
                missing.join(" and ")
            ));
        }
        match &stack.unit {
            Some(unit) if missing.len() < 3 => notes.push(format!("lengths are in {unit}")),
            _ => {}
        }
        DVec3::from_array(steps.map(|step| step.unwrap_or(1.0)))
    }

    /// Refuses `count` of `pages` that hold more than their bytes in the file can.
    fn check_packed(&self, kind: &Kind, pages: &[Page], count: usize) -> Result<(), Error> {
        const DAMAGED: &str = "the file is truncated or damaged; copy or write it again";
        let refuse = |what: String, help: &str| {
            let error = self.source.error_with_help("the samples", what, help);
            Err(error)
        };
        let sum = |part: fn(&Page) -> u64| pages.iter().map(part).fold(0, u64::saturating_add);
        let (packed, most) = (sum(|page| page.packed), sum(|page| page.most));
        let needed = kind.bytes().saturating_mul(count as u64);
        let length = self.length;
        if packed > length {
            let what = format!(
                "{packed} bytes of strips or tiles are in {length}: they overlap, or the file ends"
            );
            return refuse(what, DAMAGED);
        }
        if needed > most {
            let what = format!("{packed} packed bytes cannot hold {needed} bytes of samples");
            return refuse(what, DAMAGED);
        }
        if needed > most_unpacked(length) {
            let what =
                format!("{needed} bytes of samples are packed in {length}, which is refused");
            return refuse(what, UNPACK);
        }
        Ok(())
    }

    /// `parts` runs of `length` numbers each of the pages with these numbers, in order.
    fn decode(
        &mut self,
        kind: &Kind,
        pages: &[usize],
        length: usize,
        parts: usize,
    ) -> Result<Vec<Numbers>, Error> {
        let native = match cfg!(target_endian = "big") {
            true => Endian::Big,
            false => Endian::Little,
        };
        let mut runs: Vec<Numbers> = Vec::with_capacity(parts.min(pages.len()));
        let mut bytes = vec![0; kind.bytes() as usize];
        for &page in pages {
            let refuse = |error: TiffError| refused(&self.source, page, &error);
            self.decoder.seek_to_image(page).map_err(refuse)?;
            self.decoder.read_image_bytes(&mut bytes).map_err(refuse)?;
            if kind.inverted {
                bytes.iter_mut().for_each(|byte| *byte = !*byte);
            }
            let count = bytes.len() / kind.number.size();
            let numbers = kind.number.read(&mut bytes.as_slice(), native, count);
            let numbers = numbers.map_err(|error| refused(&self.source, page, &error.into()))?;
            match runs.last_mut().filter(|run| run.len() < length) {
                Some(run) => {
                    run.append(numbers);
                }
                None => runs.push(numbers),
            }
        }
        Ok(runs)
    }
}

/// The error for a page that is refused.
fn refused(source: &Source, page: usize, error: &TiffError) -> Error {
    source.error_with_help(
        format!("page {page}"),
        format!("the page is not read: {error}"),
        "save the stack without compression, or as .nrrd",
    )
}

fn number_of(format: u16, bits: u8) -> Option<Number> {
    Some(match (format, bits) {
        (1, 8) => Number::U8,
        (1, 16) => Number::U16,
        (1, 32) => Number::U32,
        (1, 64) => Number::U64,
        (2, 8) => Number::I8,
        (2, 16) => Number::I16,
        (2, 32) => Number::I32,
        (2, 64) => Number::I64,
        (3, 16) => Number::F16,
        (3, 32) => Number::F32,
        (3, 64) => Number::F64,
        _ => return None,
    })
}
