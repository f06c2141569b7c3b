// Compact: the list of the items that are drawn, without gaps.
//
// In:   counts, sums.
// Out:  drawn, the items; pieces, what each is of, where `PIECES`.
// With: projection/cull.wgsl

override PIECES: bool = false;

@group(0) @binding(3) var<storage, read_write> drawn: array<u32>;
// A cell and how many of its pieces come before.
@group(0) @binding(4) var<storage, read_write> pieces: array<vec2u>;

var<workgroup> ends: array<vec2u, WORKGROUP>;

// Pieces may be more than 32 bits count; then cells are drawn whole.
fn plus(a: vec2u, b: vec2u) -> vec2u {
    let sum = a + b;
    return select(sum, vec2u(0xffffffffu), sum < a);
}

// Replaces ends[thread] by the sum up to and with it.
fn add_up(thread: u32) {
    for (var step = 1u; step < WORKGROUP; step *= 2u) {
        workgroupBarrier();
        var before = vec2u(0u);
        if thread >= step {
            before = ends[thread - step];
        }
        workgroupBarrier();
        ends[thread] = plus(ends[thread], before);
    }
    workgroupBarrier();
}

// One workgroup: each thread takes a share of the blocks.
@compute @workgroup_size(WORKGROUP)
fn cs_scan(@builtin(local_invocation_index) thread: u32) {
    let share = (cull.blocks + WORKGROUP - 1u) / WORKGROUP;
    let start = min(thread * share, cull.blocks);
    let end = min(start + share, cull.blocks);
    var sum = vec2u(0u);
    for (var i = start; i < end; i++) {
        sum = plus(sum, sums[i]);
    }
    ends[thread] = sum;
    add_up(thread);
    var before = ends[thread] - sum;
    for (var i = start; i < end; i++) {
        let own = sums[i];
        sums[i] = before;
        before = plus(before, own);
    }
    if thread == WORKGROUP - 1u {
        sums[cull.blocks] = before;
    }
}

@compute @workgroup_size(WORKGROUP)
fn cs_compact(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let block = group.y * groups.x + group.x;
    let cell = block * WORKGROUP + thread;
    var count = 0u;
    if cell < cull.cells {
        count = counts[cell];
    }
    ends[thread] = vec2u(min(count, 1u), count);
    add_up(thread);
    if count == 0u {
        return;
    }
    let before = sums[min(block, cull.blocks)];
    if !PIECES {
        drawn[before.x + ends[thread].x - 1u] = cell;
        return;
    }
    let start = before.y + ends[thread].y - count;
    for (var rank = 0u; rank < count; rank++) {
        drawn[start + rank] = start + rank;
        pieces[start + rank] = vec2u(cell, rank);
    }
}
