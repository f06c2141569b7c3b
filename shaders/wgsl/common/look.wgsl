// Look: clip planes and depth cue, what an appearance has beyond its transfer function.
//
// Positions are in the space that the program works in. The counterpart of
// `tetrascope_core::appearance`; isosurfaces are in common/surfaces.wgsl.
// Needs: the uniform `look: Look`.

struct Look {
    planes: array<vec4f, 16>, // p stays where n · p + w ≥ 0; unit normals
    cue: vec4f,               // the factor of light at p is n · p + w
    plane_count: u32,
    surface_count: u32,
    light_count: u32,
    ambient: f32,
    // Of the table that a program looks integrals, or surfaces, up in (`table_span`).
    table_span: vec4f,
    interval_count: u32, // of the transfer function
}

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
