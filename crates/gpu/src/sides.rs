//! Whether a device decides on which side of a ray an edge passes as `sides.wgsl` says.
//!
//! The decision compares two rounded products. It is right where products are rounded
//! to the nearest number, or in any one direction; WGSL promises neither. So each
//! device is asked once, and where it fails [`constant`] makes programs compare
//! integers.

use tetrascope_core::Error;
use tetrascope_core::glam::Vec2;
use tetrascope_shaders::common::SIDES;
use wgpu::BufferUsages;

use crate::Gpu;
use crate::memory::{Source, read_back};
use crate::passes::{READ, WRITE, group};
use crate::pipelines::ComputeProgram;

/// The constant of `sides.wgsl` for a device: whether it has to compare integers.
///
/// The first call asks the device, in a submission of its own.
pub fn constant(gpu: &Gpu) -> Result<(&'static str, f64), Error> {
    let integers = match gpu.integer_sides().get() {
        Some(integers) => *integers,
        None => {
            let integers = !decides_right(gpu, false)?;
            *gpu.integer_sides().get_or_init(|| integers)
        }
    };
    Ok(integer_sides(integers))
}

/// The constant of `sides.wgsl` for a given choice.
pub fn integer_sides(integers: bool) -> (&'static str, f64) {
    ("INTEGER_SIDES", f64::from(u8::from(integers)))
}

/// The sign of a.x b.y − a.y b.x for normal numbers, and what an infinitesimally moved ray
/// sees where it is 0; `side` of `sides.wgsl`. 0 only where a and b coincide.
pub fn side(a: Vec2, b: Vec2) -> i32 {
    // Exact: two mantissas of 24 bits fit in one of 53.
    let left = f64::from(a.x) * f64::from(b.y);
    let right = f64::from(a.y) * f64::from(b.x);
    let sign = |less: bool, more: bool| i32::from(more) - i32::from(less);
    match sign(left < right, left > right) {
        0 if a.y != b.y => sign(a.y < b.y, a.y > b.y),
        0 => sign(b.x < a.x, b.x > a.x),
        decided => decided,
    }
}

/// On which side all three edges of a crossed face pass, or 0; `crossing` of `sides.wgsl`.
pub fn crossing(a: Vec2, b: Vec2, c: Vec2) -> i32 {
    let turn = side(a, b);
    if turn != 0 && side(b, c) == turn && side(c, a) == turn {
        turn
    } else {
        0
    }
}

/// Whether `gpu` decides as [`side`] does, and, unless it compares integers, rounds
/// products to the nearest number, in every case of [`cases`].
fn decides_right(gpu: &Gpu, integers: bool) -> Result<bool, Error> {
    let cases = cases();
    let answers = probe(gpu, "cs_sides", integers, &cases, cases.len())?;
    Ok(cases
        .iter()
        .zip(answers)
        .all(|(&[ax, ay, bx, by], answer)| {
            let right = answer[1] as i32 == side(Vec2::new(ax, ay), Vec2::new(bx, by));
            right && (integers || answer[0] == (ax * by).to_bits())
        }))
}

/// Runs an entry point of `sides_probe.wgsl`.
fn probe(
    gpu: &Gpu,
    entry: &'static str,
    integers: bool,
    inputs: &[[f32; 4]],
    count: usize,
) -> Result<Vec<[u32; 2]>, Error> {
    let label = "gpu::sides";
    let bytes = 8 * count as u64;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let inputs = gpu.upload(label, inputs, BufferUsages::STORAGE)?;
    let answers = gpu.buffer(label, bytes, usage)?;
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let layout = gpu.layout(label, wgpu::ShaderStages::COMPUTE, &[READ, WRITE])?;
    let pipeline = gpu.compute_pipeline(&ComputeProgram {
        label,
        source: SIDES,
        entry: Some(entry),
        constants: vec![integer_sides(integers)],
        groups: vec![layout.clone()],
    })?;
    gpu.checked(label, 0, || {
        let resources = [inputs.as_entire_binding(), answers.as_entire_binding()];
        let group = group(gpu, label, &layout, &resources);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: None,
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((count as u32).div_ceil(64), 1, 1);
    })?;
    let answers = read_back(gpu, &mut encoder, Source::Buffer(&answers, bytes))?;
    gpu.finish(encoder)?;
    answers.read()
}

/// A sequence of numbers without pattern (Marsaglia 2003, xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    /// A number of magnitude 2^−`spread` to 2, of either sign.
    fn float(&mut self, spread: u32) -> f32 {
        let exponent = 127 - self.next() % (spread + 1);
        f32::from_bits(self.next() & 0x807f_ffff | exponent << 23)
    }
}

