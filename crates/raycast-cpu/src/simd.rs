//! Vectors of numbers: which instructions, and what `fearless_simd` has no word for.

use fearless_simd::prelude::*;

/// The most lanes of any instruction set: what is kept a lane has room for so many.
pub(crate) const MOST_LANES: usize = 16;

/// One number a lane, where vectors are taken apart.
pub(crate) type PerLane<T> = [T; MOST_LANES];

/// Runs `$call` with `$simd` for the widest vectors that `$level` has.
///
/// Four of x86's sets would be compiled; the one between SSE2 and AVX2 has nothing that is used
/// here.
macro_rules! widest {
    ($level:expr, $simd:ident => $call:expr) => {{
        let level: fearless_simd::Level = $level;
        #[cfg(target_arch = "x86_64")]
        let result = if let Some($simd) = level.as_avx512() {
            fearless_simd::Simd::vectorize($simd, #[inline(always)] || $call)
        } else if let Some($simd) = level.as_avx2() {
            fearless_simd::Simd::vectorize($simd, #[inline(always)] || $call)
        } else if let Some($simd) = level.as_sse2() {
            fearless_simd::Simd::vectorize($simd, #[inline(always)] || $call)
        } else {
            unreachable!("every x86-64 has SSE2")
        };
        #[cfg(not(target_arch = "x86_64"))]
        let result = fearless_simd::dispatch!(level, $simd => $call);
        result
    }};
}
pub(crate) use widest;

/// An array of what `$body` is for each of some values. A closure in its place would not be compiled
/// for the instructions around it.
macro_rules! each {
    ([$($value:expr),+ $(,)?], $name:pat => $body:expr) => {
        [$({
            let $name = $value;
            $body
        }),+]
    };
}
pub(crate) use each;

/// The vector of the first lanes of `values`.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, values: &PerLane<f32>) -> S::f32s {
    S::f32s::from_slice(simd, &values[..S::f32s::LEN])
}

/// The same of whole numbers.
#[inline(always)]
pub(crate) fn load_ids<S: Simd>(simd: S, values: &PerLane<i32>) -> S::i32s {
    S::i32s::from_slice(simd, &values[..S::i32s::LEN])
}

/// Takes a vector apart.
#[inline(always)]
pub(crate) fn store<S: Simd>(vector: S::f32s, values: &mut PerLane<f32>) {
    vector.store_slice(&mut values[..S::f32s::LEN]);
}

/// The same of whole numbers.
#[inline(always)]
pub(crate) fn store_ids<S: Simd>(vector: S::i32s, values: &mut PerLane<i32>) {
    vector.store_slice(&mut values[..S::i32s::LEN]);
}

/// Four vectors of the columns of rows of four.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, rows: &PerLane<[f32; 4]>) -> [S::f32s; 4] {
    let lanes = S::f32s::LEN;
    let flat = rows.as_flattened();
    let parts =
        each!([0, 1, 2, 3], i => S::f32s::from_slice(simd, &flat[i * lanes..(i + 1) * lanes]));
    let (xz_low, yw_low) = parts[0].deinterleave(parts[1]);
    let (xz_high, yw_high) = parts[2].deinterleave(parts[3]);
    let (x, z) = xz_low.deinterleave(xz_high);
    let (y, w) = yw_low.deinterleave(yw_high);
    [x, y, z, w]
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;

    use super::*;

    #[test]
    fn rows_become_columns_in_the_order_of_lanes() {
        let rows: PerLane<[f32; 4]> =
            std::array::from_fn(|i| [0, 100, 200, 300].map(|column| (column + i) as f32));
        for level in [Level::new(), Level::baseline()] {
            let found = widest!(level, simd => {
                let mut found = [[-1.0; MOST_LANES]; 4];
                let vectors = columns(simd, &rows);
                for (values, vector) in found.iter_mut().zip(vectors) {
                    values[..vector.as_slice().len()].copy_from_slice(vector.as_slice());
                }
                found
            });
            for (column, values) in found.iter().enumerate() {
                for (lane, &value) in values.iter().enumerate().filter(|(_, v)| **v >= 0.0) {
                    assert_eq!(value, (100 * column + lane) as f32, "{level:?}");
                }
            }
        }
    }
}
