//! Spaces in which colors are interpolated, as VTK does between two points.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::{linear_to_srgb, srgb_to_linear};

/// How colors between two points are found; the words are ParaView's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColorSpace {
    /// Linear in sRGB's components.
    #[default]
    #[serde(rename = "RGB")]
    Rgb,
    /// Linear in hue, saturation and value; hue does not pass through red, as ParaView has it.
    #[serde(rename = "HSV")]
    Hsv,
    /// Linear in CIELAB (D65).
    Lab,
    /// By way of white between two saturated hues: K. Moreland, "Diverging Color Maps for
    /// Scientific Visualization", 2009.
    Diverging,
    /// The color of the upper point.
    Step,
}

impl ColorSpace {
    /// Every one that is honored.
    pub const ALL: [ColorSpace; 5] = [
        ColorSpace::Rgb,
        ColorSpace::Hsv,
        ColorSpace::Lab,
        ColorSpace::Diverging,
        ColorSpace::Step,
    ];

    /// ParaView's name.
    pub fn name(self) -> &'static str {
        match self {
            ColorSpace::Rgb => "RGB",
            ColorSpace::Hsv => "HSV",
            ColorSpace::Lab => "Lab",
            ColorSpace::Diverging => "Diverging",
            ColorSpace::Step => "Step",
        }
    }

    /// The color at `s` in (0, 1) between two, all in sRGB.
    pub(super) fn between(self, from: [f64; 3], to: [f64; 3], s: f64) -> [f64; 3] {
        let color = match self {
            ColorSpace::Rgb => mix(from, to, s),
            ColorSpace::Hsv => hsv_to_rgb(mix(rgb_to_hsv(from), rgb_to_hsv(to), s)),
            ColorSpace::Lab => lab_to_rgb(mix(rgb_to_lab(from), rgb_to_lab(to), s)),
            ColorSpace::Diverging => diverging(from, to, s),
            ColorSpace::Step => to,
        };
        color.map(|c| c.clamp(0.0, 1.0))
    }
}

fn mix(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] * (1.0 - s) + b[i] * s)
}

