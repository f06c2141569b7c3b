// Put: a table of optical depth or opacity, for what has no light.

@group(0) @binding(1) var filled: texture_storage_3d<r32float, write>;

fn put(at: vec3u, sum: vec4f) {
    textureStore(filled, at, vec4f(sum.w, 0.0, 0.0, 0.0));
}
