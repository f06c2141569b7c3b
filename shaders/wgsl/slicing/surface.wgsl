// Surface: where a ray meets the first isosurface in a slab, and how it is lit.
//
// Slabs come back to front, and what is met hides all behind, so nothing is blended.
// Out:  the color; the distance along the ray from the eye, normalized units.
// With: slicing/slab.wgsl and what it needs, common/surfaces.wgsl

@group(0) @binding(4) var<storage, read> look_items: array<vec4f>;

fn look_of(i: u32) -> vec4f {
    return look_items[i];
}

// In the voxel cells that the slab crosses, where the field is a cubic along the ray; or
// between the samples at the slab's ends.
override IN_CELLS: bool = true;
// How often the place between a slab's ends is corrected by another sample.
override CORRECTIONS: u32 = 0u;

struct Met {
    @location(0) color: vec4f,
    @location(1) distance: f32,
}

// A surface at a depth of the ray; surface_count if there is none.
struct Hit {
    surface: u32,
    depth: f32,
    cell: vec3i,
}

@fragment
fn fs_surface(in: Varying) -> Met {
    let slab = slab_of(in);
    if slab.front >= slab.back {
        discard;
    }
    let hit = first_in(slab);
    if hit.surface == look.surface_count {
        discard;
    }
    return met(slab, hit);
}

fn first_in(slab: Slab) -> Hit {
    // Where each cell has its own scalar, no value is met in any.
    if NEAREST {
        return Hit(look.surface_count, 0.0, vec3i(0));
    }
    if IN_CELLS {
        return first_in_cells(slab);
    }
    return first_between_ends(slab);
}

// The surface as it is seen.
fn met(slab: Slab, hit: Hit) -> Met {
    let place = slab.origin + hit.depth * slab.along;
    var gradient: vec3f;
    if TRILINEAR {
        let f = saturate(place - vec3f(hit.cell));
        gradient = gradient_in(corners(hit.cell + slab.texel), f);
    } else {
        gradient = gradient_at(clamp(place, vec3f(0.0), frame.cells.xyz), slab.texel);
    }
    // The axes in camera space, each over the square of its spacing: gradients are
    // covectors. Only the direction counts, and this way the squares fit.
    let narrow = frame.inverse_spacing.xyz;
    let share = narrow / max(narrow.x, max(narrow.y, narrow.z));
    let scaled = gradient * share * share;
    let normal = vec3f(
        dot(frame.right.xyz, scaled),
        dot(frame.up.xyz, scaled),
        dot(frame.forward.xyz, scaled),
    );
    var color = shade(hit.surface, normal, vec3f(slab.slope, 1.0));
    if CUED {
        color *= cue_in(slab, hit.depth);
    }
    return Met(vec4f(color, 1.0), (hit.depth + frame.anchor_depth) * stretched(slab));
}

fn first_in_cells(slab: Slab) -> Hit {
    var at = slab.front;
    // The scalar where the last cell was left, if that had one.
    var last = 0.0;
    var joined = false;
    for (var n = 0u; n < MOST_CELLS; n++) {
        let next = min(next_plane(slab, at), slab.back);
        let cell = cell_of(slab.origin + 0.5 * (at + next) * slab.along);
        let c = corners(cell + slab.texel);
        let gap = has_gap(c);
        if !gap {
            let enter = saturate(slab.origin + at * slab.along - vec3f(cell));
            let leave = saturate(slab.origin + next * slab.along - vec3f(cell));
            let b = cubic_of(c, enter, leave);
            let crossing = first_on_cubic(b, select(b.x, last, joined));
            if crossing.surface != look.surface_count {
                return Hit(crossing.surface, mix(at, next, crossing.share), cell);
            }
            last = b.w;
        }
        joined = !gap;
        if next >= slab.back {
            break;
        }
        at = next;
    }
    return Hit(look.surface_count, 0.0, vec3i(0));
}

