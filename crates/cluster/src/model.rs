//! What many ranks take, predicted from measures of few.
//!
//! The model counts what each rank does and sends on the critical path, and multiplies by what that costs on a machine:
//!
//! - Parts are compact and equal, as runs of a Hilbert curve are: one of N covers (s/N)^(2/3) of the pixels that the mesh covers,
//!   at most all, for a factor s of their shape, and gathers r runs in each.
//! - *Cast*: all runs of rays at a rank, and the cells that they pass. A ray through the mesh passes c·n^(1/3) of n cells, so that all
//!   ranks together pass as many as one rank does, whatever their number.
//! - *Exchange*: a round of k sends (k − 1)/k of what a rank holds in k − 1 messages, and joins as much as it receives. Then it holds a
//!   k-th of the tiles, of k ranks' parts, which are as one part of k/N.
//! - *Gather*: rank 0 receives the pixels that the mesh covers, 20 bytes each, in N − 1 messages.
//! - Three times a picture all ranks agree, in 2 log₂ N messages each.
//!
//! # Assumptions
//! Work is balanced, as tiles are dealt in turn and parts have as many cells; the mesh is not seen through a part of itself (no early
//! end of rays); the network carries what all ranks send at once, and a rank sends or receives at its rate. Ranks have a core each, or several:
//! seconds are those of [`Machine`].

use tetrascope_core::OpticalModel;

use crate::Exchange;
use crate::message::bytes_per_run;

/// What a machine takes for each kind of work, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// For a cell that a ray passes.
    pub cell: f64,
    /// For a run that is cast: its way to the part and out of it.
    pub run: f64,
    /// For a run that is sent or received: writing, reading, sorting and joining it.
    pub joined_run: f64,
    /// For a pixel that rank 0 receives.
    pub pixel: f64,
    /// For a message, beside its bytes.
    pub message: f64,
    /// For a byte that a rank sends or receives.
    pub byte: f64,
}

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Tetrahedra of the whole mesh.
    pub cells: f64,
    /// Pixels that the mesh covers.
    pub covered: f64,
    /// Cells that a ray through the mesh passes, in parts of the cube root of all.
    pub depth: f64,
    /// The factor s of the shape of parts: 1 for a mesh that is cut into cubes seen along an axis, and more
    /// otherwise.
    pub shape: f64,
    /// Runs for each pixel that a part covers.
    pub runs: f64,
    /// The optical model, by which a run has more or fewer bytes.
    pub model: OpticalModel,
}

/// Predictions for the ranks on the critical path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Seconds of casting rays.
    pub cast: f64,
    /// Seconds of exchanging tiles and joining them.
    pub exchange: f64,
    /// Seconds of gathering pixels at rank 0.
    pub gather: f64,
    /// Seconds of agreeing.
    pub agree: f64,
    /// Runs that a rank sends.
    pub sent_runs: f64,
    /// Bytes that a rank sends to exchange tiles.
    pub sent_bytes: f64,
    /// Messages that it sends for that.
    pub messages: f64,
}

impl Prediction {
    /// Seconds of a picture.
    pub fn seconds(&self) -> f64 {
        self.cast + self.composite()
    }

    /// Seconds after all rays are cast.
    pub fn composite(&self) -> f64 {
        self.exchange + self.gather + self.agree
    }
}

/// Bytes of a pixel that rank 0 receives, and of a tile's head.
const PIXEL: f64 = 20.0;

impl Work {
    /// Runs that a part of one in `parts` gathers.
    pub fn runs_of_part(&self, parts: f64) -> f64 {
        let share = (self.shape / parts).powf(2.0 / 3.0).min(1.0);
        // The whole is one run for each pixel, or more where it has holes.
        self.covered * share * self.runs
    }

    /// What so many ranks take.
    pub fn predict(&self, machine: &Machine, exchange: &Exchange) -> Prediction {
        let ranks: usize = exchange.factors().iter().product();
        let all = ranks as f64;
        let own = self.runs_of_part(all);
        let passed = self.covered * self.runs * self.depth * self.cells.cbrt() / all;
        let mut prediction = Prediction {
            cast: machine.cell * passed + machine.run * own,
            exchange: 0.0,
            gather: 0.0,
            agree: 3.0 * 2.0 * all.log2() * machine.message,
            sent_runs: 0.0,
            sent_bytes: 0.0,
            messages: 0.0,
        };
        let bytes = bytes_per_run(self.model) as f64;
        // Ranks whose parts a rank has joined, which is also one over its share of the tiles.
        let mut joined = 1.0;
        for &k in exchange.factors() {
            let k = k as f64;
            let held = self.runs_of_part(all / joined) / joined;
            let sent = held * (k - 1.0) / k;
            prediction.sent_runs += sent;
            prediction.messages += k - 1.0;
            // As much is received as is sent.
            prediction.exchange += (k - 1.0) * machine.message
                + 2.0 * sent * bytes * machine.byte
                + 2.0 * sent * machine.joined_run;
            joined *= k;
        }
        prediction.sent_bytes = prediction.sent_runs * bytes;
        if ranks > 1 {
            let received = self.covered * (all - 1.0) / all;
            prediction.gather =
                (all - 1.0) * machine.message + received * (PIXEL * machine.byte + machine.pixel);
        }
        prediction
    }
}
