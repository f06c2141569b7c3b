//! The camera of a view in normalized space, in f64: programs round what they need of it.

use tetrascope_core::glam::{DAffine3, DMat3, DVec3};
use tetrascope_core::{Projection, View};

use crate::Normalization;

/// The plane that faces the camera at the volume's center, on which the rays of a view have
/// their anchors; where the center is behind the eye, the plane through the eye.
///
/// Near the volume all numbers are small, however far away the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImagePlane {
    /// Where rays begin, or for parallel rays a point of the plane in which they do.
    pub eye: DVec3,
    /// A unit vector.
    pub right: DVec3,
    /// A unit vector.
    pub up: DVec3,
    /// The optical axis, a unit vector.
    pub forward: DVec3,
    /// Whether all rays go through the eye; otherwise they are parallel.
    pub is_perspective: bool,
    /// The middle of the image, on the plane.
    pub anchor: DVec3,
    /// From the eye to the anchor.
    pub anchor_depth: f64,
    /// Half the width and half the height of the image on the plane.
    pub extent: [f64; 2],
    /// How much they grow with depth: the tangents of half the opening angles, or 0 for
    /// parallel rays.
    pub slope: [f64; 2],
    /// Half the image where clip space has w = 1: `slope`, or `extent` for parallel rays.
    pub reach: [f64; 2],
}

impl ImagePlane {
    /// The plane of `view`, which must be valid.
    pub fn new(view: &View, normalization: &Normalization) -> ImagePlane {
        let camera = &view.camera;
        let (right, up, forward) = camera.axes();
        let eye = normalization.point(camera.position);
        // The volume's center is the origin.
        let anchor_depth = (-eye.dot(forward)).max(0.0);
        let (reach, is_perspective) = match camera.projection {
            Projection::Perspective { view_angle } => ((view_angle.to_radians() / 2.0).tan(), true),
            Projection::Orthographic { parallel_scale } => {
                (parallel_scale / normalization.scale, false)
            }
        };
        let aspect = f64::from(view.width) / f64::from(view.height);
        let reach = [reach * aspect, reach];
        let mut plane = ImagePlane {
            eye,
            right,
            up,
            forward,
            is_perspective,
            anchor: eye + anchor_depth * forward,
            anchor_depth,
            extent: reach,
            slope: if is_perspective { reach } else { [0.0; 2] },
            reach,
        };
        plane.extent = plane.extent_at(anchor_depth);
        plane
    }

    /// Half the width and half the height of the image this far before the eye.
    pub fn extent_at(&self, depth: f64) -> [f64; 2] {
        match self.is_perspective {
            true => self.reach.map(|reach| reach * depth),
            false => self.reach,
        }
    }

    /// To camera space: x is right, y up and z forward from the anchor, lengths stay.
    pub fn camera_from_normalized(&self) -> DAffine3 {
        let turn = DMat3::from_cols(self.right, self.up, self.forward).transpose();
        DAffine3::from_mat3_translation(turn, -(turn * self.anchor))
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec2;
    use tetrascope_core::{Bounds, Camera, CameraFit};

    use super::*;

    /// The ray of each pixel goes through the plane, and on, as `View::ray` says.
    #[test]
    fn rays_are_those_of_the_view() {
        let bounds = Bounds::of([DVec3::new(5.0, 1.0, 2.0), DVec3::new(9.0, 4.0, 3.0)]);
        let normalization = Normalization::of(&bounds);
        for orthographic in [false, true] {
            let mut camera = Camera::fit(&bounds, CameraFit::PlusIso, orthographic, 1.5);
            for inside in [false, true] {
                if inside {
                    camera.position = bounds.center() + 0.1 * (camera.position - bounds.center());
                }
                let view = View {
                    camera,
                    width: 9,
                    height: 6,
                    background: [0.0; 4],
                };
                let plane = ImagePlane::new(&view, &normalization);
                let to_camera = plane.camera_from_normalized();
                for (column, row) in [(0, 0), (8, 0), (3, 5)] {
                    let ray = view.ray(column, row);
                    let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    let x = pixel.x / 4.5 - 1.0;
                    let y = 1.0 - pixel.y / 3.0;
                    for t in [0.5, 3.0] {
                        let p = to_camera.transform_point3(normalization.point(ray.at(t)));
                        let [ex, ey] = plane.extent_at(p.z + plane.anchor_depth);
                        assert!((p.x - x * ex).abs() < 1e-12, "{p} {ex}");
                        assert!((p.y - y * ey).abs() < 1e-12, "{p} {ey}");
                        let [ex, ey] = [0, 1].map(|i| plane.extent[i] + p.z * plane.slope[i]);
                        assert!((p.x - x * ex).abs() < 1e-12, "{p} {ex}");
                        assert!((p.y - y * ey).abs() < 1e-12, "{p} {ey}");
                    }
                }
            }
        }
    }
}
