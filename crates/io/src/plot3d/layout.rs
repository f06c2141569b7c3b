//! Which of Plot3D's binary layouts a file has, from its size and its header.
//!
//! The format does not say: byte order, float width, Fortran record markers,
//! block count and IBLANK must be agreed on elsewhere. But each combination
//! needs a different number of bytes, so the header's dimensions and the size of
//! the file tell them apart.

use tetrascope_core::Error;

use crate::source::{Endian, Source, count};

/// Points along i, j and k.
pub(super) type Dimensions = [u32; 3];

/// The content of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// All x, all y, all z of a block, then perhaps its IBLANK integers.
    Grid,
    /// Four numbers of the free stream, then five arrays.
    Solution,
}

/// A way to lay the numbers out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    pub(super) endian: Endian,
    /// 64-bit floats, else 32-bit.
    wide: bool,
    /// Each record lies between two copies of its length, as Fortran writes it.
    records: bool,
    /// The file begins with the number of blocks.
    multiple: bool,
    /// Integers after the coordinates.
    blanking: bool,
}

/// Where everything is in a file.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) encoding: Encoding,
    pub(super) blocks: Vec<Block>,
    /// Bytes that the layout accounts for; the file may be longer.
    pub(super) size: u64,
}

/// Where the numbers of one block are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) dimensions: Dimensions,
    /// Byte offset of the four free-stream numbers; 0 in a grid.
    pub(super) conditions: usize,
    /// Byte offset of the coordinates or of Q1.
    pub(super) values: usize,
    /// Byte offset of IBLANK.
    pub(super) blanks: Option<usize>,
}

impl Encoding {
    fn float_size(self) -> u64 {
        if self.wide { 8 } else { 4 }
    }

    /// Float number `index` of those that begin at byte `offset`.
    pub(super) fn float(self, source: &Source, offset: usize, index: usize) -> f64 {
        let size = self.float_size() as usize;
        let bytes = &source.bytes[offset + size * index..][..size];
        if self.wide {
            self.endian.f64(bytes)
        } else {
            f64::from(self.endian.f32(bytes))
        }
    }

    /// `length` floats, the first at byte `offset`.
    pub(super) fn floats(
        self,
        source: &Source,
        offset: usize,
        length: usize,
    ) -> impl Iterator<Item = f64> {
        (0..length).map(move |index| self.float(source, offset, index))
    }

    /// "big-endian, 32-bit floats, C binary".
    pub(super) fn describe(self) -> String {
        format!(
            "{}, {}-bit floats, {}",
            self.endian.name(),
            8 * self.float_size(),
            if self.records {
                "Fortran records"
            } else {
                "C binary"
            }
        )
    }
}

impl Layout {
    /// The layout that explains the file best: one that uses every byte, else
    /// one whose record markers are all in place, else the one that leaves the
    /// fewest bytes over.
    pub(super) fn detect(source: &Source, kind: Kind) -> Result<Layout, Error> {
        let available = source.bytes.len() as u64;
        let mut best: Option<Layout> = None;
        // For the message when nothing fits: the header that asks for the least.
        let mut least: Option<(u64, Endian, Vec<Dimensions>)> = None;
        for (endian, records, multiple) in headers() {
            let Some(dimensions) = read_header(source, endian, records, multiple) else {
                continue;
            };
            for (wide, blanking) in [(false, false), (false, true), (true, false), (true, true)] {
                if kind == Kind::Solution && blanking {
                    continue;
                }
                let encoding = Encoding {
                    endian,
                    wide,
                    records,
                    multiple,
                    blanking,
                };
                let Some(layout) = arrange(encoding, kind, &dimensions) else {
                    continue;
                };
                if least.as_ref().is_none_or(|(size, ..)| layout.size < *size) {
                    least = Some((layout.size, endian, dimensions.clone()));
                }
                let rank = |layout: &Layout| {
                    (
                        layout.is_exact(source),
                        layout.encoding.records,
                        layout.size,
                    )
                };
                if layout.size <= available
                    && best.as_ref().is_none_or(|best| rank(&layout) > rank(best))
                    && layout.agrees(source)
                {
                    best = Some(layout);
                }
            }
        }
        best.ok_or_else(|| describe_failure(source, kind, least))
    }

    /// Whether every byte of the file is accounted for.
    pub(super) fn is_exact(&self, source: &Source) -> bool {
        self.size == source.bytes.len() as u64
    }

    /// Whether record markers and IBLANK hold what they must.
    fn agrees(&self, source: &Source) -> bool {
        let int = |offset: usize| self.encoding.endian.i32(&source.bytes[offset..offset + 4]);
        if self.encoding.records {
            // Both ends of every record of the bodies; the header's were checked.
            for block in &self.blocks {
                let (first, last) = block.records(self.encoding);
                let framed = |start: usize, length: u64| {
                    let length = length as i64;
                    i64::from(int(start - 4)) == length
                        && i64::from(int(start + length as usize)) == length
                };
                if !framed(block.values, last) || (first > 0 && !framed(block.conditions, first)) {
                    return false;
                }
            }
        }
        // Where bytes are left over, they could be taken for IBLANK. Real values
        // are 0, 1, or ± the number of a block; zeros alone would blank all.
        let plausible = |block: &Block, offset: usize| {
            let values = (0..points(block.dimensions) as usize).map(|p| int(offset + 4 * p));
            let mut any = false;
            for value in values {
                if value.unsigned_abs() > 100_000 {
                    return false;
                }
                any |= value != 0;
            }
            any
        };
        self.is_exact(source)
            || self
                .blocks
                .iter()
                .all(|block| block.blanks.is_none_or(|offset| plausible(block, offset)))
    }
}

