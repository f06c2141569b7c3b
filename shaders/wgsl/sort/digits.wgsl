// Radix sort: what its passes share.
//
// Least significant digit first, 4 bits a round; each round counts, scans and
// scatters ("reduce, then scan"), so no workgroup waits for another.
// Sources: D. Merrill, A. Grimshaw, "Revisiting Sorting for GPGPU Stream
// Architectures", 2010.

struct Round {
    count: u32,  // pairs
    shift: u32,  // of the digit in the key, bits
    blocks: u32, // workgroups, each with a block of the pairs
}

const THREADS: u32 = 256u;
const ITEMS: u32 = 16u; // pairs a thread
const BLOCK: u32 = THREADS * ITEMS;
const DIGITS: u32 = 16u;

@group(0) @binding(0) var<uniform> round: Round;
@group(0) @binding(1) var<storage, read> keys_in: array<u32>;
@group(0) @binding(2) var<storage, read> values_in: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys_out: array<u32>;
@group(0) @binding(4) var<storage, read_write> values_out: array<u32>;
// Counts, then first positions, of each digit in each block: [digit][block].
@group(0) @binding(5) var<storage, read_write> table: array<u32>;

fn digit_of(key: u32) -> u32 {
    return (key >> round.shift) & (DIGITS - 1u);
}
