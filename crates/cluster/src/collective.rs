//! Steps that all ranks take together: gather, tell, agree. Each takes as many steps as the number of ranks has bits.

use tetrascope_core::Error;

use crate::{Communicator, Failure};

/// The bytes of all ranks by rank, at rank 0; `None` at the others.
///
/// # Errors
/// A rank that is gone.
pub fn gather(ranks: &impl Communicator, own: Vec<u8>) -> Result<Option<Vec<Vec<u8>>>, Failure> {
    let (rank, size) = (ranks.rank(), ranks.size());
    // Parts of the ranks from this one on, by rank.
    let mut held = vec![own];
    let mut step = 1;
    while step < size {
        if rank & step != 0 {
            ranks.exchange(vec![(rank - step, pack(&held))], &[])?;
            return Ok(None);
        }
        if rank + step < size {
            for bytes in ranks.exchange(Vec::new(), &[rank + step])? {
                held.extend(unpack(&bytes));
            }
        }
        step *= 2;
    }
    Ok(Some(held))
}

/// The bytes of rank 0, at every rank; those of others do not matter.
///
/// # Errors
/// A rank that is gone.
pub fn broadcast(ranks: &impl Communicator, bytes: Vec<u8>) -> Result<Vec<u8>, Failure> {
    let (rank, size) = (ranks.rank(), ranks.size());
    let mut step = match rank {
        0 => size.next_power_of_two(),
        _ => 1 << rank.trailing_zeros(),
    };
    let mut bytes = bytes;
    if rank > 0 {
        bytes = ranks.exchange(Vec::new(), &[rank - step])?.remove(0);
    }
    while step > 1 {
        step /= 2;
        if rank + step < size {
            ranks.exchange(vec![(rank + step, bytes.clone())], &[])?;
        }
    }
    Ok(bytes)
}

/// The bytes of all ranks by rank, at every rank.
///
/// # Errors
/// A rank that is gone.
pub fn all_gather(ranks: &impl Communicator, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Failure> {
    let held = gather(ranks, own)?;
    let packed = held.map_or(Vec::new(), |held| pack(&held));
    broadcast(ranks, packed).map(|packed| unpack(&packed))
}

/// Waits until all ranks have come so far, and ends the work of all if one of them failed.
///
/// # Errors
/// At every rank, that of the first rank that failed; a rank that is gone.
pub fn agree<T>(ranks: &impl Communicator, result: Result<T, Error>) -> Result<T, Failure> {
    let (rank, size) = (ranks.rank(), ranks.size());
    let own = match &result {
        Ok(_) => Vec::new(),
        Err(error) => Failure::new(rank, size, error).encode(),
    };
    let all = all_gather(ranks, own)?;
    let failed = all.iter().position(|bytes| !bytes.is_empty());
    match (failed, result) {
        (None, Ok(value)) => Ok(value),
        (Some(rank), _) => Err(Failure {
            everywhere: all.iter().all(|bytes| *bytes == all[rank]),
            ..Failure::decode(rank, size, &all[rank])
        }),
        (None, Err(error)) => Err(Failure::new(rank, size, &error)),
    }
}

/// Several messages as one.
fn pack(parts: &[Vec<u8>]) -> Vec<u8> {
    let length: usize = parts.iter().map(|part| 8 + part.len()).sum();
    let mut bytes = Vec::with_capacity(length);
    for part in parts {
        bytes.extend((part.len() as u64).to_le_bytes());
        bytes.extend(part);
    }
    bytes
}

/// The messages that [`pack`] has made one.
fn unpack(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut parts = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk() {
        let (part, rest) = rest.split_at(u64::from_le_bytes(*length) as usize);
        parts.push(part.to_vec());
        bytes = rest;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    /// So many bytes, different for each rank; rank 1 has none.
    fn bytes(rank: usize) -> Vec<u8> {
        match rank {
            1 => Vec::new(),
            _ => vec![rank as u8; 3 * rank + 1],
        }
    }

    #[test]
    fn every_number_of_ranks_gathers_and_tells() {
        for size in 1..=17 {
            let all: Vec<Vec<u8>> = (0..size).map(bytes).collect();
            let found = threads::run(size, |ranks| {
                let gathered = gather(&ranks, bytes(ranks.rank()))?;
                assert_eq!(gathered.is_some(), ranks.rank() == 0);
                let told = broadcast(&ranks, bytes(ranks.rank()))?;
                assert_eq!(told, bytes(0));
                all_gather(&ranks, bytes(ranks.rank()))
            });
            for (rank, gathered) in found.into_iter().enumerate() {
                assert_eq!(gathered.expect("nobody fails"), all, "{rank} of {size}");
            }
        }
    }

    #[test]
    fn all_hear_of_the_first_that_fails() {
        for size in [1, 2, 5, 8] {
            let found = threads::run(size, |ranks| {
                let result = match ranks.rank() {
                    0 if size > 1 => Ok(()),
                    rank => Err(Error::Invalid {
                        what: format!("piece_{rank}.vtu is bad"),
                        help: (rank < 3).then(|| "write it again".into()),
                    }),
                };
                agree(&ranks, result)
            });
            let first = usize::from(size > 1);
            for heard in found {
                let failure = heard.expect_err("a rank failed");
                assert_eq!((failure.rank, failure.ranks), (first, size));
                assert_eq!(failure.everywhere, size == 1);
                assert_eq!(failure.kind, tetrascope_core::ErrorKind::Input);
                assert_eq!(failure.message, format!("piece_{first}.vtu is bad"));
                assert_eq!(failure.help.as_deref(), Some("write it again"));
            }
        }
    }
}
