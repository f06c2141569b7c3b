//! Rectangles of the image whose fragments are sure to fit a buffer.
//!
//! A fragment is in a pixel of the box around its cell, so sums over boxes bound the
//! number of fragments before any is drawn: nothing can overflow, no fragment is
//! counted first, and the caller's encoder needs no answer from the device.

use std::ops::Range;

use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::{Error, TetMesh, View};
use tetrascope_f32::{ImagePlane, Normalization};

/// A rectangle of pixels, row 0 at the top, and bounds of the fragments in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) origin: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) most: u64,
    /// In one pixel.
    pub(crate) deepest: u64,
}

/// Columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pixels {
    columns: Range<u32>,
    rows: Range<u32>,
}

/// Tiles that cover the image, each with at most `capacity` fragments of `boxes` and, but
/// for single rows, half as many pixels.
///
/// [`Error::TooLarge`] if a single pixel may have more.
pub(crate) fn tiles(
    boxes: &[Pixels],
    (width, height): (u32, u32),
    capacity: u64,
) -> Result<Vec<Tile>, Error> {
    // Differences of neighboring rows, then sums.
    let mut fragments = vec![0_i64; height as usize + 1];
    for pixels in boxes {
        let columns = pixels.columns.len() as i64;
        let (first, end) = (pixels.rows.start as usize, pixels.rows.end as usize);
        fragments[first] += columns;
        fragments[end] -= columns;
    }
    // What is kept of a pixel takes no more than two fragments.
    let has_room = |tile: &Tile| {
        let rows = u64::from(tile.size[1]) + 1;
        2 * rows * u64::from(width) <= capacity
    };
    let mut overlaps = Overlaps::new(boxes, width);
    let mut tiles = Vec::new();
    let mut open: Option<Tile> = None;
    let mut row_fragments = 0_i64;
    for row in 0..height {
        row_fragments += fragments[row as usize];
        let most = row_fragments as u64;
        let deepest = overlaps.greatest(row);
        if most > capacity {
            tiles.extend(open.take());
            // One pixel has at most one fragment of each cell.
            let columns = capacity / deepest.max(1);
            if columns == 0 {
                return Err(Error::TooLarge {
                    what: "the list of a pixel's fragments".into(),
                    needed: deepest,
                    limit: capacity,
                    unit: "fragments",
                });
            }
            let columns = columns.min(width.into()) as u32;
            for first in (0..width).step_by(columns as usize) {
                let count = columns.min(width - first);
                tiles.push(Tile {
                    origin: [first, row],
                    size: [count, 1],
                    most: u64::from(count) * deepest,
                    deepest,
                });
            }
            continue;
        }
        match &mut open {
            Some(tile) if tile.most + most <= capacity && has_room(tile) => {
                tile.size[1] += 1;
                tile.most += most;
                tile.deepest = tile.deepest.max(deepest);
            }
            _ => {
                tiles.extend(open.take());
                open = Some(Tile {
                    origin: [0, row],
                    size: [width, 1],
                    most,
                    deepest,
                });
            }
        }
    }
    tiles.extend(open);
    Ok(tiles)
}

/// How many boxes a pixel is in, row by row from the top.
struct Overlaps<'a> {
    boxes: &'a [Pixels],
    /// The rows in which boxes begin or end, last row first, with their numbers.
    begins: Vec<(u32, u32)>,
    ends: Vec<(u32, u32)>,
    /// Differences of neighboring columns.
    columns: Vec<i64>,
}

impl Overlaps<'_> {
    fn new(boxes: &[Pixels], width: u32) -> Overlaps<'_> {
        let sorted = |row: fn(&Pixels) -> u32| {
            let mut rows: Vec<(u32, u32)> = boxes.iter().map(row).zip(0..).collect();
            rows.sort_unstable_by(|a, b| b.cmp(a));
            rows
        };
        Overlaps {
            boxes,
            begins: sorted(|pixels| pixels.rows.start),
            ends: sorted(|pixels| pixels.rows.end),
            columns: vec![0; width as usize + 1],
        }
    }

    /// The most boxes that a pixel of `row` is in; rows come in ascending order.
    fn greatest(&mut self, row: u32) -> u64 {
        for (rows, change) in [(&mut self.begins, 1), (&mut self.ends, -1)] {
            while let Some((_, number)) = rows.pop_if(|(at, _)| *at <= row) {
                let Range { start, end } = self.boxes[number as usize].columns;
                self.columns[start as usize] += change;
                self.columns[end as usize] -= change;
            }
        }
        let mut here = 0;
        let sums = self.columns.iter().map(|change| {
            here += change;
            here
        });
        sums.max().unwrap_or(0) as u64
    }
}

