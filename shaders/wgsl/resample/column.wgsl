// Column: the samples of one column of the grid that are in one cell.
//
// Westermann 2001 section 2 draws the cross section of a cell in one slice after another; a column
// meets all slices at once.
// Out:  `put`, once for each sample.
// With: common/sides.wgsl, resample/mesh.wgsl, one of resample/put*.wgsl

// Passes of loops for a column beside those for its samples: six ties of `sides`, and tests.
const COLUMN_PASSES: u32 = 10u;

// A cell with its corners in the order of their keys: a face computes the same bits, whichever
// cell it is seen from.
struct Cell {
    p0: vec3f, p1: vec3f, p2: vec3f, p3: vec3f,  // nearest samples
    o0: vec3f, o1: vec3f, o2: vec3f, o3: vec3f,  // offsets
    scalars: vec4f,
    flipped: bool,                               // whether that order is left-handed
    low: vec2i,                                  // its columns: the first,
    size: vec2u,                                 // and how many
    depth: u32,                                  // samples along them, at most
}

fn cell_of(index: u32) -> Cell {
    var ids = corners_of(index);
    var keys = vec4u(
        key_of(ids.x),
        key_of(ids.y),
        key_of(ids.z),
        key_of(ids.w),
    );
    // Sort by place; a swap turns the handedness.
    var odd = work.flipped == 1u;
    let swap01 = is_behind(keys.xz, keys.yw, ids.xz, ids.yw);
    keys = select(keys, keys.yxwz, swap01.xxyy);
    ids = select(ids, ids.yxwz, swap01.xxyy);
    let swap02 = is_behind(keys.xy, keys.zw, ids.xy, ids.zw);
    keys = select(keys, keys.zwxy, swap02.xyxy);
    ids = select(ids, ids.zwxy, swap02.xyxy);
    let swap12 = is_behind(keys.yy, keys.zz, ids.yy, ids.zz).x;
    ids = select(ids, ids.xzyw, vec4<bool>(swap12));
    odd = odd != (swap01.x != swap01.y);
    odd = odd != (swap02.x != swap02.y);
    odd = odd != swap12;
    let a = vertex_of(ids.x);
    let b = vertex_of(ids.y);
    let c = vertex_of(ids.z);
    let d = vertex_of(ids.w);
    // The samples between the least and the greatest corner, exactly across, and along the columns
    // with those that a face before them may count as through.
    let span = max(max(a.sample, b.sample), max(c.sample, d.sample))
        - min(min(a.sample, b.sample), min(c.sample, d.sample)) + vec3f(1.0);
    let before = vec3f(0.0, 0.0, 2.0 * SNAP * max(span.x, max(span.y, span.z)));
    let first = min(
        min(first_from(a, before), first_from(b, before)),
        min(first_from(c, before), first_from(d, before)),
    );
    let last = max(max(last_to(a), last_to(b)), max(last_to(c), last_to(d)));
    let low = max(whole(first), vec3i(work.low, work.first));
    let high = min(whole(last) + vec3i(1), vec3i(work.high, work.end));
    let scalars = scalars_of(index, vec4f(a.scalar, b.scalar, c.scalar, d.scalar));
    // No columns without a value.
    let size = select(vec3u(max(high - low, vec3i(0))), vec3u(0u), any(scalars >= vec4f(NO_VALUE)));
    return Cell(
        a.sample, b.sample, c.sample, d.sample,
        a.offset, b.offset, c.offset, d.offset,
        scalars, odd, low.xy, size.xy, size.z,
    );
}

// By key; different places may have equal keys, and then the number decides.
fn is_behind(key: vec2u, other_key: vec2u, id: vec2u, other_id: vec2u) -> vec2<bool> {
    return (key > other_key) | ((key == other_key) & (id > other_id));
}

