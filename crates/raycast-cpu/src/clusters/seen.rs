//! Whether and where a cluster may be seen, told by its box and its least and greatest scalar.

use std::ops::Range;

use tetrascope_core::clusters::Cluster;
use tetrascope_core::glam::DVec2;
use tetrascope_core::{Appearance, Bounds, OpticalModel, Unit as _, View};
use tetrascope_f32::knots::knot_pairs;
use tetrascope_f32::tiles::pixels;
use tetrascope_f32::{KnotPair, Normalization, Rays, ScalarMap};

/// How much farther than it is a cluster may seem to be, normalized: rays and vertices in f32 are off by less than 2⁻¹⁹
/// (`tetrascope_f32::tiles`).
const SLACK: f64 = 1.0 / (1 << 18) as f64;

/// Scalars that show.
pub(super) struct Look {
    model: OpticalModel,
    map: ScalarMap,
    knots: Vec<KnotPair>,
    /// The values of isosurfaces, mapped.
    surfaces: Vec<f32>,
}

impl Look {
    pub(super) fn new(
        appearance: &Appearance,
        map: &ScalarMap,
        normalization: &Normalization,
    ) -> Look {
        let surfaces = appearance.isosurfaces.iter();
        Look {
            model: appearance.optical_model,
            map: *map,
            knots: knot_pairs(&appearance.transfer_function, map, normalization),
            surfaces: surfaces.map(|surface| map.scalar(surface.value)).collect(),
        }
    }

    /// Whether anything of a cluster can show, wherever it is.
    pub(super) fn shows(&self, cluster: &Cluster) -> bool {
        let Some((low, high)) = cluster.scalar_range else {
            return false;
        };
        let (low, high) = (self.map.scalar(low), self.map.scalar(high));
        if self.model == OpticalModel::Isosurfaces {
            // Met where one end is below the value and the other is not.
            return self
                .surfaces
                .iter()
                .any(|&value| low < value && value <= high);
        }
        // A scalar between two others is off by a few roundings of the greater.
        let blur = low.abs().max(high.abs()) * (1.0 / (1 << 20) as f32);
        let mut met = self.knots.iter();
        met.any(|pair| {
            let is_met = pair.low <= high + blur && low - blur <= pair.high;
            let shows = |[r, g, b, extinction]: [f32; 4]| match self.model {
                OpticalModel::MaximumIntensity => r > 0.0 || g > 0.0 || b > 0.0,
                _ => extinction > 0.0,
            };
            is_met && (shows(pair.at_low) || shows(pair.at_high))
        })
    }
}

/// A cluster that may be seen, and where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) cluster: usize,
    /// No ray meets it nearer to where it starts, world units.
    pub(super) near: f64,
    /// Columns and rows of pixels, from one up to before the other.
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Sight {
    /// `None` for a cluster beside the image, behind the eye or cut away.
    pub(super) fn of(
        number: usize,
        cluster: &Cluster,
        appearance: &Appearance,
        view: &View,
        rays: &Rays,
        normalization: &Normalization,
    ) -> Option<Sight> {
        if cluster.bounds.is_empty() {
            return None;
        }
        let corners = cluster
            .bounds
            .corners()
            .map(|corner| normalization.point(corner));
        let cut_away = appearance.clip_planes.iter().any(|plane| {
            let normal = plane.normal.unit();
            let height = normal.dot(normalization.point(plane.point));
            corners
                .iter()
                .all(|corner| normal.dot(*corner) - height < -SLACK)
        });
        let depths = corners.map(|corner| rays.depth(corner) - rays.eye_depth);
        let farthest = depths.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let margin = SLACK * (1.0 + rays.eye_depth.abs());
        if cut_away || farthest < -margin {
            return None;
        }
        let size = DVec2::new(view.width.into(), view.height.into());
        let mut seen: Option<(DVec2, DVec2)> = None;
        for face in FACES {
            let face = face.map(|i| corners[i].as_vec3());
            if let Some((min, max)) = pixels(rays, &face, size) {
                seen = Some(match seen {
                    None => (min, max),
                    Some((a, b)) => (a.min(min), b.max(max)),
                });
            }
        }
        let (min, max) = seen?;
        let min = min.floor().max(DVec2::ZERO);
        let max = (max.floor() + 1.0).min(size);
        if !min.cmplt(max).all() {
            return None;
        }
        let near = match rays.is_point {
            true => {
                let bounds = Bounds::of(corners);
                let nearest = rays.eye.clamp(bounds.min, bounds.max);
                (nearest - rays.eye).length()
            }
            false => depths.into_iter().fold(f64::INFINITY, f64::min),
        };
        Some(Sight {
            cluster: number,
            near: (near - margin) * normalization.scale,
            columns: [min.x as usize, max.x as usize],
            rows: [min.y as usize, max.y as usize],
        })
    }

    /// Whether it is in some of these rows of blocks.
    pub(super) fn is_in(&self, rows: &Range<usize>, side: usize) -> bool {
        self.rows[0] < rows.end * side && rows.start * side < self.rows[1]
    }

    /// The blocks among these rows in which it may be, numbered from the first.
    pub(super) fn blocks(&self, rows: &Range<usize>, side: usize, across: usize) -> Vec<usize> {
        let down = (self.rows[0] / side).max(rows.start)..self.rows[1].div_ceil(side).min(rows.end);
        let [left, right] = [self.columns[0] / side, self.columns[1].div_ceil(side)];
        down.flat_map(|row| (left..right).map(move |column| (row, column)))
            .map(|(row, column)| (row - rows.start) * across + column)
            .collect()
    }
}

/// Two triangles for each side of a box, by its corners.
const FACES: [[usize; 3]; 12] = [
    [0, 1, 2],
    [1, 2, 3],
    [4, 5, 6],
    [5, 6, 7],
    [0, 1, 4],
    [1, 4, 5],
    [2, 3, 6],
    [3, 6, 7],
    [0, 2, 4],
    [2, 4, 6],
    [1, 3, 5],
    [3, 5, 7],
];
