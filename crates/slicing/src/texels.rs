//! How samples lie in textures, and how they become scalars.

use tetrascope_core::grid::SampleType;
use tetrascope_core::grid::coverage::fades;
use tetrascope_core::{Appearance, OpticalModel};
use tetrascope_f32::ScalarMap;
use tetrascope_gpu::wgpu::{Features, TextureFormat};
use tetrascope_gpu::{Gpu, device_grid};
use tetrascope_shaders::slicing::{
    SLICE_COVERED, SLICE_DEVICE, SLICE_FILTERED, SLICE_FLOAT, SLICE_SIGNED, SLICE_UNSIGNED,
};

use crate::options::Filtering;

/// Stored for what is not finite: beyond `GAP` in `slab.wgsl`, also a small share of it.
pub(crate) const GAP: f32 = 1e38;

/// Scalars are clamped here, where any transfer function is constant, and far below `GAP`.
pub(crate) const MOST: f32 = 1e20;

/// How samples of one type lie in a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Texels {
    pub(crate) format: TextureFormat,
    /// The program that reads them.
    pub(crate) program: &'static str,
    /// Whether they are read as a scalar with a coverage behind it, of which there is only some or
    /// none; `None` if the program does not ask.
    pub(crate) covered: Option<bool>,
    /// Whether the texture unit filters them.
    pub(crate) filtered: bool,
    /// The factor that makes a sample of a texel's number.
    unit: f32,
    /// Bytes of one texel.
    pub(crate) bytes: u64,
}

impl Texels {
    /// Those for `sample_type`; filtered by the texture unit if it is asked for and can.
    ///
    /// Bytes are filtered as 16 bits: where texels have 8, so has what is read between
    /// them on some devices (llvmpipe: 8-bit formats that are not signed), which makes steps
    /// of a slope. As 16-bit integers they become 257 times as large, which is exact, as
    /// 257 · 255 = 65 535; half floats hold them as they are, and are filtered everywhere.
    pub(crate) fn of(gpu: &Gpu, sample_type: SampleType, filtering: Filtering) -> Texels {
        let texels = Texels::new;
        let has = |feature| gpu.features().contains(feature);
        let short = Features::TEXTURE_FORMAT_16BIT_NORM;
        let filter = SLICE_FILTERED;
        if filtering == Filtering::Hardware {
            match sample_type {
                SampleType::U8 if has(short) => {
                    return texels(TextureFormat::R16Unorm, filter, true, 255.0);
                }
                SampleType::U8 => return texels(TextureFormat::R16Float, filter, true, 1.0),
                SampleType::U16 if has(short) => {
                    return texels(TextureFormat::R16Unorm, filter, true, 65535.0);
                }
                SampleType::I16 if has(short) => {
                    return texels(TextureFormat::R16Snorm, filter, true, 32767.0);
                }
                SampleType::F32 if has(Features::FLOAT32_FILTERABLE) => {
                    return texels(TextureFormat::R32Float, filter, true, 1.0);
                }
                _ => {}
            }
        }
        match sample_type {
            SampleType::U8 => texels(TextureFormat::R8Uint, SLICE_UNSIGNED, false, 1.0),
            SampleType::U16 => texels(TextureFormat::R16Uint, SLICE_UNSIGNED, false, 1.0),
            SampleType::I16 => texels(TextureFormat::R16Sint, SLICE_SIGNED, false, 1.0),
            SampleType::F32 => texels(TextureFormat::R32Float, SLICE_FLOAT, false, 1.0),
        }
    }

    /// Those of a grid that is on the device, for `model`.
    pub(crate) fn on_device(texels: device_grid::Texels, model: OpticalModel) -> Texels {
        let is_covered = texels == device_grid::Texels::Covered;
        let (program, covered) = match is_covered && fades(model) {
            false => (SLICE_DEVICE, Some(is_covered)),
            true => (SLICE_COVERED, None),
        };
        Texels {
            covered,
            ..Texels::new(texels.format(), program, false, 1.0)
        }
    }

    fn new(format: TextureFormat, program: &'static str, filtered: bool, unit: f32) -> Texels {
        Texels {
            format,
            program,
            covered: None,
            filtered,
            unit,
            bytes: format.block_copy_size(None).map_or(4, u64::from),
        }
    }
}

/// From what a texture holds to the unit of the transfer function on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// As in `CameraUniform` of `frame.wgsl`.
    pub(crate) unit: f32,
    pub(crate) base: f32,
    /// The same for scalars that a texture holds in the field's unit.
    pub(crate) raw_unit: f32,
    pub(crate) raw_base: f32,
}

/// Scalars that a texture holds in the unit of the transfer function.
const MAPPED: Scale = Scale {
    unit: 1.0,
    base: 0.0,
    raw_unit: 1.0,
    raw_base: 0.0,
};

impl Scale {
    /// Where differences from `raw_base` are clamped: far beyond any knot, and the product is finite.
    pub(crate) fn raw_most(&self) -> f32 {
        (MOST / self.raw_unit).min(f32::MAX)
    }

    /// How samples of a volume with the finite `range` become scalars.
    ///
    /// Floats are stored in the transfer function's unit. Integers are stored as they are
    /// and keep their unit, and a whole number near the transfer function's lower end is
    /// taken off them: that is exact, so that a sample on a step of the transfer function, or
    /// on an isosurface, stays on it.
    pub(crate) fn of(
        texels: Texels,
        sample_type: SampleType,
        appearance: &Appearance,
        range: Option<(f64, f64)>,
    ) -> (Scale, ScalarMap) {
        let map = ScalarMap::of_appearance(appearance, range);
        if sample_type == SampleType::F32 {
            return (MAPPED, map);
        }
        let base = map.low().round().clamp(-65536.0, 65536.0);
        let scale = Scale {
            unit: texels.unit,
            base: base as f32,
            ..MAPPED
        };
        (scale, ScalarMap::from_low(base))
    }

    /// How scalars of a grid on the device become those of the transfer function: the shader
    /// maps each, so that another appearance leaves the texture as it is.
    pub(crate) fn on_device(
        appearance: &Appearance,
        range: Option<(f64, f64)>,
    ) -> (Scale, ScalarMap) {
        let map = ScalarMap::of_appearance(appearance, range).in_f32();
        let scale = Scale {
            raw_base: map.low() as f32,
            raw_unit: map.unit() as f32,
            ..MAPPED
        };
        (scale, map)
    }
}

/// The bits of a half float that is a whole number below 256.
pub(crate) fn half_of(number: u8) -> u16 {
    if number == 0 {
        return 0;
    }
    // 1.… · 2^exponent, of which 10 bits behind the point are kept; 15 is the bias.
    let exponent = u16::from(number).ilog2() as u16;
    let fraction = (u16::from(number) << (10 - exponent)) & 0x3ff;
    (15 + exponent) << 10 | fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_half_floats() {
        for number in 0..=255_u8 {
            let bits = half_of(number);
            let (exponent, fraction) = (i32::from(bits >> 10), f32::from(bits & 0x3ff));
            let value = match exponent {
                0 => fraction * 2f32.powi(-24),
                _ => (1.0 + fraction / 1024.0) * 2f32.powi(exponent - 15),
            };
            assert_eq!(value, f32::from(number));
        }
    }
}
