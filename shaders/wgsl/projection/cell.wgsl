// Cell: draw the back faces, find where the ray entered, integrate between.
//
// Weiler, Kraus, Ertl 2002, §3; they draw front faces and find the exit, see the
// crate docs.
// In:   drawn, cells back to front; four vertices each, by a fixed index buffer.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color.
// With: projection/frame.wgsl, common/optics_model.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl

@group(1) @binding(4) var<storage, read> intervals: array<Interval>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

struct Varying {
    @builtin(position) @invariant position: vec4f,
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
    // A vertex must land in the same place from every cell that has it.
    let p = camera_space(v[index % 4u]);
    let w = frame.w_per_depth * (p.z + frame.anchor_depth) + frame.w_constant;
    out.position = vec4f(p.xy * frame.clip_per_unit, frame.near, w);
    return out;
}

// Where the ray meets one of the cell's sides.
struct Crossing {
    depth: f32,  // along the axis, from the anchor
    scalar: f32,
    inside: f32, // how far inside the face the ray is, negative outside; a choice's measure
}

@fragment
fn fs_cell(in: Varying) -> @location(0) vec4f {
    let x = 2.0 * in.position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * in.position.y / frame.size.y;
    let through = vec2f(x, y) * frame.extent;
    let slope = vec2f(x, y) * frame.slope;
    // Sheared so that the ray is the axis x = y = 0.
    let p0 = in.v0.xy - (through + slope * in.v0.z);
    let p1 = in.v1.xy - (through + slope * in.v1.z);
    let p2 = in.v2.xy - (through + slope * in.v2.z);
    let p3 = in.v3.xy - (through + slope * in.v3.z);
    // Each edge once, so both of its faces see it on the same side of the ray.
    let e01 = edge(p0, p1);
    let e02 = edge(p0, p2);
    let e03 = edge(p0, p3);
    let e12 = edge(p1, p2);
    let e13 = edge(p1, p3);
    let e23 = edge(p2, p3);

    // A face seen from outside turns counterclockwise: its weights sum to more than 0.
    var entry = Crossing(0.0, 0.0, OUTSIDE);
    var exit = entry;
    cross_face(vec3f(e23, -e13, e12), in.v1, in.v2, in.v3, &entry, &exit);
    cross_face(vec3f(-e23, -e02, e03), in.v0, in.v3, in.v2, &entry, &exit);
    cross_face(vec3f(e13, -e03, e01), in.v0, in.v1, in.v3, &entry, &exit);
    cross_face(vec3f(-e12, -e01, e02), in.v0, in.v2, in.v1, &entry, &exit);

    // The eye is inside: the ray starts there.
    let eye = -frame.anchor_depth;
    let height = exit.depth - max(entry.depth, eye);
    if entry.inside == OUTSIDE || exit.inside == OUTSIDE || height <= 0.0 {
        return vec4f(0.0);
    }
    if entry.depth < eye {
        let cut = (eye - entry.depth) / (exit.depth - entry.depth);
        entry.scalar = mix(entry.scalar, exit.scalar, cut);
    }
    let length = height * sqrt(1.0 + dot(slope, slope));
    let sum = integrate(entry.scalar, exit.scalar, length);
    switch MODEL {
        case EMISSION_ABSORPTION: {
            return vec4f(sum.xyz, opacity(sum.w));
        }
        case ABSORPTION: {
            return vec4f(sum.w, 0.0, 0.0, 0.0);
        }
        default: {
            return vec4f(sum.xyz, 0.0);
        }
    }
}

// Less inside than any face can be: normalized coordinates, and so the weights, are small.
const OUTSIDE: f32 = -1e30;

fn edge(p: vec2f, q: vec2f) -> f32 {
    return p.x * q.y - p.y * q.x;
}

// Takes the face (u, v, w) with these weights for the entry or the exit if the ray
// is further inside it than in the one before.
//
// Where rounding or the rasterizer's grid puts the ray outside of every face, by less
// than a 256th of a pixel, the one that it misses least is taken and the point moved
// to its border. Positive weights keep depth and scalar between the vertices'.
fn cross_face(
    weights: vec3f,
    u: vec4f,
    v: vec4f,
    w: vec4f,
    entry: ptr<function, Crossing>,
    exit: ptr<function, Crossing>,
) {
    let area = weights.x + weights.y + weights.z;
    let outward = select(-weights, weights, area > 0.0);
    let inside = min(outward.x, min(outward.y, outward.z));
    let positive = max(outward, vec3f(0.0));
    let total = positive.x + positive.y + positive.z;
    let crossing = Crossing(
        (positive.x * u.z + positive.y * v.z + positive.z * w.z) / total,
        (positive.x * u.w + positive.y * v.w + positive.z * w.w) / total,
        inside,
    );
    if area > 0.0 && inside > (*entry).inside {
        *entry = crossing;
    }
    if area < 0.0 && inside > (*exit).inside {
        *exit = crossing;
    }
}
