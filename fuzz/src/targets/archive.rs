//! Archives of NumPy arrays that are packed here, behind directories that may lie.

use arbitrary::Unstructured;
use tetrascope::core::Error;

use super::Bench;
use crate::zip::{Member, zip};

/// Types of numbers, and their bytes.
const TYPES: [(&str, usize); 12] = [
    ("<f4", 4),
    ("|u1", 1),
    (">i2", 2),
    ("<f8", 8),
    ("<c8", 8),
    ("|b1", 1),
    ("<f2", 2),
    (">u4", 4),
    ("<i8", 8),
    ("<u8", 8),
    ("|i1", 1),
    (">c16", 16),
];

const NAMES: [&str; 4] = ["a.npy", "b.npy", "../c.npy", "d.txt"];

/// The truth about an archive, and the lie that its directory tells in its place.
struct Lie {
    member: usize,
    field: u8,
    number: u32,
}

/// An `.npz` of some arrays: as many as the input says, of zeros as far as it has no numbers.
pub(super) fn read(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let mut bytes = Unstructured::new(bytes);
    let byte = |bytes: &mut Unstructured| bytes.arbitrary::<u8>().unwrap_or(0);
    let lies = (0..byte(&mut bytes) % 3).map(|_| Lie {
        member: usize::from(byte(&mut bytes) % 3),
        field: byte(&mut bytes) % 4,
        number: match byte(&mut bytes) {
            0 => bytes.arbitrary().unwrap_or(u32::MAX),
            small @ 1..224 => u32::from(small - 1),
            large => u32::MAX >> (large - 224),
        },
    });
    let lies: Vec<Lie> = lies.collect();
    let mut files = Vec::new();
    for _ in 0..1 + byte(&mut bytes) % 3 {
        let options = byte(&mut bytes);
        let (kind, size) = TYPES[usize::from(byte(&mut bytes)) % TYPES.len()];
        let rank = 1 + usize::from(byte(&mut bytes).wrapping_add(2)) % 6;
        let shape: Vec<usize> = (0..rank)
            .map(|_| match byte(&mut bytes) {
                0 => 2,
                small @ 1..250 => usize::from(small % 6),
                large => usize::MAX >> (8 * (large - 250)),
            })
            .collect();
        let order = if options & 1 == 0 { "False" } else { "True" };
        let header = format!(
            "{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({},), }}\n",
            shape
                .iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(", ")
        );
        let length = (header.len() as u16).to_le_bytes();
        let mut file = [&b"\x93NUMPY\x01\0"[..], &length, header.as_bytes()].concat();
        let count = shape.iter().fold(size, |n, size| n.saturating_mul(*size));
        let numbers = usize::from(byte(&mut bytes)).min(bytes.len());
        let mut numbers = bytes.bytes(numbers).unwrap_or_default().to_vec();
        if options & 2 == 0 {
            numbers.resize(count.min(1 << 14), 0);
        }
        file.extend(numbers);
        let name = NAMES[usize::from(options >> 4 & 3)];
        files.push((name, file, options & 4 == 0));
    }
    let members = files.iter().map(|(name, bytes, is_deflated)| Member {
        name,
        bytes,
        is_deflated: *is_deflated,
    });
    let members: Vec<Member> = members.collect();
    let archive = zip(&members, |i, entry| {
        for lie in lies.iter().filter(|lie| lie.member == i) {
            match lie.field {
                0 => entry.method = lie.number as u16,
                1 => entry.packed = lie.number,
                2 => entry.unpacked = lie.number,
                _ => entry.start = lie.number,
            }
        }
    });
    bench.file("grid.npz", &archive)
}

/// Arrays of each type, stored and deflated, in both orders; and one of each lie.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![Vec::new()];
    for (i, _) in (0u8..).zip(TYPES) {
        // No lie, two arrays: options, type, rank, sizes, numbers.
        seeds.push(vec![0, 1, i % 8, i, 0, 0, 0, 0, 4, 1, 2, 3, 4, 16, i, 1]);
    }
    for field in 0..4 {
        seeds.push(vec![1, 0, field, 9]);
    }
    seeds
}
