//! Parts of one mesh with the whole's domain, against the whole.

use std::slice;

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, DepthCue, Error, Frame, Isosurface, OpticalModel, Volume, VolumeRenderer as _,
};
use tetrascope_f32::Domain;
use tetrascope_projection::{CellProjection, ProjectionOptions};
use tetrascope_testing as testing;

use crate::common::{crooked, drawn, scene};

/// The nearest surface of any part, pixel by pixel.
fn nearest(parts: &[Frame]) -> Vec<([f32; 4], f32)> {
    let pixel = |i: usize| {
        let at = |part: &Frame| (part.pixels[i], part.depths.as_ref().expect("depths")[i]);
        let parts = parts.iter().map(at);
        parts.min_by(|a, b| a.1.total_cmp(&b.1)).expect("parts")
    };
    (0..parts[0].pixels.len()).map(pixel).collect()
}

#[test]
fn parts_with_the_domain_of_the_whole_are_the_whole_to_the_last_bit() {
    let Some(gpu) = testing::gpu("parts_with_the_domain_of_the_whole_are_the_whole") else {
        return;
    };
    let (volume, function) = scene("torus", 3000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a data set is a mesh");
    };
    let (low, high) = mesh.scalar_range().expect("values");
    let mut appearance = Appearance::new(function, OpticalModel::Isosurfaces);
    appearance.depth_cue = Some(DepthCue { strength: 0.7 });
    appearance.isosurfaces = vec![Isosurface {
        value: low + 0.6 * (high - low),
        color: DVec3::new(0.9, 0.5, 0.2),
    }];
    let parts = testing::quarters(mesh).map(Volume::Mesh);
    for orthographic in [false, true] {
        let view = crooked(&volume, orthographic, 64);
        let picture = |volume: &Volume, domain| {
            let options = ProjectionOptions {
                domain,
                ..ProjectionOptions::default()
            };
            drawn(&gpu, volume, &appearance, &view, &options)
        };
        let whole = picture(&volume, None);
        let differing = |domain| {
            let parts = parts.each_ref().map(|part| picture(part, domain));
            let both = nearest(&parts)
                .into_iter()
                .zip(nearest(slice::from_ref(&whole)));
            both.filter(|(part, whole)| part != whole).count()
        };
        let seen = whole.depths.as_ref().expect("depths").iter();
        assert!(seen.filter(|depth| depth.is_finite()).count() > 500);
        assert_eq!(differing(Some(Domain::of(mesh))), 0, "{orthographic}");
        assert!(differing(None) > 500, "{orthographic}");
    }
}

#[test]
fn a_volume_outside_of_the_domain_is_refused_and_leaves_the_renderer_as_it_was() {
    let Some(gpu) = testing::gpu("a_volume_outside_of_the_domain_is_refused") else {
        return;
    };
    let (volume, function) = scene("torus", 500);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a data set is a mesh");
    };
    let [part, ..] = testing::quarters(mesh);
    let options = ProjectionOptions {
        domain: Some(Domain::of(&part)),
        ..ProjectionOptions::default()
    };
    let appearance = Appearance::new(function, OpticalModel::Emission);
    let view = crooked(&volume, false, 16);
    let part = Volume::Mesh(part);
    let mut renderer = CellProjection::new(&gpu, &part, &appearance, &options).expect("inside");
    let before = renderer.render(&view).expect("a picture");
    let error = renderer.reload(&volume).expect_err("outside");
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
    let after = renderer.render(&view).expect("a picture");
    assert_eq!(before.pixels, after.pixels);
}
