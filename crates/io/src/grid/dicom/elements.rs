//! Data elements of DICOM files: tags, representations of values and lengths (PS3.5, sections 7 and 10).
//!
//! This reader is our own because of memory: `dicom-object` 0.10.1 allocates the length that a field
//! states, up to 4 GiB, before it finds that the file ends. Here a value is a part of the file's bytes,
//! and only the elements of [`KEPT`] are kept.

use std::collections::BTreeMap;

use super::tags;
use crate::source::Endian;

/// A group and an element, in the upper and lower 16 bits.
pub(super) type Tag = u32;

/// Sequences within sequences are followed to this depth; functional groups need three.
const MOST_DEPTH: usize = 16;

/// A length that is not stated: a delimiter ends the value.
const UNDEFINED: u32 = u32::MAX;

const ITEM: Tag = 0xFFFE_E000;
const ITEM_END: Tag = 0xFFFE_E00D;
const SEQUENCE_END: Tag = 0xFFFE_E0DD;

/// How elements are written: by the transfer syntax.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Encoding {
    pub(super) endian: Endian,
    /// Elements state the representation of their value.
    pub(super) explicit: bool,
}

/// The encoding of the file's meta information, whatever the transfer syntax.
pub(super) const META: Encoding = Encoding {
    endian: Endian::Little,
    explicit: true,
};

/// Why bytes are no data set.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) at: usize,
    pub(super) what: String,
    /// The bytes end before the data set does.
    pub(super) is_short: bool,
}

/// The elements of a data set that are of use here, by tag.
#[derive(Debug, Default)]
pub(super) struct DataSet<'a> {
    values: BTreeMap<Tag, &'a [u8]>,
    sequences: BTreeMap<Tag, Vec<DataSet<'a>>>,
    is_big: bool,
}

/// Where the pixels stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelPlace {
    pub(super) tag: Tag,
    /// The first byte of the value.
    pub(super) start: usize,
    /// The value is one of words of 16 bits, whose order is that of the file, whatever the numbers are.
    pub(super) is_words: bool,
    /// Bytes of the value; `None` where it is a sequence of fragments.
    pub(super) length: Option<usize>,
}

impl<'a> DataSet<'a> {
    /// The items of a sequence; none if there is no such sequence.
    pub(super) fn items(&self, tag: Tag) -> &[DataSet<'a>] {
        self.sequences.get(&tag).map_or(&[], Vec::as_slice)
    }

    /// A value as text, without padding.
    pub(super) fn text(&self, tag: Tag) -> Option<&'a str> {
        let bytes = self.values.get(&tag)?;
        let is_padding = |c: char| c == '\0' || c.is_whitespace();
        let text = std::str::from_utf8(bytes).ok()?.trim_matches(is_padding);
        (!text.is_empty()).then_some(text)
    }

    /// The numbers of a value that is text (DS and IS); `None` if one of them is no finite number.
    pub(super) fn decimals(&self, tag: Tag) -> Option<Vec<f64>> {
        let numbers = self.text(tag)?.split('\\').map(|word| {
            let number: Option<f64> = word.trim().parse().ok();
            number.filter(|number| number.is_finite())
        });
        numbers.collect()
    }

    /// The first of [`DataSet::decimals`].
    pub(super) fn decimal(&self, tag: Tag) -> Option<f64> {
        self.decimals(tag)?.first().copied()
    }

    /// A whole number of 16 bits.
    pub(super) fn short(&self, tag: Tag) -> Option<u16> {
        let bytes = self.values.get(&tag)?.get(..2)?;
        Some(self.endian().u16(bytes))
    }

    /// Whole numbers of 32 bits.
    pub(super) fn longs(&self, tag: Tag) -> Option<Vec<u32>> {
        let bytes = self.values.get(&tag)?.chunks_exact(4);
        Some(bytes.map(|bytes| self.endian().u32(bytes)).collect())
    }

    /// A float of 64 bits.
    pub(super) fn double(&self, tag: Tag) -> Option<f64> {
        let bytes = self.values.get(&tag)?.get(..8)?;
        Some(self.endian().f64(bytes)).filter(|number| number.is_finite())
    }

    fn endian(&self) -> Endian {
        match self.is_big {
            true => Endian::Big,
            false => Endian::Little,
        }
    }
}

/// The elements from byte `start` of `bytes` on, up to the pixels, where these begin, and where the
/// elements end if there are none.
pub(super) fn data_set(
    bytes: &[u8],
    start: usize,
    encoding: Encoding,
) -> Result<(DataSet<'_>, Option<PixelPlace>), Fault> {
    let mut parser = Parser {
        bytes,
        at: start,
        encoding,
        depth: 0,
        pixels: None,
    };
    let set = parser.set(None)?;
    Ok((set, parser.pixels))
}

