// March: follow each ray from cell to cell to its end, in one dispatch or in several.
//
// Bernardon et al. 2004 take one step a pass and peel the boundary layer by
// layer; here a ray's loop is a loop, and it finds where it meets the boundary among
// the boundary faces of its tile, or reads that from layers.
//
// No loop runs for as long as a ray takes: devices stop what does not end, and llvmpipe ends all
// loops of 8 neighbors together after 65 535 passes, in silence. So a ray goes on in batches
// of rounds, whose passes `Budget` of budget.rs adds up, and what is not done is saved.
// In:   vertices, cells, boundary, and for each tile the boundary faces that its rays may meet,
//       or layers of those that each ray crosses.
// Out:  one texel per ray. EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color; Isosurfaces: color and 1.
// With: common/ends.wgsl, raycast_peel/rays.wgsl, raycast_peel/crossings.wgsl, raycast_peel/gather.wgsl,
//       raycast_peel/follow.wgsl and what they need

struct Counters {
    cell_visits_low: atomic<u32>,
    cell_visits_high: atomic<u32>,
    paths: atomic<u32>,
    unpaired_faces: atomic<u32>, // rays that cross the boundary an odd number of times
    lost_rays: atomic<u32>,      // rays that came out through a face that they do not cross
    rays_left: atomic<u32>,      // rays that are not done
}

// No uniform: for a large program whose control flow depends on one, lavapipe (Mesa 22.3) compiles
// another for each dispatch. That took 13 of 15 ms of a frame of 64x64 in which nothing shows.
@group(0) @binding(0) var<storage, read> march: March;
@group(0) @binding(1) var image: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var<storage, read_write> counters: Counters;
// Of isosurfaces: from where rays start, normalized units.
@group(0) @binding(4) var distances: texture_storage_2d<r32float, write>;
@group(0) @binding(8) var ends: texture_2d<f32>; // of rays (common/ends.wgsl)

// What differs between the dispatches of a frame.
struct Progress {
    // Work groups of the next dispatch: as many as of this one, or none.
    columns: atomic<u32>,
    rows: atomic<u32>,
    slices: atomic<u32>,
    rays_left: atomic<u32>, // rays that are not done
    goes_on: u32,   // 1 if rays are in `states` already
    is_last: u32,   // 1 if no dispatch follows
    first_row: u32, // of pixels
}

@group(3) @binding(0) var<storage, read_write> progress: Progress;
// Of each ray of a dispatch, row by row of whole tiles; one that nobody uses if not `RESUMES`.
@group(3) @binding(1) var<storage, read_write> states: array<State>;

// Whether what a dispatch does not finish is saved.
override RESUMES: bool = false;

// The bounds of one dispatch; `Budget` of budget.rs says why. A round takes at most one
// path, or a part of one; a batch is a search and eight rounds, as each takes at most one of
// the eight crossings that a search keeps but for the ends of paths.
const ROUNDS: u32 = 8u;
// Entries of a list that the first batch's search looks at, and cells in each of its rounds.
override FIRST_ENTRIES: u32 = 16384u;
override FIRST_CELLS: u32 = 999u;
// The same of later batches; without `TREES` each looks at a whole list.
override ENTRIES: u32 = 128u;
override CELLS: u32 = 16u;
// What a later batch takes beside its search, and what all of them may take.
override BATCH: u32 = 434u;
override LATER: u32 = 18000u;

// What a ray does next.
const AT_BOUNDARY_FACE: u32 = 0u; // the next crossing
const IN_MESH: u32 = 1u;
const DONE: u32 = 2u;

// A ray between two rounds, and what it did in this dispatch.
struct Trace {
    phase: u32,
    ray: Gathered,
    before: vec4f, // what it had gathered before its path: light and depth
    path: Path,
    found: Crossings,
    crossings: u32,  // taken of those
    taken_t: f32,    // the last of them
    taken_face: u32,
    // The ends of the latest paths: the boundary is crossed there too, but from inside.
    exits: vec4u,
    visits: u32, // of cells
    paths: u32,  // through the mesh
    lost: u32,   // 1 if it came out through a face that it does not cross
}

