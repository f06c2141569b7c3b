//! Rays with many crossings or many cells, against the ground truth and against the clock that
//! devices have: no dispatch may end a ray.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Cells, Knot, OpticalModel, Projection, TetMesh,
    TransferFunction, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::counters::{CELL_VISITS, LOST_RAYS, PATHS};
use tetrascope_raycast_peel::{Entries, Locality, Passes, RaycastOptions};
use tetrascope_testing::{
    self as testing, ImageError, data_set, fitted, jumping, scale, split, truth, view,
};

use crate::common::{draw, renderer};

const SIDE: u32 = 24;

/// The same numbers in each run.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }
}

/// `count` tetrahedra behind each other along z, none of which touches another.
fn tetrahedra(count: u32) -> Volume {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut points = Vec::new();
    for body in 0..count {
        let z = f64::from(body);
        for [x, y, up] in [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.1],
            [0.2, 1.0, 0.2],
            [0.4, 0.4, 0.6],
        ] {
            let mut jitter = || 0.1 * random.next();
            let at = DVec3::new(x + jitter(), y + jitter(), z + up + jitter());
            points.push(
                at * f64::from(count).recip() * DVec3::new(f64::from(count), f64::from(count), 1.0),
            );
        }
    }
    let cells = (0..count).map(|body| [0, 1, 2, 3].map(|i| 4 * body + i));
    let values = points.iter().map(|_| random.next()).collect();
    let mesh = TetMesh::from_tetrahedra(points, cells.collect(), testing::point_scalars(values));
    Volume::Mesh(mesh.expect("a mesh"))
}

/// The same of hexahedra.
fn hexahedra(count: u32) -> Volume {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut points = Vec::new();
    let mut cells = Cells::default();
    cells.offsets.push(0);
    for body in 0..u64::from(count) {
        for [x, y, up] in [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 0.6],
            [1.0, 0.0, 0.6],
            [1.0, 1.0, 0.6],
            [0.0, 1.0, 0.6],
        ] {
            // All corners of a face stay in its plane.
            points.push(DVec3::new(x, y, (body as f64 + up) / f64::from(count)));
        }
        cells.connectivity.extend(8 * body..8 * body + 8);
        cells.types.push(12);
        cells.offsets.push(8 * (body + 1));
    }
    let values = points.iter().map(|_| random.next()).collect();
    let mesh = TetMesh::new(points, &cells, testing::point_scalars(values));
    Volume::Mesh(mesh.expect("a mesh"))
}

/// `count` shells of octahedra around one center, each a layer of wedges, none touching another.
fn shells(count: u32) -> Volume {
    let mut points = Vec::new();
    let mut cells = Cells::default();
    cells.offsets.push(0);
    let axes = [
        DVec3::X,
        DVec3::Y,
        DVec3::NEG_X,
        DVec3::NEG_Y,
        DVec3::Z,
        DVec3::NEG_Z,
    ];
    for shell in 0..u64::from(count) {
        let first = points.len() as u64;
        for radius in [1.0 + shell as f64, 1.7 + shell as f64] {
            points.extend(axes.map(|axis| radius * axis));
        }
        for side in 0..4 {
            for pole in [4, 5] {
                let face = [side, (side + 1) % 4, pole];
                cells.connectivity.extend(face.map(|i| first + i));
                cells.connectivity.extend(face.map(|i| first + 6 + i));
                cells.types.push(13);
                cells.offsets.push(cells.connectivity.len() as u64);
            }
        }
    }
    let values = points.iter().map(|p| (1.3 * p.x + p.y - 0.7 * p.z).sin());
    let values = values.collect();
    let mesh = TetMesh::new(points, &cells, testing::point_scalars(values));
    Volume::Mesh(mesh.expect("a mesh"))
}

/// A function over the range of `volume` through which a ray along all of it has an optical
/// depth of a few.
fn thin(volume: &Volume, model: OpticalModel) -> Appearance {
    through(volume, model, [1.0, 6.0, 2.0])
}

/// A function over the range of `volume` with these optical depths of all of it, were its least,
/// middle and greatest scalar everywhere.
fn through(volume: &Volume, model: OpticalModel, depths: [f64; 3]) -> Appearance {
    let (low, high) = volume.scalar_range().expect("scalars");
    let length = volume.bounds().size().z;
    let knot = |share: f64, color: [f64; 3], depth: f64| Knot {
        scalar: low + share * (high - low),
        color: color.into(),
        extinction: depth / length,
    };
    let function = TransferFunction::new(vec![
        knot(0.0, [0.1, 0.2, 0.8], depths[0]),
        knot(0.5, [0.2, 0.9, 0.4], depths[1]),
        knot(1.0, [1.0, 0.3, 0.1], depths[2]),
    ]);
    Appearance::new(function.expect("valid knots"), model)
}

/// The error that a promise to be exact allows.
const RMSE: f64 = 3e-6;

fn check(
    gpu: &Gpu,
    name: &str,
    volume: &Volume,
    options: &RaycastOptions,
    models: &[OpticalModel],
) {
    for &model in models {
        check_look(gpu, name, volume, options, &thin(volume, model));
    }
}

