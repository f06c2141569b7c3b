// Chord: where the ray through a pixel enters and leaves a cell.
//
// Weiler, Kraus, Ertl 2002, §3.2; which faces are crossed is decided by the sides on
// which the ray passes the edges, see the crate docs.
// With: projection/frame.wgsl, projection/footprint.wgsl, common/sides.wgsl,
//       common/cue.wgsl, common/layer.wgsl, common/look.wgsl, common/ends.wgsl,
//       projection/transfer.wgsl

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
    let p0 = sheared(in.v0, ray);
    let p1 = sheared(in.v1, ray);
    let p2 = sheared(in.v2, ray);
    let p3 = sheared(in.v3, ray);
    let turns = turns(sides(p0.xy, p1.xy, p2.xy, p3.xy));
    let entry = crossing_point(crossed_face(turns.enters, p0, p1, p2, p3));
    let exit = crossing_point(crossed_face(turns.leaves, p0, p1, p2, p3));
    let left = what_is_left(ray, in.per_depth.z, entry, exit);
    let height = select(left.back.x - left.front.x, LAYER, left.is_layer);
    if !(any(turns.enters) & any(turns.leaves) & (height > 0.0)) {
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
    is_layer: bool, // wholly seen, whatever its length
}

// What eye, clip planes and what an application has drawn leave of the ray between entry and
// exit; where the eye is inside, the ray starts there.
fn what_is_left(ray: Ray, eye_depth: f32, entry: vec2f, exit: vec2f) -> Part {
    // The ray's parameter is the depth: at 0 it is in the anchor's plane.
    let clipped = clip_ray(vec3f(ray.through, 0.0), vec3f(ray.slope, 1.0));
    let begin = max(eye_depth, clipped.x);
    let end = min(ray.end, clipped.y);
    if is_layer(entry, exit) && entry.x >= begin && exit.x <= end {
        return Part(entry, exit, true);
    }
    var part = Part(entry, exit, false);
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

// A vertex as the ray sees it, which is the axis x = y = 0. `fma` may or may not be fused,
// but as one operation it rounds a vertex in one way for every cell that has it.
fn sheared(v: vec4f, ray: Ray) -> vec4f {
    return vec4f(on_grid(fma(-ray.slope, v.zz, v.xy - ray.through)), v.zw);
}

struct Face {
    a: vec4f,
    b: vec4f,
    c: vec4f,
}

// The one face that is marked, of those opposite vertex 0, 1, 2, 3.
fn crossed_face(opposite: vec4<bool>, p0: vec4f, p1: vec4f, p2: vec4f, p3: vec4f) -> Face {
    return Face(
        select(p0, p1, opposite.x),
        select(p1, p2, opposite.x || opposite.y),
        select(p3, p2, opposite.w),
    );
}

// Depth and scalar where the ray crosses a face.
fn crossing_point(face: Face) -> vec2f {
    return mean_where_crossed(face.a, face.b, face.c);
}
