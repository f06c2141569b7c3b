//! Samples that fill cells of their own.

use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::{DepthCue, Grid, OpticalModel};
use tetrascope_slicing::{Filtering, Integration, Level, SlicingOptions, Storage};

use crate::support::*;

/// Numbers of no order in [0, 1], some without a value.
fn cells() -> Grid {
    let place = skewed();
    let mut state = 5_u32;
    let random = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        match state >> 28 {
            0 => f32::NAN,
            _ => (state >> 8 & 0xff) as f32 / 255.0,
        }
    };
    let lattice = Lattice {
        dims: place.dims,
        origin: place.origin,
        spacing: place.spacing,
        direction: place.direction,
        interpolation: Interpolation::Nearest,
    };
    let count = place.dims.iter().product();
    let samples = (0..count).map(random).collect();
    Grid::on(lattice, Samples::F32(samples)).expect("the grid is valid")
}

// Cells are integrated one by one, whatever slabs there are: exact but for f32. A pixel's
// ray is off by 2⁻²³ of some tens of voxels, so each cell's end is off by some 1e-5 of a
// voxel, and moves that share of a voxel's optical depth, at most 6 · 0.3, from one color to
// another: 2e-5 for each cell, and rays pass some ten of them. None of these rays grazes an
// edge so that it would meet other cells.
#[test]
fn cells_are_drawn_whole() {
    let Some(gpu) = testing::gpu("cells_are_drawn_whole") else {
        return;
    };
    let grid = cells();
    let tf = ramp(6.0);
    for (name, view) in views(&grid) {
        for model in OpticalModel::VOLUMETRIC {
            for cued in [false, true] {
                let mut look = appearance(&tf, model);
                look.depth_cue = cued.then_some(DepthCue { strength: 0.6 });
                let truth = truth(&grid, &look, &view);
                let options = |slices_per_voxel, integration, storage, filtering| SlicingOptions {
                    slices_per_voxel,
                    integration,
                    storage,
                    filtering,
                    level: Level::Fixed(1),
                    ..Default::default()
                };
                for options in [
                    options(1.0, Integration::Slabs, Storage::Auto, Filtering::Exact),
                    options(
                        0.5,
                        Integration::PostClassified,
                        Storage::Bricks,
                        Filtering::Hardware,
                    ),
                ] {
                    let frame = draw(&gpu, &grid, &look, &options, &view);
                    assert!(shows(&frame), "{name} {model:?}");
                    let (rmse, most) = difference(&frame, &truth);
                    assert!(
                        rmse < 5e-6 && most < 3e-4,
                        "{name} {model:?} {cued}: {rmse:e} {most:e}"
                    );
                }
            }
        }
    }
}
