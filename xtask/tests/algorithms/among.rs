//! Volumes in front of and behind an application's opaque geometry, against the ground truth
//! whose rays end there.

use tetrascope::core::glam::{DMat3, DMat4, DVec3, DVec4};
use tetrascope::core::grid::{Grid, Samples};
use tetrascope::core::{
    Appearance, Bounds, Camera, CameraFit, Error, Frame, FrameStats, OpticalModel, Projection, Ray,
    View, Volume,
};
use tetrascope::gpu::wgpu::TextureFormat;
use tetrascope::reference::{Reference, ReferenceOptions};
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope::{Algorithm, Promise, Renderer, Settings};
use tetrascope_testing::Application;
use xtask::compare::resolve;
use xtask::limits::{limit, outliers, rmse_with_outliers};
use xtask::testing::{Failures, algorithms, context};

const SIDE: u32 = 40;

/// How an application projects: depth grows to a far plane, or falls to nothing at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Depths {
    Ordinary,
    Reversed,
}

/// An opaque sphere and nothing else.
struct Sphere {
    center: DVec3,
    radius: f64,
}

impl Sphere {
    /// How far along a ray it is met.
    fn meets(&self, ray: &Ray) -> Option<f64> {
        let from_center = ray.origin - self.center;
        let b = from_center.dot(ray.direction);
        let root = b * b - (from_center.length_squared() - self.radius * self.radius);
        let t = -b - root.sqrt();
        (root > 0.0 && t > 0.0).then_some(t)
    }
}

fn clip_from_world(view: &View, bounds: &Bounds, depths: Depths) -> DMat4 {
    let camera = &view.camera;
    let (right, up, forward) = camera.axes();
    let row = |axis: DVec3, scale: f64| (scale * axis).extend(-scale * axis.dot(camera.position));
    let distance = (bounds.center() - camera.position).length();
    let (near, far) = (0.1 * bounds.diagonal(), distance + 2.0 * bounds.diagonal());
    let depth = row(forward, 1.0);
    let (reach, z, w) = match (camera.projection, depths) {
        (Projection::Perspective { view_angle }, depths) => {
            let reach = (view_angle.to_radians() / 2.0).tan();
            let z = match depths {
                Depths::Ordinary => (depth - near * DVec4::W) * (far / (far - near)),
                Depths::Reversed => near * DVec4::W,
            };
            (reach, z, depth)
        }
        (Projection::Orthographic { parallel_scale }, depths) => {
            let z = (depth - near * DVec4::W) / (far - near);
            let z = match depths {
                Depths::Ordinary => z,
                Depths::Reversed => DVec4::W - z,
            };
            (parallel_scale, z, DVec4::W)
        }
    };
    let aspect = f64::from(view.width) / f64::from(view.height);
    let (right, up) = (row(right, 1.0 / (reach * aspect)), row(up, 1.0 / reach));
    DMat4::from_cols(right, up, z, w).transpose()
}

/// An application's depth buffer, and where its depths are on the pixels' rays.
fn depths_of(sphere: &Sphere, view: &View, clip: DMat4, depths: Depths) -> (Vec<f32>, Vec<f64>) {
    let pixels = (0..view.height).flat_map(|row| (0..view.width).map(move |column| (column, row)));
    pixels
        .map(|(column, row)| {
            let ray = view.ray(column, row);
            let Some(t) = sphere.meets(&ray) else {
                let cleared = if depths == Depths::Reversed { 0.0 } else { 1.0 };
                return (cleared, f64::INFINITY);
            };
            let at = clip * (ray.origin + t * ray.direction).extend(1.0);
            let depth = (at.z / at.w) as f32;
            // As the f32 has it, (z + t z') / (w + t w') solved for t.
            let (start, rise) = (
                clip * ray.origin.extend(1.0),
                clip * ray.direction.extend(0.0),
            );
            let d = f64::from(depth);
            (depth, (start.z - d * start.w) / (d * rise.w - rise.z))
        })
        .unzip()
}