/// Pairs of points that are hard to decide about: a.x, a.y, b.x, b.y.
fn cases() -> Vec<[f32; 4]> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut cases = Vec::new();
    for case in 0..1 << 14 {
        let (ax, ay) = (random.float(8), random.float(8));
        cases.push(match case % 4 {
            0 => [ax, ay, random.float(20), random.float(20)],
            // Almost on one line with the ray: products differ in their last bits.
            1 => {
                let factor = random.float(8);
                let nudge = |x: f32, by: u32| f32::from_bits(x.to_bits().wrapping_add(by % 3));
                let (bx, by) = (ax * factor, ay * factor);
                [ax, ay, nudge(bx, random.next()), nudge(by, random.next())]
            }
            // Exact ties, and points in one place.
            2 => {
                let factor = [0.0, 1.0, -0.5, 4.0][random.next() as usize % 4];
                [ax, ay, factor * ax, factor * ay]
            }
            // Products halfway between two numbers: 13 bits times 13 bits, odd.
            _ => {
                let short = |r: u32| (r & 0xfff | 0x1001) as f32;
                let long = |r: u32| (r & 0x7ff | 0x801) as f32;
                [
                    short(random.next()),
                    long(random.next()),
                    short(random.next()),
                    short(random.next()),
                ]
            }
        });
    }
    cases
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec2;

    use super::*;
    use crate::testing;

    #[test]
    fn devices_decide_right_by_either_path() {
        let Some(gpu) = testing::gpu("devices_decide_right_by_either_path") else {
            return;
        };
        assert!(decides_right(&gpu, true).expect("runs"), "integers");
        // Every adapter seen so far rounds to nearest; one that does not is told apart.
        let floats = decides_right(&gpu, false).expect("runs");
        let constant = constant(&gpu).expect("runs");
        assert_eq!(constant, integer_sides(!floats));
        let info = gpu.info();
        if info.name.contains("llvmpipe") {
            assert!(floats, "llvmpipe rounds to nearest");
        }
    }

    /// Points on a coarse lattice, where most decisions are ties, and others.
    fn quadruples(count: usize) -> Vec<[Vec2; 4]> {
        let mut random = Random(42);
        (0..count)
            .map(|case| {
                [(); 4].map(|()| match case % 3 {
                    0 => Vec2::new(
                        (random.next() % 5) as f32 - 2.0,
                        (random.next() % 5) as f32 - 2.0,
                    ),
                    1 => Vec2::new(random.float(3), random.float(3)),
                    // Multiples of one point, off by a last place.
                    _ => {
                        let step = (random.next() % 7) as f32 - 3.5;
                        let x = 0.1 * step;
                        let y = 0.3 * step;
                        Vec2::new(x, f32::from_bits(y.to_bits() + random.next() % 2))
                    }
                })
            })
            .collect()
    }

    fn crossed([a, b, c, d]: [Vec2; 4]) -> u32 {
        let faces = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
        let crossed = faces.iter().filter(|[a, b, c]| crossing(*a, *b, *c) != 0);
        crossed.count() as u32
    }

    /// For any four points a ray crosses 0 or 2 of the four triangles between them; here
    /// points may coincide, where a triangle has two corners in one place and is crossed
    /// by no ray.
    #[test]
    fn a_ray_crosses_no_or_two_faces_of_any_cell() {
        let cells = quadruples(300_000);
        for &cell in &cells {
            let count = crossed(cell);
            assert!(count == 0 || count == 2, "{count} of {cell:?}");
        }
        let some = cells.iter().filter(|cell| crossed(**cell) == 2).count();
        assert!(some > 10_000, "{some}");
    }

    #[test]
    fn devices_cross_the_faces_that_the_cpu_crosses() {
        let Some(gpu) = testing::gpu("devices_cross_the_faces_that_the_cpu_crosses") else {
            return;
        };
        let cells = quadruples(60_000);
        let inputs: Vec<[f32; 4]> = cells
            .iter()
            .flat_map(|[a, b, c, d]| [[a.x, a.y, b.x, b.y], [c.x, c.y, d.x, d.y]])
            .collect();
        let (_, chosen) = constant(&gpu).expect("runs");
        for integers in [chosen == 1.0, true] {
            let answers = probe(&gpu, "cs_parity", integers, &inputs, cells.len());
            for (cell, counts) in cells.iter().zip(answers.expect("runs")) {
                assert_eq!(counts, [crossed(*cell); 2], "{cell:?}");
            }
        }
    }

    /// Where a ray crosses a sliver, its shares name the ray's place and no other.
    #[test]
    fn shares_of_slivers_name_the_ray() {
        let Some(gpu) = testing::gpu("shares_of_slivers_name_the_ray") else {
            return;
        };
        // Of length 1 and width 2⁻¹², in any direction, around the ray.
        let width = 2.0f64.powi(-12);
        let mut random = Random(7);
        let mut share = || f64::from(random.next()) / f64::from(u32::MAX);
        let mut slivers = Vec::new();
        while slivers.len() < 10_000 {
            let along = DVec2::from_angle(std::f64::consts::TAU * share());
            let end = |at: f64, side: f64| at * along + side * width * along.perp();
            let (middle, ray) = (share(), share());
            let corners = [
                end(-ray, -0.5 * share()),
                end(middle - ray, 0.5),
                end(1.0 - ray, -0.5 * share()),
            ];
            let corners = corners.map(DVec2::as_vec2);
            if crossing(corners[0], corners[1], corners[2]) != 0 {
                slivers.push(corners);
            }
        }
        let inputs: Vec<[f32; 4]> = slivers
            .iter()
            .flat_map(|[a, b, c]| [[a.x, a.y, b.x, b.y], [c.x, c.y, 0.0, 0.0]])
            .collect();
        let answers = probe(&gpu, "cs_shares", false, &inputs, slivers.len()).expect("runs");
        // `shares` finds how far beside the ray the first solution is with some ten
        // roundings of 2⁻²⁴, and the areas' own, at most four, cost a share e = 2⁻²² / width of
        // that twice. Without taking it back it would be e.
        let bound = 2.0f64.powi(-20) + (2.0f64.powi(-22) / width).powi(2);
        for (corners, answer) in slivers.iter().zip(answers) {
            let [b, c] = answer.map(|bits| f64::from(f32::from_bits(bits)));
            let [p, q, r] = corners.map(|corner| corner.as_dvec2());
            let beside = (1.0 - b - c) * p + b * q + c * r;
            assert!(beside.length() <= bound, "{beside} beside {corners:?}");
            assert!(b >= 0.0 && c >= 0.0 && b + c <= 1.0 + 2.0f64.powi(-22));
        }
    }
}
