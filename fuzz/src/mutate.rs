//! Changes to a seed, and the input that an index stands for.

use crate::pack::{Part, Wrap, pack};
use crate::random::Random;
use crate::seeds::{Entry, Kind, Seed};

/// Files to be read, made from a seed.
pub(crate) struct Input {
    /// Index into the list of kinds.
    pub(crate) kind: usize,
    /// Names and bytes; the first is the one that is opened.
    pub(crate) files: Vec<(&'static str, Vec<u8>)>,
    pub(crate) entry: Entry,
}

impl Input {
    /// The input `index` of the campaign `seed`: each kind in turn, a seed of it by chance.
    pub(crate) fn new(kinds: &[Kind], seed: u64, index: u64) -> Input {
        let random = &mut Random::new(seed, index);
        let kind = (index % kinds.len() as u64) as usize;
        let Kind {
            seeds,
            heavy,
            words,
            ..
        } = &kinds[kind];
        let chosen = match !heavy.is_empty() && random.one_in(HEAVY) {
            true => random.pick(heavy),
            false => random.pick(seeds),
        };
        let mut mutation = Mutation {
            random,
            words,
            seeds,
        };
        Input {
            kind,
            files: mutation.files(chosen),
            entry: chosen.entry.clone(),
        }
    }

    /// A seed as it is, of the kind with the index `kind`.
    pub(crate) fn unchanged(kind: usize, seed: &Seed) -> Input {
        let files = seed.files.iter();
        Input {
            kind,
            files: files.map(|(name, parts)| (*name, pack(parts))).collect(),
            entry: seed.entry.clone(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.files.iter().map(|(_, bytes)| bytes.len()).sum()
    }
}

struct Mutation<'a> {
    random: &'a mut Random,
    words: &'a [&'static str],
    /// Seeds of the same kind, to splice from.
    seeds: &'a [Seed],
}

/// A heavy seed is chosen once in so many times.
const HEAVY: usize = 500;

/// Numbers in text that are not what they were.
const NUMBERS: [&str; 36] = [
    "0",
    "0",
    "0",
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "3",
    "4",
    "7",
    "8",
    "9",
    "16",
    "64",
    "65",
    "127",
    "255",
    "256",
    "32768",
    "65535",
    "65536",
    "16777217",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "18446744073709551616",
    "1e308",
    "1e-310",
    "1e999",
    "nan",
    "-inf",
];

/// Bytes that mean something in many formats.
const BYTES: [u8; 13] = [
    0, 1, 2, 0x0a, 0x1b, b' ', b'0', b'9', b'<', b'"', 0x7f, 0x80, 0xff,
];

/// Whole numbers of 8 bytes; the low ones are taken for narrower types.
const INTEGERS: [u64; 16] = [
    0,
    1,
    2,
    3,
    5,
    8,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
];

const FLOATS: [f64; 10] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    -0.0,
    1e-310,
    1e39,
    1e30,
    1e-30,
    -1.0,
];

