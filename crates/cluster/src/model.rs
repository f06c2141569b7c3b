//! Times of many ranks, predicted from measures of few.
//!
//! The model counts what the busiest rank does and sends, and multiplies by what that costs on a machine:
//!
//! - Parts are compact and have equally many cells, as runs of a Hilbert curve are: one of n covers (s/n)^(2/3) of the pixels that the mesh
//!   covers, at most all, where s says how its shape differs from a cube that is seen along an axis. It gathers one run in each.
//! - *Cast*: a ray passes d·m^(1/3) of m cells, and goes into each cluster anew. All ranks together pass as many as one does.
//! - *Exchange*: a round of k sends (k − 1)/k of the runs that a rank holds in k − 1 messages, and joins as many as come. Then it holds a
//!   k-th of its tiles, of a part that is k times as large.
//! - *Gather*: each rank makes the pixels of its tiles, and rank 0 receives those of all, in as many messages.
//! - Three times a picture all ranks agree, in 2 log₂ N messages each, one after another.
//!
//! # Assumptions
//! The mesh is without holes and so transparent that no ray ends early; tiles, which are dealt in turn, are balanced; the network carries
//! what all ranks send at once, each at its own rate; a rank has a processor of its own.

use tetrascope_core::OpticalModel;

use crate::Exchange;
use crate::message::{BYTES_PER_PIXEL, bytes_per_run};

/// Seconds that a machine takes for each kind of work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// For a cell that a ray passes.
    pub cell: f64,
    /// For a cluster that a ray goes into.
    pub cluster: f64,
    /// For a run that is sent, and for one that is received: writing or reading, sorting and joining it.
    pub run: f64,
    /// For a pixel that is made of runs.
    pub pixel: f64,
    /// For a pixel of another rank that rank 0 puts into the picture.
    pub gathered: f64,
    /// For a message, beside its bytes.
    pub message: f64,
    /// For a byte that a rank sends or receives.
    pub byte: f64,
}

impl Machine {
    /// A processor as it was measured (RESULTS.md, "Many processes"), and a network that is assumed: 5 µs for a message, and 1.7 GB/s, as ranks
    /// of that one machine have sent each other.
    pub const MEASURED: Machine = Machine {
        cell: 22e-9,
        cluster: 1.8e-6,
        run: 60e-9,
        pixel: 60e-9,
        gathered: 25e-9,
        message: 5e-6,
        byte: 6e-10,
    };
}

/// A picture to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Tetrahedra of the whole mesh.
    pub cells: f64,
    /// Tetrahedra of a cluster.
    pub cluster_cells: f64,
    /// Pixels that the mesh covers.
    pub covered: f64,
    /// Cells that a ray passes, in parts of the cube root of all: d.
    pub depth: f64,
    /// The shape of parts: s.
    pub shape: f64,
    /// How much more than the mean the busiest rank has to do, for each time that the number of ranks doubles.
    pub imbalance: f64,
    /// The optical model, by which a run has more or fewer bytes.
    pub model: OpticalModel,
}

impl Work {
    /// The data set `sphere` of a million cells as it was measured: 1024² pixels, and what a scene leaves out chosen.
    pub const SPHERE: Work = Work {
        cells: 1e6,
        cluster_cells: 65_536.0,
        covered: 646e3,
        depth: 1.08,
        shape: 1.3,
        imbalance: 0.1,
        model: OpticalModel::EmissionAbsorption,
    };

    /// Pixels in which one part of `parts` is seen.
    fn covered_by_one_of(&self, parts: f64) -> f64 {
        self.covered * (self.shape / parts.max(1.0)).powf(2.0 / 3.0).min(1.0)
    }

    /// The prediction for the ranks of an exchange.
    pub fn predict(&self, machine: &Machine, exchange: &Exchange) -> Prediction {
        let ranks = exchange.factors().iter().product::<usize>() as f64;
        let busiest = 1.0 + self.imbalance * ranks.log2();
        let cells = self.covered * self.depth * self.cells.cbrt();
        let clusters = (self.cells / self.cluster_cells).max(1.0);
        let entries = clusters * self.covered_by_one_of(clusters);
        let cast = (machine.cell * cells + machine.cluster * entries) / ranks;
        let mut found = Prediction {
            cast: busiest * cast,
            agree: 3.0 * 2.0 * ranks.log2() * machine.message,
            ..Prediction::default()
        };
        let bytes = bytes_per_run(self.model) as f64;
        // How many parts are one by now, which is also one over the share of tiles that a rank holds.
        let mut joined = 1.0;
        for &k in exchange.factors() {
            let k = k as f64;
            let held = self.covered_by_one_of(ranks / joined) / joined;
            let sent = busiest * held * (k - 1.0) / k;
            found.runs += sent;
            found.messages += k - 1.0;
            // As much is received as is sent.
            found.exchange +=
                (k - 1.0) * machine.message + 2.0 * sent * (bytes * machine.byte + machine.run);
            joined *= k;
        }
        found.bytes = found.runs * bytes;
        let others = self.covered * (ranks - 1.0) / ranks;
        found.gather = machine.pixel * self.covered / ranks
            + (ranks - 1.0) * machine.message
            + others * (BYTES_PER_PIXEL as f64 * machine.byte + machine.gathered);
        found
    }
}