fn check_look(
    gpu: &Gpu,
    name: &str,
    volume: &Volume,
    options: &RaycastOptions,
    appearance: &Appearance,
) {
    let reference = truth(volume, appearance);
    for orthographic in [true, false] {
        let view = fitted(volume, CameraFit::PlusZ, orthographic, SIDE);
        let exact = reference.render_exact(&view).expect("a frame");
        let frame = draw(gpu, volume, appearance, options, &view);
        let ImageError { rmse, max, .. } = ImageError::against(&exact.pixels, &frame);
        let unit = scale(&exact.pixels);
        let model = appearance.optical_model.name();
        let what = format!("{name}, {model}, parallel: {orthographic}");
        println!(
            "{what}: {rmse:.1e}, {max:.1e} of {unit:.1}, {} passes",
            frame.stats.passes
        );
        assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{what}");
        assert!(
            frame.stats.notes.is_empty(),
            "{what}: {:?}",
            frame.stats.notes
        );
        assert!(rmse <= RMSE * unit, "{what}: {rmse:e}");
    }
}

/// Rays that cross the boundary up to 8192 times.
#[test]
fn bodies_in_a_row_are_all_seen() {
    let Some(gpu) = testing::gpu("bodies_in_a_row_are_all_seen") else {
        return;
    };
    let options = RaycastOptions::default();
    for count in [16, 280, 1000] {
        let models = match count {
            280 => &OpticalModel::VOLUMETRIC[..],
            _ => &[OpticalModel::EmissionAbsorption],
        };
        check(
            &gpu,
            &format!("{count} tetrahedra"),
            &tetrahedra(count),
            &options,
            models,
        );
        let hexahedra = hexahedra(count);
        check(
            &gpu,
            &format!("{count} hexahedra"),
            &hexahedra,
            &options,
            &models[..1],
        );
    }
    let models = [OpticalModel::EmissionAbsorption];
    check(
        &gpu,
        "4096 tetrahedra",
        &tetrahedra(4096),
        &options,
        &models,
    );
    // Where bodies are dense, what their lengths are rounded by counts: 4096 random errors.
    let row = tetrahedra(4096);
    let dense = through(&row, OpticalModel::EmissionAbsorption, [0.0, 15.0, 30.0]);
    check_look(&gpu, "4096 dense tetrahedra", &row, &options, &dense);
}

/// `layers` hexahedra on top of each other, 1x1x1 in all, whose scalars differ.
fn column(layers: u64) -> Volume {
    let mut random = Random(0x1234_5678_9abc_def1);
    let mut points = Vec::new();
    for layer in 0..=layers {
        let z = layer as f64 / layers as f64;
        points.extend(
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z)),
        );
    }
    let mut cells = Cells::default();
    cells.offsets.push(0);
    for layer in 0..layers {
        cells.connectivity.extend(4 * layer..4 * layer + 8);
        cells.types.push(12);
        cells.offsets.push(8 * (layer + 1));
    }
    let values = points.iter().map(|_| random.next()).collect();
    let mesh = TetMesh::new(points, &cells, testing::point_scalars(values));
    Volume::Mesh(mesh.expect("a mesh"))
}

/// Each ray passes more cells than the 65 535 after which llvmpipe ends a shader's loops, in one
/// path through the mesh.
///
/// Ends of cells are f32 of a cube of side 2 and err by 2⁻²⁴, which is one end too far and the
/// next too near: with extinctions that differ by up to 5 in a depth of 3, n = 75 000 of them
/// err by 5 √n 2⁻²⁴ = 8e-5, were neighbors unlike as ends can be, and as much is lost where n
/// numbers are added to a sum of 3. Light of 1 then errs by a third of that.
#[test]
fn long_paths_are_followed_to_their_ends() {
    let Some(gpu) = testing::gpu("long_paths_are_followed_to_their_ends") else {
        return;
    };
    let volume = column(25_000);
    let models = [
        (OpticalModel::EmissionAbsorption, &[true, false][..]),
        (OpticalModel::Absorption, &[true]),
        (OpticalModel::MaximumIntensity, &[false]),
    ];
    for (model, projections) in models {
        let appearance = thin(&volume, model);
        let reference = truth(&volume, &appearance);
        for &orthographic in projections {
            let from = DVec3::new(0.55, 0.47, 20.0);
            let camera = Camera {
                position: from,
                focal_point: from - DVec3::new(0.03, -0.02, 20.0),
                view_up: DVec3::Y,
                projection: Projection::Perspective { view_angle: 1.0 },
            };
            let camera = match orthographic {
                true => camera.to_orthographic(),
                false => camera,
            };
            let view = view(camera, 3);
            let exact = reference.render_exact(&view).expect("a frame");
            let frame = draw(
                &gpu,
                &volume,
                &appearance,
                &RaycastOptions::default(),
                &view,
            );
            let ImageError { rmse, max, .. } = ImageError::against(&exact.pixels, &frame);
            let cells = frame.stats.get(CELL_VISITS).expect("counted") / 9;
            let what = format!("{}, parallel: {orthographic}", model.name());
            println!(
                "{what}: {rmse:.1e}, {max:.1e}, {cells} cells, {} passes",
                frame.stats.passes
            );
            assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{what}");
            assert!(cells > 70_000, "{what}: {cells}");
            assert!(rmse <= 3e-5, "{what}: {rmse:e}");
        }
    }
}

