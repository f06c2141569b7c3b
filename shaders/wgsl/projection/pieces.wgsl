// Pieces: a cell is drawn once for each interval of the transfer function that it has
// scalars in, so that no fragment searches, loops or reads memory.
//
// Scalars become places u in the piece, 0 at its lower end and 1 at its upper one.
// Planes of one scalar part the pieces, so their order is the same for all rays from the
// eye: those on the far side of the eye's own scalar first, beginning with the farthest.
//
// Where `PARTS`, a piece that may be too deep for `segment_weights` is drawn more than
// once: of each ray's way through it, the farthest part, then the one before it.
// With: projection/footprint.wgsl, projection/transfer.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl

override PARTS: bool = false;

// Replaces the scalars in `out` by places in a piece. `what` is which: how many others are
// drawn before it, 16 bits; how many of its parts are, 8 bits; and the number of its parts
// less 1.
fn choose_piece(out: ptr<function, Varying>, what: u32) {
    let rank = what & 0xffffu;
    let parts = (what >> 24u) + 1u;
    let part = parts - 1u - ((what >> 16u) & 0xffu);
    let s = vec4f((*out).v0.w, (*out).v1.w, (*out).v2.w, (*out).v3.w);
    let least_scalar = least(s);
    let greatest_scalar = greatest(s);
    let first = (*out).range.x;
    let last = (*out).range.y;
    // The piece that the eye looks at from within, or the nearest.
    let seen_from = scalar_at_eye(*out);
    // By bisection: at most 16 passes.
    var own = first;
    var end = last;
    while own < end {
        let middle = (own + end + 1u) / 2u;
        if interval(middle).low < seen_from {
            own = middle;
        } else {
            end = middle - 1u;
        }
    }
    let below = own - first;
    let index = select(last - (rank - below), first + rank, rank < below);
    let i = interval(index);
    let low = max(i.low, least_scalar);
    let high = min(i.high, greatest_scalar);
    (*out).at_low = sample_interval(i, low);
    (*out).at_high = sample_interval(i, high);
    // What only touches an end of the cell is in the piece there.
    var ends = vec2f(select(0.0, -1e30, index == first), select(1.0, 1e30, index == last));
    var u = (s - low) / select(high - low, 1.0, high <= low);
    if least_scalar == greatest_scalar {
        // One piece. On a step, both sides count half.
        let other = interval(last);
        let value = 0.5 * (sample_interval(interval(first), low) + sample_interval(other, low));
        (*out).at_low = value;
        (*out).at_high = value;
        ends = vec2f(-1e30, 1e30);
        u = vec4f(0.5);
    }
    (*out).piece = vec4f(ends, vec2f(f32(part), 1.0) / f32(parts));
    (*out).v0.w = u.x;
    (*out).v1.w = u.y;
    (*out).v2.w = u.z;
    (*out).v3.w = u.w;
}

// What the cell's linear function is at the eye; beyond all scalars in parallel projection.
fn scalar_at_eye(v: Varying) -> f32 {
    let a = v.v1 - v.v0;
    let b = v.v2 - v.v0;
    let c = v.v3 - v.v0;
    let bc = cross(b.xyz, c.xyz);
    let gradient = a.w * bc + b.w * cross(c.xyz, a.xyz) + c.w * cross(a.xyz, b.xyz);
    let volume = dot(a.xyz, bc);
    if frame.w_per_depth == 0.0 {
        return select(1e30, -1e30, gradient.z * volume > 0.0);
    }
    let rise = dot(gradient, vec3f(0.0, 0.0, -frame.anchor_depth) - v.v0.xyz);
    if abs(volume) * 1e30 <= abs(rise) {
        return select(-1e30, 1e30, rise * sign(volume) > 0.0);
    }
    return v.v0.w + rise / volume;
}

// What a ray's part in the cell adds that is in the piece, from place `front` to `back`.
fn integrate_piece(in: Varying, front: f32, back: f32, length: f32) -> vec4f {
    let ends = in.piece.xy;
    var start = clamp(front, ends.x, ends.y);
    var end = clamp(back, ends.x, ends.y);
    let whole = abs(back - front);
    // Constant along the ray: in the piece, or between two, half in each.
    let inside = select(0.0, select(1.0, 0.5, any(vec2f(front) == ends)), front == start);
    var share = select(abs(end - start) / whole, inside, whole == 0.0);
    if share <= 0.0 {
        return vec4f(0.0);
    }
    if PARTS {
        let way = end - start;
        start += in.piece.z * way;
        end = start + in.piece.w * way;
        share *= in.piece.w;
    }
    let at = saturate(vec2f(start, end));
    return add_piece(
        vec4f(0.0),
        in.at_low * (1.0 - at.x) + in.at_high * at.x,
        in.at_low * (1.0 - at.y) + in.at_high * at.y,
        length * share,
    );
}
