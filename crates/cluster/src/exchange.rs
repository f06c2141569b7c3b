//! The tiles of all ranks put together, each at the rank that owns it: tile t at rank t modulo the number of ranks.

use rayon::prelude::*;
use tetrascope_core::{Error, OpticalModel};
use tetrascope_raycast_cpu::{Run, Tile};

use crate::busy::Work;
use crate::message::{SentTile, bytes_per_run, put_tile, runs, tiles};
use crate::{Communicator, Failure};

/// The rounds in which tiles are exchanged.
///
/// In a round of k, groups of k ranks exchange all with all: each sends each other a k-th of the tiles that it holds, and
/// joins what it gets. After rounds whose k multiply to the number of ranks, each rank holds its tiles of all
/// ranks. One round of all ranks is *direct send*, and rounds of 2 are *binary swap*; between the two is *radix-k*.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    factors: Vec<usize>,
}

/// Counts of what a rank has sent in an exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sent {
    /// Messages, empty ones too.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Runs that were sent.
    pub runs: u64,
    /// Runs that were received.
    pub received_runs: u64,
    /// Seconds of processors for writing messages, and for reading and joining those of others.
    pub work: f64,
}

impl Exchange {
    /// One round, in which each rank sends to each other.
    pub fn direct(ranks: usize) -> Exchange {
        Exchange {
            factors: vec![ranks],
        }
    }

    /// Rounds of at most `k` ranks each, where `ranks` has such factors: a prime number of ranks above `k` is one round.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a `k` below 2.
    pub fn radix(ranks: usize, k: usize) -> Result<Exchange, Error> {
        if k < 2 {
            return Err(Error::Invalid {
                what: format!("rounds of {k} ranks"),
                help: Some("give 2 or more".into()),
            });
        }
        let mut factors = Vec::new();
        let mut rest = ranks.max(1);
        while rest > 1 {
            let divides = |factor: &usize| rest.is_multiple_of(*factor);
            let largest = (2..=k.min(rest)).rev().find(divides);
            // No factor is small enough: the smallest that there is.
            let factor = largest.or_else(|| (2..=rest).find(divides)).unwrap_or(rest);
            factors.push(factor);
            rest /= factor;
        }
        Ok(Exchange { factors })
    }

    /// How many ranks exchange in each round.
    pub fn factors(&self) -> &[usize] {
        &self.factors
    }

    /// Exchanges tiles, given by their numbers, which are the same tiles at all ranks; returns those that this rank owns, of all ranks.
    ///
    /// # Errors
    /// A rank that is gone.
    ///
    /// # Panics
    /// If it was made for another number of ranks.
    pub fn run(
        &self,
        ranks: &impl Communicator,
        own: Vec<(usize, Tile)>,
        model: OpticalModel,
    ) -> Result<(Vec<(usize, Tile)>, Sent), Failure> {
        let rank = ranks.rank();
        let product: usize = self.factors.iter().product();
        assert_eq!(product, ranks.size(), "an exchange of other ranks");
        let mut held = own;
        let mut sent = Sent::default();
        // Ranks of a group differ in one digit of their numbers, which counts this many ranks.
        let mut stride = 1;
        for &k in &self.factors {
            let digit = rank / stride % k;
            let member = |other: usize| rank - digit * stride + other * stride;
            let work = Work::start();
            let mut messages = vec![Vec::new(); k];
            let mut kept = Vec::with_capacity(held.len() / k + 1);
            for (number, tile) in held {
                let to = number / stride % k;
                if to == digit {
                    kept.push((number, tile));
                    continue;
                }
                sent.runs += tile.runs().len() as u64;
                put_tile(&mut messages[to], number, &tile, model);
            }
            let others = (0..k).filter(|other| *other != digit);
            let from: Vec<usize> = others.map(member).collect();
            let to: Vec<(usize, Vec<u8>)> = messages
                .into_iter()
                .enumerate()
                .filter(|(other, _)| *other != digit)
                .map(|(other, bytes)| (member(other), bytes))
                .collect();
            sent.messages += to.len() as u64;
            sent.bytes += to.iter().map(|(_, bytes)| bytes.len() as u64).sum::<u64>();
            sent.work += work.seconds();
            let received = ranks.exchange(to, &from)?;
            let work = Work::start();
            sent.received_runs += join(&mut kept, &received, model);
            sent.work += work.seconds();
            held = kept;
            stride *= k;
        }
        Ok((held, sent))
    }
}

/// Adds what other ranks have sent to the tiles that are kept, which are by number; gives how many runs that was.
fn join(kept: &mut [(usize, Tile)], received: &[Vec<u8>], model: OpticalModel) -> u64 {
    let mut sent: Vec<SentTile> = Vec::new();
    for bytes in received {
        sent.extend(tiles(bytes, model));
    }
    // Stable: of one tile, by rank.
    sent.sort_by_key(|(number, _)| *number);
    kept.par_iter_mut().for_each(|(number, tile)| {
        let first = sent.partition_point(|(other, _)| other < number);
        let of_tile = sent[first..]
            .iter()
            .take_while(|(other, _)| other == number);
        // All at once, so that they are sorted once.
        let runs: Vec<Run> = of_tile.flat_map(|(_, bytes)| runs(bytes, model)).collect();
        tile.add_runs(runs);
    });
    let bytes: usize = sent.iter().map(|(_, bytes)| bytes.len()).sum();
    (bytes / bytes_per_run(model)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_multiply_to_the_number_of_ranks() {
        for ranks in 1..=40 {
            for k in 2..=9 {
                let factors = Exchange::radix(ranks, k).expect("2 or more").factors;
                assert_eq!(factors.iter().product::<usize>(), ranks);
                for factor in factors {
                    let is_prime = (2..factor).all(|i| factor % i > 0);
                    assert!(factor <= k || is_prime, "{factor} of {ranks} by {k}");
                }
            }
        }
        assert_eq!(
            Exchange::radix(24, 4).expect("2 or more").factors(),
            [4, 3, 2]
        );
        assert_eq!(
            Exchange::radix(8, 2).expect("2 or more").factors(),
            [2, 2, 2]
        );
        assert_eq!(
            Exchange::radix(7, 2).expect("2 or more"),
            Exchange::direct(7)
        );
        assert!(Exchange::radix(7, 1).is_err());
    }
}
