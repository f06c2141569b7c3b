// Put: a table of light, and of opacity in alpha.

@group(0) @binding(1) var filled: texture_storage_3d<rgba32float, write>;

fn put(at: vec3u, sum: vec4f) {
    textureStore(filled, at, sum);
}
