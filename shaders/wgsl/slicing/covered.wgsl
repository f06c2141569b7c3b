// Voxels of a grid on the device with coverage: scalars in the field's unit, and how much of
// each sample is there.
//
// As `tetrascope_core::grid::coverage` defines it: with the trilinear weights w, a point has the
// coverage C = Σ w c and the scalar Σ w c s / C. Where all corners are covered whole, both are
// what `trilinear.wgsl` makes of the scalars, to the last bit.
// With: slicing/frame.wgsl, slicing/trilinear.wgsl

@group(1) @binding(1) var voxels: texture_3d<f32>;

// A scalar and its coverage.
fn covered_voxel(texel: vec3i) -> vec2f {
    let raw = textureLoad(voxels, texel, 0).xy;
    let scalar = clamp(raw.x - frame.raw_base, -frame.raw_most, frame.raw_most) * frame.raw_unit;
    return vec2f(scalar, saturate(raw.y));
}

fn voxel(texel: vec3i) -> f32 {
    return covered_voxel(texel).x;
}

// The scalar at a point of the lattice, and its coverage; 0 and 0 where nothing is.
fn sample_at(lattice: vec3f, texel: vec3i) -> vec2f {
    let base = clamp(floor(lattice), vec3f(0.0), frame.cells.xyz - 1.0);
    let f = saturate(lattice - base);
    let i = vec3i(base) + texel;
    let a = covered_voxel(i);
    let b = covered_voxel(i + vec3i(0, 1, 0));
    let c = covered_voxel(i + vec3i(0, 0, 1));
    let d = covered_voxel(i + vec3i(0, 1, 1));
    let e = covered_voxel(i + vec3i(1, 0, 0));
    let g = covered_voxel(i + vec3i(1, 1, 0));
    let h = covered_voxel(i + vec3i(1, 0, 1));
    let k = covered_voxel(i + vec3i(1, 1, 1));
    let low = Covered(vec4f(a.x, b.x, c.x, d.x), vec4f(a.y, b.y, c.y, d.y));
    let high = Covered(vec4f(e.x, g.x, h.x, k.x), vec4f(e.y, g.y, h.y, k.y));
    let coverage = trilinear(low.coverage, high.coverage, f);
    if coverage <= 0.0 {
        return vec2f(0.0);
    }
    let sum = trilinear(low.coverage * low.scalars, high.coverage * high.scalars, f);
    if coverage >= 1.0 {
        return vec2f(sum, 1.0);
    }
    // A quotient rounds; a constant stays what it is.
    let least = min(least_of(low), least_of(high));
    let greatest = max(greatest_of(low), greatest_of(high));
    return vec2f(clamp(sum / coverage, least, greatest), coverage);
}

// Four corners of a cell: of those that are not covered the scalars do not matter.
struct Covered {
    scalars: vec4f,
    coverage: vec4f,
}

fn trilinear(low: vec4f, high: vec4f, f: vec3f) -> f32 {
    let edges = low + f.x * (high - low);
    let faces = edges.xz + f.y * (edges.yw - edges.xz);
    return faces.x + f.z * (faces.y - faces.x);
}

fn least_of(c: Covered) -> f32 {
    let s = select(vec4f(GAP), c.scalars, c.coverage > vec4f(0.0));
    return min(min(s.x, s.y), min(s.z, s.w));
}

fn greatest_of(c: Covered) -> f32 {
    let s = select(vec4f(-GAP), c.scalars, c.coverage > vec4f(0.0));
    return max(max(s.x, s.y), max(s.z, s.w));
}
