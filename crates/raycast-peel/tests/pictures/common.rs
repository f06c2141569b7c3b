//! Pictures of this crate's renderer.

use tetrascope_core::{Appearance, Frame, View, Volume, VolumeRenderer as _};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::{RaycastOptions, RaycastPeel};
use tetrascope_testing::{data_set, look_of};

/// A data set of about `cells` cells with its own transfer function.
pub(crate) fn scene(name: &str, cells: u64) -> (Volume, Appearance) {
    let mesh = data_set(name, Some(cells));
    (Volume::Mesh(mesh), look_of(name))
}

pub(crate) fn renderer(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
) -> RaycastPeel {
    RaycastPeel::new(gpu, volume, appearance, options).expect("a mesh")
}

pub(crate) fn draw(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
    view: &View,
) -> Frame {
    let renderer = renderer(gpu, volume, appearance, options);
    renderer.render(view).expect("a frame")
}
