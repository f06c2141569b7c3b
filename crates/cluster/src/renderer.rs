//! A rank's renderer: its part of the mesh, and its part of the work on each picture.

use std::ops::Range;
use std::time::Instant;

use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;
use tetrascope_core::{Appearance, Error, Frame, FrameStats, OpticalModel, View, Volume};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions, Tile, counters};

use crate::busy::Work;
use crate::collective::{agree, all_gather, gather};
use crate::exchange::Exchange;
use crate::message::{pixels, put_pixel};
use crate::{Communicator, Failure, Share, Times};

/// The renderer of one rank. All ranks make it and call it together.
#[derive(Debug)]
pub struct RankRenderer {
    /// `None` where the rank has no part.
    renderer: Option<RaycastCpu>,
    appearance: Appearance,
    options: RaycastCpuOptions,
    exchange: Exchange,
}

/// A picture of all ranks, and what it took.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The picture with the counts of all ranks, at rank 0.
    pub frame: Option<Frame>,
    /// The times of each rank, by rank, at rank 0.
    pub times: Vec<Times>,
}

impl RankRenderer {
    /// The renderer of this rank's share of a mesh. `exchange` is made for as many ranks as there are; the domain of `options`
    /// is that of the share.
    ///
    /// # Errors
    /// At every rank, what [`RaycastCpu::new`] refuses at the first.
    pub fn new(
        ranks: &impl Communicator,
        share: &Share,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
        exchange: Exchange,
    ) -> Result<RankRenderer, Failure> {
        let options = RaycastCpuOptions {
            domain: Some(share.domain),
            ..options.clone()
        };
        let make = || {
            if share.own.cell_count() == 0 {
                return Ok(None);
            }
            let volume = Volume::Clusters(share.own.clone());
            RaycastCpu::new(&volume, appearance, &options).map(Some)
        };
        Ok(RankRenderer {
            renderer: agree(ranks, make())?,
            appearance: appearance.clone(),
            options,
            exchange,
        })
    }

    /// Draws a view, the same at all ranks; rank 0 gets the picture.
    ///
    /// # Errors
    /// At every rank, that of the first rank that failed.
    pub fn render(&self, ranks: &impl Communicator, view: &View) -> Result<Picture, Failure> {
        let start = Instant::now();
        let check = view.validate();
        agree(
            ranks,
            check.and_then(|()| view.check_memory(BYTES_PER_PIXEL)),
        )?;
        let mut frame = (ranks.rank() == 0).then(|| self.blank(view));
        let mut stats = FrameStats::default();
        let mut times = Times::default();
        let rows = 0..Tile::grid(view)[1];
        let mut bands = vec![rows];
        while let Some(band) = bands.pop() {
            let Some((tiles, of_band)) = self.cast(ranks, view, &band, &mut times)? else {
                // Too many runs at once at some rank: the upper half, and then the lower.
                let middle = band.start + band.len() / 2;
                bands.extend([middle..band.end, band.start..middle]);
                continue;
            };
            times.bands += 1;
            add(&mut stats, &of_band);
            let started = Instant::now();
            let model = self.appearance.optical_model;
            let (own, sent) = self.exchange.run(ranks, tiles, model)?;
            times.exchange += started.elapsed().as_secs_f64();
            times.count(sent);
            let started = Instant::now();
            self.gather(ranks, view, &own, frame.as_mut(), &mut times)?;
            times.gather += started.elapsed().as_secs_f64();
        }
        let told = gather(ranks, [times.encode(), encode_stats(&stats)].concat())?;
        let mut of_ranks = Vec::new();
        let mut all = FrameStats::default();
        for bytes in told.unwrap_or_default() {
            let (numbers, stats) = bytes.split_at(Times::BYTES);
            of_ranks.push(Times::decode(numbers));
            add(&mut all, &decode_stats(stats));
        }
        if let Some(frame) = &mut frame {
            all.cpu_seconds = start.elapsed().as_secs_f64();
            if let Some(lost @ 1..) = all.get(counters::LOST_RAYS) {
                let note = format!("{lost} rays came out of the mesh where they do not cross it");
                all.notes.push(note);
            }
            frame.stats = all;
        }
        Ok(Picture {
            frame,
            times: of_ranks,
        })
    }

    /// A picture of nothing.
    fn blank(&self, view: &View) -> Frame {
        let model = self.appearance.optical_model;
        let nothing = over(model, DVec3::ZERO, 0.0, view.premultiplied_background());
        let count = view.width as usize * view.height as usize;
        let pixels = vec![nothing.map(|value| value as f32); count];
        let has_depths = model == OpticalModel::Isosurfaces;
        Frame {
            depths: has_depths.then(|| vec![f32::INFINITY; count]),
            ..Frame::new((view.width, view.height), pixels, FrameStats::default())
        }
    }

