//! Tests of samples drawn slice by slice, against f64 and against the twin on the CPU.

use tetrascope_core::glam::{Vec3, Vec4};

use super::*;
use crate::triangles::fan_of;

/// How far beside a cell a sample may be that is drawn with it. Rasterizers round its corners to
/// 2⁻⁸ of a pixel, and the center of the fan, by half of that along both axes; and what is outside by
/// as much as both explain counts as inside: 2⁻⁸ √2 twice. One of software rounds to 2⁻⁴.
fn beside(gpu: &Gpu) -> f64 {
    match gpu.info().name.contains("SwiftShader") {
        true => 1.0 / 4.0,
        false => 1.0 / 64.0,
    }
}

fn drawing(passes: Passes, weights: u32) -> ResamplerOptions {
    ResamplerOptions {
        passes,
        weights,
        ..ResamplerOptions::default()
    }
}

fn drawn_with(
    gpu: &Gpu,
    mesh: &TetMesh,
    lattice: &Lattice,
    options: &ResamplerOptions,
    tuning: Tuning,
) -> Resampler {
    let made = Resampler::tuned(gpu, mesh, lattice, options, tuning).expect("it fits");
    made.resample().expect("it runs");
    made
}

fn drawn(gpu: &Gpu, mesh: &TetMesh, lattice: &Lattice, options: &ResamplerOptions) -> Resampler {
    drawn_with(gpu, mesh, lattice, options, Tuning::new(gpu))
}

fn texels(made: &Resampler) -> Vec<[f32; 2]> {
    let gpu = &made.gpu;
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let copy = read_back(gpu, &mut encoder, Source::Texture(made.grid.texture()));
    gpu.finish(encoder).expect("a copy");
    copy.expect("a copy").read().expect("readable")
}

#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    inside: usize,
    outside: usize,
    /// Beside the surface by no more than [`beside`].
    between: usize,
    /// Deeper in the mesh, and not drawn.
    missed: usize,
    /// The greatest error beyond what rounded places explain, in texels of the cell's range.
    texels: f64,
    /// The mean error, as a share of the mesh's range.
    mean: f64,
}

/// Measures all samples.
fn measure(made: &Resampler, mesh: &TetMesh, found: &[Vec<Candidate>], weights: u32) -> Measured {
    let range = mesh.scalar_range().expect("values");
    let rounding = 8.0 * f64::from(f32::EPSILON) * range.0.abs().max(range.1.abs());
    let mut measured = Measured::default();
    for (found, [scalar, coverage]) in found.iter().zip(texels(made)) {
        if found.is_empty() {
            assert_eq!(coverage, 0.0);
            measured.outside += 1;
            continue;
        }
        if coverage == 0.0 {
            match found.iter().any(|c| c.depth > c.reach) {
                true => measured.missed += 1,
                false => measured.between += 1,
            }
            continue;
        }
        measured.inside += 1;
        let off = |c: &Candidate| (f64::from(scalar) - c.scalar).abs();
        let beyond = |c: &Candidate| {
            let beyond = off(c) - c.slack - rounding;
            beyond.max(0.0) * f64::from(weights) / c.range.max(1e-300)
        };
        let least =
            |f: &dyn Fn(&Candidate) -> f64| found.iter().map(f).fold(f64::INFINITY, f64::min);
        measured.texels = measured.texels.max(least(&beyond));
        measured.mean += least(&off) / (range.1 - range.0);
    }
    measured.mean /= measured.inside as f64;
    measured
}

/// A scalar is off by the difference between front and back, of which none is greater than the cell's
/// range, divided by the texture's width (see `weights.rs`).
fn is_held(measured: &Measured, what: &str) {
    eprintln!("{what}: {measured:?}");
    assert!(
        measured.inside > 1000 && measured.missed == 0,
        "{what}: {measured:?}"
    );
    assert!(measured.texels <= 1.0, "{what}: {measured:?}");
}

