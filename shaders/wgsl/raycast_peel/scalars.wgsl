// Scalars: vertices with other scalars, so that positions need no second upload.
//
// In:   vertices, and their new scalars, both lists of texels (common/texels.wgsl).
// Out:  vertices as the walk reads them.

@group(0) @binding(0) var vertices: texture_2d<f32>;
@group(0) @binding(1) var scalars: texture_2d<f32>;
@group(0) @binding(2) var merged: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(64)
fn cs_merge(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(vertices)) {
        return;
    }
    let position = textureLoad(vertices, id.xy, 0).xyz;
    textureStore(merged, id.xy, vec4f(position, textureLoad(scalars, id.xy, 0).x));
}
