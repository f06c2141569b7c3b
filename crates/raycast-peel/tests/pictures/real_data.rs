//! Real meshes from several places, where they are at hand.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Camera, CameraFit, Frame, TetMesh, View, Volume, VolumeRenderer as _};
use tetrascope_raycast_peel::{Crossings, Passes, RaycastOptions};
use tetrascope_testing::{
    self as testing, ImageError, angular_sector, blunt_fin, exactly, liquid_oxygen_post, ramp,
    super_phoenix, truth,
};

use crate::common::renderer;

/// Pixels a side.
const SIDE: u32 = 48;

/// As in `ping_pong.rs`.
const OUTLIER: f64 = 3e-4;

/// How a mesh was drawn from one place.
#[derive(Debug)]
struct Errors {
    /// Of one dispatch, against the truth.
    single: ImageError,
    /// Of a step a pass, against one dispatch: RMSE over the pixels that differ by less
    /// than `OUTLIER`, and how many differ by more.
    ping_pong: (f64, usize),
    /// Rays that a step a pass gave up.
    lost: u64,
}

fn channels(frame: &Frame) -> impl Iterator<Item = f64> {
    frame.pixels.iter().flatten().map(|c| f64::from(*c))
}

/// Draws `mesh` in both forms from several places.
fn check(test: &str, mesh: TetMesh) {
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let volume = Volume::Mesh(mesh);
    let appearance = ramp(&volume);
    let new = |passes, crossings| {
        let options = RaycastOptions {
            passes,
            crossings,
            ..RaycastOptions::default()
        };
        renderer(&gpu, &volume, &appearance, &options)
    };
    let single = new(Passes::Single, Crossings::Planes);
    let ping_pong = new(Passes::PingPong, Crossings::Planes);
    let by_sides = new(Passes::PingPong, Crossings::Sides);
    let reference = truth(&volume, &appearance);
    let bounds = volume.bounds();
    let inside = Camera {
        position: bounds.center() + bounds.size() * DVec3::new(0.13, 0.21, 0.17),
        focal_point: bounds.center(),
        ..Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0)
    };
    for (from, camera) in [
        ("far", Camera::fit(&bounds, CameraFit::PlusIso, false, 1.0)),
        (
            "parallel",
            Camera::fit(&bounds, CameraFit::MinusIso, true, 1.0),
        ),
        (
            "along an axis",
            Camera::fit(&bounds, CameraFit::PlusZ, true, 1.0),
        ),
        ("inside", inside),
    ] {
        let view = View {
            camera,
            width: SIDE,
            height: SIDE,
            background: [0.0; 4],
        };
        let exact = reference.render_exact(&view).expect("a frame");
        let frame = single.render(&view).expect("a frame");
        assert_eq!(frame.stats.lost_rays, Some(0), "{test}, {from}");
        assert_eq!(frame.stats.unpaired_faces, Some(0), "{test}, {from}");
        let stepped = ping_pong.render(&view).expect("a frame");
        let count = f64::from(4 * SIDE * SIDE);
        let apart: Vec<f64> = channels(&frame)
            .zip(channels(&stepped))
            .map(|(a, b)| (a - b).abs())
            .collect();
        let close = apart.iter().filter(|e| **e <= OUTLIER);
        let errors = Errors {
            single: ImageError::against(&exact.pixels, &frame),
            ping_pong: (
                (close.map(|e| e * e).sum::<f64>() / count).sqrt(),
                apart
                    .chunks(4)
                    .filter(|p| p.iter().any(|e| *e > OUTLIER))
                    .count(),
            ),
            lost: stepped.stats.lost_rays.expect("counted"),
        };
        let stepped = by_sides.render(&view).expect("a frame");
        assert_eq!(stepped.stats.lost_rays, Some(0), "{test}, {from}");
        let apart = ImageError::against(&exactly(&frame), &stepped);
        println!("{test}, {from}: {errors:?}, by sides {apart:?}");
        // As of the small scenes in `ping_pong.rs`.
        assert!(apart.max <= 1e-5, "{test}, {from}: {apart:?}");
        // The bar: no pixel beyond 1e-3.
        let ImageError { rmse, max, .. } = errors.single;
        assert!(rmse <= 1e-5 && max <= 1e-3, "{test}, {from}: {errors:?}");
        // As of the small scenes in `ping_pong.rs`, where outliers are explained.
        let (apart, outliers) = errors.ping_pong;
        assert!(apart <= 1e-5 && outliers <= 4, "{test}, {from}: {errors:?}");
        assert_eq!(errors.lost, 0, "{test}, {from}");
    }
}

fn check_if_at_hand(test: &str, make: fn(&str) -> Option<TetMesh>) {
    if let Some(mesh) = make(test) {
        check(test, mesh);
    }
}

#[test]
fn the_blunt_fin() {
    check_if_at_hand("the Blunt Fin", blunt_fin);
}

#[test]
fn the_super_phoenix() {
    check_if_at_hand("SPX", super_phoenix);
}

#[test]
fn the_liquid_oxygen_post() {
    check_if_at_hand("the post", liquid_oxygen_post);
}

#[test]
fn the_angular_sector() {
    check_if_at_hand("the angular sector", angular_sector);
}
