//! Ranks that are threads of one process: for tests, and to see what ranks do without MPI.

use std::sync::mpsc::{Receiver, Sender, channel};

use crate::{Communicator, Failure};

/// A thread's end of the channels between all threads, one for each pair and direction.
#[derive(Debug)]
pub struct Thread {
    rank: usize,
    /// By the rank that receives, and by the rank that sends.
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
}

impl Communicator for Thread {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Result<Vec<Vec<u8>>, Failure> {
        // A channel is closed where its other end was dropped: the thread ended.
        let lost = |rank: usize| Failure::lost(rank, self.size());
        for (rank, bytes) in to {
            self.to[rank].send(bytes).map_err(|_| lost(rank))?;
        }
        let received = from
            .iter()
            .map(|&rank| self.from[rank].recv().map_err(|_| lost(rank)));
        received.collect()
    }
}

/// Runs `work` as so many ranks at once, and returns what each returns, by rank. Where a rank panics, those that wait for
/// it hear that it is gone.
///
/// # Panics
/// If a rank panicked, once all have ended.
pub fn run<T: Send>(size: usize, work: impl Fn(Thread) -> T + Sync) -> Vec<T> {
    let mut ends: Vec<Thread> = (0..size)
        .map(|rank| Thread {
            rank,
            to: Vec::new(),
            from: Vec::new(),
        })
        .collect();
    for sender in 0..size {
        for receiver in 0..size {
            let (to, from) = channel();
            ends[sender].to.push(to);
            ends[receiver].from.push(from);
        }
    }
    std::thread::scope(|scope| {
        let threads: Vec<_> = ends
            .into_iter()
            .map(|end| scope.spawn(|| work(end)))
            .collect();
        threads
            .into_iter()
            .map(|thread| thread.join().expect("a rank panicked"))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collective::all_gather;

    #[test]
    fn a_rank_that_is_gone_is_missed_and_nobody_waits() {
        let found = run(5, |ranks| match ranks.rank() {
            2 => Ok(Vec::new()),
            _ => all_gather(&ranks, Vec::new()),
        });
        let failed = found.iter().filter(|result| result.is_err()).count();
        assert_eq!(failed, 4, "{found:?}");
        assert!(found[0].as_ref().is_err_and(|failure| failure.rank == 2));
    }

    #[test]
    #[should_panic(expected = "a rank panicked")]
    fn a_rank_that_panics_does_not_hang_the_others() {
        run(3, |ranks| match ranks.rank() {
            1 => panic!("it was to panic"),
            _ => all_gather(&ranks, Vec::new()).is_err(),
        });
    }
}
