//! Frames of many small dispatches against those of one: the same bits.

use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Appearance, Camera, CameraFit, ClipPlane, DepthCue, Frame, Isosurface, Knot, Projection,
    Scalars, TetMesh, TransferFunction, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Draw as _;
use tetrascope_testing as testing;

use super::super::{budget::Budget, view_of};
use super::*;
use crate::RaycastPeel;
use crate::{Entries, Integration, RaycastOptions};

/// A dispatch looks at forty boundary faces and takes each ray through up to eight cells.
const TINY: Budget = Budget {
    first_entries: 40,
    first_cells: 1,
    entries: 2,
    cells: 1,
    later: 0,
    passes_per_cell: 3,
};

/// A few batches in each dispatch, none of which is done with a search.
const SMALL: Budget = Budget {
    first_entries: 7,
    first_cells: 3,
    entries: 5,
    cells: 2,
    later: 400,
    passes_per_cell: 3,
};

impl Single {
    /// Draws in several dispatches from the first frame on, each bounded by `budget`.
    fn with(mut self, budget: Budget) -> Single {
        let names = budget.constants().map(|(name, _)| name);
        let constants = &mut self.style.constants;
        constants.retain(|(name, _)| !names.contains(name));
        constants.extend(budget.constants());
        self.is_long.store(true, Ordering::Relaxed);
        self
    }
}

/// `count` blocks of five tetrahedra in a row along z, whose scalars go up and down; `apart`, or
/// each beginning where the last one ends, without sharing its points.
fn blocks(count: u32, apart: f64) -> TetMesh {
    let mut points = Vec::new();
    let mut cells = Vec::new();
    let mut values = Vec::new();
    for block in 0..count {
        let first = points.len() as u32;
        for corner in 0..8_u32 {
            let at = [corner & 1, corner >> 1 & 1, corner >> 2].map(f64::from);
            let z = (f64::from(block) * (1.0 + apart) + at[2]) / f64::from(count);
            points.push(DVec3::new(at[0], at[1], z));
            values.push((2.3 * f64::from(block) + 1.1 * at[0] + 0.7 * at[1] - at[2]).sin());
        }
        for cell in [
            [0, 1, 2, 4],
            [1, 3, 2, 7],
            [1, 4, 5, 7],
            [2, 4, 6, 7],
            [1, 2, 4, 7],
        ] {
            cells.push(cell.map(|i| first + i));
        }
    }
    TetMesh::from_tetrahedra(points, cells, field(Association::Point, values)).expect("a mesh")
}

fn field(association: Association, values: Vec<f64>) -> Scalars {
    Scalars {
        name: "s".into(),
        association,
        values,
    }
}

/// An appearance of many intervals, deep in some, with steps.
fn appearance(mesh: &TetMesh, model: OpticalModel) -> Appearance {
    let length = mesh.bounds().size().max_element();
    let knots = (0..40).map(|i| Knot {
        scalar: f64::from(i / 2) / 9.5 - 1.0,
        color: DVec3::new(0.5 + 0.5 * f64::from(i).sin(), 0.4, 0.02 * f64::from(i)),
        extinction: f64::from(i % 7) / length,
    });
    let function = TransferFunction::new(knots.collect()).expect("valid knots");
    Appearance::new(function, model)
}

fn seen(mesh: &TetMesh, from: CameraFit, orthographic: bool) -> View {
    View {
        camera: Camera::fit(&mesh.bounds(), from, orthographic, 1.0),
        width: 20,
        height: 12,
        background: [0.1, 0.2, 0.3, 0.5],
    }
}

fn bits(frame: &Frame) -> Vec<u32> {
    let depths = frame.depths.iter().flatten();
    let all = frame.pixels.iter().flatten().chain(depths);
    all.map(|x| x.to_bits()).collect()
}