/// The elements of group 2, which begin at byte `start`, and where they end.
pub(super) fn meta(bytes: &[u8], start: usize) -> Result<(DataSet<'_>, usize), Fault> {
    let mut parser = Parser {
        bytes,
        at: start,
        encoding: META,
        depth: 0,
        pixels: None,
    };
    let mut set = DataSet::default();
    while parser.at < bytes.len() && parser.peek_group() == Some(2) {
        parser.element(&mut set)?;
    }
    Ok((set, parser.at))
}

/// The fragments of encapsulated pixels (PS3.5, annex A.4), that of the offsets first.
pub(super) fn fragments(bytes: &[u8], start: usize) -> Result<Vec<&[u8]>, Fault> {
    let mut parser = Parser {
        bytes,
        at: start,
        encoding: META,
        depth: 0,
        pixels: None,
    };
    let mut found = Vec::new();
    loop {
        let at = parser.at;
        match parser.delimiter()? {
            (ITEM, length) if length != UNDEFINED => found.push(parser.take(length as usize)?),
            (SEQUENCE_END, _) => return Ok(found),
            (tag, _) => {
                return Err(Fault {
                    at,
                    what: format!("a fragment of pixels begins with tag {}", shown(tag)),
                    is_short: false,
                });
            }
        }
    }
}

/// A tag as people write it: "(0028,0010)".
fn shown(tag: Tag) -> String {
    format!("({:04X},{:04X})", tag >> 16, tag & 0xFFFF)
}

struct Parser<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    depth: usize,
    /// Found at depth 0, where parsing ends.
    pixels: Option<PixelPlace>,
}

impl<'a> Parser<'a> {
    fn fault(&self, what: impl Into<String>) -> Fault {
        Fault {
            at: self.at,
            what: what.into(),
            is_short: false,
        }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let Some(taken) = taken else {
            return Err(Fault {
                at: self.at,
                what: format!(
                    "{count} bytes should follow, and {} do",
                    self.bytes.len() - self.at
                ),
                is_short: true,
            });
        };
        self.at += count;
        Ok(taken)
    }

    fn u16(&mut self) -> Result<u16, Fault> {
        Ok(self.encoding.endian.u16(self.take(2)?))
    }

    fn u32(&mut self) -> Result<u32, Fault> {
        Ok(self.encoding.endian.u32(self.take(4)?))
    }

    fn tag(&mut self) -> Result<Tag, Fault> {
        Ok(Tag::from(self.u16()?) << 16 | Tag::from(self.u16()?))
    }

    fn peek_group(&self) -> Option<u16> {
        let bytes = self.bytes.get(self.at..self.at + 2)?;
        Some(self.encoding.endian.u16(bytes))
    }

    /// The tag and length of an item or delimiter.
    fn delimiter(&mut self) -> Result<(Tag, u32), Fault> {
        Ok((self.tag()?, self.u32()?))
    }