/// The box of pixels around each of `cells` that is in the image.
pub(crate) fn boxes(
    mesh: &TetMesh,
    cells: &[u32],
    view: &View,
    normalization: &Normalization,
) -> Vec<Pixels> {
    let screen = Screen::of(view, normalization);
    let points = mesh.points().iter();
    let points: Vec<DVec3> = points
        .map(|p| screen.camera_space(normalization.point(*p)))
        .collect();
    let corners = cells.iter().map(|c| mesh.tetrahedra()[*c as usize]);
    corners
        .filter_map(|c| screen.box_of(c.map(|p| points[p as usize])))
        .collect()
}

struct Screen {
    plane: ImagePlane,
    /// Half the image.
    half: DVec2,
    /// Pixels a unit where w is 1.
    per_unit: DVec2,
}

/// The least w that the shader draws, as in `frame`.
const NEAR: f64 = 1.0 / (1 << 22) as f64;

impl Screen {
    fn of(view: &View, normalization: &Normalization) -> Screen {
        let plane = ImagePlane::new(view, normalization);
        let half = DVec2::new(view.width.into(), view.height.into()) / 2.0;
        Screen {
            plane,
            half,
            per_unit: DVec2::splat(half.y / plane.reach[1]),
        }
    }

    /// From the eye.
    fn camera_space(&self, p: DVec3) -> DVec3 {
        let ImagePlane {
            right, up, forward, ..
        } = self.plane;
        DVec3::from([right, up, forward].map(|axis| axis.dot(p - self.plane.eye)))
    }

    /// `None` where the cell is behind the eye or out of the image.
    fn box_of(&self, p: [DVec3; 4]) -> Option<Pixels> {
        let is_perspective = self.plane.is_perspective;
        let w = p.map(|p| if is_perspective { p.z } else { 1.0 });
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut include = |p: DVec2, w: f64| {
            // Several times what the shader's f32 may lose, and the rasterizer.
            let q = p * self.per_unit / w;
            let slack = 1.0 + 1e-5 * (self.per_unit / w + q.abs());
            low = low.min(q - slack);
            high = high.max(q + slack);
        };
        for i in 0..4 {
            if w[i] > NEAR {
                include(p[i].truncate(), w[i]);
            }
            for j in 0..i {
                if (w[i] > NEAR) != (w[j] > NEAR) {
                    let cut = (NEAR - w[i]) / (w[j] - w[i]);
                    include(p[i].truncate().lerp(p[j].truncate(), cut), NEAR);
                }
            }
        }
        let range = |low: f64, high: f64, half: f64| {
            let start = (low + half).floor().clamp(0.0, 2.0 * half) as u32;
            let end = (high + half).ceil().clamp(0.0, 2.0 * half) as u32;
            start..end.max(start)
        };
        let columns = range(low.x, high.x, self.half.x);
        let rows = range(-high.y, -low.y, self.half.y);
        let seen = !columns.is_empty() && !rows.is_empty();
        seen.then_some(Pixels { columns, rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(columns: Range<u32>, rows: Range<u32>) -> Pixels {
        Pixels { columns, rows }
    }

    /// Fragments of `boxes` in `tile`, one by one.
    fn count(boxes: &[Pixels], tile: &Tile) -> u64 {
        let overlap = |a: &Range<u32>, start: u32, len: u32| {
            let end = a.end.min(start + len);
            u64::from(end.saturating_sub(a.start.max(start)))
        };
        let one = |b: &Pixels| {
            overlap(&b.columns, tile.origin[0], tile.size[0])
                * overlap(&b.rows, tile.origin[1], tile.size[1])
        };
        boxes.iter().map(one).sum()
    }

    #[test]
    fn tiles_cover_the_image_and_hold_no_more_than_fits() {
        let boxes = [
            pixels(0..10, 0..8),
            pixels(2..5, 3..4),
            pixels(2..5, 3..4),
            pixels(0..10, 3..4),
        ];
        for capacity in [4, 7, 12, 25, 40, 1000] {
            let tiles = tiles(&boxes, (10, 8), capacity).expect("a pixel has four at most");
            let mut covered = [[0; 10]; 8];
            for tile in &tiles {
                assert!(count(&boxes, tile) <= tile.most && tile.most <= capacity);
                // The deepest pixel of the image is in the row of all boxes.
                let expected = if tile.origin[1] <= 3 && 3 < tile.origin[1] + tile.size[1] {
                    4
                } else {
                    1
                };
                assert_eq!(tile.deepest, expected, "{tile:?}");
                for row in tile.origin[1]..tile.origin[1] + tile.size[1] {
                    for column in tile.origin[0]..tile.origin[0] + tile.size[0] {
                        covered[row as usize][column as usize] += 1;
                    }
                }
            }
            assert_eq!(covered, [[1; 10]; 8], "capacity {capacity}");
        }
        assert_eq!(tiles(&boxes, (10, 8), 1000).expect("all fit").len(), 1);
        let error = tiles(&boxes, (10, 8), 3).expect_err("a pixel has four");
        assert!(
            matches!(error, Error::TooLarge { needed: 4, .. }),
            "{error}"
        );
    }
}
