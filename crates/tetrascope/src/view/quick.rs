//! The algorithm that draws while a hand moves.

use tetrascope_core::{Settings, Volume};

use super::renderers::Setup;
use super::state::State;
use crate::{algorithm, algorithms};

/// The setup for moving frames.
#[derive(Clone, Debug)]
pub(crate) struct Quick {
    pub(crate) setup: Setup,
    /// Why this one, in a few words.
    pub(crate) why: &'static str,
}

/// A setup that was measured on this machine, with what is expected of it on the scene.
#[derive(Clone, Debug)]
pub(crate) struct Expectation {
    pub(crate) setup: Setup,
    /// Time of a frame at full size.
    pub(crate) seconds: f64,
    /// The RMSE that is not expected to be exceeded.
    pub(crate) error: f64,
}

/// A moving picture may be as wrong as this: about eight levels of an 8-bit picture.
const WORST: f64 = 3e-2;

/// The setup at hand is kept unless another is faster by this factor: it takes no more memory.
const WORTH_IT: f64 = 1.5;

/// Chooses for a state: what is measured to be fastest, if anything was measured for its model and
/// kind of volume; else the ray caster on the CPU, whose start takes the least time; else what
/// draws the complete picture.
pub(crate) fn choose(state: &State, measured: &[Expectation]) -> Quick {
    let own = Setup::of(state);
    let cpu = on_cpu().filter(|setup| setup.draws(state));
    // What draws the complete picture anyway is not made twice.
    let default = match cpu {
        Some(cpu) if cpu.algorithm.name != own.algorithm.name => Quick {
            setup: cpu,
            why: "it needs no device and adapts at once",
        },
        _ => Quick {
            setup: own,
            why: "it draws the complete picture, too",
        },
    };
    let usable = |e: &&Expectation| e.error <= WORST && e.setup.draws(state);
    let fastest = measured
        .iter()
        .filter(usable)
        .min_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let seconds = |setup: &Setup| {
        let found = measured.iter().find(|e| e.setup == *setup);
        found.map_or(f64::INFINITY, |e| e.seconds)
    };
    match fastest {
        Some(fastest) if WORTH_IT * fastest.seconds < seconds(&default.setup) => Quick {
            setup: fastest.setup.clone(),
            why: "it was measured to be the fastest here",
        },
        Some(_) => Quick {
            why: "measured: none is faster by half",
            ..default
        },
        None => default,
    }
}

fn on_cpu() -> Option<Setup> {
    let algorithm = algorithm("raycast-cpu").ok()?;
    Some(Setup {
        algorithm,
        settings: Settings::defaults(algorithm),
    })
}

/// The algorithms that draw a state with their default settings, and why others do not.
pub(crate) fn drawn_by(state: &State) -> Vec<(&'static str, Option<String>)> {
    let scene = &state.scene;
    let volume: &Volume = state.field.volume();
    let of = |algorithm: &'static crate::Algorithm| {
        let settings = Settings::defaults(algorithm);
        let supports = algorithm.supports;
        let why = supports(volume, &scene.appearance, &scene.view, &settings).err();
        (algorithm.name, why.map(|error| error.to_string()))
    };
    algorithms().iter().map(of).collect()
}
