// Face: the ray from a front face to the nearest of the others, integrated and blended.
//
// Weiler, Kraus, Ertl 2002, §4.1 and equation 1.
// In:   FaceVarying.
// Out:  as cell.wgsl.
// With: projection/faces.wgsl, preintegration/lookup.wgsl and what it needs, common/ends.wgsl

// Samples a side of the minimum texture, 0 for a minimum by comparison.
override MINIMUM_SIDE: u32 = 0u;

// The minimum of its three coordinates, each in [0, 1].
@group(2) @binding(2) var minimum: texture_3d<f32>;

@fragment
fn fs_face(in: FaceVarying) -> @location(0) vec4f {
    let longest = in.cell.y;
    // Negative only beside the face, where the rasterizer's edges are not the ray's.
    let t = in.parameters;
    var length = min(t.x, min(t.y, t.z));
    if MINIMUM_SIDE > 0u {
        // "Normalized" by the longest edge; greater ones are clamped.
        length = longest * minimum_of(t / longest);
    }
    // At a vertex nothing may be left to leave by.
    if length > longest * 1.001 {
        return vec4f(0.0);
    }
    // What is behind the eye's plane is left out.
    let hidden = max(-frame.anchor_depth - in.depth, 0.0);
    let front = in.scalar + in.cell.x * hidden;
    length -= hidden;
    if ENDS {
        // Rays are parallel to the axis.
        length = min(length, end_of_ray(vec2i(in.position.xy)) - (in.depth + hidden));
    }
    if length <= 0.0 {
        return vec4f(0.0);
    }
    let sum = segment(front, front + in.cell.x * length, length);
    switch MODEL {
        case EMISSION_ABSORPTION: {
            return vec4f(sum.xyz, segment_opacity(sum));
        }
        case ABSORPTION: {
            return vec4f(segment_depth(sum), 0.0, 0.0, 0.0);
        }
        default: {
            return vec4f(sum.xyz, 0.0);
        }
    }
}

// Between samples as texture units do it, but in f32.
fn minimum_of(t: vec3f) -> f32 {
    let at = saturate(t) * f32(MINIMUM_SIDE - 1u);
    let low = min(vec3u(at), vec3u(MINIMUM_SIDE - 2u));
    let toward = at - vec3f(low);
    let near = minimum_slice(low, toward.xy);
    return mix(near, minimum_slice(low + vec3u(0u, 0u, 1u), toward.xy), toward.z);
}

fn minimum_slice(low: vec3u, toward: vec2f) -> f32 {
    let t00 = textureLoad(minimum, low, 0).x;
    let t10 = textureLoad(minimum, low + vec3u(1u, 0u, 0u), 0).x;
    let t01 = textureLoad(minimum, low + vec3u(0u, 1u, 0u), 0).x;
    let t11 = textureLoad(minimum, low + vec3u(1u, 1u, 0u), 0).x;
    return mix(mix(t00, t10, toward.x), mix(t01, t11, toward.x), toward.y);
}
