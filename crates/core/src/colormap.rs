//! Color maps, as tables of 256 sRGB entries: perceptually uniform ones, a diverging one, and gray.

use glam::DVec3;

/// A named color map. The tables are those published by their authors:
/// viridis, inferno, magma and plasma by N. Smith and S. van der Walt (CC0),
/// cividis by J. Nuñez, C. Anderton and R. Renslow, 2018 (CC0). That of coolwarm follows from the ends and the formula
/// that K. Moreland gives in "Diverging Color Maps for Scientific Visualization", 2009, section 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colormap {
    /// Dark blue through green to yellow; the default.
    Viridis,
    /// Blue to yellow, the same to readers with and without color-vision deficiency.
    Cividis,
    /// Black through red to pale yellow.
    Inferno,
    /// Black through purple to pale pink.
    Magma,
    /// Blue through pink to yellow.
    Plasma,
    /// Blue through light gray to red, ParaView's default: for values on two sides of a middle.
    Coolwarm,
    /// Black to white.
    Gray,
}

impl Colormap {
    /// Every color map, in the order in which they are offered.
    pub const ALL: [Colormap; 7] = [
        Colormap::Viridis,
        Colormap::Cividis,
        Colormap::Inferno,
        Colormap::Magma,
        Colormap::Plasma,
        Colormap::Coolwarm,
        Colormap::Gray,
    ];

    /// The name that people write.
    pub fn name(self) -> &'static str {
        match self {
            Colormap::Viridis => "viridis",
            Colormap::Cividis => "cividis",
            Colormap::Inferno => "inferno",
            Colormap::Magma => "magma",
            Colormap::Plasma => "plasma",
            Colormap::Coolwarm => "coolwarm",
            Colormap::Gray => "gray",
        }
    }

    /// The color at `position` in [0, 1], linear RGB.
    ///
    /// Entries are interpolated in sRGB, in which the maps are uniform, and
    /// then converted. Positions outside [0, 1] are clamped.
    pub fn linear_rgb(self, position: f64) -> DVec3 {
        let x = position.clamp(0.0, 1.0) * 255.0;
        let i = (x as usize).min(254);
        let srgb = self.entry(i).lerp(self.entry(i + 1), x - i as f64);
        DVec3::from_array(srgb.to_array().map(srgb_to_linear))
    }

    /// Entry `index` of 256, sRGB in [0, 1].
    fn entry(self, index: usize) -> DVec3 {
        let table = match self {
            Colormap::Viridis => include_str!("colormap/viridis.hex"),
            Colormap::Cividis => include_str!("colormap/cividis.hex"),
            Colormap::Inferno => include_str!("colormap/inferno.hex"),
            Colormap::Magma => include_str!("colormap/magma.hex"),
            Colormap::Plasma => include_str!("colormap/plasma.hex"),
            Colormap::Coolwarm => include_str!("colormap/coolwarm.hex"),
            Colormap::Gray => return DVec3::splat(index as f64 / 255.0),
        };
        let byte = |k: usize| {
            let at = 6 * index + 2 * k;
            f64::from(u8::from_str_radix(&table[at..at + 2], 16).expect("the table is hexadecimal"))
        };
        DVec3::new(byte(0), byte(1), byte(2)) / 255.0
    }
}

/// The linear value of an sRGB component in [0, 1] (IEC 61966-2-1).
pub fn srgb_to_linear(srgb: f64) -> f64 {
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB value of a linear component in [0, 1] (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // First, middle and last entries as published, sRGB bytes.
    #[test]
    fn tables_have_the_published_entries() {
        let bytes = |map: Colormap, i| (map.entry(i) * 255.0).round().as_uvec3().to_array();
        assert_eq!(bytes(Colormap::Viridis, 0), [68, 1, 84]);
        assert_eq!(bytes(Colormap::Viridis, 128), [33, 145, 140]);
        assert_eq!(bytes(Colormap::Viridis, 255), [253, 231, 37]);
        assert_eq!(bytes(Colormap::Cividis, 0), [0, 34, 78]);
        assert_eq!(bytes(Colormap::Inferno, 255), [252, 255, 164]);
        assert_eq!(bytes(Colormap::Magma, 255), [252, 253, 191]);
        assert_eq!(bytes(Colormap::Plasma, 0), [13, 8, 135]);
        assert_eq!(bytes(Colormap::Coolwarm, 0), [59, 76, 192]);
        assert_eq!(bytes(Colormap::Coolwarm, 255), [180, 4, 38]);
        assert_eq!(bytes(Colormap::Gray, 128), [128; 3]);
    }

    #[test]
    fn srgb_and_linear_are_inverse() {
        for i in 0..=255 {
            let x = f64::from(i) / 255.0;
            assert!((linear_to_srgb(srgb_to_linear(x)) - x).abs() < 1e-7);
        }
    }
}
