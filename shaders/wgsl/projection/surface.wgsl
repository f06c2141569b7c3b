// Surface: where the ray through a pixel meets an isosurface in a cell, flat shaded.
//
// Weiler, Kraus, Ertl 2002, §5.2; with `SURFACE_TABLE` as there, by a thickened table over
// the scalars at the ray's entry and exit, else by the crossing itself. Cells come in any
// order, and the depth buffer hides.
// In:   Varying.
// Out:  the color over everything; the distance along the ray from where it starts, normalized
//       units; the depth along the axis from the anchor as one in [0, 1].
// With: projection/chord.wgsl and what it needs,
//       common/sides.wgsl, common/surfaces.wgsl

// Samples a side of the table, 0 without one.
override SURFACE_TABLE: u32 = 0u;

@group(2) @binding(0) var<storage, read> look_items: array<vec4f>;
// Which surface is seen first between two scalars, or surface_count.
@group(2) @binding(1) var seen: texture_2d<u32>;

fn look_of(i: u32) -> vec4f {
    return look_items[i];
}

struct Met {
    @location(0) color: vec4f,
    @location(1) distance: f32,
    @builtin(frag_depth) depth: f32,
}

// Farther than anything before the eye is from the anchor along the axis: the mesh is in a
// ball of radius √3, and the anchor beside its center or before it.
const REACH: f32 = 2.0;

@fragment
fn fs_surface(in: Varying) -> Met {
    let ray = ray_of(in);
    let p0 = sheared(in.v0, ray);
    let p1 = sheared(in.v1, ray);
    let p2 = sheared(in.v2, ray);
    let p3 = sheared(in.v3, ray);
    let turns = turns(sides(p0.xy, p1.xy, p2.xy, p3.xy));
    if !any(turns.enters) || !any(turns.leaves) {
        discard;
    }
    let entry = crossing_point(sorted(crossed_face(turns.enters, p0, p1, p2, p3)));
    let exit = crossing_point(sorted(crossed_face(turns.leaves, p0, p1, p2, p3)));
    let left = what_is_left(ray, in.per_depth.z, entry, exit);
    if left.back.x < left.front.x && !left.is_layer {
        discard;
    }
    let met = crossing_between(left.front.y, left.back.y);
    if met.surface == look.surface_count {
        discard;
    }
    let along = mix(left.front.x, left.back.x, met.share);
    let direction = normalize(vec3f(ray.slope, 1.0));
    let gradient = gradient_of(in.v0, in.v1, in.v2, in.v3);
    var color = shade(met.surface, gradient, direction);
    if CUED {
        color *= cue_at(vec3f(ray.through + ray.slope * along, along));
    }
    return Met(
        vec4f(color, 1.0),
        (along - in.per_depth.z) * sqrt(1.0 + dot(ray.slope, ray.slope)),
        saturate(0.5 + along / (2.0 * REACH)),
    );
}

fn crossing_between(front: f32, back: f32) -> Crossing {
    if SURFACE_TABLE == 0u {
        return nearest_crossing(front, back);
    }
    let span = table_span();
    let place = (vec2f(front, back) - span.x) * span.z;
    let texel = vec2u(saturate(place) * f32(SURFACE_TABLE));
    let surface = textureLoad(seen, min(texel, vec2u(SURFACE_TABLE - 1u)), 0).x;
    if surface == look.surface_count {
        return Crossing(surface, 0.0);
    }
    // Where the surface is thicker than the segment goes, its nearer end.
    let rise = back - front;
    let share = (look_of(surface).w - front) / select(1.0, rise, rise != 0.0);
    return Crossing(surface, saturate(share));
}

// Both cells of a sorted face compute with the same numbers in the same order and get the same
// bits. Else a surface through a shared face could be behind it for the one and before it for
// the other, and be drawn by none.
fn sorted(face: Face) -> Face {
    let is_a = comes_first(face.a.xy, face.b.xy);
    let low = select(face.b, face.a, is_a);
    let high = select(face.a, face.b, is_a);
    let is_low = comes_first(low.xy, face.c.xy);
    let first = select(face.c, low, is_low);
    let rest = select(low, face.c, is_low);
    let is_high = comes_first(high.xy, rest.xy);
    return Face(first, select(rest, high, is_high), select(high, rest, is_high));
}

fn comes_first(a: vec2f, b: vec2f) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}
