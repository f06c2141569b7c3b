// Slab: a part of a pixel's ray between two planes, and the field on it.
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

// What of a pixel's ray is looked at. Lattice space, but for through and slope.
struct Ray {
    origin: vec3f,  // at depth 0
    along: vec3f,   // per unit of depth
    through: vec2f, // in camera space the ray is (through, 0) + depth · (slope, 1)
    slope: vec2f,
    front: f32,     // depths; with `CUT_ENDS` the volume's ends are cut off
    back: f32,
}

struct Slab {
    origin: vec3f, // as in `Ray`
    along: vec3f,
    through: vec2f,
    slope: vec2f,
    front: f32,    // depths
    back: f32,     // not behind the front if nothing is left
    texel: vec3i,  // as in `PlacedBox`
}

fn ray_of(position: vec2f) -> Ray {
    let x = 2.0 * position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * position.y / frame.size.y;
    let origin = frame.origin.xyz + x * frame.origin_x.xyz + y * frame.origin_y.xyz;
    let along = frame.along.xyz + x * frame.along_x.xyz + y * frame.along_y.xyz;
    let extent = (frame.w_per_depth * frame.anchor_depth + frame.w_constant) / frame.clip_per_unit;
    let through = vec2f(x, y) * extent;
    let slope = vec2f(x, y) * frame.slope;
    let left = clip_ray(vec3f(through, 0.0), vec3f(slope, 1.0));
    var ray = Ray(origin, along, through, slope, left.x, min(left.y, end_of_ray(vec2i(position))));
    if CUT_ENDS {
        let inside = in_volume(ray);
        ray.front = max(ray.front, inside.x);
        ray.back = min(ray.back, inside.y);
    }
    return ray;
}

// Between which depths a ray is in the volume.
fn in_volume(ray: Ray) -> vec2f {
    var front = -FAR_AWAY;
    var back = FAR_AWAY;
    for (var axis = 0u; axis < 3u; axis++) {
        keep(ray.origin[axis], ray.along[axis], &front, &back);
        keep(frame.cells[axis] - ray.origin[axis], -ray.along[axis], &front, &back);
    }
    return vec2f(front, back);
}

// What is left of a slab on a ray.
fn slab_on(ray: Ray, number: i32, texel: vec3i) -> Slab {
    let front = max(slab_depth(number), ray.front);
    let back = min(slab_depth(number + 1), ray.back);
    return Slab(ray.origin, ray.along, ray.through, ray.slope, front, back, texel);
}

// The middle of a slab; a slab belongs to the box that has it.
fn middle_of(slab: Slab) -> vec3f {
    return slab.origin + 0.5 * (slab.front + slab.back) * slab.along;
}

// Whether a slab that is not cut where the volume ends is left out.
fn is_outside(middle: vec3f) -> bool {
    return !CUT_ENDS && (any(middle < vec3f(0.0)) || any(middle > frame.cells.xyz));
}

fn is_in_box(cell: vec3i, low: vec3i) -> bool {
    return all(cell >= low) && all(cell < low + vec3i(frame.box_size.xyz));
}

// The slab that a polygon's fragment stands for; empty if that is another's.
fn slab_of(in: Varying) -> Slab {
    let part = boxes[in.box_index];
    var slab = slab_on(ray_of(in.position.xy), in.slab, part.texel);
    let middle = middle_of(slab);
    if is_outside(middle) || !is_in_box(cell_of(middle), part.low) {
        slab.back = slab.front;
    }
    return slab;
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

// What is left of a slab, of which cells with gaps are cut out.
struct Left {
    scalars: vec2f, // where it begins and where it ends
    front: f32,     // depths
    back: f32,
    depth: f32,     // from front to back without the gaps between; 0 if nothing is left
    middle: f32,    // a depth that is not in a gap, in the middle if all is left
    // The mean of both ends, which scales extinction. What that errs by is a product of two
    // changes over a slab, and so of second order.
    coverage: f32,
}

// All of a slab, with these samples at its ends.
fn between_samples(slab: Slab, front: vec2f, back: vec2f) -> Left {
    // An end that is not covered has no scalar of its own.
    let scalars = vec2f(
        select(front.x, back.x, front.y <= 0.0),
        select(back.x, front.x, back.y <= 0.0),
    );
    let middle = 0.5 * (slab.front + slab.back);
    let depth = slab.back - slab.front;
    return Left(scalars, slab.front, slab.back, depth, middle, 0.5 * (front.y + back.y));
}

// Cells without gaps on both sides of one are taken for neighbors: the scalar changes by
// about as much as a slab is long, and few slabs have any gaps, so what this errs by is of
// second order.
fn without_gaps(slab: Slab) -> Left {
    var left = Left(vec2f(0.0), slab.back, slab.back, 0.0, slab.back, 1.0);
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
