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

    // Twice as many pixels per side, and one more, have their middles at a pixel's corners (the even
    // ones) and at its middle (the odd ones). Angles are rounded, so that rays are, by some 1e-16.
    #[test]
    fn corners_are_half_a_pixel_away() {
        let (volume, scene) = sphere();
        let context = Context::new();
        let corners = corners(&context, &volume, &scene).expect("drawn");
        let truth = tetrascope::truth().expect("compiled in");
        let settings = Settings::defaults(truth);
        let renderer = (truth.build)(&context, &volume, &scene.appearance, &settings);
        let renderer = renderer.expect("built");
        let middle = renderer.render(&scene.view).expect("drawn");
        let (width, height) = (scene.view.width, scene.view.height);
        let mut view = View {
            width: 2 * width + 1,
            height: 2 * height + 1,
            ..scene.view
        };
        let Projection::Perspective { view_angle } = view.camera.projection else {
            panic!("a scene is in perspective");
        };
        let taller = f64::from(2 * height + 1) / f64::from(2 * height);
        let tangent = (view_angle / 2.0).to_radians().tan() * taller;
        view.camera.projection = Projection::Perspective {
            view_angle: 2.0 * tangent.atan().to_degrees(),
        };
        let fine = renderer.render(&view).expect("drawn");
        let mut greatest = 0.0f32;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let same = |frame: &Frame, (i, j): (u32, u32)| {
                let (found, expected) = (frame.pixel(x, y), fine.pixel(i, j));
                assert!(
                    found
                        .iter()
                        .zip(expected)
                        .all(|(a, b)| (a - b).abs() < 1e-6),
                    "pixel {x}, {y}: {found:?} and {expected:?}"
                );
            };
            same(&middle, (2 * x + 1, 2 * y + 1));
            for (corner, (i, j)) in corners.iter().zip([(0, 0), (2, 0), (0, 2), (2, 2)]) {
                same(corner, (2 * x + i, 2 * y + j));
            }
            greatest = greatest.max((middle.pixel(x, y)[3] - corners[0].pixel(x, y)[3]).abs());
        }
        // A picture in which all rays see the same would show nothing.
        assert!(greatest > 0.01, "{greatest}");
    }
}
