//! Transfer functions as people edit them and as ParaView keeps them in its presets.
//!
//! A [`Preset`] has points of color, which a [`ColorSpace`] interpolates, and points of opacity over
//! one unit distance, with midpoint and sharpness. [`Preset::transfer_function`] makes of it the
//! piecewise linear function that renderers draw exactly.
//!
//! 1. `color_space` interpolates colors, `opacity` opacities, both as VTK does.
//! 2. `sample` turns both into knots, as few as show no difference, and knots into points again.
//! 3. `json` reads and writes ParaView's files.

mod color_space;
mod json;
mod opacity;
mod sample;

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::{Colormap, linear_to_srgb};
use tetrascope_core::{Error, number};

use crate::appearance::COLORMAP_KNOTS;
pub use color_space::ColorSpace;
pub use json::ReadPreset;

/// The most points of each kind: ParaView's own presets have up to some 1000.
pub const MAX_PRESET_POINTS: usize = 4096;

/// Colors and opacities of scalars.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Its name.
    pub name: String,
    /// How colors are interpolated.
    pub color_space: ColorSpace,
    /// By increasing scalar, at least one; constant beyond the ends. Two at one scalar make a step.
    pub colors: Vec<ColorPoint>,
    /// By increasing scalar, at least one; constant beyond the ends. Two at one scalar make a step.
    pub opacities: Vec<OpacityPoint>,
}

/// The color of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorPoint {
    /// In the field's own units.
    pub scalar: f64,
    /// sRGB, each in [0, 1].
    pub color: [f64; 3],
}

/// The opacity of a scalar, and the way to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpacityPoint {
    /// In the field's own units.
    pub scalar: f64,
    /// Over one unit distance, in [0, 1].
    pub opacity: f64,
    /// Where between this point and the next the middle of their opacities is, in [0, 1].
    #[serde(default = "half")]
    pub midpoint: f64,
    /// How suddenly it changes there: 0 is linear, 1 a step.
    #[serde(default)]
    pub sharpness: f64,
}

fn half() -> f64 {
    0.5
}

impl OpacityPoint {
    /// A point from which opacity goes to the next one linearly.
    pub fn new(scalar: f64, opacity: f64) -> OpacityPoint {
        OpacityPoint {
            scalar,
            opacity,
            midpoint: 0.5,
            sharpness: 0.0,
        }
    }
}

impl Preset {
    /// Refuses what is not a function of the scalar: no points or too many, some in the wrong
    /// order, numbers out of their range.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn validate(&self) -> Result<(), Error> {
        let scalars = |kind: &str, scalars: &mut dyn Iterator<Item = f64>| {
            let (mut count, mut last) = (0, f64::NEG_INFINITY);
            for scalar in scalars {
                if !scalar.is_finite() || scalar < last {
                    return Err(wrong(
                        format!("{kind} {count} is at {}", number::exact(scalar)),
                        "give finite scalars that do not decrease",
                    ));
                }
                (count, last) = (count + 1, scalar);
            }
            match count {
                0 => Err(wrong(format!("there is no {kind}"), "give at least one")),
                MAX_PRESET_POINTS.. => Err(wrong(
                    format!("there are {count} points, each a {kind}"),
                    "give fewer than 4096",
                )),
                _ => Ok(()),
            }
        };
        scalars("color point", &mut self.colors.iter().map(|p| p.scalar))?;
        scalars(
            "opacity point",
            &mut self.opacities.iter().map(|p| p.scalar),
        )?;
        let part = |value: f64| (0.0..=1.0).contains(&value);
        for (i, point) in self.colors.iter().enumerate() {
            if !point.color.iter().all(|c| part(*c)) {
                let what = format!("color point {i} has the color {:?}", point.color);
                return Err(wrong(what, "give red, green and blue from 0 to 1"));
            }
        }
        for (i, point) in self.opacities.iter().enumerate() {
            if !part(point.opacity) || !part(point.midpoint) || !part(point.sharpness) {
                let OpacityPoint {
                    opacity,
                    midpoint,
                    sharpness,
                    ..
                } = point;
                let what = format!(
                    "opacity point {i} has opacity {opacity}, midpoint {midpoint}, \
                     sharpness {sharpness}"
                );
                return Err(wrong(what, "give numbers from 0 to 1"));
            }
        }
        Ok(())
    }

    /// The colors of a named map over a range: as many points as color maps of scenes have knots.
    /// Entries between them follow within a level or so, to which the maps' tables are rounded.
    pub fn colors_of(map: Colormap, (low, high): (f64, f64)) -> Vec<ColorPoint> {
        const ENTRIES: u32 = COLORMAP_KNOTS as u32;
        let point = |i: u32| {
            let place = f64::from(i) / f64::from(ENTRIES - 1);
            let color = map.linear_rgb(place).to_array().map(linear_to_srgb);
            ColorPoint {
                scalar: low * (1.0 - place) + high * place,
                color: color.map(|c| c.clamp(0.0, 1.0)),
            }
        };
        (0..ENTRIES).map(point).collect()
    }

    /// The same over another range: its least and greatest scalar become `low` and `high`.
    pub fn scaled_to(&self, (low, high): (f64, f64)) -> Preset {
        let (from, to) = self.range();
        let move_to = |scalar: f64| match from < to {
            true => {
                let place = (scalar * 0.5 - from * 0.5) / (to * 0.5 - from * 0.5);
                low * (1.0 - place) + high * place
            }
            false => low,
        };
        let mut preset = self.clone();
        preset
            .colors
            .iter_mut()
            .for_each(|p| p.scalar = move_to(p.scalar));
        preset
            .opacities
            .iter_mut()
            .for_each(|p| p.scalar = move_to(p.scalar));
        preset
    }

    /// The least and greatest scalar of its points.
    pub fn range(&self) -> (f64, f64) {
        let colors = self.colors.iter().map(|p| p.scalar);
        let scalars = colors.chain(self.opacities.iter().map(|p| p.scalar));
        scalars.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    }
}

fn wrong(what: String, help: &str) -> Error {
    Error::Invalid {
        what,
        help: Some(help.into()),
    }
}
