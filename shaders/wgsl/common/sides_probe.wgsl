// Sides probe: many decisions at once, for testing a device and sides.wgsl.
//
// With: common/sides.wgsl

// a.x, a.y, b.x, b.y; and for `cs_parity` four points in two of these, for `cs_shares` three.
@group(0) @binding(0) var<storage, read> inputs: array<vec4f>;
// The bits of a.x b.y and the side; for `cs_parity` how many faces are crossed, one by one
// and all at once; for `cs_shares` the bits of the shares of the last two corners.
@group(0) @binding(1) var<storage, read_write> answers: array<vec2u>;

@compute @workgroup_size(64)
fn cs_sides(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&answers) {
        return;
    }
    let a = inputs[id.x].xy;
    let b = inputs[id.x].zw;
    answers[id.x] = vec2u(bitcast<u32>(a.x * b.y), bitcast<u32>(side(a, b)));
}

@compute @workgroup_size(64)
fn cs_parity(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&answers) {
        return;
    }
    let ab = inputs[2u * id.x];
    let cd = inputs[2u * id.x + 1u];
    let crossed = abs(crossing(ab.xy, ab.zw, cd.xy)) + abs(crossing(ab.xy, ab.zw, cd.zw))
        + abs(crossing(ab.xy, cd.xy, cd.zw)) + abs(crossing(ab.zw, cd.xy, cd.zw));
    let at_once = turns(sides(ab.xy, ab.zw, cd.xy, cd.zw));
    let met = select(vec4u(0u), vec4u(1u), at_once.enters | at_once.leaves);
    answers[id.x] = vec2u(u32(crossed), met.x + met.y + met.z + met.w);
}

@compute @workgroup_size(64)
fn cs_shares(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&answers) {
        return;
    }
    let ab = inputs[2u * id.x];
    answers[id.x] = bitcast<vec2u>(shares(ab.xy, ab.zw - ab.xy, inputs[2u * id.x + 1u].xy - ab.xy));
}
