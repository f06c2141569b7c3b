// Tetrahedra in floats: the two faces of a cell at a pixel, and the voxels between them.
//
// Places are as fine as depths, so that no vertex moves noticeably; from there on all is in 32-bit
// floats, evaluated for each pixel and voxel. Which pixels a face covers, and where it lies there, is
// computed from the same numbers in the same order by both of its cells: columns have no gaps.
// With: common/turns.wgsl, common/sides.wgsl, columns/crossing.wgsl, voxel_hw/work.wgsl,
//       voxel_hw/put.wgsl

// Passes of loops for a column beside those for its voxels: six ties of `sides`, and tests.
const COLUMN_PASSES: u32 = 10u;

// The first voxel's scalar is that of the front face; or interpolated at its center.
override ROUNDED: bool = false;

// A cell with its corners in the order of their places.
struct Cell {
    a: vec4i, b: vec4i, c: vec4i, d: vec4i,   // moved, and scalars
    flipped: bool,                            // whether that order is left-handed
    low: vec2i,
    size: vec2u,
    depth: u32,
}

fn is_behind(a: vec4i, b: vec4i) -> bool {
    let of_rest = a.y > b.y || (a.y == b.y && a.z > b.z);
    return a.x > b.x || (a.x == b.x && of_rest);
}

fn cell_of(index: u32) -> Cell {
    let ids = textureLoad(cells, texel_of(index), 0);
    var p = array(vertex_of(ids.x), vertex_of(ids.y), vertex_of(ids.z), vertex_of(ids.w));
    if CELL_DATA {
        let scalar = cell_scalars[index];
        p[0].w = scalar;
        p[1].w = scalar;
        p[2].w = scalar;
        p[3].w = scalar;
    }
    let swap01 = is_behind(p[0], p[1]);
    p = array(pick(p[0], p[1], swap01), pick(p[1], p[0], swap01), p[2], p[3]);
    let swap23 = is_behind(p[2], p[3]);
    p = array(p[0], p[1], pick(p[2], p[3], swap23), pick(p[3], p[2], swap23));
    let swap02 = is_behind(p[0], p[2]);
    p = array(pick(p[0], p[2], swap02), p[1], pick(p[2], p[0], swap02), p[3]);
    let swap13 = is_behind(p[1], p[3]);
    p = array(p[0], pick(p[1], p[3], swap13), p[2], pick(p[3], p[1], swap13));
    let swap12 = is_behind(p[1], p[2]);
    p = array(p[0], pick(p[1], p[2], swap12), pick(p[2], p[1], swap12), p[3]);
    let is_odd = ((swap01 != swap23) != (swap02 != swap13)) != swap12;

    let is_missing = any(vec4i(p[0].w, p[1].w, p[2].w, p[3].w) == vec4i(NO_VALUE));
    let least = min(min(p[0].xyz, p[1].xyz), min(p[2].xyz, p[3].xyz));
    let greatest = max(max(p[0].xyz, p[1].xyz), max(p[2].xyz, p[3].xyz));
    // With voxels that a face before them may count as through: see `crossing_at`.
    let extent = greatest - least;
    let before = 1 + (max(extent.x, max(extent.y, extent.z)) >> 20u);
    let found = box_of(least - vec3i(0, 0, min(before, least.z - NO_VALUE)), greatest);
    // One that rounding turns inside out is filled as well, so its volume does not matter.
    let is_there = judged(is_missing, found.is_near, vec2u(1u, 0u), false);
    let size = select(vec3u(0u), found.size, is_there);
    let offset = vec4i(work.offset, 0);
    let flipped = (work.flipped == 1u) != is_odd;
    return Cell(
        p[0] + offset, p[1] + offset, p[2] + offset, p[3] + offset,
        flipped, found.low.xy, size.xy, size.z,
    );
}

fn pick(a: vec4i, b: vec4i, second: bool) -> vec4i {
    return select(a, b, second);
}

struct Meeting {
    inside: bool,
    place: vec2i,
    // The corners, from the column, in voxels.
    q0: vec2f, q1: vec2f, q2: vec2f, q3: vec2f,
    begins: vec4<bool>,   // opposite to which corner the front face is
    ends: vec4<bool>,     // and the back face
}

// A pixel, counted from the first that the cell may cover.
fn meet(cell: Cell, pixel: vec2u) -> Meeting {
    let place = cell.low + vec2i(pixel);
    let center = center_of(place);
    let q0 = on_grid(in_voxels(cell.a.xy - center));
    let q1 = on_grid(in_voxels(cell.b.xy - center));
    let q2 = on_grid(in_voxels(cell.c.xy - center));
    let q3 = on_grid(in_voxels(cell.d.xy - center));
    let t = turns(sides(q0, q1, q2, q3));
    // `turns` is for cameras, whose right, up and forward are left-handed.
    return Meeting(
        any(t.enters),
        place,
        q0, q1, q2, q3,
        select(t.leaves, t.enters, cell.flipped),
        select(t.enters, t.leaves, cell.flipped),
    );
}

fn in_voxels(parts: vec2i) -> vec2f {
    return vec2f(parts) * exp2(-f32(PLACE_BITS));
}

fn fill_column(cell: Cell, m: Meeting) {
    let one = face_of(cell, m, m.begins);
    let other = face_of(cell, m, m.ends);
    // Floats may swap the faces where they meet.
    var front = one;
    var back = other;
    if other.first < one.first {
        front = other;
        back = one;
    }
    let first = max(i32(front.first), work.first);
    let end = min(i32(back.first), work.end);
    let depth = (back.base - front.base) + (back.height - front.height);
    let rise = back.scalar - front.scalar;
    for (var voxel = first; voxel < end; voxel++) {
        let center = f32(voxel);
        let past = select((center - front.base) - front.height, center - front.first, ROUNDED);
        let share = select(0.0, saturate(past / depth), depth > 0.0);
        let scalar = saturate(front.scalar + share * rise);
        put(vec3i(m.place, voxel), u32(round(scalar * f32(1u << VALUE_BITS))));
    }
}

// The face opposite to the corner that is `opposite`.
fn face_of(cell: Cell, m: Meeting, opposite: vec4<bool>) -> Crossing {
    let second = opposite.x | opposite.y;
    let a = select(cell.a, cell.b, opposite.x);
    let b = select(cell.b, cell.c, second);
    let c = select(cell.d, cell.c, opposite.w);
    // Heights are from the center of a voxel near the first corner.
    let base = first_voxel(a.xyz).z;
    let zero = center_of(vec2i(base, 0)).x;
    return crossing_at(
        f32(base),
        corner_of(select(m.q0, m.q1, opposite.x), a, zero),
        corner_of(select(m.q1, m.q2, second), b, zero),
        corner_of(select(m.q3, m.q2, opposite.w), c, zero),
    );
}

fn corner_of(q: vec2f, corner: vec4i, zero: i32) -> vec4f {
    let height = in_voxels(vec2i(corner.z - zero, 0)).x;
    return vec4f(q, height, f32(corner.w) * exp2(-f32(SCALAR_BITS)));
}
