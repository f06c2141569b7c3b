//! Pictures of this crate's renderer.

use tetrascope_core::{Appearance, TetMesh, View, Volume, VolumeRenderer as _};
use tetrascope_raycast_cpu::counters::{LOST_RAYS, UNPAIRED_FACES};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
use tetrascope_reference::Reference;
use tetrascope_testing::{ImageError, data_set, look_of, scale, truth};

/// The bars of the crate.
///
/// A segment in f32 errs by 2e-7 of its opacity, and sums are kept in two parts; scalars are
/// rounded to 2⁻²⁴ of the transfer function's range, over which a steep knot triples the error.
/// Where a ray grazes an edge the lengths err by 2⁻²⁴ over the sine of its angle: 1e-4 of a
/// single cell. Sums of light are as large as `scale`.
pub(crate) const RMSE: f64 = 1e-6;
pub(crate) const MAX: f64 = 1e-4;

/// A data set of about `cells` cells with its own transfer function.
pub(crate) fn scene(name: &str, cells: u64) -> (Volume, Appearance) {
    let mesh = data_set(name, Some(cells));
    (Volume::Mesh(mesh), look_of(name))
}

/// The same as a mesh.
pub(crate) fn mesh(name: &str, cells: u64) -> (TetMesh, Appearance) {
    (data_set(name, Some(cells)), look_of(name))
}

pub(crate) fn renderer(volume: &Volume, appearance: &Appearance) -> RaycastCpu {
    RaycastCpu::new(volume, appearance, &RaycastCpuOptions::default()).expect("a mesh")
}

pub(crate) fn new(volume: &Volume, appearance: &Appearance) -> (RaycastCpu, Reference) {
    (renderer(volume, appearance), truth(volume, appearance))
}

/// Holds a picture of each view to the bars.
pub(crate) fn check<'a>(
    name: &str,
    both: &(RaycastCpu, Reference),
    views: impl IntoIterator<Item = (&'a str, View)>,
) {
    check_within(1.0, name, both, views);
}

/// Holds a picture of each view to so many times the bars.
pub(crate) fn check_within<'a>(
    times: f64,
    name: &str,
    (rays, reference): &(RaycastCpu, Reference),
    views: impl IntoIterator<Item = (&'a str, View)>,
) {
    for (from, view) in views {
        let frame = rays.render(&view).expect("a frame");
        let truth = reference.render_exact(&view).expect("a frame");
        let ImageError { rmse, max, .. } = ImageError::against(&truth.pixels, &frame);
        let scale = times * scale(&truth.pixels);
        println!("{name}, {from}: rmse {rmse:.1e}, max {max:.1e} of {scale:.1}");
        for counter in [LOST_RAYS, UNPAIRED_FACES] {
            assert_eq!(frame.stats.get(counter), Some(0), "{name}, {from}");
        }
        assert!(
            rmse <= RMSE * scale && max <= MAX * scale,
            "{name}, {from}: {rmse:e} {max:e} of {scale}"
        );
    }
}
