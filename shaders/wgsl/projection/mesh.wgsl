// Mesh: the cells, as the passes after transform.wgsl see them.
//
// With: projection/vertices.wgsl

@group(1) @binding(0) var transformed: texture_2d<f32>;         // camera space and scalar
@group(1) @binding(1) var<storage, read> scalars: array<f32>;   // of each cell, for cell data
@group(1) @binding(2) var<storage, read> cells: array<vec4u>;   // vertices, positively oriented
@group(1) @binding(3) var<storage, read> drawn: array<u32>;     // which items, in drawing order
// An item is a cell or, where `PIECES`, one of these: a cell and what of it, see
// pieces.wgsl. Without pieces there is one, of no cell.
@group(1) @binding(4) var<storage, read> pieces: array<vec2u>;

override PIECES: bool = false;

// The cell of an item, and the piece.
fn cell_of(item: u32) -> vec2u {
    if PIECES {
        return pieces[item];
    }
    return vec2u(item, 0u);
}

// Whether the mesh has cell data.
override SCALARS_PER_CELL: bool = false;

fn vertex(i: u32) -> vec4f {
    return textureLoad(transformed, texel_of(i), 0);
}