/// A grid of a bump beside its center, and of slopes.
fn grid() -> Volume {
    let n = 13_usize;
    let samples = (0..n * n * n).map(|i| {
        let [x, y, z] = [i % n, i / n % n, i / n / n].map(|c| c as f32 / (n - 1) as f32 - 0.4);
        (-(x * x + y * y + 2.0 * z * z) / 0.1).exp() + 0.1 * x
    });
    let samples = Samples::F32(samples.collect());
    let grid = Grid::new(
        [n; 3],
        DVec3::new(-1.0, 2.0, 0.5),
        DVec3::splat(0.25),
        DMat3::IDENTITY,
        samples,
    );
    Volume::Grid(grid.expect("a grid"))
}

/// A volume, and what its scene leaves to be chosen.
struct Case {
    name: &'static str,
    volume: Volume,
    file: SceneFile,
    /// The sphere's center from the volume's, in its sizes.
    at: DVec3,
}

fn cases() -> Vec<Case> {
    let middle = DVec3::splat(0.1);
    let mesh = |name: &'static str, at: DVec3| {
        let dataset = tetrascope::datasets::find(name).expect("listed");
        let mut file = tetrascope::volumes::scene(dataset);
        file.volume.cells = Some(700);
        let loaded = tetrascope::volumes::load(&file.volume);
        Case {
            name,
            volume: loaded.expect("a data set").volume,
            file,
            at,
        }
    };
    let bump = Case {
        name: "bump",
        volume: grid(),
        file: SceneFile::new(VolumeSource::default()),
        at: middle,
    };
    vec![
        mesh("sphere", middle),
        mesh("orbital", middle),
        mesh("heat-sink", middle),
        mesh("torus", DVec3::new(0.3, 0.2, 0.1)),
        bump,
    ]
}

fn renderer(algorithm: &Algorithm, setting: &str, case: &Case, look: &Appearance) -> Renderer {
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    (algorithm.build)(context(), &case.volume, look, &settings)
        .unwrap_or_else(|error| panic!("{} {setting}, {}: {error}", algorithm.name, case.name))
}

/// Its picture over an application's, model by model.
fn over(model: OpticalModel, front: [f64; 4], behind: [f32; 4]) -> [f32; 4] {
    let behind = behind.map(f64::from);
    let pixel: [f64; 4] = std::array::from_fn(|i| match model {
        OpticalModel::Emission => front[i] + behind[i],
        OpticalModel::MaximumIntensity => front[i].max(behind[i]),
        _ => front[i] + (1.0 - front[3]) * behind[i],
    });
    pixel.map(|c| c as f32)
}

