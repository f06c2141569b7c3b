// Chord: where the ray through a pixel enters and leaves a cell.
//
// Weiler, Kraus, Ertl 2002, §3.2; which faces are crossed is decided by the sides on
// which the ray passes the edges, see the crate docs.
// With: projection/frame.wgsl, projection/footprint.wgsl, common/sides.wgsl,
//       common/cue.wgsl, common/look.wgsl, common/ends.wgsl

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

// A pixel's ray: where it passes the anchor's plane, and how it moves with depth.
struct Ray {
    through: vec2f,
    slope: vec2f,
    end: f32, // the depth where it meets what an application has drawn
}

fn ray_of(in: Varying) -> Ray {
    let at = vec2f(-1.0, 1.0) + vec2f(1.0, -1.0) * (in.per_pixel.xy * in.position.xy);
    return Ray(at * in.per_pixel.zw, at * in.per_depth.xy, end_of_ray(vec2i(in.position.xy)));
}

fn chord_of(in: Varying) -> Chord {
    let ray = ray_of(in);
    let through = ray.through;
    let slope = ray.slope;
    // Sheared so that the ray is the axis x = y = 0. `fma` may or may not be fused,
    // but as one operation it rounds a vertex in one way for every cell that has it.
    let p0 = on_grid(fma(-slope, in.v0.zz, in.v0.xy - through));
    let p1 = on_grid(fma(-slope, in.v1.zz, in.v1.xy - through));
    let p2 = on_grid(fma(-slope, in.v2.zz, in.v2.xy - through));
    let p3 = on_grid(fma(-slope, in.v3.zz, in.v3.xy - through));
    let turns = turns(sides(p0, p1, p2, p3));
    // Twice the area that the ray spans with each edge: the weight of the vertex opposite
    // in a face. The sides being known, rounding alone gives one the wrong sign.
    let a01 = abs(edge(p0, p1));
    let a02 = abs(edge(p0, p2));
    let a03 = abs(edge(p0, p3));
    let a12 = abs(edge(p1, p2));
    let a13 = abs(edge(p1, p3));
    let a23 = abs(edge(p2, p3));
    // Of the vertices, in the face opposite vertex 0, 1, 2, 3.
    let w0 = vec4f(0.0, a23, a13, a12);
    let w1 = vec4f(a23, 0.0, a03, a02);
    let w2 = vec4f(a13, a03, 0.0, a01);
    let w3 = vec4f(a12, a02, a01, 0.0);
    let depths = vec4f(in.v0.z, in.v1.z, in.v2.z, in.v3.z);
    let values = vec4f(in.v0.w, in.v1.w, in.v2.w, in.v3.w);
    let enters = turns.enters;
    let leaves = turns.leaves;
    let entry = point(
        select(select(select(w3, w2, enters.z), w1, enters.y), w0, enters.x),
        depths, values,
    );
    let exit = point(
        select(select(select(w3, w2, leaves.z), w1, leaves.y), w0, leaves.x),
        depths, values,
    );
    let left = what_is_left(ray, in.per_depth.z, entry, exit);
    let height = left.back.x - left.front.x;
    if !(any(enters) & any(leaves) & (height > 0.0)) {
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

// What eye, clip planes and what an application has drawn leave of the ray between entry and
// exit; where the eye is inside, the ray starts there.
fn what_is_left(ray: Ray, eye_depth: f32, entry: vec2f, exit: vec2f) -> Part {
    // The ray's parameter is the depth: at 0 it is in the anchor's plane.
    let clipped = clip_ray(vec3f(ray.through, 0.0), vec3f(ray.slope, 1.0));
    let begin = max(eye_depth, clipped.x);
    let end = min(ray.end, clipped.y);
    var part = Part(entry, exit);
    let whole = max(exit.x - entry.x, 1e-36);
    if entry.x < begin {
        part.front = vec2f(begin, on_the_way(entry.y, exit.y, (begin - entry.x) / whole));
    }
    if (CLIPPED || ENDS) && exit.x > end {
        part.back = vec2f(end, on_the_way(entry.y, exit.y, (end - entry.x) / whole));
    }
    return part;
}

// The scalar at a share of the way; equal ends leave it what it is, on the step of a
// transfer function too, which `mix` may not.
fn on_the_way(front: f32, back: f32, share: f32) -> f32 {
    return front + saturate(share) * (back - front);
}

fn edge(p: vec2f, q: vec2f) -> f32 {
    return p.x * q.y - p.y * q.x;
}

// Depth and scalar where the ray crosses a face: means of its vertices', so between them,
// but for the scalar's last bit: where it is constant in the cell it must stay so.
fn point(weights: vec4f, depths: vec4f, values: vec4f) -> vec2f {
    let total = dot(weights, vec4f(1.0));
    let mean = vec2f(dot(weights, depths), dot(weights, values)) * (1.0 / max(total, 1e-36));
    let low = min(min(values.x, values.y), min(values.z, values.w));
    let high = max(max(values.x, values.y), max(values.z, values.w));
    return vec2f(mean.x, clamp(mean.y, low, high));
}
