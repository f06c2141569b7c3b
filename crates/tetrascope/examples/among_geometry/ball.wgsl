// A lit ball at the origin, in quadrilaterals of two triangles: 48 around its axis, 24 along it.
//
// In:  the number of a vertex, six for each quadrilateral.
// Out: linear opaque RGBA, and depth.

@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) normal: vec3f,
}

@vertex
fn vs(@builtin(vertex_index) index: u32) -> Varying {
    var corners = array(0u, 1u, 2u, 2u, 1u, 3u);
    let corner = corners[index % 6u];
    let quad = index / 6u;
    let phi = f32(quad % 48u + (corner & 1u)) * 6.2831853 / 48.0;
    let theta = f32(quad / 48u + (corner >> 1u)) * 3.1415927 / 24.0;
    let normal = vec3f(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
    return Varying(clip_from_world * vec4f(0.62 * normal, 1.0), normal);
}

@fragment
fn fs(in: Varying) -> @location(0) vec4f {
    let light = max(dot(normalize(in.normal), normalize(vec3f(-0.5, -0.4, 0.6))), 0.0);
    return vec4f(vec3f(0.75, 0.78, 0.85) * (0.06 + 0.8 * light), 1.0);
}
