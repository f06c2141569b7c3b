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

override SCALARS_PER_CELL: bool = false;

var<workgroup> shown: array<vec2u, WORKGROUP>;

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
    var count = 0u;
    if cell < cull.cells {
        count = pieces_of(cell);
        counts[cell] = count;
    }
    shown[thread] = vec2u(min(count, 1u), count);
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

// In how many pieces a cell is drawn, 0 if it is not.
fn pieces_of(cell: u32) -> u32 {
    let v = cells[cell];
    var bits = vec4u(scalars[select(v.x, cell, SCALARS_PER_CELL)]);
    if !SCALARS_PER_CELL {
        bits = vec4u(bits.x, scalars[v.y], scalars[v.z], scalars[v.w]);
    }
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