// The first sample that is not farther before the vertex than that.
fn first_from(v: Vertex, before: vec3f) -> vec3f {
    return v.sample + select(vec3f(0.0), vec3f(1.0), v.offset > before);
}

// The last sample that is not behind it.
fn last_to(v: Vertex) -> vec3f {
    return v.sample - select(vec3f(0.0), vec3f(1.0), v.offset < vec3f(0.0));
}

// No grid has as many samples along an axis.
fn whole(sample: vec3f) -> vec3i {
    return vec3i(clamp(sample, vec3f(-1e6), vec3f(1e6)));
}

// A column as a cell meets it.
struct Meeting {
    inside: bool,
    place: vec2i,     // across
    // The corners, from the column.
    q0: vec2f, q1: vec2f, q2: vec2f, q3: vec2f,
    t: Turns,
}

// A column, counted from the first that the cell may meet.
fn meet(cell: Cell, column: vec2u) -> Meeting {
    let place = cell.low + vec2i(column);
    let center = vec2f(place);
    // A vertex's place from the column depends on nothing else.
    let q0 = on_grid((cell.p0.xy - center) + cell.o0.xy);
    let q1 = on_grid((cell.p1.xy - center) + cell.o1.xy);
    let q2 = on_grid((cell.p2.xy - center) + cell.o2.xy);
    let q3 = on_grid((cell.p3.xy - center) + cell.o3.xy);
    let t = turns(sides(q0, q1, q2, q3));
    return Meeting(any(t.enters), place, q0, q1, q2, q3, t);
}

// Writes the samples of a column that meets the cell.
//
// Faces cut the column into half-open intervals. Both cells of a face see the same bits, so that
// no sample is left out, whatever rounding does, and none is written twice unless rounding swaps
// the two faces of a cell.
fn fill_column(cell: Cell, m: Meeting) {
    // `turns` is for cameras, whose right, up and forward are left-handed.
    let begins = crossing_of(cell, m, select(m.t.leaves, m.t.enters, cell.flipped));
    let ends = crossing_of(cell, m, select(m.t.enters, m.t.leaves, cell.flipped));
    let first = i32(clamp(begins.first, f32(work.first), f32(work.end)));
    let end = i32(clamp(ends.first, f32(work.first), f32(work.end)));
    let least = min(begins.scalar, ends.scalar);
    let greatest = max(begins.scalar, ends.scalar);
    let rise = ends.scalar - begins.scalar;
    let texel = m.place.x * work.across_x + m.place.y * work.across_y;
    for (var i = first; i < end; i++) {
        let sample = f32(i);
        let before = max((sample - begins.base) - begins.height, 0.0);
        let behind = ends.height - (sample - ends.base);
        let scalar = begins.scalar + rise * (before / (before + behind));
        put(texel + i * work.along, clamp(scalar, least, greatest));
    }
}

// Where the column crosses the face opposite to the corner that is `opposite`.
fn crossing_of(cell: Cell, m: Meeting, opposite: vec4<bool>) -> Crossing {
    let second = opposite.x | opposite.y;
    let third = !opposite.w;
    let a = select(vec4f(m.q0, cell.o0.z, cell.scalars.x), vec4f(m.q1, cell.o1.z, cell.scalars.y), opposite.x);
    let b = select(vec4f(m.q1, cell.o1.z, cell.scalars.y), vec4f(m.q2, cell.o2.z, cell.scalars.z), second);
    let c = select(vec4f(m.q2, cell.o2.z, cell.scalars.z), vec4f(m.q3, cell.o3.z, cell.scalars.w), third);
    let base = select(cell.p0.z, cell.p1.z, opposite.x);
    let base_b = select(cell.p1.z, cell.p2.z, second);
    let base_c = select(cell.p2.z, cell.p3.z, third);
    return crossing_at(
        base,
        a,
        vec4f(b.xy, (base_b - base) + b.z, b.w),
        vec4f(c.xy, (base_c - base) + c.z, c.w),
    );
}