#[test]
fn drawn_samples_are_the_interpolant_within_a_texel() {
    let Some(gpu) = gpu("drawn_samples_are_the_interpolant_within_a_texel") else {
        return;
    };
    let meshes = [
        ("sphere", data_set("sphere", Some(3_000))),
        ("heat-sink", data_set("heat-sink", Some(3_000))),
        ("graded", graded(7, 0.3)),
        ("layers", layers(1e-3)),
        ("slivers", slivers()),
    ];
    for (name, mesh) in meshes {
        let lattice = around(&mesh, [40, 44, 36]);
        let found = candidates(&mesh, &lattice, beside(&gpu));
        let mut means = Vec::new();
        for weights in [32, 64, 128, 256, 512, 1024] {
            let one = drawn(&gpu, &mesh, &lattice, &drawing(Passes::One, weights));
            let measured = measure(&one, &mesh, &found, weights);
            is_held(&measured, &format!("{name}, {weights}"));
            means.push(measured.mean);
            // The two passes round products and their sum; one may do so once.
            let two = drawn(&gpu, &mesh, &lattice, &drawing(Passes::Two, weights));
            let range = mesh.scalar_range().expect("values");
            let rounding = 2.0 * f32::EPSILON * range.0.abs().max(range.1.abs()) as f32;
            for (one, two) in texels(&one).iter().zip(texels(&two)) {
                assert_eq!(one[1], two[1], "{name}: coverage");
                assert!(
                    (one[0] - two[0]).abs() <= rounding,
                    "{name}: {one:?} {two:?}"
                );
            }
        }
        // Halved with each texture, but for what rounded places leave.
        eprintln!("{name}: {:.1}", means[0] / means[3]);
        assert!(means[0] / means[3] > 6.0, "{name}: {means:?}");
    }
}

#[test]
fn drawn_lattices_may_be_turned_mirrored_and_partly_outside() {
    let Some(gpu) = gpu("drawn_lattices_may_be_turned_mirrored_and_partly_outside") else {
        return;
    };
    let mesh = data_set("sphere", Some(4_000));
    let straight = around(&mesh, [40, 33, 27]);
    let mirror = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    let bounds = mesh.bounds();
    let corner = lattice(
        [30, 40, 50],
        bounds.min - 0.01 * bounds.size(),
        bounds.min + 0.13 * bounds.size(),
    );
    let lattices = [
        turned(straight, rotation()),
        turned(straight, mirror),
        turned(straight, rotation() * mirror),
        corner,
    ];
    for (i, lattice) in lattices.iter().enumerate() {
        let made = drawn(&gpu, &mesh, lattice, &drawing(Passes::Two, 256));
        let found = candidates(&mesh, lattice, beside(&gpu));
        is_held(&measure(&made, &mesh, &found, 256), &format!("lattice {i}"));
    }
}

