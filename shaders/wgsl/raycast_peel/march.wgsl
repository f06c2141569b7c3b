// March: follow each ray from cell to cell to its end, in one dispatch.
//
// Bernardon et al. 2004 take one step a pass and peel the boundary layer by
// layer; here a ray's loop is a loop, and it finds where it meets the boundary among
// the boundary faces of its tile.
// In:   vertices, cells, boundary, and for each tile the boundary faces that its rays may meet.
// Out:  linear premultiplied RGBA over the background, one texel a ray.
// With: raycast_peel/walk.wgsl, common/sides.wgsl, preintegration/lookup.wgsl and
//       what it needs, common/cue.wgsl, common/look.wgsl

struct March {
    anchor: vec4f,     // anchor of pixel (0, 0)'s center, relative to the mesh's center; w unused
    anchor_x: vec4f,   // how the anchor moves from a pixel to its right neighbor
    anchor_y: vec4f,   // … and to the one below
    eye: vec4f,        // perspective: the eye, w = 1; orthographic: the direction, w = 0
    background: vec4f, // premultiplied
    eye_depth: f32,    // orthographic: t of the camera's plane, seen from the anchor
    width: u32,
    height: u32,
    tiles_x: u32,      // tiles a row
    stop_depth: f32,   // optical depth beyond which a ray stops
    scale: f32,        // world units in a normalized unit
    padding_1: u32,
    padding_2: u32,
}

// A boundary face and the cell behind it.
struct BoundaryFace {
    a: u32,
    b: u32,
    c: u32,
    cell: u32,
}

struct Counters {
    cell_visits_low: atomic<u32>,
    cell_visits_high: atomic<u32>,
    paths: atomic<u32>,
    unpaired_faces: atomic<u32>, // rays that cross the boundary an odd number of times
    lost_rays: atomic<u32>,      // rays that came out through a face that they do not cross
}

@group(0) @binding(0) var<uniform> march: March;
@group(0) @binding(1) var image: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var<storage, read_write> counters: Counters;
// For each tile where its boundary faces begin, and where the last ends; then these faces.
@group(0) @binding(3) var<storage, read> tile_faces: array<u32>;
@group(0) @binding(4) var depths: texture_storage_2d<r32float, write>; // of ISOSURFACES
@group(0) @binding(5) var<uniform> look: Look;
@group(0) @binding(6) var<storage, read> look_items: array<vec4f>;

@group(1) @binding(0) var<storage, read> positions: array<f32>; // x, y, z of each vertex, normalized
@group(1) @binding(1) var<storage, read> scalars: array<f32>;   // of each vertex or cell
@group(1) @binding(2) var<storage, read> cells: array<u32>;     // CELL_WORDS each
@group(1) @binding(3) var<storage, read> boundary: array<BoundaryFace>;

@group(2) @binding(0) var<storage, read> intervals: array<Interval>;
// One texel where `TABLE_AXES` is 0.
@group(2) @binding(1) var table: texture_3d<f32>;

fn look_of(i: u32) -> vec4f {
    return look_items[i];
}

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

// A cell is the exclusive or of its four vertex ids, then the neighbors across the
// faces opposite its vertices by increasing id (Aman, Demirci, Güdükbay 2022).
const CELL_WORDS: u32 = 5u;
// A neighbor with this bit is a boundary face.
const AT_BOUNDARY: u32 = 0x80000000u;

// How many boundary faces one search keeps. A ray with more
// searches again from where it was.
const KEPT: u32 = 6u;

// The boundary faces that a ray crosses, by increasing (t, face).
struct Crossings {
    t: array<f32, 6>,
    face: array<u32, 6>,
    kept: u32,
    total: u32, // beyond `after`, kept or not
}

// (t, face) orders crossings; faces break ties, so two faces at one place have an order.
fn comes_before(t0: f32, face0: u32, t1: f32, face1: u32) -> bool {
    return t0 < t1 || (t0 == t1 && face0 < face1);
}

