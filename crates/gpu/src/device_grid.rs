//! A regular grid whose samples are on the device: where what makes grids there and what draws
//! them meet.

use tetrascope_core::grid::{BrickSource as _, Lattice, Region};
use tetrascope_core::{Error, Grid, is_value};
use wgpu::{Extent3d, Origin3d, TextureFormat, TextureUsages};

use crate::Gpu;
use crate::memory::texture_bytes;

/// A texel of [`Texels::Gaps`] from here on is not a value. Shaders may assume that NaN never
/// occurs, so a number stands for it.
pub const NO_VALUE: f32 = f32::MAX;

/// The content of a [`DeviceGrid`]'s texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Texels {
    /// `R32Float`: scalars, all finite.
    Values,
    /// `R32Float`: finite scalars, or [`NO_VALUE`], whose cells are transparent.
    Gaps,
    /// `Rg32Float`: a finite scalar and its [coverage](tetrascope_core::grid::coverage) in
    /// [0, 1]; what is not covered has any finite scalar.
    Covered,
}

/// Samples of a regular grid in a texture.
///
/// Texel (i, j, k) is the sample (i, j, k) of the lattice, in the field's unit. Cheap to clone:
/// clones share the texture. Whoever writes it by a compute pass says what it holds. Nothing is
/// read back to check that: the pixels of a texel that breaks the promise are undefined, and no
/// others.
///
/// The ranges of boxes are not kept here: how a grid is divided, and how far each box reaches,
/// is a matter of the algorithm that draws it, which finds them on the device.
#[derive(Clone, Debug)]
pub struct DeviceGrid {
    lattice: Lattice,
    texels: Texels,
    texture: wgpu::Texture,
    scalar_range: Option<(f64, f64)>,
}

impl Texels {
    /// The format of the texture.
    pub fn format(self) -> TextureFormat {
        match self {
            Texels::Values | Texels::Gaps => TextureFormat::R32Float,
            Texels::Covered => TextureFormat::Rg32Float,
        }
    }
}

impl DeviceGrid {
    /// A grid of zeros, for a compute pass to fill: its texture is a storage texture of
    /// [`Texels::format`] for shaders that write, and one that others read and copy.
    ///
    /// No scalar that will be in it may lie outside of `scalar_range`; `None` if nothing will
    /// have a value.
    ///
    /// # Errors
    /// Refusals of [`Lattice::validate`]; a range that is not finite, or whose ends are swapped;
    /// [`Error::TooLarge`] for more samples along an axis than the device has texels, and
    /// [`Error::OutOfMemory`].
    pub fn new(
        gpu: &Gpu,
        lattice: &Lattice,
        texels: Texels,
        scalar_range: Option<(f64, f64)>,
    ) -> Result<DeviceGrid, Error> {
        lattice.validate()?;
        check_range(scalar_range)?;
        let usage = TextureUsages::STORAGE_BINDING
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_DST
            | TextureUsages::COPY_SRC;
        let texture = gpu.texture_3d(
            "the grid's samples",
            extent(lattice),
            texels.format(),
            usage,
        )?;
        Ok(DeviceGrid {
            lattice: *lattice,
            texels,
            texture,
            scalar_range,
        })
    }

