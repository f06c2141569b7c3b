//! The model of the hardware: the same voxels, and nothing lost on the way.

mod common;

use common::{FIXED_AND_FLOAT, field, lattice, options};
use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_testing::{data_set, kuhn, mesh};
use tetrascope_voxel_hw::machine::{Load, MachineConfig, MachineReport, Merge, Voxelizing};
use tetrascope_voxel_hw::{Cells, Offsets, VoxelVolume, Voxelizer, VoxelizerOptions};

const DIMS: [usize; 3] = [24; 3];

fn turned() -> TetMesh {
    let turn = common::rotation(4);
    let (points, cells) = kuhn(3, DVec3::splat(-6.0), DVec3::splat(6.0), |_| true);
    let points = points.iter().map(|p| turn * *p + 12.0);
    mesh((points.collect(), cells), field)
}

fn simulate(
    options: VoxelizerOptions,
    config: &MachineConfig,
) -> (VoxelVolume, VoxelVolume, MachineReport) {
    let voxelizer = Voxelizer::new(options).expect("valid");
    let lattice = lattice(DIMS);
    let mesh = turned();
    let truth = common::voxelize(&mesh, DIMS, options);
    let (volume, report) = voxelizer.simulate(&mesh, &lattice, config).expect("voxels");
    (truth, volume, report)
}

fn machines() -> Vec<MachineConfig> {
    let mut machines = Vec::new();
    for (geometry_engines, fragment_generators) in [(6, 5), (8, 10), (12, 20), (1, 1)] {
        for voxelizing in [Voxelizing::FragmentGenerators, Voxelizing::ImageEngines] {
            for merge in [Merge::Broadcast, Merge::Readback] {
                machines.push(MachineConfig {
                    geometry_engines,
                    fragment_generators,
                    voxelizing,
                    merge,
                    ..MachineConfig::default()
                });
            }
        }
    }
    machines
}

/// The work of all units together.
fn total(load: &Load) -> u64 {
    (load.mean * load.units as f64).round() as u64
}

#[test]
fn voxels_are_those_of_the_voxelizer_and_bytes_add_up() {
    for arithmetic in FIXED_AND_FLOAT {
        for samples in [1, 2] {
            let options = VoxelizerOptions {
                offsets: Offsets::Regular(samples),
                ..options(arithmetic)
            };
            let samples = u64::from(samples.pow(3));
            for config in machines() {
                let (truth, volume, report) = simulate(options, &config);
                assert!(truth == volume, "{config:?}");
                let counts = truth.counts();
                let cells = 6 * 27;
                assert_eq!(counts.cells, cells);
                assert_eq!(report.passes, cells * samples);
                // What one engine sends the next one gets.
                assert_eq!(report.triangles, counts.faces);
                assert_eq!(report.fragments, counts.fragments);
                assert_eq!(report.pixels, counts.columns);
                assert_eq!(report.voxels, counts.writes);
                let written = truth.writes().iter().filter(|w| **w > 0).count() as u64;
                assert_eq!(report.texels, written);
                // Each is in one texture memory, and all of these have some.
                assert_eq!(total(&report.owned_texels), written);
                assert!(report.owned_texels.balance() > 0.8, "{report}");
                // Front and back face of a tetrahedron cover the same pixels.
                assert_eq!(report.fragments, 2 * report.pixels);
                assert!(report.examined >= report.pixels);

                let buses = report.buses;
                assert_eq!(buses.host, cells * samples * 4 * 16);
                assert_eq!(buses.triangles, report.triangles * 240);
                assert_eq!(buses.fragments, report.fragments * 12);
                let texel = 4 + u64::from(samples > 1);
                let accesses = 1 + u64::from(samples > 1);
                let (pixels, texture) = match config.voxelizing {
                    Voxelizing::FragmentGenerators => {
                        (report.pixels * 16, report.voxels * accesses * texel)
                    }
                    Voxelizing::ImageEngines => (written * texel, written * texel),
                };
                assert_eq!((buses.pixels, buses.texture), (pixels, texture));
                let volume_bytes = 24 * 24 * 24 * texel;
                assert_eq!(report.texture_bytes, volume_bytes);
                let (merge, merge_host) = match (config.merge, config.fragment_generators) {
                    (Merge::Broadcast, 1) => (0, 0),
                    (Merge::Broadcast, _) => (written * (texel + 4), 0),
                    (Merge::Readback, _) => (volume_bytes, 2 * volume_bytes),
                };
                assert_eq!((buses.merge, buses.merge_host), (merge, merge_host));

                // Work that is shared is all done.
                let generators = u64::from(config.fragment_generators);
                let scan = report.fragments * 4 + generators * report.triangles * 8;
                assert_eq!(total(&report.scan_conversion), scan);
                assert_eq!(total(&report.geometry), cells * samples * 4 * 600);
                let voxel = match config.voxelizing {
                    Voxelizing::FragmentGenerators => 1,
                    Voxelizing::ImageEngines => 8,
                };
                let interpolation = report.pixels * 16 + report.voxels * accesses * voxel;
                assert_eq!(total(&report.interpolation), interpolation);
                let returned = match config.voxelizing {
                    Voxelizing::FragmentGenerators => report.pixels * 16,
                    Voxelizing::ImageEngines => written * texel,
                };
                let images = report.fragments * 32 + report.examined * 2 + returned;
                assert_eq!(total(&report.image_engines), images);

                assert!(report.pipelined_cycles <= report.lockstep_cycles);
                let (least, most) = report.frames_per_second();
                assert!(least > 0.0 && least <= most);
                // Some engine has the mean or more.
                for load in [
                    report.scan_conversion,
                    report.image_engines,
                    report.interpolation,
                ] {
                    assert!(load.min as f64 <= load.mean && load.mean <= load.max as f64);
                }
            }
        }
    }
}

