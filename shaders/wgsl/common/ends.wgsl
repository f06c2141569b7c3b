// Ends: where rays meet what an application has drawn.
//
// Needs: `ends: texture_2d<f32>`, as gather/ends.wgsl writes it; one texel that nobody reads
// without `ENDS`.

// Whether rays end there.
override ENDS: bool = false;

// How deep a pixel's ray goes, in camera space.
fn end_of_ray(pixel: vec2i) -> f32 {
    if ENDS {
        return textureLoad(ends, pixel, 0).x;
    }
    return 1e30;
}
