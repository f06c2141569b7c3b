// Elements: the triangles of every cell, made once, and the slices that each meets.
//
// Westermann 2001 section 3.1. Slices are those of the grid along its third axis, which is "along".
// With: common/sides.wgsl, resample/mesh.wgsl, resample/element.wgsl, resample/triangles.wgsl

@group(1) @binding(0) var<storage, read_write> elements: array<Element>;
// The first slice that a cell meets and the last; swapped for none.
@group(1) @binding(1) var<storage, read_write> spans: array<vec2i>;

@compute @workgroup_size(64)
fn cs_elements(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let cell = id.x + 64u * size.x * id.y;
    if cell >= work.cell_count {
        return;
    }
    let ids = corners_of(cell);
    let a = vertex_of(ids.x);
    let b = vertex_of(ids.y);
    let c = vertex_of(ids.z);
    let d = vertex_of(ids.w);
    let scalars = scalars_of(cell, vec4f(a.scalar, b.scalar, c.scalar, d.scalar));
    let base = a.sample;
    var fan = fan_of(array(
        vec4f(a.offset, scalars.x),
        vec4f((b.sample - base) + b.offset, scalars.y),
        vec4f((c.sample - base) + c.offset, scalars.z),
        vec4f((d.sample - base) + d.offset, scalars.w),
    ));
    if any(scalars >= vec4f(NO_VALUE)) {
        fan = Fan();
    }
    let first = min(min(first_from(a), first_from(b)), min(first_from(c), first_from(d)));
    let last = max(max(last_to(a), last_to(b)), max(last_to(c), last_to(d)));
    // One more across, where rasterizers round places.
    let low = max(whole(first) - vec3i(1, 1, 0), vec3i(work.low, work.first));
    let high = min(whole(last) + vec3i(2, 2, 1), vec3i(work.high, work.end));
    let is_met = fan.sides > 0u && all(low < high);
    spans[cell] = select(vec2i(1, 0), vec2i(low.z, high.z - 1), is_met);
    elements[cell] = Element(
        fan.center,
        1.0 / (fan.back.x - fan.front.x),
        fan.outline | (fan.sides << 8u) | (fan.triangles << 12u),
        fan.front,
        fan.back,
        vec2f(min(min(scalars.x, scalars.y), min(scalars.z, scalars.w)),
            max(max(scalars.x, scalars.y), max(scalars.z, scalars.w))),
    );
}

// The first sample that is not before the vertex.
fn first_from(v: Vertex) -> vec3f {
    return v.sample + select(vec3f(0.0), vec3f(1.0), v.offset > vec3f(0.0));
}

// The last sample that is not behind it.
fn last_to(v: Vertex) -> vec3f {
    return v.sample - select(vec3f(0.0), vec3f(1.0), v.offset < vec3f(0.0));
}

// No grid has as many samples along an axis.
fn whole(sample: vec3f) -> vec3i {
    return vec3i(clamp(sample, vec3f(-1e6), vec3f(1e6)));
}
