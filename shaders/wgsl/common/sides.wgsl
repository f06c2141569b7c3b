// Sides: on which side of the ray an edge passes, decided without any tolerance.
//
// Points are sheared so that the ray is the origin of the plane (Woop, Benthin, Wald
// 2013). The rounded point *is* the vertex for this ray, and every decision is an
// exact statement about rounded points: for any four points of the plane and an
// origin on none of their six lines, the origin lies in exactly 0 or 2 of the four
// triangles. So cells that share a face agree about it, whatever their shapes.

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
