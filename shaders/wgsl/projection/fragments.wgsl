// Fragments: a list for each pixel of a tile of the image.
//
// L. Carpenter, "The A-buffer", 1984; as linked lists, J. Yang et al., "Real-Time
// Concurrent Linked List Construction on the GPU", 2010.

struct Tile {
    origin: vec2u,  // pixels
    width: u32,     // pixels
    capacity: u32,  // fragments
    turn: u32,      // of composite.wgsl, and how many turns there are
    turns: u32,
}

// Scalars, so that no byte is padding.
struct Fragment {
    red: f32,
    green: f32,
    blue: f32,
    optical_depth: f32,
    depth: f32, // of the entry
    next: u32,  // the next of the same run: a number from 1, or 0 at its end
    run: u32,   // of a run's first, the first of the next run, or 0
}

@group(2) @binding(0) var<uniform> tile: Tile;
// How many fragments there are, in how many pixels composite.wgsl was not done after its
// last turn, then the first fragment of each pixel.
@group(2) @binding(1) var<storage, read_write> heads: array<atomic<u32>>;
@group(2) @binding(2) var<storage, read_write> fragments: array<Fragment>;

const FIRST_HEAD: u32 = 2u;

// The pixel's place in `heads`.
fn head_of(position: vec4f) -> u32 {
    let at = vec2u(position.xy) - tile.origin;
    return FIRST_HEAD + at.y * tile.width + at.x;
}
