//! Pictures do not depend on how a volume is divided, stored or streamed.

use std::io::Write as _;
use std::sync::Arc;

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{GridStream, SampleType, Samples};
use tetrascope_core::{Grid, OpticalModel, Volume, VolumeRenderer as _};
use tetrascope_gpu::{Draw as _, Target};
use tetrascope_io::RawFile;
use tetrascope_io::grid::ByteOrder;
use tetrascope_slicing::counters::{BRICKS_DRAWN, BRICKS_SKIPPED};
use tetrascope_slicing::{
    Filtering, Integration, Level, Shading, Slicer, Slicing, SlicingOptions, Storage,
};

use crate::support::*;

/// Some blobs in emptiness, as bytes.
fn blobs(n: usize) -> Grid {
    let blob = |p: DVec3, at: [f64; 3], r: f64| {
        (1.0 - (p - DVec3::from(at)).length_squared() / (r * r)).max(0.0)
    };
    let field = |p: DVec3| {
        let sum = blob(p, [0.2, 0.3, 0.25], 0.15)
            + blob(p, [0.7, 0.6, 0.8], 0.2)
            + blob(p, [0.75, 0.2, 0.3], 0.1);
        (255.0 * sum.min(1.0)) as u8
    };
    grid_of(&cube(n), field, Samples::U8)
}

fn look(model: OpticalModel) -> tetrascope_core::Appearance {
    let tf = tetrascope_core::TransferFunction::new(vec![
        knot(20.0, [0.0, 0.0, 0.0], 0.0),
        knot(90.0, [0.9, 0.3, 0.1], 6.0),
        knot(255.0, [0.3, 0.9, 1.0], 30.0),
    ]);
    appearance(&tf.expect("sorted"), model)
}

/// Levels and bricks against one box of one texture.
#[test]
fn bricks_and_levels_leave_no_seam() {
    let Some(gpu) = testing::gpu("bricks_and_levels_leave_no_seam") else {
        return;
    };
    let grid = blobs(70);
    for (name, view) in views(&grid) {
        for (integration, slicer) in [
            (Integration::PostClassified, Slicer::Rays),
            (Integration::PostClassified, Slicer::VertexProgram),
            (Integration::Slabs, Slicer::Rays),
            (Integration::Slabs, Slicer::VertexProgram),
        ] {
            for model in OpticalModel::VOLUMETRIC {
                let of = |level, storage| SlicingOptions {
                    slicer,
                    level: Level::Fixed(level),
                    storage,
                    integration,
                    slices_per_voxel: 1.0,
                    ..Default::default()
                };
                let draw =
                    |options: &SlicingOptions| draw(&gpu, &grid, &look(model), options, &view);
                let one = draw(&of(0, Storage::Auto));
                assert!(
                    shows(&one) || model == OpticalModel::Absorption,
                    "{name} {model:?}"
                );
                for (level, storage) in [
                    (1, Storage::Auto),
                    (3, Storage::Auto),
                    (1, Storage::Bricks),
                    (3, Storage::Bricks),
                ] {
                    let other = draw(&of(level, storage));
                    let (rmse, most) = between(&one, &other);
                    // Every slab has the same bits in each; skipped ones add exactly
                    // nothing where the transfer function is 0.
                    assert_eq!(
                        rmse, 0.0,
                        "{name} {slicer:?} {model:?} level {level} {storage:?}: {most:e}"
                    );
                }
            }
        }
    }
}

/// Skipped boxes are counted, and `Auto` finds the empty space worth skipping.
#[test]
fn empty_boxes_are_skipped_and_counted() {
    let Some(gpu) = testing::gpu("empty_boxes_are_skipped_and_counted") else {
        return;
    };
    let grid = blobs(70);
    let (_, view) = views(&grid).swap_remove(0);
    let of = |level| SlicingOptions {
        level,
        ..Default::default()
    };
    let appearance = look(OpticalModel::EmissionAbsorption);
    let fixed = draw(&gpu, &grid, &appearance, &of(Level::Fixed(3)), &view);
    let (drawn, skipped) = (
        fixed.stats.get(BRICKS_DRAWN),
        fixed.stats.get(BRICKS_SKIPPED),
    );
    let (drawn, skipped) = (drawn.expect("counted"), skipped.expect("counted"));
    assert_eq!(drawn + skipped, 512);
    assert!(drawn > 0 && drawn < 128, "{drawn}");
    // 69³ samples of a byte and one transfer function.
    assert_eq!(fixed.stats.bytes_resident / 70_u64.pow(3), 1);
    let view = tetrascope_core::View {
        width: 256,
        height: 256,
        ..view
    };
    let auto = draw(&gpu, &grid, &appearance, &of(Level::Auto), &view);
    assert!(auto.stats.get(BRICKS_SKIPPED).expect("counted") > 0);

    // Nothing is empty: one box, as the paper asks of the worst case.
    let full = grid_of(&cube(70), |_| 200_u8, Samples::U8);
    let opaque = draw(&gpu, &full, &appearance, &of(Level::Auto), &view);
    assert_eq!(opaque.stats.get(BRICKS_DRAWN), Some(1));

    // Everything is: nothing is drawn but the background.
    let empty = grid_of(&cube(70), |_| 3_u8, Samples::U8);
    let nothing = draw(&gpu, &empty, &appearance, &of(Level::Auto), &view);
    assert_eq!(nothing.stats.get(BRICKS_DRAWN), Some(0));
    let background = view.premultiplied_background().map(|c| c as f32);
    assert!(nothing.pixels.iter().all(|p| *p == background));
}

