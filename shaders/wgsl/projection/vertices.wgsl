// Vertices: where a vertex's texel is.

// Texels a row, `passes::transform::ROW`.
const VERTICES_PER_ROW: u32 = 2048u;

fn texel_of(vertex: u32) -> vec2u {
    return vec2u(vertex % VERTICES_PER_ROW, vertex / VERTICES_PER_ROW);
}
