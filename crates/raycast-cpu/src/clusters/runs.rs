//! The segments that rays have gathered so far, in runs without a gap.
//!
//! Compositing is associative: a segment that begins where another ends is joined to it, and then the
//! two are one. So a ray has as many runs as it has stretches in the clusters that were drawn so far; in the
//! models in which order does not matter, one.

use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;
use tetrascope_core::{Appearance, OpticalModel, View};

use crate::mesh::{least_transmittance, side};
use crate::options::RaycastCpuOptions;
use crate::segments::PathSegment;

/// The light of a stretch of a ray without a gap: of [`PathSegment`]s that were joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// The place of the ray's pixel in its tile, row by row.
    pub pixel: u32,
    /// Where the stretch begins, world units from where the ray starts; where it meets a surface, if it does.
    pub near: f64,
    /// Where it ends.
    pub far: f64,
    /// Light of the stretch alone, linear RGB; the greatest color in the model `MaximumIntensity`.
    pub light: DVec3,
    /// How much of the light behind gets through; 1 where the model does not absorb, 0 behind a surface.
    pub transmittance: f64,
}

/// The runs of a block of pixels, which is square unless the image ends in it.
#[derive(Clone, Debug)]
pub struct Tile {
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

    /// The tile with this number of a view's picture, row by row, without runs.
    ///
    /// # Panics
    /// If the picture has not so many tiles ([`Tile::grid`]).
    pub fn blank(
        appearance: &Appearance,
        options: &RaycastCpuOptions,
        view: &View,
        number: usize,
    ) -> Tile {
        let [across, down] = Tile::grid(view);
        assert!(number < across * down, "tile {number} of {across}x{down}");
        let size = [view.width as usize, view.height as usize];
        Tile::new(appearance, options, size, side(view), number)
    }

    /// How many tiles a view's picture has from left to right, and from top to bottom.
    pub fn grid(view: &View) -> [usize; 2] {
        [view.width, view.height].map(|size| (size as usize).div_ceil(side(view)))
    }

    /// The runs, by pixel, and front to back in each.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// How many pixels it has.
    pub fn pixel_count(&self) -> usize {
        (self.columns[1] - self.columns[0]) * (self.rows[1] - self.rows[0])
    }

    /// Where a pixel of the tile is in the image, row by row.
    pub fn place(&self, pixel: usize) -> usize {
        let width = self.columns[1] - self.columns[0];
        let (column, row) = (pixel % width, pixel / width);
        (self.rows[0] + row) * self.image_width + self.columns[0] + column
    }

    /// Adds runs of other parts of the mesh in the same look, in any order, and joins those that meet. What is
    /// behind a run that lets nothing through is dropped.
    ///
    /// # Panics
    /// If a run is of a pixel that the tile does not have.
    pub fn add_runs(&mut self, runs: impl IntoIterator<Item = Run>) {
        let old = self.runs.len();
        self.runs.extend(runs);
        let count = self.pixel_count();
        let has = |run: &Run| (run.pixel as usize) < count;
        assert!(self.runs[old..].iter().all(has), "runs of another tile");
        if self.runs.len() > old {
            self.sort_and_join();
        }
    }

    /// Each pixel that has runs, with its light before the background of `view` (premultiplied linear RGBA), and with the
    /// distance of the isosurface there, infinite where there is none.
    pub fn pixels(&self, view: &View) -> impl Iterator<Item = (usize, [f32; 4], f32)> {
        let background = view.premultiplied_background();
        let of_pixel = self.runs.chunk_by(|a, b| a.pixel == b.pixel);
        of_pixel.map(move |runs| {
            let (light, depth) = together(self.model, runs);
            let color = over(self.model, light, depth, background).map(|value| value as f32);
            (runs[0].pixel as usize, color, surface(self.model, runs))
        })
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
        self.sort_and_join();
    }

    fn sort_and_join(&mut self) {
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
        if closed_pixels == self.pixel_count() {
            self.covered = farthest;
        }
    }

    /// Whether nothing shows of what is at least so far away.
    pub(super) fn covers(&self, near: f64) -> bool {
        near >= self.covered
    }

    /// Calls `each` with the place in the image of each pixel that has runs, and with these.
    pub(super) fn for_each_pixel(&self, mut each: impl FnMut(usize, &[Run])) {
        for runs in self.runs.chunk_by(|a, b| a.pixel == b.pixel) {
            each(self.place(runs[0].pixel as usize), runs);
        }
    }

    /// Bytes of the runs in memory.
    pub fn bytes(&self) -> u64 {
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
fn together(model: OpticalModel, runs: &[Run]) -> (DVec3, f64) {
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
fn surface(model: OpticalModel, runs: &[Run]) -> f32 {
    match (model, runs) {
        (OpticalModel::Isosurfaces, [first, ..]) => first.near as f32,
        _ => f32::INFINITY,
    }
}
