// Put: a sample that is in the mesh.

@group(1) @binding(0) var samples: texture_storage_3d<rg32float, write>;

fn put(texel: vec3i, scalar: f32) {
    textureStore(samples, texel, vec4f(scalar, 1.0, 0.0, 0.0));
}
