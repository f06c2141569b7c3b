// Footprint: a triangle or quadrilateral around each cell, a little larger than its silhouette.
//
// The rasterizer only proposes pixels: it rounds vertices to a grid of its own, so
// which pixels are the cell's is decided in each of them (chord.wgsl).
//
// The four corners of a cell are four vertices, each of which sees the whole cell; so
// this avoids loops and indexed arrays, which cost software rasterizers most.
// In:   drawn, cells, ranges, transformed; four corners of each by a fixed index buffer.
// Out:  Varying.
// With: projection/frame.wgsl, projection/mesh.wgsl, projection/transfer.wgsl,
//       projection/pieces.wgsl

struct Varying {
    @builtin(position) position: vec4f,
    // The cell's vertices: camera space, and the scalar.
    @location(0) @interpolate(flat) v0: vec4f,
    @location(1) @interpolate(flat) v1: vec4f,
    @location(2) @interpolate(flat) v2: vec4f,
    @location(3) @interpolate(flat) v3: vec4f,
    // The first and the last interval of the cell's scalars.
    @location(4) @interpolate(flat) range: vec2u,
    // Where `PIECES`: see pieces.wgsl.
    @location(5) @interpolate(flat) at_low: vec4f,
    @location(6) @interpolate(flat) at_high: vec4f,
    @location(7) @interpolate(flat) piece: vec4f,
    // What a fragment needs of `frame`: software rasterizers read a uniform lane by lane,
    // and this once.
    @location(8) @interpolate(flat) per_pixel: vec4f, // of the image in [−1, 1], y down; extent
    @location(9) @interpolate(flat) per_depth: vec3f, // slope; the eye's depth
}

@vertex
fn vs_cell(@builtin(vertex_index) index: u32) -> Varying {
    let item = cell_of(drawn[index / 4u]);
    let cell = item.x;
    let v = cells[cell];
    let range = ranges[cell];
    var out: Varying;
    out.v0 = vertex(v.x);
    out.v1 = vertex(v.y);
    out.v2 = vertex(v.z);
    out.v3 = vertex(v.w);
    if SCALARS_PER_CELL {
        let scalar = scalars[cell];
        out.v0.w = scalar;
        out.v1.w = scalar;
        out.v2.w = scalar;
        out.v3.w = scalar;
    }
    out.range = vec2u(range & 0xffffu, range >> 16u);
    let corners = Corners(
        vec4f(out.v0.x, out.v1.x, out.v2.x, out.v3.x),
        vec4f(out.v0.y, out.v1.y, out.v2.y, out.v3.y),
        vec4f(out.v0.z, out.v1.z, out.v2.z, out.v3.z),
    );
    let pixel = footprint(corners, index % 4u);
    out.position = vec4f(2.0 * pixel / frame.size, 0.5, 1.0);
    out.per_pixel = vec4f(2.0 / frame.size, frame.extent);
    out.per_depth = vec3f(frame.slope, -frame.anchor_depth);
    if PIECES {
        choose_piece(&out, item.y);
    }
    return out;
}

// A cell's vertices in camera space.
struct Corners {
    x: vec4f,
    y: vec4f,
    z: vec4f,
}

// The same in the image: pixels from its center, y up.
struct Flat {
    x: vec4f,
    y: vec4f,
}

fn least(v: vec4f) -> f32 {
    return min(min(v.x, v.y), min(v.z, v.w));
}

fn greatest(v: vec4f) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// The corner of the footprint, in pixels from the image's center, y up.
fn footprint(p: Corners, corner: u32) -> vec2f {
    let per_unit = 0.5 * frame.size * frame.clip_per_unit;
    let w = frame.w_per_depth * (p.z + frame.anchor_depth) + frame.w_constant;
    let nearest = least(w);
    let divisor = max(w, vec4f(frame.near));
    let q = Flat(p.x * per_unit.x / divisor, p.y * per_unit.y / divisor);
    if nearest <= frame.near || greatest(max(abs(q.x), abs(q.y))) > LARGEST {
        return box_in_view(p, w, q, per_unit, corner);
    }
    // What f32 loses of camera space, a few 2⁻²³ of coordinates up to 2, in pixels.
    let scale = max(per_unit.x, per_unit.y) * (1.0 + max(frame.slope.x, frame.slope.y));
    let margin = MARGIN + ROUNDING * scale / nearest;
    return grown_hull(q, margin, corner);
}

