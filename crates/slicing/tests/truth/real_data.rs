//! A public volume, where it is: `../shared/data` beside the repository, or the folder that
//! `TETRASCOPE_DATA` names.

use tetrascope_core::{
    Appearance, Camera, CameraFit, OpticalModel, Projection, TransferFunction, View, Volume,
};
use tetrascope_io::{FileData, ReadOptions, read_file};
use tetrascope_slicing::counters::{BRICKS_DRAWN, FRAGMENTS};
use tetrascope_slicing::{Filtering, Integration, Level, Slicer, SlicingOptions};

use crate::support::*;

/// Arteries, 99 % of 256³ samples 0: most boxes are left out, and nothing is missing.
#[test]
fn skipping_leaves_the_aneurism_as_it_is() {
    let name = "skipping_leaves_the_aneurism_as_it_is";
    let Some(path) = testing::file(name, "aneurism.vti") else {
        return;
    };
    let Some(gpu) = testing::gpu(name) else {
        return;
    };
    let data = read_file(&path, &ReadOptions::default()).expect("it is read");
    let FileData::Grid(data) = data else {
        panic!("it is a grid");
    };
    let (Volume::Grid(grid), _) = data.into_volume(None).expect("it has a field") else {
        panic!("it fits in memory");
    };
    let vessels = vec![
        knot(30.0, [1.0, 0.9, 0.8], 0.0),
        knot(255.0, [1.0, 0.2, 0.1], 0.5),
    ];
    let vessels = TransferFunction::new(vessels).expect("sorted");
    let view = View {
        camera: Camera::fit(&grid.bounds(), CameraFit::PlusIso, false, 1.0),
        width: 96,
        height: 96,
        background: [0.0; 4],
    };
    let of = |level| SlicingOptions {
        level: Level::Fixed(level),
        slices_per_voxel: 1.0,
        ..Default::default()
    };
    let appearance = appearance(&vessels, OpticalModel::EmissionAbsorption);
    let whole = draw(&gpu, &grid, &appearance, &of(0), &view);
    assert!(shows(&whole));
    for (level, most) in [(4, 0.3), (5, 0.15)] {
        let boxes = draw(&gpu, &grid, &appearance, &of(level), &view);
        // Slabs have the same bits in each box, and those that are left out add nothing.
        assert_eq!(between(&whole, &boxes).1, 0.0);
        let drawn = boxes.stats.get(BRICKS_DRAWN).expect("counted") as f64;
        let share = drawn / f64::from(1_u32 << (3 * level));
        assert!(share < most, "level {level}: {share}");
    }

    // With the lower third hidden, as in the paper's figures, boxes that are chosen by their
    // cost leave out most of the work.
    let third = vec![
        knot(85.0, [1.0, 0.9, 0.8], 0.0),
        knot(85.0, [1.0, 0.9, 0.8], 0.2),
        knot(255.0, [1.0, 0.2, 0.1], 0.5),
    ];
    let appearance = Appearance {
        transfer_function: TransferFunction::new(third).expect("sorted"),
        ..appearance
    };
    let mut large = View {
        width: 256,
        height: 256,
        ..view
    };
    // The middle of an image of 512² pixels: in smaller ones of all of it, more of the
    // fragments are those beside polygons that complete blocks.
    if let Projection::Perspective { view_angle } = &mut large.camera.projection {
        *view_angle = 2.0
            * (0.5 * (0.5 * view_angle.to_radians()).tan())
                .atan()
                .to_degrees();
    }
    let published = |level| SlicingOptions {
        level,
        integration: Integration::PostClassified,
        filtering: Filtering::Hardware,
        slicer: Slicer::VertexProgram,
        ..of(0)
    };
    let [whole, boxes] = [Level::Fixed(0), Level::Auto]
        .map(|level| draw(&gpu, &grid, &appearance, &published(level), &large));
    assert_eq!(between(&whole, &boxes).1, 0.0);
    match [&whole, &boxes].map(|frame| frame.stats.get(FRAGMENTS)) {
        [Some(whole), Some(boxes)] => assert!(whole >= 3 * boxes, "{whole} {boxes}"),
        _ => println!("skipped: this device does not count fragments"),
    }
}
