// Gather: what a ray adds up, piece by piece.
//
// With: raycast_peel/shear.wgsl, preintegration/lookup.wgsl and what it needs, common/cue.wgsl,
//       common/layer.wgsl, common/look.wgsl, common/surfaces.wgsl, common/sums.wgsl

@group(0) @binding(5) var<uniform> look: Look;
@group(0) @binding(6) var<storage, read> look_items: array<vec4f>;

@group(2) @binding(0) var intervals: texture_2d<f32>; // three texels each
// One texel where `TABLE_AXES` is 0.
@group(2) @binding(1) var table: texture_3d<f32>;

fn look_of(i: u32) -> vec4f {
    return look_items[i];
}

fn interval(i: u32) -> KnotPair {
    let range = textureLoad(intervals, texel(3u * i + 2u), 0);
    return KnotPair(
        textureLoad(intervals, texel(3u * i), 0),
        textureLoad(intervals, texel(3u * i + 1u), 0),
        range.x,
        range.y,
        range.z,
    );
}

fn interval_count() -> u32 {
    return look.interval_count;
}

fn table_span() -> vec4f {
    return look.table_span;
}

// The distance of a surface where there is none.
const NO_SURFACE: f32 = 3e38;

// An optical depth behind which a ray stops, whatever its `stop_depth`.
const SURFACE_DEPTH: f32 = 1e35;

// Whether each cell, and not each vertex, has a scalar.
override SCALARS_PER_CELL: bool = false;

// What a ray has gathered, front to back.
struct Gathered {
    light: vec3f,
    depth: f32, // optical; stays 0 where the model does not absorb
    aside: vec4f, // both, of cells before
    surface_t: f32, // of the isosurface that it met
    // The interval of the transfer function in which the ray is: the scalar is
    // continuous along a path, so the next cell most likely begins in it.
    index: u32,
    interval: KnotPair,
}

fn nothing_gathered() -> Gathered {
    return Gathered(vec3f(0.0), 0.0, vec4f(0.0), FAR_AWAY, 0u, interval(0u));
}

// Adds light and optical depth of what lies behind, as if nothing were before it.
fn add(ray: ptr<function, Gathered>, behind: vec4f) {
    if MODEL == MAXIMUM_INTENSITY {
        (*ray).light = max((*ray).light, behind.xyz);
        return;
    }
    var reaches = 1.0;
    if MODEL == EMISSION_ABSORPTION {
        reaches = transmittance(optical_depth_of(*ray));
    }
    (*ray).light += reaches * behind.xyz;
    (*ray).depth += behind.w;
}

// Puts aside what was gathered, after every `SUMMED` cells of a path.
fn put_aside(ray: ptr<function, Gathered>, visits: u32) {
    if MODEL == MAXIMUM_INTENSITY || MODEL == ISOSURFACES {
        return;
    }
    let is_time = visits % SUMMED == 0u;
    (*ray).aside = select((*ray).aside, sum_of(*ray), is_time);
    (*ray).light = select((*ray).light, vec3f(0.0), is_time);
    (*ray).depth = select((*ray).depth, 0.0, is_time);
}

// Light and optical depth.
fn sum_of(ray: Gathered) -> vec4f {
    return ray.aside + vec4f(ray.light, ray.depth);
}

fn optical_depth_of(ray: Gathered) -> f32 {
    return ray.aside.w + ray.depth;
}

// A ray, apart from its shear.
struct Line {
    direction: vec3f,
    begin: f32, // z of the eye, or of the clip planes
    end: f32,
    cue: vec2f, // the depth cue at z is x + z y
}

// A piece of the ray in one cell.
struct Piece {
    front: f32,  // scalar
    back: f32,
    begin: f32,  // z
    length: f32, // 0 where there is nothing to add
    cue: vec2f,  // at both ends
}

// What of a piece is still to be added: it is added interval by interval, one in each pass of
// the loop that follows the ray, which so is the only one.
struct Rest {
    is_left: bool,
    scalar: f32,        // where it begins
    on_step: bool,      // waits for the other side of a step
    before_step: vec4f,
}

fn no_rest() -> Rest {
    return Rest(false, 0.0, false, vec4f(0.0));
}

// The piece of the ray between `near` and `far`, each (z, scalar), that is not cut
// away; `depth` is its length per unit of z. An inverted cell goes back; what was seen is not
// seen again.
fn piece_of(cell: u32, near: vec2f, far: vec2f, seen: f32, depth: f32, line: Line) -> Piece {
    // Where a layer is seen wholly, rounding back into what was seen cuts nothing of the next cell.
    let behind = select(seen, seen - THIN, MODEL == MAXIMUM_INTENSITY || MODEL == ISOSURFACES);
    let begin = max(max(near.x, behind), line.begin);
    let end = min(far.x, line.end);
    var front = near.y;
    var back = far.y;
    var shows = max(front, back) < TRANSPARENT_SCALAR;
    if SCALARS_PER_CELL {
        front = textureLoad(scalars, texel(cell), 0).x;
        back = front;
        shows = front < TRANSPARENT_SCALAR;
    } else {
        // Equal scalars stay equal, which `mix` does not promise.
        if begin > near.x {
            front = near.y + (begin - near.x) / (far.x - near.x) * (far.y - near.y);
        }
        if end < far.x {
            back = near.y + saturate((end - near.x) / (far.x - near.x)) * (far.y - near.y);
        }
    }
    var cue = vec2f(1.0);
    if CUED {
        cue = saturate(line.cue.x + vec2f(begin, end) * line.cue.y);
    }
    var length = select(0.0, (end - begin) * depth, shows && end > begin);
    if !SCALARS_PER_CELL && shows && is_layer(near, far) && far.x >= behind
        && near.x >= line.begin && far.x <= line.end {
        front = near.y;
        back = far.y;
        length = max(length, LAYER);
    }
    return Piece(front, back, begin, length, cue);
}

