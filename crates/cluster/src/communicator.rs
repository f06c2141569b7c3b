//! How ranks talk to each other.

use crate::Failure;

/// One rank's end of the connections between all ranks.
pub trait Communicator {
    /// The number of this rank, from 0.
    fn rank(&self) -> usize;

    /// How many ranks there are.
    fn size(&self) -> usize;

    /// Sends bytes to other ranks, and returns what ranks send to this one, in the order of `from`.
    ///
    /// A rank is named at most once in each list, and this rank in none. What a rank sends to another is received in the order
    /// in which it is sent, and each call receives one message from each of `from`, so that a message that is sent has to be
    /// asked for. Sending does not wait for the receiver.
    ///
    /// # Errors
    /// A rank that is gone.
    fn exchange(&self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Result<Vec<Vec<u8>>, Failure>;
}
