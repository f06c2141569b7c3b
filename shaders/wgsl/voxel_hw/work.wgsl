// Work: what one dispatch voxelizes, and the cells of the mesh.
//
// Pixel (i, j) is the column of voxels (i, j, k) for all k, with its center at (i + 1/2, j + 1/2). All
// places are in parts of a voxel, and all scalars in parts of the field's range; `fixed.rs` has the
// bits and why they are enough.

// In a storage buffer: lavapipe compiles large programs anew at every dispatch if their loops depend
// on a uniform buffer.
struct Work {
    dims: vec3i,       // voxels along each axis
    cell_count: u32,
    offset: vec3i,     // by which cells move, in parts of a voxel
    first: i32,        // layer of voxels
    end: i32,          // behind the last one
    small: u32,        // the most passes of one invocation for a cell
    flipped: u32,      // 1 where the axes of the grid are left-handed
    is_first: u32,     // 1 for the first dispatch, which tells what becomes of cells
}

// Bits of a place in a voxel.
override PLACE_BITS: u32 = 8u;
const DEPTH_BITS: u32 = 19u;
const SCALAR_BITS: u32 = 24u;
const VALUE_BITS: u32 = 30u;

// Stands for no scalar.
const NO_VALUE: i32 = i32(-0x80000000);

@group(2) @binding(0) var<storage, read> work: Work;
// A texel for each vertex: its place, and its scalar for a field of points. Software rasterizers read
// texels several times faster than buffers. Texel i is at (i % 4096, i / 4096).
@group(0) @binding(0) var vertices: texture_2d<u32>;
@group(0) @binding(1) var cells: texture_2d<u32>;
// One for each cell, if they have any.
@group(0) @binding(2) var<storage, read> cell_scalars: array<i32>;

// Whether cells have scalars, not vertices.
override CELL_DATA: bool = false;

fn texel_of(index: u32) -> vec2u {
    return vec2u(index & 4095u, index >> 12u);
}

fn vertex_of(id: u32) -> vec4i {
    return bitcast<vec4i>(textureLoad(vertices, texel_of(id), 0));
}

// The center of a pixel.
fn center_of(place: vec2i) -> vec2i {
    return (place << vec2u(PLACE_BITS)) + vec2i(1 << (PLACE_BITS - 1u));
}

// The first voxel whose center is not less than `coordinate`: ⌈c − 1/2⌉.
fn first_voxel(coordinate: vec3i) -> vec3i {
    return (coordinate + vec3i((1 << (PLACE_BITS - 1u)) - 1)) >> vec3u(PLACE_BITS);
}

// The voxels between the least and the greatest corner, moved by the offset.
struct Box {
    is_near: bool,   // whether the cell can reach a voxel, for some offset
    low: vec3i,
    size: vec3u,
}

fn box_of(least: vec3i, greatest: vec3i) -> Box {
    // Before anything is added: what is far away may be at the ends of integers.
    let half = vec3i(1 << (PLACE_BITS - 1u));
    let ends = work.dims << vec3u(PLACE_BITS);
    let is_near = all(greatest >= -half) && all(least <= ends + half);
    let begin = select(vec3i(0), least, is_near) + work.offset;
    let end = select(vec3i(0), greatest, is_near) + work.offset;
    let low = max(first_voxel(begin), vec3i(0, 0, work.first));
    let high = min(first_voxel(end), vec3i(work.dims.xy, work.end));
    return Box(is_near, low, vec3u(max(high - low, vec3i(0))));
}

// Whether a cell is voxelized, and if not, why: `volume` is what is left of its volume, negative where
// it is to be so if it is `mirrored`.
fn judged(is_missing: bool, is_near: bool, volume: vec2u, mirrored: bool) -> bool {
    let is_flat = all(volume == vec2u(0u));
    let is_inverted = is_negative(volume) != mirrored;
    tally(WITHOUT_VALUE, is_missing);
    tally(OUTSIDE, !is_missing && !is_near);
    tally(DEGENERATE, !is_missing && is_near && is_flat);
    tally(INVERTED, !is_missing && is_near && !is_flat && is_inverted);
    return !is_missing && is_near && !is_flat && !is_inverted;
}
