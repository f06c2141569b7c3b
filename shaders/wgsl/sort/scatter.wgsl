// Radix sort, pass 3: move each pair of a block to its place.
//
// A thread owns consecutive pairs and moves them in order, so pairs with equal
// digits keep theirs.
// In:   keys_in, values_in; table, first positions.
// Out:  keys_out, values_out.
// With: sort/digits.wgsl

// Positions in the block, two digits to a word: digit d in the low half and d + 8
// in the high one, [d][thread]. A block has 4096 pairs, so halves do not overflow.
const HALF: u32 = DIGITS / 2u;
const WORDS: u32 = HALF * THREADS;
var<workgroup> positions: array<u32, WORDS>;
var<workgroup> sums: array<u32, THREADS>;
// What to add to a position in the block to get one in the output.
var<workgroup> offsets: array<u32, DIGITS>;

fn word_of(digit: u32, thread: u32) -> u32 {
    return (digit % HALF) * THREADS + thread;
}

fn half_of(digit: u32) -> u32 {
    return 16u * (digit / HALF);
}

@compute @workgroup_size(THREADS)
fn cs_scatter(@builtin(local_invocation_index) thread: u32, @builtin(workgroup_id) block: vec3u) {
    let start = min(block.x * BLOCK + thread * ITEMS, round.count);
    let end = min(start + ITEMS, round.count);
    // Workgroup memory starts as zeros.
    for (var i = start; i < end; i++) {
        let digit = digit_of(keys_in[i]);
        positions[word_of(digit, thread)] += 1u << half_of(digit);
    }
    workgroupBarrier();

    // Sums of all that comes before, in the order of the words.
    let share = WORDS / THREADS;
    var sum = 0u;
    for (var i = 0u; i < share; i++) {
        sum += positions[thread * share + i];
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
    // The high halves come after all of the low ones.
    let low_total = sums[THREADS - 1u] & 0xffffu;
    var position = sums[thread] - sum + (low_total << 16u);
    for (var i = 0u; i < share; i++) {
        let count = positions[thread * share + i];
        positions[thread * share + i] = position;
        position += count;
    }
    workgroupBarrier();
    if thread < DIGITS {
        let first = (positions[word_of(thread, 0u)] >> half_of(thread)) & 0xffffu;
        offsets[thread] = table[thread * round.blocks + block.x] - first;
    }
    workgroupBarrier();

    for (var i = start; i < end; i++) {
        let key = keys_in[i];
        let digit = digit_of(key);
        let word = word_of(digit, thread);
        let place = offsets[digit] + ((positions[word] >> half_of(digit)) & 0xffffu);
        positions[word] += 1u << half_of(digit);
        keys_out[place] = key;
        values_out[place] = values_in[i];
    }
}
