// March: follow each ray from cell to cell to its end, in one dispatch.
//
// Bernardon et al. 2004 take one step a pass and peel the boundary layer by
// layer; here a ray's loop is a loop, and it finds where it meets the boundary among
// the boundary faces of its tile, or reads that from layers.
// In:   vertices, cells, boundary, and for each tile the boundary faces that its rays may meet,
//       or layers of those that each ray crosses.
// Out:  linear premultiplied RGBA over the background, one texel a ray.
// With: raycast_peel/rays.wgsl, raycast_peel/boundary.wgsl and preintegration/lookup.wgsl and
//       what they need, common/cue.wgsl, common/look.wgsl

struct Counters {
    cell_visits_low: atomic<u32>,
    cell_visits_high: atomic<u32>,
    paths: atomic<u32>,
    unpaired_faces: atomic<u32>, // rays that cross the boundary an odd number of times
    lost_rays: atomic<u32>,      // rays that came out through a face that they do not cross
}

@group(0) @binding(1) var image: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var<storage, read_write> counters: Counters;
// For each tile where its boundary faces begin, and where the last ends; then these faces.
@group(0) @binding(3) var<storage, read> tile_faces: array<u32>;
@group(0) @binding(4) var depths: texture_storage_2d<r32float, write>; // of ISOSURFACES
@group(0) @binding(5) var<uniform> look: Look;
@group(0) @binding(6) var<storage, read> look_items: array<vec4f>;
// The boundary faces that each ray crosses, in order, from peel.wgsl; NO_FACE behind the last.
@group(0) @binding(7) var layers: texture_2d_array<u32>;

// Lists of texels (common/texels.wgsl).
@group(1) @binding(1) var scalars: texture_2d<f32>;   // of each cell, for cell data
@group(1) @binding(2) var sums: texture_2d<u32>;      // of each cell, see `follow`
@group(1) @binding(3) var neighbors: texture_2d<u32>;

@group(2) @binding(0) var intervals: texture_2d<f32>; // three texels each
// One texel where `TABLE_AXES` is 0.
@group(2) @binding(1) var table: texture_3d<f32>;

fn look_of(i: u32) -> vec4f {
    return look_items[i];
}

fn interval(i: u32) -> Interval {
    let range = textureLoad(intervals, texel(3u * i + 2u), 0);
    return Interval(
        textureLoad(intervals, texel(3u * i), 0),
        textureLoad(intervals, texel(3u * i + 1u), 0),
        range.x,
        range.y,
        range.z,
    );
}

override INTERVAL_COUNT: u32 = 1u;

fn interval_count() -> u32 {
    return INTERVAL_COUNT;
}

// A cell is the exclusive or of its four vertex ids, in `sums`, and the neighbors across the
// faces opposite its vertices by increasing id (Aman, Demirci, Güdükbay 2022).
// A neighbor with this bit is a boundary face.
const AT_BOUNDARY: u32 = 0x80000000u;

// How many boundary faces one search keeps. A ray with more
// searches again from where it was.
const KEPT: u32 = 8u;

// The boundary faces that a ray crosses, by increasing (t, face).
//
// In vectors, as software rasterizers are slow at arrays with an index.
struct Crossings {
    t: vec4f,
    face: vec4u,
    more_t: vec4f,
    more_face: vec4u,
    kept: u32,
    total: u32, // beyond `after`, kept or not
}

fn no_crossings() -> Crossings {
    let none = vec4f(FAR_AWAY);
    return Crossings(none, vec4u(NO_FACE), none, vec4u(NO_FACE), 0u, 0u);
}

// Whether rays read the boundary faces that they cross from `layers`, and do not search.
override LAYERED: bool = false;

fn peeled_face(pixel: vec2u, layer: u32) -> u32 {
    return textureLoad(layers, pixel, layer, 0).x;
}

// How many layers a ray is in.
fn peeled_faces(pixel: vec2u) -> u32 {
    var count = 0u;
    while count < march.layers && peeled_face(pixel, count) != NO_FACE {
        count += 1u;
    }
    return count;
}

// (t, face) orders crossings; faces break ties, so two faces at one place have an order.
fn comes_before(t0: f32, face0: u32, t1: f32, face1: u32) -> bool {
    return t0 < t1 || (t0 == t1 && face0 < face1);
}

