//! What the tests of pictures share: scenes, views, the truth and how far it is.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_datasets::{Options, find};
use tetrascope_gpu::Gpu;
use tetrascope_projection::{Projection, ProjectionOptions};
use tetrascope_reference::{Reference, ReferenceOptions};

/// Root mean square and greatest error of a picture that is exact but for rounding.
///
/// Which cells a ray crosses is decided alike for all, so only f32 is left. Vertices
/// are rounded by up to 2⁻²⁴ of the mesh's size, and the shear to a ray adds a few of
/// that: 2e-7. In most pixels that is the error of the whole chord, times extinctions up
/// to some 20 a size and a slope: 2e-5. In a face seen edge on to within 1/500 it is
/// 500 times that, 2e-3, in a pixel or two.
pub(crate) const EXACT: (f64, f64) = (2e-5, 2e-3);

/// A data set of about so many cells.
pub(crate) fn mesh(name: &str, cells: u64) -> Volume {
    let options = Options {
        cells: Some(cells),
        seed: None,
    };
    let mesh = find(name).expect("a data set").mesh(&options);
    Volume::Mesh(mesh.expect("a mesh"))
}

/// A data set with its own transfer function.
pub(crate) fn scene(name: &str, cells: u64) -> (Volume, TransferFunction) {
    let volume = mesh(name, cells);
    let knots = find(name).expect("a data set").look().knots;
    (volume, TransferFunction::new(knots).expect("valid knots"))
}

/// From a crooked side, so that no pixel's center is on an edge.
pub(crate) fn crooked(volume: &Volume, orthographic: bool, side: u32) -> View {
    let bounds = volume.bounds();
    let camera = Camera::fit(&bounds, CameraFit::PlusIso, orthographic, 1.0);
    View {
        camera: Camera {
            position: camera.position + bounds.diagonal() * DVec3::new(0.3, -0.1, 0.07),
            ..camera
        },
        width: side,
        height: side,
        background: [0.2, 0.3, 0.1, 0.6],
    }
}

pub(crate) fn drawn(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
    options: &ProjectionOptions,
) -> Frame {
    let renderer = Projection::new(gpu, volume, appearance, options).expect("it fits");
    renderer.render(view).expect("a picture")
}

pub(crate) fn reference(volume: &Volume, appearance: &Appearance) -> Reference {
    let options = ReferenceOptions::default();
    Reference::new(volume, appearance, &options).expect("a mesh")
}

pub(crate) fn truth(volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let reference = reference(volume, appearance);
    reference.render(view).expect("a picture")
}

/// Root mean square and greatest difference over all channels.
pub(crate) fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let squares: Vec<f64> = pairs.map(|(x, y)| f64::from(x - y).powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (
        mean.sqrt(),
        squares.iter().copied().fold(0.0, f64::max).sqrt(),
    )
}
