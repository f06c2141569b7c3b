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

/// Levels of [`signed_map`] on each side of none: what a person tells apart, and small as a file.
const LEVELS: i32 = 15;

/// The colors of differences at none, at half of the scale and at its end: brighter than the truth in
/// red, darker in blue, as readers with color-vision deficiency tell apart (C. Brewer, "RdBu").
const NONE: [f64; 3] = [247.0, 247.0, 247.0];
const DARKER: [[f64; 3]; 2] = [[103.0, 169.0, 207.0], [5.0, 48.0, 97.0]];
const BRIGHTER: [[f64; 3]; 2] = [[239.0, 138.0, 98.0], [103.0, 0.0, 31.0]];

/// How a picture differs from the truth, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct SignedMap {
    /// For each pixel, the difference of the channel that differs most, by color.
    pub image: RgbaImage,
    /// The color scale goes from minus this to this: 1, 2 or 5 times a power of ten.
    pub end: f64,
    /// Pixels that differ by more, and have the color of the end.
    pub beyond: usize,
}

/// The light that a picture has more than the truth, or less, in false color; `None` where they are equal.
///
/// The scale ends at what 99.9 % of the pixels do not exceed, so that a few wrong ones leave the
/// rest in sight. What is not a number is beyond. Panics where the sizes differ.
pub fn signed_map(truth: &Frame, image: &Frame) -> Option<SignedMap> {
    assert_eq!((truth.width, truth.height), (image.width, image.height));
    let differences: Vec<f64> = (truth.pixels.iter().zip(&image.pixels))
        .map(|(t, p)| {
            let signed = |c: usize| match apart(t[c].into(), p[c].into()) {
                0.0 => 0.0,
                size if p[c] < t[c] => -size,
                size => size,
            };
            let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
            (0..4).map(signed).fold(0.0, largest)
        })
        .collect();
    let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let greatest = sizes.iter().rev().find(|d| d.is_finite());
    let most = (999 * sizes.len()).div_ceil(1000).max(1) - 1;
    let end = match (sizes.get(most), greatest) {
        _ if sizes.last().is_none_or(|&greatest| greatest == 0.0) => return None,
        (Some(&most), _) if most > 0.0 && most.is_finite() => round_up(most),
        (_, Some(&greatest)) if greatest > 0.0 => round_up(greatest),
        _ => 1.0,
    };
    let width = truth.width;
    Some(SignedMap {
        image: RgbaImage::from_fn(width, truth.height, |column, row| {
            signed_color(differences[row as usize * width as usize + column as usize] / end)
        }),
        end,
        beyond: sizes.iter().rev().take_while(|&&d| d > end).count(),
    })
}

/// The color of a share of the scale, from -1 to 1.
fn signed_color(share: f64) -> Rgba<u8> {
    let level = (share.clamp(-1.0, 1.0) * f64::from(LEVELS)).round() / f64::from(LEVELS);
    let [half, end] = if level < 0.0 { DARKER } else { BRIGHTER };
    let (from, to, t) = match level.abs() {
        size if size < 0.5 => (NONE, half, 2.0 * size),
        size => (half, end, 2.0 * size - 1.0),
    };
    let byte = |c: usize| (from[c] + t * (to[c] - from[c])).round() as u8;
    Rgba([byte(0), byte(1), byte(2), 255])
}

/// The signed map `factor` times smaller: of each box of pixels the one that is farthest from none, so
/// that one wrong pixel stays in sight.
pub fn strongest_of_boxes(image: &RgbaImage, factor: u32) -> RgbaImage {
    let strength = |pixel: &&Rgba<u8>| -> u32 {
        let from_none = |c: usize| (f64::from(pixel.0[c]) - NONE[c]).abs() as u32;
        (0..3).map(from_none).sum()
    };
    boxes(image, factor, |pixels| {
        *pixels
            .iter()
            .max_by_key(strength)
            .expect("a box has a pixel")
    })
}

/// The square of `2 * reach + 1` pixels around one, cut at the picture's borders.
pub fn around(image: &RgbaImage, [column, row]: [u32; 2], reach: u32) -> RgbaImage {
    let cut = |at: u32, side: u32| {
        let from = at.saturating_sub(reach).min(side.saturating_sub(1));
        (from, (at + reach + 1).min(side) - from)
    };
    let ((x, width), (y, height)) = (cut(column, image.width()), cut(row, image.height()));
    image::imageops::crop_imm(image, x, y, width, height).to_image()
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

/// One pixel for each box of `factor` pixels per side; boxes at the right and at the foot may be cut.
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

/// The image as a small PNG file, for the repository and for pages: slower to make, and without alpha
/// where it is opaque.
pub fn small_png(image: &RgbaImage) -> Vec<u8> {
    let is_opaque = image.pixels().all(|pixel| pixel.0[3] == 255);
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    let written = match is_opaque {
        true => image::DynamicImage::from(image.clone())
            .into_rgb8()
            .write_with_encoder(encoder),
        false => image.write_with_encoder(encoder),
    };
    written.expect("memory takes any image");
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
    fn differences_have_a_sign_and_a_scale_that_few_pixels_do_not_set() {
        let pixels = |change: fn(usize, &mut [f32; 4])| {
            let mut all = vec![[0.5, 0.5, 0.5, 1.0]; 4000];
            all.iter_mut().enumerate().for_each(|(i, p)| change(i, p));
            Frame::new((40, 100), all, FrameStats::default())
        };
        let truth = pixels(|_, _| ());
        assert_eq!(signed_map(&truth, &truth), None);
        // A half is darker by 2^-10 in red, 40 pixels brighter in alpha, and 3 not a number.
        let map = signed_map(
            &truth,
            &pixels(|i, p| match i {
                0..3 => p[1] = f32::NAN,
                3..43 => p[3] += 1.0 / 1024.0,
                43..2000 => p[0] -= 1.0 / 1024.0,
                _ => {}
            }),
        )
        .expect("they differ");
        assert_eq!((map.end, map.beyond), (1e-3, 3));
        let at = |i: u32| map.image.get_pixel(i % 40, i / 40).0;
        assert_eq!(at(3999), [247, 247, 247, 255]);
        assert_eq!(at(0), [103, 0, 31, 255]);
        assert!(at(5)[0] > at(5)[2] && at(100)[2] > at(100)[0]);
        // One wrong pixel alone sets the scale.
        let one = signed_map(
            &truth,
            &pixels(|i, p| p[0] += if i == 7 { 0.03 } else { 0.0 }),
        );
        assert_eq!(one.map(|map| (map.end, map.beyond)), Some((0.05, 0)));
    }

    #[test]
    fn one_wrong_pixel_stays_in_smaller_differences() {
        let mut image = RgbaImage::from_pixel(4, 4, signed_color(0.0));
        image.put_pixel(3, 2, signed_color(-0.7));
        let small = strongest_of_boxes(&image, 2);
        assert_eq!(*small.get_pixel(1, 1), signed_color(-0.7));
        assert_eq!(*small.get_pixel(0, 0), signed_color(0.0));
    }

    #[test]
    fn what_is_around_a_pixel_is_cut_at_the_border() {
        let image = RgbaImage::from_fn(20, 10, |x, y| Rgba([x as u8, y as u8, 0, 255]));
        let of = |at| {
            let part = around(&image, at, 3);
            (part.dimensions(), part.get_pixel(0, 0).0[..2].to_vec())
        };
        assert_eq!(of([10, 5]), ((7, 7), vec![7, 2]));
        assert_eq!(of([0, 9]), ((4, 4), vec![0, 6]));
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
