//! Clip planes: what is cut away, and what is left of a ray.

use crate::Unit as _;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Bounds, Error, Ray};

/// The most clip planes of an appearance.
pub const MAX_CLIP_PLANES: usize = 16;

/// A plane; what lies on the side of its normal stays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipPlane {
    /// A point of the plane, world space.
    pub point: DVec3,
    /// The plane's normal, of any length, world space.
    pub normal: DVec3,
}

impl ClipPlane {
    /// The six planes that leave what is inside of `bounds`.
    pub fn of_box(bounds: &Bounds) -> [ClipPlane; 6] {
        let keep = |point, normal| ClipPlane { point, normal };
        [
            keep(bounds.min, DVec3::X),
            keep(bounds.min, DVec3::Y),
            keep(bounds.min, DVec3::Z),
            keep(bounds.max, DVec3::NEG_X),
            keep(bounds.max, DVec3::NEG_Y),
            keep(bounds.max, DVec3::NEG_Z),
        ]
    }

    /// Refuses a plane without a place or a direction.
    pub fn validate(&self) -> Result<(), Error> {
        let length = self.normal.length();
        if self.point.is_finite() && length.is_finite() && length > 0.0 {
            return Ok(());
        }
        Err(Error::Invalid {
            what: format!(
                "a clip plane through {} with normal {}",
                self.point, self.normal
            ),
            help: Some("give finite numbers, and a normal that is not zero".into()),
        })
    }

    /// The distance of `p` from the plane, positive on the side that stays, world units.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.normal.unit().dot(p - self.point)
    }
}

/// The stretch of a ray, [near, far] in world units from its origin, that no plane cuts away.
///
/// The part that planes leave is convex, so on a ray it is one stretch: [0, ∞) without planes,
/// and near > far where nothing is left. A ray in a plane, or beside it, is whole
/// or cut away by which side its origin is on; the plane itself stays.
pub fn clip_ray(planes: &[ClipPlane], ray: &Ray) -> [f64; 2] {
    let [mut near, mut far] = [0.0f64, f64::INFINITY];
    for plane in planes {
        let normal = plane.normal.unit();
        let height = normal.dot(ray.origin - plane.point);
        let rise = normal.dot(ray.direction);
        if rise > 0.0 {
            near = near.max(-height / rise);
        } else if rise < 0.0 {
            far = far.min(height / -rise);
        } else if height < 0.0 {
            far = f64::NEG_INFINITY;
        }
    }
    [near, far]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(point: DVec3, normal: DVec3) -> ClipPlane {
        ClipPlane { point, normal }
    }

    fn along_z(origin: DVec3) -> Ray {
        Ray {
            origin,
            direction: DVec3::Z,
        }
    }

    #[test]
    fn a_box_leaves_a_ray_its_inside() {
        let bounds = Bounds {
            min: DVec3::new(-1.0, -1.0, 2.0),
            max: DVec3::new(1.0, 1.0, 5.0),
        };
        let planes = ClipPlane::of_box(&bounds);
        assert_eq!(clip_ray(&planes, &along_z(DVec3::ZERO)), [2.0, 5.0]);
        let inside = along_z(DVec3::new(0.0, 0.0, 3.0));
        assert_eq!(clip_ray(&planes, &inside), [0.0, 2.0]);
        let [near, far] = clip_ray(&planes, &along_z(DVec3::new(2.0, 0.0, 0.0)));
        assert!(near > far);
    }

    #[test]
    fn a_normal_has_any_length_and_a_ray_in_the_plane_stays() {
        let ray = along_z(DVec3::ZERO);
        for length in [1e-6, 1.0, 1e6] {
            let tilted = plane(DVec3::Z, length * DVec3::new(0.0, 0.6, 0.8));
            let [near, far] = clip_ray(&[tilted], &ray);
            assert!((near - 1.0).abs() < 1e-15 && far == f64::INFINITY);
        }
        let beside = plane(DVec3::ZERO, DVec3::X);
        assert_eq!(clip_ray(&[beside], &ray), [0.0, f64::INFINITY]);
        assert_eq!(clip_ray(&[], &ray), [0.0, f64::INFINITY]);
    }

    #[test]
    fn planes_that_are_none_are_refused() {
        for (point, normal) in [
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::NAN, DVec3::X),
            (DVec3::ZERO, DVec3::INFINITY),
        ] {
            assert!(plane(point, normal).validate().is_err());
        }
        assert!(plane(DVec3::ZERO, DVec3::X).validate().is_ok());
    }
}
