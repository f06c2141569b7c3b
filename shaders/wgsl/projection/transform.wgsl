// Transform: the mesh's vertices in camera space, once a frame.
//
// In:   positions, scalars.
// Out:  transformed, x, y, z and the scalar of each vertex.
// With: projection/frame.wgsl, projection/vertices.wgsl

@group(1) @binding(0) var<storage, read> positions: array<f32>; // x, y, z of each vertex
@group(1) @binding(1) var<storage, read> scalars: array<f32>;   // of each vertex or cell
@group(1) @binding(2) var transformed: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(256)
fn cs_transform(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 256u + id.x;
    if i >= arrayLength(&positions) / 3u {
        return;
    }
    let p = vec4f(positions[3u * i], positions[3u * i + 1u], positions[3u * i + 2u], 1.0);
    let at = vec3f(dot(frame.right, p), dot(frame.up, p), dot(frame.forward, p));
    let scalar = select(scalars[min(i, arrayLength(&scalars) - 1u)], 0.0, frame.scalars_per_cell == 1u);
    textureStore(transformed, texel_of(i), vec4f(at, scalar));
}
