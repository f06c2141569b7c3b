//! The values of options, from text.

use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use tetrascope_core::colormap::{Colormap, srgb_to_linear};
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{ByteOrder, Interpolation, RawNumber};
use tetrascope_core::view::{check_background, check_size};
use tetrascope_core::{CameraFit, ClipPlane, DepthCue, Error, OpticalModel};

use crate::help;

/// A parser of the names of optical models.
pub fn models() -> impl clap::builder::TypedValueParser<Value = OpticalModel> {
    PossibleValuesParser::new(OpticalModel::ALL.map(OpticalModel::name)).map(|name| {
        let model = OpticalModel::ALL.into_iter().find(|m| m.name() == name);
        model.expect("one of the possible values")
    })
}

/// A parser of the names of color maps.
pub fn colormaps() -> impl clap::builder::TypedValueParser<Value = Colormap> {
    PossibleValuesParser::new(Colormap::ALL.map(Colormap::name)).map(|name| {
        let map = Colormap::ALL.into_iter().find(|m| m.name() == name);
        map.expect("one of the possible values")
    })
}

/// A parser of the names of interpolations.
pub fn interpolations() -> impl clap::builder::TypedValueParser<Value = Interpolation> {
    PossibleValuesParser::new(Interpolation::ALL.map(Interpolation::name)).map(|name| {
        let found = Interpolation::ALL.into_iter().find(|i| i.name() == name);
        found.expect("one of the possible values")
    })
}

/// A parser of the types of raw numbers.
pub fn raw_numbers() -> impl clap::builder::TypedValueParser<Value = RawNumber> {
    PossibleValuesParser::new(RawNumber::ALL.map(RawNumber::name)).map(|name| {
        let number = RawNumber::ALL.into_iter().find(|n| n.name() == name);
        number.expect("one of the possible values")
    })
}

/// A parser of the orders of bytes.
pub fn byte_orders() -> impl clap::builder::TypedValueParser<Value = ByteOrder> {
    PossibleValuesParser::new(ByteOrder::ALL.map(|(name, _)| name)).map(|name| {
        let order = ByteOrder::ALL.into_iter().find(|(n, _)| *n == name);
        order.expect("one of the possible values").1
    })
}

/// Three whole numbers, 2 or more: `256x256x128`.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn dims(text: &str) -> Result<[usize; 3], String> {
    let parts = text
        .split(['x', 'X', '×'])
        .map(|part| part.trim().parse().ok());
    let dims: Option<Vec<usize>> = parts.collect();
    let dims = dims.and_then(|dims| dims.try_into().ok());
    dims.filter(|dims: &[usize; 3]| dims.iter().all(|n| *n >= 2))
        .ok_or_else(|| "give three whole numbers, 2 or more, such as 256x256x128".into())
}

/// A whole number, 1 or more.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn count(text: &str) -> Result<u64, String> {
    let count = text.trim().parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| format!("give a whole number, from 1 to {}", u64::MAX))
}

/// Three numbers: `1,1,2.5`.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Option<[f64; 3]> = numbers(text).and_then(|n| n.try_into().ok());
    numbers
        .map(DVec3::from_array)
        .ok_or_else(|| "give three numbers, such as 1,1,2.5".into())
}

/// Three distances, each more than 0.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn spacing(text: &str) -> Result<DVec3, String> {
    let spacing = vector(text)?;
    match spacing.cmpgt(DVec3::ZERO).all() {
        true => Ok(spacing),
        false => Err("distances are more than 0".into()),
    }
}

/// A finite number.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    number.ok_or_else(|| "give a number, such as 0.5".into())
}

/// A length, more than 0.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn length(text: &str) -> Result<f64, String> {
    let length = finite(text).ok().filter(|x| *x > 0.0);
    length.ok_or_else(|| "give a length in world units, more than 0".into())
}

/// A number above 0.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn tolerance(text: &str) -> Result<f64, String> {
    let tolerance = finite(text).ok().filter(|x| *x > 0.0);
    tolerance.ok_or_else(|| "give a number above 0, such as 1e-3".into())
}

/// The strength of a depth cue.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn strength(text: &str) -> Result<f64, String> {
    let cue = DepthCue {
        strength: finite(text)?,
    };
    cue.validate().map_err(in_words)?;
    Ok(cue.strength)
}

/// An error and its help, on the line on which clap quotes the value.
fn in_words(error: Error) -> String {
    match help(&error) {
        Some(help) => format!("{error}; {help}"),
        None => error.to_string(),
    }
}

