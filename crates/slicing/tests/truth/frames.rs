//! Costs of a frame: fragments, vertices, bytes; and that it shows the same, whoever
//! cuts boxes.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::{
    Appearance, Bounds, Camera, CameraFit, ClipPlane, Frame, Grid, OpticalModel, Projection,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_slicing::counters::{
    BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES,
};
use tetrascope_slicing::{
    Integration, Level, PlaneTest, Slicer, Slicing, SlicingOptions, Storage, Traversal,
};

use crate::support::*;

/// A wave that is transparent in about half of the cube.
fn wave() -> Grid {
    grid(&cube(65), |p| {
        (7.0 * p.x + 2.0 * p.y).sin() * (6.0 * p.y - 3.0 * p.z).cos()
    })
}

fn look() -> Appearance {
    appearance(&ramp(6.0), OpticalModel::EmissionAbsorption)
}

fn bricks(frame: &Frame) -> [u64; 2] {
    let stats = &frame.stats;
    [stats.get(BRICKS_DRAWN), stats.get(BRICKS_SKIPPED)].map(|count| count.expect("counted"))
}

/// Every slab of a ray is computed from the pixel alone, so polygons have to cover it and
/// nothing else: whoever cuts them, the picture has the same bits.
#[test]
fn both_slicers_draw_the_same() {
    let Some(gpu) = testing::gpu("both_slicers_draw_the_same") else {
        return;
    };
    let grid = wave();
    for (name, view) in views(&grid) {
        for (level, storage, memory_budget) in [
            (0, Storage::Auto, 1 << 30),
            (3, Storage::Auto, 1 << 30),
            // Bricks of 19 samples per side and of 4 bytes; five of 64 at a time.
            (3, Storage::Bricks, 5 * 2 * 4 * 19_u64.pow(3)),
        ] {
            let of = |slicer| SlicingOptions {
                level: Level::Fixed(level),
                slices_per_voxel: 1.0,
                slicer,
                storage,
                brick_level: Level::Fixed(2),
                memory_budget,
                ..Default::default()
            };
            let vertex = draw(&gpu, &grid, &look(), &of(Slicer::VertexProgram), &view);
            let cpu = draw(&gpu, &grid, &look(), &of(Slicer::Cpu), &view);
            assert!(shows(&vertex), "{name}");
            assert_eq!(between(&vertex, &cpu).1, 0.0, "{name} level {level}");
            assert_eq!(bricks(&vertex), bricks(&cpu));
            assert_eq!(vertex.stats.bytes_uploaded, cpu.stats.bytes_uploaded);
            assert_eq!(cpu.stats.passes > 2, storage == Storage::Bricks);
            if level == 3 {
                // A box is 32 bytes; its polygons are some dozen of 4 corners and 2
                // triangles, 104 bytes each.
                let bytes = [&vertex, &cpu].map(|f| f.stats.get(GEOMETRY_BYTES).expect("counted"));
                assert!(bytes[0] < 288 + 32 * 512, "{bytes:?}");
                assert!(bytes[1] > 20 * bytes[0], "{name}: {bytes:?}");
            }
        }
    }
}

/// The published test on both sides, whose polygons may be torn at corners.
#[test]
fn both_slicers_know_the_published_test() {
    let Some(gpu) = testing::gpu("both_slicers_know_the_published_test") else {
        return;
    };
    let grid = wave();
    let (_, view) = views(&grid).swap_remove(0);
    let frames = [Slicer::VertexProgram, Slicer::Cpu].map(|slicer| {
        let options = SlicingOptions {
            level: Level::Fixed(2),
            plane_test: PlaneTest::Published,
            slicer,
            ..Default::default()
        };
        draw(&gpu, &grid, &look(), &options, &view)
    });
    // A torn polygon is a slab of at most 16 cells in a part of the image.
    assert!(between(&frames[0], &frames[1]).0 < 1e-2);
}