impl Mutation<'_> {
    fn files(&mut self, seed: &Seed) -> Vec<(&'static str, Vec<u8>)> {
        let mut files: Vec<(&'static str, Vec<Part>)> = seed.files.clone();
        // One change as a rule, a few at times.
        let mut changes = 1;
        while changes < 8 && self.random.one_in(2) {
            changes += 1;
        }
        let behind = self.random.below(changes + 1);
        for _ in 0..behind {
            let file = self.random.below(files.len());
            let parts = &mut files[file].1;
            let part = self.random.below(parts.len());
            let part = &mut parts[part];
            if let Wrap::Vtk { edit, .. } = &mut part.wrap
                && self.random.one_in(3)
            {
                let number = *self.random.pick(&INTEGERS) as u32;
                *edit = Some((self.random.below(8), number));
                continue;
            }
            self.change(&mut part.bytes);
            if self.random.one_in(100) {
                part.zeros = self.random.below(1 << 24);
            }
        }
        let mut files: Vec<_> = files
            .iter()
            .map(|(name, parts)| (*name, pack(parts)))
            .collect();
        for _ in behind..changes {
            let file = self.random.below(files.len());
            self.change(&mut files[file].1);
        }
        // Growth by doubling stays small: the bound on memory is a multiple of it.
        for (_, bytes) in &mut files {
            bytes.truncate(1 << 20);
        }
        files
    }

    fn change(&mut self, bytes: &mut Vec<u8>) {
        match self.random.below(16) {
            0 => self.flip(bytes),
            1 | 2 => self.byte(bytes),
            3 | 4 => self.integer(bytes),
            5 => self.float(bytes),
            6..=8 => self.number(bytes),
            9 => self.truncate(bytes),
            10 => self.remove(bytes),
            11 => self.repeat(bytes),
            12 => self.splice(bytes),
            13 | 14 => self.word(bytes),
            _ => self.line(bytes),
        }
    }

    fn flip(&mut self, bytes: &mut [u8]) {
        let at = self.random.below(bytes.len());
        let bit = self.random.below(8);
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 1 << bit;
        }
    }

    fn byte(&mut self, bytes: &mut Vec<u8>) {
        let at = self.random.below(bytes.len() + 1);
        let byte = match self.random.one_in(2) {
            true => self.random.next() as u8,
            false => *self.random.pick(&BYTES),
        };
        match bytes.get_mut(at) {
            Some(place) if !self.random.one_in(4) => *place = byte,
            _ => bytes.insert(at, byte),
        }
    }

    /// Puts a whole number at a multiple of its size, of either byte order.
    fn integer(&mut self, bytes: &mut [u8]) {
        let size = *self.random.pick(&[2, 4, 8]);
        let mut number = *self.random.pick(&INTEGERS);
        if self.random.one_in(4) {
            number = self.random.below(bytes.len() * 2) as u64;
        }
        let little = number.to_le_bytes();
        let mut digits = little[..size].to_vec();
        if self.random.one_in(2) {
            digits.reverse();
        }
        self.overwrite(bytes, &digits);
    }

    fn float(&mut self, bytes: &mut [u8]) {
        let number = *self.random.pick(&FLOATS);
        let mut digits = match self.random.one_in(2) {
            true => number.to_le_bytes().to_vec(),
            false => (number as f32).to_le_bytes().to_vec(),
        };
        if self.random.one_in(2) {
            digits.reverse();
        }
        self.overwrite(bytes, &digits);
    }

    fn overwrite(&mut self, bytes: &mut [u8], digits: &[u8]) {
        let places = bytes.len() / digits.len();
        let at = self.random.below(places) * digits.len();
        if let Some(place) = bytes.get_mut(at..at + digits.len()) {
            place.copy_from_slice(digits);
        }
    }

    /// Puts another number in place of one in text.
    fn number(&mut self, bytes: &mut Vec<u8>) {
        let from = self.random.below(bytes.len());
        let Some(start) = bytes[from.min(bytes.len())..]
            .iter()
            .position(u8::is_ascii_digit)
            .map(|i| from + i)
        else {
            return self.byte(bytes);
        };
        let is_part = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
        let before = bytes[..start].iter().rev().take_while(|b| is_part(b));
        let start = start - before.count();
        let end = start + bytes[start..].iter().take_while(|b| is_part(b)).count();
        let old = std::str::from_utf8(&bytes[start..end]).ok();
        let old: Option<i64> = old.and_then(|text| text.parse().ok());
        let new = match (self.random.below(5), old) {
            (0, Some(old)) => old.wrapping_add(1).to_string(),
            (1, Some(old)) => old.wrapping_sub(1).to_string(),
            (2, Some(old)) => old.wrapping_mul(1 << self.random.below(40)).to_string(),
            _ => (*self.random.pick(&NUMBERS)).into(),
        };
        let old = bytes[start..end].to_vec();
        if !self.random.one_in(4) {
            bytes.splice(start..end, new.into_bytes());
            return;
        }
        // Everywhere: counts that belong together stay equal.
        let mut rest = bytes.as_slice();
        let mut all = Vec::with_capacity(rest.len());
        while let Some(first) = rest.first() {
            if !is_part(first) {
                all.push(*first);
                rest = &rest[1..];
                continue;
            }
            let (token, behind) = rest.split_at(rest.iter().take_while(|b| is_part(b)).count());
            all.extend_from_slice(if token == old { new.as_bytes() } else { token });
            rest = behind;
        }
        *bytes = all;
    }

    fn truncate(&mut self, bytes: &mut Vec<u8>) {
        let most = bytes.len();
        // Near the end as often as anywhere.
        let cut = match self.random.one_in(2) {
            true => self.random.below(most),
            false => self.random.below(most.min(16)),
        };
        bytes.truncate(most - cut);
    }

    /// A range of up to 64 bytes, or at times of any length.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.random.below(length);
        let most = match self.random.one_in(8) {
            true => length,
            false => 64,
        };
        let end = (start + 1 + self.random.below(most)).min(length);
        start..end
    }

    fn remove(&mut self, bytes: &mut Vec<u8>) {
        let range = self.range(bytes.len());
        bytes.drain(range);
    }

    fn repeat(&mut self, bytes: &mut Vec<u8>) {
        let range = self.range(bytes.len());
        let times = 1 + self.random.below(4);
        let copy = bytes[range.clone()].repeat(times);
        let at = match self.random.one_in(2) {
            true => range.end,
            false => self.random.below(bytes.len() + 1),
        };
        bytes.splice(at..at, copy);
    }

    /// Copies a range of another seed of this kind over a place or between two.
    fn splice(&mut self, bytes: &mut Vec<u8>) {
        let other = self.random.pick(self.seeds);
        let parts = &self.random.pick(&other.files).1;
        let part = self.random.pick(parts).bytes.clone();
        let chunk = part[self.range(part.len())].to_vec();
        let at = self.random.below(bytes.len() + 1);
        let end = match self.random.one_in(2) {
            true => at,
            false => (at + chunk.len()).min(bytes.len()),
        };
        bytes.splice(at..end, chunk);
    }

    /// Puts a word of the format in place of another one in the file, or anywhere.
    fn word(&mut self, bytes: &mut Vec<u8>) {
        let new = self.random.pick(self.words).as_bytes().to_vec();
        let old = self.random.pick(self.words).as_bytes();
        let found = bytes.windows(old.len()).position(|window| window == old);
        match found {
            Some(at) => bytes.splice(at..at + old.len(), new),
            None => {
                let at = self.random.below(bytes.len() + 1);
                bytes.splice(at..at, new)
            }
        };
    }

    /// Removes, repeats or moves a line.
    fn line(&mut self, bytes: &mut Vec<u8>) {
        let mut lines: Vec<Vec<u8>> = bytes
            .split_inclusive(|b| *b == b'\n')
            .map(Vec::from)
            .collect();
        if lines.len() < 2 {
            return self.repeat(bytes);
        }
        let (from, to) = (
            self.random.below(lines.len()),
            self.random.below(lines.len()),
        );
        match self.random.below(3) {
            0 => _ = lines.remove(from),
            1 => lines.insert(to, lines[from].clone()),
            _ => lines.swap(from, to),
        }
        *bytes = lines.concat();
    }
}
