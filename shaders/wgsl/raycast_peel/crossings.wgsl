// Crossings: the boundary faces that a ray crosses, eight at a time, in order.
//
// A tile lists the boundary faces that its rays may meet. A search looks at all of them; or, in
// a tree of depths (`TREES`), at those that may be among the next eight crossings, so
// that a ray with n crossings looks at each face a few times and not n / 8 times.
// With: raycast_peel/rays.wgsl, raycast_peel/boundary.wgsl

// For each tile where its list begins, and where the last ends; then the lists: faces, or
// entries of trees.
@group(0) @binding(3) var<storage, read> tile_faces: array<u32>;
// The boundary faces that each ray crosses, in order, from peel.wgsl; NO_FACE behind the last.
@group(0) @binding(7) var layers: texture_2d_array<u32>;

// Whether lists are trees (`Trees` of tiles.rs): in preorder, four words an entry.
// The nearest and the farthest depth of what is below it, which entry is behind all that,
// and its face, NO_FACE in an inner entry.
override TREES: bool = false;

// How many crossings a search keeps.
const KEPT: u32 = 8u;

// The crossings after one, by increasing (t, face).
//
// In vectors, as software rasterizers are slow at arrays with an index.
struct Crossings {
    t: vec4f,
    face: vec4u,
    more_t: vec4f,
    more_face: vec4u,
    kept: u32,
    total: u32,   // how many were found, kept or not
    at: u32,      // where the search goes on in the list
    is_over: bool,
    is_cut: bool, // more may be behind those kept
}

fn no_crossings(list: u32) -> Crossings {
    let none = vec4f(FAR_AWAY);
    return Crossings(none, vec4u(NO_FACE), none, vec4u(NO_FACE), 0u, 0u, list, false, false);
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

// Looks for the crossings after (t, face) among `most` entries of a list that ends at `end`.
// `slope` is depth along the view per t.
fn search(
    found: ptr<function, Crossings>,
    end: u32,
    shear: Shear,
    slope: f32,
    after_t: f32,
    after_face: u32,
    most: u32,
) {
    for (var n = 0u; n < most && (*found).at < end; n += 1u) {
        var next = (*found).at + 1u;
        var face = tile_faces[(*found).at];
        var is_near = true;
        if TREES {
            let entry = (*found).at;
            let is_past = bitcast<f32>(tile_faces[entry + 1u]) < after_t * slope;
            let is_behind = bitcast<f32>(face) > (*found).more_t.w * slope;
            (*found).is_cut |= is_behind;
            face = tile_faces[entry + 3u];
            is_near = !(is_past || is_behind);
            next = select(tile_faces[entry + 2u], entry + 4u, is_near);
            is_near &= face != NO_FACE;
        }
        (*found).at = next;
        let crossed = boundary_crossing(select(0u, face, is_near), shear);
        let counts = is_near && crossed.y != 0.0 && comes_before(after_t, after_face, crossed.x, face);
        // What does not count comes after all, and changes nothing.
        insert(found, select(FAR_AWAY, crossed.x, counts), select(NO_FACE, face, counts));
        (*found).total += u32(counts);
    }
    (*found).is_over = (*found).at >= end;
    (*found).kept = min((*found).total, KEPT);
    (*found).is_cut |= (*found).total > KEPT;
}

fn insert(found: ptr<function, Crossings>, t: f32, face: u32) {
    let before = earlier(t, face, (*found).t, (*found).face);
    let last_t = (*found).t.w;
    let last_face = (*found).face.w;
    (*found).t = inserted_t(t, (*found).t, before);
    (*found).face = inserted_face(face, (*found).face, before);
    // What was pushed out goes to the second half.
    let next_t = select(t, last_t, before.w);
    let next_face = select(face, last_face, before.w);
    let before_more = earlier(next_t, next_face, (*found).more_t, (*found).more_face);
    (*found).more_t = inserted_t(next_t, (*found).more_t, before_more);
    (*found).more_face = inserted_face(next_face, (*found).more_face, before_more);
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
fn behind_first(found: Crossings) -> Crossings {
    return Crossings(
        vec4f(found.t.yzw, found.more_t.x),
        vec4u(found.face.yzw, found.more_face.x),
        vec4f(found.more_t.yzw, FAR_AWAY),
        vec4u(found.more_face.yzw, NO_FACE),
        found.kept - 1u,
        found.total,
        found.at,
        found.is_over,
        found.is_cut,
    );
}
