// Faces, 456 bytes per cell: twelve vertices of four numbers and eleven of 16 bits (§7).
//
// With: projection/faces.wgsl

// Position, offset.
@group(2) @binding(0) var<storage, read> placed: array<f32>;
// Two a word, low half first: two components of the normal and the adjacent normal, in
// [-1, 1]; the slot; the scalar, in [0, 1] of the field's range; the longest edge and the
// gradient, the upper halves of f32.
@group(2) @binding(1) var<storage, read> shaped: array<u32>;

fn half_word(index: u32) -> u32 {
    return (shaped[index / 2u] >> (16u * (index % 2u))) & 0xffffu;
}

fn signed(index: u32) -> f32 {
    return unpack2x16snorm(half_word(index)).x;
}

fn float(index: u32) -> f32 {
    return bitcast<f32>(half_word(index) << 16u);
}

fn face_vertex(cell: u32, corner: u32) -> FaceVertex {
    let p = 4u * (12u * cell + corner);
    let s = 11u * (12u * cell + corner);
    let n = vec2f(signed(s), signed(s + 1u));
    return FaceVertex(
        vec3f(placed[p], placed[p + 1u], placed[p + 2u]),
        vec3f(n, sqrt(max(1.0 - dot(n, n), 0.0))),
        placed[p + 3u],
        vec3f(signed(s + 2u), signed(s + 3u), signed(s + 4u)),
        float(s + 7u),
        vec3f(float(s + 8u), float(s + 9u), float(s + 10u)),
        mix(frame.scalar_range.x, frame.scalar_range.y, f32(half_word(s + 6u)) / 65535.0),
    );
}