/// Shells around each other, seen from outside and from their middle.
#[test]
fn nested_shells_are_all_seen() {
    let Some(gpu) = testing::gpu("nested_shells_are_all_seen") else {
        return;
    };
    let models = OpticalModel::VOLUMETRIC;
    check(
        &gpu,
        "64 shells",
        &shells(64),
        &RaycastOptions::default(),
        &models,
    );
}

/// Every setting that promises the same picture.
#[test]
fn settings_change_nothing_in_a_long_row() {
    let Some(gpu) = testing::gpu("settings_change_nothing_in_a_long_row") else {
        return;
    };
    let defaults = RaycastOptions::default();
    let models = [OpticalModel::EmissionAbsorption];
    for (name, options) in settings() {
        check(&gpu, name, &tetrahedra(80), &options, &models);
    }
    // As many as make a picture be drawn in several dispatches.
    let layers = RaycastOptions {
        entries: Entries::PeeledLayers,
        ..defaults
    };
    check(&gpu, "layers", &tetrahedra(700), &layers, &models);
}

fn settings() -> [(&'static str, RaycastOptions); 4] {
    let defaults = RaycastOptions::default();
    [
        (
            "as given",
            RaycastOptions {
                locality: Locality::AsGiven,
                ..defaults
            },
        ),
        (
            "integers",
            RaycastOptions {
                integer_sides: true,
                ..defaults
            },
        ),
        (
            "layers",
            RaycastOptions {
                entries: Entries::PeeledLayers,
                ..defaults
            },
        ),
        (
            "ping-pong",
            RaycastOptions {
                passes: Passes::PingPong,
                ..defaults
            },
        ),
    ]
}

/// Cells that share no points, with values that agree and with values that jump.
#[test]
fn cells_that_share_no_points_are_passed_one_after_the_other() {
    let Some(gpu) = testing::gpu("cells_that_share_no_points_are_passed_one_after_the_other")
    else {
        return;
    };
    let defaults = RaycastOptions::default();
    let models = [OpticalModel::EmissionAbsorption];
    let mesh = data_set("torus", Some(1500));
    check(
        &gpu,
        "agreeing",
        &split(&mesh),
        &defaults,
        &OpticalModel::VOLUMETRIC,
    );
    let jumping = jumping(&mesh);
    check(
        &gpu,
        "jumping",
        &jumping,
        &defaults,
        &OpticalModel::VOLUMETRIC,
    );
    for (name, options) in settings() {
        check(
            &gpu,
            &format!("jumping, {name}"),
            &jumping,
            &options,
            &models,
        );
    }
    // As few bytes and crossings as a mesh that shares them, bit for bit the same picture.
    let whole = Volume::Mesh(mesh.clone());
    let appearance = thin(&whole, OpticalModel::EmissionAbsorption);
    let view = fitted(&whole, CameraFit::PlusZ, false, SIDE);
    let [a, b] =
        [&whole, &split(&mesh)].map(|volume| draw(&gpu, volume, &appearance, &defaults, &view));
    assert_eq!(a.stats.get(PATHS), b.stats.get(PATHS));
    assert_eq!(a.stats.get(CELL_VISITS), b.stats.get(CELL_VISITS));
    assert_eq!(a.stats.bytes_resident, b.stats.bytes_resident);
}

/// New scalars that jump, and that do not, on the same geometry.
#[test]
fn a_field_may_begin_to_jump() {
    let Some(gpu) = testing::gpu("a_field_may_begin_to_jump") else {
        return;
    };
    let mesh = data_set("sphere", Some(700));
    let Volume::Mesh(jumping) = jumping(&mesh) else {
        panic!("a mesh")
    };
    let smooth = testing::point_scalars(
        (0..mesh.cell_count())
            .flat_map(|c| mesh.cell_scalars(c))
            .collect(),
    );
    let smooth = jumping.with_scalars(smooth).expect("as many");
    for passes in [Passes::Single, Passes::PingPong] {
        let options = RaycastOptions {
            passes,
            ..RaycastOptions::default()
        };
        let volume = |mesh: &TetMesh| Volume::Mesh(mesh.clone());
        let appearance = thin(&volume(&smooth), OpticalModel::EmissionAbsorption);
        let view = fitted(&volume(&smooth), CameraFit::PlusZ, false, SIDE);
        let mut renderer = renderer(&gpu, &volume(&smooth), &appearance, &options);
        for mesh in [&jumping, &smooth] {
            renderer.reload(&volume(mesh)).expect("a mesh");
            let frame = renderer.render(&view).expect("a frame");
            let new = draw(&gpu, &volume(mesh), &appearance, &options, &view);
            assert!(frame.pixels == new.pixels, "{passes:?}");
        }
    }
}
