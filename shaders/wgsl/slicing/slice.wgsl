// Slice: what a slab of the volume adds to a pixel.
//
// Rezk Salama, Kolb 2005, §7; step lengths, clipped slabs and integration are ours, see
// the crate docs. Every number here depends on the pixel and the slab alone, so that
// boxes share no seam: a slab of a ray belongs to the one box that has its middle.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color.
// With: slicing/frame.wgsl, slicing/box_plane.wgsl, a part with `raw_at`,
//       common/optics_model.wgsl, common/transfer_function.wgsl, common/optics.wgsl

@group(1) @binding(0) var<storage, read> intervals: array<Interval>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

// Integrate between the samples at both ends of a slab; or classify the one between.
override SLABS: bool = true;
// Cut the first and the last slab of a ray where the volume ends; or count them whole.
override CLIPPED: bool = true;
// Lengths along the ray; or along the optical axis, as planes are apart.
override PER_RAY: bool = true;
// Light the volume by the gradient, from the eye.
override PHONG: bool = false;
override AMBIENT: f32 = 0.3;
override DIFFUSE: f32 = 0.7;
override SPECULAR: f32 = 0.2;
override SHININESS: f32 = 20.0;
// Whether there are samples that are no number: stored beyond GAP, and transparent.
override GAPS: bool = false;
const GAP: f32 = 1e30;

@fragment
fn fs_slice(in: Varying) -> @location(0) vec4f {
    let part = boxes[in.box_index];
    let x = 2.0 * in.position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * in.position.y / frame.size.y;
    let origin = frame.origin.xyz + x * frame.origin_x.xyz + y * frame.origin_y.xyz;
    let along = frame.along.xyz + x * frame.along_x.xyz + y * frame.along_y.xyz;
    var front = slab_depth(in.slab);
    var back = slab_depth(in.slab + 1);
    if CLIPPED {
        for (var axis = 0u; axis < 3u; axis++) {
            keep(origin[axis], along[axis], &front, &back);
            keep(frame.cells[axis] - origin[axis], -along[axis], &front, &back);
        }
    }
    for (var i = 0u; i < frame.clip_plane_count; i++) {
        let plane = clip_planes[i];
        keep(dot(plane.xyz, origin) + plane.w, dot(plane.xyz, along), &front, &back);
    }
    if front >= back {
        discard;
    }
    let middle = origin + 0.5 * (front + back) * along;
    if !CLIPPED && (any(middle < vec3f(0.0)) || any(middle > frame.cells.xyz)) {
        discard;
    }
    let cell = clamp(vec3i(floor(middle)), vec3i(0), vec3i(frame.cells.xyz) - 1);
    if any(cell < part.low) || any(cell >= part.low + vec3i(frame.box_size.xyz)) {
        discard;
    }
    let ray = vec3f(vec2f(x, y) * frame.slope, 1.0);
    let thickness = (back - front) * select(1.0, length(ray), PER_RAY);
    var scalars: vec2f;
    if SLABS {
        scalars.x = scalar_at(origin + front * along, part.texel);
        scalars.y = scalar_at(origin + back * along, part.texel);
    } else {
        scalars = vec2f(scalar_at(middle, part.texel));
    }
    if GAPS && max(scalars.x, scalars.y) >= GAP {
        discard;
    }
    var sum = integrate(scalars.x, scalars.y, thickness);
    if PHONG {
        sum = lit(sum, middle, along, length(ray), part.texel);
    }
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

// Cuts [front, back] to where at + slope · depth ≥ 0.
fn keep(at: f32, slope: f32, front: ptr<function, f32>, back: ptr<function, f32>) {
    if slope == 0.0 {
        if at < 0.0 {
            *back = *front;
        }
        return;
    }
    let crossing = -at / slope;
    if slope > 0.0 {
        *front = max(*front, crossing);
    } else {
        *back = min(*back, crossing);
    }
}

// The scalar at a point of the lattice, in the unit of `ScalarMap`; GAP or more where
// there is none.
fn scalar_at(lattice: vec3f, texel: vec3i) -> f32 {
    let raw = raw_at(lattice, texel);
    if GAPS && raw >= GAP {
        return raw;
    }
    let scalar = (raw * frame.scalar_unit - frame.scalar_base) * frame.scalar_factor;
    // Within the outermost intervals, whatever the transfer function's width.
    return clamp(scalar + frame.scalar_shift, -1e30, 1e30);
}

// `sum` under a light at the eye: Phong's terms, on both sides of a surface.
//
// The gradient is by central differences, one-sided at the volume's border. A gradient
// is a covector, so its product with the ray is the same in lattice and camera space.
fn lit(sum: vec4f, middle: vec3f, along: vec3f, ray: f32, texel: vec3i) -> vec4f {
    let low = max(middle - 1.0, vec3f(0.0));
    let high = min(middle + 1.0, frame.cells.xyz);
    var gradient: vec3f;
    for (var axis = 0u; axis < 3u; axis++) {
        var before = middle;
        var behind = middle;
        before[axis] = low[axis];
        behind[axis] = high[axis];
        let difference = scalar_at(behind, texel) - scalar_at(before, texel);
        gradient[axis] = difference / (high[axis] - low[axis]);
    }
    let steepness = length(gradient * frame.inverse_spacing.xyz);
    // Where nothing changes there is no surface to light, as beside a gap.
    var facing = 0.0;
    if steepness > 0.0 && !(GAPS && steepness >= 1e-9 * GAP) {
        facing = min(abs(dot(gradient, along)) / (steepness * ray), 1.0);
    }
    var light = sum.xyz * (AMBIENT + DIFFUSE * facing);
    if MODEL == EMISSION_ABSORPTION {
        light += SPECULAR * pow(facing, SHININESS) * opacity(sum.w);
    }
    return vec4f(light, sum.w);
}
