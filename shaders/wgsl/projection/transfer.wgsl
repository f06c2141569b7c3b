// Transfer: the transfer function's intervals and its table, as
// common/transfer_function.wgsl and preintegration/lookup.wgsl ask.

@group(1) @binding(4) var<storage, read> intervals: array<Interval>;
// One texel where `TABLE_AXES` is 0.
@group(1) @binding(5) var table: texture_3d<f32>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}
