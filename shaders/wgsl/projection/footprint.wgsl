// Footprint: a quadrilateral around each cell, a little larger than its silhouette.
//
// The rasterizer only proposes pixels: it rounds vertices to a grid of its own, so
// which pixels are the cell's is decided in each of them (chord.wgsl).
// In:   drawn, cells; four corners of each by a fixed index buffer.
// Out:  Varying.
// With: projection/frame.wgsl

struct Varying {
    @builtin(position) position: vec4f,
    // The cell's vertices: camera space, and the scalar.
    @location(0) @interpolate(flat) v0: vec4f,
    @location(1) @interpolate(flat) v1: vec4f,
    @location(2) @interpolate(flat) v2: vec4f,
    @location(3) @interpolate(flat) v3: vec4f,
}

@vertex
fn vs_cell(@builtin(vertex_index) index: u32) -> Varying {
    let cell = drawn[index / 4u];
    let v = cells[cell];
    let at = select(v, vec4u(cell), vec4<bool>(frame.scalars_per_cell == 1u));
    var out: Varying;
    out.v0 = vec4f(camera_space(v.x), scalars[at.x]);
    out.v1 = vec4f(camera_space(v.y), scalars[at.y]);
    out.v2 = vec4f(camera_space(v.z), scalars[at.z]);
    out.v3 = vec4f(camera_space(v.w), scalars[at.w]);
    var corners = array<vec3f, 4>(out.v0.xyz, out.v1.xyz, out.v2.xyz, out.v3.xyz);
    let pixel = footprint(&corners, index % 4u);
    out.position = vec4f(2.0 * pixel / frame.size, 0.5, 1.0);
    return out;
}

// The corner of the footprint, in pixels from the image's center, y up.
fn footprint(p: ptr<function, array<vec3f, 4>>, corner: u32) -> vec2f {
    let per_unit = 0.5 * frame.size * frame.clip_per_unit;
    var q: array<vec2f, 4>;
    var nearest = 1e30;
    var farthest_out = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let w = w_of((*p)[i]);
        nearest = min(nearest, w);
        q[i] = (*p)[i].xy * per_unit / max(w, frame.near);
        farthest_out = max(farthest_out, max(abs(q[i].x), abs(q[i].y)));
    }
    if nearest <= frame.near || farthest_out > LARGEST {
        return box_in_view(p, per_unit, corner);
    }
    // What f32 loses of camera space, a few 2⁻²³ of coordinates up to 2, in pixels.
    let scale = max(per_unit.x, per_unit.y) * (1.0 + max(frame.slope.x, frame.slope.y));
    let margin = MARGIN + ROUNDING * scale / nearest;
    return grown_hull(&q, margin, corner);
}

// The least that Vulkan lets a rasterizer resolve is 1/16 of a pixel: vertices move by
// half of that each way.
const MARGIN: f32 = 0.0625;
const ROUNDING: f32 = 9.5367431640625e-7; // 2⁻²⁰
// f32 resolves 1/512 of a pixel there.
const LARGEST: f32 = 16384.0;

fn w_of(p: vec3f) -> f32 {
    return frame.w_per_depth * (p.z + frame.anchor_depth) + frame.w_constant;
}

// A cell that reaches the eye's plane, or far out of the image: the box around the
// part before the eye, cut to the image.
fn box_in_view(p: ptr<function, array<vec3f, 4>>, per_unit: vec2f, corner: u32) -> vec2f {
    var low = vec2f(1e30);
    var high = vec2f(-1e30);
    for (var i = 0u; i < 4u; i++) {
        let w = w_of((*p)[i]);
        if w > frame.near {
            let q = (*p)[i].xy * per_unit / w;
            low = min(low, q);
            high = max(high, q);
        }
        for (var j = 0u; j < i; j++) {
            let other = w_of((*p)[j]);
            if (w > frame.near) != (other > frame.near) {
                let cut = (frame.near - w) / (other - w);
                let q = mix((*p)[i].xy, (*p)[j].xy, cut) * per_unit / frame.near;
                low = min(low, q);
                high = max(high, q);
            }
        }
    }
    // Near the eye rounding is worth many pixels; it is a small share of how far out
    // they are, and what is behind the eye gives an empty box.
    let border = 0.5 * frame.size + 2.0;
    let slack = 1.0 + 1e-3 * max(abs(low), abs(high));
    low = clamp(low - slack, -border, border);
    high = clamp(high + slack, -border, border);
    return select(low, high, far_sides(corner));
}

