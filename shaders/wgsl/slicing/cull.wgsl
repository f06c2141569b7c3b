// Cull: the boxes that can show, back to front, and how many they are.
//
// Rezk Salama, Kolb 2005, §6, where the CPU traverses an octree. The traversal takes the
// children of a node farthest first, so a box's rank in it spells its path: number r of
// all boxes is found by its bits, and no box waits for another. What is left to do in
// order is to close the gaps of boxes that do not show, by prefix sums.
// In:   the range of each box as two places in a table over the transfer function, or as two
//       scalars (ranges.wgsl), whose places are found here.
// Out:  the list of boxes that `vs_slice` draws, and the arguments of that draw; or, as how many
//       they are is found alike, the table of boxes in which rays.wgsl looks.
// With: slicing/box.wgsl

struct Cull {
    whole: vec4u,      // cells along each axis of all boxes together
    box_size: vec4u,   // cells along each axis of a box
    halvings: vec4u,   // how often each axis is halved down to a box
    brick_shift: vec4u, // a box at p lies in brick p >> brick_shift
    brick_count: vec4u, // bricks along each axis
    eye: vec4f,        // lattice space; a direction if w = 0
    margin: vec4f,     // by how much a box is enlarged on each side
    level: u32,
    bits: u32,         // of a rank: all halvings
    plane_count: u32,
    block_count: u32,
    // Where ranges are scalars: a scalar s is (s − base) · bins_per_scalar + offset bins behind
    // the first, farther than `most` as good as at `most`. Without any bins they are places.
    base: f32,
    most: f32,
    bins_per_scalar: f32,
    offset: f32,
    bins: u32,
    // Where the ranges of this level begin.
    first_range: u32,
}

// As wgpu has it.
struct Arguments {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    base_vertex: i32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> cull: Cull;
// Of a table's first n entries `counts[n]` show; a box shows if some between its two do.
@group(0) @binding(1) var<storage, read> ranges: array<vec2u>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
// What is seen has normal · p + w ≥ 0, lattice space.
@group(0) @binding(3) var<storage, read> planes: array<vec4f>;
// What turns the index of a sample in a brick into its texel.
@group(0) @binding(4) var<storage, read> bricks: array<vec4i>;
// How many boxes of each block show; then how many of those before it.
@group(0) @binding(5) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(6) var<storage, read_write> boxes: array<PlacedBox>;
@group(0) @binding(7) var<storage, read_write> arguments: Arguments;
// All boxes, as rays.wgsl has them.
@group(1) @binding(0) var table: texture_storage_3d<rgba16sint, write>;

const BLOCK: u32 = 256u;

var<workgroup> sums: array<u32, BLOCK>;

// How many boxes of a block of ranks show.
@compute @workgroup_size(BLOCK)
fn cs_count(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) block: vec3u,
) {
    sums[local] = select(0u, 1u, is_rank(id.x) && shows(place_of(id.x)));
    let all = sum_before(local) + sums[local];
    if local == BLOCK - 1u {
        blocks[block.x] = all;
    }
}

// Where each block's boxes begin. One workgroup.
@compute @workgroup_size(BLOCK)
fn cs_scan(@builtin(local_invocation_index) local: u32) {
    let share = (cull.block_count + BLOCK - 1u) / BLOCK;
    let first = min(local * share, cull.block_count);
    let end = min(first + share, cull.block_count);
    var sum = 0u;
    for (var b = first; b < end; b++) {
        sum += blocks[b];
    }
    sums[local] = sum;
    var before = sum_before(local);
    if local == BLOCK - 1u {
        arguments.instance_count = before + sum;
    }
    for (var b = first; b < end; b++) {
        let count = blocks[b];
        blocks[b] = before;
        before += count;
    }
}

// The list itself.
@compute @workgroup_size(BLOCK)
fn cs_list(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) block: vec3u,
) {
    var place = vec3u(0u);
    var shown = false;
    if is_rank(id.x) {
        place = place_of(id.x);
        shown = shows(place);
    }
    sums[local] = select(0u, 1u, shown);
    let number = blocks[block.x] + sum_before(local);
    if shown {
        boxes[number] = PlacedBox(vec3i(place * cull.box_size.xyz), texel_of(place));
    }
}

