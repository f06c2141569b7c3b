//! The image in f64, and what is known about its errors.

use std::ops::Range;

use tetrascope_core::{Frame, FrameStats, View};

use crate::counters::{CELL_VISITS, INCONSISTENT_PIXELS};
use crate::ray::Outcome;

/// An image in f64 with an error bound for each pixel.
#[derive(Clone, Debug)]
pub struct ReferenceImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Premultiplied linear RGBA, row-major, top row first, `width * height` texels.
    pub pixels: Vec<[f64; 4]>,
    /// A bound on the absolute error of each pixel's channels, laid out as `pixels`.
    ///
    /// It holds what rounding does to the picture of the mesh as given, to first
    /// order; what the mesh does not know about the world is not in it.
    pub error_bound: Vec<f64>,
    /// In the model `Isosurfaces`: how far along its ray each pixel's surface is, world
    /// units, infinite where there is none; laid out as `pixels`.
    pub depths: Option<Vec<f64>>,
    /// Ray-cell intervals that were integrated.
    pub cell_visits: u64,
    /// Pixels in which cells overlap by more than rounding.
    pub overlapping_pixels: u64,
    /// Pixels with a gap wider than rounding and yet too thin for a hole; see
    /// [`Consistency`](crate::Consistency).
    pub cracked_pixels: u64,
    /// Pixels with either.
    pub inconsistent_pixels: u64,
    /// Bytes of the BVH and of the mesh in its order.
    pub bytes_resident: u64,
    /// Wall time, seconds.
    pub seconds: f64,
}

/// A tile's pixels, and where they go.
pub(crate) struct Part {
    columns: Range<u32>,
    rows: Range<u32>,
    /// Color, error bound and surface depth.
    pixels: Vec<([f64; 4], f64, f64)>,
    cell_visits: u64,
    overlapping: u64,
    cracked: u64,
    inconsistent: u64,
}

impl Part {
    pub(crate) fn new(
        columns: Range<u32>,
        rows: Range<u32>,
        outcomes: Vec<(Outcome, usize)>,
    ) -> Part {
        let mut part = Part {
            columns,
            rows,
            pixels: Vec::with_capacity(outcomes.len()),
            cell_visits: 0,
            overlapping: 0,
            cracked: 0,
            inconsistent: 0,
        };
        for (outcome, visits) in outcomes {
            part.pixels
                .push((outcome.pixel, outcome.error, outcome.surface_depth));
            part.cell_visits += visits as u64;
            let consistency = outcome.consistency;
            part.overlapping += u64::from(consistency.overlap);
            part.cracked += u64::from(consistency.crack);
            part.inconsistent += u64::from(consistency.overlap || consistency.crack);
        }
        part
    }
}

impl ReferenceImage {
    /// A clear image, to be filled in.
    pub(crate) fn new(view: &View, has_depths: bool) -> ReferenceImage {
        let count = view.width as usize * view.height as usize;
        ReferenceImage {
            width: view.width,
            height: view.height,
            pixels: vec![[0.0; 4]; count],
            error_bound: vec![0.0; count],
            depths: has_depths.then(|| vec![f64::INFINITY; count]),
            cell_visits: 0,
            overlapping_pixels: 0,
            cracked_pixels: 0,
            inconsistent_pixels: 0,
            bytes_resident: 0,
            seconds: 0.0,
        }
    }

    /// Puts a part in its place.
    pub(crate) fn add(&mut self, part: &Part) {
        self.cell_visits += part.cell_visits;
        self.overlapping_pixels += part.overlapping;
        self.cracked_pixels += part.cracked;
        self.inconsistent_pixels += part.inconsistent;
        let rows = part
            .rows
            .clone()
            .zip(part.pixels.chunks(part.columns.len()));
        for (row, pixels) in rows {
            let start = row as usize * self.width as usize + part.columns.start as usize;
            for (i, (pixel, error, depth)) in pixels.iter().enumerate() {
                self.pixels[start + i] = *pixel;
                self.error_bound[start + i] = *error;
                if let Some(depths) = &mut self.depths {
                    depths[start + i] = *depth;
                }
            }
        }
    }

    /// The pixel in (column, row), row 0 at the top.
    pub fn pixel(&self, column: u32, row: u32) -> [f64; 4] {
        self.pixels[row as usize * self.width as usize + column as usize]
    }

    /// The greatest of all error bounds.
    pub fn worst_error_bound(&self) -> f64 {
        self.error_bound.iter().fold(0.0, |worst, e| worst.max(*e))
    }

    /// The image rounded to f32, with statistics; the error bound includes that rounding.
    pub fn to_frame(&self) -> Frame {
        let rounded: Vec<[f32; 4]> = self.pixels.iter().map(|p| p.map(|c| c as f32)).collect();
        let worst = self.pixels.iter().zip(&rounded).zip(&self.error_bound);
        let worst = worst.map(|((exact, rounded), error)| {
            let rounding = exact.iter().zip(rounded);
            rounding.fold(0.0f64, |m, (e, r)| m.max((e - f64::from(*r)).abs())) + error
        });
        let mut stats = FrameStats::default();
        stats.cpu_seconds = self.seconds;
        stats.count(CELL_VISITS, self.cell_visits);
        stats.bytes_resident = self.bytes_resident;
        stats.error_bound = Some(worst.fold(0.0, f64::max));
        stats.count(INCONSISTENT_PIXELS, self.inconsistent_pixels);
        let mut frame = Frame::new((self.width, self.height), rounded, stats);
        let single = |depths: &Vec<f64>| depths.iter().map(|d| *d as f32).collect();
        frame.depths = self.depths.as_ref().map(single);
        frame
    }
}