fn new_trace(list: u32) -> Trace {
    let none = Corner(0u, vec2f(0.0), 0.0, 0.0);
    let piece = Piece(0.0, 0.0, 0.0, 0.0, vec2f(0.0));
    let path = Path(none, none, none, 1, 0u, 0u, vec2f(0.0), 0.0, 0u, piece, no_rest());
    return Trace(
        AT_BOUNDARY_FACE,
        nothing_gathered(),
        vec4f(0.0),
        path,
        no_crossings(list),
        0u,
        -FAR_AWAY,
        0u,
        vec4u(NO_FACE),
        0u,
        0u,
        0u,
    );
}

const TILE: u32 = 8u;

var<workgroup> tile_visits: atomic<u32>;
var<workgroup> tile_paths: atomic<u32>;
var<workgroup> tile_unpaired: atomic<u32>;
var<workgroup> tile_lost: atomic<u32>;
var<workgroup> tile_left: atomic<u32>;

@compute @workgroup_size(TILE, TILE)
fn cs_cast(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) lane: u32,
    @builtin(num_workgroups) groups: vec3u,
) {
    let pixel = vec2u(id.x, id.y + progress.first_row);
    var visits = 0u;
    if pixel.x < march.width && pixel.y < march.height {
        visits = cast_ray(pixel, id.y * march.tiles_x * TILE + id.x);
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
        let left = atomicLoad(&tile_left);
        if left > 0u {
            if progress.is_last == 1u {
                atomicAdd(&counters.rays_left, left);
            }
            atomicAdd(&progress.rays_left, left);
            atomicMax(&progress.columns, groups.x);
            atomicMax(&progress.rows, groups.y);
            atomicMax(&progress.slices, groups.z);
        }
    }
}

// Casts the ray of one pixel as far as a dispatch goes, writes its texel and returns how
// many cells it passed.
fn cast_ray(pixel: vec2u, place: u32) -> u32 {
    let pixel_ray = ray_of(pixel);
    let shear = shear_of(pixel_ray.anchor, pixel_ray.direction);
    let left = clip_ray(pixel_ray.anchor, pixel_ray.direction);
    let cue_y = dot(look.cue.xyz, pixel_ray.direction) * shear.depth;
    let cue = vec2f(dot(look.cue.xyz, pixel_ray.anchor) + look.cue.w - cue_y * shear.anchor, cue_y);
    var end = left.y;
    if ENDS {
        end = min(end, end_of_ray(vec2i(pixel)) / dot(pixel_ray.direction, march.forward.xyz));
    }
    let begin = max(pixel_ray.eye_t, left.x);
    let line = Line(pixel_ray.direction, z_of(begin, shear), z_of(end, shear), cue);
    let tile = pixel.y / TILE * march.tiles_x + pixel.x / TILE;
    var t = new_trace(tile_faces[tile]);
    if RESUMES {
        if progress.goes_on == 1u {
            t = restored(states[place], shear);
            if t.phase == DONE {
                return 0u;
            }
        }
    }
    trace(&t, pixel, tile, shear, line);
    if t.phase == DONE {
        atomicAdd(&tile_paths, t.paths);
        // A ray that did not look at all of its crossings cannot tell.
        if t.found.is_over && !t.found.is_cut {
            atomicAdd(&tile_unpaired, (t.crossings + t.found.kept) % 2u);
        }
    } else {
        atomicAdd(&tile_paths, t.paths);
        atomicAdd(&tile_left, 1u);
    }
    atomicAdd(&tile_lost, t.lost);
    if RESUMES {
        states[place] = state_of(t);
    }
    textureStore(image, pixel, gathered(t.ray));
    if MODEL == ISOSURFACES {
        let met = t.ray.surface_t;
        let distance = select(met - pixel_ray.eye_t, NO_SURFACE, met == FAR_AWAY);
        textureStore(distances, pixel, vec4f(distance, 0.0, 0.0, 0.0));
    }
    return t.visits;
}

