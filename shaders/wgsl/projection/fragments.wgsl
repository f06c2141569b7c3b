// Fragments: a list for each pixel of a tile of the image.
//
// L. Carpenter, "The A-buffer", 1984; as linked lists, J. Yang et al., "Real-Time
// Concurrent Linked List Construction on the GPU", 2010.

struct Tile {
    origin: vec2u,  // pixels
    width: u32,     // pixels
    capacity: u32,  // fragments
}

// Scalars, so that no byte is padding.
struct Fragment {
    red: f32,
    green: f32,
    blue: f32,
    optical_depth: f32,
    depth: f32, // of the entry
    next: u32,  // number of a fragment, from 1; 0 ends the list
}

@group(2) @binding(0) var<uniform> tile: Tile;
// How many fragments there are, then the first of each pixel.
@group(2) @binding(1) var<storage, read_write> heads: array<atomic<u32>>;
@group(2) @binding(2) var<storage, read_write> fragments: array<Fragment>;

// The pixel's place in `heads`.
fn head_of(position: vec4f) -> u32 {
    let at = vec2u(position.xy) - tile.origin;
    return 1u + at.y * tile.width + at.x;
}