/// An opaque cube seen along an axis: as many fragments as it has pixels, for each slab.
#[test]
fn fragments_and_vertices_are_counted() {
    let Some(gpu) = testing::gpu("fragments_and_vertices_are_counted") else {
        return;
    };
    let full = grid(&cube(17), |_| 0.5);
    let mut camera = Camera::fit(&full.bounds(), CameraFit::MinusX, true, 1.0);
    for (half_height, side) in [(0.5, 64), (0.6, 64), (0.7, 64), (1.0, 32), (2.0, 64)] {
        camera.projection = Projection::Orthographic {
            parallel_scale: half_height,
        };
        let view = View {
            camera,
            width: side,
            height: side,
            background: [0.0; 4],
        };
        let of = |slicer| SlicingOptions {
            level: Level::Fixed(0),
            slicer,
            ..Default::default()
        };
        let frame = draw(&gpu, &full, &look(), &of(Slicer::VertexProgram), &view);
        // 16 cells and 2 slices in each; a few more planes may cut the box as enlarged.
        let slabs = 32;
        let vertices = frame.stats.get(VERTICES).expect("counted");
        assert!(
            vertices >= 6 * slabs && vertices <= 6 * (slabs + 4),
            "{vertices}"
        );
        let cpu = draw(&gpu, &full, &look(), &of(Slicer::Cpu), &view);
        assert_eq!(cpu.stats.get(VERTICES), Some(4 * slabs));

        let Some(fragments) = frame.stats.get(FRAGMENTS) else {
            println!("skipped: this device does not count fragments");
            return;
        };
        let pixels = frame.pixels.iter().filter(|p| p[3] > 0.0).count() as u64;
        // Devices complete blocks, of 4×4 pixels at most, along the edges of each of the
        // square's two triangles: along its sides, and twice along its diagonal.
        let blocks = pixels.isqrt().div_ceil(4) + 1;
        let most = 16 * (blocks * blocks + blocks);
        let range = slabs * pixels..=slabs * most;
        assert!(
            range.contains(&fragments),
            "{half_height}: {fragments}, {range:?}"
        );
    }
}

/// Boxes beside the image and behind clip planes are left out, and are not missed.
#[test]
fn what_is_outside_of_the_image_is_skipped() {
    let Some(gpu) = testing::gpu("what_is_outside_of_the_image_is_skipped") else {
        return;
    };
    let grid = grid(&cube(65), |p| {
        0.6 + 0.4 * (7.0 * p.x + 5.0 * p.y * p.z).sin()
    });
    let kept = Bounds {
        min: DVec3::new(-1.0, 0.3, -1.0),
        max: DVec3::new(0.8, 2.0, 2.0),
    };
    let cut = Appearance {
        clip_planes: ClipPlane::of_box(&kept).to_vec(),
        ..look()
    };
    for (name, whole) in views(&grid) {
        let mut near = whole;
        near.camera.projection = match near.camera.projection {
            Projection::Perspective { .. } => Projection::Perspective { view_angle: 4.0 },
            Projection::Orthographic { .. } => Projection::Orthographic {
                parallel_scale: 0.1,
            },
        };
        let of = |level| SlicingOptions {
            level: Level::Fixed(level),
            slices_per_voxel: 1.0,
            ..Default::default()
        };
        let all = draw(&gpu, &grid, &look(), &of(3), &whole);
        for (view, appearance) in [(&near, &look()), (&whole, &cut)] {
            let boxes = draw(&gpu, &grid, appearance, &of(3), view);
            let one = draw(&gpu, &grid, appearance, &of(0), view);
            let light = one.pixels.iter().map(|p| p[0]).fold(0.0, f32::max);
            assert!(light > 0.2, "{name}: {light}");
            assert_eq!(between(&one, &boxes).1, 0.0, "{name}");
            let (some, all) = (bricks(&boxes)[0], bricks(&all)[0]);
            assert!(some > 0 && 4 * some < 3 * all, "{name}: {some} of {all}");
            assert_eq!(bricks(&boxes).iter().sum::<u64>(), 512);
        }
    }
}

