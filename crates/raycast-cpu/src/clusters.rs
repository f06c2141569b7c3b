//! Tetrahedral meshes in clusters, of which few have to be in memory at a time.
//!
//! 1. `seen` tells, without reading it, whether and where a cluster may be seen.
//! 2. `kept` reads clusters, packs them for `mesh`, and keeps what there is memory for.
//! 3. `runs` puts what rays gather in one cluster after another together, pixel by pixel.
//! 4. Here are the frames, drawn in bands of rows where the runs of all would take too much memory.
//!
//! Clusters come front to back by the distances of their boxes, as then most runs of a ray are joined at
//! once and what is covered is not read. The picture needs no such order, and there may be none: a ray can leave a
//! cluster and come back.

mod kept;
mod runs;
mod seen;

use std::ops::Range;
use std::sync::Mutex;

use rayon::prelude::*;
use tetrascope_core::clusters::MeshClusters;
use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;
use tetrascope_core::{Appearance, Error, Frame, FrameStats, Stop, View};
use tetrascope_f32::{Domain, Normalization, Rays, ScalarMap};

use crate::counters::{
    CLUSTERS_COVERED, CLUSTERS_DRAWN, CLUSTERS_HIDDEN, CLUSTERS_OUTSIDE, CLUSTERS_READ,
};
use crate::mesh::{Counts, side};
use crate::options::RaycastCpuOptions;
use crate::segments::{PathSegment, PathSegments};
use kept::Kept;
pub use runs::{Run, Tile};
use seen::{Look, Sight};

/// Clusters that are drawn side by side. What is covered is looked at before each batch.
const BATCH: usize = 4;

/// A mesh in clusters, in a look.
#[derive(Debug)]
pub(crate) struct Caster {
    clusters: MeshClusters,
    appearance: Appearance,
    /// With the domain that all clusters share.
    options: RaycastCpuOptions,
    domain: Domain,
    map: ScalarMap,
    kept: Mutex<Kept>,
}

/// Counts of a frame's clusters.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    drawn: u64,
    read: u64,
    hidden: u64,
    outside: u64,
    covered: u64,
}