// The least that Vulkan lets a rasterizer resolve is 1/16 of a pixel: vertices move by
// half of that each way.
const MARGIN: f32 = 0.0625;
const ROUNDING: f32 = 9.5367431640625e-7; // 2⁻²⁰
// f32 resolves 1/512 of a pixel there.
const LARGEST: f32 = 16384.0;

// A cell that reaches the eye's plane, or far out of the image: the box around the
// part before the eye, cut to the image.
fn box_in_view(p: Corners, w: vec4f, q: Flat, per_unit: vec2f, corner: u32) -> vec2f {
    let seen = w > vec4f(frame.near);
    let none = vec4f(1e30);
    var low = vec2f(least(select(none, q.x, seen)), least(select(none, q.y, seen)));
    var high = vec2f(greatest(select(-none, q.x, seen)), greatest(select(-none, q.y, seen)));
    // Where edges 01, 02, 03 and 12, 13, 23 pass the near plane.
    let scale = per_unit / frame.near;
    let a = cuts(w.xxx, w.yzw);
    let a_x = scale.x * mix(p.x.xxx, p.x.yzw, a);
    let a_y = scale.y * mix(p.y.xxx, p.y.yzw, a);
    let b = cuts(w.yyz, w.zww);
    let b_x = scale.x * mix(p.x.yyz, p.x.zww, b);
    let b_y = scale.y * mix(p.y.yyz, p.y.zww, b);
    let a_cut = seen.xxx != seen.yzw;
    let b_cut = seen.yyz != seen.zww;
    let far = vec3f(1e30);
    low = min(low, vec2f(
        least(min(select(far, a_x, a_cut), select(far, b_x, b_cut)).xyzz),
        least(min(select(far, a_y, a_cut), select(far, b_y, b_cut)).xyzz),
    ));
    high = max(high, vec2f(
        greatest(max(select(-far, a_x, a_cut), select(-far, b_x, b_cut)).xyzz),
        greatest(max(select(-far, a_y, a_cut), select(-far, b_y, b_cut)).xyzz),
    ));
    // Near the eye rounding is worth many pixels; it is a small share of how far out
    // they are, and what is behind the eye gives an empty box.
    let border = 0.5 * frame.size + 2.0;
    let slack = 1.0 + 1e-3 * max(abs(low), abs(high));
    low = clamp(low - slack, -border, border);
    high = clamp(high + slack, -border, border);
    return select(low, high, far_sides(corner));
}

// Where w is `frame.near` on the way from `from_w` to `to_w`.
fn cuts(from_w: vec3f, to_w: vec3f) -> vec3f {
    let along = to_w - from_w;
    return (frame.near - from_w) / select(along, vec3f(1.0), along == vec3f(0.0));
}

// Which sides of a box meet in its corner, around it.
fn far_sides(corner: u32) -> vec2<bool> {
    return vec2<bool>(corner == 1u || corner == 2u, corner >= 2u);
}