// The first crossings after (t, face), in order, among the faces of a tile.
fn search(tile: u32, shear: Shear, after_t: f32, after_face: u32, first: bool) -> Crossings {
    var found = no_crossings();
    let end = tile_faces[tile + 1u];
    for (var i = tile_faces[tile]; i < end; i += 1u) {
        let face = tile_faces[i];
        let crossed = boundary_crossing(face, shear);
        let counts = crossed.y != 0.0 && (first || comes_before(after_t, after_face, crossed.x, face));
        // What does not count comes after all, and changes nothing.
        let t = select(FAR_AWAY, crossed.x, counts);
        let id = select(NO_FACE, face, counts);
        found.total += u32(counts);
        let before = earlier(t, id, found.t, found.face);
        let last_t = found.t.w;
        let last_face = found.face.w;
        found.t = inserted_t(t, found.t, before);
        found.face = inserted_face(id, found.face, before);
        // What was pushed out goes to the second half.
        let next_t = select(t, last_t, before.w);
        let next_face = select(id, last_face, before.w);
        let before_more = earlier(next_t, next_face, found.more_t, found.more_face);
        found.more_t = inserted_t(next_t, found.more_t, before_more);
        found.more_face = inserted_face(next_face, found.more_face, before_more);
    }
    found.kept = min(found.total, KEPT);
    return found;
}

// Before which of four crossings one comes.
fn earlier(t: f32, face: u32, ts: vec4f, faces: vec4u) -> vec4<bool> {
    return (vec4f(t) < ts) | ((vec4f(t) == ts) & (vec4u(face) < faces));
}

// Four sorted numbers with one more, the last pushed out; `before` says before which it comes.
fn inserted_t(t: f32, ts: vec4f, before: vec4<bool>) -> vec4f {
    let pushed = vec4<bool>(false, before.xyz);
    return select(ts, select(vec4f(t), vec4f(0.0, ts.xyz), pushed), before);
}

fn inserted_face(face: u32, faces: vec4u, before: vec4<bool>) -> vec4u {
    let pushed = vec4<bool>(false, before.xyz);
    return select(faces, select(vec4u(face), vec4u(0u, faces.xyz), pushed), before);
}

// Without the first.
fn rest(found: Crossings) -> Crossings {
    return Crossings(
        vec4f(found.t.yzw, found.more_t.x),
        vec4u(found.face.yzw, found.more_face.x),
        vec4f(found.more_t.yzw, FAR_AWAY),
        vec4u(found.more_face.yzw, NO_FACE),
        found.kept - 1u,
        found.total - 1u,
    );
}

// A ray, apart from its shear.
struct Line {
    direction: vec3f,
    begin: f32, // t of the eye, or of the clip planes
    end: f32,
    cue: vec2f, // the depth cue at t is x + t y
}

// Where a path through the mesh ended.
struct Exit {
    face: u32,   // a boundary face
    visits: u32, // cells passed
}

// Follows the ray from boundary face `entry` through the mesh to the boundary
// face where it leaves, and adds every cell on the way to `ray`.
//
// Ends without a counter: each cell is crossed through exactly two faces
// (walk.wgsl), so a path cannot come back to a cell.
fn follow(entry: u32, turn: i32, shear: Shear, line: Line, ray: ptr<function, Gathered>) -> Exit {
    let ids = textureLoad(boundary, texel(entry), 0);
    var a = corner(ids.x, shear);
    var b = corner(ids.y, shear);
    var c = corner(ids.z, shear);
    var cell = ids.w;
    let turned = f32(turn);
    var near = crossing_point(a, b, c, turned) * vec2f(shear.depth, 1.0); // t, scalar
    var seen = near.x; // t never goes back, not even in an inverted cell
    var visits = 0u;
    var exit = NO_FACE;
    loop {
        let at = texel(cell);
        let d = corner(textureLoad(sums, at, 0).x ^ a.id ^ b.id ^ c.id, shear);
        // Of the three faces around d, the ray leaves through the one whose two
        // edges at d pass it on the side of the entry face's edges.
        var left = a;
        var kept = vec2u(b.id, c.id);
        if side(a.xy, d.xy) == -turn {
            if side(b.xy, d.xy) == turn {
                left = c;
                kept = vec2u(a.id, b.id);
                c = d;
            } else {
                a = d;
            }
        } else if side(c.xy, d.xy) == -turn {
            left = b;
            kept = vec2u(a.id, c.id);
            b = d;
        } else {
            a = d;
        }
        let rank = u32(kept.x < left.id) + u32(kept.y < left.id) + u32(d.id < left.id);
        let next = textureLoad(neighbors, at, 0)[rank];
        let far = crossing_point(a, b, c, turned) * vec2f(shear.depth, 1.0);
        let piece = piece_of(cell, near, far, seen, line);
        if piece.length > 0.0 {
            if MODEL == ISOSURFACES {
                meet_surface(piece, array<Corner, 4>(a, b, c, left), shear, line, ray);
            } else {
                gather(ray, piece);
            }
        }
        visits += 1u;
        seen = max(seen, far.x);
        near = far;
        // Before the boundary is looked at: in a path's last cell, too, a ray may be done.
        if (*ray).depth > march.stop_depth {
            break;
        }
        if (next & AT_BOUNDARY) != 0u {
            exit = next & ~AT_BOUNDARY;
            break;
        }
        if seen >= line.end {
            break;
        }
        cell = next;
    }
    return Exit(exit, visits);
}

