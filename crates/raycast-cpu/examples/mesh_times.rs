//! Times frames of a mesh against the ground truth: the Blunt Fin if `TETRASCOPE_DATA` has it, else
//! the sphere of as many cells as the first argument says.
//!
//! Prints medians of nine frames, steps per second and the error; `cargo bench` compares algorithms.

use std::time::Instant;

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, OpticalModel, Projection, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_raycast_cpu::counters::CELL_VISITS;
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{ImageError, data_set, knot, look_of, mesh_data, truth};

fn blunt_fin() -> Option<(Volume, Appearance, Camera)> {
    let data = mesh_data("mesh_times", "bluntfin_tets.vtu")?;
    let volume = Volume::Mesh(data.into_mesh(Some("density")).expect("a mesh"));
    let knots = [
        (0.19, [0.1, 0.2, 0.75], 0.4),
        (0.55, [0.12, 0.4, 0.9], 0.1),
        (0.95, [0.15, 0.65, 0.95], 0.02),
        (1.4, [0.2, 0.85, 0.8], 0.1),
        (2.2, [0.45, 0.9, 0.4], 0.6),
        (3.0, [0.98, 0.8, 0.2], 1.2),
        (3.8, [0.98, 0.45, 0.1], 2.5),
        (4.98, [0.95, 0.15, 0.15], 6.0),
    ];
    let knots = knots.map(|(scalar, color, extinction)| knot(scalar, color, extinction));
    let function = TransferFunction::new(knots.to_vec()).expect("sorted");
    let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
    let camera = Camera {
        position: DVec3::new(-22.0, 15.0, 20.0),
        focal_point: DVec3::new(2.4, 3.6, 2.4),
        view_up: DVec3::Y,
        projection: Projection::Perspective { view_angle: 30.0 },
    };
    Some((volume, appearance, camera))
}

fn sphere(cells: u64) -> (Volume, Appearance, Camera) {
    let volume = Volume::Mesh(data_set("sphere", Some(cells)));
    let camera = Camera::fit(&volume.bounds(), CameraFit::PlusIso, false, 1.0);
    (volume, look_of("sphere"), camera)
}

fn main() {
    let cells = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let (volume, appearance, camera) = match cells {
        Some(cells) => sphere(cells),
        None => blunt_fin().unwrap_or_else(|| sphere(200_000)),
    };
    let view = View {
        camera,
        width: 512,
        height: 512,
        background: [0.04, 0.045, 0.06, 1.0],
    };
    if std::env::var_os("ONE_FRAME").is_some() {
        let options = RaycastCpuOptions {
            threads: Some(1),
            ..RaycastCpuOptions::default()
        };
        let renderer = RaycastCpu::new(&volume, &appearance, &options).expect("a mesh");
        renderer.render(&view).expect("a frame");
        return;
    }
    let reference = truth(&volume, &appearance);
    let start = Instant::now();
    let exact = reference.render_exact(&view).expect("a frame");
    println!("reference {:.3} s", start.elapsed().as_secs_f64());
    let most = std::env::var("THREADS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(2);
    for threads in 1..=most {
        let options = RaycastCpuOptions {
            threads: Some(threads),
            ..RaycastCpuOptions::default()
        };
        let start = Instant::now();
        let renderer = RaycastCpu::new(&volume, &appearance, &options).expect("a mesh");
        let prepared = start.elapsed().as_secs_f64();
        let mut frames: Vec<_> = (0..9)
            .map(|_| renderer.render(&view).expect("a frame"))
            .collect();
        let error = ImageError::against(&exact.pixels, &frames[0]);
        frames.sort_by(|a, b| a.stats.cpu_seconds.total_cmp(&b.stats.cpu_seconds));
        let [best, median] = [0, 4].map(|i| frames[i].stats.cpu_seconds);
        let steps = frames[0].stats.get(CELL_VISITS).unwrap_or_default();
        println!(
            "{threads} threads: prepared {prepared:.3} s, median {median:.4} s, best {best:.4} s, \
             {:.2} M steps, {:.0} M a second, rmse {:.1e}, max {:.1e}",
            steps as f64 / 1e6,
            steps as f64 / 1e6 / median,
            error.rmse,
            error.max
        );
    }
}
