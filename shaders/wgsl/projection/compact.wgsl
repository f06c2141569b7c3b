// Compact: the list of the items that are drawn, without gaps.
//
// In:   counts, sums.
// Out:  drawn, the items; pieces, what each is of, where `PIECES`.
// With: projection/cull.wgsl

override PIECES: bool = false;
override PARTS: bool = false;

@group(0) @binding(3) var<storage, read_write> drawn: array<u32>;
// A cell and, see pieces.wgsl, what of it.
@group(0) @binding(4) var<storage, read_write> pieces: array<vec2u>;

var<workgroup> ends: array<vec4u, WORKGROUP>;

// Pieces may be more than 32 bits count; then cells are drawn whole.
fn plus(a: vec4u, b: vec4u) -> vec4u {
    let sum = a + b;
    return select(sum, vec4u(0xffffffffu), sum < a);
}

// Replaces ends[thread] by the sum up to and with it.
fn add_up(thread: u32) {
    for (var step = 1u; step < WORKGROUP; step *= 2u) {
        workgroupBarrier();
        var before = vec4u(0u);
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
    var sum = vec4u(0u);
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
    let own = vec4u(min(count, 1u), pieces_in(count), pieces_in(count) * parts_in(count), 0u);
    ends[thread] = own;
    add_up(thread);
    if count == 0u {
        return;
    }
    let start = sums[min(block, cull.blocks)] + ends[thread] - own;
    if !PIECES {
        drawn[start.x] = cell;
        return;
    }
    let first = select(start.y, start.z, PARTS);
    let parts = select(1u, parts_in(count), PARTS);
    for (var n = 0u; n < pieces_in(count) * parts; n++) {
        drawn[first + n] = first + n;
        pieces[first + n] = vec2u(cell, (n / parts) | ((n % parts) << 16u) | ((parts - 1u) << 24u));
    }
}