fn rgb_to_hsv([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = high - low;
    if chroma <= 0.0 {
        return [0.0, 0.0, high];
    }
    let sixth = if high == r {
        (g - b) / chroma
    } else if high == g {
        2.0 + (b - r) / chroma
    } else {
        4.0 + (r - g) / chroma
    };
    [(sixth / 6.0).rem_euclid(1.0), chroma / high, high]
}

fn hsv_to_rgb([h, s, v]: [f64; 3]) -> [f64; 3] {
    // A component rises and falls over hue, one third of a turn after another.
    [5.0, 3.0, 1.0].map(|shift: f64| {
        let k = (shift + 6.0 * h).rem_euclid(6.0);
        v - v * s * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

/// The white of D65, as VTK has it.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];

/// sRGB's primaries (IEC 61966-2-1): columns are red, green and blue.
const XYZ_OF_RGB: [[f64; 3]; 3] = [
    [0.4124, 0.3576, 0.1805],
    [0.2126, 0.7152, 0.0722],
    [0.0193, 0.1192, 0.9505],
];

const RGB_OF_XYZ: [[f64; 3]; 3] = [
    [3.2406, -1.5372, -0.4986],
    [-0.9689, 1.8758, 0.0415],
    [0.0557, -0.2040, 1.0570],
];

fn times(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// CIE 15: the cube root, and a line near black.
fn rgb_to_lab(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(XYZ_OF_RGB, rgb.map(srgb_to_linear));
    let root = |i: usize| match xyz[i] / WHITE[i] {
        t if t > 0.008856 => t.cbrt(),
        t => 7.787 * t + 16.0 / 116.0,
    };
    let [x, y, z] = [0, 1, 2].map(root);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn lab_to_rgb([l, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let roots = [a / 500.0 + y, y, y - b / 200.0];
    let xyz = std::array::from_fn(|i| {
        let t = roots[i];
        let cube = t * t * t;
        WHITE[i]
            * match cube > 0.008856 {
                true => cube,
                false => (t - 16.0 / 116.0) / 7.787,
            }
    });
    let linear = times(RGB_OF_XYZ, xyz).map(|c| c.max(0.0));
    // VTK scales what is too bright, which keeps its hue.
    let most = linear.iter().copied().fold(1.0, f64::max);
    linear.map(|c| linear_to_srgb(c / most))
}

/// Below this, a color in polar form has no hue to speak of.
const UNSATURATED: f64 = 0.05;

/// Magnitude, saturation and hue: CIELAB in polar form.
fn lab_to_msh([l, a, b]: [f64; 3]) -> [f64; 3] {
    let m = (l * l + a * a + b * b).sqrt();
    let s = if m > 0.001 { (l / m).acos() } else { 0.0 };
    let h = if s > 0.001 { b.atan2(a) } else { 0.0 };
    [m, s, h]
}

fn msh_to_lab([m, s, h]: [f64; 3]) -> [f64; 3] {
    [m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()]
}

/// Moreland 2009, section 5.
fn diverging(from: [f64; 3], to: [f64; 3], s: f64) -> [f64; 3] {
    let [mut from, mut to] = [from, to].map(|rgb| lab_to_msh(rgb_to_lab(rgb)));
    let mut s = s;
    let turn = (from[2] - to[2]).abs().rem_euclid(TAU);
    let apart = turn.min(TAU - turn);
    if from[1] > UNSATURATED && to[1] > UNSATURATED && apart > 0.33 * PI {
        let white = [from[0].max(to[0]).max(88.0), 0.0, 0.0];
        if s < 0.5 {
            to = white;
            s *= 2.0;
        } else {
            from = white;
            s = 2.0 * s - 1.0;
        }
    }
    if from[1] < UNSATURATED && to[1] > UNSATURATED {
        from[2] = spun(to, from[0]);
    } else if to[1] < UNSATURATED && from[1] > UNSATURATED {
        to[2] = spun(from, to[0]);
    }
    lab_to_rgb(msh_to_lab(mix(from, to, s)))
}

/// The hue for an unsaturated color of this magnitude beside a saturated one, so that steps
/// between them look even.
fn spun([m, s, h]: [f64; 3], unsaturated: f64) -> f64 {
    if m >= unsaturated - 0.1 {
        return h;
    }
    let spin = s * (unsaturated * unsaturated - m * m).sqrt() / (m * s.sin());
    match h > -0.3 * PI {
        true => h + spin,
        false => h - spin,
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::colormap::Colormap;

    use super::*;

    fn bytes(color: [f64; 3]) -> [i32; 3] {
        color.map(|c| (255.0 * c).round() as i32)
    }

    const RED: [f64; 3] = [1.0, 0.0, 0.0];
    const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn ends_are_the_points_in_every_space() {
        for space in ColorSpace::ALL {
            for (from, to) in [
                (RED, BLUE),
                ([0.231, 0.298, 0.753], [0.706, 0.016, 0.149]),
                ([0.0; 3], [1.0; 3]),
                ([0.2, 0.7, 0.4], [0.2, 0.7, 0.4]),
            ] {
                // Matrices of four digits are inverse to each other within 1e-3 of a level.
                let [start, end] = [0.0, 1.0].map(|s| space.between(from, to, s));
                let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 4e-3);
                assert!(
                    space == ColorSpace::Step || near(start, from),
                    "{space:?} {start:?}"
                );
                assert!(near(end, to), "{space:?} {end:?}");
            }
        }
    }

    #[test]
    fn hue_takes_the_way_that_paraview_takes() {
        // "Blue to Red Rainbow" is two points; green is in its middle.
        assert_eq!(bytes(ColorSpace::Hsv.between(BLUE, RED, 0.5)), [0, 255, 0]);
        assert_eq!(
            bytes(ColorSpace::Hsv.between(BLUE, RED, 0.25)),
            [0, 255, 255]
        );
        assert_eq!(bytes(ColorSpace::Step.between(RED, BLUE, 0.1)), [0, 0, 255]);
        assert_eq!(
            bytes(ColorSpace::Rgb.between(RED, BLUE, 0.5)),
            [128, 0, 128]
        );
    }

    // Moreland gives cool and warm as (59, 76, 192) and (180, 4, 38), and their middle as
    // (221, 221, 221), in the table beside the paper; hue and lightness are published to a level.
    #[test]
    fn cool_to_warm_has_its_published_middle() {
        let [cool, warm] = [[59.0, 76.0, 192.0], [180.0, 4.0, 38.0]].map(|c| c.map(|c| c / 255.0));
        let middle = bytes(ColorSpace::Diverging.between(cool, warm, 0.5));
        assert!(middle.iter().all(|c| (c - 221).abs() <= 1), "{middle:?}");
        let quarter = bytes(ColorSpace::Diverging.between(cool, warm, 0.25));
        // The published table has (141, 176, 254).
        let published = [141, 176, 254];
        assert!(
            (0..3).all(|i| (quarter[i] - published[i]).abs() <= 2),
            "{quarter:?}"
        );
    }

    // The two were made apart from each other.
    #[test]
    fn the_color_map_coolwarm_is_cool_to_warm() {
        let [cool, warm] = [[59.0, 76.0, 192.0], [180.0, 4.0, 38.0]].map(|c| c.map(|c| c / 255.0));
        for i in 0..=255 {
            let place = f64::from(i) / 255.0;
            let space = bytes(ColorSpace::Diverging.between(cool, warm, place));
            let table = bytes(
                Colormap::Coolwarm
                    .linear_rgb(place)
                    .to_array()
                    .map(linear_to_srgb),
            );
            let is_near = (0..3).all(|c| (space[c] - table[c]).abs() <= 1);
            assert!(is_near, "{i}: {space:?} {table:?}");
        }
    }

    // Lindbloom's numbers for sRGB's red under D65: (53.24, 80.09, 67.20).
    #[test]
    fn red_has_its_known_place_in_lab() {
        let lab = rgb_to_lab(RED);
        for (found, known) in lab.into_iter().zip([53.24, 80.09, 67.20]) {
            assert!((found - known).abs() < 0.05, "{lab:?}");
        }
        let gray = rgb_to_lab([0.5; 3]);
        assert!(gray[1].abs() < 0.02 && gray[2].abs() < 0.02, "{gray:?}");
    }
}
