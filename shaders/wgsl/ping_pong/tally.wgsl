// Tally: the rays that a layer lost. Not in the paper.
//
// In:   the layer, the state after its last pass, and which tiles were drawn in it.
// Out:  how many rays were given up, or still went on when the passes ran out.
// With: ping_pong/rays.wgsl

struct Tally {
    tiles: vec4u, // a side; the others are unused
    lost: atomic<u32>,
    drawn: array<u32, 64>, // whether each tile was, row by row
}

@group(2) @binding(0) var states: texture_2d<f32>;
@group(2) @binding(1) var colors: texture_2d<f32>;
@group(2) @binding(2) var layer: texture_2d<f32>; // only rays that came in were written
@group(2) @binding(3) var<storage, read_write> tally: Tally;

@compute @workgroup_size(8, 8)
fn cs_tally(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(states);
    if any(id.xy >= size) {
        return;
    }
    // Tile i begins at pixel ⌊i size / tiles⌋.
    let tile = ((id.xy + 1u) * tally.tiles.xx - 1u) / size;
    if tally.drawn[tile.y * tally.tiles.x + tile.x] == 0u {
        return;
    }
    let began = textureLoad(layer, vec2i(id.xy), 0).x >= 0.0;
    let state = textureLoad(states, vec2i(id.xy), 0).x;
    let opacity = textureLoad(colors, vec2i(id.xy), 0).w;
    if began && opacity < frame.stop_opacity && (state == LOST || state >= 0.0) {
        atomicAdd(&tally.lost, 1u);
    }
}