/// Times and counts of the busiest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Seconds of casting rays.
    pub cast: f64,
    /// Seconds of exchanging tiles and joining them.
    pub exchange: f64,
    /// Seconds of making pixels and gathering them at rank 0.
    pub gather: f64,
    /// Seconds of agreeing.
    pub agree: f64,
    /// Runs that it sends.
    pub runs: f64,
    /// Bytes that it sends to exchange tiles.
    pub bytes: f64,
    /// Messages that it sends for that.
    pub messages: f64,
}

impl Prediction {
    /// Seconds after all rays are cast.
    pub fn composite(&self) -> f64 {
        self.exchange + self.gather + self.agree
    }

    /// Seconds of a picture.
    pub fn seconds(&self) -> f64 {
        self.cast + self.composite()
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::clusters::MeshClusters;
    use tetrascope_core::{CameraFit, Volume};
    use tetrascope_raycast_cpu::RaycastCpuOptions;
    use tetrascope_testing::{data_set, fitted, look_of};

    use super::*;
    use crate::{Communicator as _, RankRenderer, Share, threads};

    #[test]
    fn one_rank_sends_nothing_and_rounds_send_more_runs_in_fewer_messages() {
        let work = Work::SPHERE;
        let predict = |exchange: &Exchange| work.predict(&Machine::MEASURED, exchange);
        let one = predict(&Exchange::direct(1));
        assert_eq!(
            (one.exchange, one.agree, one.runs, one.messages),
            (0.0, 0.0, 0.0, 0.0)
        );
        assert!(one.gather > 0.0 && one.cast > 0.0);
        let mut before = one;
        for ranks in [2, 4, 8, 64, 512] {
            let direct = predict(&Exchange::direct(ranks));
            assert_eq!(direct.messages, ranks as f64 - 1.0);
            assert!(direct.cast < before.cast);
            before = direct;
            if ranks > 2 {
                let swap = predict(&Exchange::radix(ranks, 2).expect("2 or more"));
                assert_eq!(swap.messages, (ranks as f64).log2());
                assert!(swap.runs > direct.runs, "{ranks}");
            }
        }
    }

    /// Bytes as they are counted grow with ranks and rounds as predicted. How many there are of two ranks is not compared: where
    /// parts meet, rays go in and out of such coarse cells several times.
    #[test]
    fn bytes_grow_as_predicted() {
        let mesh = data_set("sphere", Some(5 * 12 * 12 * 12));
        let volume = Volume::Mesh(mesh.clone());
        let clusters = MeshClusters::of(&mesh, 140).expect("cut");
        let view = fitted(&volume, CameraFit::PlusIso, false, 96);
        let (appearance, options) = (look_of("sphere"), RaycastCpuOptions::default());
        let mut of_two = None;
        for ranks in [2, 4, 8] {
            for exchange in [
                Exchange::direct(ranks),
                Exchange::radix(ranks, 2).expect("2"),
            ] {
                let pictures = threads::run(ranks, |ranks| {
                    let share = Share::by_bytes(&clusters, ranks.rank(), ranks.size());
                    let share = share.expect("clusters");
                    let exchange = exchange.clone();
                    let renderer =
                        RankRenderer::new(&ranks, &share, &appearance, &options, exchange)?;
                    renderer.render(&ranks, &view)
                });
                let picture = pictures.into_iter().next().expect("a rank");
                let picture = picture.expect("drawn");
                let frame = picture.frame.expect("rank 0 has it");
                let background = frame.pixels[0];
                let covered = frame.pixels.iter().filter(|pixel| **pixel != background);
                let work = Work {
                    covered: covered.count() as f64,
                    imbalance: 0.0,
                    ..Work::SPHERE
                };
                let found = work.predict(&Machine::MEASURED, &exchange);
                let sent: u64 = picture.times.iter().map(|times| times.bytes).sum();
                let ratio = sent as f64 / ranks as f64 / found.bytes;
                let ratio = ratio / *of_two.get_or_insert(ratio);
                println!("{exchange:?}: {ratio:.2} of what is predicted");
                // The model knows no part's shape, and these are coarse.
                assert!((0.7..1.5).contains(&ratio), "{exchange:?}: {ratio}");
            }
        }
    }
}
