//! What ranks tell each other about their pieces. Numbers are little-endian.

use tetrascope_core::Bounds;
use tetrascope_core::clusters::Cluster;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_io::lists::PieceField;

use crate::collective::all_gather;
use crate::{Communicator, Failure};

/// The facts on a piece with cells that all ranks know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facts {
    pub(super) piece: usize,
    pub(super) cluster: Cluster,
    /// How many values it has.
    pub(super) values: u64,
}

impl Facts {
    const BYTES: usize = 12 * 8;

    pub(super) fn encode(&self) -> Vec<u8> {
        let Cluster {
            cells,
            points,
            bounds,
            scalar_range,
        } = self.cluster;
        let counts = [self.piece as u64, cells.into(), points.into(), self.values];
        let (low, high) = scalar_range.unwrap_or((f64::NAN, f64::NAN));
        let [min, max] = [bounds.min, bounds.max].map(|p| p.to_array());
        let floats = min.into_iter().chain(max).chain([low, high]);
        let counts = counts.into_iter().flat_map(u64::to_le_bytes);
        counts.chain(floats.flat_map(f64::to_le_bytes)).collect()
    }

    pub(super) fn decode_all(bytes: &[u8]) -> Vec<Facts> {
        let decode = |bytes: &[u8]| {
            let (numbers, _) = bytes.as_chunks::<8>();
            let count = |i: usize| u64::from_le_bytes(numbers[i]);
            let float = |i: usize| f64::from_le_bytes(numbers[i]);
            let point = |i: usize| DVec3::new(float(i), float(i + 1), float(i + 2));
            let (low, high) = (float(10), float(11));
            Facts {
                piece: count(0) as usize,
                cluster: Cluster {
                    cells: count(1) as u32,
                    points: count(2) as u32,
                    bounds: Bounds {
                        min: point(4),
                        max: point(7),
                    },
                    scalar_range: (!low.is_nan()).then_some((low, high)),
                },
                values: count(3),
            }
        };
        bytes.chunks_exact(Facts::BYTES).map(decode).collect()
    }
}

/// The numbers of a message.
pub(super) fn numbers(bytes: &[u8]) -> impl Iterator<Item = f64> {
    let (numbers, _) = bytes.as_chunks::<8>();
    numbers.iter().map(|number| f64::from_le_bytes(*number))
}

/// The fields of all pieces that have cells, by piece.
pub(super) fn all_fields(
    ranks: &impl Communicator,
    own: Vec<Option<Vec<PieceField>>>,
) -> Result<Vec<Vec<PieceField>>, Failure> {
    let mut bytes = Vec::new();
    for fields in own.into_iter().flatten() {
        bytes.extend((fields.len() as u32).to_le_bytes());
        for field in fields {
            bytes.push(u8::from(field.association == Association::Cell));
            let (low, high) = field.range.unwrap_or((f64::NAN, f64::NAN));
            bytes.extend([low, high].into_iter().flat_map(f64::to_le_bytes));
            bytes.extend((field.name.len() as u32).to_le_bytes());
            bytes.extend(field.name.as_bytes());
        }
    }
    let all = all_gather(ranks, bytes)?;
    let mut pieces = Vec::new();
    for bytes in &all {
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            let count = u32::from_le_bytes(take(&mut rest));
            let field = |_| {
                let [of_cells] = take(&mut rest);
                let low = f64::from_le_bytes(take(&mut rest));
                let high = f64::from_le_bytes(take(&mut rest));
                let length = u32::from_le_bytes(take(&mut rest)) as usize;
                let (name, after) = rest.split_at(length);
                rest = after;
                PieceField {
                    name: String::from_utf8_lossy(name).into_owned(),
                    association: match of_cells {
                        1 => Association::Cell,
                        _ => Association::Point,
                    },
                    range: (!low.is_nan()).then_some((low, high)),
                }
            };
            pieces.push((0..count).map(field).collect());
        }
    }
    Ok(pieces)
}

/// Takes bytes off the front of a message, which ranks of this program have written.
fn take<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (first, rest) = bytes.split_first_chunk().expect("a whole message");
    *bytes = rest;
    *first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facts_are_those_that_were_sent() {
        let bounds = Bounds::of([DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
        let facts = [Some((-1.5, 2.5)), None].map(|scalar_range| Facts {
            piece: 7,
            cluster: Cluster {
                cells: 8,
                points: 9,
                bounds,
                scalar_range,
            },
            values: 10,
        });
        let bytes: Vec<u8> = facts.iter().flat_map(Facts::encode).collect();
        assert_eq!(bytes.len(), 2 * Facts::BYTES);
        assert_eq!(Facts::decode_all(&bytes), facts);
    }
}
