// Triangles: a tetrahedron as it is seen, a fan of triangles between its outline and a vertex inside.
//
// Shirley & Tuchman 1990, as in Westermann 2001 section 2.1. The mirror of `triangles.rs`, where the
// classes are explained and tested.
// With: common/sides.wgsl

// Points are (x, y, depth, scalar); x to the right and y upwards make what is counterclockwise.
struct Fan {
    center: vec2f,    // the vertex inside
    front: vec2f,     // depth and scalar there, where the depth is less
    back: vec2f,      // and where it is greater
    outline: u32,     // corners counterclockwise, two bits each, the first lowest
    sides: u32,       // of the outline: 3, 4, or 0 for a cell without volume
    triangles: u32,   // those with an area: 3, 4, 2, 1 in classes 1, 2, 3, 4
}

// Thinner than this share of its depth, 2^-22, a cell has no volume: as much is rounding.
const FLAT: f32 = 2.384185791015625e-7;

fn fan_of(corners: array<vec4f, 4>) -> Fan {
    var p = corners;
    // Shares of the point that two parts of the corners have in common (Radon): their sum, and
    // that of shares times corners, is 0.
    let shares = vec4f(
        area(p[1], p[2], p[3]),
        -area(p[0], p[2], p[3]),
        area(p[0], p[1], p[3]),
        -area(p[0], p[1], p[2]),
    );
    let turns = vec4i(
        turn(p[1], p[2], p[3]),
        -turn(p[0], p[2], p[3]),
        turn(p[0], p[1], p[3]),
        -turn(p[0], p[1], p[2]),
    );
    let above = turns > vec4i(0);
    let below = turns < vec4i(0);
    let ones = select(vec4u(0u), vec4u(1u), above);
    let others = select(vec4u(0u), vec4u(1u), below);
    let count = ones.x + ones.y + ones.z + ones.w;
    let count_below = others.x + others.y + others.z + others.w;
    if count == 0u || count_below == 0u {
        return Fan();
    }
    let depths = vec4f(p[0].z, p[1].z, p[2].z, p[3].z);
    let least = min(min(depths.x, depths.y), min(depths.z, depths.w));
    let greatest = max(max(depths.x, depths.y), max(depths.z, depths.w));
    var fan = Fan();
    var one: vec2f;
    var other: vec2f;
    if count == 1u || count_below == 1u {
        // One corner is inside of the three others' triangle, or on its edge or corner.
        let lone = first_of(select(below, above, count == 1u));
        let x = select(0u, 1u, lone == 0u);
        let y = select(1u, 2u, lone <= 1u);
        let z = select(2u, 3u, lone <= 2u);
        let at = vec4f(p[lone].xy, 0.0, 0.0);
        let is_left = turn(p[x], p[y], p[z]) > 0;
        fan.center = p[lone].xy;
        one = p[lone].zw;
        other = mean_where_crossed(p[x] - at, p[y] - at, p[z] - at);
        fan.outline = x | (select(z, y, is_left) << 2u) | (select(y, z, is_left) << 4u);
        fan.sides = 3u;
        fan.triangles = count + count_below - 1u;
    } else {
        // Two edges cross, between the corners above and those below.
        let above_ends = ends_of(above);
        let below_ends = ends_of(below);
        let first = p[above_ends.y].xy - p[above_ends.x].xy;
        let second = p[below_ends.y].xy - p[below_ends.x].xy;
        // The point is taken on the shorter one, and the place on the longer from it: so it is beside
        // both by no more than rounding, even where they are almost parallel.
        let is_first = dot(first, first) <= dot(second, second);
        let on = select(below_ends, above_ends, is_first);
        let other_edge = select(above_ends, below_ends, is_first);
        let share = shares[on.y] / (shares[on.x] + shares[on.y]);
        let point = mix_points(p[on.x], p[on.y], clamp(share, 0.0, 1.0));
        let edge = p[other_edge.y].xy - p[other_edge.x].xy;
        let along = dot(point.xy - p[other_edge.x].xy, edge) / max(dot(edge, edge), 1e-37);
        fan.center = point.xy;
        one = point.zw;
        other = mix_points(p[other_edge.x], p[other_edge.y], clamp(along, 0.0, 1.0)).zw;
        let is_left = first.x * second.y > first.y * second.x;
        let from_right = select(below_ends.yx, below_ends, is_left);
        fan.outline = above_ends.x | (from_right.x << 2u) | (above_ends.y << 4u) | (from_right.y << 6u);
        fan.sides = 4u;
        fan.triangles = 4u;
    }
    if abs(one.x - other.x) <= FLAT * (greatest - least) {
        return Fan();
    }
    let is_front = one.x < other.x;
    fan.front = select(other, one, is_front);
    fan.back = select(one, other, is_front);
    return fan;
}

// The corner at place `i` of the outline.
fn corner_of(outline: u32, i: u32) -> u32 {
    return (outline >> (2u * i)) & 3u;
}

fn mix_points(a: vec4f, b: vec4f, share: f32) -> vec4f {
    return a + share * (b - a);
}

// Twice the area of abc as it is seen, positive if counterclockwise.
fn area(a: vec4f, b: vec4f, c: vec4f) -> f32 {
    let ab = b.xy - a.xy;
    let ac = c.xy - a.xy;
    return ab.x * ac.y - ab.y * ac.x;
}

// Its sign. Products are compared, not subtracted, so that there is nothing to fuse.
fn turn(a: vec4f, b: vec4f, c: vec4f) -> i32 {
    let ab = b.xy - a.xy;
    let ac = c.xy - a.xy;
    let left = ab.x * ac.y;
    let right = ab.y * ac.x;
    return select(select(0, -1, left < right), 1, left > right);
}

fn first_of(which: vec4<bool>) -> u32 {
    return select(select(select(3u, 2u, which.z), 1u, which.y), 0u, which.x);
}

// The first and the last.
fn ends_of(which: vec4<bool>) -> vec2u {
    let last = select(select(select(0u, 1u, which.y), 2u, which.z), 3u, which.w);
    return vec2u(first_of(which), last);
}
