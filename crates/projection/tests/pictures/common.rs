//! Scenes, views, the truth and measures of error that the tests of pictures share.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_projection::{CellProjection, ProjectionOptions};
use tetrascope_testing::{data_set, look_of};

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
    Volume::Mesh(data_set(name, Some(cells)))
}

/// A data set with its own transfer function.
pub(crate) fn scene(name: &str, cells: u64) -> (Volume, TransferFunction) {
    (mesh(name, cells), look_of(name).transfer_function)
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
    let renderer = CellProjection::new(gpu, volume, appearance, options).expect("it fits");
    renderer.render(view).expect("a picture")
}

/// The ground truth's picture.
pub(crate) fn truth(volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let reference = tetrascope_testing::truth(volume, appearance);
    reference.render(view).expect("a picture")
}