/// Faces, edges and corners on samples, and cells narrower than samples.
#[test]
fn no_sample_in_a_mesh_is_left_out() {
    let Some(gpu) = gpu("no_sample_in_a_mesh_is_left_out") else {
        return;
    };
    for (n, count) in [(6, 6), (6, 12), (4, 12), (12, 4), (21, 3), (5, 17)] {
        for direction in [DMat3::IDENTITY, rotation()] {
            let side = count as f64;
            let (points, cells) = kuhn(n, DVec3::ZERO, DVec3::splat(side), |_| true);
            let points = points.into_iter().map(|p| direction * p).collect();
            let mesh = mesh((points, cells), |p| p.x - p.y);
            let lattice = Lattice {
                dims: [count + 3, count + 4, count + 5],
                origin: direction * DVec3::splat(-1.0),
                spacing: DVec3::ONE,
                direction,
                interpolation: Interpolation::Linear,
            };
            let made = drawn(&gpu, &mesh, &lattice, &drawing(Passes::One, 256));
            for (i, [_, coverage]) in texels(&made).iter().enumerate() {
                let [x, y, _] = lattice.dims;
                let at = [i % x, i / x % y, i / (x * y)];
                let is_inner = at.iter().all(|&i| i > 1 && i < count + 1);
                let is_outer = at.iter().any(|&i| i < 1 || i > count + 1);
                assert!(
                    !is_inner || *coverage == 1.0,
                    "{n}, {count}: {at:?} is left out"
                );
                assert!(
                    !is_outer || *coverage == 0.0,
                    "{n}, {count}: {at:?} is outside"
                );
            }
        }
    }
    // A grid that ends with the mesh, as most do, but for a millionth.
    let mesh = data_set("sphere", Some(5_000));
    for dims in [[40, 33, 27], [2, 3, 100], [257, 2, 64]] {
        let lattice = Lattice::over(&mesh.bounds(), dims).expect("a box");
        let made = drawn(&gpu, &mesh, &lattice, &drawing(Passes::Two, 256));
        let outside = texels(&made).iter().filter(|t| t[1] != 1.0).count();
        let is_fine = beside(&gpu) == 1.0 / 64.0;
        assert!(
            outside == 0 || !is_fine,
            "{outside} of {dims:?} are left out"
        );
    }
    // A box, turned: all samples farther from its surface than rounding are inside.
    let mesh = data_set("sphere", Some(20_000));
    let lattice = turned(around(&mesh, [48, 48, 48]), rotation());
    let options = drawing(Passes::One, 256);
    let bounds = mesh.bounds();
    let margin = beside(&gpu) * lattice.spacing.max_element();
    let holes = [0.0, 1.0 / 256.0].map(|rounded| {
        let tuning = Tuning {
            rounded,
            ..Tuning::new(&gpu)
        };
        let made = drawn_with(&gpu, &mesh, &lattice, &options, tuning);
        let samples = texels(&made).into_iter().enumerate();
        let is_hole = |(i, [_, coverage]): (usize, [f32; 2])| {
            let place = [i % 48, i / 48 % 48, i / (48 * 48)].map(|i| i as f64);
            let p = lattice.point(place.into());
            let is_inner = (p - margin).cmpgt(bounds.min).all();
            let is_inner = is_inner && (p + margin).cmplt(bounds.max).all();
            is_inner && coverage == 0.0
        };
        samples.filter(|sample| is_hole(*sample)).count()
    });
    eprintln!("holes without and with what rounded vertices explain: {holes:?}");
    // What rounds vertices to more than `ROUNDED` may leave out one.
    let most = usize::from(beside(&gpu) > 1.0 / 64.0);
    assert!(holes[1] <= most, "{holes:?}");
}

#[test]
fn slabs_and_ways_to_add_change_nothing() {
    let Some(gpu) = gpu("slabs_and_ways_to_add_change_nothing") else {
        return;
    };
    let mesh = data_set("sphere", Some(4_000));
    let lattice = around(&mesh, [30, 35, 41]);
    for passes in [Passes::One, Passes::Two] {
        let with = |slabs: u32, adds: bool| {
            let options = ResamplerOptions {
                slabs,
                ..drawing(passes, 256)
            };
            let tuning = Tuning {
                adds,
                ..Tuning::new(&gpu)
            };
            let made = drawn_with(&gpu, &mesh, &lattice, &options, tuning);
            assert_eq!(
                made.drawn().expect("read").expect("drawn").elements.len(),
                slabs.min(41) as usize
            );
            texels(&made)
        };
        let expected = with(40, false);
        for slabs in [1, 7, 40, 41, 1000] {
            assert!(with(slabs, false) == expected, "{passes:?}, {slabs} slabs");
        }
        if Tuning::new(&gpu).adds {
            assert!(
                with(40, true) == expected,
                "{passes:?}, added by the device"
            );
        }
    }
}

