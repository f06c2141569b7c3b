// Column: the voxels between the two buffers at a pixel (`voxelize_between_two_buffers`).
//
// Prakash, Manohar 1995 section 2.2.1. The scalar goes from voxel to voxel by increments, as
// published, in integers: nothing is rounded on the way.
// With: voxel_hw/wide.wgsl, voxel_hw/work.wgsl, voxel_hw/face.wgsl, voxel_hw/put.wgsl

// The first voxel's scalar is that of the front face; or interpolated at its center.
override ROUNDED: bool = false;

fn fill_between(place: vec2i, one: Fragment, other: Fragment) {
    let swapped = other.voxel < one.voxel;
    let front = pick(one, other, swapped);
    let back = pick(other, one, swapped);
    let first = max(front.voxel, work.first);
    let end = min(back.voxel, work.end);
    let depth = back.depth - front.depth;
    // A front face at a voxel's center and a back face less than a unit behind it.
    let is_thin = depth <= 0;
    let rise = select(back.scalar - front.scalar, 0, is_thin);
    let center = (first << DEPTH_BITS) + (1 << (DEPTH_BITS - 1u)) - front.depth;
    let past = select(center, (first - front.voxel) << DEPTH_BITS, ROUNDED);
    let d = vec2u(u32(max(depth, 1)), 0u);
    let inverse = 1.0 / f32(d.x);
    let begin = quotient(wide_times(wide_of(past), rise), d, inverse);
    // Not used by a single voxel, for which it may not fit.
    let step = quotient(wide_shifted(wide_of(rise), DEPTH_BITS), d, inverse);
    var whole = front.scalar + begin.whole;
    var rest = begin.rest.x;
    for (var voxel = first; voxel < end; voxel++) {
        put(vec3i(place, voxel), bitcast<u32>(whole));
        rest += step.rest.x;
        let carries = rest >= d.x;
        rest = select(rest, rest - d.x, carries);
        whole += step.whole + select(0, 1, carries);
    }
}

fn pick(a: Fragment, b: Fragment, second: bool) -> Fragment {
    return Fragment(
        select(a.voxel, b.voxel, second),
        select(a.depth, b.depth, second),
        select(a.scalar, b.scalar, second),
    );
}
