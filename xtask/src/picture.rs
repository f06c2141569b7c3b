//! Pictures for people: frames as PNG, differences in false color.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{Rgba, RgbaImage};
use tetrascope::core::Frame;
use tetrascope::core::colormap::{Colormap, linear_to_srgb, srgb_to_linear};
use tetrascope_testing::apart;

/// The color map of differences: black is none, pale yellow the scale's end.
pub const DIFFERENCE_MAP: Colormap = Colormap::Inferno;

/// A frame as it is shown: sRGB with straight alpha, clamped to [0, 1].
pub fn shown(frame: &Frame) -> RgbaImage {
    let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    RgbaImage::from_fn(frame.width, frame.height, |column, row| {
        let [r, g, b, alpha] = frame.pixel(column, row).map(f64::from);
        // A clear pixel has no color of its own, though it may add light.
        let straight = |c: f64| linear_to_srgb((c / alpha.max(1e-12)).clamp(0.0, 1.0));
        let color = if alpha > 0.0 {
            [r, g, b].map(straight)
        } else {
            [0.0; 3]
        };
        Rgba([byte(color[0]), byte(color[1]), byte(color[2]), byte(alpha)])
    })
}

/// The greatest difference of each pixel's channels in false color, and the
/// value at the color scale's end: 1, 2 or 5 times a power of ten.
///
/// `None` where the images are equal. Panics where the sizes differ.
pub fn difference_map(truth: &Frame, image: &Frame) -> Option<(RgbaImage, f64)> {
    assert_eq!((truth.width, truth.height), (image.width, image.height));
    let at = |column, row| {
        let (t, p) = (truth.pixel(column, row), image.pixel(column, row));
        (0..4)
            .map(|c| apart(t[c].into(), p[c].into()))
            .fold(0.0, f64::max)
    };
    let pixels = (0..truth.height).flat_map(|row| (0..truth.width).map(move |c| at(c, row)));
    // What is infinitely wrong shows as the scale's end and must not set it.
    let greatest = pixels.clone().filter(|d| d.is_finite()).fold(0.0, f64::max);
    if !pixels.clone().any(|d| d > 0.0) {
        return None;
    }
    let end = if greatest > 0.0 {
        round_up(greatest)
    } else {
        1.0
    };
    let map = RgbaImage::from_fn(truth.width, truth.height, |column, row| {
        let color = DIFFERENCE_MAP.linear_rgb((at(column, row) / end).min(1.0));
        let [r, g, b] = color
            .to_array()
            .map(|c| (linear_to_srgb(c) * 255.0).round() as u8);
        Rgba([r, g, b, 255])
    });
    Some((map, end))
}

/// The least of 1, 2 and 5 times a power of ten that is not below `x` > 0.
pub fn round_up(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * decade);
    // A power of ten may come out an ulp low: forgive that.
    let fits = steps.into_iter().find(|&step| x <= step * (1.0 + 1e-12));
    fits.unwrap_or(10.0 * decade)
}

/// A picture `factor` times smaller: the mean of each box of pixels, as light and by its alpha.
pub fn mean_of_boxes(image: &RgbaImage, factor: u32) -> RgbaImage {
    boxes(image, factor, |pixels| {
        let mut sum = [0.0; 4];
        for Rgba([r, g, b, alpha]) in pixels {
            let alpha = f64::from(*alpha) / 255.0;
            for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                *sum += alpha * srgb_to_linear(f64::from(*c) / 255.0);
            }
            sum[3] += alpha;
        }
        let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let color = |c: usize| byte(linear_to_srgb((sum[c] / sum[3].max(1e-12)).clamp(0.0, 1.0)));
        let alpha = byte(sum[3] / pixels.len() as f64);
        Rgba([color(0), color(1), color(2), alpha])
    })
}

/// A picture of differences `factor` times smaller: the brightest of each box of pixels, which is
/// its greatest difference, so that one wrong pixel stays in sight.
pub fn brightest_of_boxes(image: &RgbaImage, factor: u32) -> RgbaImage {
    // Rec. 709's weights of luminance, which grows along the color map.
    let luminance = |Rgba([r, g, b, _]): &Rgba<u8>| {
        2126 * u32::from(*r) + 7152 * u32::from(*g) + 722 * u32::from(*b)
    };
    boxes(image, factor, |pixels| {
        let brightest = pixels.iter().max_by_key(|pixel| luminance(pixel));
        *brightest.expect("a box has a pixel")
    })
}

/// One pixel for each box of `factor` pixels a side; boxes at the right and at the foot may be cut.
fn boxes(image: &RgbaImage, factor: u32, pixel: impl Fn(&[Rgba<u8>]) -> Rgba<u8>) -> RgbaImage {
    let (width, height) = image.dimensions();
    RgbaImage::from_fn(width.div_ceil(factor), height.div_ceil(factor), |x, y| {
        let end = |start: u32, side: u32| (start + factor).min(side);
        let (left, top) = (x * factor, y * factor);
        let rows = top..end(top, height);
        let all = rows.flat_map(|y| (left..end(left, width)).map(move |x| *image.get_pixel(x, y)));
        pixel(&all.collect::<Vec<_>>())
    })
}

