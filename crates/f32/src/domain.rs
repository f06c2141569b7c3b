//! The box and the range that a volume's numbers are relative to.

use tetrascope_core::{Bounds, Error, ScalarUnits, TetMesh};

/// The box and range to which positions, scalars of isosurfaces and the depth cue are relative.
///
/// By default a volume's own. With one domain for all of them, the parts of a mesh, or the
/// steps of a time series, round each vertex and each scalar alike: their numbers in f32 are
/// those of the whole to the last bit, and a depth cue goes over all of them. (A map of scalars
/// that a restyle keeps, as digits are left, is the same in renderers that were restyled alike.)
/// Two things are not relative to it: a table of integrals ends at each mesh's own longest edge, and
/// slices begin at each grid's own corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// World space.
    pub bounds: Bounds,
    /// The least and the greatest scalar, `None` where there is no value.
    pub scalar_range: Option<(f64, f64)>,
}

impl Domain {
    /// The domain of a mesh alone.
    pub fn of(mesh: &TetMesh) -> Domain {
        Domain {
            bounds: mesh.bounds(),
            scalar_range: mesh.scalar_range(),
        }
    }

    /// The same for scalars that were rounded to 32-bit floats, perhaps beyond the ends.
    pub fn of_floats(self) -> Domain {
        Domain {
            scalar_range: self.scalar_range.map(range_of_floats),
            ..self
        }
    }

    /// The same of a field in other units.
    pub fn in_units(self, units: &ScalarUnits) -> Domain {
        Domain {
            scalar_range: self.scalar_range.map(|range| units.range(range)),
            ..self
        }
    }

    /// The domain `given` for a volume that has this one, or this one if there is none.
    ///
    /// # Errors
    /// [`Error::Invalid`] if this domain is not inside the one that is given.
    pub fn within(self, given: Option<Domain>) -> Result<Domain, Error> {
        let Some(given) = given else {
            return Ok(self);
        };
        let (own, all) = (&self.bounds, &given.bounds);
        let is_finite = all.min.is_finite() && all.max.is_finite();
        let has_box = own.min.cmpge(all.min).all() && own.max.cmple(all.max).all();
        let has_scalars = match (self.scalar_range, given.scalar_range) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some(own), Some(all)) => own.0 >= all.0 && own.1 <= all.1,
        };
        let outside = |what: &str, own: String, all: String| {
            Err(Error::Invalid {
                what: format!("a domain whose {what} {all} do not hold the volume's {own}"),
                help: Some("give one that holds every part and every time step".into()),
            })
        };
        if !(is_finite && (own.is_empty() || has_box)) {
            let text = |b: &Bounds| format!("{} to {}", b.min, b.max);
            return outside("bounds", text(own), text(all));
        }
        if !has_scalars {
            let text = |range: Option<(f64, f64)>| match range {
                Some((low, high)) => format!("{low} to {high}"),
                None => "of no value".into(),
            };
            let (own, all) = (text(self.scalar_range), text(given.scalar_range));
            return outside("scalars", own, all);
        }
        Ok(given)
    }
}

/// A range of 32-bit floats that holds `range`, however its scalars are rounded.
pub fn range_of_floats((low, high): (f64, f64)) -> (f64, f64) {
    let [low, high] = [low as f32, high as f32];
    (low.next_down().into(), high.next_up().into())
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;

    use super::*;

    fn domain(size: f64, scalar_range: Option<(f64, f64)>) -> Domain {
        Domain {
            bounds: Bounds::of([DVec3::ZERO, DVec3::splat(size)]),
            scalar_range,
        }
    }

    #[test]
    fn a_domain_holds_its_volume() {
        let own = domain(1.0, Some((2.0, 3.0)));
        assert_eq!(own.within(None).expect("its own"), own);
        let whole = domain(2.0, Some((1.0, 3.0)));
        assert_eq!(own.within(Some(whole)).expect("it holds it"), whole);
        let none = Domain {
            bounds: Bounds::EMPTY,
            scalar_range: None,
        };
        assert_eq!(none.within(Some(whole)).expect("nothing to hold"), whole);
        for wrong in [
            domain(0.5, Some((1.0, 3.0))),
            domain(f64::NAN, Some((1.0, 3.0))),
            domain(f64::INFINITY, Some((1.0, 3.0))),
            domain(2.0, Some((2.5, 3.0))),
            domain(2.0, Some((1.0, f64::NAN))),
            domain(2.0, None),
        ] {
            let error = own.within(Some(wrong)).expect_err("it does not hold it");
            assert!(matches!(error, Error::Invalid { .. }), "{error}");
        }
    }
}
