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

fn sides(p0: vec2f, p1: vec2f, p2: vec2f, p3: vec2f) -> Sides {
    if INTEGER_SIDES {
        return Sides(
            vec3i(side(p0, p1), side(p0, p2), side(p0, p3)) > vec3i(0),
            vec3i(side(p1, p2), side(p1, p3), side(p2, p3)) > vec3i(0),
        );
    }
    let l_first = vec3f(p0.x * p1.y, p0.x * p2.y, p0.x * p3.y);
    let r_first = vec3f(p0.y * p1.x, p0.y * p2.x, p0.y * p3.x);
    let l_rest = vec3f(p1.x * p2.y, p1.x * p3.y, p2.x * p3.y);
    let r_rest = vec3f(p1.y * p2.x, p1.y * p3.x, p2.y * p3.x);
    var s = Sides(l_first > r_first, l_rest > r_rest);
    // Ties are rare. Software rasterizers run both sides of each branch, so one at a time
    // costs them a sixth of six.
    var tied_first = l_first == r_first;
    var tied_rest = l_rest == r_rest;
    for (var n = 0u; n < 6u; n++) {
        if !(any(tied_first) | any(tied_rest)) {
            break;
        }
        // The tied edge that comes first, in the order of the fields.
        let of_p0 = any(tied_first);
        let of_p1 = tied_rest.x | tied_rest.y;
        let to_p2 = select(tied_rest.x, !tied_first.x & tied_first.y, of_p0);
        let a = select(select(p2, p1, of_p1), p0, of_p0);
        let b = select(select(p3, p2, to_p2), p1, tied_first.x);
        let order = side_exact(a, b) > 0;
        let chosen_first = tied_first
            & vec3<bool>(true, !tied_first.x, !(tied_first.x | tied_first.y));
        let chosen_rest = tied_rest
            & vec3<bool>(!of_p0, !(of_p0 | tied_rest.x), !(of_p0 | of_p1));
        s.of_first = select(s.of_first, vec3<bool>(order), chosen_first);
        s.of_rest = select(s.of_rest, vec3<bool>(order), chosen_rest);
        tied_first = tied_first & !chosen_first;
        tied_rest = tied_rest & !chosen_rest;
    }
    return s;
}

// For products that round to the same number. They differ by less than that number's
// last place, 2²⁴ units of a 48-bit product, so the lowest 32 bits of the products of
// the mantissas tell which is greater, once they count the same units. Where the rounded
// products are 0 so are the exact ones, as none underflows. Without branches, as software
// rasterizers run both sides of each.
fn side_exact(a: vec2f, b: vec2f) -> i32 {
    let x = bitcast<vec4u>(vec4f(a.x, b.y, a.y, b.x));
    let exponents = vec4i((x >> vec4u(23u)) & vec4u(0xffu));
    let mantissas = (x & vec4u(0x7fffffu)) | vec4u(0x800000u);
    // Mantissas' products are within a factor of 4, so only one place apart is a tie.
    let apart = exponents.x + exponents.y - exponents.z - exponents.w;
    let left = (mantissas.x * mantissas.y) << u32(max(apart, 0) & 1);
    let right = (mantissas.z * mantissas.w) << u32(max(-apart, 0) & 1);
    let more = bitcast<i32>(left - right);
    let rounded = a.x * b.y;
    let order = select(-1, 1, (more > 0) == (rounded > 0.0));
    return select(order, perturbed(a, b), (more == 0) | (rounded == 0.0));
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

// z and w where the ray crosses face abc, between its corners': a's, and shares of b's and c's
// differences from it, so that what rounding leaves is relative to the face's extent and not to
// its place, and a constant stays one. Where the face is seen edge on, those of its middle.
fn mean_where_crossed(a: vec4f, b: vec4f, c: vec4f) -> vec2f {
    let ab = b - a;
    let ac = c - a;
    let share = shares(a.xy, ab.xy, ac.xy);
    return a.zw + (share.x * ab.zw + share.y * ac.zw);
}

// The shares of b and c where the ray crosses face abc, neither negative: those of which
// a + x ab + y ac = 0.
//
// Products of f32 err by 2^-24 of themselves, so for a sliver, l long and h wide as the ray sees
// it, they name a point up to e l beside the ray, e = 2^-24 l / h: much farther than vertices are
// rounded. What is left of the equation is solved once more. That leaves some 2^-24 l, as if the
// ray had moved, and e^2 l.
fn shares(a: vec2f, ab: vec2f, ac: vec2f) -> vec2f {
    let area = ab.x * ac.y - ab.y * ac.x;
    let is_edge_on = abs(area) < 1e-37;
    let scale = 1.0 / select(area, 1.0, is_edge_on);
    let x = scale * vec2f(-ac.y, ab.y);
    let y = scale * vec2f(ac.x, -ab.x);
    let rough = a.x * x + a.y * y;
    let left = a + rough.x * ab + rough.y * ac;
    let share = rough + (left.x * x + left.y * y);
    return select(max(share, vec2f(0.0)), vec2f(1.0 / 3.0), is_edge_on);
}