// t where the ray crosses boundary face `face`. One function for search and
// walk, so that both get the same bits.
fn boundary_crossing(face: u32, shear: Shear) -> vec2f {
    let ids = boundary[face];
    let a = corner(ids.a, shear);
    let b = corner(ids.b, shear);
    let c = corner(ids.c, shear);
    let turn = crossing(a.xy, b.xy, c.xy);
    let t = crossing_point(a, b, c, f32(turn)).x * shear.depth;
    return vec2f(t, f32(turn));
}

// The first crossings after (t, face), in order, among the faces of a tile.
fn search(tile: u32, shear: Shear, after_t: f32, after_face: u32, first: bool) -> Crossings {
    var found: Crossings;
    let end = tile_faces[tile + 1u];
    for (var i = tile_faces[tile]; i < end; i += 1u) {
        let face = tile_faces[i];
        let crossed = boundary_crossing(face, shear);
        if crossed.y == 0.0 || !(first || comes_before(after_t, after_face, crossed.x, face)) {
            continue;
        }
        found.total += 1u;
        insert(&found, crossed.x, face);
    }
    return found;
}

fn insert(found: ptr<function, Crossings>, t: f32, face: u32) {
    var place = (*found).kept;
    if place == KEPT {
        if !comes_before(t, face, (*found).t[KEPT - 1u], (*found).face[KEPT - 1u]) {
            return;
        }
        place = KEPT - 1u;
    } else {
        (*found).kept += 1u;
    }
    while place > 0u && comes_before(t, face, (*found).t[place - 1u], (*found).face[place - 1u]) {
        (*found).t[place] = (*found).t[place - 1u];
        (*found).face[place] = (*found).face[place - 1u];
        place -= 1u;
    }
    (*found).t[place] = t;
    (*found).face[place] = face;
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
    let ids = boundary[entry];
    var a = corner(ids.a, shear);
    var b = corner(ids.b, shear);
    var c = corner(ids.c, shear);
    var cell = ids.cell;
    let turned = f32(turn);
    var near = crossing_point(a, b, c, turned) * vec2f(shear.depth, 1.0); // t, scalar
    var seen = near.x; // t never goes back, not even in an inverted cell
    var visits = 0u;
    var exit = NO_FACE;
    loop {
        let word = cell * CELL_WORDS;
        let d = corner(cells[word] ^ a.id ^ b.id ^ c.id, shear);
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
        let next = cells[word + 1u + rank];
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
        if (next & AT_BOUNDARY) != 0u {
            exit = next & ~AT_BOUNDARY;
            break;
        }
        if (*ray).depth > march.stop_depth || seen >= line.end {
            break;
        }
        cell = next;
    }
    return Exit(exit, visits);
}

// Instead of a face: the ray ended inside the mesh.
const NO_FACE: u32 = 0xffffffffu;

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
    if SCALARS_PER_CELL {
        front = scalars[cell];
        back = front;
    } else {
        if begin > near.x {
            front = mix(near.y, far.y, (begin - near.x) / (far.x - near.x));
        }
        if end < far.x {
            back = mix(near.y, far.y, saturate((end - near.x) / (far.x - near.x)));
        }
    }
    let shows = max(front, back) < TRANSPARENT_SCALAR;
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

// From here on a mapped scalar stands for one that is not a number.
const TRANSPARENT_SCALAR: f32 = 1e34;

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

