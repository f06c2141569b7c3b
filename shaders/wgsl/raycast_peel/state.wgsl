// State: a ray between two dispatches.
//
// What a program computes in the same way again, such as corners, is left out.
// With: raycast_peel/march.wgsl and what it needs

struct State {
    gathered: vec4f, // light and optical depth
    aside: vec4f,
    before: vec4f,
    near: vec4f,     // z and scalar, `seen`, t of the surface
    ids: vec4u,      // of the face's corners, and the cell
    path: vec4u,     // phase; turn, `is_left` and `on_step`; next cell; visits
    piece: vec4f,    // front, back, begin, length
    rest: vec4f,     // cue, scalar; unused
    before_step: vec4f,
    crossed: vec4u,  // crossings, t and face of the last; interval
    exits: vec4u,
    t: vec4f,
    face: vec4u,
    more_t: vec4f,
    more_face: vec4u,
    search: vec4u,   // kept, total, at, `is_over` and `is_cut`
}

fn state_of(t: Trace) -> State {
    let p = t.path;
    let found = t.found;
    let marks = u32(p.turn > 0) | u32(p.rest.is_left) << 1u | u32(p.rest.on_step) << 2u;
    return State(
        vec4f(t.ray.light, t.ray.depth),
        t.ray.aside,
        t.before,
        vec4f(p.near, p.seen, t.ray.surface_t),
        vec4u(p.a.id, p.b.id, p.c.id, p.cell),
        vec4u(t.phase, marks, p.next, p.visits),
        vec4f(p.piece.front, p.piece.back, p.piece.begin, p.piece.length),
        vec4f(p.piece.cue, p.rest.scalar, 0.0),
        p.rest.before_step,
        vec4u(t.crossings, bitcast<u32>(t.taken_t), t.taken_face, t.ray.index),
        t.exits,
        found.t,
        found.face,
        found.more_t,
        found.more_face,
        vec4u(found.kept, found.total, found.at, u32(found.is_over) | u32(found.is_cut) << 1u),
    );
}

fn restored(s: State, shear: Shear) -> Trace {
    let marks = s.path.y;
    let rest = Rest((marks & 2u) != 0u, s.rest.z, (marks & 4u) != 0u, s.before_step);
    let piece = Piece(s.piece.x, s.piece.y, s.piece.z, s.piece.w, s.rest.xy);
    let path = Path(
        corner(s.ids.x, shear),
        corner(s.ids.y, shear),
        corner(s.ids.z, shear),
        select(-1, 1, (marks & 1u) != 0u),
        s.ids.w,
        s.path.z,
        s.near.xy,
        s.near.z,
        s.path.w,
        piece,
        rest,
    );
    let index = s.crossed.w;
    let ray = Gathered(s.gathered.xyz, s.gathered.w, s.aside, s.near.w, index, interval(index));
    let found = Crossings(
        s.t,
        s.face,
        s.more_t,
        s.more_face,
        s.search.x,
        s.search.y,
        s.search.z,
        (s.search.w & 1u) != 0u,
        (s.search.w & 2u) != 0u,
    );
    let taken_t = bitcast<f32>(s.crossed.y);
    return Trace(s.path.x, ray, s.before, path, found, s.crossed.x, taken_t, s.crossed.z, s.exits, 0u, 0u, 0u);
}
