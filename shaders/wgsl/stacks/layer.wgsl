// Layer: the field between the samples of a layer, and between two layers.
//
// As `tetrascope_core::grid::coverage` defines it: with the weights w of samples, a point has the
// coverage C = Σ w c and the scalar Σ w c s / C. Without coverage each c is 1, which changes no bit
// of the interpolated scalar.
// With: stacks/frame.wgsl

@group(1) @binding(1) var stack: texture_2d_array<f32>;

// Whether texels have a coverage behind the scalar.
override COVERED: bool = false;
// For models that know nothing between: a cell is there if each of its samples is, or not at all.
override ALL_OR_NOTHING: bool = false;
const THERE: f32 = 0.5;
// Beyond any scalar.
const BEYOND: f32 = 1e30;

// A weighted mean that may go on along another axis.
struct Mean {
    sum: f32,      // Σ w c s
    coverage: f32, // Σ w c
    least: f32,    // of the covered scalars
    greatest: f32,
}

// A scalar and its coverage.
fn sample_of(place: vec2i, layer: i32) -> vec2f {
    let raw = textureLoad(stack, place, layer, 0).xy;
    let scalar = clamp(raw.x - frame.raw_base, -frame.raw_most, frame.raw_most) * frame.raw_unit;
    return vec2f(scalar, select(1.0, saturate(raw.y), COVERED));
}

// In a layer, bilinearly: four loads.
fn in_layer(place: vec2f, layer: i32) -> Mean {
    let base = clamp(floor(place), vec2f(0.0), frame.cells.xy - 1.0);
    let f = saturate(place - base);
    let i = vec2i(base);
    let a = sample_of(i, layer);
    let b = sample_of(i + vec2i(0, 1), layer);
    let c = sample_of(i + vec2i(1, 0), layer);
    let d = sample_of(i + vec2i(1, 1), layer);
    let scalars = vec4f(a.x, b.x, c.x, d.x);
    let coverage = vec4f(a.y, b.y, c.y, d.y);
    if ALL_OR_NOTHING {
        let whole = select(0.0, 1.0, all(coverage >= vec4f(THERE)));
        return Mean(whole * bilinear(scalars, f), whole, -BEYOND, BEYOND);
    }
    let low = select(vec4f(BEYOND), scalars, coverage > vec4f(0.0));
    let high = select(vec4f(-BEYOND), scalars, coverage > vec4f(0.0));
    return Mean(
        bilinear(coverage * scalars, f),
        bilinear(coverage, f),
        min(min(low.x, low.y), min(low.z, low.w)),
        max(max(high.x, high.y), max(high.z, high.w)),
    );
}

// Corners (0, 0), (0, 1), (1, 0), (1, 1). Where all are equal so is what is between them.
fn bilinear(corners: vec4f, f: vec2f) -> f32 {
    let edge = corners.xy + f.x * (corners.zw - corners.xy);
    return edge.x + f.y * (edge.y - edge.x);
}

// Between a layer and the next one.
fn between_layers(near: Mean, far: Mean, share: f32) -> Mean {
    let both = near.coverage * far.coverage > 0.0;
    return Mean(
        near.sum + share * (far.sum - near.sum),
        select(near.coverage + share * (far.coverage - near.coverage), 0.0, ALL_OR_NOTHING && !both),
        min(near.least, far.least),
        max(near.greatest, far.greatest),
    );
}

// The scalar and its coverage; 0 and 0 where nothing is.
fn scalar_of(mean: Mean) -> vec2f {
    if mean.coverage <= 0.0 {
        return vec2f(0.0);
    }
    if mean.coverage >= 1.0 {
        return vec2f(mean.sum, 1.0);
    }
    // A quotient rounds; a constant stays what it is.
    return vec2f(clamp(mean.sum / mean.coverage, mean.least, mean.greatest), mean.coverage);
}
