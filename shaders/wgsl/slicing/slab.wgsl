// Slab: the part of a pixel's ray that a fragment stands for, and the field on it.
//
// Every number here depends on the pixel and the slab alone, so that boxes share no seam: a
// slab of a ray belongs to the one box that has its middle.
// With: slicing/frame.wgsl, slicing/box_plane.wgsl, common/look.wgsl,
//       common/ends.wgsl, slicing/corners.wgsl,
//       a part with `raw_at` and one with `sample_at`

// Cut the first and the last slab of a ray where the volume ends; or count them whole.
override CUT_ENDS: bool = true;
// Whether there are samples that are not finite: stored beyond GAP, and transparent.
override GAPS: bool = false;
const GAP: f32 = 1e30;
// Whether a cell has one scalar, the sample at its lower corner.
override NEAREST: bool = false;
// The gradient of the interpolant in its cell; or central differences.
override TRILINEAR: bool = false;

// Lattice space, but for through and slope.
struct Slab {
    origin: vec3f,  // of the ray, at depth 0
    along: vec3f,   // per unit of depth
    through: vec2f, // the ray in camera space is (through, 0) + depth · (slope, 1)
    slope: vec2f,
    front: f32,     // depths
    back: f32,      // not behind the front if nothing is left
    texel: vec3i,   // as in `PlacedBox`
}

