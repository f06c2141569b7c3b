// Slice: what a slab of the volume adds to a pixel, and the fragments of its polygons.
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
    if slab.front >= slab.back {
        discard;
    }
    return blended(part_of(slab));
}

// The light and the optical depth of a slab.
fn part_of(slab: Slab) -> vec4f {
    if NEAREST {
        return cell_by_cell(slab);
    }
    var left: Left;
    if GAPS && SLABS && CUT_ENDS {
        left = without_gaps(slab);
    } else if SLABS {
        let front = sample_at(slab.origin + slab.front * slab.along, slab.texel);
        let back = sample_at(slab.origin + slab.back * slab.along, slab.texel);
        left = between_samples(slab, front, back);
    } else {
        let there = sample_at(middle_of(slab), slab.texel);
        left = between_samples(slab, there, there);
    }
    var held = no_interval();
    return part_left(slab, left, &held);
}

// The light and the optical depth of what is left of a slab.
fn part_left(slab: Slab, left: Left, held: ptr<function, Held>) -> vec4f {
    let scalars = left.scalars;
    if left.depth <= 0.0 || left.coverage <= 0.0 || (GAPS && max(scalars.x, scalars.y) >= GAP) {
        return vec4f(0.0);
    }
    let thickness = left.coverage * left.depth * select(1.0, stretched(slab), PER_RAY);
    var sum: vec4f;
    if CUED {
        let cue = vec2f(cue_in(slab, left.front), cue_in(slab, left.back));
        sum = integrate_cued_from(held, scalars.x, scalars.y, thickness, cue);
    } else {
        sum = integrate_from(held, scalars.x, scalars.y, thickness);
    }
    if PHONG {
        sum = lit(sum, slab.origin + left.middle * slab.along, slab);
    }
    return sum;
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