fn cross2(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

fn pick(q: Flat, index: u32) -> vec2f {
    let pair_x = select(q.x.xz, q.x.yw, index % 2u == 1u);
    let pair_y = select(q.y.xz, q.y.yw, index % 2u == 1u);
    return select(vec2f(pair_x.x, pair_y.x), vec2f(pair_x.y, pair_y.y), index >= 2u);
}

// Around the hull of four points by which of the numbers w, Σ w = 0, Σ w q = 0, are
// positive (bit i for w of point i, or of their opposites where that has bit 3): the
// points of one sign are on a diagonal, or alone inside the triangle of the others (Radon).
// Two bits per corner, the first lowest; a triangle repeats its last point.
//     0: 0000 all on a line   1: 1233   2: 0233   3: 0213
//     4: 0133                 5: 0123   6: 0132   7: 0122
const RINGS: vec4u = vec4u(0xf900u, 0xd8f8u, 0xe4f4u, 0xa4b4u);

fn ring_of(bits: u32) -> u32 {
    let pairs = select(
        select(RINGS.x, RINGS.y, bits >= 2u),
        select(RINGS.z, RINGS.w, bits >= 6u),
        bits >= 4u,
    );
    return select(pairs & 0xffu, pairs >> 8u, bits % 2u == 1u);
}

// Corners around a convex polygon; a triangle repeats its last one.
struct Ring {
    a: vec2f,
    b: vec2f,
    c: vec2f,
    d: vec2f,
    triangle: bool,
}

// A quadrilateral as a triangle around it where that is little larger: without one of its
// sides, the two beside it prolonged until they meet. Else with its shorter diagonal from a
// to c, along which two triangles meet. Blocks of pixels there are shaded twice.
fn in_few_triangles(h: Ring) -> Ring {
    let e0 = h.b - h.a;
    let e1 = h.c - h.b;
    let e2 = h.d - h.c;
    let e3 = h.a - h.d;
    let x = vec4f(e0.x, e1.x, e2.x, e3.x);
    let y = vec4f(e0.y, e1.y, e2.y, e3.y);
    // Of each side and the one before, and of the one after and the one before.
    let turns = x.wxyz * y - y.wxyz * x;
    let opens = x.wxyz * y.yzwx - y.wxyz * x.yzwx;
    // Where those two meet, in lengths of each.
    let divisors = select(vec4f(1e-30), opens, opens != vec4f(0.0));
    let behind = turns.yzwx / divisors;
    let before = turns / divisors;
    let area = abs(turns.x + turns.z);
    let added = abs(behind * turns);
    let fits = (min(behind, before) > vec4f(0.0)) & (max(behind, before) <= vec4f(LONGEST))
        & (added <= vec4f(MOST_ADDED * area));
    let cost = select(vec4f(1e30), added, fits);
    let cheapest = least(cost);
    if h.triangle {
        return h;
    }
    if cheapest >= 1e30 {
        if dot(h.d - h.b, h.d - h.b) < dot(h.c - h.a, h.c - h.a) {
            return Ring(h.b, h.c, h.d, h.a, false);
        }
        return h;
    }
    if cost.x == cheapest {
        return Ring(h.a + behind.x * e3, h.c, h.d, h.d, true);
    }
    if cost.y == cheapest {
        return Ring(h.b + behind.y * e0, h.d, h.a, h.a, true);
    }
    if cost.z == cheapest {
        return Ring(h.c + behind.z * e1, h.a, h.b, h.b, true);
    }
    return Ring(h.d + behind.w * e2, h.b, h.c, h.c, true);
}

// A share of the area: the fragments around a cell cost, too.
const MOST_ADDED: f32 = 0.2;
// Keeps tips near: a far one is sharp, and one that is too sharp (`SHARPEST`) makes the
// footprint a box. A choice; the picture does not depend on it. Rounding moves a tip across a
// side by a few 2⁻²⁴ of the triangle's size, below `LARGEST` far less than `MARGIN`.
const LONGEST: f32 = 4.0;

// A corner of the convex hull of q, its sides moved outward by `margin` pixels. Where
// that makes a tip too long, of the box along the longest edge.
fn grown_hull(q: Flat, margin: f32, corner: u32) -> vec2f {
    let q0 = vec2f(q.x.x, q.y.x);
    let a = vec2f(q.x.y, q.y.y) - q0;
    let b = vec2f(q.x.z, q.y.z) - q0;
    let c = vec2f(q.x.w, q.y.w) - q0;
    let w = vec4f(cross2(b - a, c - a), -cross2(b, c), cross2(a, c), -cross2(a, b));
    let bits = dot(select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), w > vec4f(0.0)), vec4u(1u));
    let ring = ring_of(select(bits, 15u - bits, bits >= 8u));
    let hull = in_few_triangles(Ring(
        pick(q, ring & 3u),
        pick(q, (ring >> 2u) & 3u),
        pick(q, (ring >> 4u) & 3u),
        pick(q, ring >> 6u),
        ((ring >> 4u) & 3u) == ring >> 6u,
    ));
    let h0 = hull.a;
    let h1 = hull.b;
    let h2 = hull.c;
    let h3 = hull.d;
    let triangle = hull.triangle;
    // From each corner to the next; a triangle's last side comes twice.
    let e0 = h1 - h0;
    let e1 = h2 - h1;
    let e2 = select(h3, h0, triangle) - h2;
    let e3 = h0 - h3;
    let x = vec4f(e0.x, e1.x, e2.x, e3.x);
    let y = vec4f(e0.y, e1.y, e2.y, e3.y);
    let lengths = sqrt(x * x + y * y);
    // Of each side and the one before.
    let turns = x.wxyz * y - y.wxyz * x;
    let turn = sign(turns.y);
    let scale = turn / max(lengths, vec4f(SHORTEST));
    let n_x = y * scale;
    let n_y = -x * scale;
    let cosines = 1.0 + n_x.wxyz * n_x + n_y.wxyz * n_y;
    let bends = select(turn * turns, vec4f(1.0), vec4<bool>(false, false, false, triangle));
    let fits = turn != 0.0 && least(lengths) >= SHORTEST && least(bends) > 0.0
        && least(cosines) >= SHARPEST;
    if !fits {
        return box_along(q, margin, corner);
    }
    let mine = vec4<bool>(corner == 0u, corner == 1u, corner == 2u || (triangle && corner == 3u),
        corner == 3u && !triangle);
    let reach = select(vec4f(0.0), margin / max(cosines, vec4f(SHARPEST)), mine);
    let here = select(select(h0, h1, mine.y), select(h2, h3, mine.w), mine.z || mine.w);
    return here + vec2f(dot(n_x.wxyz + n_x, reach), dot(n_y.wxyz + n_y, reach));
}

