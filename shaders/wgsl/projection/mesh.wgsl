// Mesh: the cells, as the passes after transform.wgsl see them.
//
// With: projection/vertices.wgsl

@group(1) @binding(0) var transformed: texture_2d<f32>;         // camera space and scalar
@group(1) @binding(1) var<storage, read> scalars: array<f32>;   // of each cell, for cell data
@group(1) @binding(2) var<storage, read> cells: array<vec4u>;   // vertices, positively oriented
@group(1) @binding(3) var<storage, read> drawn: array<u32>;     // which cells, in drawing order

// Whether the mesh has cell data.
override SCALARS_PER_CELL: bool = false;

fn vertex(i: u32) -> vec4f {
    return textureLoad(transformed, texel_of(i), 0);
}
