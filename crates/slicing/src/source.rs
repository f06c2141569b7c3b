//! Where samples come from: a grid in memory, or a file that need not fit there.

use std::fmt::Debug;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Samples;
use tetrascope_core::{Bounds, Error, Grid};

/// Where the samples of a regular grid lie, without the samples.
///
/// Sample (i, j, k) is at `origin + direction * (spacing * (i, j, k))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Samples along each axis, 2 or more.
    pub dims: [usize; 3],
    /// Where sample (0, 0, 0) lies, world space.
    pub origin: DVec3,
    /// The distance of neighbors along each axis, world units.
    pub spacing: DVec3,
    /// The axes' directions, one a column.
    pub direction: DMat3,
}

impl Lattice {
    /// That of `grid`.
    pub fn of(grid: &Grid) -> Lattice {
        Lattice {
            dims: grid.dims(),
            origin: grid.origin(),
            spacing: grid.spacing(),
            direction: grid.direction(),
        }
    }

    /// Cells along each axis: one less than samples.
    pub fn cells(&self) -> [usize; 3] {
        self.dims.map(|d| d - 1)
    }

    /// From lattice to world space, the linear part.
    pub(crate) fn linear(&self) -> DMat3 {
        self.direction * DMat3::from_diagonal(self.spacing)
    }

    /// The box around all samples, world space.
    pub fn bounds(&self) -> Bounds {
        let cells = self.cells().map(|c| c as f64);
        Bounds::of((0..8).map(|corner: usize| {
            let pick = |axis: usize| (corner >> axis & 1) as f64 * cells[axis];
            self.origin + self.linear() * DVec3::new(pick(0), pick(1), pick(2))
        }))
    }
}

/// The type of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// Unsigned bytes.
    U8,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 16-bit integers.
    I16,
    /// 32-bit floats; NaN is transparent.
    F32,
}

impl SampleType {
    /// Bytes of one sample.
    pub fn bytes(self) -> usize {
        match self {
            SampleType::U8 => 1,
            SampleType::U16 | SampleType::I16 => 2,
            SampleType::F32 => 4,
        }
    }

    fn of(samples: &Samples) -> Option<SampleType> {
        match samples {
            Samples::U8(_) => Some(SampleType::U8),
            Samples::U16(_) => Some(SampleType::U16),
            Samples::I16(_) => Some(SampleType::I16),
            Samples::F32(_) => Some(SampleType::F32),
            _ => None,
        }
    }
}

/// A box of samples: `size` of them from `low` on, along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first sample.
    pub low: [usize; 3],
    /// How many along each axis.
    pub size: [usize; 3],
}

impl Region {
    /// How many samples.
    pub fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Where each row of samples along x begins, by increasing y, then z.
    fn rows(self, dims: [usize; 3]) -> impl Iterator<Item = usize> {
        let Region { low, size } = self;
        (0..size[2]).flat_map(move |z| {
            (0..size[1]).map(move |y| low[0] + dims[0] * (low[1] + y + dims[1] * (low[2] + z)))
        })
    }
}

/// A regular grid whose samples are read region by region.
pub trait BrickSource: Debug + Send + Sync {
    /// Where the samples lie; never changes.
    fn lattice(&self) -> Lattice;

    /// Their type; never changes.
    fn sample_type(&self) -> SampleType;

    /// The samples of `region`, which lies inside of the lattice, x fastest.
    fn read(&self, region: Region) -> Result<Samples, Error>;
}

/// A grid in memory.
#[derive(Clone, Debug)]
pub(crate) struct GridSource {
    grid: Grid,
    sample_type: SampleType,
}

impl GridSource {
    pub(crate) fn new(grid: &Grid) -> Result<GridSource, Error> {
        let sample_type = SampleType::of(grid.samples()).ok_or_else(|| Error::Unsupported {
            renderer: crate::NAME,
            what: "samples of this type".into(),
            reason: "it knows u8, u16, i16 and f32".into(),
        })?;
        Ok(GridSource {
            grid: grid.clone(),
            sample_type,
        })
    }
}

impl BrickSource for GridSource {
    fn lattice(&self) -> Lattice {
        Lattice::of(&self.grid)
    }

