//! The rays of a view, normalized.

use tetrascope_core::View;
use tetrascope_core::glam::DVec3;

use crate::{ImagePlane, Normalization};

/// An eye that is nearer to the mesh's center is at it.
const NEAREST: f64 = 1e-9;

/// The rays of one view in normalized space: each starts at its anchor, a point of the plane
/// that faces the camera at the mesh's center. Near the mesh all numbers are small, however
/// far away the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// The anchor of pixel (0, 0).
    pub anchor: DVec3,
    /// From a pixel's anchor to that of its right neighbor.
    pub anchor_x: DVec3,
    /// From a pixel's anchor to that of the one below.
    pub anchor_y: DVec3,
    /// The eye if `is_point`, or else the common direction.
    pub eye: DVec3,
    /// Whether all rays go through the eye.
    pub is_point: bool,
    /// The camera's direction, a unit vector.
    pub forward: DVec3,
    /// The depth of the eye's plane, from that of the anchors; negative.
    pub eye_depth: f64,
}

impl Rays {
    /// The rays of `view`, which must be valid.
    pub fn new(view: &View, normalization: &Normalization) -> Rays {
        let plane = ImagePlane::new(view, normalization);
        let ImagePlane {
            right, up, forward, ..
        } = plane;
        // A camera inside or past the mesh looks at a plane half a mesh ahead, or nearer if it is that near to
        // the center: what is seen of a long and thin mesh from its side is small, and so have
        // to be the numbers.
        let from_center = plane.eye.length();
        let ahead = if from_center > NEAREST {
            from_center.min(0.5)
        } else {
            0.5
        };
        let depth = plane.anchor_depth.max(ahead);
        let (width, height) = (f64::from(view.width), f64::from(view.height));
        let pixel = 2.0 * plane.extent_at(depth)[1] / height;
        let center = plane.eye + depth * forward;
        let anchor_x = right * pixel;
        let anchor_y = -up * pixel;
        let is_point = plane.is_perspective;
        Rays {
            anchor: center - anchor_x * (width / 2.0 - 0.5) - anchor_y * (height / 2.0 - 0.5),
            anchor_x,
            anchor_y,
            eye: if is_point { plane.eye } else { forward },
            is_point,
            forward,
            eye_depth: -depth,
        }
    }

    /// How far behind the anchors' plane a point is.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.anchor).dot(self.forward)
    }
}
