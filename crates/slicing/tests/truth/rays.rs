//! Slabs of rays, one behind the other, against the same slabs in polygons.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::{
    Appearance, Bounds, ClipPlane, DepthCue, Frame, Grid, Isosurface, OpticalModel,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_slicing::counters::{BRICKS_DRAWN, VERTICES};
use tetrascope_slicing::{
    Crossing, Filtering, Gradient, Integration, Level, Shading, SlabEnds, Slicer, Slicing,
    SlicingOptions, StepLength, Storage, Traversal,
};

use crate::support::*;

/// A wave that is transparent in about half of the volume.
fn wave(place: &Place) -> Grid {
    grid(place, |p| {
        let p = (p - place.origin) / place.spacing / place.dims[0] as f64;
        (7.0 * p.x + 2.0 * p.y).sin() * (6.0 * p.y - 3.0 * p.z).cos()
    })
}

/// The wave with samples that are missing.
fn torn(place: &Place) -> Grid {
    let whole = wave(place);
    let Samples::F32(mut samples) = whole.samples().clone() else {
        panic!("made of floats");
    };
    samples.iter_mut().step_by(37).for_each(|s| *s = f32::NAN);
    Grid::on(*whole.lattice(), Samples::F32(samples)).expect("as many")
}

/// The wave, of which less and less is there.
fn faded(place: &Place) -> Grid {
    let count: usize = place.dims.iter().product();
    let shares = (0..count).map(|i| (i % 997) as f32 / 996.0).collect();
    wave(place).covered(shares).expect("shares")
}

/// Clip planes and a depth cue.
fn with_all(look: Appearance, grid: &Grid) -> Appearance {
    let (low, size) = (grid.bounds().min, grid.bounds().size());
    let kept = Bounds {
        min: low + DVec3::new(-0.5, 0.2, 0.1) * size,
        max: low + DVec3::new(0.9, 2.0, 0.8) * size,
    };
    Appearance {
        clip_planes: ClipPlane::of_box(&kept).to_vec(),
        depth_cue: Some(DepthCue { strength: 0.7 }),
        ..look
    }
}

/// The same pictures by rays and by polygons, for each view.
fn both(
    gpu: &Gpu,
    grid: &Grid,
    look: &Appearance,
    options: &SlicingOptions,
    views: &[View],
) -> Vec<[Frame; 2]> {
    let drawn = |slicer| {
        let options = SlicingOptions {
            slicer,
            ..options.clone()
        };
        let volume = Volume::Grid(grid.clone());
        let slicing = Slicing::new(gpu, &volume, look, &options).expect("the grid fits");
        let draw = |view| slicing.render(view).expect("the view is valid");
        views.iter().map(draw).collect::<Vec<Frame>>()
    };
    let pairs = drawn(Slicer::Rays)
        .into_iter()
        .zip(drawn(Slicer::VertexProgram));
    pairs.map(|(rays, polygons)| [rays, polygons]).collect()
}

/// That both pictures have the same slabs, which are added up in another order.
///
/// Each slab has the same bits in both. A sum of n parts is rounded n times, by 2⁻²⁴ of what it is
/// at most; light is also multiplied by opacities or by what they leave, n times in polygons, or once
/// by an exponential of a depth that is such a sum itself, which devices round by up to 2⁻²⁰ (llvmpipe
/// below a depth of 24). The greatest is not rounded at all.
fn assert_same_slabs(
    [rays, polygons]: &[Frame; 2],
    model: OpticalModel,
    slabs: u32,
    context: &str,
) {
    let (_, off) = between(rays, polygons);
    let most = polygons
        .pixels
        .iter()
        .flatten()
        .fold(1.0_f32, |a, b| a.max(b.abs()));
    let rounding = match model {
        OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => 0.0,
        _ => f64::from(most) * (4.0 * f64::from(slabs) * 2_f64.powi(-24) + 2_f64.powi(-20)),
    };
    assert!(off <= rounding, "{context}: {off:e}, {rounding:e}");
}

