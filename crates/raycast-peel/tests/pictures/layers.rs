//! Peeled layers against lists of boundary faces: the same bits.

use tetrascope_core::{
    Appearance, Camera, CameraFit, Error, Frame, OpticalModel, Projection, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_gpu::{Draw as _, Gpu, Target};
use tetrascope_raycast_peel::counters::{CELL_VISITS, LAYERS, LOST_RAYS, PATHS, UNPAIRED_FACES};
use tetrascope_raycast_peel::{Entries, Locality, RaycastOptions, RaycastPeel};
use tetrascope_testing::{
    self as testing, angular_sector, cells, cutting, fitted, inside, liquid_oxygen_post,
    mismatched, ramp, stacked_plates, super_phoenix, surfaces, tilted, view,
};

use crate::common::{draw, renderer, scene};

const SIDE: u32 = 32;

fn views(volume: &Volume) -> [(&'static str, View); 5] {
    let inside = inside(volume);
    // Rays that begin beside the view's middle pass the mesh hundreds of units from their anchors.
    let wide = Camera {
        projection: Projection::Perspective { view_angle: 179.9 },
        ..inside
    };
    // Along the lattice, where many rays run in faces and tie.
    let along = fitted(volume, CameraFit::PlusX, true, SIDE);
    let outside = fitted(volume, CameraFit::PlusIso, false, SIDE);
    [
        ("outside", outside),
        ("along the lattice", along),
        ("inside", view(inside, SIDE)),
        ("orthographic, inside", view(cutting(volume), SIDE)),
        ("wide", view(wide, SIDE)),
    ]
}

/// By lists and by layers.
struct Both([RaycastPeel; 2]);

impl Both {
    fn new(gpu: &Gpu, volume: &Volume, appearance: &Appearance, options: &RaycastOptions) -> Both {
        Both([Entries::TileLists, Entries::PeeledLayers].map(|entries| {
            let options = RaycastOptions {
                entries,
                ..*options
            };
            renderer(gpu, volume, appearance, &options)
        }))
    }

    /// Draws both ways, and compares every bit and all that is counted of rays. Returns the
    /// frame by layers.
    fn compare(&self, what: &str, view: &View) -> Frame {
        let draw = |renderer: &RaycastPeel| renderer.render(view).expect("a frame");
        let [lists, layers] = self.0.each_ref().map(draw);
        let bits = |frame: &Frame| frame.pixels.iter().flatten().map(|c| c.to_bits()).collect();
        let [a, b]: [Vec<u32>; 2] = [&lists, &layers].map(bits);
        let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "{what}: channels that differ");
        assert_eq!(lists.depths, layers.depths, "{what}");
        let counted = |frame: &Frame| {
            let stats = &frame.stats;
            [
                stats.get(UNPAIRED_FACES),
                stats.get(LOST_RAYS),
                stats.get(PATHS),
                stats.get(CELL_VISITS),
            ]
        };
        assert_eq!(counted(&lists), counted(&layers), "{what}");
        assert_eq!(layers.stats.get(LOST_RAYS), Some(0), "{what}");
        assert_eq!(lists.stats.get(LAYERS), None, "{what}");
        layers
    }
}

fn check(gpu: &Gpu, name: &str, volume: &Volume, appearance: &Appearance) {
    let clipped = Appearance {
        clip_planes: tilted(volume),
        ..appearance.clone()
    };
    let looks = [
        ("whole", appearance.clone()),
        ("clipped", clipped),
        ("isosurfaces", surfaces(volume, appearance.clone())),
    ];
    for (look, appearance) in looks {
        let both = Both::new(gpu, volume, &appearance, &RaycastOptions::default());
        for (from, view) in views(volume) {
            let what = format!("{name}, {look}, {from}");
            let frame = both.compare(&what, &view);
            let layers = frame.stats.get(LAYERS).expect("counted");
            // Clears, these layers, one that is empty and so known to be the last, the march, and
            // what puts it over the background.
            assert_eq!(frame.stats.passes, 1 + layers + 1 + 1 + 1, "{what}");
        }
    }
}

#[test]
fn layers_give_the_bits_of_lists() {
    let Some(gpu) = testing::gpu("layers_give_the_bits_of_lists") else {
        return;
    };
    for (name, cells) in [
        ("sphere", 3000),
        ("heat-sink", 2000),
        ("torus", 2000),
        ("delaunay", 1000),
        ("graded", 2000),
        ("staircase", 23),
    ] {
        let (volume, appearance) = scene(name, cells);
        check(&gpu, name, &volume, &appearance);
    }
    // A sphere is convex: one way in, one out.
    let (volume, appearance) = scene("sphere", 3000);
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let options = RaycastOptions {
        entries: Entries::PeeledLayers,
        ..RaycastOptions::default()
    };
    let frame = draw(&gpu, &volume, &appearance, &options, &view);
    assert_eq!((frame.stats.get(LAYERS), frame.stats.passes), (Some(2), 6));
}

/// Nested and touching boundaries, early termination, and integers that decide.
#[test]
fn layers_give_the_bits_of_lists_on_data() {
    let test = "layers_give_the_bits_of_lists_on_data";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let options = RaycastOptions {
        integer_sides: true,
        stop_opacity: 0.95,
        ..RaycastOptions::default()
    };
    let meshes = [
        ("spx", super_phoenix(test)),
        ("post", liquid_oxygen_post(test)),
        ("sector", angular_sector(test)),
    ];
    for (name, mesh) in meshes {
        let Some(mesh) = mesh else { continue };
        let volume = Volume::Mesh(mesh);
        check(&gpu, name, &volume, &ramp(&volume));
        let both = Both::new(&gpu, &volume, &ramp(&volume), &options);
        for (from, view) in views(&volume) {
            both.compare(&format!("{name}, {from}, integers"), &view);
        }
    }
}

/// All but the outermost faces are in pairs of one place, where t ties and the faces decide.
#[test]
fn faces_in_one_place_are_all_peeled() {
    let Some(gpu) = testing::gpu("faces_in_one_place_are_all_peeled") else {
        return;
    };
    let volume = mismatched(5);
    let both = Both::new(&gpu, &volume, &ramp(&volume), &RaycastOptions::default());
    let mut most = 0;
    for (from, view) in views(&volume) {
        let frame = both.compare(from, &view);
        most = most.max(frame.stats.get(LAYERS).expect("counted"));
    }
    // Rays cross several cubes.
    assert!(most >= 6, "{most}");
}

/// Where depths cannot tell two entries of overlapping cells apart, lists do not either: the faces
/// decide. Rays meet the second cell first, by 2e-10, in the plane of their anchors.
#[test]
fn entries_a_hair_apart_are_in_one_order() {
    let Some(gpu) = testing::gpu("entries_a_hair_apart_are_in_one_order") else {
        return;
    };
    let mut points = Vec::new();
    for z in [1e-10, -1e-10] {
        points.extend([
            [-0.9, -0.9, z],
            [0.9, -0.9, z],
            [0.0, 0.9, z],
            [0.0, 0.0, 1.0],
        ]);
    }
    // And one that puts the mesh's center where that plane is.
    points.extend([
        [-1.0, -1.0, -1.0],
        [1.0, -1.0, -1.0],
        [0.0, 1.0, -1.0],
        [0.0, 0.0, -0.9],
    ]);
    let values = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5];
    let each = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]];
    let volume = cells(&points, &each, &values);
    let options = RaycastOptions {
        locality: Locality::AsGiven,
        ..RaycastOptions::default()
    };
    let both = Both::new(&gpu, &volume, &ramp(&volume), &options);
    let view = fitted(&volume, CameraFit::MinusZ, true, SIDE);
    let frame = both.compare("overlapping", &view);
    assert_eq!(frame.stats.get(LAYERS), Some(6));
}