/// A budget that holds a few bricks at a time, from memory and from a file.
#[test]
fn a_small_budget_streams_the_same_picture() {
    let Some(gpu) = testing::gpu("a_small_budget_streams_the_same_picture") else {
        return;
    };
    let grid = grid_of(
        &cube(140),
        |p| (255.0 * (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y + p.z).cos())) as u8,
        Samples::U8,
    );
    let appearance = look(OpticalModel::EmissionAbsorption);
    let of = |memory_budget| SlicingOptions {
        memory_budget,
        slices_per_voxel: 1.0,
        // Streamed slabs are in polygons; rays add the same up in another order.
        slicer: Slicer::VertexProgram,
        ..Default::default()
    };
    let (_, view) = views(&grid).swap_remove(0);
    let whole = draw(&gpu, &grid, &appearance, &of(1 << 30), &view);
    assert_eq!(whole.stats.bytes_uploaded, 0);
    // Bricks of 36 + 3 samples per side; eleven of them in half the budget.
    let budget = 11 * 2 * 38_u64.pow(3);
    let streamed = draw(&gpu, &grid, &appearance, &of(budget), &view);
    assert_eq!(between(&whole, &streamed).1, 0.0);
    assert!(
        streamed.stats.bytes_resident <= budget,
        "{:?}",
        streamed.stats
    );
    assert!(streamed.stats.bytes_uploaded > 0, "{:?}", streamed.stats);
    assert!(streamed.stats.passes > 2, "{:?}", streamed.stats);

    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    let Samples::U8(bytes) = grid.samples() else {
        panic!("made of bytes");
    };
    file.write_all(&[7; 13])
        .and_then(|()| file.write_all(bytes))
        .expect("written");
    let open = |offset| {
        let lattice = *grid.lattice();
        RawFile::open(
            file.path(),
            offset,
            lattice,
            SampleType::U8,
            ByteOrder::Little,
        )
    };
    let source = Arc::new(open(13).expect("all samples are there"));
    let stream = Volume::Stream(GridStream::new(source).expect("all of it is read"));
    let slicing = Slicing::new(&gpu, &stream, &appearance, &of(budget));
    let slicing = slicing.expect("a few bricks fit");
    let from_file = slicing.render(&view).expect("drawn");
    assert_eq!(between(&whole, &from_file).1, 0.0);
    // The second frame begins with what the first left.
    let again = slicing.render(&view).expect("drawn");
    assert_eq!(between(&whole, &again).1, 0.0);
    assert!(again.stats.bytes_uploaded <= from_file.stats.bytes_uploaded);

    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let target = gpu.texture(
        "target",
        (48, 48),
        tetrascope_gpu::wgpu::TextureFormat::Rgba32Float,
        tetrascope_gpu::wgpu::TextureUsages::RENDER_ATTACHMENT,
    );
    let target = target.expect("it fits");
    let target_view = target.create_view(&Default::default());
    let target = Target::new(&target_view, target.format());
    let error = slicing.encode(&mut encoder, &view, &target).err();
    let error = error.expect("streamed");
    assert!(error.to_string().contains("budget"), "{error}");

    assert!(
        open(14)
            .expect_err("one byte is missing")
            .to_string()
            .contains("the file ends")
    );
    let options = SlicingOptions {
        memory_budget: 1000,
        ..Default::default()
    };
    let source = Arc::new(open(13).expect("all samples are there"));
    let error = Slicing::from_source(&gpu, source, &appearance, &options);
    assert!(error.expect_err("no room").to_string().contains("limit") || budget > 0);
}

/// Gradients reach one sample beyond a brick, and so does its border.
#[test]
fn shaded_bricks_have_no_seam() {
    let Some(gpu) = testing::gpu("shaded_bricks_have_no_seam") else {
        return;
    };
    let grid = blobs(70);
    let (_, view) = views(&grid).swap_remove(1);
    for model in OpticalModel::VOLUMETRIC {
        for integration in [Integration::PostClassified, Integration::Slabs] {
            for filtering in [Filtering::Exact, Filtering::Hardware] {
                let of = |level, storage| SlicingOptions {
                    level: Level::Fixed(level),
                    storage,
                    integration,
                    filtering,
                    shading: Shading::Phong(Default::default()),
                    ..Default::default()
                };
                let draw =
                    |options: &SlicingOptions| draw(&gpu, &grid, &look(model), options, &view);
                let one = draw(&of(0, Storage::Auto));
                let bricks = draw(&of(2, Storage::Bricks));
                let (rmse, most) = between(&one, &bricks);
                let context = format!("{model:?} {integration:?} {filtering:?}: {rmse:e} {most:e}");
                match filtering {
                    Filtering::Exact => assert_eq!(most, 0.0, "{context}"),
                    // A texel's place in a larger texture has other roundings, which
                    // may turn the last of a fraction's bits.
                    Filtering::Hardware => assert!(rmse <= 1e-6, "{context}"),
                }
            }
        }
    }
}