    /// The tiles of a band of rows by their numbers; `None` if those of some rank take more than there is room for.
    #[expect(
        clippy::type_complexity,
        reason = "tiles with their numbers, and counts"
    )]
    fn cast(
        &self,
        ranks: &impl Communicator,
        view: &View,
        band: &Range<usize>,
        times: &mut Times,
    ) -> Result<Option<(Vec<(usize, Tile)>, FrameStats)>, Failure> {
        let [across, _] = Tile::grid(view);
        let numbers = band.start * across..band.end * across;
        let (started, work) = (Instant::now(), Work::start());
        let cast = self.tiles(view, band);
        times.cast += started.elapsed().as_secs_f64();
        times.cast_work += work.seconds();
        let started = Instant::now();
        let cast = agree(ranks, cast)?;
        let is_too_much = all_gather(ranks, vec![u8::from(cast.is_none())])?;
        times.wait += started.elapsed().as_secs_f64();
        if is_too_much.iter().any(|flag| *flag != [0]) {
            return Ok(None);
        }
        Ok(cast.map(|(tiles, stats)| (numbers.zip(tiles).collect(), stats)))
    }

    fn tiles(
        &self,
        view: &View,
        band: &Range<usize>,
    ) -> Result<Option<(Vec<Tile>, FrameStats)>, Error> {
        let Some(renderer) = &self.renderer else {
            let [across, _] = Tile::grid(view);
            let numbers = band.start * across..band.end * across;
            let blank = |number| Tile::blank(&self.appearance, &self.options, view, number);
            return Ok(Some((numbers.map(blank).collect(), FrameStats::default())));
        };
        renderer.tiles(view, band.clone(), self.options.memory / 8)
    }

    /// Makes pixels of the tiles that this rank owns, and puts those of all ranks into the picture.
    fn gather(
        &self,
        ranks: &impl Communicator,
        view: &View,
        own: &[(usize, Tile)],
        frame: Option<&mut Frame>,
        times: &mut Times,
    ) -> Result<(), Failure> {
        let work = Work::start();
        let has_depth = self.appearance.optical_model == OpticalModel::Isosurfaces;
        let found = own.iter().flat_map(|(_, tile)| {
            let pixels = tile.pixels(view);
            pixels.map(|(pixel, color, depth)| (tile.place(pixel), color, depth))
        });
        let Some(frame) = frame else {
            let mut bytes = Vec::new();
            found.for_each(|pixel| put_pixel(&mut bytes, pixel, has_depth));
            times.pixel_bytes += bytes.len() as u64;
            times.gather_work += work.seconds();
            return ranks.exchange(vec![(0, bytes)], &[]).map(drop);
        };
        let mut put = |(place, color, depth): (usize, [f32; 4], f32)| {
            frame.pixels[place] = color;
            if let Some(depths) = &mut frame.depths {
                depths[place] = depth;
            }
        };
        found.for_each(&mut put);
        times.gather_work += work.seconds();
        let others: Vec<usize> = (1..ranks.size()).collect();
        let received = ranks.exchange(Vec::new(), &others)?;
        let work = Work::start();
        for bytes in received {
            pixels(&bytes, has_depth).for_each(&mut put);
        }
        times.gather_work += work.seconds();
        Ok(())
    }
}

/// Bytes for a pixel of a picture and its distance, twice: as it is gathered and as it is written.
const BYTES_PER_PIXEL: u64 = 2 * (16 + 4);

/// Adds the counts of a band or a rank.
fn add(all: &mut FrameStats, more: &FrameStats) {
    for count in &more.counts {
        all.add(count.counter, count.value);
    }
    all.bytes_resident += more.bytes_resident;
}

fn encode_stats(stats: &FrameStats) -> Vec<u8> {
    let counts = counters::ALL
        .iter()
        .map(|counter| stats.get(*counter).unwrap_or(0));
    counts.flat_map(u64::to_le_bytes).collect()
}

fn decode_stats(bytes: &[u8]) -> FrameStats {
    let (numbers, _) = bytes.as_chunks::<8>();
    let mut stats = FrameStats::default();
    for (counter, number) in counters::ALL.iter().zip(numbers) {
        // Grids count others.
        if *counter != counters::CELLS_SKIPPED {
            stats.count(*counter, u64::from_le_bytes(*number));
        }
    }
    stats
}
