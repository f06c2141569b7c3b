//! The truth through corners of pixels, where some of VTK's rays go.

use tetrascope::core::{Error, Frame, FrameStats, Projection, View, Volume, VolumeRenderer as _};
use tetrascope::scene::Scene;
use tetrascope::{Context, Settings};

/// The truth with its rays through each of the four corners of every pixel in place of the middle.
///
/// A picture that is a pixel wider and higher at the same size of a pixel has its pixels' middles at
/// the corners of the other's.
pub(super) fn corners(
    context: &Context,
    volume: &Volume,
    scene: &Scene,
) -> Result<Vec<Frame>, Error> {
    let Some(truth) = tetrascope::truth() else {
        return Ok(Vec::new());
    };
    let View { width, height, .. } = scene.view;
    let mut view = View {
        width: width + 1,
        height: height + 1,
        ..scene.view
    };
    let taller = f64::from(view.height) / f64::from(height);
    view.camera.projection = match view.camera.projection {
        Projection::Perspective { view_angle } => Projection::Perspective {
            view_angle: 2.0
                * ((view_angle.to_radians() / 2.0).tan() * taller)
                    .atan()
                    .to_degrees(),
        },
        Projection::Orthographic { parallel_scale } => Projection::Orthographic {
            parallel_scale: parallel_scale * taller,
        },
    };
    let renderer = (truth.build)(
        context,
        volume,
        &scene.appearance,
        &Settings::defaults(truth),
    )?;
    let large = renderer.render(&view)?;
    let shifts = [(0, 0), (1, 0), (0, 1), (1, 1)];
    let shifted = shifts.map(|(x, y)| {
        let rows = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        let pixels = rows.map(|(column, row)| large.pixel(column + x, row + y));
        Frame::new((width, height), pixels.collect(), FrameStats::default())
    });
    Ok(shifted.into())
}

#[cfg(test)]
mod tests {
    use super::super::tests::sphere;
    use super::*;
    use crate::metrics::Errors;

    // A corner of one picture's pixel is a ray of ours: asked for alone, it sees the very same, but for
    // the rounding of its angle.
    #[test]
    fn corners_are_half_a_pixel_away() {
        let (volume, scene) = sphere();
        let context = Context::new();
        let corners = corners(&context, &volume, &scene).expect("drawn");
        let at = |frame: &Frame, x, y| frame.pixel(x, y);
        for (x, y) in [(3, 2), (4, 3), (5, 2)] {
            // The lower right corner of a pixel is the upper left of the next one.
            assert_eq!(at(&corners[3], x, y), at(&corners[0], x + 1, y + 1));
            assert_eq!(at(&corners[1], x, y), at(&corners[0], x + 1, y));
        }
        // Twice as many pixels a side have the corners' neighbors around the middle: the mean of the
        // four corners is the middle's value to second order in half a pixel.
        let truth = tetrascope::truth().expect("compiled in");
        let settings = Settings::defaults(truth);
        let renderer = (truth.build)(&context, &volume, &scene.appearance, &settings);
        let middle = renderer.and_then(|r| r.render(&scene.view)).expect("drawn");
        let error = |frame: &Frame| Errors::between(&middle, frame).image.rmse;
        let mean: Vec<[f32; 4]> = (0..middle.pixels.len())
            .map(|i| std::array::from_fn(|c| corners.iter().map(|f| f.pixels[i][c] / 4.0).sum()))
            .collect();
        let mean = Frame::new((9, 6), mean, FrameStats::default());
        assert!(
            corners
                .iter()
                .all(|corner| error(corner) > 2.0 * error(&mean))
        );
    }
}