    /// Elements up to byte `end`, or to the delimiter of an item; at depth 0 up to the pixels, or to the end.
    fn set(&mut self, end: Option<usize>) -> Result<DataSet<'a>, Fault> {
        let mut set = DataSet {
            is_big: self.encoding.endian == Endian::Big,
            ..DataSet::default()
        };
        loop {
            let is_over = match end {
                Some(end) => self.at >= end,
                None => self.depth == 0 && (self.at == self.bytes.len() || self.pixels.is_some()),
            };
            if is_over {
                break;
            }
            if !self.element(&mut set)? {
                break;
            }
        }
        match end {
            Some(end) if self.at != end => Err(self.fault("an element ends behind its item")),
            _ => Ok(set),
        }
    }

    /// Reads an element into `set`; false for the delimiter of an item.
    fn element(&mut self, set: &mut DataSet<'a>) -> Result<bool, Fault> {
        let tag = self.tag()?;
        if tag == ITEM_END && self.depth > 0 {
            self.u32()?;
            return Ok(false);
        }
        if tag >> 16 == 0xFFFE {
            return Err(self.fault(format!("{} stands where an element should", shown(tag))));
        }
        let (representation, length) = self.length(tag)?;
        if self.depth == 0 && tags::PIXELS.contains(&tag) {
            self.pixels = Some(PixelPlace {
                tag,
                start: self.at,
                is_words: representation == Some(b"OW"),
                length: (length != UNDEFINED).then_some(length as usize),
            });
            return Ok(true);
        }
        let is_kept = tags::SEQUENCES.contains(&tag);
        if length == UNDEFINED {
            // An unknown value that is a sequence is in implicit encoding (PS3.5, section 6.2.2).
            let items = match representation {
                None | Some(b"SQ") => self.items(None)?,
                Some(b"UN") => {
                    let encoding = self.encoding;
                    self.encoding = Encoding {
                        endian: Endian::Little,
                        explicit: false,
                    };
                    let items = self.items(None);
                    self.encoding = encoding;
                    items?
                }
                Some(_) => {
                    return Err(self.fault(format!("{} states no length", shown(tag))));
                }
            };
            if is_kept {
                set.sequences.insert(tag, items);
            }
            return Ok(true);
        }
        let start = self.at;
        let value = self.take(length as usize)?;
        if is_kept && !matches!(representation, Some(b"UN")) {
            self.at = start;
            let items = self.items(Some(start + value.len()))?;
            set.sequences.insert(tag, items);
        } else if tags::VALUES.contains(&tag) {
            set.values.insert(tag, value);
        }
        Ok(true)
    }

    /// The representation, if it is stated, and the length of the value of an element.
    fn length(&mut self, tag: Tag) -> Result<(Option<&'a [u8; 2]>, u32), Fault> {
        if !self.encoding.explicit {
            return Ok((None, self.u32()?));
        }
        let at = self.at;
        let representation = self.take(2)?.first_chunk::<2>();
        let representation = representation.filter(|r| r.iter().all(u8::is_ascii_uppercase));
        let Some(representation) = representation else {
            self.at = at;
            let what = format!("{} has no representation of its value", shown(tag));
            return Err(self.fault(what));
        };
        let length = match representation {
            b"OB" | b"OD" | b"OF" | b"OL" | b"OV" | b"OW" | b"SQ" | b"SV" | b"UC" | b"UN"
            | b"UR" | b"UT" | b"UV" => {
                self.take(2)?;
                self.u32()?
            }
            _ => self.u16()?.into(),
        };
        Ok((Some(representation), length))
    }

    /// The items of a sequence up to byte `end`, or to its delimiter.
    fn items(&mut self, end: Option<usize>) -> Result<Vec<DataSet<'a>>, Fault> {
        if self.depth == MOST_DEPTH {
            return Err(self.fault(format!("sequences lie in {MOST_DEPTH} others")));
        }
        self.depth += 1;
        let mut items = Vec::new();
        while end.is_none_or(|end| self.at < end) {
            let (tag, length) = self.delimiter()?;
            match (tag, length) {
                (SEQUENCE_END, _) if end.is_none() => break,
                (ITEM, UNDEFINED) => items.push(self.set(None)?),
                (ITEM, length) => {
                    let item_end = self.at.saturating_add(length as usize);
                    if item_end > end.unwrap_or(self.bytes.len()) {
                        self.take(length as usize)?;
                        return Err(self.fault("an item ends behind its sequence"));
                    }
                    items.push(self.set(Some(item_end))?);
                }
                _ => {
                    let what = format!("{} stands where an item should", shown(tag));
                    return Err(self.fault(what));
                }
            }
        }
        self.depth -= 1;
        Ok(items)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn explicit(tag: Tag, representation: &[u8; 2], value: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend(((tag >> 16) as u16).to_le_bytes());
        bytes.extend((tag as u16).to_le_bytes());
        bytes.extend(representation);
        if representation == b"SQ" {
            bytes.extend([0, 0]);
            bytes.extend((value.len() as u32).to_le_bytes());
        } else {
            bytes.extend((value.len() as u16).to_le_bytes());
        }
        bytes.extend(value);
        bytes
    }

    fn item(value: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0xFE, 0xFF, 0x00, 0xE0];
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
        bytes
    }

    #[test]
    fn sequences_nest_to_a_depth() {
        let nested = |depth: usize| {
            let mut value = explicit(tags::ROWS, b"US", &[7, 0]);
            for _ in 0..depth {
                value = explicit(tags::SHARED_GROUPS, b"SQ", &item(&value));
            }
            value
        };
        let value = nested(2);
        let (set, _) = data_set(&value, 0, META).unwrap();
        let inner = &set.items(tags::SHARED_GROUPS)[0].items(tags::SHARED_GROUPS)[0];
        assert_eq!(inner.short(tags::ROWS), Some(7));
        assert!(data_set(&nested(MOST_DEPTH), 0, META).is_ok());
        let fault = data_set(&nested(MOST_DEPTH + 1), 0, META).unwrap_err();
        assert!(fault.what.contains("lie in 16 others"), "{fault:?}");
    }

    #[test]
    fn an_item_stays_in_its_sequence() {
        let mut value = item(&explicit(tags::ROWS, b"US", &[7, 0]));
        value[4] += 2;
        let mut bytes = explicit(tags::SHARED_GROUPS, b"SQ", &value);
        bytes.extend(explicit(tags::COLUMNS, b"US", &[7, 0]));
        let fault = data_set(&bytes, 0, META).unwrap_err();
        assert!(fault.what.contains("behind its sequence"), "{fault:?}");
    }

    #[test]
    fn every_cut_is_short() {
        let mut bytes = explicit(
            tags::SHARED_GROUPS,
            b"SQ",
            &item(&explicit(tags::ROWS, b"US", &[7, 0])),
        );
        bytes.extend(explicit(tags::POSITION, b"DS", b"1\\2\\3 "));
        let whole = data_set(&bytes, 0, META).unwrap().0;
        assert_eq!(whole.decimals(tags::POSITION), Some(vec![1.0, 2.0, 3.0]));
        let between = bytes.len() - 14;
        for end in (1..bytes.len()).filter(|end| *end != between) {
            let fault = data_set(&bytes[..end], 0, META).unwrap_err();
            assert!(fault.is_short, "{end}: {fault:?}");
        }
    }
}