    fn sample_type(&self) -> SampleType {
        self.sample_type
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        fn rows<T: Copy>(all: &[T], dims: [usize; 3], region: Region) -> Vec<T> {
            let mut out = Vec::with_capacity(region.count());
            for start in region.rows(dims) {
                out.extend_from_slice(&all[start..start + region.size[0]]);
            }
            out
        }
        let dims = self.grid.dims();
        Ok(match self.grid.samples() {
            Samples::U8(v) => Samples::U8(rows(v, dims, region)),
            Samples::U16(v) => Samples::U16(rows(v, dims, region)),
            Samples::I16(v) => Samples::I16(rows(v, dims, region)),
            Samples::F32(v) => Samples::F32(rows(v, dims, region)),
            _ => return Err(Error::invalid("samples of an unknown type")),
        })
    }
}

/// The order of a number's bytes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// Least significant first.
    Little,
    /// Most significant first.
    Big,
}

/// A file of samples, x fastest, read where and when they are needed.
#[derive(Debug)]
pub struct RawFile {
    path: PathBuf,
    file: Mutex<File>,
    offset: u64,
    lattice: Lattice,
    sample_type: SampleType,
    byte_order: ByteOrder,
}

impl RawFile {
    /// The samples of `lattice` that begin at byte `offset` of the file at `path`.
    ///
    /// Refuses a file that ends before the last sample.
    pub fn open(
        path: &Path,
        offset: u64,
        lattice: Lattice,
        sample_type: SampleType,
        byte_order: ByteOrder,
    ) -> Result<RawFile, Error> {
        let io = |action| {
            move |source| Error::Io {
                action,
                path: path.to_path_buf(),
                source,
            }
        };
        // `Grid` has the checks of a lattice; its own wants all samples.
        let needed = lattice
            .dims
            .iter()
            .try_fold(sample_type.bytes() as u64, |n, d| n.checked_mul(*d as u64))
            .and_then(|n| n.checked_add(offset));
        let placed = lattice.origin.is_finite()
            && lattice.spacing.is_finite()
            && lattice.spacing.cmpgt(DVec3::ZERO).all()
            && lattice.direction.is_finite();
        let needed = needed.filter(|_| placed && lattice.dims.iter().all(|d| *d >= 2));
        let needed = needed.ok_or_else(|| {
            Error::invalid(format!("a lattice that holds no volume: {lattice:?}"))
        })?;
        let file = File::open(path).map_err(io("cannot open"))?;
        let length = file.metadata().map_err(io("cannot read"))?.len();
        if length < needed {
            return Err(Error::Format {
                path: path.to_path_buf(),
                at: format!("byte {length}"),
                what: format!(
                    "the file ends, but {:?} samples need {needed} bytes",
                    lattice.dims
                ),
                help: Some("check dimensions, sample type and offset".into()),
            });
        }
        Ok(RawFile {
            path: path.to_path_buf(),
            file: Mutex::new(file),
            offset,
            lattice,
            sample_type,
            byte_order,
        })
    }
}

impl BrickSource for RawFile {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn sample_type(&self) -> SampleType {
        self.sample_type
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        let io = |source| Error::Io {
            action: "cannot read",
            path: self.path.clone(),
            source,
        };
        let width = self.sample_type.bytes();
        let row = region.size[0] * width;
        let mut bytes = vec![0; region.count() * width];
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        for (start, out) in region
            .rows(self.lattice.dims)
            .zip(bytes.chunks_exact_mut(row))
        {
            let at = self.offset + (start * width) as u64;
            file.seek(SeekFrom::Start(at)).map_err(io)?;
            file.read_exact(out).map_err(io)?;
        }
        Ok(decode(&bytes, self.sample_type, self.byte_order))
    }
}

fn decode(bytes: &[u8], sample_type: SampleType, order: ByteOrder) -> Samples {
    let little = order == ByteOrder::Little;
    let pairs = || bytes.chunks_exact(2).map(|b| [b[0], b[1]]);
    match sample_type {
        SampleType::U8 => Samples::U8(bytes.to_vec()),
        SampleType::U16 if little => Samples::U16(pairs().map(u16::from_le_bytes).collect()),
        SampleType::U16 => Samples::U16(pairs().map(u16::from_be_bytes).collect()),
        SampleType::I16 if little => Samples::I16(pairs().map(i16::from_le_bytes).collect()),
        SampleType::I16 => Samples::I16(pairs().map(i16::from_be_bytes).collect()),
        SampleType::F32 => {
            let quads = bytes.chunks_exact(4).map(|b| [b[0], b[1], b[2], b[3]]);
            Samples::F32(if little {
                quads.map(f32::from_le_bytes).collect()
            } else {
                quads.map(f32::from_be_bytes).collect()
            })
        }
    }
}
