// Chord: where the ray through a pixel enters and leaves a cell.
//
// Weiler, Kraus, Ertl 2002, §3.2; which faces are crossed is decided by the sides on
// which the ray passes the edges, see the crate docs.
// With: projection/frame.wgsl, projection/footprint.wgsl, common/sides.wgsl,
//       common/cue.wgsl, common/look.wgsl

@group(0) @binding(1) var<uniform> look: Look;

// The ray's part in a cell that is before the eye and not cut away; `length` is 0 where
// there is none.
struct Chord {
    depth: f32, // of the entry, along the axis, from the anchor
    front: f32, // scalar at the entry
    back: f32,  // and at the exit
    length: f32,
    cue: vec2f, // the depth cue at both ends
}

fn chord_of(in: Varying) -> Chord {
    let x = 2.0 * in.position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * in.position.y / frame.size.y;
    let through = vec2f(x, y) * frame.extent;
    let slope = vec2f(x, y) * frame.slope;
    // Sheared so that the ray is the axis x = y = 0. `fma` may or may not be fused,
    // but as one operation it rounds a vertex in one way for every cell that has it.
    let p0 = on_grid(fma(-slope, in.v0.zz, in.v0.xy - through));
    let p1 = on_grid(fma(-slope, in.v1.zz, in.v1.xy - through));
    let p2 = on_grid(fma(-slope, in.v2.zz, in.v2.xy - through));
    let p3 = on_grid(fma(-slope, in.v3.zz, in.v3.xy - through));
    let s = sides(p0, p1, p2, p3);
    let s01 = s.of_first.x;
    let s02 = s.of_first.y;
    let s03 = s.of_first.z;
    let s12 = s.of_rest.x;
    let s13 = s.of_rest.y;
    let s23 = s.of_rest.z;
    // How each face turns around the ray, for the face opposite vertex 0, 1, 2, 3, seen
    // from outside the cell: 1 where the ray enters, −1 where it leaves, else 0.
    let turns = vec4i(
        same(s12, s23, -s13),
        same(s03, -s23, -s02),
        same(s01, s13, -s03),
        same(s02, -s12, -s01),
    );
    let e01 = edge(p0, p1);
    let e02 = edge(p0, p2);
    let e03 = edge(p0, p3);
    let e12 = edge(p1, p2);
    let e13 = edge(p1, p3);
    let e23 = edge(p2, p3);
    let w0 = vec4f(0.0, e23, -e13, e12);
    let w1 = vec4f(-e23, 0.0, e03, -e02);
    let w2 = vec4f(e13, -e03, 0.0, e01);
    let w3 = vec4f(-e12, e02, -e01, 0.0);
    let depths = vec4f(in.v0.z, in.v1.z, in.v2.z, in.v3.z);
    let values = vec4f(in.v0.w, in.v1.w, in.v2.w, in.v3.w);
    let none = vec4f(0.0);
    let enters = turns == vec4i(1);
    let leaves = turns == vec4i(-1);
    let entry = point(
        select(none, w0, enters.x) + select(none, w1, enters.y)
            + select(none, w2, enters.z) + select(none, w3, enters.w),
        depths, values,
    );
    let exit = point(
        -(select(none, w0, leaves.x) + select(none, w1, leaves.y)
            + select(none, w2, leaves.z) + select(none, w3, leaves.w)),
        depths, values,
    );
    let left = what_is_left(through, slope, entry, exit);
    let height = left.back.x - left.front.x;
    if !any(enters) || !any(leaves) || height <= 0.0 {
        return Chord(0.0, 0.0, 0.0, 0.0, vec2f(1.0));
    }
    var cue = vec2f(1.0);
    if CUED {
        cue = vec2f(
            cue_at(vec3f(through + slope * left.front.x, left.front.x)),
            cue_at(vec3f(through + slope * left.back.x, left.back.x)),
        );
    }
    let length = height * sqrt(1.0 + dot(slope, slope));
    return Chord(left.front.x, left.front.y, left.back.y, length, cue);
}

// Depth and scalar at both ends.
struct Part {
    front: vec2f,
    back: vec2f,
}

// What eye and clip planes leave of the ray between entry and exit; where the eye is
// inside, the ray starts there.
fn what_is_left(through: vec2f, slope: vec2f, entry: vec2f, exit: vec2f) -> Part {
    // The ray's parameter is the depth: at 0 it is in the anchor's plane.
    let clipped = clip_ray(vec3f(through, 0.0), vec3f(slope, 1.0));
    let begin = max(-frame.anchor_depth, clipped.x);
    var part = Part(entry, exit);
    let whole = max(exit.x - entry.x, 1e-36);
    if entry.x < begin {
        part.front = vec2f(begin, mix(entry.y, exit.y, saturate((begin - entry.x) / whole)));
    }
    if CLIPPED && exit.x > clipped.y {
        let share = saturate((clipped.y - entry.x) / whole);
        part.back = vec2f(clipped.y, mix(entry.y, exit.y, share));
    }
    return part;
}

fn same(a: i32, b: i32, c: i32) -> i32 {
    return select(0, a, a == b && b == c);
}

fn edge(p: vec2f, q: vec2f) -> f32 {
    return p.x * q.y - p.y * q.x;
}

// Depth and scalar where the ray crosses a face. The sides being known, rounding alone
// makes a weight negative; with positive ones both stay between the vertices'.
fn point(weights: vec4f, depths: vec4f, values: vec4f) -> vec2f {
    let positive = max(weights, vec4f(0.0));
    let total = dot(positive, vec4f(1.0));
    return vec2f(dot(positive, depths), dot(positive, values)) / max(total, 1e-36);
}
