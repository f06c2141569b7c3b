//! What a raw file does not say about itself.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::grid::{Interpolation, Lattice};
use crate::scene::VolumeSource;

/// A type of numbers in a raw file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RawNumber {
    /// Signed bytes.
    I8,
    /// Unsigned bytes.
    U8,
    /// Signed 16-bit integers.
    I16,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 32-bit integers.
    I32,
    /// Unsigned 32-bit integers.
    U32,
    /// 32-bit floats.
    F32,
    /// 64-bit floats.
    F64,
}

impl RawNumber {
    /// Every type.
    pub const ALL: [RawNumber; 8] = [
        RawNumber::I8,
        RawNumber::U8,
        RawNumber::I16,
        RawNumber::U16,
        RawNumber::I32,
        RawNumber::U32,
        RawNumber::F32,
        RawNumber::F64,
    ];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            RawNumber::I8 => "i8",
            RawNumber::U8 => "u8",
            RawNumber::I16 => "i16",
            RawNumber::U16 => "u16",
            RawNumber::I32 => "i32",
            RawNumber::U32 => "u32",
            RawNumber::F32 => "f32",
            RawNumber::F64 => "f64",
        }
    }
}

/// The order of a number's bytes in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ByteOrder {
    /// Least significant first.
    #[default]
    Little,
    /// Most significant first.
    Big,
}

impl ByteOrder {
    /// Every order, with its name.
    pub const ALL: [(&'static str, ByteOrder); 2] =
        [("little", ByteOrder::Little), ("big", ByteOrder::Big)];
}

/// How the numbers of a raw file are to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawLayout {
    /// Where the samples lie, world space.
    pub lattice: Lattice,
    /// Their type.
    pub number: RawNumber,
    /// Bytes before the first.
    pub offset: u64,
    /// The order of a number's bytes.
    pub byte_order: ByteOrder,
}

impl VolumeSource {
    /// The layout of a raw file, if the source has one.
    ///
    /// # Errors
    /// Some of the keys without `dims` and `type`, and a lattice that holds no volume.
    pub fn raw_layout(&self) -> Result<Option<RawLayout>, Error> {
        let (dims, number) = match (self.dims, self.number) {
            (Some(dims), Some(number)) => (dims, number),
            (None, None) if !self.has_raw_keys() => return Ok(None),
            _ => {
                return Err(Error::Invalid {
                    what: "a raw file needs its dims and the type of its numbers".into(),
                    help: Some("give both, as in --dims 256x256x128 --type u8".into()),
                });
            }
        };
        let lattice = Lattice {
            dims,
            origin: self.origin.unwrap_or(DVec3::ZERO),
            spacing: self.spacing.unwrap_or(DVec3::ONE),
            direction: DMat3::IDENTITY,
            interpolation: self.interpolation.unwrap_or(Interpolation::Linear),
        };
        lattice.validate()?;
        Ok(Some(RawLayout {
            lattice,
            number,
            offset: self.offset.unwrap_or(0),
            byte_order: self.byte_order.unwrap_or_default(),
        }))
    }

    /// Whether any key is given that only raw files have.
    pub fn has_raw_keys(&self) -> bool {
        self.dims.is_some()
            || self.number.is_some()
            || self.spacing.is_some()
            || self.origin.is_some()
            || self.offset.is_some()
            || self.byte_order.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_is_whole_or_not_there() {
        let layout = |toml: &str| {
            toml::from_str::<VolumeSource>(toml)
                .expect("keys")
                .raw_layout()
        };
        assert_eq!(layout("file = \"a.vti\"").expect("none"), None);
        let found = layout("file = \"a.raw\"\ndims = [2, 3, 4]\ntype = \"u16\"");
        let found = found.expect("whole").expect("raw");
        assert_eq!(found.lattice.dims, [2, 3, 4]);
        assert_eq!(found.number, RawNumber::U16);
        assert_eq!((found.offset, found.byte_order), (0, ByteOrder::Little));
        assert!(layout("dims = [2, 3, 4]").is_err());
        assert!(layout("spacing = [1.0, 1.0, 2.0]").is_err());
        assert!(layout("dims = [2, 3, 1]\ntype = \"u8\"").is_err());
        assert!(layout("dims = [2, 3, 2]\ntype = \"u8\"\nspacing = [0.0, 1.0, 1.0]").is_err());
    }
}
