// Face: a triangle at the center of a pixel, exactly.
//
// Prakash, Manohar 1995 section 2.2 goes from pixel to pixel by increments, in which nothing is lost
// here; so a pixel by itself is the same. `fixed.rs` does it as published.
// With: voxel_hw/wide.wgsl, voxel_hw/work.wgsl

// Whether a cell may be 128 voxels wide or wider: then areas need more than 32 bits.
override WIDE: bool = false;

// What frame- and z-buffer hold.
struct Fragment {
    voxel: i32,    // the first voxel whose center is not in front of the face
    depth: i32,    // in 2⁻¹⁹ voxels, rounded down
    scalar: i32,   // in 2⁻³⁰ of the range, rounded down
}

// a.x b.y - a.y b.x for corners relative to the pixel's center.
fn turn(a: vec2i, b: vec2i) -> vec2u {
    if WIDE {
        return wide_difference(wide_times(wide_of(a.x), b.y), wide_times(wide_of(a.y), b.x));
    }
    return wide_of(a.x * b.y - a.y * b.x);
}

// u · (v × w).
fn six_volumes(u: vec3i, v: vec3i, w: vec3i) -> vec2u {
    let across = wide_sum(wide_times(turn(v.yz, w.yz), u.x), wide_times(turn(v.zx, w.zx), u.y));
    return wide_sum(across, wide_times(turn(v.xy, w.xy), u.z));
}

// The sign of it: on which side of the center the line from a to b passes. Where it is 0 the center
// is moved by (e, e²), e → 0; 0 only where a and b coincide.
fn side(a: vec2i, b: vec2i) -> i32 {
    let moved = select(sign(b.x - a.x), sign(a.y - b.y), a.y != b.y);
    if WIDE {
        let t = turn(a, b);
        return select(select(1, -1, is_negative(t)), moved, all(t == vec2u(0u)));
    }
    let t = a.x * b.y - a.y * b.x;
    return select(sign(t), moved, t == 0);
}

// Face abc at the pixel's center, which it covers.
fn fragment_of(a: vec4i, b: vec4i, c: vec4i) -> Fragment {
    // Twice the areas opposite to the corners, of one sign or 0.
    let all_of_a = turn(b.xy, c.xy);
    let all_of_b = turn(c.xy, a.xy);
    let all_of_c = turn(a.xy, b.xy);
    let negative = is_negative(all_of_a) || is_negative(all_of_b) || is_negative(all_of_c);
    let of_a = narrowed(wide_negated(all_of_a, negative));
    let of_b = narrowed(wide_negated(all_of_b, negative));
    let of_c = narrowed(wide_negated(all_of_c, negative));
    let area = narrowed(wide_sum(of_a, wide_sum(of_b, of_c)));
    let inverse = 1.0 / float_of(area);
    let ab = b - a;
    let ac = c - a;
    let depths = wide_sum(wide_times(of_b, ab.z), wide_times(of_c, ac.z));
    let scalars = wide_sum(wide_times(of_b, ab.w), wide_times(of_c, ac.w));
    let depth = scaled(a.z, depths, area, inverse, DEPTH_BITS - PLACE_BITS);
    let scalar = scaled(a.w, scalars, area, inverse, VALUE_BITS - SCALAR_BITS);
    let ceiling = depth.whole + select(1, 0, all(depth.rest == vec2u(0u)));
    const HALF: i32 = 1 << (DEPTH_BITS - 1u);
    return Fragment((ceiling + HALF - 1) >> DEPTH_BITS, depth.whole, scalar.whole);
}

// A number that is not negative, of 32 bits where no cell is wide: so compilers can tell.
fn narrowed(a: vec2u) -> vec2u {
    return vec2u(a.x, select(0u, a.y, WIDE));
}

// (base + n / d) 2^bits, rounded down.
fn scaled(base: i32, n: vec2u, d: vec2u, inverse: f32, bits: u32) -> Quotient {
    if WIDE {
        let coarse = quotient(n, d, inverse);
        let fine = small_quotient(wide_shifted(coarse.rest, bits), d, inverse);
        return Quotient(((base + coarse.whole) << bits) + fine.whole, fine.rest);
    }
    // n is below 2³¹ 2¹⁵ for depths, and 2³¹ 2²⁴ for scalars, twice: 2⁵⁸ and 2⁶² with their bits.
    let found = quotient(wide_shifted(n, bits), d, inverse);
    return Quotient((base << bits) + found.whole, found.rest);
}