    /// The grid of a texture that is there already.
    ///
    /// # Errors
    /// As [`DeviceGrid::new`]; and a texture of another size than the lattice, another format
    /// than the texels', or one that shaders cannot read.
    pub fn from_texture(
        texture: wgpu::Texture,
        lattice: &Lattice,
        texels: Texels,
        scalar_range: Option<(f64, f64)>,
    ) -> Result<DeviceGrid, Error> {
        lattice.validate()?;
        check_range(scalar_range)?;
        let (size, expected) = (texture.size(), extent(lattice));
        let wrong = if size != expected || texture.dimension() != wgpu::TextureDimension::D3 {
            let [x, y, z] = lattice.dims;
            let found = (size.width, size.height, size.depth_or_array_layers);
            Some(format!("a texture of {found:?} for a grid of {x}×{y}×{z}"))
        } else if texture.format() != texels.format() {
            let (found, expected) = (texture.format(), texels.format());
            Some(format!(
                "a texture of {found:?} where {texels:?} are {expected:?}"
            ))
        } else if !texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
            Some("a texture that shaders cannot read, without TEXTURE_BINDING".into())
        } else {
            None
        };
        if let Some(what) = wrong {
            return Err(Error::Invalid {
                what,
                help: Some("`DeviceGrid::new` makes one that fits".into()),
            });
        }
        Ok(DeviceGrid {
            lattice: *lattice,
            texels,
            texture,
            scalar_range,
        })
    }

    /// Uploads the samples of `grid`, some layers at a time, and its coverage.
    ///
    /// Samples of every type are whole numbers or floats that f32 has exactly.
    ///
    /// # Errors
    /// As [`DeviceGrid::new`]; [`Error::Invalid`] for a sample that is [`NO_VALUE`].
    pub fn upload(gpu: &Gpu, grid: &Grid) -> Result<DeviceGrid, Error> {
        DeviceGrid::upload_in_parts(gpu, grid, BYTES_PER_WRITE)
    }

    fn upload_in_parts(gpu: &Gpu, grid: &Grid, bytes: u64) -> Result<DeviceGrid, Error> {
        let samples = grid.samples();
        let texels = match grid.coverage() {
            Some(_) => Texels::Covered,
            None if samples.missing() > 0 => Texels::Gaps,
            None => Texels::Values,
        };
        let range = grid.scalar_range();
        if range.is_some_and(|(_, high)| high >= f64::from(NO_VALUE)) {
            return Err(Error::Invalid {
                what: format!("a sample of {NO_VALUE:e}, which marks no value on the device"),
                help: Some("store NaN where there is no value".into()),
            });
        }
        let made = DeviceGrid::new(gpu, grid.lattice(), texels, range)?;
        let [nx, ny, nz] = grid.dims();
        let layer = nx * ny;
        let layers = (bytes / made.bytes().div_ceil(nz as u64)).clamp(1, nz as u64);
        for z in (0..nz).step_by(layers as usize) {
            let region = Region {
                low: [0, 0, z],
                size: [nx, ny, (layers as usize).min(nz - z)],
            };
            let part = grid.read(region)?;
            let scalar = |i: usize| {
                let sample = part.get(i);
                if is_value(sample) {
                    sample as f32
                } else {
                    NO_VALUE
                }
            };
            let numbers: Vec<f32> = match grid.coverage() {
                None => (0..part.len()).map(scalar).collect(),
                Some(coverage) => (0..part.len())
                    .flat_map(|i| match coverage[z * layer + i] {
                        0.0 => [0.0; 2],
                        share => [scalar(i), share],
                    })
                    .collect(),
            };
            let origin = Origin3d {
                z: z as u32,
                ..Origin3d::ZERO
            };
            let size = Extent3d {
                depth_or_array_layers: region.size[2] as u32,
                ..made.texture.size()
            };
            gpu.write_texels(&made.texture, origin, size, bytemuck::cast_slice(&numbers))?;
            // The device is done with one part before the next is on its way.
            gpu.finish(gpu.device().create_command_encoder(&Default::default()))?;
        }
        Ok(made)
    }

    /// Where the samples lie.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The content of the texels.
    pub fn texels(&self) -> Texels {
        self.texels
    }

    /// The samples.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// The range of the scalars; `None` if nothing has a value.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        self.scalar_range
    }

    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        texture_bytes(&self.texture)
    }
}

/// About how many bytes are written at a time.
const BYTES_PER_WRITE: u64 = 1 << 24;

fn check_range(range: Option<(f64, f64)>) -> Result<(), Error> {
    match range {
        Some((low, high)) if !(low <= high && is_value(low) && is_value(high)) => {
            Err(Error::invalid(format!(
                "scalars from {low:e} to {high:e} are not a range of 32-bit floats"
            )))
        }
        _ => Ok(()),
    }
}

