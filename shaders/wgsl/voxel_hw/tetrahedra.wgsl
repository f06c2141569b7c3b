// Tetrahedra: the two faces of a cell at a pixel.
//
// A cell has one front face and one back face wherever it is met, so the two buffers are two numbers.
// With: common/turns.wgsl, voxel_hw/wide.wgsl, voxel_hw/work.wgsl, voxel_hw/face.wgsl,
//       voxel_hw/column.wgsl

// Passes of loops for a column beside those for its voxels: tests.
const COLUMN_PASSES: u32 = 4u;

struct Cell {
    a: vec4i, b: vec4i, c: vec4i, d: vec4i,   // places, moved, and scalars
    low: vec2i,
    size: vec2u,
    depth: u32,
}

fn cell_of(index: u32) -> Cell {
    let ids = textureLoad(cells, texel_of(index), 0);
    var a = vertex_of(ids.x);
    var b = vertex_of(ids.y);
    var c = vertex_of(ids.z);
    var d = vertex_of(ids.w);
    if CELL_DATA {
        let scalar = cell_scalars[index];
        a.w = scalar;
        b.w = scalar;
        c.w = scalar;
        d.w = scalar;
    }
    let is_missing = a.w == NO_VALUE || b.w == NO_VALUE || c.w == NO_VALUE || d.w == NO_VALUE;
    let found = box_of(
        min(min(a.xyz, b.xyz), min(c.xyz, d.xyz)),
        max(max(a.xyz, b.xyz), max(c.xyz, d.xyz)),
    );
    let volume = six_volumes(b.xyz - a.xyz, c.xyz - a.xyz, d.xyz - a.xyz);
    let is_there = judged(is_missing, found.is_near, volume, work.flipped == 1u);
    let size = select(vec3u(0u), found.size, is_there);
    let offset = vec4i(work.offset, 0);
    return Cell(a + offset, b + offset, c + offset, d + offset, found.low.xy, size.xy, size.z);
}

struct Meeting {
    inside: bool,
    place: vec2i,
    center: vec4i,
    begins: vec4<bool>,   // opposite to which corner the front face is
    ends: vec4<bool>,     // and the back face
}

// A pixel, counted from the first that the cell may cover.
fn meet(cell: Cell, pixel: vec2u) -> Meeting {
    let place = cell.low + vec2i(pixel);
    let center = center_of(place);
    let a = cell.a.xy - center;
    let b = cell.b.xy - center;
    let c = cell.c.xy - center;
    let d = cell.d.xy - center;
    let t = turns(Sides(
        vec3i(side(a, b), side(a, c), side(a, d)) > vec3i(0),
        vec3i(side(b, c), side(b, d), side(c, d)) > vec3i(0),
    ));
    let flipped = work.flipped == 1u;
    // `turns` is for cameras, whose right, up and forward are left-handed.
    return Meeting(
        any(t.enters),
        place,
        vec4i(center, 0, 0),
        select(t.leaves, t.enters, flipped),
        select(t.enters, t.leaves, flipped),
    );
}

fn fill_column(cell: Cell, m: Meeting) {
    fill_between(m.place, face_of(cell, m, m.begins), face_of(cell, m, m.ends));
}

// The face opposite to the corner that is `opposite`.
fn face_of(cell: Cell, m: Meeting, opposite: vec4<bool>) -> Fragment {
    return fragment_of(
        select(cell.a, cell.b, opposite.x) - m.center,
        select(cell.b, cell.c, opposite.x | opposite.y) - m.center,
        select(cell.d, cell.c, opposite.w) - m.center,
    );
}
