// Fill: integrate along each ray in a cell and keep the result in the pixel's list.
//
// In:   Varying, cells in any order.
// Out:  heads, fragments.
// With: projection/fragments.wgsl, projection/chord.wgsl and what it needs,
//       projection/transfer.wgsl, projection/segment.wgsl and what it needs

@fragment
fn fs_fill(in: Varying) {
    let chord = chord_of(in);
    if chord.length <= 0.0 {
        return;
    }
    let sum = segment_within(in, chord);
    let number = 1u + atomicAdd(&heads[0], 1u);
    // The tile was chosen so that all fit; if not, the count tells.
    if number > tile.capacity {
        return;
    }
    // Each begins as a run for itself.
    let run = atomicExchange(&heads[head_of(in.position)], number);
    let depth = segment_depth(sum);
    fragments[number - 1u] = Fragment(sum.x, sum.y, sum.z, depth, chord.depth, 0u, run);
}
