// Active: the list of elements that meet a slab.
//
// Westermann 2001 section 3. Cells come in any order: which of two wins a sample that both cover is
// decided by their numbers (section.wgsl).
// With: resample/element.wgsl

// An indirect draw of a slab's elements.
struct Draw {
    vertices: u32,             // of an element, 12
    elements: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> spans: array<vec2i>;
@group(0) @binding(2) var<storage, read> elements: array<Element>;
@group(0) @binding(3) var<storage, read_write> list: array<u32>;
@group(0) @binding(4) var<storage, read_write> draws: array<Draw>;
// Triangles with an area in each slab's list.
@group(0) @binding(5) var<storage, read_write> triangles: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> cell_count: u32;

@compute @workgroup_size(64)
fn cs_active(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let cell = id.x + 64u * size.x * id.y;
    if cell >= cell_count {
        return;
    }
    let span = spans[cell];
    if max(span.x, step.first) > min(span.y, step.end - 1) {
        return;
    }
    list[atomicAdd(&draws[step.slab].elements, 1u)] = cell;
    atomicAdd(&triangles[step.slab], elements[cell].fan >> 12u);
}
