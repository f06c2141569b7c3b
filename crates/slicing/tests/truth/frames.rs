//! What a frame takes: fragments, vertices, bytes; and that it shows the same, whoever
//! cuts boxes.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Bounds, Camera, CameraFit, ClipPlane, Frame, Grid, OpticalModel, Projection, View,
};
use tetrascope_gpu::testing;
use tetrascope_slicing::{Level, PlaneTest, Slicer, SlicingOptions, Storage};

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
    [stats.bricks_drawn, stats.bricks_skipped].map(|count| count.expect("counted"))
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
            // Bricks of 19 samples a side and of 4 bytes; five of 64 at a time.
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
                let bytes = [&vertex, &cpu].map(|f| f.stats.geometry_bytes.expect("counted"));
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
        let vertices = frame.stats.vertices.expect("counted");
        assert!(
            vertices >= 6 * slabs && vertices <= 6 * (slabs + 4),
            "{vertices}"
        );
        let cpu = draw(&gpu, &full, &look(), &of(Slicer::Cpu), &view);
        assert_eq!(cpu.stats.vertices, Some(4 * slabs));

        let Some(fragments) = frame.stats.fragments else {
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