/// Images in a row, a few gray pixels between them.
pub fn side_by_side(images: &[&RgbaImage]) -> RgbaImage {
    const GAP: u32 = 8;
    let height = images.iter().map(|i| i.height()).max().unwrap_or(1);
    let width: u32 = images.iter().map(|i| i.width() + GAP).sum();
    let mut row = RgbaImage::from_pixel(width.max(1), height, Rgba([128, 128, 128, 255]));
    let mut x = 0;
    for image in images {
        image::imageops::replace(&mut row, *image, x.into(), 0);
        x += image.width() + GAP;
    }
    row
}

/// Images below each other, a few gray pixels between them.
pub fn stacked(images: &[&RgbaImage]) -> RgbaImage {
    // In a row they are aligned at the top, which turned and mirrored is the left.
    let turned = images.iter().map(|i| transposed(i));
    let turned: Vec<RgbaImage> = turned.collect();
    transposed(&side_by_side(&turned.iter().collect::<Vec<_>>()))
}

/// The image as a PNG file.
pub fn png(image: &RgbaImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("memory takes any image");
    bytes.into_inner()
}

/// Columns as rows.
fn transposed(image: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(image.height(), image.width(), |x, y| *image.get_pixel(y, x))
}

/// An opaque image as a small PNG file, for the repository: slower to make, and without alpha.
pub fn small_png(image: &RgbaImage) -> Vec<u8> {
    let rgb = image::DynamicImage::from(image.clone()).into_rgb8();
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    rgb.write_with_encoder(encoder)
        .expect("memory takes any image");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope::core::FrameStats;

    fn one(pixel: [f32; 4]) -> Frame {
        Frame::new((1, 1), vec![pixel], FrameStats::default())
    }

    #[test]
    fn smaller_pictures_are_means_of_light() {
        // Three columns: half of the first box is clear, the second box is cut.
        let mut image = RgbaImage::from_pixel(3, 2, Rgba([255, 0, 100, 255]));
        image.put_pixel(1, 0, Rgba([9, 9, 9, 0]));
        image.put_pixel(1, 1, Rgba([0, 0, 100, 255]));
        let small = mean_of_boxes(&image, 2);
        assert_eq!(small.dimensions(), (2, 1));
        // Two of three are white in red: 2/3 of the light is 212.9 in sRGB. 3/4 of 255 is 191.25.
        assert_eq!(small.get_pixel(0, 0).0, [213, 0, 100, 191]);
        assert_eq!(small.get_pixel(1, 0).0, [255, 0, 100, 255]);
        assert_eq!(mean_of_boxes(&small, 1), small);
    }

    #[test]
    fn one_wrong_pixel_stays_in_smaller_differences() {
        let mut image = RgbaImage::from_pixel(4, 4, Rgba([0, 0, 4, 255]));
        image.put_pixel(3, 2, Rgba([187, 55, 84, 255]));
        let small = brightest_of_boxes(&image, 2);
        assert_eq!(small.get_pixel(1, 1).0, [187, 55, 84, 255]);
        assert_eq!(small.get_pixel(0, 0).0, [0, 0, 4, 255]);
    }

    #[test]
    fn stacks_are_aligned_on_the_left() {
        let of = |width, height, byte| RgbaImage::from_pixel(width, height, Rgba([byte; 4]));
        let (first, second) = (of(3, 1, 10), of(2, 2, 20));
        let stack = stacked(&[&first, &second]);
        assert_eq!(stack.dimensions(), (3, 1 + 8 + 2 + 8));
        let at = |x, y| stack.get_pixel(x, y).0[0];
        assert_eq!(
            [at(0, 0), at(2, 0), at(0, 9), at(1, 10), at(2, 9)],
            [10, 10, 20, 20, 128]
        );
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, end) in [
            (0.011, 0.02),
            (0.02, 0.02),
            (3.0, 5.0),
            (7.0, 10.0),
            (1e-5, 1e-5),
        ] {
            assert!(
                (round_up(x) / end - 1.0).abs() < 1e-9,
                "{x}: {}",
                round_up(x)
            );
        }
    }

    #[test]
    fn equal_images_have_no_difference_map() {
        assert!(difference_map(&one([0.5; 4]), &one([0.5; 4])).is_none());
        let (map, end) =
            difference_map(&one([0.5; 4]), &one([0.5, 0.5, 0.5, 0.25])).expect("they differ");
        assert!((end - 0.5).abs() < 1e-12);
        assert_ne!(map.get_pixel(0, 0).0, [0, 0, 0, 255]);
    }

    #[test]
    fn shown_pixels_are_srgb_with_straight_alpha() {
        // Half covered by linear 0.216, which is 128 in sRGB: 0.108 premultiplied.
        let shown = shown(&one([0.108, 0.0, 0.5, 0.5]));
        assert_eq!(shown.get_pixel(0, 0).0, [128, 0, 255, 128]);
    }
}