// Which sides of a box meet in its corner, around it.
fn far_sides(corner: u32) -> vec2<bool> {
    return vec2<bool>(corner == 1u || corner == 2u, corner >= 2u);
}

fn cross2(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// Around the hull of four points by which of the numbers w, Σ w = 0, Σ w q = 0, are
// positive (bit i for w of point i): the points of one sign are on a diagonal, or
// alone inside the triangle of the others (Radon). A triangle repeats its last point.
const RINGS = array<vec4u, 8>(
    vec4u(0u, 0u, 0u, 0u), // none: all on a line
    vec4u(1u, 2u, 3u, 3u),
    vec4u(0u, 2u, 3u, 3u),
    vec4u(0u, 2u, 1u, 3u),
    vec4u(0u, 1u, 3u, 3u),
    vec4u(0u, 1u, 2u, 3u),
    vec4u(0u, 1u, 3u, 2u),
    vec4u(0u, 1u, 2u, 2u),
);

// A corner of the convex hull of q, its sides moved outward by `margin` pixels. Where
// that makes a tip too long, of the box along the longest edge.
fn grown_hull(q: ptr<function, array<vec2f, 4>>, margin: f32, corner: u32) -> vec2f {
    let a = (*q)[1] - (*q)[0];
    let b = (*q)[2] - (*q)[0];
    let c = (*q)[3] - (*q)[0];
    let w = vec4f(cross2(b - a, c - a), -cross2(b, c), cross2(a, c), -cross2(a, b));
    let bits = dot(select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), w > vec4f(0.0)), vec4u(1u));
    var rings = RINGS;
    let ring = rings[select(bits, 15u - bits, bits >= 8u)];
    let count = select(4u, 3u, ring.z == ring.w);
    let mine = min(corner, count - 1u);
    let turn = sign(cross2((*q)[ring.y] - (*q)[ring.x], (*q)[ring.z] - (*q)[ring.y]));
    var result = vec2f(0.0);
    var fits = turn != 0.0;
    for (var i = 0u; i < count; i++) {
        let here = (*q)[ring[i]];
        let before = here - (*q)[ring[(i + count - 1u) % count]];
        let after = (*q)[ring[(i + 1u) % count]] - here;
        let lengths = vec2f(length(before), length(after));
        if min(lengths.x, lengths.y) < SHORTEST || turn * cross2(before, after) <= 0.0 {
            fits = false;
        }
        let n = turn * vec2f(before.y, -before.x) / max(lengths.x, SHORTEST);
        let m = turn * vec2f(after.y, -after.x) / max(lengths.y, SHORTEST);
        let cosine = 1.0 + dot(n, m);
        if cosine < SHARPEST {
            fits = false;
        }
        if i == mine {
            result = here + (n + m) * (margin / max(cosine, SHARPEST));
        }
    }
    if fits {
        return result;
    }
    return box_along(q, margin, corner);
}

// Pixels; of shorter edges rounding makes the direction.
const SHORTEST: f32 = 0.015625;
// 2/16²: a tip moves by √(2/SHARPEST) = 16 margins, a pixel.
const SHARPEST: f32 = 0.0078125;

fn box_along(q: ptr<function, array<vec2f, 4>>, margin: f32, corner: u32) -> vec2f {
    var along = vec2f(1.0, 0.0);
    var longest = 1e-12;
    for (var i = 1u; i < 4u; i++) {
        for (var j = 0u; j < i; j++) {
            let edge = (*q)[i] - (*q)[j];
            let square = dot(edge, edge);
            if square > longest {
                longest = square;
                along = edge / sqrt(square);
            }
        }
    }
    // From the first point, as differences are small.
    var low = vec2f(0.0);
    var high = vec2f(0.0);
    for (var i = 1u; i < 4u; i++) {
        let d = (*q)[i] - (*q)[0];
        let at = vec2f(dot(d, along), cross2(along, d));
        low = min(low, at);
        high = max(high, at);
    }
    let at = select(low - margin, high + margin, far_sides(corner));
    return (*q)[0] + at.x * along + at.y * vec2f(-along.y, along.x);
}
