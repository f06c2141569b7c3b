//! Tables of the integral: their entries, and what lies between.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::optics::{Segment, integrate_segment};
use tetrascope_core::{Error, Knot, OpticalModel, Scalars, TetMesh, TransferFunction};
use tetrascope_f32::mean_chord;
use tetrascope_gpu::memory::read_back;
use tetrascope_gpu::preintegration::{self, Fixed, Source, Table};
use tetrascope_gpu::{Gpu, Integration, memory};
use tetrascope_testing as testing;

use crate::support::{Probe, bumps, intervals_of, on_device, random, table};

/// Every model with each integration that has a table for it.
const TABLES: [(OpticalModel, Integration); 8] = [
    (OpticalModel::Emission, Integration::Table2d { n: 33 }),
    (
        OpticalModel::MaximumIntensity,
        Integration::Table2d { n: 33 },
    ),
    (OpticalModel::Absorption, Integration::Table2d { n: 33 }),
    (OpticalModel::Absorption, Integration::Table3d { n: 17 }),
    (
        OpticalModel::EmissionAbsorption,
        Integration::Table3d { n: 17 },
    ),
    (OpticalModel::Emission, FIXED),
    (OpticalModel::Absorption, FIXED),
    (OpticalModel::EmissionAbsorption, FIXED),
];

const FIXED: Integration = Integration::TableFixed { n: 33 };

/// Red, green, blue and depth or opacity of a segment in f64.
fn exact(tf: &TransferFunction, model: OpticalModel, opacity: bool, probe: Probe) -> [f64; 4] {
    let segment = Segment {
        front: probe.front.into(),
        back: probe.back.into(),
        length: probe.length.into(),
    };
    let (light, depth) = integrate_segment(tf, model, &segment);
    let last = if opacity { -(-depth).exp_m1() } else { depth };
    [light.x, light.y, light.z, last]
}

/// The table's entries, the scalar at the front running fastest.
fn entries(gpu: &Gpu, table: &Table) -> Vec<Vec<f32>> {
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let source = memory::Source::Texture(table.texture());
    let copy = read_back(gpu, &mut encoder, source).expect("a copy");
    gpu.finish(encoder).expect("nothing can fail");
    let numbers: Vec<f32> = copy.read().expect("readable");
    let components = table.texture().format().components().into();
    numbers.chunks(components).map(<[f32]>::to_vec).collect()
}

#[test]
fn entries_are_the_integral() {
    let Some(gpu) = testing::gpu("entries_are_the_integral") else {
        return;
    };
    let longest = 2.0_f32;
    let densest = [3.0, 100.0];
    let cases = densest
        .into_iter()
        .flat_map(|d| TABLES.map(|(m, i)| (d, m, i)));
    for (densest, model, integration) in cases {
        let tf = bumps(densest);
        let table = table(&gpu, &tf, model, integration, longest);
        // Whether entries are opacities, layers, and the length in one.
        type LengthIn = fn(f32, f32) -> f32;
        let (n, opacity, layers, length): (u32, bool, u32, LengthIn) = match integration {
            Integration::Table2d { n } => (n, false, 1, |_, _| 1.0),
            Integration::Table3d { n } => (n, true, n, |longest, share| longest * share),
            Integration::TableFixed { n } => (n, true, 1, |longest, _| longest),
            _ => unreachable!("listed"),
        };
        let last = (n - 1) as f32;
        let entries = entries(&gpu, &table);
        assert_eq!(entries.len() as u32, n * n * layers, "{model:?}");
        assert_eq!(
            table.bytes(),
            entries.len() as u64 * 4 * entries[0].len() as u64
        );
        let mut worst = 0.0_f64;
        for (entry, i) in entries.iter().zip(0..) {
            let (front, back, layer) = (i % n, i / n % n, i / n / n);
            let probe = Probe {
                front: front as f32 / last,
                back: back as f32 / last,
                length: length(longest, layer as f32 / last),
            };
            let truth = exact(&tf, model, opacity, probe);
            let truth = match entry.len() {
                1 => vec![truth[3]],
                _ => truth[..if opacity { 4 } else { 3 }].to_vec(),
            };
            for (found, truth) in entry.iter().zip(&truth) {
                // What optics.rs allows, relative to the greatest that there can be: the densest
                // per unit length in an emission or depth, 1 in light, color and opacity.
                let scale = match (model, opacity) {
                    (OpticalModel::Emission, true) => densest * f64::from(longest),
                    (OpticalModel::Emission, _) | (OpticalModel::Absorption, false) => densest,
                    _ => 1.0,
                };
                let off = (f64::from(*found) - truth).abs() / scale;
                worst = worst.max(off);
                assert!(
                    off <= 1.7e-6,
                    "{model:?} {probe:?}: {entry:?}, truth {truth:?}"
                );
            }
        }
        eprintln!("{densest} {model:?} {integration:?}: worst {worst:.1e}");
        assert!(worst > 0.0, "f32 is not f64: nothing was compared");
    }
}

