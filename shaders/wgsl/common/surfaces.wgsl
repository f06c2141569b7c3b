// Surfaces: where a ray meets isosurfaces, and how they are lit.
//
// Scalars are in the unit of `ScalarMap`. The counterpart of
// `tetrascope_core::appearance`.
// Needs: `fn look_of(i: u32) -> vec4f`: color and value of each surface, by value; then of
//        each light the unit vector toward it and its color.
// With: common/look.wgsl

// The first surface that a stretch meets on which the scalar goes linearly from `front`
// to `back`.
struct Crossing {
    surface: u32, // surface_count if there is none
    share: f32,   // where, of the stretch
}

fn nearest_crossing(front: f32, back: f32) -> Crossing {
    let surface = first_between(front, back);
    if surface == look.surface_count {
        return Crossing(surface, 2.0);
    }
    return Crossing(surface, saturate((look_of(surface).w - front) / (back - front)));
}

// The surface that is met first where the scalar goes from `front` to `back` without
// turning back; surface_count if there is none.
//
// One end is below the value and the other is not, so that a chain of stretches
// misses no surface and doubles none.
fn first_between(front: f32, back: f32) -> u32 {
    // How many are at or below the front, by bisection.
    var first = 0u;
    var end = look.surface_count;
    while first < end {
        let middle = (first + end) / 2u;
        if look_of(middle).w <= front {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    // On the way up the next one, on the way down the last of those.
    let rising = front < back;
    let there = select(first > 0u, first < look.surface_count, rising);
    if !there {
        return look.surface_count;
    }
    let surface = select(first - 1u, first, rising);
    let value = look_of(surface).w;
    return select(look.surface_count, surface, (front < value) != (back < value));
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