/// A bound of the slabs that a ray crosses: the lattice's diagonal, twice for rays that are longer
/// between planes than the optical axis.
fn slabs(grid: &Grid, options: &SlicingOptions) -> u32 {
    let least = grid.spacing().min_element();
    (2.0 * grid.bounds().diagonal() / least * options.slices_per_voxel).ceil() as u32
}

/// Every optical model, with everything that a slab depends on.
#[test]
fn rays_have_the_slabs_of_polygons() {
    let Some(gpu) = testing::gpu("rays_have_the_slabs_of_polygons") else {
        return;
    };
    let of = |change: fn(&mut SlicingOptions)| {
        let mut options = SlicingOptions {
            slices_per_voxel: 1.0,
            ..Default::default()
        };
        change(&mut options);
        options
    };
    let settings: [(&str, SlicingOptions); 8] = [
        ("slabs", of(|_| ())),
        ("two", of(|o| o.slices_per_voxel = 2.3)),
        ("half", of(|o| o.slices_per_voxel = 0.5)),
        (
            "classified",
            of(|o| o.integration = Integration::PostClassified),
        ),
        ("whole", of(|o| o.slab_ends = SlabEnds::Whole)),
        ("planar", of(|o| o.step_length = StepLength::Planar)),
        ("filtered", of(|o| o.filtering = Filtering::Hardware)),
        (
            "lit",
            of(|o| o.shading = Shading::Phong(Default::default())),
        ),
    ];
    for (kind, grid) in [
        ("whole", wave(&cube(24))),
        ("skewed", wave(&skewed())),
        ("torn", torn(&cube(24))),
        ("faded", faded(&cube(24))),
    ] {
        for (setting, options) in &settings {
            if kind == "faded" && options.shading != Shading::None {
                continue;
            }
            for model in OpticalModel::VOLUMETRIC {
                let plain = appearance(&ramp(9.0), model);
                for look in [plain.clone(), with_all(plain, &grid)] {
                    let (names, views): (Vec<_>, Vec<_>) = views(&grid).into_iter().unzip();
                    let frames = both(&gpu, &grid, &look, options, &views);
                    for (name, frames) in names.into_iter().zip(frames) {
                        let context = format!("{kind} {setting} {model:?} {name}");
                        let dark = model == OpticalModel::Absorption;
                        assert!(dark || shows(&frames[0]), "{context}");
                        assert_same_slabs(&frames, model, slabs(&grid, options), &context);
                    }
                }
            }
        }
    }
}

/// The first surface on a ray is the last that polygons draw, to the last bit.
#[test]
fn rays_meet_the_surfaces_of_polygons() {
    let Some(gpu) = testing::gpu("rays_meet_the_surfaces_of_polygons") else {
        return;
    };
    for (kind, grid) in [("whole", wave(&cube(24))), ("torn", torn(&skewed()))] {
        let mut look = appearance(&ramp(1.0), OpticalModel::Isosurfaces);
        look.isosurfaces = [(0.3, DVec3::X), (-0.2, DVec3::Y)]
            .map(|(value, color)| Isosurface { value, color })
            .to_vec();
        for look in [look.clone(), with_all(look, &grid)] {
            for crossing in [Crossing::Cells, Crossing::Corrected, Crossing::Linear] {
                for gradient in [Gradient::Trilinear, Gradient::CentralDifferences] {
                    let options = SlicingOptions {
                        crossing,
                        gradient,
                        level: Level::Fixed(1),
                        ..Default::default()
                    };
                    let (names, views): (Vec<_>, Vec<_>) = views(&grid).into_iter().unzip();
                    let frames = both(&gpu, &grid, &look, &options, &views);
                    for (name, frames) in names.into_iter().zip(frames) {
                        let context = format!("{kind} {crossing:?} {gradient:?} {name}");
                        assert!(shows(&frames[0]), "{context}");
                        assert_same_slabs(&frames, OpticalModel::Isosurfaces, 0, &context);
                        let depths = frames.map(|f| f.depths.expect("of surfaces"));
                        assert_eq!(depths[0], depths[1], "{context}");
                    }
                }
            }
        }
    }
}