/// 1 + sin and the like at so many knots that no sample of a table sees their corners.
fn waves() -> TransferFunction {
    let last = 512;
    let knots = (0..=last).map(|k| {
        let x = f64::from(k) / f64::from(last);
        let wave =
            |turns: f64, at: f64| 0.5 + 0.5 * (std::f64::consts::TAU * (turns * x + at)).sin();
        Knot {
            scalar: x,
            color: DVec3::new(wave(1.0, 0.1), wave(1.5, 0.3), wave(0.5, 0.7)),
            extinction: 2.0 * wave(1.0, 0.45),
        }
    });
    TransferFunction::new(knots.collect()).expect("sorted")
}

/// The waves with a jump from dark to bright and back.
fn steps() -> TransferFunction {
    let knot = |scalar, color, extinction| Knot {
        scalar,
        color: DVec3::splat(color),
        extinction,
    };
    // Where no sample of a table is.
    let (a, b) = (0.3141592, 0.7243961);
    TransferFunction::new(vec![
        knot(0.0, 0.1, 0.2),
        knot(a, 0.1, 0.2),
        knot(a, 1.0, 2.0),
        knot(b, 1.0, 2.0),
        knot(b, 0.3, 0.5),
        knot(1.0, 0.3, 0.5),
    ])
    .expect("sorted")
}

/// Segments in the table's range, seeded.
fn segments(seed: u32, longest: f64) -> Vec<Probe> {
    let mut next = random(seed);
    let one = |_| Probe {
        front: next() as f32,
        back: next() as f32,
        length: (longest * next()) as f32,
    };
    (0..5000).map(one).collect()
}

/// Root mean square and greatest error over segments, of light and opacity.
fn error(
    gpu: &Gpu,
    tf: &TransferFunction,
    model: OpticalModel,
    integration: Integration,
) -> (f64, f64) {
    let longest = 1.5;
    let table = table(gpu, tf, model, integration, longest);
    let probes = segments(7, longest.into());
    let answers = on_device(gpu, tf, model, &table, &probes);
    let mut squares = 0.0;
    let mut greatest = 0.0_f64;
    for (probe, (answer, opacity)) in probes.iter().zip(answers) {
        let truth = exact(tf, model, true, *probe);
        let found = [answer[0], answer[1], answer[2], opacity];
        for (found, truth) in found.into_iter().zip(truth) {
            let off = (f64::from(found) - truth).abs();
            squares += off * off;
            greatest = greatest.max(off);
        }
    }
    ((squares / (4 * probes.len()) as f64).sqrt(), greatest)
}

/// The errors for n, 2n and 4n intervals, and the orders of their RMS.
fn orders(
    gpu: &Gpu,
    tf: &TransferFunction,
    (model, three): (OpticalModel, bool),
    first: u32,
) -> [f64; 2] {
    let errors = [first, 2 * first, 4 * first].map(|intervals| {
        let n = intervals + 1;
        let integration = if three {
            Integration::Table3d { n }
        } else {
            Integration::Table2d { n }
        };
        let (rms, greatest) = error(gpu, tf, model, integration);
        eprintln!("{model:?} {integration:?}: RMS {rms:.2e}, greatest {greatest:.2e}");
        rms
    });
    [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2)
}

