// Sides: on which side of the ray an edge passes, decided without any tolerance.
//
// Points are sheared so that the ray is the origin of the plane (Woop, Benthin, Wald
// 2013). The rounded point *is* the vertex for this ray, and every decision is an
// exact statement about rounded points: for any four points of the plane and an
// origin on none of their six lines, the origin lies in exactly 0 or 2 of the four
// triangles. So cells that share a face agree about it, whatever their shapes.

// Whether products are compared as integers: where the device does not round products of
// floats to the nearest number, which WGSL leaves open (`sides` of tetrascope-gpu asks).
override INTEGER_SIDES: bool = false;

// 2⁻⁶⁰: products of two of these are normal numbers.
const LEAST: f32 = 8.673617379884035e-19;

// A sheared point as `side` takes it: nearer to an axis than `LEAST` it is on the axis, so
// that no product underflows. The rounded point is the vertex, this one too.
fn on_grid(p: vec2f) -> vec2f {
    return select(p, vec2f(0.0), abs(p) < vec2f(LEAST));
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
    let order = side_rounded(a, b);
    if order == TIED {
        return side_exact(a, b);
    }
    return order;
}

// Neither side, as the rounded products are equal.
const TIED: i32 = 2;

fn side_rounded(a: vec2f, b: vec2f) -> i32 {
    if INTEGER_SIDES {
        return side_of_integers(a, b);
    }
    let left = a.x * b.y;
    let right = a.y * b.x;
    return select(select(TIED, -1, left < right), 1, left > right);
}

// The sides of the edges 01, 02, 03, and of 12, 13, 23.
struct Sides {
    of_first: vec3i,
    of_rest: vec3i,
}

fn sides(p0: vec2f, p1: vec2f, p2: vec2f, p3: vec2f) -> Sides {
    var s = Sides(
        vec3i(side_rounded(p0, p1), side_rounded(p0, p2), side_rounded(p0, p3)),
        vec3i(side_rounded(p1, p2), side_rounded(p1, p3), side_rounded(p2, p3)),
    );
    // Ties are rare. Software rasterizers run both sides of each branch, so one at a time
    // costs them a sixth of six.
    for (var n = 0u; n < 6u; n++) {
        let first = s.of_first == vec3i(TIED);
        let rest = s.of_rest == vec3i(TIED);
        if !any(first) && !any(rest) {
            break;
        }
        var a = p2;
        var b = p3;
        a = select(a, p1, rest.x || rest.y);
        b = select(b, p2, rest.x);
        a = select(a, p0, any(first));
        b = select(select(select(b, p3, first.z), p2, first.y), p1, first.x);
        let order = side_exact(a, b);
        // The tied edge that comes first, in the order of the fields.
        let chosen_first = first & vec3<bool>(true, !first.x, !(first.x || first.y));
        let chosen_rest = rest & vec3<bool>(!any(first), !any(first) && !rest.x, !any(first) && !(rest.x || rest.y));
        s.of_first = select(s.of_first, vec3i(order), chosen_first);
        s.of_rest = select(s.of_rest, vec3i(order), chosen_rest);
    }
    return s;
}

// For products that round to the same number. They differ by less than that number's
// last place, 2²⁴ units of a 48-bit product, so the lowest 32 bits of the products of
// the mantissas tell which is greater, once they count the same units. Without branches,
// as software rasterizers run both sides of each.
fn side_exact(a: vec2f, b: vec2f) -> i32 {
    let x = bitcast<vec4u>(vec4f(a.x, b.y, a.y, b.x));
    let biased = (x >> vec4u(23u)) & vec4u(0xffu);
    let mantissas = select(vec4u(0u), (x & vec4u(0x7fffffu)) | vec4u(0x800000u), biased != vec4u(0u));
    let signs = select(vec4i(1), vec4i(-1), (x >> vec4u(31u)) == vec4u(1u))
        * select(vec4i(1), vec4i(0), mantissas == vec4u(0u));
    let left = signs.x * signs.y;
    let right = signs.z * signs.w;
    let exponents = vec4i(biased);
    let apart = exponents.x + exponents.y - exponents.z - exponents.w;
    // Mantissas' products are within a factor of 4, so only one place apart is a tie.
    let shift = vec2u(max(vec2i(apart, -apart), vec2i(0))) & vec2u(31u);
    let low = vec2u(mantissas.x * mantissas.y, mantissas.z * mantissas.w) << shift;
    let nearly = select(left * sign(bitcast<i32>(low.x - low.y)), left * sign(apart), abs(apart) > 1);
    let order = select(nearly, sign(left - right), left != right);
    return select(perturbed(a, b), order, order != 0);
}

// An exact tie: the ray is moved by (e, e^2).
fn perturbed(a: vec2f, b: vec2f) -> i32 {
    let across = select(0, select(-1, 1, b.x > a.x), a.x != b.x);
    return select(across, select(-1, 1, a.y > b.y), a.y != b.y);
}

// As `side`, by the exact products of 48 bits, whatever the device rounds.
fn side_of_integers(a: vec2f, b: vec2f) -> i32 {
    let x = bitcast<vec4u>(vec4f(a.x, b.y, a.y, b.x));
    let biased = (x >> vec4u(23u)) & vec4u(0xffu);
    let mantissas = select(vec4u(0u), (x & vec4u(0x7fffffu)) | vec4u(0x800000u), biased != vec4u(0u));
    let signs = select(vec4i(1), vec4i(-1), (x >> vec4u(31u)) == vec4u(1u))
        * select(vec4i(1), vec4i(0), mantissas == vec4u(0u));
    let left = signs.x * signs.y;
    let right = signs.z * signs.w;
    if left != right {
        return sign(left - right);
    }
    let exponents = vec4i(biased);
    let apart = exponents.x + exponents.y - exponents.z - exponents.w;
    // Mantissas' products are within a factor of 4.
    var larger = sign(apart);
    if abs(apart) <= 1 {
        let p = product(mantissas.x, mantissas.y, u32(max(apart, 0)));
        let q = product(mantissas.z, mantissas.w, u32(max(-apart, 0)));
        larger = select(compare(p.x, q.x), compare(p.y, q.y), p.x == q.x);
    }
    let order = left * larger;
    return select(perturbed(a, b), order, order != 0);
}

// a b 2^shift for numbers of 24 bits and a shift of at most 1, as the bits from the 24th
// on and those below.
fn product(a: u32, b: u32, shift: u32) -> vec2u {
    let high = vec2u(a, b) >> vec2u(12u);
    let low = vec2u(a, b) & vec2u(0xfffu);
    let middle = high.x * low.y + low.x * high.y;
    let rest = (low.x * low.y + ((middle & 0xfffu) << 12u)) << shift;
    return vec2u(((high.x * high.y + (middle >> 12u)) << shift) + (rest >> 24u), rest & 0xffffffu);
}

fn compare(a: u32, b: u32) -> i32 {
    return select(select(0, -1, a < b), 1, a > b);
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
