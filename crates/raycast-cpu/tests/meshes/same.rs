//! Changes that must not change a picture.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Knot, OpticalModel, Projection, Scalars, TetMesh,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::{CELL_VISITS, LOST_RAYS};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{
    check_counts, fitted, outside_and_inside, point_scalars, ramp, surfaces, view,
};

use crate::common::{mesh, renderer, scene};

const SIDE: u32 = 64;

#[test]
fn pixels_do_not_depend_on_threads() {
    let (volume, appearance) = scene("heat-sink", 20_000);
    let view = fitted(&volume, CameraFit::PlusIso, false, 300);
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            ..surfaces(&volume, appearance.clone())
        };
        let frames = [1, 2, 7].map(|threads| {
            let options = RaycastCpuOptions {
                threads: Some(threads),
                ..RaycastCpuOptions::default()
            };
            let rays = RaycastCpu::new(&volume, &appearance, &options).expect("a mesh");
            rays.render(&view).expect("a frame")
        });
        for frame in &frames[1..] {
            assert!(frame.pixels == frames[0].pixels && frame.depths == frames[0].depths);
            assert_eq!(frame.stats.counts, frames[0].stats.counts);
        }
        check_counts(&tetrascope_raycast_cpu::ENTRY, &frames[0].stats);
    }
}

/// A million miles from the origin and a micrometer wide: the same bits.
#[test]
fn place_and_size_change_nothing() {
    let (mesh, appearance) = mesh("torus", 1500);
    let draw = |size: f64, place: DVec3| {
        let points = mesh.points().iter().map(|&p| (p + place) * size).collect();
        let scalars = mesh.scalars().clone();
        let moved = TetMesh::from_tetrahedra(points, mesh.tetrahedra().to_vec(), scalars);
        let volume = Volume::Mesh(moved.expect("a mesh"));
        let knots = appearance.transfer_function.knots().iter().map(|k| Knot {
            extinction: k.extinction / size,
            ..*k
        });
        let appearance = Appearance {
            transfer_function: TransferFunction::new(knots.collect()).expect("valid knots"),
            ..appearance.clone()
        };
        let camera = Camera::fit(&volume.bounds(), CameraFit::PlusX, false, 1.0);
        let frame = renderer(&volume, &appearance).render(&view(camera, SIDE));
        frame.expect("a frame").pixels
    };
    let here = draw(1.0, DVec3::ZERO);
    for power in [-300, -40, 300] {
        assert!(here == draw(2f64.powi(power), DVec3::ZERO), "2^{power}");
    }
    let there = draw(1.0, DVec3::splat(2f64.powi(20)));
    // The mesh's own coordinates lose 20 of f64's 53 bits there; f32 has 24.
    let worst = here.iter().flatten().zip(there.iter().flatten());
    let worst = worst.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
    assert!(worst < 1e-4, "place: {worst}");
}

#[test]
fn new_scalars_and_styles_give_what_a_new_renderer_gives() {
    let (mesh, appearance) = mesh("heat-sink", 2000);
    let new =
        |mesh: &TetMesh, appearance: &Appearance| renderer(&Volume::Mesh(mesh.clone()), appearance);
    let camera = Camera::fit(&mesh.bounds(), CameraFit::PlusIso, false, 1.0);
    let view = view(camera, SIDE);
    let frame = |rays: &RaycastCpu| rays.render(&view).expect("a frame").pixels;
    let mut rays = new(&mesh, &appearance);

    let values = mesh.scalars().values.iter().map(|s| 130.0 - s).collect();
    let turned = mesh.with_scalars(point_scalars(values)).expect("as many");
    rays.reload(&Volume::Mesh(turned.clone())).expect("a mesh");
    assert!(frame(&rays) == frame(&new(&turned, &appearance)), "scalars");

    let emission = Appearance {
        optical_model: OpticalModel::Emission,
        ..appearance.clone()
    };
    rays.restyle(&emission).expect("a style");
    assert!(frame(&rays) == frame(&new(&turned, &emission)), "style");

    let values = (0..turned.cell_count()).map(|c| c as f64 / turned.cell_count() as f64 * 60.0);
    let per_cell = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values: values.collect(),
    };
    let per_cell = turned.with_scalars(per_cell).expect("as many values");
    rays.reload(&Volume::Mesh(per_cell.clone()))
        .expect("a mesh");
    assert!(
        frame(&rays) == frame(&new(&per_cell, &emission)),
        "association"
    );

    let (sphere, _) = self::mesh("sphere", 700);
    rays.reload(&Volume::Mesh(sphere.clone())).expect("a mesh");
    assert!(frame(&rays) == frame(&new(&sphere, &emission)), "geometry");
}

#[test]
fn early_stop_changes_no_more_than_it_says() {
    let (volume, appearance) = scene("sphere", 5000);
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let draw = |stop_opacity| {
        let options = RaycastCpuOptions {
            stop_opacity,
            ..RaycastCpuOptions::default()
        };
        let rays = RaycastCpu::new(&volume, &appearance, &options).expect("a mesh");
        rays.render(&view).expect("a frame")
    };
    let (exact, stopped) = (draw(1.0), draw(0.6));
    let all = exact.pixels.iter().flatten();
    let all = all.zip(stopped.pixels.iter().flatten());
    let worst = all.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
    // Colors are at most 1 here, so what is hidden is at most what shines through.
    assert!(worst > 0.0 && worst <= 0.4, "{worst}");
    assert!(stopped.stats.get(CELL_VISITS) < exact.stats.get(CELL_VISITS));
}

/// Rays of every main axis in one picture, and of opposite ones: nothing is lost where they meet.
#[test]
fn a_camera_sees_almost_all_around() {
    let (volume, appearance) = scene("sphere", 2000);
    let [.., inside] = outside_and_inside(&volume, 90);
    for view_angle in [100.0, 150.0, 175.0] {
        let camera = Camera {
            projection: Projection::Perspective { view_angle },
            ..inside.camera
        };
        let view = View { camera, ..inside };
        let both = crate::common::new(&volume, &appearance);
        crate::common::check("wide", &both, [("inside", view)]);
    }
}

#[test]
fn a_cell_takes_at_most_52_bytes_with_its_vertices() {
    let (volume, appearance) = scene("sphere", 100_000);
    let view = fitted(&volume, CameraFit::PlusIso, false, 8);
    let frame = renderer(&volume, &appearance)
        .render(&view)
        .expect("a frame");
    let bytes = frame.stats.bytes_per_cell.expect("a mesh");
    println!("{bytes:.1} bytes per cell");
    assert!(bytes <= 52.0, "{bytes}");
}

#[test]
fn what_shows_nothing_is_not_cast() {
    let (mesh, mut appearance) = mesh("sphere", 1000);
    let volume = Volume::Mesh(mesh.clone());
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let clear = appearance.transfer_function.knots().iter().map(|k| Knot {
        extinction: 0.0,
        ..*k
    });
    appearance.transfer_function = TransferFunction::new(clear.collect()).expect("sorted");
    let frame = renderer(&volume, &appearance)
        .render(&view)
        .expect("a frame");
    assert_eq!(frame.stats.get(CELL_VISITS), Some(0));
    let empty = TetMesh::from_tetrahedra(Vec::new(), Vec::new(), point_scalars(Vec::new()));
    let empty = Volume::Mesh(empty.expect("a mesh"));
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            ..surfaces(&volume, ramp(&volume))
        };
        let frame = renderer(&empty, &appearance)
            .render(&view)
            .expect("a frame");
        assert_eq!(frame.stats.get(LOST_RAYS), Some(0));
    }
}
