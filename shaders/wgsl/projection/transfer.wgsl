// Transfer: the transfer function's intervals and its table, as
// common/transfer_function.wgsl and preintegration/lookup.wgsl ask.
//
// Intervals are in a texture, three texels each, as software rasterizers read those
// faster than buffers.

@group(0) @binding(1) var<uniform> look: Look;
@group(1) @binding(5) var intervals: texture_2d<f32>;
// The first and the last interval of the transfer function that each cell's scalars are
// in, 16 bits each.
@group(1) @binding(6) var<storage, read> ranges: array<u32>;
// One texel where `TABLE_AXES` is 0.
@group(1) @binding(7) var table: texture_3d<f32>;

// Intervals a row of the texture, `volume::INTERVALS_PER_ROW`.
const INTERVALS_PER_ROW: u32 = 256u;

fn interval(i: u32) -> KnotPair {
    let at = vec2u(3u * (i % INTERVALS_PER_ROW), i / INTERVALS_PER_ROW);
    let range = textureLoad(intervals, at + vec2u(2u, 0u), 0);
    return KnotPair(
        textureLoad(intervals, at, 0),
        textureLoad(intervals, at + vec2u(1u, 0u), 0),
        range.x,
        range.y,
        range.z,
    );
}

fn interval_count() -> u32 {
    return look.interval_count;
}

fn table_span() -> vec4f {
    return look.table_span;
}
