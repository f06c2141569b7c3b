//! Parts of one mesh with the whole's domain, against the whole.

use tetrascope_core::{Appearance, CameraFit, DepthCue, Frame, OpticalModel, Volume};
use tetrascope_f32::{Domain, Locality};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::{Passes, RaycastOptions};
use tetrascope_testing::{self as testing, fitted, surfaces};

use crate::common::{draw, scene};

/// The picture that four parts show together: the nearest surface, or the greatest of each channel.
fn together(parts: &[Frame]) -> Vec<[f32; 4]> {
    let nearer = |a: (f32, [f32; 4]), b: (f32, [f32; 4])| if b.0 < a.0 { b } else { a };
    let greater = |a: [f32; 4], b: [f32; 4]| [0, 1, 2, 3].map(|i| a[i].max(b[i]));
    let pixel = |i: usize| {
        let nearest = parts
            .iter()
            .map(|part| Some((part.depths.as_ref()?[i], part.pixels[i])));
        let nearest: Option<Vec<_>> = nearest.collect();
        match nearest {
            Some(parts) => parts.into_iter().reduce(nearer).expect("parts").1,
            None => {
                let parts = parts.iter().map(|part| part.pixels[i]);
                parts.reduce(greater).expect("parts")
            }
        }
    };
    (0..parts[0].pixels.len()).map(pixel).collect()
}

/// How many pixels of four parts together differ from the whole's in any bit, and by how much
/// at most.
///
/// Where a ray goes on into another part, the corners of the face between them are added up in
/// another order.
fn differing(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
) -> (usize, f32) {
    let Volume::Mesh(mesh) = volume else {
        panic!("a data set is a mesh");
    };
    let view = fitted(volume, CameraFit::PlusIso, false, 64);
    let alone = RaycastOptions {
        domain: None,
        ..*options
    };
    let whole = draw(gpu, volume, appearance, &alone, &view);
    let parts = testing::quarters(mesh).map(Volume::Mesh);
    let parts = parts.map(|part| draw(gpu, &part, appearance, options, &view));
    let together = together(&parts);
    let count = together.iter().zip(&whole.pixels).filter(|(a, b)| a != b);
    let pairs = together.iter().flatten().zip(whole.pixels.iter().flatten());
    let greatest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    (count.count(), greatest)
}

#[test]
fn parts_with_the_domain_of_the_whole_have_its_numbers() {
    let Some(gpu) = testing::gpu("parts_with_the_domain_of_the_whole_have_its_numbers") else {
        return;
    };
    let (volume, appearance) = scene("torus", 3000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a data set is a mesh");
    };
    let domain = Some(Domain::of(mesh));
    let surfaces = Appearance {
        depth_cue: Some(DepthCue { strength: 0.7 }),
        ..surfaces(&volume, appearance.clone())
    };
    let brightest = Appearance::new(appearance.transfer_function, OpticalModel::MaximumIntensity);
    for (passes, appearance) in [
        (Passes::Single, &surfaces),
        (Passes::Single, &brightest),
        (Passes::PingPong, &brightest),
    ] {
        let count = |domain| {
            let options = RaycastOptions {
                passes,
                domain,
                locality: Locality::AsGiven,
                ..RaycastOptions::default()
            };
            differing(&gpu, &volume, appearance, &options)
        };
        let ((with, most), (without, _)) = (count(domain), count(None));
        let what = format!("{passes:?} {:?}", appearance.optical_model);
        println!("{what}: {with} pixels by {most:e}, {without} without a domain");
        // A mean of three corners rounds by less than 2⁻²², and colors change by less than 16
        // times as much as the mapped scalar.
        assert!(most <= 1.0 / (1 << 18) as f32, "{what}: {most:e}");
        assert!(
            without > 100 && 10 * with < without,
            "{what}: {with} {without}"
        );
    }
}