impl Block {
    /// Bytes of the record of free-stream numbers (0 in a grid) and of the record of values.
    fn records(&self, encoding: Encoding) -> (u64, u64) {
        let float = encoding.float_size();
        let n = points(self.dimensions);
        if self.conditions > 0 {
            (4 * float, 5 * n * float)
        } else {
            (0, 3 * n * float + if encoding.blanking { 4 * n } else { 0 })
        }
    }
}

/// Points in a block; at most 2⁹³, so check with [`arrange`] first.
pub(super) fn points(dimensions: Dimensions) -> u64 {
    dimensions.iter().map(|&d| u64::from(d)).product()
}

/// Byte order, Fortran records, several blocks.
fn headers() -> impl Iterator<Item = (Endian, bool, bool)> {
    [Endian::Big, Endian::Little]
        .into_iter()
        .flat_map(|endian| [(endian, true), (endian, false)])
        .flat_map(|(endian, records)| [(endian, records, false), (endian, records, true)])
}

/// The dimensions of every block, if the file can begin with such a header.
fn read_header(
    source: &Source,
    endian: Endian,
    records: bool,
    multiple: bool,
) -> Option<Vec<Dimensions>> {
    let mut at = 0;
    let mut int = || -> Option<u32> {
        let value = endian.i32(source.bytes.get(at..at + 4)?);
        at += 4;
        u32::try_from(value).ok()
    };
    let mut block_count = 1;
    if multiple {
        if records && int()? != 4 {
            return None;
        }
        block_count = int()?;
        if records && int()? != 4 {
            return None;
        }
    }
    // No more blocks than the file has room for headers of.
    if block_count == 0 || u64::from(block_count) > source.bytes.len() as u64 / 12 {
        return None;
    }
    if records && u64::from(int()?) != 12 * u64::from(block_count) {
        return None;
    }
    let dimensions: Option<Vec<Dimensions>> = (0..block_count)
        .map(|_| Some([int()?, int()?, int()?]))
        .collect();
    if records && u64::from(int()?) != 12 * u64::from(block_count) {
        return None;
    }
    dimensions.filter(|all| all.iter().flatten().all(|&d| d > 0))
}

/// Where everything lies; `None` if the sizes overflow, so that no file can be it.
fn arrange(encoding: Encoding, kind: Kind, dimensions: &[Dimensions]) -> Option<Layout> {
    let marker = if encoding.records { 4 } else { 0 };
    let mut at = 12 * dimensions.len() as u64 + 2 * marker;
    if encoding.multiple {
        at += 4 + 2 * marker;
    }
    let mut blocks = Vec::with_capacity(dimensions.len());
    for &dimensions in dimensions {
        let n = dimensions
            .iter()
            .try_fold(1_u64, |n, &d| n.checked_mul(u64::from(d)))?;
        n.checked_mul(64)?; // more than any layout needs a point
        let mut block = Block {
            dimensions,
            conditions: 0,
            values: 0,
            blanks: None,
        };
        if kind == Kind::Solution {
            block.conditions = usize::try_from(at + marker).ok()?;
            at = at.checked_add(4 * encoding.float_size() + 2 * marker)?;
        }
        block.values = usize::try_from(at + marker).ok()?;
        let (_, length) = block.records(encoding);
        if encoding.blanking {
            let coordinates = 3 * n * encoding.float_size();
            block.blanks = Some(usize::try_from((at + marker).checked_add(coordinates)?).ok()?);
        }
        at = at.checked_add(length)?.checked_add(2 * marker)?;
        blocks.push(block);
    }
    Some(Layout {
        encoding,
        blocks,
        size: at,
    })
}

fn describe_failure(
    source: &Source,
    kind: Kind,
    least: Option<(u64, Endian, Vec<Dimensions>)>,
) -> Error {
    let what = match kind {
        Kind::Grid => "grid",
        Kind::Solution => "solution",
    };
    let head = &source.bytes[..source.bytes.len().min(256)];
    if head
        .iter()
        .all(|&b| b.is_ascii_graphic() || b.is_ascii_whitespace())
    {
        return source.error_with_help(
            "byte 0",
            "the file is text; of Plot3D only binary files are read",
            "write the grid and the solution as binary (unformatted) Plot3D",
        );
    }
    match least {
        Some((size, endian, blocks)) => source.error_with_help(
            "byte 0",
            format!(
                "the header of this Plot3D {what} says {} ({}), which needs at least {size} bytes, but the file has {}",
                describe_blocks(&blocks),
                endian.name(),
                source.bytes.len()
            ),
            "the file is truncated, or it is not a Plot3D file",
        ),
        None => source.error_with_help(
            "byte 0",
            format!("the file does not begin with the dimensions of a Plot3D {what} in either byte order"),
            "a Plot3D file begins with ni, nj and nk as 32-bit integers",
        ),
    }
}

/// "40×32×32", or "3 blocks, 10×10×10 the first".
pub(super) fn describe_blocks(blocks: &[Dimensions]) -> String {
    let [i, j, k] = blocks[0];
    match blocks.len() {
        1 => format!("{i}×{j}×{k} points"),
        n => format!(
            "{}, the first of {i}×{j}×{k} points",
            count(n as u64, "block")
        ),
    }
}
