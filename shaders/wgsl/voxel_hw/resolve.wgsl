// Resolve: the accumulation volume buffer as a grid's samples.

struct Resolve {
    dims: vec3u,       // of the part
    first: u32,        // its first layer in the grid
    low: f32,          // the field's range, in its unit
    high: f32,
    steps: f32,        // voxels are whole numbers of the range over this, unless it is 0
    samples: f32,      // of a voxel
    // The steps of a texel: columns run along any axis of the grid.
    across_x: vec3u,
    across_y: vec3u,
    along: vec3u,
}

@group(0) @binding(0) var<uniform> resolve: Resolve;
@group(0) @binding(1) var<storage, read> sums: array<u32>;   // as put.wgsl leaves them
@group(0) @binding(2) var samples: texture_storage_3d<rg32float, write>;

@compute @workgroup_size(64)
fn cs_resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= resolve.dims) {
        return;
    }
    let index = 3u * (id.x + resolve.dims.x * (id.y + resolve.dims.y * id.z));
    let count = sums[index + 2u];
    var texel = vec2f(0.0);
    if count > 0u {
        // In 2⁻³⁰ of the range.
        let whole = f32(sums[index + 1u]) * 4.0 + f32(sums[index]) * 9.31322574615478515625e-10;
        var share = min(whole / f32(count), 1.0);
        if resolve.steps > 0.0 {
            share = round(share * resolve.steps) / resolve.steps;
        }
        // The range may be too wide for a float.
        let scalar = (1.0 - share) * resolve.low + share * resolve.high;
        let held = clamp(scalar, resolve.low, resolve.high);
        texel = vec2f(held, min(f32(count) / resolve.samples, 1.0));
    }
    let at = id.x * resolve.across_x + id.y * resolve.across_y + (id.z + resolve.first) * resolve.along;
    textureStore(samples, at, vec4f(texel, 0.0, 0.0));
}
