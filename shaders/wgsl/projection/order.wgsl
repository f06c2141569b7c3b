// Order: a key for each drawn item, greater nearer to the eye.
//
// The distance of the centroid from the eye (perspective) or along the view
// (orthographic). Of d² = (z + anchor)² + x² + y² only d² − anchor² is kept, which
// loses no digits when the eye is far, in steps of a 2²⁴th of its range.
// In:   cells, transformed, drawn.
// Out:  keys and values (items) for the radix sort, back to front.
// With: projection/frame.wgsl, projection/mesh.wgsl

@group(2) @binding(0) var<storage, read_write> keys: array<u32>;
@group(2) @binding(1) var<storage, read_write> values: array<u32>;

@compute @workgroup_size(256)
fn cs_order(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 256u + id.x;
    if i >= frame.cell_count {
        return;
    }
    let item = drawn[i];
    // Not `cell_of`: this pass is not compiled again for other transfer functions.
    let piece = pieces[min(item, arrayLength(&pieces) - 1u)];
    let v = cells[select(piece.x, item, piece.x == NO_CELL)];
    let c = 0.25 * (vertex(v.x) + vertex(v.y) + vertex(v.z) + vertex(v.w)).xyz;
    var near = c.z;
    if frame.w_per_depth > 0.0 {
        near = 2.0 * frame.anchor_depth * c.z + dot(c, c);
    }
    let key = clamp((frame.far_key - near) * frame.key_scale, 0.0, 16777215.0);
    keys[i] = u32(key);
    values[i] = item;
}

// `volume::NO_CELL`.
const NO_CELL: u32 = 0xffffffffu;
