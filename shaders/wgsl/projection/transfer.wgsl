// Transfer: the transfer function's intervals, as common/transfer_function.wgsl asks.

@group(1) @binding(4) var<storage, read> intervals: array<Interval>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}