// Adds a piece as `integrate` does, from the interval that the ray is in: where
// it stays there nothing is read.
fn gather_exactly(ray: ptr<function, Gathered>, piece: Piece) {
    let front = piece.front;
    let back = piece.back;
    let length = piece.length;
    // The outer intervals reach beyond every scalar, so neither loop leaves the array.
    while front > (*ray).interval.high {
        enter(ray, (*ray).index + 1u);
    }
    while front < (*ray).interval.low {
        enter(ray, (*ray).index - 1u);
    }
    let whole = abs(back - front);
    var scalar = front;
    loop {
        let here = (*ray).interval;
        let end_scalar = clamp(back, here.low, here.high);
        var start = sample_interval(here, scalar);
        var end = sample_interval(here, end_scalar);
        // Each piece is as long as its share of the scalars; a constant one is whole.
        var share = length;
        if whole > 0.0 {
            share = length * (abs(end_scalar - scalar) / whole);
        } else if scalar == here.low || scalar == here.high {
            // Constant, and on a step: both sides count half.
            let beyond = select((*ray).index - 1u, (*ray).index + 1u, scalar == here.high);
            start = 0.5 * (start + sample_interval(interval(beyond), scalar));
            end = start;
        }
        // A piece without length adds nothing, in MAXIMUM_INTENSITY neither.
        if share > 0.0 {
            var sum = vec4f((*ray).light, (*ray).depth);
            if CUED {
                var at = vec2f(0.0, 1.0);
                if whole > 0.0 {
                    at = abs(vec2f(scalar, end_scalar) - front) / whole;
                }
                sum = add_cued_piece(sum, start, end, share, mix(piece.cue.xx, piece.cue.yy, at));
            } else {
                sum = add_piece(sum, start, end, share);
            }
            (*ray).light = sum.xyz;
            (*ray).depth = sum.w;
        }
        if back >= here.low && back <= here.high {
            break;
        }
        enter(ray, select((*ray).index - 1u, (*ray).index + 1u, back > here.high));
        scalar = end_scalar;
    }
}

fn enter(ray: ptr<function, Gathered>, index: u32) {
    (*ray).index = index;
    (*ray).interval = interval(index);
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
    let anchor = (march.anchor + f32(pixel.x) * march.anchor_x + f32(pixel.y) * march.anchor_y).xyz;
    var direction = march.eye.xyz;
    var eye_t = march.eye_depth;
    if march.eye.w == 1.0 {
        let from_eye = anchor - march.eye.xyz;
        let distance = length(from_eye);
        direction = from_eye / distance;
        eye_t = -distance;
    }
    let shear = shear_of(anchor, direction);
    let left = clip_ray(anchor, direction);
    let cue = vec2f(dot(look.cue.xyz, anchor) + look.cue.w, dot(look.cue.xyz, direction));
    let line = Line(direction, max(eye_t, left.x), left.y, cue);
    var ray = nothing_gathered();
    let tile = pixel.y / TILE * march.tiles_x + pixel.x / TILE;
    let traced = trace(tile, shear, line, &ray);
    atomicAdd(&tile_paths, traced.paths);
    atomicAdd(&tile_unpaired, traced.crossings % 2u);
    atomicAdd(&tile_lost, traced.lost);
    textureStore(image, pixel, over(ray, march.background));
    if MODEL == ISOSURFACES {
        // World units from where the ray starts.
        let depth = select((ray.surface_t - eye_t) * march.scale, NO_SURFACE, ray.surface_t == FAR_AWAY);
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
fn trace(tile: u32, shear: Shear, line: Line, ray: ptr<function, Gathered>) -> Traced {
    var found = search(tile, shear, 0.0, 0u, true);
    var traced = Traced(found.total, 0u, 0u, 0u);
    // The ends of the latest paths: the boundary is crossed there too, but from inside.
    var exits = array<u32, 4>(NO_FACE, NO_FACE, NO_FACE, NO_FACE);
    var next = 0u;
    while next < found.kept {
        let t = found.t[next];
        let face = found.face[next];
        next += 1u;
        if t >= line.end {
            break;
        }
        let is_exit = any(vec4u(exits[0], exits[1], exits[2], exits[3]) == vec4u(face));
        if !is_exit {
            let before = *ray;
            let turn = i32(boundary_crossing(face, shear).y);
            let path = follow(face, turn, shear, line, ray);
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
                exits[traced.paths % 4u] = path.face;
                traced.paths += 1u;
            }
        }
        if next == found.kept && found.total > found.kept {
            found = search(tile, shear, t, face, false);
            next = 0u;
        }
    }
    return traced;
}