/// Boxes found by the GPU are those that the CPU finds, in the same order: with slabs that
/// do not commute, another order would show.
#[test]
fn both_traversals_find_the_same_boxes() {
    let Some(gpu) = testing::gpu("both_traversals_find_the_same_boxes") else {
        return;
    };
    // Unlike axes, halved three, four and two times, and boxes that reach out of the volume.
    let place = Place {
        dims: [71, 130, 36],
        spacing: DVec3::new(0.014, 0.007, 0.02),
        ..skewed()
    };
    let wave = |p: DVec3| (9.0 * p.x + 2.0 * p.y).sin() * (8.0 * p.y - 3.0 * p.z).cos();
    let near = |p: DVec3| (2.0 * wave(p - place.origin) - 1.0).max(0.0);
    let kept = Bounds {
        min: place.origin - DVec3::splat(0.4),
        max: place.origin + DVec3::splat(0.3),
    };
    let bytes = TransferFunction::new(vec![
        knot(20.0, [0.1, 0.3, 0.9], 0.0),
        knot(255.0, [0.9, 0.5, 0.2], 9.0),
    ]);
    let bytes = appearance(&bytes.expect("sorted"), OpticalModel::EmissionAbsorption);
    let grids = [
        (grid(&place, near), look()),
        (
            grid_of(&place, |p| (255.0 * near(p)) as u8, Samples::U8),
            bytes,
        ),
    ];
    for (grid, look) in grids {
        let volume = Volume::Grid(grid.clone());
        let cut = Appearance {
            clip_planes: ClipPlane::of_box(&kept).to_vec(),
            ..look.clone()
        };
        for (level, storage, slicer) in [
            (0, Storage::Auto, Slicer::VertexProgram),
            (2, Storage::Auto, Slicer::VertexProgram),
            (4, Storage::Auto, Slicer::VertexProgram),
            (4, Storage::Bricks, Slicer::VertexProgram),
            (2, Storage::Auto, Slicer::Rays),
            (4, Storage::Bricks, Slicer::Rays),
        ] {
            let of = |traversal| SlicingOptions {
                slicer,
                level: Level::Fixed(level),
                slices_per_voxel: 1.0,
                brick_level: Level::Fixed(2),
                traversal,
                storage,
                ..Default::default()
            };
            let make = |traversal| {
                let options = of(traversal);
                Slicing::new(&gpu, &volume, &look, &options).expect("it fits")
            };
            let (mut cpu, mut device) = (make(Traversal::Cpu), make(Traversal::Gpu));
            for (name, view) in views(&grid) {
                for appearance in [&look, &cut] {
                    cpu.restyle(appearance).expect("it fits");
                    device.restyle(appearance).expect("it fits");
                    let cpu = cpu.render(&view).expect("drawn");
                    let device = device.render(&view).expect("drawn");
                    let context = format!("{name} level {level} {storage:?} {slicer:?}");
                    assert_eq!(bricks(&cpu), bricks(&device), "{context}");
                    // Where the device finds the boxes, rays are followed even if there are none.
                    let is_drawn = slicer != Slicer::Rays || bricks(&cpu)[0] > 0;
                    for counter in [VERTICES, FRAGMENTS].into_iter().filter(|_| is_drawn) {
                        assert_eq!(
                            cpu.stats.get(counter),
                            device.stats.get(counter),
                            "{context}"
                        );
                    }
                    assert_eq!(between(&cpu, &device).1, 0.0, "{context}");
                    let sent = device.stats.get(GEOMETRY_BYTES).expect("counted");
                    // The camera, for drawing and for culling, and eleven planes.
                    assert!(sent < 700, "{sent}");
                    if level == 4 && appearance.clip_planes.is_empty() {
                        let [drawn, skipped] = bricks(&device);
                        assert!(drawn > 20 && skipped > 20, "{context}: {drawn} {skipped}");
                    }
                }
            }
        }
    }
}

/// Streamed bricks are what the CPU asks for, so it finds the boxes.
#[test]
fn a_streamed_volume_is_traversed_by_the_cpu() {
    let Some(gpu) = testing::gpu("a_streamed_volume_is_traversed_by_the_cpu") else {
        return;
    };
    let grid = wave();
    let (_, view) = views(&grid).swap_remove(0);
    let options = SlicingOptions {
        memory_budget: 5 * 2 * 4 * 19_u64.pow(3),
        traversal: Traversal::Gpu,
        ..Default::default()
    };
    let frame = draw(&gpu, &grid, &look(), &options, &view);
    assert!(
        frame
            .stats
            .notes
            .iter()
            .any(|note| note.contains("streamed"))
    );
    assert!(shows(&frame) && bricks(&frame)[0] > 0);
    let both = SlicingOptions {
        slicer: Slicer::Cpu,
        ..options
    };
    assert!(both.validate().is_err());
}

/// Bytes are as `SlicingOptions::brick_level` says.
#[test]
fn bricks_take_their_samples_and_those_around_them() {
    let Some(gpu) = testing::gpu("bricks_take_their_samples_and_those_around_them") else {
        return;
    };
    let grid = grid_of(&cube(65), |_| 200_u8, Samples::U8);
    let (_, view) = views(&grid).swap_remove(0);
    let of = |integration, brick_level| SlicingOptions {
        storage: Storage::Bricks,
        integration,
        brick_level: Level::Fixed(brick_level),
        ..Default::default()
    };
    let takes = |options: &SlicingOptions, samples: u64| {
        let frame = draw(&gpu, &grid, &look(), options, &view);
        // Rays look into a table with 8 bytes for each box.
        let resident = frame.stats.bytes_resident - 8 * bricks(&frame).iter().sum::<u64>();
        // A hundredth for slots at the ends of rows; the transfer function has at most four
        // intervals of at most 64 bytes.
        let range = samples..=samples + samples / 100 + 256;
        assert!(range.contains(&resident), "{resident}, {range:?}");
    };
    takes(&SlicingOptions::default(), 65 * 65 * 65);
    for (level, side) in [(1, 32_u64), (2, 16), (3, 8)] {
        let bricks = 1_u64 << (3 * level);
        for (integration, around) in [(Integration::PostClassified, 1), (Integration::Slabs, 3)] {
            takes(&of(integration, level), bricks * (side + around).pow(3));
        }
    }
}