// Follows a ray along its paths, in order, as far as a dispatch goes.
fn trace(t: ptr<function, Trace>, pixel: vec2u, tile: u32, shear: Shear, line: Line) {
    let end = tile_faces[tile + 1u];
    let list = tile_faces[tile];
    let slope = dot(line.direction, march.forward.xyz);
    var peeled = 0u;
    if LAYERED {
        peeled = peeled_faces(pixel);
    }
    let is_peeled = LAYERED && peeled < march.listed_from;
    // Alike for all rays of a tile, whatever they do: so they add up.
    let later_entries = select(end - list, ENTRIES, TREES);
    let batches = 1u + select(LATER / (BATCH + later_entries), 0u, !TREES && later_entries > FIRST_ENTRIES);
    for (var batch = 0u; batch < batches; batch += 1u) {
        if is_peeled {
            (*t).found.kept = peeled - (*t).crossings;
            (*t).found.is_over = true;
        } else {
            // Crossings for all rounds of this batch, a search at the same time for all rays.
            if (*t).found.is_over && (*t).found.is_cut && (*t).found.kept < KEPT {
                (*t).found = no_crossings(list);
            }
            if !(*t).found.is_over {
                let entries = select(later_entries, FIRST_ENTRIES, batch == 0u);
                var found = (*t).found;
                search(&found, end, shear, slope, (*t).taken_t, (*t).taken_face, entries);
                (*t).found = found;
            }
        }
        for (var round = 0u; round < ROUNDS; round += 1u) {
            if (*t).phase == AT_BOUNDARY_FACE {
                if !(*t).found.is_over {
                    break;
                }
                if (*t).found.kept == 0u {
                    (*t).phase = select(DONE, AT_BOUNDARY_FACE, (*t).found.is_cut);
                    break;
                }
                take(t, pixel, is_peeled);
                if any((*t).exits == vec4u((*t).taken_face)) && (*t).found.kept > 0u {
                    take(t, pixel, is_peeled);
                }
                if any((*t).exits == vec4u((*t).taken_face)) {
                    continue;
                }
                let crossed = boundary_crossing((*t).taken_face, shear);
                (*t).taken_t = crossed.x;
                // Two programs may have decided about one ray in two ways.
                (*t).lost |= u32(crossed.y == 0.0);
                if crossed.y == 0.0 || crossed.x >= t_of(line.end, shear) {
                    (*t).phase = DONE;
                    break;
                }
                (*t).before = sum_of((*t).ray);
                go_back(t);
                (*t).path = path_from((*t).taken_face, i32(crossed.y), shear);
                (*t).phase = IN_MESH;
            }
            let cells = select(CELLS, FIRST_CELLS, batch == 0u);
            var path = (*t).path;
            var ray = (*t).ray;
            let ended = follow(&path, shear, line, &ray, cells);
            (*t).path = path;
            (*t).ray = ray;
            if ended == STOPPED {
                (*t).visits += (*t).path.visits;
                (*t).paths += 1u;
                (*t).phase = DONE;
                break;
            }
            if ended == LEFT {
                let face = (*t).path.next & ~AT_BOUNDARY;
                let way_out = boundary_crossing(face, shear);
                // What walk.wgsl says cannot be.
                (*t).lost |= u32(way_out.y == 0.0);
                if comes_before(way_out.x, face, (*t).taken_t, (*t).taken_face) {
                    // The path was followed from its other end, which the four above forgot.
                    go_back(t);
                } else {
                    (*t).visits += (*t).path.visits;
                    (*t).exits = vec4u(face, (*t).exits.xyz);
                    (*t).paths += 1u;
                }
                (*t).phase = AT_BOUNDARY_FACE;
            }
        }
        if (*t).phase == DONE {
            break;
        }
    }
}

// What was gathered is what it was before the path.
fn go_back(t: ptr<function, Trace>) {
    (*t).ray.depth = 0.0;
    // The greatest is no sum.
    if MODEL == MAXIMUM_INTENSITY {
        (*t).ray.light = (*t).before.xyz;
    } else {
        (*t).ray.aside = (*t).before;
        (*t).ray.light = vec3f(0.0);
    }
}

// Takes the first of the crossings that are kept.
fn take(t: ptr<function, Trace>, pixel: vec2u, is_peeled: bool) {
    (*t).taken_t = (*t).found.t.x;
    (*t).taken_face = (*t).found.face.x;
    if is_peeled {
        (*t).taken_face = peeled_face(pixel, (*t).crossings);
    }
    (*t).crossings += 1u;
    (*t).found = behind_first((*t).found);
}
