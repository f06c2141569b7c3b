//! The layout of a raw file, which says nothing about itself.

use serde::{Deserialize, Serialize};

use super::Lattice;

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

    /// The name that people write.
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
