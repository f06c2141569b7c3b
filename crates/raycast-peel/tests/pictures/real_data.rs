//! Real meshes from several places, where they are at hand.

use crate::ping_pong::{self, OUTLIER};
use tetrascope_core::glam::DVec3;
use tetrascope_core::{Camera, CameraFit, TetMesh, View, Volume, VolumeRenderer as _};
use tetrascope_raycast_peel::counters::{LOST_RAYS, UNPAIRED_FACES};
use tetrascope_raycast_peel::{Crossings, Passes, RaycastOptions};
use tetrascope_testing::{
    self as testing, ImageError, angular_sector, blunt_fin, exactly, liquid_oxygen_post, ramp,
    super_phoenix, truth,
};

use crate::common::renderer;

/// Pixels per side.
const SIDE: u32 = 48;

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
    let by_planes = new(Passes::PingPong, Crossings::Planes);
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
        assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{test}, {from}");
        assert_eq!(frame.stats.get(UNPAIRED_FACES), Some(0), "{test}, {from}");
        let stepped = by_planes.render(&view).expect("a frame");
        let (moved, outliers) = ping_pong::difference(&frame, &stepped, OUTLIER);
        assert_eq!(stepped.stats.get(LOST_RAYS), Some(0), "{test}, {from}");
        // The bar: no pixel beyond 1e-3.
        let ImageError { rmse, max, .. } = ImageError::against(&exact.pixels, &frame);
        let what = format!(
            "{test}, {from}: {rmse:.1e}, {max:.1e}; by planes {moved:.1e}, {} outliers",
            outliers.len()
        );
        println!("{what}");
        assert!(rmse <= 1e-5 && max <= 1e-3, "{what}");
        // As of the small scenes in `ping_pong.rs`, where outliers are explained. A strip n times
        // as wide along edges has n times as many rays that the rasterizer moves, those that
        // differ by less than an outlier too: so have their squares.
        let width = ping_pong::grid_width(&what, &volume, &view, &outliers);
        let most = 1e-5 * (width as f64).sqrt();
        assert!(
            moved <= most && outliers.len() <= 4 * width,
            "{what}, {width}"
        );
        let stepped = by_sides.render(&view).expect("a frame");
        assert_eq!(stepped.stats.get(LOST_RAYS), Some(0), "{test}, {from}");
        let apart = ImageError::against(&exactly(&frame), &stepped);
        // As of the small scenes in `ping_pong.rs`.
        assert!(apart.max <= 1e-5, "{test}, {from}: {apart:?}");
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
