// Faces, 720 bytes per cell: twelve vertices of fifteen numbers (§6).
//
// In two buffers, as devices may not bind as much as large meshes need in one.
// With: projection/faces.wgsl

// Position, offset; then gradient, scalar.
@group(2) @binding(0) var<storage, read> placed: array<f32>;
// Two components of the normal, the slot, the longest edge; then the adjacent normal.
@group(2) @binding(1) var<storage, read> shaped: array<f32>;

fn face_vertex(cell: u32, corner: u32) -> FaceVertex {
    let p = 8u * (12u * cell + corner);
    let s = 7u * (12u * cell + corner);
    let n = vec2f(shaped[s], shaped[s + 1u]);
    return FaceVertex(
        vec3f(placed[p], placed[p + 1u], placed[p + 2u]),
        // Equation 4.
        vec3f(n, sqrt(max(1.0 - dot(n, n), 0.0))),
        placed[p + 3u],
        vec3f(shaped[s + 4u], shaped[s + 5u], shaped[s + 6u]),
        shaped[s + 3u],
        vec3f(placed[p + 4u], placed[p + 5u], placed[p + 6u]),
        placed[p + 7u],
    );
}
