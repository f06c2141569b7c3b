//! Voxels: scalars and coverage, or colors.

use tetrascope_core::grid::{Lattice, Samples};
use tetrascope_core::{Error, Grid, TransferFunction};

use crate::options::VoxelSize;
use crate::voxelizer::{Counts, Voxelizer, emitted, in_range, zeros};

/// Scalars as they are stored, x fastest; what was not written is 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// 0…255 for the field's range.
    U8(Vec<u8>),
    /// 0…65535 for the field's range.
    U16(Vec<u16>),
    /// 0…2³² − 1 for the field's range.
    U32(Vec<u32>),
    /// In the field's unit.
    F32(Vec<f32>),
}

/// A voxelized mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelVolume {
    lattice: Lattice,
    range: (f64, f64),
    samples: u32,
    voxels: Voxels,
    writes: Vec<u32>,
    counts: Counts,
}

impl VoxelVolume {
    pub(crate) fn new(
        lattice: Lattice,
        range: (f64, f64),
        voxelizer: &Voxelizer,
        sums: &[u64],
        writes: Vec<u32>,
        counts: Counts,
    ) -> Result<VoxelVolume, Error> {
        let means = || {
            let pairs = sums.iter().zip(&writes);
            // Exact: sums are below 2⁵³, of 2²³ writes and more.
            pairs.map(|(sum, &writes)| (writes > 0).then(|| *sum as f64 / f64::from(writes)))
        };
        let unit = f64::from(1 << crate::face::VALUE_BITS);
        let scaled = |mean: Option<f64>, most: f64| (mean.unwrap_or(0.0) / unit * most).round();
        let voxels = match voxelizer.options().voxel_size {
            VoxelSize::Bits8 => {
                let mut voxels = zeros(sums.len())?;
                let set = |(voxel, mean): (&mut u8, _)| *voxel = scaled(mean, 255.0) as u8;
                voxels.iter_mut().zip(means()).for_each(set);
                Voxels::U8(voxels)
            }
            VoxelSize::Bits16 => {
                let mut voxels = zeros(sums.len())?;
                let set = |(voxel, mean): (&mut u16, _)| *voxel = scaled(mean, 65535.0) as u16;
                voxels.iter_mut().zip(means()).for_each(set);
                Voxels::U16(voxels)
            }
            VoxelSize::Bits32 => {
                let mut voxels = zeros(sums.len())?;
                let most = f64::from(u32::MAX);
                let set = |(voxel, mean): (&mut u32, _)| *voxel = scaled(mean, most) as u32;
                voxels.iter_mut().zip(means()).for_each(set);
                Voxels::U32(voxels)
            }
            VoxelSize::Float => {
                let mut voxels = zeros(sums.len())?;
                let set = |(voxel, mean): (&mut f32, Option<f64>)| {
                    *voxel = mean.map_or(0.0, |mean| in_range(range, mean) as f32);
                };
                voxels.iter_mut().zip(means()).for_each(set);
                Voxels::F32(voxels)
            }
        };
        Ok(VoxelVolume {
            lattice,
            range,
            samples: voxelizer.offsets().len() as u32,
            voxels,
            writes,
            counts,
        })
    }

    /// Where the centers of the voxels are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Voxels along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.lattice.dims
    }

    /// The scalars of the least and the greatest integer.
    pub fn scalar_range(&self) -> (f64, f64) {
        self.range
    }

    /// Samples per voxel.
    pub fn samples_per_voxel(&self) -> u32 {
        self.samples
    }

    /// The scalars as they are stored.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Voxel `index`'s scalar, in the field's unit; `None` if it has none.
    pub fn scalar(&self, index: usize) -> Option<f64> {
        let (low, high) = self.range;
        let of = |share: f64| low + (high - low) * share;
        (self.writes[index] > 0).then(|| match &self.voxels {
            Voxels::U8(v) => of(f64::from(v[index]) / 255.0),
            Voxels::U16(v) => of(f64::from(v[index]) / 65535.0),
            Voxels::U32(v) => of(f64::from(v[index]) / f64::from(u32::MAX)),
            Voxels::F32(v) => v[index].into(),
        })
    }

    /// How often each voxel was written, x fastest: in a mesh whose cells neither overlap nor
    /// leave gaps, once for each of its samples in the mesh.
    pub fn writes(&self) -> &[u32] {
        &self.writes
    }

    /// The share of voxel `index`'s samples that are in the mesh.
    pub fn coverage(&self, index: usize) -> f32 {
        (self.writes[index] as f32 / self.samples as f32).min(1.0)
    }

    /// How many voxels were written more often than they have samples, as cells overlap.
    pub fn overlaps(&self) -> usize {
        let writes = self.writes.iter();
        writes.filter(|writes| **writes > self.samples).count()
    }

    /// Counts of the work.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// The grid of these scalars, in the field's unit, with coverage. Along an axis of one voxel
    /// a grid cannot be interpolated; the lattice says whether it is to be.
    ///
    /// # Errors
    /// No memory.
    pub fn grid(&self) -> Result<Grid, Error> {
        let count = self.writes.len();
        let mut samples = zeros(count)?;
        let mut coverage = zeros(count)?;
        for index in 0..count {
            samples[index] = self.scalar(index).map_or(f32::NAN, |s| s as f32);
            coverage[index] = self.coverage(index);
        }
        Grid::on(self.lattice, Samples::F32(samples))?.covered(coverage)
    }

    /// The transfer function after the mean: emission and extinction of each voxel's scalar,
    /// times its coverage.
    ///
    /// # Errors
    /// No memory.
    pub fn classify(&self, transfer_function: &TransferFunction) -> Result<ColorVolume, Error> {
        let mut voxels = zeros(self.writes.len())?;
        for (index, voxel) in voxels.iter_mut().enumerate() {
            if let Some(scalar) = self.scalar(index) {
                let coverage = f64::from(self.coverage(index));
                *voxel = emitted(transfer_function, scalar).map(|v| (v * coverage) as f32);
            }
        }
        Ok(ColorVolume::new(self.lattice, voxels, self.counts))
    }
}

/// Emission and extinction of voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorVolume {
    lattice: Lattice,
    voxels: Vec<[f32; 4]>,
    counts: Counts,
}

impl ColorVolume {
    pub(crate) fn new(lattice: Lattice, voxels: Vec<[f32; 4]>, counts: Counts) -> ColorVolume {
        ColorVolume {
            lattice,
            voxels,
            counts,
        }
    }

    /// Where the centers of the voxels are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Color times extinction in linear RGB, and extinction, all per world unit; x fastest.
    pub fn voxels(&self) -> &[[f32; 4]] {
        &self.voxels
    }

    /// Counts of the work.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }
}
