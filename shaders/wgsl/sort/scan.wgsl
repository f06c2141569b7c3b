// Radix sort, pass 2: where each digit of each block begins.
//
// One workgroup: the table has 16 entries for every 4096 pairs.
// In, out: table, counts replaced by the sums of all that comes before.
// With: sort/digits.wgsl

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(THREADS)
fn cs_scan(@builtin(local_invocation_index) thread: u32) {
    let size = DIGITS * round.blocks;
    let share = (size + THREADS - 1u) / THREADS;
    let start = min(thread * share, size);
    let end = min(start + share, size);
    var sum = 0u;
    for (var i = start; i < end; i++) {
        sum += table[i];
    }
    sums[thread] = sum;
    workgroupBarrier();
    for (var step = 1u; step < THREADS; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = sums[thread - step];
        }
        workgroupBarrier();
        sums[thread] += before;
        workgroupBarrier();
    }
    var position = sums[thread] - sum;
    for (var i = start; i < end; i++) {
        let count = table[i];
        table[i] = position;
        position += count;
    }
}