/// With twice the fragment generators the busiest one has less to do, but not less than half.
#[test]
fn more_generators_share_the_work() {
    let of = |fragment_generators| {
        let config = MachineConfig {
            fragment_generators,
            ..MachineConfig::default()
        };
        simulate(VoxelizerOptions::default(), &config).2
    };
    let reports = [5, 10, 20].map(of);
    for pair in reports.windows(2) {
        assert!(pair[1].interpolation.max < pair[0].interpolation.max);
        assert!(pair[1].interpolation.max * 2 >= pair[0].interpolation.max);
        assert!(pair[1].scan_conversion.max < pair[0].scan_conversion.max);
    }
    for report in &reports {
        assert!(report.interpolation.balance() > 0.7, "{report}");
    }
    assert_eq!(reports[0], of(5));
}

/// How texture memories become alike changes nothing else.
#[test]
fn the_merge_is_told_apart() {
    let options = VoxelizerOptions::default();
    for pair in machines().chunks(2) {
        let [broadcast, readback] = pair else {
            panic!("machines come in pairs");
        };
        let reports = [broadcast, readback].map(|config| simulate(options, config).2);
        assert_eq!(reports[0].clone().merged(readback), reports[1]);
        assert_eq!(reports[1].clone().merged(broadcast), reports[0]);
        let longest = reports[0].stages.iter().map(|stage| stage.cycles).max();
        assert_eq!(longest, Some(reports[0].pipelined_cycles));
    }
}

#[test]
fn what_takes_longest_is_the_bound() {
    let bound = |config: &MachineConfig| simulate(VoxelizerOptions::default(), config).2.bound();
    let slow = 1_000_000;
    let config = MachineConfig::default;
    for (name, config) in [
        (
            "geometry engines",
            MachineConfig {
                geometry_cycles_per_triangle: slow,
                ..config()
            },
        ),
        (
            "triangle bus",
            MachineConfig {
                triangle_bytes: slow,
                ..config()
            },
        ),
        (
            "host bus",
            MachineConfig {
                corner_bytes: slow,
                ..config()
            },
        ),
        (
            "fragment generators",
            MachineConfig {
                column_cycles: slow,
                ..config()
            },
        ),
        (
            "image engines",
            MachineConfig {
                merge_cycles: slow,
                ..config()
            },
        ),
        (
            "merge",
            MachineConfig {
                corner_bytes: 0,
                geometry_cycles_per_triangle: 0,
                triangle_bytes: 0,
                setup_cycles: 0,
                fragment_cycles: 0,
                merge_cycles: 0,
                column_cycles: 0,
                ..config()
            },
        ),
    ] {
        assert_eq!(bound(&config).name, name);
    }
}

