// Rectangle: what a plane of samples, or the slab behind it, adds to a pixel.
//
// Prakash, Manohar 1995, section 4: planes of the volume are textures on rectangles, which are
// blended in their order. `fs_slice` is that; `fs_slab` integrates between two planes instead.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color.
// With: stacks/layer.wgsl and what it needs, common/optics_model.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl, common/cue.wgsl

@group(1) @binding(0) var<storage, read> intervals: array<KnotPair>;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

// Whether a rectangle stands for the slab up to the next one.
override SLABS: bool = true;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) layer: i32,
}

// Six vertices for the part of the image in which a rectangle, or a slab, can show.
//
// Which pixels its rays meet is for fragments to say: rasterizers round corners, to a sixteenth of a
// pixel, and the sides of a slab would be drawn twice, or not at all, where they are narrower.
@vertex
fn vs_rectangle(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varying {
    let layer = layer_of(i32(instance));
    let part = part_of_image(layer);
    let is_right = vertex == 1u || vertex >= 4u;
    let is_high = vertex == 2u || vertex == 3u || vertex == 5u;
    let place = vec2f(select(part.x, part.z, is_right), select(part.y, part.w, is_high));
    return Varying(vec4f(place, 0.5, 1.0), layer);
}

// Back to front: each ray meets those before the eye, or those behind it, in this order.
fn layer_of(instance: i32) -> i32 {
    return select(instance - frame.ahead, frame.rectangle_count - 1 - instance, instance < frame.ahead);
}

// What is as near to the eye may be behind it for all that f32 knows of its depth.
const NEAREST: f32 = 1.0 / 1024.0;
// How far camera space is off: sums of four terms of at most 2, each of which rounds thrice, and so
// do the sums: 24 · 2 · 2⁻²⁴, and twice that.
const ROUNDING: f32 = 1.0 / 262144.0;

// The lower left and the upper right corner, each in [−1, 1].
fn part_of_image(layer: i32) -> vec4f {
    var low = vec2f(FAR_AWAY);
    var high = vec2f(-FAR_AWAY);
    var nearest = FAR_AWAY;
    var farthest = -FAR_AWAY;
    let thick = select(0.0, 1.0, SLABS);
    for (var corner = 0u; corner < 8u; corner++) {
        let at = vec3f((vec3u(corner) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
        let p = vec4f(at.xy * frame.cells.xy, f32(layer) + at.z * thick, 1.0);
        let distance = dot(frame.forward, p) + frame.anchor_depth;
        let w = frame.w_per_depth * distance + frame.w_constant;
        let place = vec2f(dot(frame.right, p), dot(frame.up, p)) * frame.inverse_reach
            / max(w, NEAREST);
        low = min(low, place);
        high = max(high, place);
        nearest = min(nearest, w);
        farthest = max(farthest, distance);
    }
    if farthest <= 0.0 {
        return vec4f(2.0);
    }
    if nearest < NEAREST {
        return vec4f(-1.0, -1.0, 1.0, 1.0);
    }
    // An eighth of a pixel for rasterizers, and what places and w are off by.
    let margin = 0.25 / frame.size + ROUNDING * (frame.inverse_reach + 1.0) / nearest;
    return clamp(vec4f(low - margin, high + margin), vec4f(-1.0), vec4f(1.0));
}

// The sample in the plane, for as long as planes are apart along the ray.
@fragment
fn fs_slice(in: Varying) -> @location(0) vec4f {
    let ray = ray_of(in.position);
    let layer = f32(in.layer);
    let is_parallel = ray.along.z == 0.0;
    let depth = (layer - ray.origin.z) / select(ray.along.z, 1.0, is_parallel);
    let place = ray.origin.xy + depth * ray.along.xy;
    let outside = any(place < vec2f(0.0)) || any(place > frame.cells.xy);
    if is_parallel || outside || depth < ray.span.x || depth >= ray.span.y {
        discard;
    }
    let there = scalar_of(in_layer(place, in.layer));
    if there.y <= 0.0 {
        discard;
    }
    // The samples end at the first and the last plane, which have a neighbor on one side alone. A
    // ray that goes along the planes is in the box for less than to the next one.
    let is_last = layer == 0.0 || layer == frame.cells.z;
    let apart = select(1.0, 0.5, is_last) / abs(ray.along.z);
    let inside = within(ray, vec3f(0.0), frame.cells.xyz, vec2f(-FAR_AWAY, FAR_AWAY));
    let thickness = there.y * stretched(ray) * min(apart, max(inside.y - inside.x, 0.0));
    if CUED {
        return blended(integrate_cued(there.x, there.x, thickness, vec2f(cue_in(ray, depth))));
    }
    return blended(integrate(there.x, there.x, thickness));
}

// The integral between both ends of the ray in the slab.
@fragment
fn fs_slab(in: Varying) -> @location(0) vec4f {
    let ray = ray_of(in.position);
    let low = vec3f(0.0, 0.0, f32(in.layer));
    let high = vec3f(frame.cells.xy, low.z + 1.0);
    let part = within(ray, low, high, ray.span);
    if part.x >= part.y {
        discard;
    }
    let front = scalar_in_slab(ray, part.x, in.layer);
    let back = scalar_in_slab(ray, part.y, in.layer);
    if front.y + back.y <= 0.0 {
        discard;
    }
    // An end that is not covered has no scalar of its own.
    let scalars = vec2f(select(front.x, back.x, front.y <= 0.0), select(back.x, front.x, back.y <= 0.0));
    let coverage = coverage_between(vec2f(front.y, back.y), scalars);
    let thickness = coverage * stretched(ray) * (part.y - part.x);
    if CUED {
        let cue = vec2f(cue_in(ray, part.x), cue_in(ray, part.y));
        return blended(integrate_cued(scalars.x, scalars.y, thickness, cue));
    }
    return blended(integrate(scalars.x, scalars.y, thickness));
}

// What scales the extinction of a slab, whose ends have these coverages C and scalars s.
//
// Of three linear functions, C, C s and σ(s), C σ(s) is linear, too: so the slab has the optical
// depth of a trapezoid, (C₀ σ₀ + C₁ σ₁) / 2 per length, and that of σ alone times this. Elsewhere it
// is a mean of both coverages all the same, and what it errs by is of second order.
fn coverage_between(coverage: vec2f, scalars: vec2f) -> f32 {
    if ALL_OR_NOTHING || coverage.x == coverage.y {
        return select(coverage.x, 1.0, ALL_OR_NOTHING);
    }
    let extinction = vec2f(extinction_of(scalars.x), extinction_of(scalars.y));
    let sum = extinction.x + extinction.y;
    if sum <= 0.0 {
        return 0.5 * (coverage.x + coverage.y);
    }
    return dot(coverage, extinction) / sum;
}

fn extinction_of(scalar: f32) -> f32 {
    return sample_interval(interval(find_interval(scalar, true)), scalar).w;
}

// The scalar at a depth of the ray, in the slab behind `layer`. Most rays enter and leave slabs
// through planes of samples, of which one is read then.
fn scalar_in_slab(ray: Ray, depth: f32, layer: i32) -> vec2f {
    let p = ray.origin + depth * ray.along;
    let place = clamp(p.xy, vec2f(0.0), frame.cells.xy);
    let planes = (vec2f(f32(layer), f32(layer) + 1.0) - ray.origin.z)
        / select(ray.along.z, 1.0, ray.along.z == 0.0);
    var share = saturate(p.z - f32(layer));
    if ray.along.z != 0.0 {
        share = select(share, 0.0, depth == planes.x);
        share = select(share, 1.0, depth == planes.y);
    }
    // Whether a cell is there, both of its layers say.
    if !ALL_OR_NOTHING && (share == 0.0 || share == 1.0) {
        return scalar_of(in_layer(place, layer + i32(share)));
    }
    return scalar_of(between_layers(in_layer(place, layer), in_layer(place, layer + 1), share));
}
