// Transfer: the transfer function's intervals and its table, as
// common/transfer_function.wgsl and preintegration/lookup.wgsl ask.

@group(3) @binding(0) var<storage, read> intervals: array<KnotPair>;
// One texel where `TABLE_AXES` is 0.
@group(3) @binding(1) var table: texture_3d<f32>;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

fn table_span() -> vec4f {
    return frame.table_span;
}