impl Caster {
    pub(crate) fn new(
        clusters: &MeshClusters,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Result<Caster, Error> {
        let own = Domain {
            bounds: clusters.bounds(),
            scalar_range: clusters.scalar_range(),
        };
        let domain = own.within(options.domain)?;
        let options = RaycastCpuOptions {
            domain: Some(domain),
            ..options.clone()
        };
        let kept = Kept::new(clusters, options.memory)?;
        Ok(Caster {
            clusters: clusters.clone(),
            appearance: appearance.clone(),
            map: ScalarMap::of_appearance(appearance, domain.scalar_range),
            options,
            domain,
            kept: Mutex::new(kept),
        })
    }

    /// Another look; clusters that are kept stay if their scalars suit it.
    pub(crate) fn restyle(&mut self, appearance: &Appearance) {
        let range = self.domain.scalar_range;
        let kept = self
            .kept
            .get_mut()
            .expect("no frame panics while it is held");
        match self.map.suits_appearance(appearance, range) {
            true => kept.restyle(appearance),
            false => {
                kept.clear();
                self.map = ScalarMap::of_appearance(appearance, range);
            }
        }
        self.appearance = appearance.clone();
    }

    /// Draws a valid view; each ray ends where `ends` says, world units, one per pixel.
    pub(crate) fn draw(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        stop: &Stop,
    ) -> Result<Frame, Error> {
        let model = self.appearance.optical_model;
        let background = view.premultiplied_background();
        let (width, height) = (view.width as usize, view.height as usize);
        let nothing = over(model, DVec3::ZERO, 0.0, background);
        let mut pixels = vec![nothing.map(|value| value as f32); width * height];
        let mut depths = vec![f32::INFINITY; width * height];
        let mut tally = Tally::default();
        let mut counts = Counts::default();
        let sights = self.sights(view, &mut tally);
        let rows = 0..height.div_ceil(side(view));
        let mut bands = vec![rows];
        while let Some(band) = bands.pop() {
            let mut of_band = (Tally::default(), Counts::default());
            let room = self.room_of_runs();
            let Some(tiles) =
                self.tiles(view, ends, &sights, band.clone(), room, &mut of_band, stop)?
            else {
                // Too many runs at once: the upper half, and then the lower.
                let middle = band.start + band.len() / 2;
                bands.extend([middle..band.end, band.start..middle]);
                continue;
            };
            tally += of_band.0;
            counts += of_band.1;
            for tile in &tiles {
                for (pixel, color, depth) in tile.pixels(view) {
                    let at = tile.place(pixel);
                    pixels[at] = color;
                    depths[at] = depth;
                }
            }
        }
        let mut stats = FrameStats::default();
        counts.tell(&mut stats);
        tally.tell(&mut stats);
        let kept = self.kept.lock().expect("no frame panics while it is held");
        stats.bytes_resident = kept.bytes();
        Ok(Frame {
            depths: Some(depths),
            ..Frame::new((view.width, view.height), pixels, stats)
        })
    }

    /// The paths of a valid view: of what a process has of a mesh, joined as far as they meet.
    pub(crate) fn segments(&self, view: &View, stop: &Stop) -> Result<PathSegments, Error> {
        let model = self.appearance.optical_model;
        let sights = self.sights(view, &mut Tally::default());
        let rows = 0..(view.height as usize).div_ceil(side(view));
        let mut counts = Default::default();
        let tiles = self.tiles(view, None, &sights, rows, u64::MAX, &mut counts, stop)?;
        let mut segments = Vec::new();
        for tile in tiles.iter().flatten() {
            tile.for_each_pixel(|at, runs| {
                segments.extend(runs.iter().map(|run| {
                    let segment = PathSegment {
                        near: run.near,
                        far: run.far,
                        transmittance: run.transmittance,
                        light: run.light.as_vec3().to_array(),
                    };
                    (at as u32, segment)
                }));
            });
        }
        Ok(PathSegments::new(view, model, segments))
    }

    /// The tiles of some rows of a valid view; `None` if that takes more than one row and more than `room` bytes of runs.
    pub(crate) fn tiles_of(
        &self,
        view: &View,
        rows: Range<usize>,
        room: u64,
        stop: &Stop,
    ) -> Result<Option<(Vec<Tile>, FrameStats)>, Error> {
        let mut tally = Tally::default();
        let sights = self.sights(view, &mut tally);
        if rows.start > 0 {
            tally = Tally::default(); // what is not seen is counted once, with the first rows
        }
        let mut of_rows = (tally, Counts::default());
        let tiles = self.tiles(view, None, &sights, rows, room, &mut of_rows, stop)?;
        let (tally, counts) = of_rows;
        Ok(tiles.map(|tiles| {
            let mut stats = FrameStats::default();
            counts.tell(&mut stats);
            tally.tell(&mut stats);
            (tiles, stats)
        }))
    }

    /// The clusters that may be seen, front to back.
    fn sights(&self, view: &View, tally: &mut Tally) -> Vec<Sight> {
        let normalization = Normalization::of(&self.domain.bounds);
        let rays = Rays::new(view, &normalization);
        let look = Look::new(&self.appearance, &self.map, &normalization);
        let mut sights = Vec::new();
        for (number, cluster) in self.clusters.source().clusters().iter().enumerate() {
            if !look.shows(cluster) {
                tally.hidden += 1;
                continue;
            }
            let sight = Sight::of(
                number,
                cluster,
                &self.appearance,
                view,
                &rays,
                &normalization,
            );
            match sight {
                Some(sight) => sights.push(sight),
                None => tally.outside += 1,
            }
        }
        sights.sort_by(|a, b| a.near.total_cmp(&b.near).then(a.cluster.cmp(&b.cluster)));
        sights
    }

    /// Bytes of the runs that may be there at once.
    fn room_of_runs(&self) -> u64 {
        self.options.memory / 8
    }

    /// Draws clusters in some rows of blocks; `None` if that takes more than one row and more than `room`
    /// bytes of runs.
    #[expect(
        clippy::too_many_arguments,
        reason = "two callers, each with what differs"
    )]
    fn tiles(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        sights: &[Sight],
        rows: Range<usize>,
        room: u64,
        (tally, counts): &mut (Tally, Counts),
        stop: &Stop,
    ) -> Result<Option<Vec<Tile>>, Error> {
        let side = side(view);
        let size = [view.width as usize, view.height as usize];
        let across = size[0].div_ceil(side);
        let blocks = rows.start * across..rows.end * across;
        let mut tiles: Vec<Tile> = blocks
            .map(|block| Tile::new(&self.appearance, &self.options, size, side, block))
            .collect();
        let batch = self
            .kept
            .lock()
            .expect("no frame panics while it is held")
            .batch(BATCH);
        for sights in sights.chunks(batch) {
            stop.check()?;
            let mut wanted = Vec::new();
            for sight in sights.iter().filter(|sight| sight.is_in(&rows, side)) {
                let under = sight.blocks(&rows, side, across);
                match under.into_iter().all(|tile| tiles[tile].covers(sight.near)) {
                    true => tally.covered += 1,
                    false => wanted.push(sight.cluster),
                }
            }
            let cast = wanted.par_iter().map(|&cluster| {
                let (part, is_new) = self.part(cluster)?;
                let blocks = part.paths(view, ends, rows.clone(), stop)?;
                Ok((cluster, part, is_new, blocks))
            });
            let cast = cast.collect::<Result<Vec<_>, Error>>()?;
            tiles.par_iter_mut().enumerate().for_each(|(index, tile)| {
                // One after another, whatever the batch: so sums are the same.
                for (.., blocks) in &cast {
                    if let Some(block) = blocks.get(index) {
                        tile.add(&block.segments);
                    }
                }
            });
            let mut kept = self.kept.lock().expect("no frame panics while it is held");
            for (cluster, part, is_new, blocks) in cast {
                tally.drawn += 1;
                tally.read += u64::from(is_new);
                for block in blocks {
                    *counts += block.counts;
                }
                kept.keep(cluster, part);
            }
            drop(kept);
            let bytes: u64 = tiles.iter().map(Tile::bytes).sum();
            if bytes > room && rows.len() > 1 {
                return Ok(None);
            }
        }
        Ok(Some(tiles))
    }

    /// A cluster, packed, and whether it was read for that.
    fn part(&self, cluster: usize) -> Result<(kept::Part, bool), Error> {
        let kept = self.kept.lock().expect("no frame panics while it is held");
        if let Some(part) = kept.get(cluster) {
            return Ok((part, false));
        }
        drop(kept);
        let mesh = self.clusters.source().read(cluster)?;
        let part = crate::mesh::Caster::with_map(&mesh, &self.appearance, &self.options, self.map)?;
        Ok((part.into(), true))
    }
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, more: Tally) {
        self.drawn += more.drawn;
        self.read += more.read;
        self.hidden += more.hidden;
        self.outside += more.outside;
        self.covered += more.covered;
    }
}

impl Tally {
    fn tell(&self, stats: &mut FrameStats) {
        stats.count(CLUSTERS_DRAWN, self.drawn);
        stats.count(CLUSTERS_READ, self.read);
        stats.count(CLUSTERS_HIDDEN, self.hidden);
        stats.count(CLUSTERS_OUTSIDE, self.outside);
        stats.count(CLUSTERS_COVERED, self.covered);
    }
}
