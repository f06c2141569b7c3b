// List: which cells may have samples in them, and how much work each is.
//
// With: resample/mesh.wgsl

// How many cells are in each list; `Counts` of fill.wgsl.
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>, 4>;
// Lists 0 and 1 share the first half, from its ends, and 2 and 3 the second.
@group(0) @binding(5) var<storage, read_write> lists: array<u32>;
// Workgroups of the dispatches over lists 1 to 3, four numbers each.
@group(0) @binding(6) var<storage, read_write> workgroups: array<vec4u, 3>;

// Columns that a workgroup, 64 and 4096 of them take at most; see fill.wgsl.
const OF_ONE: u32 = 1024u;
const OF_64: u32 = 65536u;

// Passes of loops for a column beside those for its samples: six ties of `sides`, and tests.
const COLUMN_PASSES: u32 = 10u;

@compute @workgroup_size(64)
fn cs_list(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let cell = id.x + 64u * size.x * id.y;
    if cell >= work.cell_count {
        return;
    }
    let ids = cells[cell];
    let a = vertices[ids.x];
    let b = vertices[ids.y];
    let c = vertices[ids.z];
    let d = vertices[ids.w];
    // The samples between the least and the greatest corner, exactly across, and along the columns
    // with those that a face before them may count as through.
    let span = max(max(a.sample, b.sample), max(c.sample, d.sample))
        - min(min(a.sample, b.sample), min(c.sample, d.sample)) + vec3f(1.0);
    let before = vec3f(0.0, 0.0, 2.0 * SNAP * max(span.x, max(span.y, span.z)));
    let first = min(
        min(first_from(a, before), first_from(b, before)),
        min(first_from(c, before), first_from(d, before)),
    );
    let last = max(max(last_to(a), last_to(b)), max(last_to(c), last_to(d)));
    let low = clamp_to(first, vec3i(work.low, work.first));
    let high = -clamp_to(-last - vec3f(1.0), -vec3i(work.high, work.end));
    let size_of_box = high - low;
    let scalars = scalars_of(cell, vec4f(a.scalar, b.scalar, c.scalar, d.scalar));
    if any(scalars >= vec4f(NO_VALUE)) || any(size_of_box <= vec3i(0)) {
        return;
    }
    let columns = u32(size_of_box.x) * u32(size_of_box.y);
    var list = 3u;
    if columns * (u32(size_of_box.z) + COLUMN_PASSES) <= work.small {
        list = 0u;
    } else if columns <= OF_ONE {
        list = 1u;
    } else if columns <= OF_64 {
        list = 2u;
    }
    let place = atomicAdd(&counts[list], 1u);
    let count = work.cell_count;
    let from_start = (list >> 1u) * count + place;
    let from_end = ((list >> 1u) + 1u) * count - 1u - place;
    lists[select(from_start, from_end, (list & 1u) == 1u)] = cell;
}

// The first sample that is not farther before the vertex than that.
fn first_from(v: Vertex, before: vec3f) -> vec3f {
    return v.sample + select(vec3f(0.0), vec3f(1.0), v.offset > before);
}

// The last sample that is not behind it.
fn last_to(v: Vertex) -> vec3f {
    return v.sample - select(vec3f(0.0), vec3f(1.0), v.offset < vec3f(0.0));
}

// The greater of both, as integers.
fn clamp_to(sample: vec3f, least: vec3i) -> vec3i {
    return max(vec3i(clamp(sample, vec3f(-1e6), vec3f(1e6))), least);
}

// How many workgroups take lists 1 to 3; 65 535 is the most along each axis.
@compute @workgroup_size(1)
fn cs_arrange() {
    arrange(0u, 1u);
    arrange(1u, 64u);
    arrange(2u, 4096u);
}

fn arrange(dispatch: u32, for_each: u32) {
    let count = atomicLoad(&counts[dispatch + 1u]);
    let rows = (count + 65534u) / 65535u;
    workgroups[dispatch] = vec4u(for_each, select(0u, (count + rows - 1u) / max(rows, 1u), rows > 0u), rows, 0u);
}
