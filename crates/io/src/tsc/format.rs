//! The bytes of header, directory and clusters.

use tetrascope_core::Bounds;
use tetrascope_core::clusters::{Cluster, Part};
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;

/// The first bytes of a file. As those of PNG: they show transfers that change line ends.
pub(crate) const MAGIC: [u8; 8] = *b"\x89TSC\r\n\x1a\n";

pub(super) const VERSION: u32 = 1;

/// Bytes of the header.
pub(super) const HEADER: usize = 56;

/// Bytes of a cluster's entry in the directory.
pub(super) const ENTRY: usize = 88;

/// Flags of an entry.
const POSITIONS_ARE_FLOATS: u32 = 1;
const VALUES_ARE_FLOATS: u32 = 2;

/// The header's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) of_cells: bool,
    pub(super) cells: u64,
    pub(super) clusters: u64,
    pub(super) directory: u64,
    pub(super) directory_bytes: u64,
    pub(super) directory_checksum: u32,
}

/// A cluster's entry in the directory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) offset: u64,
    pub(super) flags: u32,
    pub(super) checksum: u32,
    pub(super) cluster: Cluster,
}

/// CRC-32 of `bytes`.
pub(super) fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

impl Header {
    pub(super) fn encode(&self) -> [u8; HEADER] {
        let mut bytes = Vec::with_capacity(HEADER);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(u32::from(self.of_cells).to_le_bytes());
        for number in [
            self.cells,
            self.clusters,
            self.directory,
            self.directory_bytes,
        ] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(self.directory_checksum.to_le_bytes());
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes.try_into().expect("so many were put there")
    }

    /// The header's numbers, or what is wrong with it and where.
    pub(super) fn decode(bytes: &[u8; HEADER]) -> Result<Header, (usize, String)> {
        let mut reader = Reader(bytes);
        if reader.take(8) != MAGIC {
            return Err((0, "the file does not begin as a .tsc file".into()));
        }
        // Before the checksum, which another version may have elsewhere.
        let version = reader.u32();
        if version != VERSION {
            return Err((
                8,
                format!("the file is of version {version} of the format, and {VERSION} is read"),
            ));
        }
        let association = reader.u32();
        let header = Header {
            of_cells: association == 1,
            cells: reader.u64(),
            clusters: reader.u64(),
            directory: reader.u64(),
            directory_bytes: reader.u64(),
            directory_checksum: reader.u32(),
        };
        if reader.u32() != checksum(&bytes[..HEADER - 4]) {
            return Err((0, DAMAGED_HEADER.into()));
        }
        if association > 1 {
            return Err((
                12,
                format!("values are at points (0) or in cells (1), not {association}"),
            ));
        }
        Ok(header)
    }
}

pub(super) const DAMAGED_HEADER: &str = "the header is damaged: its checksum is another";

