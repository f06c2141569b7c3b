// Walk: which face a ray crosses, decided without any tolerance.
//
// Each vertex is sheared once a ray so that the ray becomes the z axis (Woop,
// Benthin, Wald 2013). The rounded (x, y) then *is* the vertex for this ray,
// and every decision below is an exact statement about these rounded points:
// for any four points of the plane and an origin on none of their six lines,
// the origin lies in exactly 0 or 2 of the four triangles. So a ray that enters
// a cell leaves it, whatever its shape, and never comes back to it.

// One vertex as one ray sees it.
struct Corner {
    id: u32,
    xy: vec2f,     // across the ray, normalized units
    z: f32,        // along the ray's main axis, from the anchor
    scalar: f32,
}

// The ray in the shape that `corner` needs.
struct Shear {
    anchor: vec3f,    // a point of the ray near the middle of the mesh
    slope: vec2f,     // d.x / d.z and d.y / d.z after the axes are permuted
    axis: u32,        // the axis along which |d| is greatest: it becomes z
    depth: f32,       // t per unit of z
}

fn shear_of(anchor: vec3f, direction: vec3f) -> Shear {
    let size = abs(direction);
    var axis = 2u;
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
    } else if size.y >= size.z {
        axis = 1u;
    }
    let d = permute(direction, axis);
    return Shear(anchor, d.xy / d.z, axis, 1.0 / d.z);
}

// Cyclic, so that handedness stays.
fn permute(p: vec3f, axis: u32) -> vec3f {
    if axis == 2u {
        return p;
    }
    return select(p.zxy, p.yzx, axis == 0u);
}

// The only code that shears a vertex: the same vertex has the same bits wherever
// a ray meets it. `fma` may or may not be fused, but as one operation it is
// rounded in one way throughout a shader.
fn corner(id: u32, shear: Shear) -> Corner {
    let position = vec3f(positions[3u * id], positions[3u * id + 1u], positions[3u * id + 2u]);
    let p = permute(position - shear.anchor, shear.axis);
    var scalar = 0.0;
    if !SCALARS_PER_CELL {
        scalar = scalars[id];
    }
    return Corner(id, fma(-shear.slope, p.zz, p.xy), p.z, scalar);
}

// The sign of a.x b.y - a.y b.x: on which side of the origin the line from a to
// b passes. 0 only where a and b coincide.
//
// Two rounded products are compared, not subtracted, so there is nothing to
// fuse. Rounding is monotone: where the products differ their order is right.
// Where they are equal the exact products decide, and where those are equal the
// ray is moved by (e, e^2), e -> 0: the ray, not the mesh, so every face sees
// the same ray.
fn side(a: vec2f, b: vec2f) -> i32 {
    let left = a.x * b.y;
    let right = a.y * b.x;
    if left > right {
        return 1;
    }
    if left < right {
        return -1;
    }
    return side_exact(a, b);
}

fn side_exact(a: vec2f, b: vec2f) -> i32 {
    let order = compare_products(a.x, b.y, a.y, b.x);
    if order != 0 {
        return order;
    }
    if a.y != b.y {
        return select(-1, 1, a.y > b.y);
    }
    if a.x != b.x {
        return select(-1, 1, b.x > a.x);
    }
    return 0;
}

// An exact product of two f32: sign, a 48-bit magnitude with its top bit set (or
// zero), and the power of two of its lowest bit.
struct Product {
    sign: i32,
    exponent: i32,
    high: u32, // the upper 24 bits
    low: u32,  // the lower 24 bits
}

fn exact_product(a: f32, b: f32) -> Product {
    let bits_a = bitcast<u32>(a);
    let bits_b = bitcast<u32>(b);
    let mantissa_a = mantissa(bits_a);
    let mantissa_b = mantissa(bits_b);
    if mantissa_a == 0u || mantissa_b == 0u {
        return Product(0, 0, 0u, 0u);
    }
    // 24 x 24 bits by halves of 12.
    let a1 = mantissa_a >> 12u;
    let a0 = mantissa_a & 0xfffu;
    let b1 = mantissa_b >> 12u;
    let b0 = mantissa_b & 0xfffu;
    let middle = a1 * b0 + a0 * b1; // under 2^25
    let low_sum = a0 * b0 + ((middle & 0xfffu) << 12u); // under 2^25
    var low = low_sum & 0xffffffu;
    var high = a1 * b1 + (middle >> 12u) + (low_sum >> 24u);
    var exponent = i32((bits_a >> 23u) & 0xffu) + i32((bits_b >> 23u) & 0xffu);
    if high < 0x800000u { // 47 bits: the product of two normal numbers has 47 or 48
        high = (high << 1u) | (low >> 23u);
        low = (low << 1u) & 0xffffffu;
        exponent -= 1;
    }
    let negative = ((bits_a ^ bits_b) >> 31u) == 1u;
    return Product(select(1, -1, negative), exponent, high, low);
}

// Subnormal numbers count as zero, as hardware may flush them: the mesh is
// normalized to size 1, so they are 2^-100 of its size.
fn mantissa(bits: u32) -> u32 {
    return select(0u, (bits & 0x7fffffu) | 0x800000u, ((bits >> 23u) & 0xffu) != 0u);
}

// The order of a b and c d, exact: -1, 0 or 1.
fn compare_products(a: f32, b: f32, c: f32, d: f32) -> i32 {
    let p = exact_product(a, b);
    let q = exact_product(c, d);
    if p.sign != q.sign {
        return select(-1, 1, p.sign > q.sign);
    }
    if p.exponent != q.exponent {
        return select(-p.sign, p.sign, p.exponent > q.exponent);
    }
    if p.high != q.high {
        return select(-p.sign, p.sign, p.high > q.high);
    }
    if p.low != q.low {
        return select(-p.sign, p.sign, p.low > q.low);
    }
    return 0;
}

// On which side all three edges of a crossed face pass, or 0 where it is not crossed.
fn crossing(a: vec2f, b: vec2f, c: vec2f) -> i32 {
    let turn = side(a, b);
    if turn == 0 || side(b, c) != turn || side(c, a) != turn {
        return 0;
    }
    return turn;
}

// Twice the area that the origin spans with the edge from a to b: the weight of
// the corner opposite. `turn` makes it positive; rounding cannot make it
// negative, as the order of the products is known.
fn weight(a: vec2f, b: vec2f, turn: f32) -> f32 {
    return max(turn * (a.x * b.y - a.y * b.x), 0.0);
}

// z and scalar where the ray crosses face abc. Convex weights: no sliver can
// push either outside the range of its corners.
fn crossing_point(a: Corner, b: Corner, c: Corner, turn: f32) -> vec2f {
    let wa = weight(b.xy, c.xy, turn);
    let wb = weight(c.xy, a.xy, turn);
    let wc = weight(a.xy, b.xy, turn);
    let sum = wa + wb + wc;
    let zs = wa * vec2f(a.z, a.scalar) + wb * vec2f(b.z, b.scalar) + wc * vec2f(c.z, c.scalar);
    if sum > 0.0 {
        return zs / sum;
    }
    // The face is seen edge on.
    return (vec2f(a.z, a.scalar) + vec2f(b.z, b.scalar) + vec2f(c.z, c.scalar)) / 3.0;
}
