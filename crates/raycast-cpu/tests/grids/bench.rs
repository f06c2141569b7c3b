//! Scenes, and how a picture is held to the truth.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, Grid, Isosurface, Knot, OpticalModel, Projection,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
use tetrascope_reference::ReferenceImage;
use tetrascope_testing::{fitted, knot, truth};

/// A picture of a scene.
pub(crate) fn drawn(volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let options = RaycastCpuOptions::default();
    let renderer = RaycastCpu::new(volume, appearance, &options).expect("it draws all");
    renderer.render(view).expect("a picture")
}

/// The greatest difference of any channel, and the root of the mean of squares, relative to the
/// brightest channel, at least 1; as far as the reference itself is sure of a pixel.
pub(crate) fn difference(got: &[[f32; 4]], want: &ReferenceImage) -> (f64, f64) {
    assert_eq!(got.len(), want.pixels.len());
    let scale = want.pixels.iter().flatten().fold(1.0f64, |a, b| a.max(*b));
    let off = |at: usize| {
        let (pixel, channel) = (at / 4, at % 4);
        let got = got[pixel][channel];
        assert!(got.is_finite(), "{got}");
        let off = (f64::from(got) - want.pixels[pixel][channel]).abs();
        (off - want.error_bound[pixel]).max(0.0) / scale
    };
    let all = (0..4 * got.len()).map(off);
    let (mut most, mut sum) = (0.0f64, 0.0);
    for off in all {
        most = most.max(off);
        sum += off * off;
    }
    (most, (sum / (4 * got.len()) as f64).sqrt())
}

/// Panics unless a picture is as near to the truth as `most` and `rmse` say.
pub(crate) fn check(
    name: &str,
    (volume, appearance, view): (&Volume, &Appearance, &View),
    [most, rmse]: [f64; 2],
) {
    let exact = truth(volume, appearance)
        .render_exact(view)
        .expect("the truth");
    let frame = drawn(volume, appearance, view);
    let found = difference(&frame.pixels, &exact);
    println!("{name}: {:.1e} {:.1e}", found.0, found.1);
    assert!(
        found.0 <= most && found.1 <= rmse,
        "{name}: greatest difference {:e}, RMSE {:e}",
        found.0,
        found.1
    );
}

/// A turned and flipped lattice with three spacings, of `dims` samples.
pub(crate) fn oblique(dims: [usize; 3], interpolation: Interpolation) -> Lattice {
    let direction = DMat3::from_euler(glam_order(), 0.4, -0.7, 1.1)
        * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    Lattice {
        dims,
        origin: DVec3::new(3.0, -40.0, 7.5),
        spacing: DVec3::new(0.7, 1.1, 0.45),
        direction,
        interpolation,
    }
}

fn glam_order() -> tetrascope_core::glam::EulerRot {
    tetrascope_core::glam::EulerRot::XYZ
}

/// Smooth, from 0 to 1.
pub(crate) fn wave(p: DVec3) -> f64 {
    let wave = (5.0 * p.x).sin() * (4.0 * p.y + 1.0).cos() + (6.0 * p.z + 2.0 * p.x * p.y).sin();
    0.25 * wave + 0.5
}

/// Samples of a formula over the shares of the way along each axis, of `kind`.
pub(crate) fn samples(dims: [usize; 3], kind: &str, field: impl Fn(DVec3) -> f64) -> Samples {
    let [nx, ny, nz] = dims;
    let at = |i: usize| {
        let place = [i % nx, i / nx % ny, i / (nx * ny)];
        let share = |axis: usize| place[axis] as f64 / (dims[axis].max(2) - 1) as f64;
        field(DVec3::new(share(0), share(1), share(2)))
    };
    let all = (0..nx * ny * nz).map(at);
    match kind {
        "u8" => Samples::U8(all.map(|s| (255.0 * s).round() as u8).collect()),
        "u16" => Samples::U16(all.map(|s| (65535.0 * s).round() as u16).collect()),
        "i16" => Samples::I16(all.map(|s| (32000.0 * (s - 0.5)).round() as i16).collect()),
        _ => Samples::F32(all.map(|s| s as f32).collect()),
    }
}

/// A grid of `kind` on an oblique lattice.
pub(crate) fn grid_of(kind: &str, interpolation: Interpolation) -> Volume {
    let dims = [21, 14, 37];
    let samples = samples(dims, kind, wave);
    Volume::Grid(Grid::on(oblique(dims, interpolation), samples).expect("a grid"))
}

/// Knots by their share of the volume's range; extinctions are optical depths over its size.
pub(crate) fn function(volume: &Volume, knots: &[(f64, [f64; 3], f64)]) -> TransferFunction {
    let (low, high) = volume.scalar_range().unwrap_or((0.0, 1.0));
    let size = volume.bounds().diagonal();
    let knots: Vec<Knot> = knots
        .iter()
        .map(|&(share, color, depth)| knot(low + share * (high - low), color, depth / size))
        .collect();
    TransferFunction::new(knots).expect("sorted knots")
}

/// One slope over all scalars.
pub(crate) const SLOPE: [(f64, [f64; 3], f64); 2] =
    [(0.0, [0.1, 0.2, 0.8], 0.5), (1.0, [1.0, 0.3, 0.1], 12.0)];

/// Slopes between clear stretches, with a step.
pub(crate) const STEPS: [(f64, [f64; 3], f64); 7] = [
    (0.1, [0.9, 0.9, 0.1], 0.0),
    (0.25, [0.2, 0.4, 0.9], 8.0),
    (0.25, [0.9, 0.1, 0.3], 1.0),
    (0.4, [0.3, 0.8, 0.3], 0.0),
    (0.55, [0.3, 0.8, 0.3], 0.0),
    (0.7, [1.0, 0.5, 0.2], 30.0),
    (0.9, [0.2, 0.5, 1.0], 2.0),
];

/// An appearance with three surfaces, where the model draws some.
pub(crate) fn look(
    volume: &Volume,
    knots: &[(f64, [f64; 3], f64)],
    model: OpticalModel,
) -> Appearance {
    let appearance = Appearance::new(function(volume, knots), model);
    match model {
        OpticalModel::Isosurfaces => tetrascope_testing::surfaces(volume, appearance),
        _ => appearance,
    }
}

/// From outside in perspective and in parallel, and from inside.
pub(crate) fn views(volume: &Volume, side: u32) -> [View; 4] {
    let inside = tetrascope_testing::inside(volume);
    [
        fitted(volume, CameraFit::PlusIso, false, side),
        fitted(volume, CameraFit::MinusX, true, side),
        tetrascope_testing::view(inside, side),
        tetrascope_testing::view(tetrascope_testing::cutting(volume), side),
    ]
}

/// Along the z axis of the world, in parallel, `side` pixels of size `scale` · 2 / side.
pub(crate) fn along_z(middle: DVec3, scale: f64, side: u32) -> View {
    let camera = Camera {
        position: middle + 10.0 * DVec3::Z,
        focal_point: middle,
        view_up: DVec3::Y,
        projection: Projection::Orthographic {
            parallel_scale: scale,
        },
    };
    tetrascope_testing::view(camera, side)
}

/// One white surface.
pub(crate) fn white_surface(value: f64) -> Isosurface {
    Isosurface {
        value,
        color: DVec3::ONE,
    }
}