#[test]
fn what_does_not_fit_is_said() {
    // Two buffers of 64 bits, and a column of 24 voxels of 32 bits.
    let config = MachineConfig {
        voxelizing: Voxelizing::ImageEngines,
        texture_bytes: 1000,
        ..MachineConfig::default()
    };
    let (_, _, report) = simulate(VoxelizerOptions::default(), &config);
    assert!(!report.texture_fits);
    assert_eq!(report.pixel_bits, 128 + 24 * 32);
    assert!(report.pixel_fits);
}

#[test]
fn hexahedra_go_through_as_they_are() {
    let stairs = data_set("staircase", None);
    let options = VoxelizerOptions {
        cells: Cells::AsGiven,
        ..VoxelizerOptions::default()
    };
    let voxelizer = Voxelizer::new(options).expect("valid");
    let lattice = tetrascope_core::grid::Lattice {
        spacing: DVec3::splat(0.25),
        origin: DVec3::splat(0.125),
        ..lattice([12, 12, 16])
    };
    let truth = voxelizer.voxelize(&stairs, &lattice).expect("voxels");
    let config = MachineConfig::default();
    let (volume, report) = voxelizer
        .simulate(&stairs, &lattice, &config)
        .expect("voxels");
    assert!(truth == volume);
    // Of a cube two faces of two triangles each are not on edge.
    assert_eq!((report.passes, report.triangles), (23, 92));
    assert_eq!(report.buses.host, 23 * 8 * 16);
    assert_eq!(report.voxels, 23 * 64);
}

#[test]
fn machines_that_cannot_be_are_refused() {
    let wrong = [
        MachineConfig {
            fragment_generators: 0,
            ..MachineConfig::default()
        },
        MachineConfig {
            image_engines: u32::MAX,
            ..MachineConfig::default()
        },
        MachineConfig {
            geometry_engines: 0,
            ..MachineConfig::default()
        },
        MachineConfig {
            clock_mhz: 0,
            ..MachineConfig::default()
        },
        MachineConfig {
            link_bytes_per_cycle: 0,
            ..MachineConfig::default()
        },
    ];
    let voxelizer = Voxelizer::new(VoxelizerOptions::default()).expect("valid");
    for config in wrong {
        let error = voxelizer.simulate(&turned(), &lattice(DIMS), &config);
        let error = error.expect_err("refused");
        assert!(error.help().is_some(), "{error}");
    }
}

/// Numbers that bound the machine move the answer, by as much as they are; numbers that it does not use move nothing.
#[test]
fn what_bounds_the_machine_moves_the_answer() {
    let voxelizer = Voxelizer::new(VoxelizerOptions::default()).expect("valid");
    let config = MachineConfig {
        // So slow that nothing else counts, but for the merge, which waits for all.
        geometry_cycles_per_triangle: 1_000_000,
        ..MachineConfig::default()
    };
    let found = voxelizer.sensitivity(&turned(), &lattice(DIMS), &config, |_| ());
    let found = found.expect("voxels");
    let of = |name: &str| found.iter().find(|s| s.name == name).expect(name).ratios;
    let bound = ["clock_mhz", "geometry_cycles_per_triangle"];
    assert!(found[..2].iter().all(|s| bound.contains(&s.name)));
    assert_eq!(of("clock_mhz"), [0.5, 2.0]);
    let [half, twice] = of("geometry_cycles_per_triangle");
    assert!((half - 2.0).abs() < 0.01 && (twice - 0.5).abs() < 0.01);
    assert_eq!(of("image_voxel_cycles"), [1.0; 2]);
    assert_eq!(of("fragment_cycles"), [1.0; 2]);
}

