// Polyhedra: the outermost faces of a cell at a pixel, whatever cell it is.
//
// Each cell has vertices and triangles of its own. Of a convex one a pixel meets one front face and
// one back face; of others the two buffers keep the outermost, as their z-tests do.
// With: voxel_hw/wide.wgsl, voxel_hw/work.wgsl, voxel_hw/face.wgsl, voxel_hw/column.wgsl

// Passes of loops for a column beside those for its voxels: triangles, and tests.
const COLUMN_PASSES: u32 = 26u;

// The corners of triangles, in the lower three.
@group(0) @binding(3) var triangles: texture_2d<u32>;

struct Cell {
    low: vec2i,
    size: vec2u,
    depth: u32,
    first: u32,         // triangle
    count: u32,
    inside_out: bool,   // whether triangles are clockwise from outside
}

struct Triangle {
    a: vec4i, b: vec4i, c: vec4i,
}

fn triangle_of(index: u32) -> Triangle {
    let ids = textureLoad(triangles, texel_of(index), 0);
    return Triangle(vertex_of(ids.x), vertex_of(ids.y), vertex_of(ids.z));
}

fn cell_of(index: u32) -> Cell {
    // First triangle, how many, and the sign of the cell's volume.
    let cell = textureLoad(cells, texel_of(index), 0);
    let origin = triangle_of(cell.x).a.xyz;
    var least = origin;
    var greatest = origin;
    var volume = vec2u(0u);
    var is_missing = false;
    for (var n = 0u; n < cell.y; n++) {
        let t = triangle_of(cell.x + n);
        least = min(least, min(t.a.xyz, min(t.b.xyz, t.c.xyz)));
        greatest = max(greatest, max(t.a.xyz, max(t.b.xyz, t.c.xyz)));
        volume = wide_sum(volume, six_volumes(t.a.xyz - origin, t.b.xyz - origin, t.c.xyz - origin));
        is_missing = is_missing || t.a.w == NO_VALUE || t.b.w == NO_VALUE || t.c.w == NO_VALUE;
    }
    let found = box_of(least, greatest);
    let orientation = bitcast<i32>(cell.z);
    volume = select(volume, vec2u(0u), orientation == 0);
    let is_there = judged(is_missing, found.is_near, volume, orientation < 0);
    let size = select(vec3u(0u), found.size, is_there);
    return Cell(found.low.xy, size.xy, size.z, cell.x, cell.y, orientation < 0);
}

struct Meeting {
    inside: bool,
    place: vec2i,
    front: Fragment,
    back: Fragment,
}

// A pixel, counted from the first that the cell may cover.
fn meet(cell: Cell, pixel: vec2u) -> Meeting {
    let place = cell.low + vec2i(pixel);
    let center = vec4i(center_of(place), 0, 0) - vec4i(work.offset, 0);
    var front = Fragment(0, 0, 0);
    var back = front;
    var has_front = false;
    var has_back = false;
    for (var n = 0u; n < cell.count; n++) {
        let t = triangle_of(cell.first + n);
        let a = t.a - center;
        let b = t.b - center;
        let c = t.c - center;
        let turns = side(a.xy, b.xy);
        if turns == 0 || side(b.xy, c.xy) != turns || side(c.xy, a.xy) != turns {
            continue;
        }
        let found = fragment_of(a, b, c);
        // One looks along +z, and sees front faces clockwise.
        if (turns < 0) != cell.inside_out {
            front = pick(front, found, !has_front || is_less(found, front));
            has_front = true;
        } else {
            back = pick(back, found, !has_back || is_less(back, found));
            has_back = true;
        }
    }
    return Meeting(has_front && has_back, place, front, back);
}

fn is_less(a: Fragment, b: Fragment) -> bool {
    let of_depth = a.depth < b.depth || (a.depth == b.depth && a.scalar < b.scalar);
    return a.voxel < b.voxel || (a.voxel == b.voxel && of_depth);
}

fn fill_column(cell: Cell, m: Meeting) {
    fill_between(m.place, m.front, m.back);
}