/// More layers than memory is spent on: a ray in all of them searches lists.
#[test]
fn rays_in_more_layers_than_there_are_lose_none() {
    let Some(gpu) = testing::gpu("rays_in_more_layers_than_there_are_lose_none") else {
        return;
    };
    // 2, 14, 16 and 18 crossings, and as many as make lists search twice.
    for (plates, layers) in [(1, 2), (7, 14), (8, 16), (9, 16), (20, 16)] {
        let volume = stacked_plates(plates);
        let mut appearance = ramp(&volume);
        appearance.optical_model = OpticalModel::Emission;
        let both = Both::new(&gpu, &volume, &appearance, &RaycastOptions::default());
        for (from, view) in views(&volume) {
            let what = format!("{plates} plates, {from}");
            let frame = both.compare(&what, &view);
            if from == "outside" {
                assert_eq!(frame.stats.get(LAYERS), Some(layers), "{what}");
            }
        }
    }
}

#[test]
fn layers_are_not_recorded_for_others() {
    let Some(gpu) = testing::gpu("layers_are_not_recorded_for_others") else {
        return;
    };
    let (volume, appearance) = scene("sphere", 100);
    let options = RaycastOptions {
        entries: Entries::PeeledLayers,
        ..RaycastOptions::default()
    };
    let renderer = renderer(&gpu, &volume, &appearance, &options);
    let view = fitted(&volume, CameraFit::PlusX, false, 8);
    let usage = tetrascope_gpu::wgpu::TextureUsages::RENDER_ATTACHMENT;
    let format = tetrascope_gpu::wgpu::TextureFormat::Rgba32Float;
    let image = gpu.texture("image", (8, 8), format, usage).expect("small");
    let image = image.create_view(&Default::default());
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let refused = renderer.encode(&mut encoder, &view, &Target::new(&image, format));
    assert!(matches!(refused, Err(Error::Unsupported { .. })));
}
