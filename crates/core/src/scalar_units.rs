//! Units in which floats hold the scalars of a field with room to spare.
//!
//! Values that are near each other and far from 0 leave few bits for what lies between them, and widths
//! near the ends of the exponents have no inverse. Both are put right by a difference and a power of two
//! that are exact in f64: s′ = (s − base) 2ᵏ. Everything else stays as it is, to the last bit.

use crate::{Appearance, Isosurface, Knot, Scalars, TetMesh, TransferFunction};

/// The kind of floats that hold scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Floats {
    /// 24 bits.
    F32,
    /// 53 bits.
    F64,
}

impl Floats {
    /// A range that is a smaller part of its values than this is taken from its low end: so many of the
    /// bits are lost otherwise. Differences of such values are exact (Sterbenz 1974).
    fn narrow(self) -> f64 {
        match self {
            Floats::F32 => 1.0 / 64.0,
            Floats::F64 => 1.0 / (1u64 << 20) as f64,
        }
    }

    /// Widths beyond this, or below its inverse, come near the last exponents.
    fn extreme(self) -> f64 {
        match self {
            Floats::F32 => 1e30,
            Floats::F64 => 1e270,
        }
    }
}

/// Where a knot that lies farther away is put: nothing of a field is near it.
const FARTHEST: f64 = 1e300;

/// s′ = (s − base) factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarUnits {
    base: f64,
    /// A power of two.
    factor: f64,
}

impl ScalarUnits {
    /// The field's own.
    pub const OWN: ScalarUnits = ScalarUnits {
        base: 0.0,
        factor: 1.0,
    };

    /// Those in which `floats` hold the scalars of a range well: the field's own if they do so.
    pub fn of_range(range: Option<(f64, f64)>, floats: Floats) -> ScalarUnits {
        let Some((low, high)) = range else {
            return ScalarUnits::OWN;
        };
        let (width, greatest) = (high - low, low.abs().max(high.abs()));
        let is_narrow = width > 0.0 && width < floats.narrow() * greatest;
        let extent = if is_narrow { width } else { greatest };
        let usual = 1.0 / floats.extreme()..=floats.extreme();
        if greatest == 0.0 || !is_narrow && usual.contains(&extent) {
            return ScalarUnits::OWN;
        }
        let exponent = extent.log2().floor().clamp(-1000.0, 1000.0);
        ScalarUnits {
            base: if is_narrow { low } else { 0.0 },
            factor: (-exponent).exp2(),
        }
    }

    /// A scalar of the field.
    pub fn from_field(&self, scalar: f64) -> f64 {
        match *self == ScalarUnits::OWN {
            true => scalar,
            false => (scalar - self.base) * self.factor,
        }
    }

    /// The field's scalar.
    pub fn to_field(&self, scalar: f64) -> f64 {
        match *self == ScalarUnits::OWN {
            true => scalar,
            false => self.base + scalar / self.factor,
        }
    }

    /// A range in these units.
    pub fn range(&self, (low, high): (f64, f64)) -> (f64, f64) {
        (self.from_field(low), self.from_field(high))
    }

    /// The mesh in these units.
    pub fn mesh(&self, mesh: &TetMesh) -> TetMesh {
        if *self == ScalarUnits::OWN {
            return mesh.clone();
        }
        let scalars = mesh.scalars();
        let values = scalars.values.iter().map(|s| self.from_field(*s));
        let scalars = Scalars {
            values: values.collect(),
            ..scalars.clone()
        };
        mesh.with_scalars(scalars).expect("as many as before")
    }

    /// The appearance in these units.
    pub fn appearance(&self, appearance: &Appearance) -> Appearance {
        if *self == ScalarUnits::OWN {
            return appearance.clone();
        }
        let place = |scalar: f64| self.from_field(scalar).clamp(-FARTHEST, FARTHEST);
        let knots = appearance
            .transfer_function
            .knots()
            .iter()
            .map(|knot| Knot {
                scalar: place(knot.scalar),
                ..*knot
            });
        let function = TransferFunction::new(knots.collect());
        let surfaces = appearance.isosurfaces.iter().map(|surface| Isosurface {
            value: place(surface.value),
            ..*surface
        });
        Appearance {
            transfer_function: function.expect("their order is kept"),
            isosurfaces: surfaces.collect(),
            ..appearance.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::is_value;
    use crate::mesh::Association;
    use glam::DVec3;

    fn cell(values: [f64; 4]) -> TetMesh {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let scalars = Scalars {
            name: "s".into(),
            association: Association::Point,
            values: values.into(),
        };
        TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars).expect("a mesh")
    }

    #[test]
    fn usual_fields_stay_as_they_are() {
        for values in [
            [0.0, 1.0, 0.5, 0.25],
            [7.0; 4],
            [0.0; 4],
            [1e38, -1e38, 0.0, 1e-300],
            [101_325.0, 101_326.0, 101_325.0, 101_325.5],
            [f64::NAN; 4],
        ] {
            assert_eq!(
                ScalarUnits::of_range(cell(values).scalar_range(), Floats::F64),
                ScalarUnits::OWN,
                "{values:?}"
            );
        }
    }

    #[test]
    fn others_come_near_1_and_back_to_the_last_bit() {
        for values in [
            [1.0, 1.0f64.next_up(), 1.0, 1.0],
            [101_325.0, 101_325.001, 101_325.000_5, 101_325.0],
            [-1e37, -1e37f64.next_down(), -1e37, -1e37],
            [1e-310, 3e-310, 0.0, 2e-310],
            [5e-324, 0.0, 0.0, 0.0],
        ] {
            let mesh = cell(values);
            let units = ScalarUnits::of_range(mesh.scalar_range(), Floats::F64);
            let (low, high) = units.mesh(&mesh).scalar_range().expect("values");
            let width = high - low;
            assert!(
                (1e-25..=2.0).contains(&width),
                "{values:?}: {low} to {high}"
            );
            for value in values {
                assert_eq!(units.to_field(units.from_field(value)), value);
            }
        }
    }

    #[test]
    fn values_that_are_none_stay_none() {
        let mesh = cell([1.0, 1.0f64.next_up(), f64::NAN, 1e39]);
        let values = &ScalarUnits::of_range(mesh.scalar_range(), Floats::F64)
            .mesh(&mesh)
            .scalars()
            .values
            .clone();
        let is_value = |s: &f64| is_value(*s);
        assert_eq!(
            values.iter().map(is_value).collect::<Vec<_>>(),
            [true, true, false, false]
        );
    }

    #[test]
    fn floats_of_32_bits_keep_what_they_hold_well() {
        let of = |low, high| ScalarUnits::of_range(Some((low, high)), Floats::F32);
        for (low, high) in [(0.0, 255.0), (280.0, 310.0), (-1e6, 1e6), (1e-6, 2e-6)] {
            assert_eq!(of(low, high), ScalarUnits::OWN, "{low} to {high}");
        }
        for (low, high) in [(101_325.0, 101_326.0), (1e-35, 2e-35), (-1e36, 1e36)] {
            let (low, high) = of(low, high).range((low, high));
            assert!((0.5..4.0).contains(&(high - low)), "{low} to {high}");
        }
    }
}
