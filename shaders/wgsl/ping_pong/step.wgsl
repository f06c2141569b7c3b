// Step: each ray through one cell.
//
// Phase 3a of Bernardon et al. 2004. Both targets are read in one pass and written in
// the next ("ping-pong"), as no target can be read while it is written.
// In:   the traversal state (figure 9): cell, λ and scalar; color and opacity.
// Out:  the same, one cell further.
// With: common/layer.wgsl, ping_pong/rays.wgsl, ping_pong/planes.wgsl or ping_pong/sides.wgsl,
//       ping_pong/transfer.wgsl, preintegration/lookup.wgsl and what it needs

@group(2) @binding(0) var states: texture_2d<f32>;
@group(2) @binding(1) var colors: texture_2d<f32>;

// Whether each cell, and not each vertex, has a scalar.
override SCALARS_PER_CELL: bool = false;

// Whether the field jumps where cells touch: then a cell begins with its own scalar, and not with
// that where the ray left the last one.
override JUMPS: bool = false;

struct Stepped {
    @location(0) state: vec4f,
    @location(1) color: vec4f,
}

// Between the depth of idle rays, 0, and that of others, 1.
@vertex
fn vs_step(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.5);
}

@fragment
fn fs_step(@builtin(position) position: vec4f) -> Stepped {
    let pixel = vec2i(position.xy);
    let state = textureLoad(states, pixel, 0);
    let color = textureLoad(colors, pixel, 0);
    if state.x < 0.0 || color.w >= frame.stop_opacity {
        return Stepped(state, color);
    }
    let ray = ray_of(position);
    let cell = vec2i(state.xy);
    let leaving = leave(cell, ray);
    if leaving.lambda >= FAR {
        return Stepped(vec4f(LOST, LOST, state.zw), color);
    }
    // A flat cell, or rounding, may go back; what was seen is not seen again.
    let way_out = vec2f(leaving.lambda, leaving.scalar);
    let in_layer = !SCALARS_PER_CELL && !JUMPS && state.z >= ray.eye && is_layer(state.zw, way_out);
    if leaving.lambda <= state.z && !in_layer {
        return Stepped(vec4f(leaving.next, state.z, scalar_after(state.w, leaving)), color);
    }
    let back = leaving.scalar;
    var front = state.w;
    var begin = state.z;
    if SCALARS_PER_CELL {
        front = back;
    } else if JUMPS {
        front = scalar_where_entered(cell, ray, state);
    } else if front >= TRANSPARENT_SCALAR {
        front = scalar_between(cell, ray, state, leaving, begin);
    }
    if begin < ray.eye {
        // A camera in the volume sees what is before it.
        begin = min(ray.eye, leaving.lambda);
        if front < TRANSPARENT_SCALAR && !SCALARS_PER_CELL {
            front = scalar_between(cell, ray, vec4f(state.xyz, front), leaving, begin);
        }
    }
    var sum = color;
    if (leaving.lambda > begin || in_layer) && max(front, back) < TRANSPARENT_SCALAR {
        let length = leaving.lambda - begin;
        let piece = segment(front, back, select(length, max(length, LAYER), in_layer));
        sum = over(color, vec4f(piece.xyz, segment_opacity(piece)));
    }
    return Stepped(vec4f(leaving.next, max(leaving.lambda, state.z), back), sum);
}

// Equation 3, model by model: what is behind `front`, as light and opacity.
fn over(front: vec4f, behind: vec4f) -> vec4f {
    switch MODEL {
        case EMISSION: {
            return vec4f(front.xyz + behind.xyz, 0.0);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(max(front.xyz, behind.xyz), 0.0);
        }
        default: {
            return front + (1.0 - front.w) * behind;
        }
    }
}