// Pixels; of shorter edges rounding makes the direction.
const SHORTEST: f32 = 0.015625;
// 2/16²: a tip moves by √(2/SHARPEST) = 16 margins, a pixel.
const SHARPEST: f32 = 0.0078125;

fn box_along(q: Flat, margin: f32, corner: u32) -> vec2f {
    // Edges 01, 02, 03 and 12, 13, 23; the longest one.
    let a = vec3f(q.x.yzw - q.x.xxx);
    let b = vec3f(q.y.yzw - q.y.xxx);
    let c = vec3f(q.x.zww - q.x.yyz);
    let d = vec3f(q.y.zww - q.y.yyz);
    let first = a * a + b * b;
    let rest = c * c + d * d;
    let longest = max(max(max(first.x, first.y), first.z), max(max(rest.x, rest.y), rest.z));
    var edge = vec2f(a.x, b.x);
    edge = select(edge, vec2f(a.y, b.y), first.y == longest);
    edge = select(edge, vec2f(a.z, b.z), first.z == longest);
    edge = select(edge, vec2f(c.x, d.x), rest.x == longest);
    edge = select(edge, vec2f(c.y, d.y), rest.y == longest);
    edge = select(edge, vec2f(c.z, d.z), rest.z == longest);
    let along = select(vec2f(1.0, 0.0), edge / sqrt(max(longest, 1e-30)), longest > 1e-24);
    // From the first point, as differences are small.
    let u = a * along.x + b * along.y;
    let v = b * along.x - a * along.y;
    let low = vec2f(least(vec4f(u, 0.0)), least(vec4f(v, 0.0))) - margin;
    let high = vec2f(greatest(vec4f(u, 0.0)), greatest(vec4f(v, 0.0))) + margin;
    let at = select(low, high, far_sides(corner));
    return vec2f(q.x.x, q.y.x) + at.x * along + at.y * vec2f(-along.y, along.x);
}
