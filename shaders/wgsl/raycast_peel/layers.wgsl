// Layers: what peeling the boundary by sides needs, in one dispatch and one step per pass.
//
// A boundary face is drawn as the rectangle of pixels that may see it, and each ray decides
// whether it crosses the face: what a rasterizer would decide is rounded otherwise.

// Corner `index` of a rectangle's two triangles; left, bottom, right, top in clip space.
fn rectangle_corner(index: u32, rectangle: vec4f) -> vec4f {
    let right = index == 1u || index == 2u || index == 4u;
    let top = index == 2u || index == 4u || index == 5u;
    let x = select(rectangle.x, rectangle.z, right);
    return vec4f(x, select(rectangle.y, rectangle.w, top), 0.5, 1.0);
}

// 2⁻³⁰: nearer to 0 depths do not differ.
const LEAST_DEPTH: f32 = 9.313225746154785e-10;

// Depths fall as t grows, and differ wherever t differs in f32: the bits of |t| from 2⁻³⁰ to
// 2³³, normalized units, are 63 · 2²³ numbers, which fit twice into the normal numbers up
// to 1. What is nearer to 0 ties, and nothing is farther.
fn depth_of(t: f32) -> f32 {
    const LEAST: u32 = 0x30800000u; // of 2⁻³⁰
    const MOST: u32 = 0x50000000u;  // of 2³³
    let size = i32(clamp(bitcast<u32>(abs(t)), LEAST, MOST) - LEAST);
    return bitcast<f32>(u32(0x20000000 - select(size, -size, t < 0.0)));
}
