//! The three rates of change: what a renderer keeps when its volume or its appearance changes, and
//! what is left of it when that fails.

mod faults;

use tetrascope::core::Values;
use tetrascope::core::glam::DVec3;
use tetrascope::core::{
    Appearance, CameraFit, Error, Frame, Knot, OpticalModel, TetMesh, TransferFunction, View,
    Volume, VolumeRenderer as _,
};
use tetrascope::gpu::Gpu;
use tetrascope::{Algorithm, Context, Renderer, Settings};
use tetrascope_testing::{
    ImageError, Place, fitted, grid, kuhn, point_scalars, surfaces, tetrahedra_of,
};
use xtask::testing::{Failures, algorithms};

const SIDE: u32 = 8;

/// A volume, the same with other scalars, and one of another shape.
fn series() -> [[Volume; 3]; 2] {
    let wave = |p: DVec3| (3.0 * p.x).sin() + p.y * p.z;
    let other = |p: DVec3| (2.0 * p.y).cos() * (0.3 + p.x);
    let cube = |n: usize, field: &dyn Fn(DVec3) -> f64| {
        let (points, cells) = kuhn(n, DVec3::ZERO, DVec3::ONE, |_| true);
        let values = points.iter().map(|p| field(*p)).collect();
        let mesh = TetMesh::from_tetrahedra(points, cells, point_scalars(values));
        Volume::Mesh(mesh.expect("a mesh"))
    };
    let mesh = cube(4, &wave);
    let tetrahedra = tetrahedra_of(&mesh);
    let values = tetrahedra.points().iter().map(|p| other(*p)).collect();
    let changed = tetrahedra.with_scalars(point_scalars(values));
    let changed = Volume::Mesh(changed.expect("as many"));
    [
        [mesh, changed, cube(3, &other)],
        [(7, 0), (7, 1), (5, 1)].map(|(cells, field)| {
            let place = Place::unit(cells);
            Volume::Grid(match field {
                0 => grid(&place, wave),
                _ => grid(&place, other),
            })
        }),
    ]
}

/// So many knots over the range of `volume`, with optical depths up to `depth` across it.
fn look(volume: &Volume, model: OpticalModel, knots: u32, depth: f64) -> Appearance {
    let (low, high) = volume.scalar_range().expect("scalars");
    let size = volume.bounds().size().max_element();
    let knots = (0..knots).map(|i| {
        let share = f64::from(i) / f64::from(knots - 1);
        let wave = 0.5 + 0.5 * (9.0 * share).sin();
        Knot {
            scalar: low + share * (high - low),
            color: DVec3::new(share, wave, 1.0 - share),
            extinction: (0.2 + wave) * depth / size,
        }
    });
    let function = TransferFunction::new(knots.collect()).expect("sorted");
    let appearance = Appearance::new(function, model);
    match model {
        OpticalModel::Isosurfaces => surfaces(volume, appearance),
        _ => appearance,
    }
}

/// A renderer in one setting, and the view of all its pictures.
struct Case<'a> {
    context: &'a Context,
    algorithm: &'a Algorithm,
    settings: Settings,
    view: View,
}

impl Case<'_> {
    fn build(&self, volume: &Volume, look: &Appearance) -> Renderer {
        let made = (self.algorithm.build)(self.context, volume, look, &self.settings);
        made.unwrap_or_else(|error| panic!("{} {}: {error}", self.algorithm.name, self.settings))
    }

    fn draws(&self, volume: &Volume, look: &Appearance) -> bool {
        (self.algorithm.supports)(volume, look, &self.view, &self.settings).is_ok()
    }
}

/// Each setting of each algorithm that draws on a GPU, with light or surfaces and each series of
/// volumes that it draws.
fn for_each(test: &str, mut check: impl FnMut(&Gpu, &Case, OpticalModel, &[Volume; 3])) {
    // A device of its own: what is refused on it is refused to this test alone.
    let context = Context::new();
    let drawing = algorithms(test).into_iter().filter(|a| a.needs_gpu);
    let mut count = 0;
    for algorithm in drawing {
        let gpu = context.gpu().expect("there is an adapter");
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Isosurfaces] {
            for settings in ways(algorithm) {
                for series in &series() {
                    let case = Case {
                        context: &context,
                        algorithm,
                        settings: settings.clone(),
                        view: fitted(&series[0], CameraFit::PlusZ, true, SIDE),
                    };
                    if case.draws(&series[0], &look(&series[0], model, 3, 1.0)) {
                        count += 1;
                        check(gpu, &case, model, series);
                    }
                }
            }
        }
    }
    eprintln!("{test}: {count} settings");
}

