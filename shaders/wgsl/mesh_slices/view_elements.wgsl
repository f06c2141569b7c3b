// View elements: the triangles of every cell as a camera sees it, and the planes that each meets.
//
// Westermann 2001 section 3.1, in every view anew.
// With: mesh_slices/frame.wgsl and what it needs, common/sides.wgsl, resample/element.wgsl,
//       resample/triangles.wgsl

@group(2) @binding(0) var<storage, read_write> elements: array<Element>;
// The first plane that a cell meets and the last; swapped for none.
@group(2) @binding(1) var<storage, read_write> spans: array<vec2i>;

@compute @workgroup_size(64)
fn cs_elements(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let cell = id.x + 64u * size.x * id.y;
    if cell >= frame.cell_count {
        return;
    }
    let ids = corners_of(cell);
    let a = vertex_of(ids.x, cell);
    let b = vertex_of(ids.y, cell);
    let c = vertex_of(ids.z, cell);
    let d = vertex_of(ids.w, cell);
    var fan = fan_of(array(seen(a), seen(b), seen(c), seen(d)));
    if any(vec4f(a.w, b.w, c.w, d.w) >= vec4f(NO_VALUE)) {
        fan = Fan();
    }
    let depths = vec2f(min(min(a.z, b.z), min(c.z, d.z)), max(max(a.z, b.z), max(c.z, d.z)));
    // Planes, and where rounding might tell otherwise one more.
    let planes = (depths - frame.first_depth) / frame.step - 0.5;
    let first = max(ceil(planes.x - 0.01), 0.0);
    let last = min(floor(planes.y + 0.01), f32(frame.plane_count) - 1.0);
    spans[cell] = select(vec2i(1, 0), vec2i(i32(first), i32(last)), fan.sides > 0u);
    elements[cell] = Element(
        fan.center,
        1.0 / (fan.back.x - fan.front.x),
        fan.outline | (fan.sides << 8u) | (fan.triangles << 12u),
        fan.front,
        fan.back,
        vec2f(min(min(a.w, b.w), min(c.w, d.w)), max(max(a.w, b.w), max(c.w, d.w))),
    );
}