// A piece of the ray in one cell.
struct Piece {
    front: f32,  // scalar
    back: f32,
    begin: f32,  // t
    length: f32, // 0 where there is nothing to add
    cue: vec2f,  // at both ends
}

// The piece of the ray between `near` and `far`, each (t, scalar), that is not cut
// away. An inverted cell goes back; what was seen is not seen again.
fn piece_of(cell: u32, near: vec2f, far: vec2f, seen: f32, line: Line) -> Piece {
    let begin = max(max(near.x, seen), line.begin);
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
    return Piece(front, back, begin, select(0.0, end - begin, shows && end > begin), cue);
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
    let gradient = unpermute(vec3f(g.xy, g.z - dot(shear.slope, g.xy)), shear.axis);
    let cue = mix(piece.cue.x, piece.cue.y, met.share);
    (*ray).light = cue * shade(met.surface, gradient, line.direction);
    (*ray).depth = SURFACE_DEPTH;
    (*ray).surface_t = piece.begin + met.share * piece.length;
}

// The depth of rays that meet none.
const NO_SURFACE: f32 = 3e38;

// An optical depth behind which a ray stops, whatever its `stop_depth`.
const SURFACE_DEPTH: f32 = 1e35;

// Whether each cell, and not each vertex, has a scalar.
override SCALARS_PER_CELL: bool = false;

// What a ray has gathered, front to back.
struct Gathered {
    light: vec3f,
    depth: f32, // optical; stays 0 where the model does not absorb
    surface_t: f32, // of the isosurface that it met
    // The interval of the transfer function in which the ray is: the scalar is
    // continuous along a path, so the next cell most likely begins in it.
    index: u32,
    interval: Interval,
}

fn nothing_gathered() -> Gathered {
    return Gathered(vec3f(0.0), 0.0, FAR_AWAY, 0u, interval(0u));
}

// Adds a piece, from the table if there is one.
fn gather(ray: ptr<function, Gathered>, piece: Piece) {
    if TABLE_AXES == 0u {
        gather_exactly(ray, piece);
        return;
    }
    let sum = segment(piece.front, piece.back, piece.length);
    switch MODEL {
        case MAXIMUM_INTENSITY: {
            (*ray).light = max((*ray).light, sum.xyz);
        }
        case EMISSION: {
            (*ray).light += sum.xyz;
        }
        default: {
            (*ray).light += transmittance((*ray).depth) * sum.xyz;
            (*ray).depth += segment_depth(sum);
        }
    }
}

// Adds a piece as `integrate` does, from the interval that the ray is in.
//
// One loop with one place that reads an interval: software rasterizers run what
// follows a branch whether or not it is taken.
fn gather_exactly(ray: ptr<function, Gathered>, piece: Piece) {
    let front = piece.front;
    let back = piece.back;
    let whole = abs(back - front);
    var scalar = front;
    var on_step = false;
    var before_step = vec4f(0.0);
    var here = (*ray).interval;
    var index = (*ray).index;
    var sum = vec4f((*ray).light, (*ray).depth);
    loop {
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
            start = select(start, 0.5 * (start + before_step), on_step);
            end = start;
            if !outside && !on_step {
                up = scalar == here.high;
                down = scalar == here.low;
                on_step = up || down;
                before_step = start;
                share = select(share, 0.0, on_step);
            }
        }
        // A piece without length adds nothing, in MAXIMUM_INTENSITY neither.
        if !outside && share > 0.0 {
            if CUED {
                var at = vec2f(0.0, 1.0);
                if whole > 0.0 {
                    at = abs(vec2f(scalar, end_scalar) - front) / whole;
                }
                sum = add_cued_piece(sum, start, end, share, mix(piece.cue.xx, piece.cue.yy, at));
            } else {
                sum = add_piece(sum, start, end, share);
            }
        }
        if outside {
            up = scalar > here.high;
            down = scalar < here.low;
        } else {
            scalar = end_scalar;
        }
        if !up && !down {
            break;
        }
        index = select(index - 1u, index + 1u, up);
        here = interval(index);
    }
    (*ray).interval = here;
    (*ray).index = index;
    (*ray).light = sum.xyz;
    (*ray).depth = sum.w;
}

// `tetrascope_core::optics::over`, model by model.
fn over(ray: Gathered, behind: vec4f) -> vec4f {
    let t = transmittance(ray.depth);
    switch MODEL {
        case EMISSION: {
            return vec4f(ray.light + behind.xyz, behind.w);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(max(ray.light, behind.xyz), behind.w);
        }
        default: {
            return vec4f(ray.light + t * behind.xyz, opacity(ray.depth) + t * behind.w);
        }
    }
}