/// Each word of each setting of `algorithm`, the others at their defaults, and numbers at their
/// least, with which tables are small.
fn ways(algorithm: &Algorithm) -> Vec<Settings> {
    let least = algorithm.settings.iter().filter_map(|s| match s.values {
        Values::Integer { min, .. } => Some(format!("{}={min}", s.name)),
        _ => None,
    });
    let least: Vec<String> = least.collect();
    let words = algorithm.settings.iter().flat_map(|s| match s.values {
        Values::Choice(words) => words.iter().map(|w| format!("{}={w}", s.name)).collect(),
        _ => Vec::new(),
    });
    let mut ways = Vec::new();
    for word in words {
        let pairs = least.iter().map(String::as_str).chain([word.as_str()]);
        let settings = Settings::parse(algorithm, pairs).expect("as offered");
        if !ways.contains(&settings) {
            ways.push(settings);
        }
    }
    ways
}

fn same(a: &Frame, b: &Frame) -> bool {
    let bits = |frame: &Frame| -> Vec<[u32; 4]> {
        let pixels = frame.pixels.iter();
        pixels.map(|pixel| pixel.map(f32::to_bits)).collect()
    };
    bits(a) == bits(b)
}

/// Knots that are moved, added and removed, and extinctions that change: but for a few kinds of
/// functions nothing is compiled, and the picture is that of a renderer made for it.
#[test]
fn an_edited_transfer_function_compiles_nothing() {
    let mut failures = Failures::default();
    let test = "an_edited_transfer_function_compiles_nothing";
    for_each(test, |gpu, case, model, [volume, ..]| {
        let looks = [(3, 1.0), (40, 1.1), (4, 90.0), (17, 70.0), (60, 0.5)];
        // The second round has other numbers of the same kinds, so what it needs was compiled.
        let rounds = [0, 1].map(|more| {
            looks.map(|(knots, depth)| {
                let depth = depth * (1.0 + 0.01 * f64::from(more));
                look(volume, model, knots + more, depth)
            })
        });
        let mut renderer = case.build(volume, &rounds[0][0]);
        let what = format!(
            "{} {}, {}",
            case.algorithm.name,
            case.settings,
            model.name()
        );
        for (round, looks) in rounds.iter().enumerate() {
            for look in looks {
                let before = gpu.compiled_pipelines();
                renderer.restyle(look).expect("a look");
                let frame = renderer.render(&case.view).expect("a frame");
                let compiled = gpu.compiled_pipelines() - before;
                if round == 0 {
                    // The kinds: cells in pieces or whole, segments deep or not.
                    continue;
                }
                if compiled > 0 {
                    failures.push(format!("{what}: compiled {compiled}"));
                }
                let fresh = case.build(volume, look).render(&case.view);
                let fresh = fresh.expect("a frame");
                if !same(&frame, &fresh) {
                    failures.push(format!("{what}: not as if it were new"));
                }
            }
        }
    });
    failures.finish();
}

/// Each step of `restyle` and `reload` fails in turn: then the renderer draws what it drew.
#[test]
fn what_fails_leaves_the_renderer_as_it_was() {
    let mut failures = Failures::default();
    let test = "what_fails_leaves_the_renderer_as_it_was";
    let mut steps = 0;
    for_each(test, |gpu, case, model, [volume, changed, other]| {
        let (first, second) = (look(volume, model, 3, 1.0), look(volume, model, 9, 40.0));
        // Far from the scalars that there are, so that they are mapped anew.
        let far = look(volume, model, 5, 2.0);
        let far = moved(&far, 1e6);
        let what = format!(
            "{} {}, {}",
            case.algorithm.name,
            case.settings,
            model.name()
        );
        let mut renderer = case.build(volume, &first);
        let before = renderer.render(&case.view).expect("a frame");
        type Change<'a> = Box<dyn Fn(&mut Renderer) -> Result<(), Error> + 'a>;
        let changes: [(&str, Change, (&Volume, &Appearance)); 4] = [
            (
                "restyle",
                Box::new(|r| r.restyle(&second)),
                (volume, &second),
            ),
            ("restyle far", Box::new(|r| r.restyle(&far)), (volume, &far)),
            (
                "reload of scalars",
                Box::new(|r| r.reload(changed)),
                (changed, &first),
            ),
            ("reload", Box::new(|r| r.reload(other)), (other, &first)),
        ];
        for (name, change, (to, look)) in changes {
            for step in 0.. {
                gpu.refuse_after(Some(step));
                let done = change(&mut renderer);
                gpu.refuse_after(None);
                if done.is_ok() {
                    break;
                }
                steps += 1;
                let after = renderer.render(&case.view).expect("a frame");
                if !same(&before, &after) {
                    failures.push(format!(
                        "{what}: {name} failed at {step} and left something"
                    ));
                }
            }
            let done = renderer.render(&case.view).expect("a frame");
            let fresh = case.build(to, look).render(&case.view).expect("a frame");
            let apart = ImageError::between(&fresh, &done);
            // Scalars and colors are mapped by the former look's unit, as `reload` keeps it.
            if !apart.within(3e-6, 1e-4) {
                failures.push(format!("{what}: {name} is not as if new: {apart:?}"));
            }
            renderer.reload(volume).expect("a volume");
            renderer.restyle(&first).expect("a look");
            let again = renderer.render(&case.view).expect("a frame");
            if !same(&before, &again) {
                failures.push(format!("{what}: not back after {name}"));
            }
        }
    });
    eprintln!("{steps} steps failed");
    failures.finish();
}