#[test]
fn a_sphere_in_each_scene_hides_what_is_behind_it_and_nothing_else() {
    let drawing = algorithms("a_sphere_in_each_scene_hides_what_is_behind_it_and_nothing_else");
    let drawing: Vec<_> = drawing.into_iter().filter(|a| a.needs_gpu).collect();
    if drawing.is_empty() {
        return;
    }
    let gpu = context().gpu().expect("it was there");
    let (mut failures, mut drawn, mut hidden_surfaces) = (Failures::default(), 0, 0);
    for (index, case) in cases().into_iter().enumerate() {
        let bounds = case.volume.bounds();
        let sphere = Sphere {
            center: bounds.center() + case.at * bounds.size(),
            radius: 0.22 * bounds.size().min_element().max(0.3 * bounds.diagonal()),
        };
        // Each case in both projections, and with both kinds of depths in turn.
        let (one, other) = match index % 2 {
            0 => (Depths::Ordinary, Depths::Reversed),
            _ => (Depths::Reversed, Depths::Ordinary),
        };
        for (orthographic, depths) in [(false, one), (true, other)] {
            let view = View {
                camera: Camera::fit(&bounds, CameraFit::PlusIso, orthographic, 1.0),
                width: SIDE,
                height: SIDE,
                background: [0.0; 4],
            };
            let clip = clip_from_world(&view, &bounds, depths);
            let (values, ends) = depths_of(&sphere, &view, clip, depths);
            let pixels: Vec<[f32; 4]> = (0..SIDE * SIDE)
                .map(|i| [0.2, (i % 7) as f32 / 10.0, 0.4, 0.5 + (i % 3) as f32 / 4.0])
                .collect();
            for model in OpticalModel::ALL {
                let scene = resolve(&case.file, model, &case.volume).expect("a scene");
                let look = scene.appearance;
                let options = ReferenceOptions::default();
                let reference =
                    Reference::new(&case.volume, &look, &options).expect("it draws all");
                let truth = reference.render_before(&view, &ends).expect("a picture");
                let without = reference.render_exact(&view).expect("a picture");
                let hidden = truth.pixels.iter().zip(&without.pixels);
                let hidden = hidden.filter(|(a, b)| a != b).count();
                // What is behind need not be the greatest, and a surface around the sphere hides it.
                if matches!(
                    model,
                    OpticalModel::EmissionAbsorption | OpticalModel::Emission
                ) {
                    assert!(hidden > 20, "{}: {hidden} pixels are hidden", case.name);
                }
                hidden_surfaces += usize::from(model == OpticalModel::Isosurfaces) * hidden;
                for algorithm in &drawing {
                    for setting in (algorithm.sweep)(model) {
                        let settings = Settings::parse(algorithm, setting.split(','));
                        let settings = settings.expect("the sweep is valid");
                        let supports = (algorithm.supports)(&case.volume, &look, &view, &settings);
                        let promise = (algorithm.promise)(&settings);
                        if supports.is_err() || promise == Promise::Open {
                            continue;
                        }
                        let what = format!(
                            "{} {setting}, {}, {model:?}, {depths:?}, orthographic: {orthographic}",
                            algorithm.name, case.name
                        );
                        let renderer = renderer(algorithm, setting, &case, &look);
                        let draw = renderer.as_draw().expect("it draws on a GPU");
                        let application = Application::draw(
                            gpu,
                            (SIDE, SIDE),
                            &pixels,
                            &values,
                            TextureFormat::Depth32Float,
                        )
                        .expect("an application");
                        let color = application.color.create_view(&Default::default());
                        let target = application.target(&color, clip);
                        let mut encoder = gpu.device().create_command_encoder(&Default::default());
                        let recorded = match draw.encode(&mut encoder, &view, &target) {
                            Ok(recorded) => recorded,
                            Err(Error::Unsupported { reason, .. }) => {
                                let known = reason.contains("the CPU reads between");
                                assert!(known, "{what}: {reason}");
                                continue;
                            }
                            Err(error) => panic!("{what}: {error}"),
                        };
                        gpu.finish(encoder).expect("drawn");
                        let stats = recorded.statistics().expect("read");
                        assert!(stats.passes > 0, "{what}");
                        let (got, after) = application.read(gpu).expect("read");
                        drawn += 1;
                        if model != OpticalModel::Isosurfaces {
                            assert_eq!(after, values, "{what}: depths were written");
                        }
                        let Some(limit) = limit(promise, model, stats.order_proven, Some(1e-2))
                        else {
                            continue;
                        };
                        let wanted = truth.pixels.iter().zip(&pixels);
                        let wanted = wanted.map(|(&front, &behind)| over(model, front, behind));
                        let frame =
                            |pixels| Frame::new((SIDE, SIDE), pixels, FrameStats::default());
                        let (wanted, got) = (frame(wanted.collect()), frame(got));
                        let limit = (rmse_with_outliers(limit, model, [SIDE; 2]), limit.1);
                        failures.compare_most(&what, &wanted, &got, limit, outliers(model));
                    }
                }
            }
        }
    }
    assert!(drawn > 100, "{drawn} pictures");
    assert!(hidden_surfaces > 50, "{hidden_surfaces} pixels");
    failures.finish();
}
