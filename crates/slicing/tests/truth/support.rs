//! Small volumes, views, and the exact pictures to compare with.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, Grid, OpticalModel, Projection, Ray, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_slicing::{Slicing, SlicingOptions};
pub(crate) use tetrascope_testing::{
    self as testing, Place, between, difference, grid, grid_of, knot,
};

/// The cube [0, 1]³ with n samples per axis.
pub(crate) fn cube(n: usize) -> Place {
    Place::unit(n - 1)
}

/// Turned, flipped and with three different spacings, far from the origin.
pub(crate) fn skewed() -> Place {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).unit(), 0.7);
    Place {
        dims: [14, 23, 9],
        origin: DVec3::new(1000.0, -2000.0, 500.0),
        spacing: DVec3::new(0.1, 0.05, 0.3),
        direction: turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
    }
}

/// Smooth enough and with a color that changes.
pub(crate) fn ramp(most: f64) -> TransferFunction {
    let knots = vec![
        knot(0.0, [0.1, 0.3, 0.9], 0.0),
        knot(0.4, [0.9, 0.5, 0.2], 0.3 * most),
        knot(1.0, [1.0, 0.9, 0.6], most),
    ];
    TransferFunction::new(knots).expect("the knots are sorted")
}

pub(crate) fn appearance(tf: &TransferFunction, optical_model: OpticalModel) -> Appearance {
    Appearance::new(tf.clone(), optical_model)
}

/// Views of `grid` from outside, in both projections, along an axis, and from inside.
pub(crate) fn views(grid: &Grid) -> Vec<(&'static str, View)> {
    let bounds = grid.bounds();
    let fit = |fit, orthographic| Camera::fit(&bounds, fit, orthographic, 1.0);
    let off = |camera: Camera| {
        let shift = bounds.diagonal() * DVec3::new(0.31, -0.17, 0.05);
        Camera {
            position: camera.position + shift,
            ..camera
        }
    };
    let inside = Camera {
        position: bounds.center() + bounds.size() * DVec3::new(0.11, -0.07, 0.13),
        focal_point: bounds.center() + bounds.size() * DVec3::new(1.0, 0.6, 0.4),
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle: 70.0 },
    };
    let view = |camera| testing::view(camera, 48);
    vec![
        ("perspective", view(off(fit(CameraFit::PlusIso, false)))),
        ("orthographic", view(off(fit(CameraFit::MinusIso, true)))),
        ("along an axis", view(fit(CameraFit::MinusX, true))),
        ("inside", view(inside)),
    ]
}

pub(crate) fn draw(
    gpu: &Gpu,
    grid: &Grid,
    appearance: &Appearance,
    options: &SlicingOptions,
    view: &View,
) -> Frame {
    let volume = Volume::Grid(grid.clone());
    let slicing = Slicing::new(gpu, &volume, appearance, options).expect("the grid fits");
    slicing.render(view).expect("the view is valid")
}

/// Where a ray is inside of a grid, as distances; nothing if `start >= end`.
pub(crate) fn span(grid: &Grid, ray: &Ray) -> (f64, f64) {
    let (origin, direction) = in_lattice(grid, ray);
    let (mut start, mut end) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let cells = (grid.dims()[axis] - 1) as f64;
        if direction[axis] == 0.0 {
            if !(0.0..=cells).contains(&origin[axis]) {
                return (0.0, 0.0);
            }
            continue;
        }
        let hits = [0.0, cells].map(|x| (x - origin[axis]) / direction[axis]);
        start = start.max(hits[0].min(hits[1]));
        end = end.min(hits[0].max(hits[1]));
    }
    (start, end)
}

/// A ray in lattice coordinates, its parameter still in world units.
fn in_lattice(grid: &Grid, ray: &Ray) -> (DVec3, DVec3) {
    let inverse = (grid.direction() * DMat3::from_diagonal(grid.spacing())).inverse();
    (
        inverse * (ray.origin - grid.origin()),
        inverse * ray.direction,
    )
}

/// The exact picture.
pub(crate) fn truth(grid: &Grid, appearance: &Appearance, view: &View) -> Vec<[f64; 4]> {
    let volume = Volume::Grid(grid.clone());
    let image = testing::truth(&volume, appearance).render_exact(view);
    image.expect("the view is valid").pixels
}

/// A picture by a formula of the ray.
pub(crate) fn pixels(view: &View, pixel: impl Fn(&Ray) -> [f64; 4]) -> Vec<[f64; 4]> {
    (0..view.height)
        .flat_map(|row| (0..view.width).map(move |column| (column, row)))
        .map(|(column, row)| pixel(&view.ray(column, row)))
        .collect()
}

/// That a picture shows something: its pixels differ from the background.
pub(crate) fn shows(frame: &Frame) -> bool {
    let first = frame.pixels[0];
    let differs = |p: &[f32; 4]| p.iter().zip(first).any(|(a, b)| (a - b).abs() > 0.05);
    frame.pixels.iter().any(differs)
}

/// That two pictures differ by roundings of scalars alone: shaders that map scalars may fuse
/// other products with other sums, so each scalar in [0, 1] is off by 2⁻²³ at most, and optical
/// depth and light by some ten times that on a ray; by less on most, as signs vary.
pub(crate) fn assert_near(a: &Frame, b: &Frame, context: &str) {
    let (rmse, most) = between(a, b);
    assert!(
        rmse <= 1e-7 && most <= 2e-6,
        "{context}: RMSE {rmse:e}, at most {most:e}"
    );
}
