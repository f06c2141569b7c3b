//! Parts of one mesh against the whole.

use tetrascope_core::{Appearance, CameraFit, OpticalModel, Volume, VolumeRenderer as _};
use tetrascope_raycast_cpu::{Domain, PathSegments, RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{exactly, fitted, inside, quarters, scale, surfaces, tilted, view};

use crate::common::{mesh, renderer};

/// Four parts together show the same as the whole: a ray goes through the torus twice, and
/// through its parts in any order.
#[test]
fn paths_of_parts_are_the_whole() {
    let (mesh, appearance) = mesh("torus", 3000);
    let volume = Volume::Mesh(mesh.clone());
    let options = RaycastCpuOptions {
        domain: Some(Domain::of(&mesh)),
        ..RaycastCpuOptions::default()
    };
    for model in OpticalModel::ALL {
        let appearance = Appearance {
            optical_model: model,
            clip_planes: tilted(&volume),
            ..surfaces(&volume, appearance.clone())
        };
        let whole = renderer(&volume, &appearance);
        let parts = quarters(&mesh).map(|part| {
            RaycastCpu::new(&Volume::Mesh(part), &appearance, &options).expect("a part")
        });
        for mut view in [
            fitted(&volume, CameraFit::PlusIso, false, 64),
            view(inside(&volume), 64),
        ] {
            view.background = [0.3, 0.2, 0.1, 0.5];
            let whole = whole.render(&view).expect("a frame");
            let segments = parts.each_ref().map(|p| p.segments(&view).expect("paths"));
            let together = PathSegments::composite(&segments, &view).expect("one size");
            let scale = scale(&exactly(&whole));
            let pairs = together.iter().flatten().zip(whole.pixels.iter().flatten());
            // Each of some ten segments rounds by 2⁻²⁴, and where a ray goes on into another part the
            // corners of the face between them are added up in another order.
            let worst = pairs.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
            assert!(
                f64::from(worst) <= 2e-6 * scale,
                "{}: {worst:e} of {scale}",
                model.name()
            );
        }
        let view = fitted(&volume, CameraFit::PlusIso, false, 32);
        let small = parts[0].segments(&view).expect("paths");
        assert!(!small.segments.is_empty());
        let large = fitted(&volume, CameraFit::PlusIso, false, 64);
        assert!(PathSegments::composite(&[small], &large).is_err());
    }
}