/// A width and a height in pixels, or one number for both.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once(['x', 'X', '×']).unwrap_or((text, text));
    let (Ok(width), Ok(height)) = (width.parse(), height.parse()) else {
        return Err("give whole numbers of pixels, such as 640x480".into());
    };
    check_size(width, height).map_err(in_words)?;
    Ok((width, height))
}

/// The side from which a camera looks.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn camera(text: &str) -> Result<CameraFit, String> {
    CameraFit::parse(text).map_err(|error| error.to_string())
}

/// Finite numbers with commas between them.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|part| finite(part).ok()).collect()
}

/// Two numbers, the lower first.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn range(text: &str) -> Result<[f64; 2], String> {
    let numbers = numbers(text).and_then(|n| <[f64; 2]>::try_from(n).ok());
    match numbers.ok_or("give two numbers, such as 0.5,2")? {
        [low, high] if low > high => Err(format!("the range is reversed; give {high},{low}")),
        range => Ok(range),
    }
}

/// A point of a plane and the plane's normal.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn clip_plane(text: &str) -> Result<ClipPlane, String> {
    let numbers = numbers(text).and_then(|n| <[f64; 6]>::try_from(n).ok());
    let [x, y, z, nx, ny, nz] =
        numbers.ok_or("give a point of the plane and its normal, such as 0,0,0,1,0,0")?;
    let plane = ClipPlane {
        point: DVec3::new(x, y, z),
        normal: DVec3::new(nx, ny, nz),
    };
    plane.validate().map_err(in_words)?;
    Ok(plane)
}

/// A color: by name, `#RRGGBB` or as linear numbers.
///
/// # Errors
/// A sentence that says what to give instead.
pub fn background(text: &str) -> Result<[f32; 4], String> {
    let named = match text {
        "transparent" => Some([0.0; 4]),
        "black" => Some([0.0, 0.0, 0.0, 1.0]),
        "white" => Some([1.0; 4]),
        _ => None,
    };
    let linear = || match numbers(text)?[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => None,
    };
    let color = named.or_else(|| hexadecimal(text)).or_else(linear);
    let color = color
        .ok_or("give black, white, transparent, #RRGGBB, or linear numbers such as 0.1,0.1,0.1")?;
    let color = color.map(|x| x as f32);
    check_background(color).map_err(in_words)?;
    Ok(color)
}

/// `#RRGGBB` or `#RGB`, an opaque sRGB color, to linear RGBA.
fn hexadecimal(text: &str) -> Option<[f64; 4]> {
    let digits = text.strip_prefix('#')?;
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None; // also a sign, which numbers may have
    }
    let value = u32::from_str_radix(digits, 16).ok()?;
    let bytes = match digits.len() {
        6 => [value >> 16, value >> 8 & 255, value & 255],
        3 => [value >> 8, value >> 4 & 15, value & 15].map(|digit| digit * 17),
        _ => return None,
    };
    let [r, g, b] = bytes.map(|byte| srgb_to_linear(f64::from(byte) / 255.0));
    Some([r, g, b, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_parse_as_documented() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert_eq!(size("64"), Ok((64, 64)));
        for wrong in [
            "",
            "64x",
            "-1x2",
            "1e3",
            "4294967296x1",
            "0x9",
            "65536x4096",
        ] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(dims("2x30x4"), Ok([2, 30, 4]));
        assert!(dims("2x3").is_err() && dims("2x3x-4").is_err() && dims("a").is_err());
        assert_eq!(vector("1,-2,0.5"), Ok(DVec3::new(1.0, -2.0, 0.5)));
        assert!(vector("1,2").is_err());
        assert_eq!(range("-1,2.5"), Ok([-1.0, 2.5]));
        assert!(range("1").is_err() && range("1,2,3").is_err() && range("a,b").is_err());
        assert_eq!(background("#ffffff"), Ok([1.0; 4]));
        assert_eq!(background("0.5,0,0"), Ok([0.5, 0.0, 0.0, 1.0]));
        assert_eq!(background("1,1,1,0.25"), Ok([1.0, 1.0, 1.0, 0.25]));
        assert_eq!(background("#f80"), background("#ff8800"));
        for wrong in ["", "#ffff", "#+ff", "#gggggg", "red", "1,2"] {
            assert!(background(wrong).is_err(), "{wrong}");
        }
    }
}
