// Texels: lists in textures, as `Gpu::upload_texels` lays them out.
//
// Software rasterizers read a texel of four numbers faster than one number of a buffer.

const TEXELS_PER_ROW: u32 = 4096u;

// Where texel `i` is.
fn texel(i: u32) -> vec2u {
    return vec2u(i % TEXELS_PER_ROW, i / TEXELS_PER_ROW);
}
