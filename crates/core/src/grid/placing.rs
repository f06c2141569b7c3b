//! Lattices for samples that are yet to be taken: over a box, or on a plane through it.

use crate::Unit as _;
use glam::{DMat3, DVec3};

use super::{Interpolation, Lattice};
use crate::{Bounds, Error, number};

/// How far inside of a box the outermost samples are, in shares of its size: they are to be in
/// what fills the box, not on its surface. VTK's `vtkResampleToImage` insets by as much.
const INSET: f64 = 5e-7;

impl Lattice {
    /// Samples along each axis of `bounds`, about as far apart along all, `longest` along the
    /// longest and never less than 2.
    pub fn dims_over(bounds: &Bounds, longest: usize) -> [usize; 3] {
        let size = bounds.size();
        let spacing = size.max_element() / longest.saturating_sub(1).max(1) as f64;
        size.to_array().map(|side| {
            let cells = (side / spacing).round();
            // A size of 0 by a spacing of 0 is NaN, and that is 0 cells.
            (cells as usize + 1).clamp(2, longest.max(2))
        })
    }

    /// A lattice whose outermost samples lie on the sides of `bounds`, or rather half a millionth
    /// of its size inside.
    ///
    /// # Errors
    /// A box without volume, and what [`Lattice::validate`] refuses.
    pub fn over(bounds: &Bounds, dims: [usize; 3]) -> Result<Lattice, Error> {
        let size = bounds.size();
        if !size.cmpgt(DVec3::ZERO).all() {
            return Err(Error::Invalid {
                what: format!(
                    "the region from {} to {} has no volume",
                    number::vector(bounds.min),
                    number::vector(bounds.max)
                ),
                help: Some("its first corner is less than its second along each axis".into()),
            });
        }
        if dims.iter().any(|&d| d < 2) {
            return Err(Error::invalid(format!(
                "a grid needs at least 2 samples along each axis, not {dims:?}"
            )));
        }
        let cells = DVec3::from_array(dims.map(|d| (d - 1) as f64));
        let lattice = Lattice {
            dims,
            origin: bounds.min + INSET * size,
            spacing: (1.0 - 2.0 * INSET) * size / cells,
            direction: DMat3::IDENTITY,
            interpolation: Interpolation::Linear,
        };
        lattice.validate()?;
        Ok(lattice)
    }

    /// One layer of square samples on the plane through `point` with `normal`, `longest` along the
    /// longer side of what the plane cuts out of `bounds`, each in the middle of its square.
    ///
    /// Seen from where the normal points to, the first axis goes to the right and the second up,
    /// which is +z as nearly as it can be, or +y where the normal is ±z.
    ///
    /// # Errors
    /// A normal without direction, a plane that passes the box, no samples, and what
    /// [`Lattice::validate`] refuses.
    pub fn on_plane(
        bounds: &Bounds,
        point: DVec3,
        normal: DVec3,
        longest: usize,
    ) -> Result<Lattice, Error> {
        let largest = normal.abs().max_element();
        let is_direction = normal.is_finite() && largest > 0.0 && point.is_finite();
        if !is_direction || longest == 0 {
            return Err(Error::Invalid {
                what: format!(
                    "a plane through {} with normal {} in {longest} samples",
                    number::vector(point),
                    number::vector(normal)
                ),
                help: Some("give a point, a normal that is not 0, and 1 sample or more".into()),
            });
        }
        let normal = (normal / largest).unit();
        let upright = if normal.z.abs() > 1.0 - 1e-9 {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let up = (upright - normal * normal.dot(upright)).unit();
        let right = up.cross(normal);
        let met = met(bounds, point, normal);
        let along = |axis: DVec3| {
            let places = met.iter().map(|p| (*p - point).dot(axis));
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            })
        };
        let (x, y) = (along(right), along(up));
        let (width, height) = (x.1 - x.0, y.1 - y.0);
        if !(width > 0.0 && height > 0.0) {
            return Err(Error::Invalid {
                what: format!(
                    "the plane through {} with normal {} does not cut the volume",
                    number::vector(point),
                    number::vector(normal)
                ),
                help: Some(format!(
                    "the volume reaches from {} to {}",
                    number::vector(bounds.min),
                    number::vector(bounds.max)
                )),
            });
        }
        let spacing = width.max(height) / longest as f64;
        let count = |side: f64| ((side / spacing).round() as usize).clamp(1, longest);
        let dims = [count(width), count(height), 1];
        // The samples' squares around the middle of what is cut out.
        let middle = point + 0.5 * ((x.0 + x.1) * right + (y.0 + y.1) * up);
        let half = DVec3::from_array(dims.map(|d| 0.5 * (d as f64 - 1.0) * spacing));
        let lattice = Lattice {
            dims,
            origin: middle - half.x * right - half.y * up,
            spacing: DVec3::splat(spacing),
            direction: DMat3::from_cols(right, up, normal),
            interpolation: Interpolation::Nearest,
        };
        lattice.validate()?;
        Ok(lattice)
    }
}

