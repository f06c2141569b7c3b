use tetrascope_core::Grid;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Samples;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::read_back;
use tetrascope_testing as testing;

use super::*;
use crate::boxes::places;
use crate::octree::Octree;

fn grid(dims: [usize; 3], value: impl Fn(usize) -> f32) -> Grid {
    let samples = Samples::F32((0..dims.iter().product()).map(value).collect());
    let grid = Grid::new(dims, DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
    grid.expect("valid")
}

/// Numbers that look random, of both signs and many magnitudes.
fn noise(i: usize) -> f32 {
    let mixed = (i as u32 ^ 0x5bd1)
        .wrapping_mul(0x85eb_ca6b)
        .rotate_left(11);
    ((mixed % 2001) as f32 - 1000.0) * (1 << (mixed >> 28)) as f32
}

/// The ranges that the device finds.
fn found(gpu: &Gpu, grid: &DeviceGrid, boxes: &Boxes, reach: usize) -> Vec<[f32; 2]> {
    let ranges = DeviceRanges::new(gpu, grid, boxes, reach).expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    ranges.record(&mut encoder);
    let source = Source::Buffer(&ranges.buffer, ranges.buffer.size());
    let copy = read_back(gpu, &mut encoder, source);
    gpu.finish(encoder).expect("submitted");
    copy.and_then(|copy| copy.read()).expect("read")
}

/// Compares every box of every level; `grid` is what counts, in NaN and numbers.
fn compare(gpu: &Gpu, on_device: &DeviceGrid, grid: &Grid, context: &str) {
    for reach in 0..=2 {
        let octree = Octree::build(grid, reach).expect("it is in memory");
        let boxes = octree.boxes;
        let found = found(gpu, on_device, &boxes, reach);
        let mut checked = 0;
        for level in 0..=boxes.deepest() {
            for place in places(boxes.divisions(level)) {
                let index = first_range(&boxes, level) + boxes.index(level, place);
                let (truth, range) = (octree.range(level, place), found[index]);
                let both_empty = truth[0] > truth[1] && range[0] > range[1];
                assert!(
                    truth == range || both_empty,
                    "{context}, reach {reach}, level {level} {place:?}: {range:?} not {truth:?}"
                );
                checked += 1;
            }
        }
        assert_eq!(checked, found.len());
    }
}

// The least and greatest of numbers are some of them, so nothing is rounded.
#[test]
fn the_device_finds_the_ranges_that_the_cpu_finds() {
    let Some(gpu) = testing::gpu("the_device_finds_the_ranges_that_the_cpu_finds") else {
        return;
    };
    // None is a multiple of a box; one box alone; one axis much longer; boxes outside.
    for dims in [
        [71, 20, 33],
        [2, 2, 2],
        [5, 3, 130],
        [64, 65, 66],
        [17, 47, 9],
    ] {
        let grid = grid(dims, noise);
        let on_device = DeviceGrid::upload(&gpu, &grid).expect("it fits");
        assert_eq!(on_device.texels(), Texels::Values);
        compare(&gpu, &on_device, &grid, &format!("{dims:?}"));
    }
}

#[test]
fn gaps_and_what_is_not_covered_have_no_range() {
    let Some(gpu) = testing::gpu("gaps_and_what_is_not_covered_have_no_range") else {
        return;
    };
    let dims = [40, 37, 33];
    // A corner without any number, and single ones elsewhere.
    let is_gap = |i: usize| {
        let [x, y, z] = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
        (x < 20 && y < 19 && z < 20) || i % 7 == 3
    };
    let gaps = grid(dims, |i| if is_gap(i) { f32::NAN } else { noise(i) });
    let on_device = DeviceGrid::upload(&gpu, &gaps).expect("it fits");
    assert_eq!(on_device.texels(), Texels::Gaps);
    compare(&gpu, &on_device, &gaps, "gaps");
    // The same with what is there beyond the rest, and not covered.
    let beyond = grid(dims, |i| if is_gap(i) { 1e30 } else { noise(i) });
    let coverage = (0..dims.iter().product()).map(|i| match is_gap(i) {
        true => 0.0,
        false => 1e-3 + (i % 5) as f32 / 8.0,
    });
    let covered = beyond.covered(coverage.collect()).expect("shares");
    let on_device = DeviceGrid::upload(&gpu, &covered).expect("it fits");
    assert_eq!(on_device.texels(), Texels::Covered);
    compare(&gpu, &on_device, &gaps, "coverage");
}