// Linear interpolation errs by h² f''/8 and less where f is smooth.
#[test]
fn smooth_tables_converge_in_second_order() {
    let Some(gpu) = testing::gpu("smooth_tables_converge_in_second_order") else {
        return;
    };
    let cases = [
        (OpticalModel::Emission, false, 16),
        (OpticalModel::Absorption, false, 16),
        (OpticalModel::Absorption, true, 16),
        (OpticalModel::EmissionAbsorption, true, 16),
    ];
    let tf = waves();
    for (model, three, first) in cases {
        let orders = orders(&gpu, &tf, (model, three), first);
        // The next terms, of fourth order, are under 1/100 at 1/16 of these waves; f32's
        // rounding, 1e-7, is under 1/100 of the errors measured, 1e-4 to 1e-5.
        for order in orders {
            assert!((order - 2.0).abs() < 0.1, "{model:?}: {orders:?}");
        }
    }
}

// The mean over an interval that ends at a jump has a corner there: within one sample
// of it the error is of order h, elsewhere h², and the share of such segments is h, so
// its RMS goes with h^(3/2). Where both ends are near a jump the mean takes any value
// between, but those are h² of all segments: an RMS of order 1.
#[test]
fn tables_of_steps_converge_in_first_order() {
    let Some(gpu) = testing::gpu("tables_of_steps_converge_in_first_order") else {
        return;
    };
    let tf = steps();
    for (model, three) in [
        (OpticalModel::Emission, false),
        (OpticalModel::EmissionAbsorption, true),
    ] {
        let orders = orders(&gpu, &tf, (model, three), 16);
        let mean = 0.5 * (orders[0] + orders[1]);
        assert!((0.8..1.6).contains(&mean), "{model:?}: {orders:?}");
    }
}

// The greatest color has an edge on the diagonal, where front and back change places, and
// wherever a crest comes into the interval: an error of order h in a share h of segments.
#[test]
fn tables_of_maxima_are_within_one_sample() {
    let Some(gpu) = testing::gpu("tables_of_maxima_are_within_one_sample") else {
        return;
    };
    let tf = waves();
    let model = OpticalModel::MaximumIntensity;
    for n in [17, 33, 65, 129] {
        let (rms, greatest) = error(&gpu, &tf, model, Integration::Table2d { n });
        // The maximum changes by no more than the color does along an end's way to a
        // sample, at most h, on average h/2 for both ends: the steepest wave has π 1.5.
        let bound = std::f64::consts::PI * 1.5 / f64::from(n - 1);
        eprintln!("{n}: RMS {rms:.2e}, greatest {greatest:.2e}, bound {bound:.2e}");
        assert!(greatest <= bound, "{n}: {greatest:e}");
        assert!(greatest > bound / 100.0, "nothing was compared");
    }
}