/// An extent that does not fit 32 bits is refused with the texture.
fn extent(lattice: &Lattice) -> Extent3d {
    let [width, height, depth] = lattice.dims.map(|d| u32::try_from(d).unwrap_or(u32::MAX));
    Extent3d {
        width,
        height,
        depth_or_array_layers: depth,
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::{DMat3, DVec3};
    use tetrascope_core::grid::Samples;

    use super::*;
    use crate::memory::Source;
    use crate::{read_back, testing};

    const DIMS: [usize; 3] = [5, 4, 3];

    fn grid(samples: Samples) -> Grid {
        let grid = Grid::new(DIMS, DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
        grid.expect("valid")
    }

    fn texels(gpu: &Gpu, grid: &DeviceGrid) -> Vec<f32> {
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let copy = read_back(gpu, &mut encoder, Source::Texture(grid.texture()));
        gpu.finish(encoder).expect("submitted");
        copy.and_then(|copy| copy.read()).expect("read")
    }

    #[test]
    fn samples_of_every_type_are_floats_on_the_device() {
        let Some(gpu) = testing::gpu("samples_of_every_type_are_floats_on_the_device") else {
            return;
        };
        let numbers = || (0..60).map(|i| i as f32);
        let mut gaps: Vec<f32> = numbers().collect();
        (gaps[7], gaps[8]) = (f32::NAN, f32::NEG_INFINITY);
        let cases = [
            (Samples::U8((0..60).collect()), Texels::Values),
            (Samples::U16((0..60).collect()), Texels::Values),
            (Samples::I16((0..60).collect()), Texels::Values),
            (Samples::F32(numbers().collect()), Texels::Values),
            (Samples::F32(gaps), Texels::Gaps),
        ];
        for (samples, kind) in cases {
            let made = DeviceGrid::upload(&gpu, &grid(samples)).expect("it fits");
            assert_eq!(made.texels(), kind);
            assert_eq!(made.scalar_range(), Some((0.0, 59.0)));
            let mut expected: Vec<f32> = numbers().collect();
            if kind == Texels::Gaps {
                (expected[7], expected[8]) = (NO_VALUE, NO_VALUE);
            }
            assert_eq!(texels(&gpu, &made), expected, "{kind:?}");
        }
    }

    #[test]
    fn what_is_not_covered_has_no_scalar() {
        let Some(gpu) = testing::gpu("what_is_not_covered_has_no_scalar") else {
            return;
        };
        let mut samples: Vec<f32> = (0..60).map(|i| i as f32).collect();
        samples[3] = f32::NAN;
        samples[50] = f32::MAX;
        let coverage: Vec<f32> = (0..60).map(|i| (i % 5) as f32 / 4.0).collect();
        let covered = grid(Samples::F32(samples))
            .covered(coverage)
            .expect("shares");
        let made = DeviceGrid::upload(&gpu, &covered).expect("it fits");
        assert_eq!(made.texels(), Texels::Covered);
        assert_eq!(made.scalar_range(), Some((1.0, 59.0)));
        assert_eq!(made.bytes(), 60 * 8);
        let expected = (0..60).flat_map(|i| match (i % 5, i) {
            (0, _) | (_, 3) => [0.0; 2],
            (share, _) => [i as f32, share as f32 / 4.0],
        });
        let expected: Vec<f32> = expected.collect();
        assert_eq!(texels(&gpu, &made), expected);
        // A layer has 160 bytes: one at a time, and two and one.
        for bytes in [1, 400] {
            let parts = DeviceGrid::upload_in_parts(&gpu, &covered, bytes).expect("it fits");
            assert_eq!(texels(&gpu, &parts), expected, "{bytes}");
        }
    }

    #[test]
    fn what_is_not_a_grid_is_refused() {
        let Some(gpu) = testing::gpu("what_is_not_a_grid_is_refused") else {
            return;
        };
        let ramp = grid(Samples::U8((0..60).collect()));
        let lattice = *ramp.lattice();
        let made = DeviceGrid::new(&gpu, &lattice, Texels::Covered, None).expect("it fits");
        let texture = made.texture();
        let long = Lattice {
            dims: [6, 4, 3],
            ..lattice
        };
        let of = |lattice, texels, range| {
            DeviceGrid::from_texture(texture.clone(), lattice, texels, range)
        };
        assert!(of(&lattice, Texels::Covered, Some((-1.0, 2.0))).is_ok());
        for (made, words) in [
            (of(&long, Texels::Covered, None), "grid of 6×4×3"),
            (of(&lattice, Texels::Gaps, None), "Rg32Float"),
            (of(&lattice, Texels::Covered, Some((2.0, 1.0))), "range"),
            (
                of(&lattice, Texels::Covered, Some((0.0, f64::NAN))),
                "range",
            ),
            (of(&lattice, Texels::Covered, Some((0.0, 1e39))), "range"),
        ] {
            let error = made.expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
        let endless = Lattice {
            dims: [1 << 20, 2, 2],
            ..lattice
        };
        let error = DeviceGrid::new(&gpu, &endless, Texels::Values, None).expect_err("too long");
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
        let mark = grid(Samples::F32(vec![f32::MAX; 60]));
        let error = DeviceGrid::upload(&gpu, &mark).expect_err("it would be transparent");
        assert!(error.to_string().contains("marks no value"), "{error}");
    }
}
