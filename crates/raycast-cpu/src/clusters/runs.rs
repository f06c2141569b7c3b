//! The segments that rays have gathered so far, in runs without a gap.
//!
//! Compositing is associative: a segment that begins where another ends is joined to it, and then the
//! two are one. So a ray has as many runs as it has stretches in the clusters that were drawn so far; in the
//! models in which order does not matter, one.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Appearance, OpticalModel};

use crate::mesh::least_transmittance;
use crate::options::RaycastCpuOptions;
use crate::segments::PathSegment;

/// The light of a stretch of a ray; its fields are those of a [`PathSegment`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// The place in its tile, row by row.
    pixel: u32,
    pub(super) near: f64,
    pub(super) far: f64,
    pub(super) light: DVec3,
    pub(super) transmittance: f64,
}

/// The runs of a block of pixels.
#[derive(Debug)]
pub(super) struct Tile {
    model: OpticalModel,
    /// Nothing shows behind a run that lets less light through.
    least: f64,
    columns: [usize; 2],
    rows: [usize; 2],
    image_width: usize,
    /// By pixel, and front to back.
    runs: Vec<Run>,
    /// Nothing shows behind this distance in any pixel.
    covered: f64,
}

impl Tile {
    /// A block without runs of an image of this size.
    pub(super) fn new(
        appearance: &Appearance,
        options: &RaycastCpuOptions,
        [width, height]: [usize; 2],
        side: usize,
        block: usize,
    ) -> Tile {
        let across = width.div_ceil(side);
        let (x, y) = (block % across * side, block / across * side);
        Tile {
            model: appearance.optical_model,
            least: least_transmittance(appearance, options).into(),
            columns: [x, (x + side).min(width)],
            rows: [y, (y + side).min(height)],
            image_width: width,
            runs: Vec::new(),
            covered: f64::INFINITY,
        }
    }

    /// Adds a cluster's segments, each with the place of its pixel in the block.
    pub(super) fn add(&mut self, segments: &[(u32, PathSegment)]) {
        if segments.is_empty() {
            return;
        }
        let surfaces = self.model == OpticalModel::Isosurfaces;
        let shows = |segment: &PathSegment| !surfaces || segment.transmittance == 0.0;
        let new = segments.iter().filter(|(_, segment)| shows(segment));
        self.runs.extend(new.map(|&(pixel, segment)| Run {
            pixel,
            near: segment.near,
            far: segment.far,
            light: DVec3::from(segment.light.map(f64::from)),
            transmittance: segment.transmittance,
        }));
        self.runs.sort_by(|a, b| {
            let ends = a.near.total_cmp(&b.near).then(a.far.total_cmp(&b.far));
            a.pixel.cmp(&b.pixel).then(ends)
        });
        self.join();
    }

    /// Joins runs that meet, and drops those that are covered.
    fn join(&mut self) {
        let mut count = 0_usize;
        // Pixels in which nothing shows behind some distance, and the greatest of these.
        let (mut closed_pixels, mut farthest) = (0, 0.0_f64);
        let mut closed = f64::INFINITY;
        for i in 0..self.runs.len() {
            let run = self.runs[i];
            let before = count.checked_sub(1).map(|last| self.runs[last]);
            let before = before.filter(|before| before.pixel == run.pixel);
            if before.is_none() {
                closed = f64::INFINITY;
            }
            if run.near >= closed {
                continue;
            }
            let joined = before.and_then(|before| before.joined(&run, self.model));
            let run = match joined {
                Some(run) => {
                    count -= 1;
                    run
                }
                None => run,
            };
            self.runs[count] = run;
            count += 1;
            let end = match self.model {
                OpticalModel::Isosurfaces => Some(run.near),
                OpticalModel::EmissionAbsorption if run.transmittance < self.least => Some(run.far),
                _ => None,
            };
            if let Some(end) = end {
                closed_pixels += usize::from(closed == f64::INFINITY);
                closed = closed.min(end);
                farthest = farthest.max(closed);
            }
        }
        self.runs.truncate(count);
        let pixels = (self.columns[1] - self.columns[0]) * (self.rows[1] - self.rows[0]);
        if closed_pixels == pixels {
            self.covered = farthest;
        }
    }

    /// Whether nothing shows of what is at least so far away.
    pub(super) fn covers(&self, near: f64) -> bool {
        near >= self.covered
    }

    /// Calls `each` with the place in the image of each pixel that has runs, and with these.
    pub(super) fn for_each_pixel(&self, mut each: impl FnMut(usize, &[Run])) {
        let width = self.columns[1] - self.columns[0];
        for runs in self.runs.chunk_by(|a, b| a.pixel == b.pixel) {
            let place = runs[0].pixel as usize;
            let (column, row) = (place % width, place / width);
            let at = (self.rows[0] + row) * self.image_width + self.columns[0] + column;
            each(at, runs);
        }
    }

    /// Bytes of the runs.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(&self.runs[..]) as u64
    }
}

impl Run {
    /// This and `behind` as one, unless something may be in between.
    fn joined(&self, behind: &Run, model: OpticalModel) -> Option<Run> {
        let light = match model {
            // Where order matters, an end is the next one's beginning, to the last bit.
            OpticalModel::EmissionAbsorption if self.far != behind.near => return None,
            OpticalModel::Isosurfaces => return Some(*self),
            OpticalModel::MaximumIntensity => self.light.max(behind.light),
            _ => self.light + self.transmittance * behind.light,
        };
        Some(Run {
            pixel: self.pixel,
            near: self.near,
            far: self.far.max(behind.far),
            light,
            transmittance: self.transmittance * behind.transmittance,
        })
    }
}

/// Light and optical depth of a ray's runs, front to back.
pub(super) fn together(model: OpticalModel, runs: &[Run]) -> (DVec3, f64) {
    let (mut light, mut transmittance) = (DVec3::ZERO, 1.0);
    for run in runs {
        light = match model {
            OpticalModel::MaximumIntensity => light.max(run.light),
            _ => light + transmittance * run.light,
        };
        transmittance *= run.transmittance;
    }
    // −ln 1 is −0.
    (light, -f64::ln(transmittance) + 0.0)
}

/// How far the isosurface is that a ray meets, world units.
pub(super) fn surface(model: OpticalModel, runs: &[Run]) -> f32 {
    match (model, runs) {
        (OpticalModel::Isosurfaces, [first, ..]) => first.near as f32,
        _ => f32::INFINITY,
    }
}