// Beyond the knots a table has no place; color and extinction are constant there.
#[test]
fn segments_may_leave_the_table() {
    let Some(gpu) = testing::gpu("segments_may_leave_the_table") else {
        return;
    };
    // Steps at both ends, so that what is beyond is unlike what is inside.
    let knot = |scalar, color: [f64; 3], extinction| Knot {
        scalar,
        color: color.into(),
        extinction,
    };
    let tf = TransferFunction::new(vec![
        knot(0.0, [0.9, 0.2, 0.1], 0.7),
        knot(0.0, [0.1, 0.5, 0.3], 0.2),
        knot(1.0, [0.3, 0.7, 0.5], 0.4),
        knot(1.0, [0.2, 0.1, 0.8], 0.9),
    ])
    .expect("sorted");
    let ends = [-0.75, -0.001, 0.0, 0.25, 1.0, 1.001, 1.5];
    let pairs = ends.into_iter().flat_map(|a| ends.map(|b| (a, b)));
    let probes: Vec<Probe> = pairs
        .flat_map(|(front, back)| {
            [0.03, 0.5, 1.5].map(|length| Probe {
                front,
                back,
                length,
            })
        })
        .collect();
    // Of one length there is nothing beyond: that table holds the whole field.
    let tables = TABLES.into_iter().filter(|(_, table)| *table != FIXED);
    for (model, integration) in tables {
        let table = table(&gpu, &tf, model, integration, 1.5);
        let answers = on_device(&gpu, &tf, model, &table, &probes);
        for (probe, (answer, opacity)) in probes.iter().zip(answers) {
            let truth = exact(&tf, model, true, *probe);
            let found = [answer[0], answer[1], answer[2], opacity];
            let both_beyond = |limit: fn(f32) -> bool| limit(probe.front) && limit(probe.back);
            // Exact where nothing is inside. Else what interpolation leaves, h²/8 of the
            // second derivatives: (σ l)² at most along the length, with σ = 0.65 where a
            // scalar stays on a step and h = 1/16; less along scalars, whose slopes are
            // 0.2. A maximum has a corner, so h · 0.2.
            let tolerance = if both_beyond(|x| x < 0.0) || both_beyond(|x| x > 1.0) {
                1e-6
            } else if model == OpticalModel::MaximumIntensity {
                0.2 / 32.0
            } else {
                (0.65_f64 * 1.5).powi(2) / 8.0 / 256.0
            };
            for (found, truth) in found.into_iter().zip(truth) {
                let off = (f64::from(found) - truth).abs();
                assert!(
                    off <= tolerance,
                    "{model:?} {integration:?} {probe:?}: {answer:?} {opacity}, truth {truth:?}"
                );
            }
        }
    }
}

#[test]
fn the_published_tents_err_as_published() {
    let Some(gpu) = testing::gpu("the_published_tents_err_as_published") else {
        return;
    };
    // An opacity tent of width 1/4 around 1/2 with an optical depth up to `deepest` in the
    // longest segment. For 64 samples per side a greatest error of α of 2.5e-2 for a depth
    // of 2 and of 0.11 for 20 was measured with another implementation.
    let tent = |deepest: f64| {
        let knot = |scalar, extinction| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        };
        let knots = vec![
            knot(0.0, 0.0),
            knot(0.375, 0.0),
            knot(0.5, deepest / 1.5),
            knot(0.625, 0.0),
            knot(1.0, 0.0),
        ];
        TransferFunction::new(knots).expect("sorted")
    };
    for (deepest, published) in [(2.0, 2.5e-2), (20.0, 0.11)] {
        let integration = Integration::Table3d { n: 64 };
        let model = OpticalModel::EmissionAbsorption;
        let (rms, greatest) = error(&gpu, &tent(deepest), model, integration);
        eprintln!(
            "τ ≤ {deepest}: RMS {rms:.2e}, greatest {greatest:.2e}, published {published:.2e}"
        );
        // Samples of segments differ, so a third more is within what was published.
        assert!(
            (published / 4.0..1.33 * published).contains(&greatest),
            "{greatest:e}"
        );
    }
}

#[test]
fn tables_that_cannot_be_are_refused_in_words() {
    let Some(gpu) = testing::gpu("tables_that_cannot_be_are_refused_in_words") else {
        return;
    };
    let intervals = intervals_of(&bumps(1.0));
    let make = |integration, model| {
        let source = Source {
            integration,
            model,
            intervals: &intervals,
            longest: 1.0,
            fixed: None,
        };
        Table::new(&gpu, "projection", &source)
    };
    let model = OpticalModel::EmissionAbsorption;
    let large = make(Integration::Table3d { n: 512 }, model).expect_err("2 GiB");
    let text = "projection does not draw a table of integrals with 512 samples a side: beyond \
                256 a table of this many axes takes too much memory";
    assert_eq!(large.to_string(), text);
    for n in [Integration::MOST_2D + 1, u32::MAX] {
        let large = make(Integration::Table2d { n }, OpticalModel::Emission);
        assert!(matches!(large, Err(Error::Unsupported { .. })), "{n}");
    }
    for n in [0, 1] {
        for integration in [Integration::Table2d { n }, Integration::Table3d { n }] {
            let small = make(integration, OpticalModel::Absorption);
            assert!(matches!(small, Err(Error::Invalid { .. })), "{n}");
        }
    }
    let flat = make(Integration::Table2d { n: 64 }, model).expect_err("not linear");
    assert!(matches!(flat, Error::Unsupported { .. }), "{flat}");
    let fixed = make(FIXED, model).expect_err("no length is given");
    assert!(matches!(fixed, Error::Unsupported { .. }), "{fixed}");
    let large = Integration::TableFixed {
        n: Integration::MOST_2D + 1,
    };
    let large = make(large, model).expect_err("too large");
    assert!(matches!(large, Error::Unsupported { .. }), "{large}");
}

