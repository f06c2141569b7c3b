//! Tests that all that does not show is passed over, and only that.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::{Frame, Grid, OpticalModel, Volume, VolumeRenderer as _};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions, counters};

use super::bench::{check, look, views};

/// One bright sample in each block of `step`³ samples of 70³, at another place in each.
fn stars(step: usize) -> Volume {
    let side = 70;
    let mut values = vec![0u8; side * side * side];
    let blocks = side / step;
    for block in 0..blocks * blocks * blocks {
        let [x, y, z] = [
            block % blocks,
            block / blocks % blocks,
            block / (blocks * blocks),
        ];
        let inner = |seed: usize| (block * seed + 7 * seed) % step;
        let at = [
            x * step + inner(13),
            y * step + inner(29),
            z * step + inner(57),
        ];
        values[at[0] + side * (at[1] + side * at[2])] = 255;
    }
    let lattice = Lattice {
        dims: [side; 3],
        origin: DVec3::ZERO,
        spacing: DVec3::ONE,
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Linear,
    };
    Volume::Grid(Grid::on(lattice, Samples::U8(values)).expect("a grid"))
}

/// Clear up to a fifth of the range.
const STAR: [(f64, [f64; 3], f64); 3] = [
    (0.0, [0.0; 3], 0.0),
    (0.2, [0.0; 3], 0.0),
    (1.0, [1.0, 0.7, 0.2], 300.0),
];

fn counted(frame: &Frame, counter: tetrascope_core::Counter) -> u64 {
    frame.stats.get(counter).expect("it is counted")
}

// A star lies in each corner and on each face of blocks of 4, 16 and 64 cells, so one that a
// wrong classification hides is one that the reference shows.
#[test]
fn no_star_is_lost() {
    for step in [5, 11, 23, 35] {
        let volume = stars(step);
        for model in OpticalModel::ALL {
            let look = look(&volume, &STAR, model);
            let [first, second, inside, _] = views(&volume, 64);
            for view in [first, second, inside] {
                let name = format!("stars of {step} {model:?}");
                // The extinction is 300 over the volume, ten times that of `models`.
                check(&name, (&volume, &look, &view), [2e-5, 2e-6]);
            }
        }
    }
}

#[test]
fn what_is_empty_is_passed_over() {
    let volume = stars(35);
    let options = RaycastCpuOptions::default();
    let view = views(&volume, 64)[0];
    for model in OpticalModel::ALL {
        let look = look(&volume, &STAR, model);
        let renderer = RaycastCpu::new(&volume, &look, &options).expect("it draws all");
        let frame = renderer.render(&view).expect("a picture");
        let visits = counted(&frame, counters::CELL_VISITS);
        let skipped = counted(&frame, counters::CELLS_SKIPPED);
        assert!(visits > 0, "{model:?}");
        assert!(skipped > 100 * visits, "{model:?} {visits} {skipped}");
        tetrascope_testing::check_counts(&tetrascope_raycast_cpu::ENTRY, &frame.stats);
    }
}

// Where all shows nothing is passed over, and after a restyle that hides all, everything is.
#[test]
fn a_restyle_classifies_anew() {
    let volume = stars(35);
    let options = RaycastCpuOptions::default();
    let view = views(&volume, 32)[0];
    let dense = [(0.0, [1.0; 3], 1.0), (1.0, [1.0; 3], 2.0)];
    let hidden = [(0.0, [1.0; 3], 0.0), (1.0, [1.0; 3], 0.0)];
    let model = OpticalModel::EmissionAbsorption;
    let mut renderer =
        RaycastCpu::new(&volume, &look(&volume, &dense, model), &options).expect("it draws all");
    let frame = renderer.render(&view).expect("a picture");
    let all = counted(&frame, counters::CELL_VISITS);
    assert_eq!(counted(&frame, counters::CELLS_SKIPPED), 0);
    renderer
        .restyle(&look(&volume, &hidden, model))
        .expect("it draws all");
    let frame = renderer.render(&view).expect("a picture");
    assert_eq!(counted(&frame, counters::CELL_VISITS), 0);
    let skipped = counted(&frame, counters::CELLS_SKIPPED);
    // Both count the planes between cells, but for the first or last cell of each ray.
    assert!(all.abs_diff(skipped) < 2 * 32 * 32, "{all} {skipped}");
}
