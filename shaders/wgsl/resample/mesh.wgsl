// Mesh: the cells as resampling sees them, in the grid's own units.
//
// Columns of samples run along one axis of the grid, "along"; the two others are "across", and
// (across, along) is a right-handed frame: the axes (y, z, x), or those turned on. One unit is
// the distance of neighboring samples, and samples lie at whole numbers.

// A vertex as its nearest sample and what is left, so that differences from any sample keep a
// float's relative precision, however small the cell is.
struct Vertex {
    sample: vec3f,   // whole numbers: across, across, along
    key: u32,        // of the place: equal places have equal keys
    offset: vec3f,   // from that sample, within [-1/2, 1/2] of each axis
    scalar: f32,     // in the field's unit, or NO_VALUE
}

// What one dispatch is about. In a storage buffer: lavapipe compiles large programs anew at
// every dispatch if their loops depend on a uniform buffer.
struct Work {
    low: vec2i,        // the first column of this part of the grid
    high: vec2i,       // behind the last one
    first: i32,        // sample of a column
    end: i32,          // behind the last one
    cell_count: u32,
    small: u32,        // the most passes of one invocation for a cell
    along: vec3i,      // the step of a texel along a column
    flipped: u32,      // 1 where the axes of the grid are left-handed
    across_x: vec3i,   // and to the next column
    across_y: vec3i,
}

// Stands for no scalar.
const NO_VALUE: f32 = 0x1.fffffep127f;

@group(0) @binding(0) var<storage, read> work: Work;
// Two texels for each vertex, and one for each cell; software rasterizers read texels several
// times faster than buffers. Texel i is at (i % 4096, i / 4096).
@group(0) @binding(1) var vertices: texture_2d<u32>;
@group(0) @binding(2) var cells: texture_2d<u32>;
// One for each cell, if they have any.
@group(0) @binding(3) var<storage, read> cell_scalars: array<f32>;

// Whether cells have scalars, not vertices.
override CELL_DATA: bool = false;

fn scalars_of(cell: u32, of_vertices: vec4f) -> vec4f {
    if CELL_DATA {
        return vec4f(cell_scalars[cell]);
    }
    return of_vertices;
}

fn corners_of(cell: u32) -> vec4u {
    return textureLoad(cells, vec2u(cell & 4095u, cell >> 12u), 0);
}

fn key_of(id: u32) -> u32 {
    return textureLoad(vertices, vec2u((2u * id) & 4095u, id >> 11u), 0).w;
}

fn vertex_of(id: u32) -> Vertex {
    let at = vec2u((2u * id) & 4095u, id >> 11u);
    let near = textureLoad(vertices, at, 0);
    let rest = bitcast<vec4f>(textureLoad(vertices, at + vec2u(1u, 0u), 0));
    return Vertex(bitcast<vec3f>(near.xyz), near.w, rest.xyz, rest.w);
}
