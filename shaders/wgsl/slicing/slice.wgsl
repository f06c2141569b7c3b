// Slice: what a slab of the volume adds to a pixel.
//
// Rezk Salama, Kolb 2005, §7; step lengths, clipped slabs and integration are ours, see
// the crate docs.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color.
// With: slicing/slab.wgsl and what it needs, common/optics_model.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl, common/cue.wgsl

@group(1) @binding(0) var<storage, read> intervals: array<KnotPair>;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

// Integrate between the samples at both ends of a slab; or classify the one between.
override SLABS: bool = true;
// Lengths along the ray; or along the optical axis, as planes are apart.
override PER_RAY: bool = true;
// Light the volume by the gradient, from the eye.
override PHONG: bool = false;
override AMBIENT: f32 = 0.3;
override DIFFUSE: f32 = 0.7;
override SPECULAR: f32 = 0.2;
override SHININESS: f32 = 20.0;

@fragment
fn fs_slice(in: Varying) -> @location(0) vec4f {
    let slab = slab_of(in);
    var front = slab.front;
    var back = slab.back;
    if front >= back {
        discard;
    }
    if NEAREST {
        return blended(cell_by_cell(slab));
    }
    var depth = back - front;
    var middle = slab.origin + 0.5 * (front + back) * slab.along;
    var scalars: vec2f;
    // Of the slab: the mean of its ends, which scales extinction. What that errs by is a product
    // of two changes over a slab, and so of second order.
    var coverage = 1.0;
    if GAPS && SLABS && CUT_ENDS {
        let left = without_gaps(slab);
        if left.depth <= 0.0 {
            discard;
        }
        scalars = left.scalars;
        front = left.front;
        back = left.back;
        depth = left.depth;
        middle = slab.origin + left.middle * slab.along;
    } else if SLABS {
        let a = sample_at(slab.origin + front * slab.along, slab.texel);
        let b = sample_at(slab.origin + back * slab.along, slab.texel);
        // An end that is not covered has no scalar of its own.
        scalars = vec2f(select(a.x, b.x, a.y <= 0.0), select(b.x, a.x, b.y <= 0.0));
        coverage = 0.5 * (a.y + b.y);
    } else {
        let there = sample_at(middle, slab.texel);
        scalars = vec2f(there.x);
        coverage = there.y;
    }
    if coverage <= 0.0 {
        discard;
    }
    if GAPS && max(scalars.x, scalars.y) >= GAP {
        discard;
    }
    let thickness = coverage * depth * select(1.0, stretched(slab), PER_RAY);
    var sum: vec4f;
    if CUED {
        let cue = vec2f(cue_in(slab, front), cue_in(slab, back));
        sum = integrate_cued(scalars.x, scalars.y, thickness, cue);
    } else {
        sum = integrate(scalars.x, scalars.y, thickness);
    }
    if PHONG {
        sum = lit(sum, middle, slab);
    }
    return blended(sum);
}

// The light and the optical depth of the cells that a slab crosses, front to back: the scalar
// of each is constant.
fn cell_by_cell(slab: Slab) -> vec4f {
    var sum = vec4f(0.0);
    var at = slab.front;
    let stretch = select(1.0, stretched(slab), PER_RAY);
    for (var n = 0u; n < MOST_CELLS; n++) {
        let next = min(next_plane(slab, at), slab.back);
        let cell = cell_of(slab.origin + 0.5 * (at + next) * slab.along);
        let scalar = scalar_of(voxel(cell + slab.texel));
        let thickness = (next - at) * stretch;
        if thickness > 0.0 && !(GAPS && scalar >= GAP) {
            let all = constant_of(scalar);
            if CUED {
                let cue = vec2f(cue_in(slab, at), cue_in(slab, next));
                sum = add_cued_piece(sum, all, all, thickness, cue);
            } else {
                sum = add_piece(sum, all, all, thickness);
            }
        }
        if next >= slab.back || hides_all(sum) {
            break;
        }
        at = next;
    }
    return sum;
}

// Color and extinction of a constant scalar; on a step both sides count half.
fn constant_of(scalar: f32) -> vec4f {
    let index = find_interval(scalar, true);
    let i = interval(index);
    let above = sample_interval(i, scalar);
    if index > 0u && scalar == i.low {
        return 0.5 * (above + sample_interval(interval(index - 1u), scalar));
    }
    return above;
}

// `sum` under a light at the eye: Phong's terms, on both sides of a surface.
//
// A gradient is a covector, so its product with the ray is the same in lattice and camera
// space. The highlight fades with the depth cue as all light does.
fn lit(sum: vec4f, middle: vec3f, slab: Slab) -> vec4f {
    let gradient = gradient_at(middle, slab.texel);
    let steepness = length(gradient * frame.inverse_spacing.xyz);
    // Where nothing changes there is no surface to light.
    var facing = 0.0;
    if steepness > 0.0 {
        facing = min(abs(dot(gradient, slab.along)) / (steepness * stretched(slab)), 1.0);
    }
    var light = sum.xyz * (AMBIENT + DIFFUSE * facing);
    if MODEL == EMISSION_ABSORPTION {
        var highlight = SPECULAR * pow(facing, SHININESS) * opacity(sum.w);
        if CUED {
            highlight *= cue_in(slab, 0.5 * (slab.front + slab.back));
        }
        light += highlight;
    }
    return vec4f(light, sum.w);
}
