//! The pictures of a page.

use std::collections::BTreeMap;

use image::RgbaImage;
use serde::Serialize;

use super::Row;
use super::numbers::scientific;
use crate::diagrams::words;
use crate::page;
use crate::picture::{SignedMap, around, mean_of_boxes, small_png, strongest_of_boxes};

/// The picture of one algorithm.
pub struct Picture {
    /// The algorithm.
    pub algorithm: String,
    /// The settings, "key=value,…".
    pub setting: String,
    /// As it is shown.
    pub image: RgbaImage,
    /// How it differs from the truth; `None` for the truth.
    pub difference: Option<Difference>,
}

/// How a picture differs from the truth.
pub struct Difference {
    /// `None` where both are equal.
    pub map: Option<SignedMap>,
    /// Column and row of the greatest difference.
    pub worst_pixel: [u32; 2],
}

/// The pictures of a report by scene and model, the truth's first where there is one.
pub type Pictures = BTreeMap<(usize, usize), Vec<Picture>>;

/// A picture on the page; images are files as `data:` addresses.
#[derive(Serialize)]
pub(super) struct ShownPicture<'a> {
    algorithm: &'a str,
    setting: &'a str,
    /// The setting in few words.
    words: String,
    is_truth: bool,
    image: String,
    /// The signed difference; `None` for the truth and for what is equal to it.
    map: Option<String>,
    /// The scale's end, "2e-5".
    end: Option<String>,
    beyond: usize,
    worst_pixel: Option<[u32; 2]>,
    /// The place of the worst pixel in the picture, in percent.
    worst_place: [f64; 2],
    /// Around the worst pixel: the truth, then the picture.
    zoom: Option<[String; 2]>,
}

/// Bytes that all pictures of a page may take, so that it stays below 4 MB with its tables.
const PICTURE_BYTES: usize = 2_900_000;

/// The least side of a picture on the page in pixels: what is smaller shows nothing.
const LEAST_SIDE: u32 = 32;

/// Pixels to each side of the worst one.
const REACH: u32 = 7;

/// All pictures for a page, made smaller where they would take more than [`PICTURE_BYTES`].
pub(super) fn shown(pictures: &Pictures) -> BTreeMap<(usize, usize), Vec<ShownPicture<'_>>> {
    let images = || pictures.values().flatten().map(|picture| &picture.image);
    let side = images().map(|i| i.width().max(i.height())).max();
    let mut factor = 1;
    loop {
        let shown: BTreeMap<_, Vec<ShownPicture>> = pictures
            .iter()
            .map(|(place, of_model)| {
                let truth = of_model.iter().find(|p| p.difference.is_none());
                let of_model = of_model.iter();
                let of_model = of_model.map(|picture| picture.shown(factor, truth));
                (*place, of_model.collect())
            })
            .collect();
        let bytes: usize = shown.values().flatten().map(ShownPicture::bytes).sum();
        if bytes <= PICTURE_BYTES || side.unwrap_or(0) / (factor + 1) < LEAST_SIDE {
            return shown;
        }
        factor += 1;
    }
}

impl ShownPicture<'_> {
    /// Whether this is a row's picture.
    pub(super) fn is_of(&self, row: &Row) -> bool {
        self.algorithm == row.algorithm && self.setting == row.setting
    }

    fn bytes(&self) -> usize {
        let images = self.map.iter().chain(self.zoom.iter().flatten());
        self.image.len() + images.map(String::len).sum::<usize>()
    }
}

impl Picture {
    /// The picture, `factor` times smaller.
    fn shown(&self, factor: u32, truth: Option<&Picture>) -> ShownPicture<'_> {
        let smaller = |image: &RgbaImage, by: fn(&RgbaImage, u32) -> RgbaImage| match factor {
            1 => address(image),
            _ => address(&by(image, factor)),
        };
        let map = (self.difference.as_ref()).and_then(|difference| difference.map.as_ref());
        let worst = self.difference.as_ref().map(|d| d.worst_pixel);
        let zoom = truth.zip(worst).filter(|_| map.is_some());
        let [width, height] = [self.image.width(), self.image.height()].map(f64::from);
        let percent = |at: u32, side: f64| 100.0 * (f64::from(at) + 0.5) / side;
        ShownPicture {
            algorithm: &self.algorithm,
            setting: &self.setting,
            words: words(&self.setting),
            is_truth: self.difference.is_none(),
            image: smaller(&self.image, mean_of_boxes),
            map: map.map(|map| smaller(&map.image, strongest_of_boxes)),
            end: map.map(|map| scientific(map.end)),
            beyond: map.map_or(0, |map| map.beyond),
            worst_pixel: worst,
            worst_place: worst.map_or([50.0; 2], |[x, y]| [percent(x, width), percent(y, height)]),
            zoom: zoom.map(|(truth, at)| {
                [truth, self].map(|picture| address(&around(&picture.image, at, REACH)))
            }),
        }
    }
}

/// A picture as a `data:` address.
fn address(image: &RgbaImage) -> String {
    page::address(&small_png(image))
}
