//! The volume of a scene, as written.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use tetrascope_core::Error;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{ByteOrder, Interpolation, Lattice, RawLayout, RawNumber};

/// Where a volume comes from: a file or a named data set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VolumeSource {
    /// A mesh file; relative paths start at the scene file.
    ///
    /// Text holds UTF-8 alone: a name of other bytes is written with replacements, so
    /// such a scene does not find its file again.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        serialize_with = "text"
    )]
    pub file: Option<PathBuf>,
    /// The Plot3D solution that belongs to a Plot3D grid; found by name if left out.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        serialize_with = "text"
    )]
    pub solution: Option<PathBuf>,
    /// A generated data set, in place of a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dataset: Option<String>,
    /// About how many cells to generate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<u64>,
    /// The seed of random data sets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Which field to draw, by a name that `info` lists; `cell:NAME` and `point:NAME` tell two of
    /// one name apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The time step of a file that holds several, by its number from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<usize>,
    /// The same, by its time in the file's own unit, in place of `step`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// How far curved cells may be off, cut into straight ones: in parts of the diagonal of the mesh's
    /// box and of the field's range; 1e-3 unless given, or what little memory allows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curved: Option<f64>,
    /// The scalar between a grid's samples; linear for samples at points, nearest for those
    /// of cells unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// Samples along each axis of a raw file, x fastest. The keys below are for raw
    /// files too; `spacing` and `origin` also for others that do not say them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dims: Option<[usize; 3]>,
    /// The type of a raw file's numbers.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub number: Option<RawNumber>,
    /// The distance of samples along each axis, world units; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<DVec3>,
    /// Where the first sample lies, world space; at 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<DVec3>,
    /// Bytes before the first number; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<u64>,
    /// The order of a number's bytes; little unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub byte_order: Option<ByteOrder>,
}

/// A path as text, whatever its bytes: TOML and JSON would fail.
fn text<S: serde::Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(path) => serializer.serialize_some(&path.to_string_lossy()),
        None => serializer.serialize_none(),
    }
}

impl VolumeSource {
    /// The layout of a raw file, if the source has one.
    ///
    /// # Errors
    /// `offset` or `byte_order` without `dims` and `type`, one of these alone, and a lattice that holds no volume.
    pub fn raw_layout(&self) -> Result<Option<RawLayout>, Error> {
        let (dims, number) = match (self.dims, self.number) {
            (Some(dims), Some(number)) => (dims, number),
            (None, None) if self.offset.is_none() && self.byte_order.is_none() => return Ok(None),
            _ => {
                return Err(Error::Invalid {
                    what: "a raw file needs its dims and the type of its numbers".into(),
                    help: Some("give `dims` and `type`".into()),
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

    /// Whether any key is given that says what is in a raw file, or where its samples lie.
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
        assert!(layout("byte_order = \"big\"").is_err());
        // For files of arrays, which the reader looks at.
        assert_eq!(layout("spacing = [1.0, 1.0, 2.0]").expect("none"), None);
        assert!(layout("dims = [2, 3, 1]\ntype = \"u8\"").is_err());
        assert!(layout("dims = [2, 3, 2]\ntype = \"u8\"\nspacing = [0.0, 1.0, 1.0]").is_err());
    }
}