/// Saw teeth of so many knots.
fn teeth(count: usize) -> TransferFunction {
    let knots = (0..count).map(|i| {
        let share = i as f64 / (count - 1) as f64;
        knot(share, [share, 0.5, 1.0 - share], 6.0 * (i % 2) as f64)
    });
    TransferFunction::new(knots.collect()).expect("sorted")
}

/// With more knots a fragment takes fewer slabs, and a ray is drawn in more of them.
#[test]
fn a_ray_is_drawn_in_runs() {
    let Some(gpu) = testing::gpu("a_ray_is_drawn_in_runs") else {
        return;
    };
    let grid = wave(&cube(24));
    let options = SlicingOptions::default();
    // For each view.
    let mut fewer = [0; 2];
    for knots in [3, 3000, 16_000] {
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
            let look = appearance(&teeth(knots), model);
            let small = |(name, view)| {
                let (width, height) = (16, 16);
                (
                    name,
                    View {
                        width,
                        height,
                        ..view
                    },
                )
            };
            let (names, views): (Vec<_>, Vec<_>) = views(&grid).into_iter().map(small).unzip();
            let frames = both(&gpu, &grid, &look, &options, &views);
            for ((name, frames), fewer) in names.into_iter().zip(frames).zip(&mut fewer) {
                let context = format!("{knots} {model:?} {name}");
                assert!(shows(&frames[0]), "{context}");
                assert_same_slabs(&frames, model, slabs(&grid, &options), &context);
                let runs = frames[0].stats.get(VERTICES).expect("counted") / 3;
                assert!(runs >= *fewer, "{context}: {runs}");
                assert!((knots == 3) == (runs == 1), "{context}: {runs}");
                *fewer = runs;
            }
        }
    }
}

/// The same boxes show, whoever finds them and however samples are stored.
#[test]
fn rays_look_into_the_boxes_that_show() {
    let Some(gpu) = testing::gpu("rays_look_into_the_boxes_that_show") else {
        return;
    };
    let grid = wave(&cube(70));
    let look = appearance(&ramp(6.0), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&grid) {
        let of = |level, storage, traversal| {
            let options = SlicingOptions {
                level: Level::Fixed(level),
                brick_level: Level::Fixed(2),
                storage,
                traversal,
                ..Default::default()
            };
            draw(&gpu, &grid, &look, &options, &view)
        };
        let whole = of(0, Storage::Auto, Traversal::Cpu);
        assert_eq!(whole.stats.get(BRICKS_DRAWN), Some(1), "{name}");
        for storage in [Storage::Auto, Storage::Bricks] {
            for traversal in [Traversal::Cpu, Traversal::Gpu] {
                let boxes = of(3, storage, traversal);
                assert_eq!(
                    between(&whole, &boxes).1,
                    0.0,
                    "{name} {storage:?} {traversal:?}"
                );
                let drawn = boxes.stats.get(BRICKS_DRAWN).expect("counted");
                assert!((1..512).contains(&drawn), "{name}: {drawn}");
            }
        }
    }
}

/// A streamed volume is drawn in polygons, and says so.
#[test]
fn a_streamed_volume_is_drawn_in_polygons() {
    let Some(gpu) = testing::gpu("a_streamed_volume_is_drawn_in_polygons") else {
        return;
    };
    let grid = wave(&cube(65));
    let look = appearance(&ramp(6.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&grid).swap_remove(0);
    let options = SlicingOptions {
        // Bricks of 19 samples per side and of 4 bytes; five of 64 at a time.
        memory_budget: 5 * 2 * 4 * 19_u64.pow(3),
        ..Default::default()
    };
    let [frames] = &both(&gpu, &grid, &look, &options, &[view])[..] else {
        panic!("one for the view");
    };
    assert_eq!(between(&frames[0], &frames[1]).1, 0.0);
    let says = |frame: &Frame| {
        frame
            .stats
            .notes
            .iter()
            .any(|note| note.contains("polygons"))
    };
    assert!(says(&frames[0]) && !says(&frames[1]));
}
