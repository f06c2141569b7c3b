// Rays: the slabs of a ray one behind the other, without polygons.
//
// They are those that polygons stand for, in the boxes that show; what boxes do not show is passed
// in one step. What slabs add is added up front to back in registers, so nothing behind what hides
// all is looked at, and nothing is blended but runs of slabs: a fragment takes `slabs_per_run`, as
// many as loops may take, and the runs of a ray are instances, back to front.
// In:   all boxes, and which of them show.
// Out:  as slice.wgsl and surface.wgsl.
// With: slicing/slice.wgsl and slicing/surface.wgsl, and what they need

// Of each box what turns a sample's index into its texel, and 1 if the box shows, else 0.
@group(2) @binding(0) var table: texture_3d<i32>;

// One triangle over the whole image for each run.
@vertex
fn vs_run(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    let run = frame.run_count - 1u - instance;
    return Varying(vec4f(corner, 0.0, 1.0), i32(run * frame.slabs_per_run), 0u);
}

// Some of a ray's slabs, from number `next` up to `end`. Those up to `last` are in one box, which
// shows.
struct Run {
    next: i32,
    end: i32,
    last: i32,
    texel: vec3i, // of that box
}

fn run_of(ray: Ray, first: i32) -> Run {
    var span = vec2f(ray.front, ray.back);
    if !CUT_ENDS {
        let inside = in_volume(ray);
        span = vec2f(max(span.x, inside.x), min(span.y, inside.y));
    }
    // The slabs in which the span begins and ends, and one more on each side for rounding.
    let numbers = (span - frame.first_depth) / frame.step;
    let least = f32(first);
    let most = f32(min(first + i32(frame.slabs_per_run), frame.slab_count));
    let next = clamp(floor(numbers.x) - 1.0, least, most);
    let end = clamp(floor(numbers.y) + 2.0, least, most);
    return Run(i32(next), select(i32(end), i32(next), span.x >= span.y), i32(next) - 1, vec3i(0));
}

// Goes on to the next slab that is in a box that shows, if there is one: else `next` is `end`.
fn seek(ray: Ray, run: ptr<function, Run>) {
    let cells_to_boxes = 1.0 / frame.box_size.xyz;
    for (var n = 0u; n < frame.slabs_per_run; n++) {
        let number = (*run).next;
        if number >= (*run).end || number <= (*run).last {
            return;
        }
        let slab = slab_on(ray, number, vec3i(0));
        let middle = middle_of(slab);
        if slab.front >= slab.back || is_outside(middle) {
            (*run).next = number + 1;
            continue;
        }
        // Cells are whole numbers below 2¹⁴: half of one is more than rounding.
        let place = vec3i((vec3f(cell_of(middle)) + 0.5) * cells_to_boxes);
        let part = textureLoad(table, place, 0);
        let last = last_in_box(ray, *run, place * vec3i(frame.box_size.xyz));
        if part.w != 0 {
            (*run).last = last;
            (*run).texel = part.xyz;
            return;
        }
        (*run).next = last + 1;
    }
}

// The number of the last slab in a row, from the next on, that is in this box. It may be too
// small: then the box is found again.
fn last_in_box(ray: Ray, run: Run, low: vec3i) -> i32 {
    let ahead = vec3f(low) + select(vec3f(0.0), frame.box_size.xyz, ray.along > vec3f(0.0));
    let depths = (ahead - ray.origin) / ray.along;
    // Along an axis that the ray does not follow it leaves no box.
    let leave = select(vec3f(FAR_AWAY), depths, ray.along != vec3f(0.0));
    let depth = min(leave.x, min(leave.y, leave.z));
    let number = (depth - frame.first_depth) / frame.step - 0.5;
    let last = i32(clamp(floor(number), f32(run.next), f32(run.end - 1)));
    // Middles follow each other as numbers do, in each coordinate and with all roundings. So if
    // the first and this one are in the box, all between them are.
    let slab = slab_on(ray, last, vec3i(0));
    let is_there = slab.front < slab.back && is_in_box(cell_of(middle_of(slab)), low);
    return select(run.next, last, is_there);
}

// Whether a slab begins with the sample at which the one before it ends.
fn shares_samples() -> bool {
    return SLABS && !NEAREST && !(GAPS && CUT_ENDS);
}

@fragment
fn fs_run(in: Varying) -> @location(0) vec4f {
    let ray = ray_of(in.position.xy);
    var run = run_of(ray, in.slab);
    var sum = vec4f(0.0);
    var held = no_interval();
    // Where the next slab begins, if the one before it was looked at.
    var front = vec2f(0.0);
    var joined = -1;
    // Each slab takes two passes at most: one for each of its ends.
    for (var n = 0u; n < 2u * frame.slabs_per_run; n++) {
        seek(ray, &run);
        if run.next >= run.end || hides_all(sum) {
            break;
        }
        let slab = slab_on(ray, run.next, run.texel);
        if slab.front >= slab.back || is_outside(middle_of(slab)) {
            run.next++;
            continue;
        }
        if !shares_samples() {
            sum = add_behind(sum, part_of(slab));
            run.next++;
            continue;
        }
        // One place where samples are read serves both ends.
        let is_joined = joined == run.next;
        let depth = select(slab.front, slab.back, is_joined);
        let there = sample_at(ray.origin + depth * ray.along, run.texel);
        if is_joined {
            sum = add_behind(sum, part_left(slab, between_samples(slab, front, there), &held));
            run.next++;
        }
        front = there;
        joined = run.next;
    }
    return blended(sum);
}

// `sum` and a part behind it.
fn add_behind(sum: vec4f, part: vec4f) -> vec4f {
    switch MODEL {
        case EMISSION_ABSORPTION: {
            return sum + vec4f(transmittance(sum.w) * part.xyz, part.w);
        }
        case MAXIMUM_INTENSITY: {
            return max(sum, part);
        }
        default: {
            return sum + part;
        }
    }
}

@fragment
fn fs_run_surface(in: Varying) -> Met {
    let ray = ray_of(in.position.xy);
    var run = run_of(ray, in.slab);
    var slab: Slab;
    var hit = Hit(look.surface_count, 0.0, vec3i(0));
    for (var n = 0u; n < frame.slabs_per_run; n++) {
        seek(ray, &run);
        if run.next >= run.end {
            break;
        }
        slab = slab_on(ray, run.next, run.texel);
        if slab.front < slab.back && !is_outside(middle_of(slab)) {
            hit = first_in(slab);
            if hit.surface != look.surface_count {
                break;
            }
        }
        run.next++;
    }
    if hit.surface == look.surface_count {
        discard;
    }
    return met(slab, hit);
}
