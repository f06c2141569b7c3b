// Radix sort, pass 1: count the digits of a block.
//
// In:   keys_in.
// Out:  table, counts.
// With: sort/digits.wgsl

var<workgroup> counts: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(THREADS)
fn cs_count(@builtin(local_invocation_index) thread: u32, @builtin(workgroup_id) block: vec3u) {
    let start = block.x * BLOCK;
    for (var i = thread; i < BLOCK; i += THREADS) {
        if start + i < round.count {
            atomicAdd(&counts[digit_of(keys_in[start + i])], 1u);
        }
    }
    workgroupBarrier();
    if thread < DIGITS {
        table[thread * round.blocks + block.x] = atomicLoad(&counts[thread]);
    }
}
