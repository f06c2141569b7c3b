// Look: clip planes, depth cue and isosurfaces, what an appearance has beyond its
// transfer function.
//
// Positions are in the space that the program works in; scalars in the unit of
// `ScalarMap`. The counterpart of `tetrascope_core::appearance`.
// Needs: `fn look_of(i: u32) -> vec4f`, the items below, and the uniform `look: Look`.

struct Look {
    planes: array<vec4f, 16>, // p stays where n · p + w ≥ 0; unit normals
    cue: vec4f,               // the factor of light at p is n · p + w
    plane_count: u32,
    surface_count: u32,
    light_count: u32,
    ambient: f32,
}

// Items: color and value of each surface, then of each light the unit vector toward
// it and its color.

// Whether there are clip planes.
override CLIPPED: bool = false;

const FAR_AWAY: f32 = 1e30;

// What the planes leave of the ray at origin + t direction, as the least and greatest t.
fn clip_ray(origin: vec3f, direction: vec3f) -> vec2f {
    var left = vec2f(-FAR_AWAY, FAR_AWAY);
    if CLIPPED {
        for (var i = 0u; i < look.plane_count; i += 1u) {
            let plane = look.planes[i];
            let height = dot(plane.xyz, origin) + plane.w;
            let rise = dot(plane.xyz, direction);
            if rise > 0.0 {
                left.x = max(left.x, -height / rise);
            } else if rise < 0.0 {
                left.y = min(left.y, height / -rise);
            } else if height < 0.0 {
                left.y = -FAR_AWAY;
            }
        }
    }
    return left;
}

// The depth cue at p.
fn cue_at(p: vec3f) -> f32 {
    return saturate(dot(look.cue.xyz, p) + look.cue.w);
}

// The first surface that a stretch meets on which the scalar goes linearly from `front`
// to `back`.
struct Crossing {
    surface: u32, // surface_count if there is none
    share: f32,   // where, of the stretch
}

// One end is below the value and the other is not, so that a chain of stretches
// misses no surface and doubles none.
fn nearest_crossing(front: f32, back: f32) -> Crossing {
    var nearest = Crossing(look.surface_count, 2.0);
    for (var i = 0u; i < look.surface_count; i += 1u) {
        let value = look_of(i).w;
        if (front < value) != (back < value) {
            let share = saturate((value - front) / (back - front));
            if share < nearest.share {
                nearest = Crossing(i, share);
            }
        }
    }
    return nearest;
}

// What a surface sends to the eye, before the cue. `gradient` is normal to it, of any
// length and on either side; the side that the ray along `direction` meets is lit.
fn shade(surface: u32, gradient: vec3f, direction: vec3f) -> vec3f {
    // Scaled first, as squares of huge and tiny gradients do not fit.
    let size = max(abs(gradient.x), max(abs(gradient.y), abs(gradient.z)));
    var normal = vec3f(0.0);
    if size > 0.0 {
        normal = normalize(gradient / size);
        normal = select(normal, -normal, dot(normal, direction) > 0.0);
    }
    var light = vec3f(look.ambient);
    for (var i = 0u; i < look.light_count; i += 1u) {
        let item = look.surface_count + 2u * i;
        light += look_of(item + 1u).xyz * max(dot(normal, look_of(item).xyz), 0.0);
    }
    return light * look_of(surface).xyz;
}

// The gradient of the scalar in a cell, up to its length and sign: a, b, c and d in any
// space, each with its scalar.
fn gradient_of(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> vec3f {
    let p = b - a;
    let q = c - a;
    let r = d - a;
    return p.w * cross(q.xyz, r.xyz) + q.w * cross(r.xyz, p.xyz) + r.w * cross(p.xyz, q.xyz);
}
