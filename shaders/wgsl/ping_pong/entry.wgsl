// Entry: where rays come in, one layer of boundary faces after the other.
//
// Phases 1 and 2 of Bernardon et al. 2004: front faces of the boundary are drawn with
// a depth test; a fragment counts if it lies behind the layer before. In the first
// layer every fragment does.
// In:   the boundary's triangles, the layer before.
// Out:  the cell behind the face, λ and the scalar there.
// With: ping_pong/rays.wgsl, ping_pong/planes.wgsl

@group(2) @binding(0) var before: texture_2d<f32>;

struct Entering {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) cell: vec2f,
}

@vertex
fn vs_entry(@location(0) position: vec3f, @location(1) cell: vec2f) -> Entering {
    return Entering(frame.clip * vec4f(position, 1.0), cell);
}

@fragment
fn fs_entry(in: Entering) -> @location(0) vec4f {
    let ray = ray_of(in.position);
    let cell = vec2i(in.cell);
    let planes = planes_of(cell, ray);
    // The last plane through which the ray comes in.
    let entering = select(vec4f(-FAR), planes.lambda, planes.toward < vec4f(0.0));
    let lambda = max(max(entering.x, entering.y), max(entering.z, entering.w));
    let layer = textureLoad(before, vec2i(in.position.xy), 0);
    if !(lambda > layer.z + frame.bias) {
        discard;
    }
    return vec4f(in.cell, lambda, scalar_at(cell, ray, lambda));
}

@vertex
fn vs_inside(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

// The first layer where the eye is in a cell: all rays begin there.
@fragment
fn fs_inside(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(frame.inside.xy, ray_of(position).eye, frame.inside.w);
}