// The first surface that a cubic meets, after a joint from `last` to its front; the share
// is 2 if there is none. Between its extremes a cubic rises or falls.
fn first_on_cubic(b: vec4f, last: f32) -> Crossing {
    let joint = first_between(last, b.x);
    if joint != look.surface_count {
        return Crossing(joint, 0.0);
    }
    // The curve stays between its coefficients.
    let least = min(min(b.x, b.y), min(b.z, b.w));
    let greatest = max(max(b.x, b.y), max(b.z, b.w));
    if first_between(least, greatest) == look.surface_count {
        return Crossing(look.surface_count, 2.0);
    }
    // A third of the derivative is e.x (1−s)² + 2 e.y s (1−s) + e.z s².
    let e = b.yzw - b.xyz;
    let discriminant = e.y * e.y - e.x * e.z;
    let slope = e.y - e.x;
    let q = -(slope + select(-1.0, 1.0, slope >= 0.0) * sqrt(max(discriminant, 0.0)));
    let a = (e.x - e.y) + (e.z - e.y);
    // A root outside of (0, 1), or none, divides nothing.
    let first = inside(q, a, discriminant);
    let second = inside(e.x, q, discriminant);
    let places = vec4f(0.0, min(first, second), max(first, second), 1.0);
    var front = b.x;
    for (var part = 0u; part < 3u; part++) {
        let there = clamp(cubic_at(b, places[part + 1u]), least, greatest);
        let back = select(there, b.w, part == 2u);
        let surface = first_between(front, back);
        if surface != look.surface_count {
            let d = b - look_of(surface).w;
            let share = place_between(d, places[part], places[part + 1u], front < back);
            return Crossing(surface, share);
        }
        front = back;
    }
    return Crossing(look.surface_count, 2.0);
}

// a / b if that is in (0, 1) and a root is real, else 1.
fn inside(a: f32, b: f32, discriminant: f32) -> f32 {
    let between = discriminant > 0.0 && a * b > 0.0 && abs(a) < abs(b);
    return select(1.0, a / select(1.0, b, between), between);
}

// Where a cubic passes 0 between two places, on which it only rises or only falls:
// Newton's steps, and halves where those leave the bracket or do not shrink it.
fn place_between(d: vec4f, from_place: f32, to_place: f32, rising: bool) -> f32 {
    var low = from_place;
    var high = to_place;
    var place = 0.5 * (low + high);
    var before = high - low;
    let e = 3.0 * (d.yzw - d.xyz);
    // 24 halvings reach the last bit; Newton's steps are done after four or five.
    for (var n = 0u; n < 24u; n++) {
        let value = cubic_at(d, place);
        if (value < 0.0) == rising {
            low = place;
        } else {
            high = place;
        }
        let first = mix(e.xy, e.yz, place);
        let slope = mix(first.x, first.y, place);
        let step = -value / select(1.0, slope, slope != 0.0);
        let newton = slope != 0.0 && place + step > low && place + step < high
            && 2.0 * abs(step) < before;
        let next = select(0.5 * (low + high), place + step, newton);
        before = abs(next - place);
        place = next;
        if before < 1e-7 {
            break;
        }
    }
    return place;
}

fn first_between_ends(slab: Slab) -> Hit {
    let front = scalar_at(slab.origin + slab.front * slab.along, slab.texel);
    let back = scalar_at(slab.origin + slab.back * slab.along, slab.texel);
    let crossing = nearest_crossing(front, back);
    var hit = Hit(crossing.surface, mix(slab.front, slab.back, min(crossing.share, 1.0)), vec3i(0));
    if GAPS && max(front, back) >= GAP {
        hit.surface = look.surface_count;
    }
    if hit.surface != look.surface_count {
        if CORRECTIONS > 0u {
            hit.depth = corrected(slab, look_of(hit.surface).w, vec2f(front, back), hit.depth);
        }
        hit.cell = cell_of(slab.origin + hit.depth * slab.along);
    }
    return hit;
}

// The depth of `value` between a slab's ends with the scalars `ends`, from a first guess:
// false position, in which an end that stays twice counts half (Illinois).
fn corrected(slab: Slab, value: f32, ends: vec2f, guess: f32) -> f32 {
    var low = slab.front;
    var high = slab.back;
    var at_low = ends.x - value;
    var at_high = ends.y - value;
    var depth = guess;
    var kept = 0;
    for (var n = 0u; n < CORRECTIONS; n++) {
        let here = scalar_at(slab.origin + depth * slab.along, slab.texel) - value;
        if GAPS && here >= 0.5 * GAP {
            break;
        }
        if (here < 0.0) == (ends.x < value) {
            low = depth;
            at_low = here;
            at_high *= select(1.0, 0.5, kept == 1);
            kept = 1;
        } else {
            high = depth;
            at_high = here;
            at_low *= select(1.0, 0.5, kept == 2);
            kept = 2;
        }
        let change = at_high - at_low;
        if change == 0.0 {
            break;
        }
        depth = clamp(low - at_low * (high - low) / change, low, high);
    }
    return depth;
}