#[test]
fn many_dispatches_draw_the_bits_of_one() {
    let Some(gpu) = testing::gpu("many_dispatches_draw_the_bits_of_one") else {
        return;
    };
    let emission = OpticalModel::EmissionAbsorption;
    let apart = blocks(10, 0.3);
    let touching = blocks(6, 0.0);
    let count = apart.points().len();
    let smooth = field(
        Association::Point,
        (0..count).map(|i| i as f64 / count as f64).collect(),
    );
    let smooth = apart.with_scalars(smooth).expect("as many");
    let per_cell = (0..touching.cell_count())
        .map(|c| (c as f64).sin())
        .collect();
    let per_cell = touching
        .with_scalars(field(Association::Cell, per_cell))
        .expect("as many");
    let styled = |mesh: &TetMesh, model| appearance(mesh, model);
    let exact = RaycastOptions::default();
    let layered = RaycastOptions {
        entries: Entries::PeeledLayers,
        ..exact
    };
    let cut = Appearance {
        depth_cue: Some(DepthCue { strength: 0.7 }),
        clip_planes: vec![ClipPlane {
            point: apart.bounds().center() + DVec3::new(0.1, 0.2, -0.3),
            normal: DVec3::new(0.2, 0.1, 1.0),
        }],
        ..styled(&apart, emission)
    };
    let surfaces = Appearance {
        isosurfaces: [-0.3, 0.6]
            .map(|value| Isosurface {
                value,
                color: DVec3::ONE,
            })
            .into(),
        ..styled(&smooth, OpticalModel::Isosurfaces)
    };
    let table = RaycastOptions {
        integration: Integration::Table3d { n: 8 },
        ..exact
    };
    let stopping = RaycastOptions {
        stop_opacity: 0.6,
        ..exact
    };
    for (name, mesh, appearance, options) in [
        ("apart", &apart, styled(&apart, emission), exact),
        (
            "layers",
            &apart,
            styled(&apart, OpticalModel::Emission),
            layered,
        ),
        ("cut and cued", &apart, cut, exact),
        ("surfaces", &smooth, surfaces, exact),
        ("table", &smooth, styled(&smooth, emission), table),
        ("jumping", &touching, styled(&touching, emission), stopping),
        (
            "cells",
            &per_cell,
            styled(&per_cell, OpticalModel::MaximumIntensity),
            exact,
        ),
    ] {
        let volume = Volume::Mesh(mesh.clone());
        let new = || Single::new(&gpu, &volume, &appearance, &options).expect("a mesh");
        let single = RaycastPeel::with(&gpu, new());
        let mut inside = seen(mesh, CameraFit::PlusZ, false);
        inside.camera.position = mesh.bounds().center() + DVec3::new(0.1, 0.2, 0.1);
        inside.camera.projection = Projection::Perspective { view_angle: 70.0 };
        let views = [
            ("along", seen(mesh, CameraFit::PlusZ, true)),
            ("inside", inside),
            ("across", seen(mesh, CameraFit::PlusX, false)),
        ];
        let expected = views.map(|(_, view)| single.render(&view).expect("a frame"));
        let budgets = match name {
            "apart" => &[TINY, SMALL][..],
            _ => &[TINY],
        };
        for &budget in budgets {
            let single = RaycastPeel::with(&gpu, new().with(budget));
            for ((from, view), expected) in views.iter().zip(&expected) {
                let what = format!("{name}, {from}, {budget:?}");
                let frame = single.render(view).expect("a frame");
                assert!(expected.stats.get(PATHS) > Some(0), "{what}");
                let more = frame.stats.passes > expected.stats.passes;
                assert!(more || *from != "along", "{what}");
                let (got, wanted) = (bits(&frame), bits(expected));
                let differ = got.iter().zip(&wanted).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "{what}: {differ} numbers");
                let counted = |frame: &Frame| {
                    let stats = &frame.stats;
                    [
                        stats.get(CELL_VISITS),
                        stats.get(PATHS),
                        stats.get(LOST_RAYS),
                    ]
                };
                assert_eq!(counted(&frame), counted(expected), "{what}");
                assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{what}");
                assert_eq!(frame.stats.get(UNPAIRED_FACES), Some(0), "{what}");
            }
        }
    }
}

/// A ray that is given up is counted and spoken of, in a frame and by those who record.
#[test]
fn rays_that_are_given_up_are_counted() {
    let Some(gpu) = testing::gpu("rays_that_are_given_up_are_counted") else {
        return;
    };
    let mesh = blocks(30, 0.5);
    let volume = Volume::Mesh(mesh.clone());
    let appearance = appearance(&mesh, OpticalModel::EmissionAbsorption);
    let options = RaycastOptions::default();
    let new = || Single::new(&gpu, &volume, &appearance, &options).expect("a mesh");
    let view = seen(&mesh, CameraFit::PlusZ, true);
    let expected = RaycastPeel::with(&gpu, new())
        .render(&view)
        .expect("a frame");
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let size = (view.width, view.height);
    let image = gpu.texture("image", size, TextureFormat::Rgba32Float, usage);
    let image = image.expect("small");
    let target = view_of(&image);
    let target = Target::new(&target, image.format());
    let recorded = |single: Single| {
        let renderer = RaycastPeel::with(&gpu, single);
        let mut encoder = new_encoder(&gpu);
        let recorded = renderer.encode(&mut encoder, &view, &target);
        let pixels = read_back(&gpu, &mut encoder, Source::Texture(&image)).expect("small");
        gpu.finish(encoder).expect("runs");
        let stats = recorded.expect("recorded").statistics().expect("read");
        let pixels: Vec<[f32; 4]> = pixels.read().expect("read");
        (stats, pixels)
    };
    let (stats, pixels) = recorded(new());
    assert_eq!(stats.get(LOST_RAYS), Some(0));
    assert_eq!(stats.get(PATHS), expected.stats.get(PATHS));
    assert!(pixels == expected.pixels);
    // Too few for any of them.
    let (stats, pixels) = recorded(new().with(TINY));
    assert!(stats.get(LOST_RAYS) > Some(0), "{stats:?}");
    assert!(pixels != expected.pixels);
    let single = new().with(TINY);
    let rays = Rays::new(&view, &single.mesh.normalization);
    let found = Found::Lists(single.lists(&view, &rays).expect("few"));
    let found = single.trees(&view, &rays, found).expect("few");
    let canvas = Canvas::new(&gpu).expect("one texel");
    let sums = canvas.sums(&view, single.sums_kind()).expect("small");
    let (ends, has_ends) = canvas
        .ends(
            &mut new_encoder(&gpu),
            &view,
            &single.mesh.normalization,
            0.0,
            None,
        )
        .expect("none");
    let targets = Targets {
        sums: &sums,
        ends: &ends,
        has_ends,
    };
    let cast = Cast::new(&single, &view, &rays, &found, &targets, true).expect("a cast");
    let left = single.finish(&cast, &mut 0, 2).expect("runs");
    assert!(left > 0);
    let mut encoder = new_encoder(&gpu);
    let bytes = size_of::<Counters>() as u64;
    let counters = read_back(&gpu, &mut encoder, Source::Buffer(&cast.counters, bytes));
    gpu.finish(encoder).expect("runs");
    let mut counters: Counters = one(counters.expect("small")).expect("read");
    assert_eq!(counters.rays_left, left);
    counters.lost_rays = 3;
    let mut stats = FrameStats::default();
    counters.count(&mut stats);
    assert_eq!(stats.get(LOST_RAYS), Some(u64::from(left) + 3));
    assert!(stats.notes[0].starts_with(&format!("{left} rays were given up")));
    assert!(stats.notes[1].starts_with("3 rays came out"));
}
