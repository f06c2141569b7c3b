// Samples of a grid without coverage: all of each is there.
//
// Needs: `fn scalar_at(lattice: vec3f, texel: vec3i) -> f32`.

// The scalar at a point of the lattice, and how much of it is there.
fn sample_at(lattice: vec3f, texel: vec3i) -> vec2f {
    return vec2f(scalar_at(lattice, texel), 1.0);
}
