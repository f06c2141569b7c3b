//! The costs of a frame in which nothing shows, and of an edited transfer function:
//! `slicing/bump/262k samples/empty frame/default`, `projection/blunt-fin/187k cells/edit/order=mpvo`.
//!
//! An empty frame is 64×64 pixels of a volume that is transparent throughout: passes, submission
//! and readback, and nothing else. An edit moves a knot, as a person does who drags it; `edit, hiding`
//! makes a knot transparent and opaque in turn, so that other cells show each time; `edit and
//! frame` draws 64×64 pixels after each edit, so that what an edit leaves to the frame is seen.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use tetrascope::core::{
    Appearance, CameraFit, Knot, OpticalModel, TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope::{Algorithm, Context, Settings};
use tetrascope_benches::Case;
use tetrascope_testing::{Place, blunt_fin, fitted, grid, ramp};

/// Who says what is missing.
const BENCH: &str = "rates";

/// A mesh and a grid, with names and sizes: the Blunt Fin if it is there.
fn volumes() -> Vec<(String, Volume)> {
    let sphere = || {
        let case = tetrascope_benches::cases().swap_remove(0);
        let Case { name, volume, .. } = case;
        (name, volume)
    };
    let mesh = blunt_fin(BENCH).map_or_else(sphere, |fin| {
        let thousands = (fin.cell_count() + 500) / 1000;
        let name = format!("blunt-fin/{thousands}k cells");
        (name, Volume::Mesh(fin))
    });
    let bump = grid(&Place::unit(63), |p| {
        (-9.0 * (p - 0.5).length_squared()).exp()
    });
    vec![mesh, ("bump/262k samples".into(), Volume::Grid(bump))]
}

/// `look` with the color of knot `n`, counted round, changed by a hair, and its place if it has
/// neighbors.
fn edited(look: &Appearance, n: usize) -> Appearance {
    let mut knots = look.transfer_function.knots().to_vec();
    let index = n % knots.len();
    let share = 0.001 * (n % 100) as f64;
    knots[index].color *= 1.0 - share;
    if index > 0 && index + 1 < knots.len() {
        let gap = knots[index].scalar - knots[index - 1].scalar;
        knots[index].scalar -= share * gap;
    }
    let mut edited = look.clone();
    edited.transfer_function = TransferFunction::new(knots).expect("sorted");
    edited
}

/// `look` in which every second time the last knots are transparent.
fn hiding(look: &Appearance, n: usize) -> Appearance {
    let mut knots = look.transfer_function.knots().to_vec();
    let last = knots.len() - 1;
    for knot in &mut knots[last - 1..] {
        knot.extinction *= (n % 2) as f64;
    }
    let mut edited = look.clone();
    edited.transfer_function = TransferFunction::new(knots).expect("sorted");
    edited
}

fn transparent(look: &Appearance) -> Appearance {
    let knots = look.transfer_function.knots().iter().map(|knot| Knot {
        extinction: 0.0,
        ..*knot
    });
    let function = TransferFunction::new(knots.collect()).expect("sorted");
    Appearance::new(function, look.optical_model)
}

/// Each setting of the sweep that draws `volume`, with its words.
fn settings(
    algorithm: &'static Algorithm,
    volume: &Volume,
    look: &Appearance,
    view: &View,
) -> Vec<(&'static str, Settings)> {
    let sweep = (algorithm.sweep)(OpticalModel::EmissionAbsorption).iter();
    let parsed = sweep.map(|words| {
        let settings = Settings::parse(algorithm, words.split(',')).expect("the sweep is valid");
        (if words.is_empty() { "default" } else { *words }, settings)
    });
    let draws = |s: &Settings| (algorithm.supports)(volume, look, view, s).is_ok();
    parsed.filter(|(_, settings)| draws(settings)).collect()
}

fn rates(criterion: &mut Criterion) {
    let context = Context::new();
    if tetrascope_benches::gpu(&context, BENCH).is_none() {
        return;
    }
    for (name, volume) in volumes() {
        let look = ramp(&volume);
        let view = fitted(&volume, CameraFit::PlusZ, true, 64);
        for algorithm in tetrascope::algorithms().iter().filter(|a| a.needs_gpu) {
            let group = format!("{}/{name}", algorithm.name);
            let mut group = criterion.benchmark_group(group);
            group
                .warm_up_time(Duration::from_millis(300))
                .measurement_time(Duration::from_secs(1));
            for (words, settings) in settings(algorithm, &volume, &look, &view) {
                let build = |look: &Appearance| {
                    (algorithm.build)(&context, &volume, look, &settings).expect("it draws this")
                };
                let empty = build(&transparent(&look));
                group.sample_size(20);
                group.bench_function(format!("empty frame/{words}"), |b| {
                    b.iter(|| black_box(empty.render(&view).expect("a frame")));
                });
                let mut renderer = build(&look);
                group.sample_size(10);
                let mut n = 0;
                group.bench_function(format!("edit/{words}"), |b| {
                    b.iter(|| {
                        n += 1;
                        renderer.restyle(&edited(&look, n)).expect("a look");
                    });
                });
                group.bench_function(format!("edit, hiding/{words}"), |b| {
                    b.iter(|| {
                        n += 1;
                        renderer.restyle(&hiding(&look, n)).expect("a look");
                    });
                });
                group.bench_function(format!("edit and frame/{words}"), |b| {
                    b.iter(|| {
                        n += 1;
                        renderer.restyle(&edited(&look, n)).expect("a look");
                        black_box(renderer.render(&view).expect("a frame"));
                    });
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, rates);
criterion_main!(benches);