/// An edge of 1 has a volume of 1/(6 √2) and a surface of √3; five cells of a unit cube have
/// 1, and six of the cube's sides, four times the inner cell's sides of √3/2 twice.
#[test]
fn the_mean_chord_is_four_volumes_over_surfaces() {
    let scalars = |count| Scalars {
        name: "s".into(),
        association: Association::Point,
        values: vec![0.0; count],
    };
    let corners = [[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
    let corners = corners.map(|c| DVec3::from(c.map(f64::from)));
    let regular = corners.map(|c| c / 2f64.sqrt()).to_vec();
    let mesh = TetMesh::from_tetrahedra(regular, vec![[0, 1, 2, 3]], scalars(4)).expect("a mesh");
    let expected = 4.0 / (6.0 * 2f64.sqrt()) / 3f64.sqrt();
    assert!((mean_chord(&mesh) - expected).abs() < 1e-15);

    let cube: Vec<DVec3> = (0..8)
        .map(|i| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(f64::from)))
        .collect();
    // The corners 0, 3, 5 and 6 are the inner cell's.
    let cells = vec![
        [0, 3, 5, 6],
        [1, 0, 3, 5],
        [2, 0, 3, 6],
        [4, 0, 5, 6],
        [7, 3, 5, 6],
    ];
    let mesh = TetMesh::from_tetrahedra(cube, cells, scalars(8)).expect("a mesh");
    let expected = 4.0 / (6.0 + 8.0 * 3f64.sqrt() / 2.0);
    assert!((mean_chord(&mesh) - expected).abs() < 1e-15);
}

#[test]
fn a_table_is_made_again_only_if_it_would_differ() {
    let Some(gpu) = testing::gpu("a_table_is_made_again_only_if_it_would_differ") else {
        return;
    };
    let (tf, other) = (intervals_of(&bumps(1.0)), intervals_of(&bumps(2.0)));
    let source = Source {
        integration: Integration::Table3d { n: 8 },
        model: OpticalModel::EmissionAbsorption,
        intervals: &tf,
        longest: 1.0,
        fixed: None,
    };
    let table = Table::new(&gpu, "test", &source).expect("it fits");
    let kept = |source: &preintegration::Source| {
        let renewed = table.renewed(&gpu, "test", source).expect("it fits");
        renewed.texture() == table.texture()
    };
    assert!(kept(&source));
    let integration = Integration::Table3d { n: 9 };
    assert!(!kept(&Source {
        integration,
        ..source.clone()
    }));
    let model = OpticalModel::Absorption;
    assert!(!kept(&Source {
        model,
        ..source.clone()
    }));
    assert!(!kept(&Source {
        intervals: &other,
        ..source.clone()
    }));
    assert!(!kept(&Source {
        longest: 2.0,
        ..source.clone()
    }));

    // Of one length: the longest does not matter, that length and the axes do.
    let fixed = |length, scalars| Source {
        integration: FIXED,
        fixed: Some(Fixed { length, scalars }),
        ..source.clone()
    };
    let table = Table::new(&gpu, "test", &fixed(0.5, (0.0, 1.0))).expect("it fits");
    let kept = |source: &preintegration::Source| {
        let renewed = table.renewed(&gpu, "test", source).expect("it fits");
        renewed.texture() == table.texture()
    };
    assert!(kept(&Source {
        longest: 2.0,
        ..fixed(0.5, (0.0, 1.0))
    }));
    assert!(!kept(&fixed(0.25, (0.0, 1.0))));
    assert!(!kept(&fixed(0.5, (0.0, 0.5))));
}