const TILE: u32 = 8u;

var<workgroup> tile_visits: atomic<u32>;
var<workgroup> tile_paths: atomic<u32>;
var<workgroup> tile_unpaired: atomic<u32>;
var<workgroup> tile_lost: atomic<u32>;

@compute @workgroup_size(TILE, TILE)
fn cs_cast(
    @builtin(global_invocation_id) pixel: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var visits = 0u;
    if pixel.x < march.width && pixel.y < march.height {
        visits = cast_ray(pixel.xy);
    }
    // One addition a tile to what all tiles share.
    atomicAdd(&tile_visits, visits);
    workgroupBarrier();
    if lane == 0u {
        let sum = atomicLoad(&tile_visits);
        let before = atomicAdd(&counters.cell_visits_low, sum);
        if before + sum < before {
            atomicAdd(&counters.cell_visits_high, 1u);
        }
        atomicAdd(&counters.paths, atomicLoad(&tile_paths));
        atomicAdd(&counters.unpaired_faces, atomicLoad(&tile_unpaired));
        atomicAdd(&counters.lost_rays, atomicLoad(&tile_lost));
    }
}

// Casts the ray of one pixel, writes its texel and returns how many cells it passed.
fn cast_ray(pixel: vec2u) -> u32 {
    let pixel_ray = ray_of(pixel);
    let shear = shear_of(pixel_ray.anchor, pixel_ray.direction);
    let left = clip_ray(pixel_ray.anchor, pixel_ray.direction);
    let cue_x = dot(look.cue.xyz, pixel_ray.anchor) + look.cue.w;
    let cue = vec2f(cue_x, dot(look.cue.xyz, pixel_ray.direction));
    let line = Line(pixel_ray.direction, max(pixel_ray.eye_t, left.x), left.y, cue);
    var ray = nothing_gathered();
    let traced = trace(pixel, shear, line, &ray);
    atomicAdd(&tile_paths, traced.paths);
    atomicAdd(&tile_unpaired, traced.crossings % 2u);
    atomicAdd(&tile_lost, traced.lost);
    textureStore(image, pixel, over(ray, march.background));
    if MODEL == ISOSURFACES {
        // World units from where the ray starts.
        let depth = select((ray.surface_t - pixel_ray.eye_t) * march.scale, NO_SURFACE, ray.surface_t == FAR_AWAY);
        textureStore(depths, pixel, vec4f(depth, 0.0, 0.0, 0.0));
    }
    return traced.visits;
}

// What a ray did.
struct Traced {
    crossings: u32, // of the boundary
    paths: u32,     // through the mesh
    visits: u32,    // of cells
    lost: u32,      // 1 if it came out through a face that it does not cross
}

// Follows a ray along all its paths, in order.
fn trace(pixel: vec2u, shear: Shear, line: Line, ray: ptr<function, Gathered>) -> Traced {
    let tile = pixel.y / TILE * march.tiles_x + pixel.x / TILE;
    var peeled = 0u;
    if LAYERED {
        peeled = peeled_faces(pixel);
    }
    let is_peeled = LAYERED && peeled < march.listed_from;
    var found = no_crossings();
    if is_peeled {
        found.kept = peeled;
        found.total = peeled;
    } else {
        found = search(tile, shear, 0.0, 0u, true);
    }
    var traced = Traced(found.total, 0u, 0u, 0u);
    // The ends of the latest paths: the boundary is crossed there too, but from inside.
    var exits = vec4u(NO_FACE);
    while found.kept > 0u {
        var face = found.face.x;
        if is_peeled {
            face = peeled_face(pixel, traced.crossings - found.total);
        }
        found = rest(found);
        let crossed = boundary_crossing(face, shear);
        let t = crossed.x;
        if crossed.y == 0.0 {
            traced.lost = 1u; // two programs decided about one ray in two ways
            break;
        }
        if t >= line.end {
            break;
        }
        if !any(exits == vec4u(face)) {
            let before = *ray;
            let path = follow(face, i32(crossed.y), shear, line, ray);
            if path.face == NO_FACE {
                traced.visits += path.visits;
                traced.paths += 1u;
                break;
            }
            let way_out = boundary_crossing(path.face, shear);
            if way_out.y == 0.0 {
                traced.lost = 1u; // what walk.wgsl says cannot be
            }
            if comes_before(way_out.x, path.face, t, face) {
                // The path was followed from its other end, which the four above forgot.
                *ray = before;
            } else {
                traced.visits += path.visits;
                exits = vec4u(path.face, exits.xyz);
                traced.paths += 1u;
            }
        }
        if found.kept == 0u && found.total > 0u {
            found = search(tile, shear, t, face, false);
        }
    }
    return traced;
}
