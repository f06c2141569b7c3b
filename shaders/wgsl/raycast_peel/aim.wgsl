// Aim: rays one by one, for testing the walk where it is hardest.
//
// With: all of raycast_peel/march.wgsl

struct Aim {
    anchor: vec4f,
    direction: vec4f, // of any length
}

@group(3) @binding(2) var<storage, read> aims: array<Aim>;
// Visits, paths, unpaired crossings, lost; 4 words a ray.
@group(3) @binding(3) var<storage, read_write> traces: array<vec4u>;

@compute @workgroup_size(64)
fn cs_aim(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&aims) {
        return;
    }
    let anchor = aims[id.x].anchor.xyz;
    let direction = aims[id.x].direction.xyz;
    let line = Line(direction, -FAR_AWAY, FAR_AWAY, vec2f(1.0, 0.0));
    var t = new_trace(tile_faces[0]);
    trace(&t, vec2u(0u), 0u, shear_of(anchor, direction), line);
    let unpaired = t.crossings + t.found.kept - 2u * t.paths;
    // A ray that is not done is as bad as a lost one.
    traces[id.x] = vec4u(t.visits, t.paths, unpaired, t.lost | u32(t.phase != DONE));
}