/// A block of cubes, turned, cut in tetrahedra, partly beside the voxels.
fn block(seed: u64, n: usize, dims: [usize; 3]) -> TetMesh {
    let turn = common::rotation(seed);
    let mut random = common::random(seed ^ 1);
    let half = 0.4 * dims.into_iter().max().expect("three") as f64;
    let (points, cells) = kuhn(n, DVec3::splat(-half), DVec3::splat(half), |_| true);
    let center = 0.5 * DVec3::from_array(dims.map(|d| d as f64));
    let center = center + DVec3::new(random(), random(), random()) * half;
    let points = points.iter().map(|p| turn * *p + center);
    mesh((points.collect(), cells), field)
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(40))]

    /// Whatever the mesh and the machine: what one stage sends the next one gets, every touched pixel is
    /// transferred once, every voxel write is accounted for, and bytes are those of what they carry.
    #[test]
    fn nothing_is_lost_between_engines(
        seed in 0_u64..1000,
        n in 1_usize..4,
        dims in proptest::array::uniform3(3_usize..20),
        samples in 1_u32..4,
        engines in proptest::array::uniform3(1_u32..24),
        bytes in proptest::array::uniform4(1_u32..300),
        ways in proptest::array::uniform3(proptest::bool::ANY),
    ) {
        let mesh = block(seed, n, dims);
        let [geometry_engines, fragment_generators, image_engines] = engines;
        let [corner_bytes, triangle_bytes, fragment_bytes, pixel_bytes] = bytes;
        let [in_image_engines, readback, as_floats] = ways;
        let config = MachineConfig {
            geometry_engines,
            fragment_generators,
            image_engines,
            corner_bytes,
            triangle_bytes,
            fragment_bytes,
            pixel_bytes,
            voxelizing: match in_image_engines {
                true => Voxelizing::ImageEngines,
                false => Voxelizing::FragmentGenerators,
            },
            merge: if readback { Merge::Readback } else { Merge::Broadcast },
            ..MachineConfig::default()
        };
        let options = VoxelizerOptions {
            offsets: Offsets::Regular(samples),
            ..options(FIXED_AND_FLOAT[usize::from(as_floats)])
        };
        let truth = common::voxelize(&mesh, dims, options);
        let voxelizer = Voxelizer::new(options).expect("valid");
        let simulated = voxelizer.simulate(&mesh, &lattice(dims), &config);
        let (volume, report) = simulated.expect("voxels");
        proptest::prop_assert!(truth == volume);

        let counts = truth.counts();
        let written = truth.writes().iter().filter(|w| **w > 0).count() as u64;
        let writes: u64 = truth.writes().iter().map(|w| u64::from(*w)).sum();
        proptest::prop_assert_eq!(
            [report.triangles, report.fragments, report.pixels, report.voxels],
            [counts.faces, counts.fragments, counts.columns, counts.writes]
        );
        proptest::prop_assert_eq!(counts.writes, writes);
        proptest::prop_assert_eq!([report.texels, total(&report.owned_texels)], [written; 2]);

        let samples = u64::from(samples.pow(3));
        let buses = report.buses;
        let of = |count: u64, bytes: u32| count * u64::from(bytes);
        proptest::prop_assert_eq!(buses.host, of(counts.cells * samples * 4, corner_bytes));
        proptest::prop_assert_eq!(buses.triangles, of(report.triangles, triangle_bytes));
        proptest::prop_assert_eq!(buses.fragments, of(report.fragments, fragment_bytes));
        let texel = 4 + u64::from(samples > 1);
        let accesses = 1 + u64::from(samples > 1);
        let back_and_written = match config.voxelizing {
            Voxelizing::FragmentGenerators => {
                (of(report.pixels, pixel_bytes), report.voxels * accesses * texel)
            }
            Voxelizing::ImageEngines => (written * texel, written * texel),
        };
        proptest::prop_assert_eq!((buses.pixels, buses.texture), back_and_written);
        let whole = dims.into_iter().product::<usize>() as u64 * texel;
        let merged = match (config.merge, fragment_generators) {
            (Merge::Broadcast, 1) => (0, 0),
            (Merge::Broadcast, _) => (written * (texel + 4), 0),
            (Merge::Readback, _) => (whole, 2 * whole),
        };
        proptest::prop_assert_eq!((buses.merge, buses.merge_host), merged);
    }
}
