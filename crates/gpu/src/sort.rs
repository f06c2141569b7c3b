//! Sorts pairs of a 32-bit key and a 32-bit value on the device.
//!
//! A stable radix sort, least significant digit first, 4 bits a round; each round
//! counts, scans and scatters. No workgroup waits for another and no subgroup size is
//! assumed, so it runs on software adapters and on those that schedule as they like,
//! unlike single-pass sorts ("OneSweep", Adinets and Merrill 2022).
//!
//! D. Merrill, A. Grimshaw, "Revisiting Sorting for GPGPU Stream Architectures", 2010.

use tetrascope_core::Error;
use tetrascope_shaders::sort::{COUNT, SCAN, SCATTER};
use wgpu::BufferUsages;

use crate::Gpu;
use crate::passes::{READ, UNIFORM, WRITE};
use crate::pipelines::ComputeProgram;

/// Pairs that one workgroup moves; `BLOCK` in the shaders.
const BLOCK: u32 = 4096;
/// The most blocks: 4096 passes of each loop of `scan.wgsl`, see
/// [`tetrascope_shaders::loops`].
const MOST_BLOCKS: u32 = 1 << 16;
/// Bits a round.
const DIGIT_BITS: u32 = 4;

/// The mirror of the shaders' `Round`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Round {
    count: u32,
    shift: u32,
    blocks: u32,
}

/// The pipelines of the sort.
#[derive(Clone, Debug)]
pub struct RadixSort {
    layout: wgpu::BindGroupLayout,
    count: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    scatter: wgpu::ComputePipeline,
}

/// Buffers for a number of pairs, filled and sorted as often as one likes.
#[derive(Debug)]
pub struct SortedPairs {
    sort: RadixSort,
    keys: wgpu::Buffer,
    values: wgpu::Buffer,
    rounds: Vec<wgpu::BindGroup>,
    blocks: u32,
    bytes: u64,
}

impl RadixSort {
    /// Compiles the sort.
    pub fn new(gpu: &Gpu) -> Result<RadixSort, Error> {
        let types = [UNIFORM, READ, READ, WRITE, WRITE, WRITE];
        let layout = gpu.layout("gpu::sort", wgpu::ShaderStages::COMPUTE, &types)?;
        let pipeline = |label, source| {
            gpu.compute_pipeline(&ComputeProgram {
                label,
                source,
                groups: vec![layout.clone()],
                ..Default::default()
            })
        };
        Ok(RadixSort {
            count: pipeline("gpu::sort count", COUNT)?,
            scan: pipeline("gpu::sort scan", SCAN)?,
            scatter: pipeline("gpu::sort scatter", SCATTER)?,
            layout,
        })
    }

    /// Buffers for `count` pairs of which the low `key_bits` bits of the keys differ.
    ///
    /// [`Error::TooLarge`] if the device does not hold them or cannot start that
    /// many workgroups.
    pub fn pairs(&self, gpu: &Gpu, count: u32, key_bits: u32) -> Result<SortedPairs, Error> {
        let blocks = count.div_ceil(BLOCK);
        let limits = gpu.limits();
        let most = limits.max_compute_workgroups_per_dimension.min(MOST_BLOCKS);
        if blocks > most {
            return Err(Error::TooLarge {
                what: "the sort".into(),
                needed: count.into(),
                limit: u64::from(most) * u64::from(BLOCK),
                unit: "pairs",
            });
        }
        let bytes = 4 * u64::from(count.max(1));
        let table_bytes = 4 * 16 * u64::from(blocks.max(1));
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = |label: &str| gpu.buffer(label, bytes, usage);
        let keys = [buffer("gpu::sort keys")?, buffer("gpu::sort other keys")?];
        let values = [
            buffer("gpu::sort values")?,
            buffer("gpu::sort other values")?,
        ];
        let table = gpu.buffer("gpu::sort table", table_bytes, BufferUsages::STORAGE)?;
        // An even number of rounds ends in the buffers in which it began.
        let round_count = key_bits
            .clamp(1, 32)
            .div_ceil(DIGIT_BITS)
            .next_multiple_of(2);
        let mut rounds = Vec::new();
        for round in 0..round_count {
            let uniform = Round {
                count,
                // A round beyond the key's last bit sees zeros and moves nothing.
                shift: (round * DIGIT_BITS).min(31),
                blocks,
            };
            let uniform = gpu.upload("gpu::sort round", &[uniform], BufferUsages::UNIFORM)?;
            let (from, to) = ((round % 2) as usize, ((round + 1) % 2) as usize);
            let buffers = [
                &uniform,
                &keys[from],
                &values[from],
                &keys[to],
                &values[to],
                &table,
            ];
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            rounds.push(gpu.checked("gpu::sort", 0, || {
                gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("gpu::sort round"),
                    layout: &self.layout,
                    entries: &entries,
                })
            })?);
        }
        let [keys, _] = keys;
        let [values, _] = values;
        Ok(SortedPairs {
            sort: self.clone(),
            keys,
            values,
            rounds,
            blocks,
            bytes: 4 * bytes + table_bytes,
        })
    }
}