// Ends the ray at the first isosurface in a piece, if there is one.
fn meet_surface(piece: Piece, cell: array<Corner, 4>, shear: Shear, line: Line, ray: ptr<function, Gathered>) {
    let met = nearest_crossing(piece.front, piece.back);
    if met.surface == look.surface_count {
        return;
    }
    let g = gradient_of(
        vec4f(cell[0].xy, cell[0].z, cell[0].scalar),
        vec4f(cell[1].xy, cell[1].z, cell[1].scalar),
        vec4f(cell[2].xy, cell[2].z, cell[2].scalar),
        vec4f(cell[3].xy, cell[3].z, cell[3].scalar),
    );
    // Corners are sheared: x' = x − slope z changes the derivative by z alone.
    let g_z = shear.sign * (g.z - dot(shear.slope, g.xy));
    let gradient = unpermute(vec3f(g.xy, g_z), shear.axis);
    let cue = mix(piece.cue.x, piece.cue.y, met.share);
    (*ray).light = cue * shade(met.surface, gradient, line.direction);
    (*ray).depth = SURFACE_DEPTH;
    (*ray).surface_t = t_of(piece.begin, shear) + met.share * piece.length;
}

// Begins to add a piece that has a length: from the table at once, if there is one.
fn begin_piece(ray: ptr<function, Gathered>, piece: Piece, rest: ptr<function, Rest>) {
    if TABLE_AXES == 0u {
        (*rest).is_left = true;
        (*rest).scalar = piece.front;
        (*rest).on_step = false;
        return;
    }
    let sum = segment(piece.front, piece.back, piece.length);
    switch MODEL {
        case MAXIMUM_INTENSITY, EMISSION: {
            add(ray, vec4f(sum.xyz, 0.0));
        }
        default: {
            add(ray, vec4f(sum.xyz, segment_depth(sum)));
        }
    }
}

// Adds the part of a piece that is in one interval, as `integrate` does, from the interval
// that the ray is in.
fn gather_interval(ray: ptr<function, Gathered>, piece: Piece, rest: ptr<function, Rest>) {
    let front = piece.front;
    let back = piece.back;
    let whole = abs(back - front);
    let here = (*ray).interval;
    let scalar = (*rest).scalar;
    let on_step = (*rest).on_step;
    // The outer intervals reach beyond every scalar, so the walk does not leave the array.
    let outside = scalar > here.high || scalar < here.low;
    let end_scalar = clamp(back, here.low, here.high);
    var start = sample_interval(here, scalar);
    var end = sample_interval(here, end_scalar);
    // Each piece is as long as its share of the scalars; a constant one is whole.
    var share = piece.length * (abs(end_scalar - scalar) / max(whole, 1e-36));
    var up = back > here.high;
    var down = back < here.low;
    if whole == 0.0 {
        share = piece.length;
        // On a step both sides count half: this one waits for the other.
        start = select(start, 0.5 * (start + (*rest).before_step), on_step);
        end = start;
        if !outside && !on_step {
            up = scalar == here.high;
            down = scalar == here.low;
            (*rest).on_step = up || down;
            (*rest).before_step = start;
            share = select(share, 0.0, up || down);
        }
    }
    // A piece without length adds nothing, in MAXIMUM_INTENSITY neither.
    if !outside && share > 0.0 {
        if CUED {
            var at = vec2f(0.0, 1.0);
            if whole > 0.0 {
                at = abs(vec2f(scalar, end_scalar) - front) / whole;
            }
            add(ray, add_cued_piece(vec4f(0.0), start, end, share, mix(piece.cue.xx, piece.cue.yy, at)));
        } else {
            add(ray, add_piece(vec4f(0.0), start, end, share));
        }
    }
    if outside {
        up = scalar > here.high;
        down = scalar < here.low;
    } else {
        (*rest).scalar = end_scalar;
    }
    (*rest).is_left = up || down;
    if up || down {
        let index = select((*ray).index - 1u, (*ray).index + 1u, up);
        (*ray).index = index;
        (*ray).interval = interval(index);
    } else {
        (*rest).on_step = false;
    }
}

// What a ray leaves for gather/resolve.wgsl.
fn gathered(ray: Gathered) -> vec4f {
    let sum = sum_of(ray);
    if MODEL == ABSORPTION {
        return vec4f(sum.w, 0.0, 0.0, 0.0);
    }
    return vec4f(sum.xyz, opacity(sum.w));
}
