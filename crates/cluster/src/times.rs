//! The times of a picture at each rank.

use crate::exchange::Sent;

/// The times of a picture at one rank. Seconds are of the wall clock, and but for `cast` they include waiting for others; seconds of
/// processors do not count what other programs take (where the system does not tell them, they are of the wall clock).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Seconds of casting rays.
    pub cast: f64,
    /// Seconds of waiting for the last rank to have cast its rays.
    pub wait: f64,
    /// Seconds of exchanging tiles and joining them.
    pub exchange: f64,
    /// Seconds of making pixels and gathering them at rank 0.
    pub gather: f64,
    /// Bytes sent to exchange tiles.
    pub bytes: u64,
    /// Messages sent to exchange tiles, empty ones too.
    pub messages: u64,
    /// Runs sent to exchange tiles.
    pub runs: u64,
    /// Bytes of pixels sent to rank 0.
    pub pixel_bytes: u64,
    /// How many bands of rows the picture took, so that runs fit in memory.
    pub bands: u64,
    /// Runs received to exchange tiles.
    pub received_runs: u64,
    /// Seconds of processors for casting rays.
    pub cast_work: f64,
    /// Seconds of processors for writing, reading and joining tiles.
    pub exchange_work: f64,
    /// Seconds of processors for making pixels and, at rank 0, for putting those of others into the picture.
    pub gather_work: f64,
}

impl Times {
    /// Seconds after all rays are cast.
    pub fn composite(&self) -> f64 {
        self.exchange + self.gather
    }

    /// Bytes of a message with it.
    pub(crate) const BYTES: usize = 13 * 8;

    pub(crate) fn count(&mut self, sent: Sent) {
        self.bytes += sent.bytes;
        self.messages += sent.messages;
        self.runs += sent.runs;
        self.received_runs += sent.received_runs;
        self.exchange_work += sent.work;
    }

    pub(crate) fn encode(&self) -> Vec<u8> {
        let seconds = [
            self.cast,
            self.wait,
            self.exchange,
            self.gather,
            self.cast_work,
            self.exchange_work,
            self.gather_work,
        ];
        let seconds = seconds.map(f64::to_le_bytes);
        let counts = [
            self.bytes,
            self.messages,
            self.runs,
            self.pixel_bytes,
            self.bands,
            self.received_runs,
        ];
        let counts = counts.map(u64::to_le_bytes);
        seconds.into_iter().chain(counts).flatten().collect()
    }

    pub(crate) fn decode(bytes: &[u8]) -> Times {
        let (numbers, _) = bytes.as_chunks::<8>();
        let seconds = |i: usize| f64::from_le_bytes(numbers[i]);
        let count = |i: usize| u64::from_le_bytes(numbers[i]);
        Times {
            cast: seconds(0),
            wait: seconds(1),
            exchange: seconds(2),
            gather: seconds(3),
            cast_work: seconds(4),
            exchange_work: seconds(5),
            gather_work: seconds(6),
            bytes: count(7),
            messages: count(8),
            runs: count(9),
            pixel_bytes: count(10),
            bands: count(11),
            received_runs: count(12),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_are_those_that_were_sent() {
        let times = Times {
            cast: 0.1,
            wait: 0.2,
            exchange: 0.3,
            gather: 0.4,
            bytes: 5,
            messages: 6,
            runs: 7,
            pixel_bytes: 8,
            bands: 9,
            received_runs: 10,
            cast_work: 0.11,
            exchange_work: 0.12,
            gather_work: 0.13,
        };
        assert_eq!(times.encode().len(), Times::BYTES);
        assert_eq!(Times::decode(&times.encode()), times);
    }
}