impl SortedPairs {
    /// The keys: written before, sorted after. Array of u32 in a storage buffer.
    pub fn keys(&self) -> &wgpu::Buffer {
        &self.keys
    }

    /// The values: written before, in the order of their keys after.
    pub fn values(&self) -> &wgpu::Buffer {
        &self.values
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Records the sort, by increasing key; pairs with equal keys keep their order.
    pub fn record(&self, pass: &mut wgpu::ComputePass) {
        if self.blocks == 0 {
            return;
        }
        for round in &self.rounds {
            pass.set_bind_group(0, round, &[]);
            pass.set_pipeline(&self.sort.count);
            pass.dispatch_workgroups(self.blocks, 1, 1);
            pass.set_pipeline(&self.sort.scan);
            pass.dispatch_workgroups(1, 1, 1);
            pass.set_pipeline(&self.sort.scatter);
            pass.dispatch_workgroups(self.blocks, 1, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::{Source, read_back};
    use crate::testing;

    /// A full-period generator of 32-bit numbers (Numerical Recipes' constants).
    fn random(seed: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(seed), |x| {
            Some(x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223))
        })
        // The low bits of such a generator are poor.
        .map(|x| x.rotate_left(16) ^ x)
    }

    fn sorted_on_device(gpu: &Gpu, keys: &[u32], bits: u32) -> Vec<(u32, u32)> {
        let count = keys.len() as u32;
        let sort = RadixSort::new(gpu).expect("the shaders are valid");
        let pairs = sort.pairs(gpu, count, bits).expect("the pairs fit");
        let values: Vec<u32> = (0..count).collect();
        gpu.write("keys", pairs.keys(), keys).expect("they fit");
        gpu.write("values", pairs.values(), &values)
            .expect("they fit");
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        pairs.record(&mut encoder.begin_compute_pass(&Default::default()));
        let bytes = 4 * u64::from(count);
        let mut copy = |buffer| read_back(gpu, &mut encoder, Source::Buffer(buffer, bytes));
        let keys = copy(pairs.keys()).expect("a copy");
        let values = copy(pairs.values()).expect("a copy");
        gpu.finish(encoder).expect("nothing can fail");
        let keys: Vec<u32> = keys.read().expect("readable");
        keys.into_iter()
            .zip(values.read::<u32>().expect("readable"))
            .collect()
    }

    fn sorted_on_cpu(keys: &[u32]) -> Vec<(u32, u32)> {
        let mut pairs: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
        pairs.sort_by_key(|pair| pair.0);
        pairs
    }

    #[test]
    fn pairs_come_out_as_from_a_stable_sort() {
        let Some(gpu) = testing::gpu("pairs_come_out_as_from_a_stable_sort") else {
            return;
        };
        // Around a thread's, a block's and several blocks' pairs.
        for count in [1, 2, 15, 17, 255, 4095, 4096, 4097, 70_001, 300_000] {
            let keys: Vec<u32> = random(count).take(count as usize).collect();
            assert_eq!(
                sorted_on_device(&gpu, &keys, 32),
                sorted_on_cpu(&keys),
                "{count} pairs"
            );
        }
    }

    #[test]
    fn equal_keys_keep_their_order() {
        let Some(gpu) = testing::gpu("equal_keys_keep_their_order") else {
            return;
        };
        let few: Vec<u32> = random(7).map(|k| k % 5).take(20_000).collect();
        assert_eq!(sorted_on_device(&gpu, &few, 3), sorted_on_cpu(&few));
        let one = vec![u32::MAX; 9000];
        assert_eq!(sorted_on_device(&gpu, &one, 32), sorted_on_cpu(&one));
    }

    #[test]
    fn bits_that_are_not_sorted_need_not_be_rounds() {
        let Some(gpu) = testing::gpu("bits_that_are_not_sorted_need_not_be_rounds") else {
            return;
        };
        for bits in [4, 12, 20, 24] {
            let keys: Vec<u32> = random(bits)
                .map(|k| k >> (32 - bits))
                .take(10_000)
                .collect();
            assert_eq!(
                sorted_on_device(&gpu, &keys, bits),
                sorted_on_cpu(&keys),
                "{bits} bits"
            );
        }
    }

    #[test]
    fn round_has_the_layout_of_its_twin() {
        tetrascope_shaders::assert_layout!(
            COUNT,
            Round {
                count,
                shift,
                blocks
            }
        );
    }
}