impl Entry {
    pub(super) fn encode(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.offset.to_le_bytes());
        let Cluster {
            cells,
            points,
            bounds,
            scalar_range,
        } = self.cluster;
        for number in [cells, points, self.flags, self.checksum] {
            bytes.extend(number.to_le_bytes());
        }
        let (low, high) = scalar_range.unwrap_or((f64::NAN, f64::NAN));
        let [min, max] = [bounds.min, bounds.max].map(|p| p.to_array());
        for number in min.into_iter().chain(max).chain([low, high]) {
            bytes.extend(number.to_le_bytes());
        }
    }

    /// An entry, whatever its numbers are.
    pub(super) fn decode(bytes: &[u8]) -> Entry {
        let mut reader = Reader(bytes);
        let offset = reader.u64();
        let [cells, points, flags, checksum] = [(); 4].map(|()| reader.u32());
        let [min, max] = [(); 2].map(|()| DVec3::from([(); 3].map(|()| reader.f64())));
        let range = (reader.f64(), reader.f64());
        Entry {
            offset,
            flags,
            checksum,
            cluster: Cluster {
                cells,
                points,
                bounds: Bounds { min, max },
                scalar_range: (!range.0.is_nan()).then_some(range),
            },
        }
    }

    /// Bytes of the cluster, if its numbers make sense.
    pub(super) fn length(&self, of_cells: bool) -> Option<u64> {
        let [cells, points] = [self.cluster.cells, self.cluster.points].map(u64::from);
        let values = if of_cells { cells } else { points };
        let width = |flag| if self.flags & flag == 0 { 8 } else { 4 };
        let is_known = self.flags & !(POSITIONS_ARE_FLOATS | VALUES_ARE_FLOATS) == 0;
        // Cells use all points.
        let is_right = is_known && cells > 0 && points > 0 && points <= 4 * cells;
        let bytes = points * 3 * width(POSITIONS_ARE_FLOATS) + values * width(VALUES_ARE_FLOATS);
        is_right.then_some(bytes + 16 * cells)
    }

    /// Whether box and range are ones.
    pub(super) fn is_sound(&self) -> bool {
        let Bounds { min, max } = self.cluster.bounds;
        let has_box = min.is_finite() && max.is_finite() && min.cmple(max).all();
        let is_range = |(low, high): (f64, f64)| low.is_finite() && high.is_finite() && low <= high;
        has_box && self.cluster.scalar_range.is_none_or(is_range)
    }
}

/// The bytes of a cluster, and its flags.
pub(super) fn encode(part: &Part) -> (Vec<u8>, u32) {
    let is_float = |x: &f64| !x.is_finite() || f64::from(*x as f32) == *x;
    let coordinates = || part.points.iter().flat_map(|p| p.to_array());
    let positions_fit = coordinates().all(|x| is_float(&x));
    let values_fit = part.values.iter().all(is_float);
    let mut bytes = Vec::with_capacity(32 * part.points.len() + 24 * part.tetrahedra.len());
    let mut put = |numbers: &mut dyn Iterator<Item = f64>, fits: bool| match fits {
        true => numbers.for_each(|x| bytes.extend((x as f32).to_le_bytes())),
        false => numbers.for_each(|x| bytes.extend(x.to_le_bytes())),
    };
    put(&mut coordinates(), positions_fit);
    put(&mut part.values.iter().copied(), values_fit);
    for index in part.tetrahedra.iter().flatten() {
        bytes.extend(index.to_le_bytes());
    }
    let flag = |is_set: bool, flag| if is_set { flag } else { 0 };
    let flags = flag(positions_fit, POSITIONS_ARE_FLOATS) | flag(values_fit, VALUES_ARE_FLOATS);
    (bytes, flags)
}

/// The cluster with these bytes, as many as [`Entry::length`] says.
pub(super) fn decode(bytes: &[u8], entry: &Entry, of_cells: bool) -> Part {
    let mut reader = Reader(bytes);
    let Cluster { cells, points, .. } = entry.cluster;
    let mut numbers = |count: usize, flag: u32| -> Vec<f64> {
        match entry.flags & flag {
            0 => (0..count).map(|_| reader.f64()).collect(),
            _ => (0..count)
                .map(|_| f64::from(f32::from_bits(reader.u32())))
                .collect(),
        }
    };
    let coordinates = numbers(3 * points as usize, POSITIONS_ARE_FLOATS);
    let count = if of_cells { cells } else { points };
    let values = numbers(count as usize, VALUES_ARE_FLOATS);
    let (coordinates, _) = coordinates.as_chunks();
    let indices = (0..cells).map(|_| [(); 4].map(|()| reader.u32()));
    Part {
        tetrahedra: indices.collect(),
        points: coordinates.iter().map(|&p| DVec3::from(p)).collect(),
        association: association(of_cells),
        values,
    }
}

pub(super) fn association(of_cells: bool) -> Association {
    match of_cells {
        true => Association::Cell,
        false => Association::Point,
    }
}

/// Takes numbers off the front of bytes of which there are enough.
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl<'a> Reader<'a> {
    pub(super) fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        self.take(N).try_into().expect("so many were taken")
    }

    pub(super) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    pub(super) fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.array())
    }

    pub(super) fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.array())
    }
}
