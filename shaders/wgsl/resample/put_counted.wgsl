// Put: a sample that is in the mesh, and how often each was put there, for tests.

@group(1) @binding(0) var samples: texture_storage_3d<rg32float, write>;
// How often each sample was written, x fastest.
@group(1) @binding(1) var<storage, read_write> writes: array<atomic<u32>>;

fn put(texel: vec3i, scalar: f32) {
    textureStore(samples, texel, vec4f(scalar, 1.0, 0.0, 0.0));
    let size = vec3i(textureDimensions(samples));
    atomicAdd(&writes[texel.x + size.x * (texel.y + size.y * texel.z)], 1u);
}