fn slab_of(in: Varying) -> Slab {
    let part = boxes[in.box_index];
    let x = 2.0 * in.position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * in.position.y / frame.size.y;
    let origin = frame.origin.xyz + x * frame.origin_x.xyz + y * frame.origin_y.xyz;
    let along = frame.along.xyz + x * frame.along_x.xyz + y * frame.along_y.xyz;
    let extent = (frame.w_per_depth * frame.anchor_depth + frame.w_constant) / frame.clip_per_unit;
    let through = vec2f(x, y) * extent;
    let slope = vec2f(x, y) * frame.slope;
    var front = slab_depth(in.slab);
    var back = slab_depth(in.slab + 1);
    if CUT_ENDS {
        for (var axis = 0u; axis < 3u; axis++) {
            keep(origin[axis], along[axis], &front, &back);
            keep(frame.cells[axis] - origin[axis], -along[axis], &front, &back);
        }
    }
    let left = clip_ray(vec3f(through, 0.0), vec3f(slope, 1.0));
    front = max(front, left.x);
    back = min(back, min(left.y, end_of_ray(vec2i(in.position.xy))));
    let middle = origin + 0.5 * (front + back) * along;
    let outside = !CUT_ENDS && (any(middle < vec3f(0.0)) || any(middle > frame.cells.xyz));
    let cell = cell_of(middle);
    let elsewhere = any(cell < part.low) || any(cell >= part.low + vec3i(frame.box_size.xyz));
    if outside || elsewhere {
        back = front;
    }
    return Slab(origin, along, through, slope, front, back, part.texel);
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

// How long the ray is where its depth grows by 1.
fn stretched(slab: Slab) -> f32 {
    return length(vec3f(slab.slope, 1.0));
}

// The depth cue at a depth of the ray.
fn cue_in(slab: Slab, depth: f32) -> f32 {
    return cue_at(vec3f(slab.through + slab.slope * depth, depth));
}

// The cell of a point of the lattice; of several the last.
fn cell_of(lattice: vec3f) -> vec3i {
    return clamp(vec3i(floor(lattice)), vec3i(0), vec3i(frame.cells.xyz) - 1);
}

// The scalar at a point of the lattice, in the unit of `ScalarMap`; GAP or more where
// there is none.
fn scalar_at(lattice: vec3f, texel: vec3i) -> f32 {
    return scalar_of(raw_at(lattice, texel));
}

// What is read of the texture as a scalar. Integers lose a whole number, which is exact.
fn scalar_of(raw: f32) -> f32 {
    return raw * frame.scalar_unit - frame.scalar_base;
}

// More cells than a slab crosses: along each axis a ray goes at most two voxels in it, so
// that it meets at most three planes, and one more if rounding puts it just beside one.
const MOST_CELLS: u32 = 13u;

// The depth behind `at` where the ray crosses the next plane of samples.
fn next_plane(slab: Slab, at: f32) -> f32 {
    var next = FAR_AWAY;
    for (var axis = 0u; axis < 3u; axis++) {
        let slope = slab.along[axis];
        if slope == 0.0 {
            continue;
        }
        let place = slab.origin[axis] + at * slope;
        let ahead = sign(slope);
        var plane = select(ceil(place) - 1.0, floor(place) + 1.0, slope > 0.0);
        if (plane - slab.origin[axis]) / slope <= at {
            plane += ahead;
        }
        next = min(next, (plane - slab.origin[axis]) / slope);
    }
    return next;
}

fn has_gap(c: Corners) -> bool {
    let greatest = max(c.low, c.high);
    return GAPS && max(max(greatest.x, greatest.y), max(greatest.z, greatest.w)) >= GAP;
}

// What cells with gaps leave of a slab.
struct Left {
    scalars: vec2f, // where it begins and where it ends
    front: f32,     // depths
    back: f32,
    depth: f32,     // from front to back without the gaps between; 0 if nothing is left
    middle: f32,    // a depth that is not in a gap, in the middle if all is left
}

// Cells without gaps on both sides of one are taken for neighbors: the scalar changes by
// about as much as a slab is long, and few slabs have any gaps, so what this errs by is of
// second order.
fn without_gaps(slab: Slab) -> Left {
    var left = Left(vec2f(0.0), slab.back, slab.back, 0.0, slab.back);
    var longest = 0.0;
    var has_all = true;
    var at = slab.front;
    for (var n = 0u; n < MOST_CELLS; n++) {
        let next = min(next_plane(slab, at), slab.back);
        let cell = cell_of(slab.origin + 0.5 * (at + next) * slab.along);
        let c = corners(cell + slab.texel);
        if has_gap(c) {
            has_all = false;
        } else {
            let enter = saturate(slab.origin + at * slab.along - vec3f(cell));
            let leave = saturate(slab.origin + next * slab.along - vec3f(cell));
            if left.depth == 0.0 {
                left.front = at;
                left.scalars.x = value_in(c, enter);
            }
            left.back = next;
            left.scalars.y = value_in(c, leave);
            left.depth += next - at;
            if next - at > longest {
                longest = next - at;
                left.middle = 0.5 * (at + next);
            }
        }
        if next >= slab.back {
            break;
        }
        at = next;
    }
    if has_all {
        left.depth = slab.back - slab.front;
        left.middle = 0.5 * (slab.front + slab.back);
    }
    return left;
}

// The gradient at a point of the lattice, per voxel.
fn gradient_at(lattice: vec3f, texel: vec3i) -> vec3f {
    let cell = cell_of(lattice);
    let inside = gradient_in(corners(cell + texel), saturate(lattice - vec3f(cell)));
    if TRILINEAR {
        return inside;
    }
    // By central differences, one-sided at the volume's border: six fetches.
    let low = max(lattice - 1.0, vec3f(0.0));
    let high = min(lattice + 1.0, frame.cells.xyz);
    var gradient: vec3f;
    for (var axis = 0u; axis < 3u; axis++) {
        var before = lattice;
        var behind = lattice;
        before[axis] = low[axis];
        behind[axis] = high[axis];
        let difference = scalar_at(behind, texel) - scalar_at(before, texel);
        gradient[axis] = difference / (high[axis] - low[axis]);
    }
    // Beside a gap the cell alone knows.
    let beside = GAPS && any(abs(gradient) >= vec3f(1e-9 * GAP));
    return select(gradient, inside, beside);
}
