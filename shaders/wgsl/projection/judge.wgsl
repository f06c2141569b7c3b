// Judge: which cells can show, and in which intervals of the transfer function each is.
//
// Left out are cells without volume, cells with a scalar that is NaN, and cells whose
// scalars map to nothing: no extinction, or black where only color counts. Where isosurfaces
// are drawn, cells that none goes through.
// In:   cells (of four times one vertex where they have no volume), scalars.
// Out:  ranges; counts; sums of each workgroup's.
// With: projection/cull.wgsl, common/optics_model.wgsl, common/transfer_function.wgsl

@group(0) @binding(3) var<storage, read> cells: array<vec4u>;
@group(0) @binding(4) var<storage, read> scalars: array<u32>; // bits, as they may be NaN
@group(0) @binding(5) var<storage, read> intervals: array<Interval>;
// For each interval the next, from it on, in which something shows; or isovalues' bits,
// sorted.
@group(0) @binding(6) var<storage, read> marks: array<u32>;
// The first and the last interval of each cell, 16 bits each.
@group(0) @binding(7) var<storage, read_write> ranges: array<u32>;
@group(0) @binding(8) var<storage, read> positions: array<f32>; // three of each vertex

override SCALARS_PER_CELL: bool = false;

var<workgroup> shown: array<vec4u, WORKGROUP>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return cull.intervals;
}

@compute @workgroup_size(WORKGROUP)
fn cs_judge(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let block = group.y * groups.x + group.x;
    let cell = block * WORKGROUP + thread;
    shown[thread] = vec4u(0u);
    if cell < cull.cells {
        let pieces = pieces_of(cell);
        var parts = 0u;
        if pieces > 0u {
            parts = parts_of(cell);
        }
        let counted = min(parts, MOST_PARTS);
        counts[cell] = pieces | (counted << 24u);
        shown[thread] = vec4u(min(pieces, 1u), pieces, pieces * counted, u32(parts > MOST_PARTS));
    }
    for (var step = WORKGROUP / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if thread < step {
            shown[thread] += shown[thread + step];
        }
    }
    if thread == 0u && block < cull.blocks {
        sums[block] = shown[0];
    }
}

fn bits_of(cell: u32) -> vec4u {
    let v = cells[cell];
    if SCALARS_PER_CELL {
        return vec4u(scalars[cell]);
    }
    return vec4u(scalars[v.x], scalars[v.y], scalars[v.z], scalars[v.w]);
}

// In how many pieces a cell is drawn, 0 if it is not.
fn pieces_of(cell: u32) -> u32 {
    let v = cells[cell];
    let bits = bits_of(cell);
    // Shaders may take it that there is no NaN, so its bits are looked at.
    if any((bits & vec4u(0x7fffffffu)) > vec4u(0x7f800000u)) {
        ranges[cell] = 0u;
        return 0u;
    }
    let s = bitcast<vec4f>(bits);
    let low = min(min(s.x, s.y), min(s.z, s.w));
    let high = max(max(s.x, s.y), max(s.z, s.w));
    // What only touches a knot is not beyond it, unless it is constant: then it is on both
    // sides.
    let above = find_interval(low, true);
    let below = find_interval(high, false);
    let first = min(above, below);
    let last = max(above, below);
    ranges[cell] = first | (last << 16u);
    let is_flat = v.x == v.y;
    let is_constant = low == high;
    var shows = false;
    if MODEL == ISOSURFACES {
        shows = isovalue_in(low, high);
    } else if is_constant {
        shows = shows_at(first, low) || shows_at(last, low);
    } else {
        // Where one end of an interval shows, all of its inside does.
        shows = marks[first] <= last;
    }
    if is_flat || !shows {
        return 0u;
    }
    return select(last - first + 1u, 1u, is_constant);
}

const MOST_PARTS: u32 = 255u;

// Intervals that a cell may have to be looked at.
const MOST_LOOKED_AT: u32 = 64u;

// Into how many parts of one optical depth at most, for `segment_weights`, the ray's way
// through a cell is cut; more than `MOST_PARTS` where that is unknown.
fn parts_of(cell: u32) -> u32 {
    if MODEL != EMISSION_ABSORPTION {
        return 1u;
    }
    let first = ranges[cell] & 0xffffu;
    let last = ranges[cell] >> 16u;
    if last - first >= MOST_LOOKED_AT {
        return MOST_PARTS + 1u;
    }
    let v = cells[cell];
    let s = bitcast<vec4f>(bits_of(cell));
    let low = min(min(s.x, s.y), min(s.z, s.w));
    let high = max(max(s.x, s.y), max(s.z, s.w));
    var densest = 0.0;
    for (var index = first; index <= last; index++) {
        let i = intervals[index];
        let ends = vec2f(
            sample_interval(i, clamp(low, i.low, i.high)).w,
            sample_interval(i, clamp(high, i.low, i.high)).w,
        );
        densest = max(densest, max(ends.x, ends.y));
    }
    let p0 = position(v.x);
    let p1 = position(v.y);
    let p2 = position(v.z);
    let p3 = position(v.w);
    let longest = max(
        max(max(length(p1 - p0), length(p2 - p0)), length(p3 - p0)),
        max(max(length(p2 - p1), length(p3 - p1)), length(p3 - p2)),
    );
    // More than f32 loses in all this.
    let deepest = densest * longest * 1.00001;
    if !(deepest <= f32(MOST_PARTS)) {
        return MOST_PARTS + 1u;
    }
    return max(u32(ceil(deepest)), 1u);
}

fn position(vertex: u32) -> vec3f {
    return vec3f(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

fn shows_at(index: u32, scalar: f32) -> bool {
    let value = sample_interval(intervals[index], scalar);
    if MODEL == MAXIMUM_INTENSITY {
        return any(value.xyz > vec3f(0.0));
    }
    return value.w > 0.0;
}

// Whether low < v ≤ high for one of the isovalues, as `surfaces.wgsl` decides.
fn isovalue_in(low: f32, high: f32) -> bool {
    // How many are at most `low`, by bisection.
    var first = 0u;
    var end = cull.marks;
    while first < end {
        let middle = (first + end) / 2u;
        if bitcast<f32>(marks[middle]) <= low {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    return first < cull.marks && bitcast<f32>(marks[min(first, cull.marks - 1u)]) <= high;
}
