//! Ranks that are processes, connected by MPI.

use mpi::Threading;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination as _, Source as _};
use mpi::request::multiple_scope;
use mpi::topology::{Communicator as _, SimpleCommunicator};

use crate::{Communicator, Failure};

/// This process among those that `mpirun` has started; alone if it has not. MPI ends when it is dropped.
pub struct Mpi {
    world: SimpleCommunicator,
    // Behind `world`: what is declared last is dropped last.
    _universe: Universe,
}

/// The most bytes of one MPI message, whose length is an `i32`. A longer message goes in several.
const MOST: usize = 1 << 30;

impl Mpi {
    /// Starts MPI; `None` if it was started before. From then on a panic in any thread ends all ranks, with one line that names this one:
    /// while it unwinds, MPI would wait for the others.
    pub fn start() -> Option<Mpi> {
        // Threads that draw do not call MPI, but for the one that panics.
        let (universe, _) = mpi::initialize_with_threading(Threading::Serialized)?;
        let world = universe.world();
        std::panic::set_hook(Box::new(|panic| {
            let world = SimpleCommunicator::world();
            let message = panic.to_string().replace('\n', " ");
            eprintln!(
                "error: rank {} of {}: {message}",
                world.rank(),
                world.size()
            );
            world.abort(PANICKED);
        }));
        Some(Mpi {
            world,
            _universe: universe,
        })
    }
}

/// The exit code after a panic, as Rust's own.
const PANICKED: i32 = 101;

impl Communicator for Mpi {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    /// Errors of MPI end all ranks, as is its default.
    fn exchange(&self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Result<Vec<Vec<u8>>, Failure> {
        // First the length, and then as many messages as it takes.
        let sent: Vec<(usize, [u8; 8], &[u8])> = to
            .iter()
            .map(|(rank, bytes)| (*rank, (bytes.len() as u64).to_le_bytes(), &bytes[..]))
            .collect();
        let parts = |bytes: &[u8]| 1 + bytes.len().div_ceil(MOST);
        let count = sent.iter().map(|(.., bytes)| parts(bytes)).sum();
        let received = multiple_scope(count, |scope, requests| {
            for (rank, length, bytes) in &sent {
                let process = self.world.process_at_rank(*rank as i32);
                requests.add(process.immediate_send(scope, &length[..]));
                for part in bytes.chunks(MOST) {
                    requests.add(process.immediate_send(scope, part));
                }
            }
            let receive = |&rank: &usize| {
                let process = self.world.process_at_rank(rank as i32);
                let mut length = [0; 8];
                process.receive_into(&mut length[..]);
                let mut bytes = vec![0; u64::from_le_bytes(length) as usize];
                for part in bytes.chunks_mut(MOST) {
                    process.receive_into(part);
                }
                bytes
            };
            let received = from.iter().map(receive).collect();
            requests.wait_all(&mut Vec::new());
            received
        });
        Ok(received)
    }
}
