//! The ground truth, and what f32 may make of it.

use tetrascope_core::glam::DVec2;
use tetrascope_core::{Appearance, Ray, View, Volume, VolumeRenderer as _};
use tetrascope_reference::{Reference, ReferenceOptions};

/// The ground truth of a scene.
pub fn truth(volume: &Volume, appearance: &Appearance) -> Reference {
    Reference::new(volume, appearance, &ReferenceOptions::default()).expect("it draws all")
}

/// Whether a ray within 1e-4 of a pixel of this one has this color. f32 moves rays by less
/// than that (2⁻²⁴ of the distance of some hundred pixels), so it decides what a
/// ray along a surface's outline, or along an edge between two facets, sees.
pub fn is_near_explained(truth: &Reference, view: &View, pixel: usize, got: [f32; 4]) -> bool {
    let (column, row) = (pixel as u32 % view.width, pixel as u32 / view.width);
    (0..16).any(|i| {
        let angle = f64::from(i) / 16.0 * std::f64::consts::TAU;
        let shift = 1e-4 * DVec2::from_angle(angle);
        let size = DVec2::new(view.width.into(), view.height.into());
        let at = 2.0 * (DVec2::new(column.into(), row.into()) + 0.5 + shift) / size - 1.0;
        let ray = view.camera.ray(at.x, -at.y, size.x / size.y);
        has_color(truth, view, &ray, got)
    })
}

/// Whether [`is_near_explained`], or surfaces within 2⁻²² of the field's range of their values
/// give this color, as scalars are rounded to 2⁻²⁴ of it and three of them are summed: f32
/// decides which of two facets a ray meets where a surface crosses from cell to cell.
pub fn is_explained(
    truth: &Reference,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
    pixel: usize,
    got: [f32; 4],
) -> bool {
    let (low, high) = volume.scalar_range().expect("a field");
    let ray = view.ray(pixel as u32 % view.width, pixel as u32 / view.width);
    is_near_explained(truth, view, pixel, got)
        || [-1.0, 1.0].into_iter().any(|sign| {
            let mut appearance = appearance.clone();
            for surface in &mut appearance.isosurfaces {
                surface.value += sign * (high - low) / f64::from(1 << 22);
            }
            let mut truth = truth.clone();
            truth.restyle(&appearance).expect("it draws all");
            has_color(&truth, view, &ray, got)
        })
}

fn has_color(truth: &Reference, view: &View, ray: &Ray, got: [f32; 4]) -> bool {
    let background = view.premultiplied_background();
    let trace = truth.trace(ray).expect("a ray");
    (0..4).all(|c| {
        let want = trace.pixel[c] + (1.0 - trace.pixel[3]) * background[c];
        (want - f64::from(got[c])).abs() <= 1e-3
    })
}
