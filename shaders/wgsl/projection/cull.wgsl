// Cull: what the passes share that choose the cells to draw.
//
// judge.wgsl counts, compact.wgsl adds up and writes the list; in order, so that the same
// cells always come in the same order. "Reduce, then scan", as the radix sort.

struct Cull {
    cells: u32,
    intervals: u32,
    marks: u32,
    blocks: u32, // workgroups, each with so many cells as threads
}

const WORKGROUP: u32 = 256u;

@group(0) @binding(0) var<uniform> cull: Cull;
// In how many pieces each cell is drawn, 0 if it is not; from bit 24 on how many parts each
// of them has.
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
// Of each block the cells that are drawn, their pieces, the parts of those, and the cells
// with more parts than are counted; then those before it, and in the end all.
@group(0) @binding(2) var<storage, read_write> sums: array<vec4u>;

fn pieces_in(count: u32) -> u32 {
    return count & 0xffffffu;
}

fn parts_in(count: u32) -> u32 {
    return count >> 24u;
}