// The table.
@compute @workgroup_size(BLOCK)
fn cs_table(@builtin(global_invocation_id) id: vec3u) {
    if is_rank(id.x) {
        let place = place_of(id.x);
        textureStore(table, place, vec4i(texel_of(place), select(0, 1, shows(place))));
    }
}

// What turns the index of a sample in a box into its texel.
fn texel_of(place: vec3u) -> vec3i {
    let brick = place >> cull.brick_shift.xyz;
    let index = brick.x + cull.brick_count.x * (brick.y + cull.brick_count.y * brick.z);
    return bricks[index].xyz;
}

fn is_rank(rank: u32) -> bool {
    return rank < 1u << cull.bits;
}

// The box that the traversal comes to after `rank` others.
fn place_of(rank: u32) -> vec3u {
    var place = vec3u(0u);
    var left = cull.bits;
    for (var level = 0u; level < cull.level; level++) {
        for (var i = 0u; i < 3u; i++) {
            let axis = 2u - i;
            if level >= cull.halvings[axis] {
                continue;
            }
            left--;
            let is_second = rank >> left & 1u;
            let upper = 2u * place[axis] + 1u;
            let middle = f32(upper * (cull.whole[axis] >> (level + 1u)));
            let from_point = cull.eye.w != 0.0;
            let upper_is_far = select(cull.eye[axis] > 0.0, cull.eye[axis] < middle, from_point);
            place[axis] = select(upper - 1u + is_second, upper - is_second, upper_is_far);
        }
    }
    return place;
}

fn shows(place: vec3u) -> bool {
    let along = vec3u(1u) << cull.halvings.xyz;
    let range = ranges[cull.first_range + place.x + along.x * (place.y + along.y * place.z)];
    var entries = range;
    if cull.bins > 0u {
        entries = entries_of(bitcast<vec2f>(range));
    }
    if counts[entries.y] <= counts[entries.x] {
        return false;
    }
    let low = vec3f(place * cull.box_size.xyz) - cull.margin.xyz;
    let high = vec3f((place + 1u) * cull.box_size.xyz) + cull.margin.xyz;
    for (var i = 0u; i < cull.plane_count; i++) {
        let plane = planes[i];
        // The corner that is farthest inside.
        let farthest = select(low, high, plane.xyz > vec3f(0.0));
        if dot(plane.xyz, farthest) + plane.w < 0.0 {
            return false;
        }
    }
    return true;
}

// By how much of a bin places may be off: f32 has 2⁻²⁴, of 65 536 bins 1/256, and that for the
// difference, for what a scalar is multiplied by, for the product and for the sum.
const SLACK: f32 = 0.03125;

// The entries of a table (`float_table.rs`) for scalars in a range: the first, and the one behind
// the last. Rounded outward, so that no box is left out that shows.
fn entries_of(range: vec2f) -> vec2u {
    if range.x > range.y {
        return vec2u(0u);
    }
    let difference = clamp(range - cull.base, vec2f(-cull.most), vec2f(cull.most));
    let places = difference * cull.bins_per_scalar + cull.offset;
    if range.x == range.y && places.x == 0.0 {
        // The scalar at which the bins begin, which is that of much empty space.
        return cull.bins + vec2u(2u, 3u);
    }
    let last = f32(cull.bins + 1u);
    let lowest = clamp(floor(places.x - SLACK) + 1.0, 0.0, last);
    let highest = clamp(ceil(places.y + SLACK), 0.0, last);
    return vec2u(u32(lowest), u32(highest) + 1u);
}

// The sum of `sums` before this one. Every invocation of the workgroup calls it.
fn sum_before(local: u32) -> u32 {
    let own = sums[local];
    workgroupBarrier();
    for (var reach = 1u; reach < BLOCK; reach *= 2u) {
        var more = 0u;
        if local >= reach {
            more = sums[local - reach];
        }
        workgroupBarrier();
        sums[local] += more;
        workgroupBarrier();
    }
    let sum = sums[local] - own;
    workgroupBarrier();
    sums[local] = own;
    return sum;
}