/// The samples that are drawn are those that the twin says.
#[test]
fn what_is_drawn_is_counted() {
    let Some(gpu) = gpu("what_is_drawn_is_counted") else {
        return;
    };
    let meshes = [
        ("sphere", data_set("sphere", Some(5_000))),
        ("heat-sink", data_set("heat-sink", Some(3_000))),
        ("graded", graded(6, 0.3)),
    ];
    for (name, mesh) in meshes {
        let dims = [40, 30, 53];
        let lattice = around(&mesh, dims);
        for (passes, times, slabs) in [(Passes::One, 1, 40), (Passes::Two, 2, 7)] {
            let options = ResamplerOptions {
                slabs,
                ..drawing(passes, 64)
            };
            let made = drawn(&gpu, &mesh, &lattice, &options);
            let placed = Placed::new(&mesh, &lattice, 2).expect("placed");
            let start = |slab: u32| (slab * 53 / slabs) as f32;
            let mut expected = Drawn {
                elements: vec![0; slabs as usize],
                triangles: 0,
            };
            for cell in mesh.tetrahedra() {
                let corners = cell.map(|corner| placed.vertices[corner as usize]);
                let base = Vec3::from(corners[0].sample);
                let points = corners.map(|v| {
                    let place = (Vec3::from(v.sample) - base) + Vec3::from(v.offset);
                    Vec4::from((place, v.scalar))
                });
                let Some(fan) = fan_of(points) else { continue };
                let heights = corners.map(|v| f64::from(v.sample[2]) + f64::from(v.offset[2]));
                let least = heights.into_iter().fold(f64::INFINITY, f64::min).ceil() as f32;
                let greatest = heights
                    .into_iter()
                    .fold(f64::NEG_INFINITY, f64::max)
                    .floor() as f32;
                for slab in 0..slabs {
                    let (first, end) = (start(slab), start(slab + 1));
                    if least.max(first) < (greatest + 1.0).min(end) {
                        expected.elements[slab as usize] += 1;
                        let slices = (end - first) as u64;
                        expected.triangles += times * slices * u64::from(fan.triangles);
                    }
                }
            }
            let found = made.drawn().expect("read").expect("drawn");
            let each = found.triangles as f64 / mesh.cell_count() as f64;
            eprintln!("{name}, {passes:?}: {each:.1} triangles for each cell");
            assert_eq!(found, expected, "{name}, {passes:?}");
        }
    }
    let direct = ResamplerOptions::default();
    let mesh = data_set("sphere", Some(500));
    let made = drawn(&gpu, &mesh, &around(&mesh, [9; 3]), &direct);
    assert_eq!(made.drawn().expect("nothing to read"), None);
}

#[test]
fn drawn_fields_of_cells_are_constant_in_each() {
    let Some(gpu) = gpu("drawn_fields_of_cells_are_constant_in_each") else {
        return;
    };
    let mesh = with_cell_scalars();
    let lattice = around(&mesh, [37, 30, 41]);
    let found = candidates(&mesh, &lattice, beside(&gpu));
    for passes in [Passes::One, Passes::Two] {
        let made = drawn(&gpu, &mesh, &lattice, &drawing(passes, 256));
        is_held(&measure(&made, &mesh, &found, 256), "cells");
        // Both weights add up to 1, but for rounding.
        let is_whole = |t: &[f32; 2]| (t[0] - t[0].round()).abs() <= 101.0 * f32::EPSILON;
        assert!(texels(&made).iter().all(is_whole));
    }
}

#[test]
fn reloading_draws_nothing_of_the_old_mesh() {
    let Some(gpu) = gpu("reloading_draws_nothing_of_the_old_mesh") else {
        return;
    };
    let meshes = [
        data_set("sphere", Some(4_000)),
        graded(5, 0.2),
        layers(1e-3),
        data_set("sphere", Some(6_000)),
    ];
    let lattice = lattice([33, 30, 35], DVec3::splat(-1.1), DVec3::splat(1.1));
    let options = drawing(Passes::Two, 128);
    let mut made = drawn(&gpu, &meshes[0], &lattice, &options);
    let mut sizes = Vec::new();
    for round in 0..2 {
        for mesh in &meshes {
            made.reload(mesh).expect("it fits");
            made.resample().expect("it runs");
            let fresh = drawn(&gpu, mesh, &lattice, &options);
            assert!(texels(&made) == texels(&fresh), "round {round}");
            assert_eq!(made.drawn().expect("read"), fresh.drawn().expect("read"));
        }
        sizes.push(made.bytes());
    }
    assert_eq!(
        sizes[0], sizes[1],
        "sizes that were seen need no other buffers"
    );
}

#[test]
fn options_out_of_range_are_refused_in_words() {
    let Some(gpu) = gpu("options_out_of_range_are_refused_in_words") else {
        return;
    };
    let mesh = data_set("sphere", Some(500));
    let lattice = around(&mesh, [9; 3]);
    let usual = ResamplerOptions::default();
    let with = |weights, slabs| ResamplerOptions {
        weights,
        slabs,
        ..usual
    };
    let cases = [
        (with(16, 40), "from 32 to 1024"),
        (with(1026, 40), "from 32 to 1024"),
        (with(33, 40), "even"),
        (with(64, 0), "slabs"),
    ];
    for (options, words) in cases {
        let error = Resampler::new(&gpu, &mesh, &lattice, &options);
        let error = error.expect_err(words).to_string();
        assert!(error.contains(words) && !error.contains('\n'), "{error}");
    }
}