/// A volume in which nothing shows becomes one in which something does.
#[test]
fn what_begins_to_show_is_drawn() {
    let mut failures = Failures::default();
    let test = "what_begins_to_show_is_drawn";
    for_each(test, |_, case, model, [volume, changed, _]| {
        let (low, high) = volume.scalar_range().expect("scalars");
        let clear = look(changed, model, 3, 0.0);
        let knot = |scalar, extinction| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        };
        // Of small optical depths, from above all that `changed` has.
        let (_, top) = changed.scalar_range().expect("scalars");
        if top >= high {
            return;
        }
        let middle = 0.5 * (top + high);
        let knots = vec![knot(low, 0.0), knot(middle, 0.0), knot(high, 0.5)];
        let mut shown = clear.clone();
        shown.transfer_function = TransferFunction::new(knots).expect("sorted");
        let mut renderer = case.build(changed, &shown);
        renderer.render(&case.view).expect("a frame");
        renderer.reload(volume).expect("a volume");
        let frame = renderer.render(&case.view).expect("a frame");
        let fresh = case.build(volume, &shown).render(&case.view);
        let apart = ImageError::between(&fresh.expect("a frame"), &frame);
        let shows = frame.pixels.iter().any(|pixel| pixel[3] > 0.0);
        if !apart.within(3e-6, 1e-4) || !shows {
            let (name, settings) = (case.algorithm.name, &case.settings);
            failures.push(format!("{name} {settings}, {}: {apart:?}", model.name()));
        }
    });
    failures.finish();
}

/// A frame in which nothing can show is its background, in one pass that draws nothing.
#[test]
fn a_frame_of_nothing_is_left_out() {
    let mut failures = Failures::default();
    let test = "a_frame_of_nothing_is_left_out";
    for_each(test, |_, case, model, [volume, ..]| {
        if model == OpticalModel::Isosurfaces {
            return; // Transparent surfaces do not exist.
        }
        let view = View {
            background: [0.2, 0.7, 0.1, 0.6],
            ..case.view
        };
        let background = view.premultiplied_background().map(|c| c as f32);
        for model in OpticalModel::ALL {
            let by_depth = !matches!(
                model,
                OpticalModel::Isosurfaces | OpticalModel::MaximumIntensity
            );
            let clear = look(volume, model, 3, 0.0);
            if !by_depth || !case.draws(volume, &clear) {
                continue;
            }
            let frame = case.build(volume, &clear).render(&view).expect("a frame");
            let is_background = frame.pixels.iter().all(|pixel| *pixel == background);
            if !is_background || frame.stats.passes != 1 {
                let (name, settings) = (case.algorithm.name, &case.settings);
                let (passes, model) = (frame.stats.passes, model.name());
                failures.push(format!("{name} {settings}, {model}: {passes} passes"));
            }
        }
    });
    failures.finish();
}

/// The same function of scalars that are greater by `offset`.
fn moved(look: &Appearance, offset: f64) -> Appearance {
    let knots = look.transfer_function.knots().iter().map(|knot| Knot {
        scalar: knot.scalar + offset,
        ..*knot
    });
    let mut moved = look.clone();
    moved.transfer_function = TransferFunction::new(knots.collect()).expect("sorted");
    moved
}
