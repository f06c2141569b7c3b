// Put: the accumulation volume buffer, and what became of cells.
//
// Prakash, Manohar 1995 section 3.1. Integers, so that the order of cells does not matter.

// Three words for each voxel of the part, x fastest: the sum of scalars, the lower word first, and how
// many they are.
@group(1) @binding(0) var<storage, read_write> sums: array<atomic<u32>>;
@group(1) @binding(1) var<storage, read_write> tallies: array<atomic<u32>, 4>;

// Cells that cannot reach a voxel, that have no value, no volume, or are inside out.
const OUTSIDE: u32 = 0u;
const WITHOUT_VALUE: u32 = 1u;
const DEGENERATE: u32 = 2u;
const INVERTED: u32 = 3u;

fn tally(what: u32, yes: bool) {
    if yes && work.is_first == 1u {
        atomicAdd(&tallies[what], 1u);
    }
}

fn put(voxel: vec3i, scalar: u32) {
    let index = 3 * (voxel.x + work.dims.x * (voxel.y + work.dims.y * (voxel.z - work.first)));
    let before = atomicAdd(&sums[index], scalar);
    if before + scalar < before {
        atomicAdd(&sums[index + 1], 1u);
    }
    atomicAdd(&sums[index + 2], 1u);
}