/// Where a plane meets the edges of a box.
fn met(bounds: &Bounds, point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let corner = |c: usize| {
        DVec3::select(
            glam::BVec3::new(c & 1 == 1, c >> 1 & 1 == 1, c >> 2 == 1),
            bounds.max,
            bounds.min,
        )
    };
    let mut met = Vec::new();
    for c in 0..8_usize {
        for axis in 0..3 {
            let other = c | 1 << axis;
            if other == c {
                continue;
            }
            let (from, to) = (corner(c), corner(other));
            let [a, b] = [from, to].map(|p| (p - point).dot(normal));
            if (a <= 0.0) != (b <= 0.0) {
                met.push(from + (to - from) * (a / (a - b)));
            } else if a == 0.0 && b == 0.0 {
                met.extend([from, to]);
            }
        }
    }
    met
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Bounds {
        Bounds {
            min: DVec3::new(-1.0, 2.0, 5.0),
            max: DVec3::new(3.0, 4.0, 6.0),
        }
    }

    #[test]
    fn samples_are_about_as_far_apart_along_all_axes() {
        assert_eq!(Lattice::dims_over(&unit(), 9), [9, 5, 3]);
        assert_eq!(Lattice::dims_over(&unit(), 2), [2, 2, 2]);
        assert_eq!(Lattice::dims_over(&unit(), 0), [2, 2, 2]);
        let flat = Bounds {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 0.0, 0.5),
        };
        assert_eq!(Lattice::dims_over(&flat, 101), [101, 2, 51]);
    }

    #[test]
    fn the_outermost_samples_are_just_inside() {
        let bounds = unit();
        let lattice = Lattice::over(&bounds, [9, 5, 3]).expect("a box");
        let of = lattice.bounds();
        let (low, high) = (of.min - bounds.min, bounds.max - of.max);
        // Half a millionth of the size, but for roundings of numbers up to 6.
        for off in [low / bounds.size(), high / bounds.size()] {
            assert!((off - INSET).abs().max_element() < 1e-14, "{off}");
        }
        for (bounds, dims) in [(bounds, [9, 1, 3]), (bounds, [0, 0, 0])] {
            Lattice::over(&bounds, dims).expect_err("too few samples");
        }
        let flat = Bounds {
            max: DVec3::new(3.0, 2.0, 6.0),
            ..bounds
        };
        let error = Lattice::over(&flat, [2; 3]).expect_err("no volume");
        assert!(error.to_string().contains("no volume"), "{error}");
    }

    // From +x, y goes to the right and z up: what is cut out of the box is 2 by 1.
    #[test]
    fn a_plane_across_an_axis_cuts_a_side_out() {
        let lattice = Lattice::on_plane(&unit(), DVec3::ZERO, DVec3::X, 10).expect("it cuts");
        assert_eq!(lattice.dims, [10, 5, 1]);
        assert_eq!(
            lattice.direction,
            DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X)
        );
        assert_eq!(lattice.spacing, DVec3::splat(0.2));
        let first = lattice.point(DVec3::ZERO);
        assert!(
            first.abs_diff_eq(DVec3::new(0.0, 2.1, 5.1), 1e-14),
            "{first}"
        );
        // From above, x goes to the right and y up.
        let above = Lattice::on_plane(&unit(), unit().center(), DVec3::Z, 4).expect("it cuts");
        assert_eq!(above.direction, DMat3::IDENTITY);
        assert_eq!(above.dims, [4, 2, 1]);
    }

    #[test]
    fn every_plane_through_the_box_is_covered() {
        let bounds = unit();
        for i in 0..200_u32 {
            let turn = |k: f64| (k * f64::from(i)).sin();
            let normal = DVec3::new(turn(1.3), turn(2.1), turn(0.7) + 0.01);
            let point =
                bounds.center() + 0.3 * bounds.size() * DVec3::new(turn(3.0), turn(5.0), 0.1);
            let lattice = Lattice::on_plane(&bounds, point, normal, 64).expect("it cuts");
            assert_eq!(lattice.dims[0].max(lattice.dims[1]), 64);
            for corner in met(&bounds, point, normal.unit()) {
                let at =
                    (lattice.direction.transpose() * (corner - lattice.origin)) / lattice.spacing.x;
                // Within the squares around the samples, but for what counts round down.
                let most = DVec3::new(lattice.dims[0] as f64, lattice.dims[1] as f64, 1.0);
                assert!(at.x > -1.0 && at.y > -1.0 && at.z.abs() < 1e-9, "{at}");
                assert!(at.x < most.x && at.y < most.y, "{at}");
            }
        }
    }

    #[test]
    fn what_cuts_nothing_is_refused() {
        let bounds = unit();
        let cut = |point, normal, count| Lattice::on_plane(&bounds, point, normal, count);
        let error = cut(DVec3::splat(-9.0), DVec3::X, 8).expect_err("it passes");
        assert!(error.to_string().contains("does not cut"), "{error}");
        assert!(error.help().is_some());
        let center = bounds.center();
        cut(center, DVec3::ZERO, 8).expect_err("no direction");
        cut(center, DVec3::NAN, 8).expect_err("no direction");
        cut(center, DVec3::X, 0).expect_err("no samples");
        cut(center, DVec3::splat(1e-300), 8).expect("any length");
    }
}
