//! Cameras and views.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Camera, CameraFit, Projection, View, Volume};

/// A square view over a background that is seen through.
pub fn view(camera: Camera, side: u32) -> View {
    View {
        camera,
        width: side,
        height: side,
        background: [0.1, 0.2, 0.3, 0.5],
    }
}

/// The whole volume from one side.
pub fn fitted(volume: &Volume, from: CameraFit, orthographic: bool, side: u32) -> View {
    view(Camera::fit(&volume.bounds(), from, orthographic, 1.0), side)
}

/// In the volume, at no vertex of it.
pub fn inside(volume: &Volume) -> Camera {
    looking_in(volume, DVec3::new(0.11, 0.13, 0.07))
}

/// A parallel view that cuts the volume in the same place.
pub fn cutting(volume: &Volume) -> Camera {
    Camera {
        projection: Projection::Orthographic {
            parallel_scale: volume.bounds().diagonal() / 3.0,
        },
        ..inside(volume)
    }
}

/// In perspective and in parallel from outside, and from inside.
pub fn outside_and_inside(volume: &Volume, side: u32) -> [View; 3] {
    [
        fitted(volume, CameraFit::PlusIso, false, side),
        fitted(volume, CameraFit::MinusIso, true, side),
        view(looking_in(volume, DVec3::splat(0.1)), side),
    ]
}

/// A camera that looks at the volume's middle from there; `off` is a part of the volume's size.
fn looking_in(volume: &Volume, off: DVec3) -> Camera {
    let bounds = volume.bounds();
    Camera {
        position: bounds.center() + off * bounds.size(),
        focal_point: bounds.center(),
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle: 70.0 },
    }
}
