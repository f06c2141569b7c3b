//! The registry: every algorithm's [`Entry`], which its crate brings, and how to build it.
//!
//! The command line, the comparison, the benchmarks and the tests iterate over
//! [`algorithms`] and know none by name; one that is about a single algorithm takes the name
//! that its crate exports. An algorithm is in the list if its
//! cargo feature is on.

use std::ops::Deref;

use tetrascope_core::{Appearance, Entry, Error, Settings, Volume};

use crate::{Context, Renderer};

#[cfg(feature = "reference")]
mod reference;

/// An algorithm: what it says about itself, and how to build it.
#[derive(Debug)]
pub struct Algorithm {
    /// The description that its crate brings.
    pub entry: Entry,
    /// Whether building it needs a graphics adapter.
    pub needs_gpu: bool,
    /// Prepares it for a volume and an appearance, so that it can render.
    pub build: Build,
}

impl Deref for Algorithm {
    type Target = Entry;

    fn deref(&self) -> &Entry {
        &self.entry
    }
}

/// Builds a renderer: makes the device if it needs one, uploads the volume.
pub type Build = fn(&Context, &Volume, &Appearance, &Settings) -> Result<Renderer, Error>;

/// An algorithm that draws on a GPU: its crate, renderer and options.
#[cfg(feature = "gpu")]
macro_rules! on_gpu {
    ($krate:ident, $renderer:ident, $options:ident) => {
        Algorithm {
            entry: $krate::ENTRY,
            needs_gpu: true,
            build: |context, volume, appearance, settings| {
                let options = $krate::$options::from_settings(settings);
                let gpu = context.gpu()?.with_stop(context.stop().clone());
                let renderer = $krate::$renderer::new(&gpu, volume, appearance, &options)?;
                Ok(Renderer::Gpu(Box::new(renderer)))
            },
        }
    };
}

const ALL: &[Algorithm] = &[
    #[cfg(feature = "reference")]
    reference::ALGORITHM,
    #[cfg(feature = "raycast-cpu")]
    Algorithm {
        entry: tetrascope_raycast_cpu::ENTRY,
        needs_gpu: false,
        build: |context, volume, appearance, settings| {
            let options = tetrascope_raycast_cpu::RaycastCpuOptions::from_settings(settings);
            let renderer = tetrascope_raycast_cpu::RaycastCpu::new(volume, appearance, &options)?;
            let renderer = renderer.with_stop(context.stop().clone());
            Ok(Renderer::Cpu(Box::new(renderer)))
        },
    },
    #[cfg(feature = "projection")]
    on_gpu!(tetrascope_projection, CellProjection, ProjectionOptions),
    #[cfg(feature = "raycast-peel")]
    on_gpu!(tetrascope_raycast_peel, RaycastPeel, RaycastOptions),
    #[cfg(feature = "resample")]
    on_gpu!(tetrascope_resample, Resampling, ResamplingOptions),
    #[cfg(feature = "slicing")]
    on_gpu!(tetrascope_slicing, Slicing, SlicingOptions),
    #[cfg(feature = "voxel-hw")]
    on_gpu!(tetrascope_voxel_hw, Voxelization, VoxelizationOptions),
];

/// Every algorithm that was compiled in, the ground truth first.
pub fn algorithms() -> &'static [Algorithm] {
    ALL
}

/// The ground truth, if it was compiled in.
pub fn truth() -> Option<&'static Algorithm> {
    ALL.iter().find(|algorithm| algorithm.is_truth())
}

/// The algorithm called `name`; an unknown name is refused with those that exist.
pub fn algorithm(name: &str) -> Result<&'static Algorithm, Error> {
    let found = ALL.iter().find(|algorithm| algorithm.name == name);
    found.ok_or_else(|| Error::Unknown {
        kind: "algorithm",
        name: name.into(),
        valid: ALL.iter().map(|algorithm| algorithm.name.into()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use tetrascope_core::OpticalModel;

    use super::*;

    #[cfg(all(feature = "gpu", feature = "raycast-cpu"))]
    #[test]
    fn frames_stop_when_asked_and_the_next_is_whole() {
        use tetrascope_core::{Stop, VolumeRenderer as _};

        let sphere = tetrascope_datasets::find("sphere").expect("a data set");
        let mut file = crate::volumes::scene(sphere);
        file.volume.cells = Some(300);
        (file.image.width, file.image.height) = (Some(16), Some(16));
        let volume = crate::volumes::load(&file.volume).expect("a mesh").volume;
        let scene = file.resolve(&volume).expect("a scene");
        let stop = Stop::new();
        let context = Context::new().with_stop(stop.clone());
        if let Err(why) = context.gpu() {
            eprintln!("skipped: frames of GPUs: {why}");
        }
        for algorithm in algorithms() {
            let settings = Settings::defaults(algorithm);
            let (supports, build) = (algorithm.supports, algorithm.build);
            let is_drawn = supports(&volume, &scene.appearance, &scene.view, &settings).is_ok();
            if !is_drawn || (algorithm.needs_gpu && context.gpu().is_err()) {
                continue;
            }
            let renderer = build(&context, &volume, &scene.appearance, &settings);
            let renderer = renderer.expect("it draws meshes");
            let whole = renderer.render(&scene.view).expect("a frame");
            stop.set();
            let stopped = renderer.render(&scene.view);
            assert!(matches!(stopped, Err(Error::Stopped)), "{}", algorithm.name);
            stop.clear();
            let next = renderer.render(&scene.view).expect("a frame");
            assert!(whole.pixels == next.pixels, "{}", algorithm.name);
        }
    }

    #[test]
    fn every_entry_is_complete_and_consistent() {
        for (i, a) in algorithms().iter().enumerate() {
            assert!(algorithms()[..i].iter().all(|b| b.name != a.name));
            for text in [a.title, a.paper, a.draws] {
                assert!(!text.is_empty() && !text.contains('\n'), "{}", a.name);
            }
            for setting in a.settings {
                assert!(setting.values.contain(setting.default), "{}", setting.name);
            }
            let swept = |setting| {
                OpticalModel::ALL
                    .iter()
                    .any(|m| (a.sweep)(*m).contains(setting))
            };
            for source in a.sources {
                assert!(swept(&source.with) && source.without.as_ref().is_none_or(swept));
            }
            for model in OpticalModel::ALL {
                let sweep = (a.sweep)(model);
                assert!(!sweep.is_empty(), "{} has nothing to compare", a.name);
                for quality in sweep {
                    Settings::parse(a, quality.split(',')).expect("the sweep is valid");
                }
            }
        }
    }

    #[test]
    fn an_unknown_algorithm_lists_those_that_exist() {
        let error = algorithm("refrence").expect_err("misspelt").to_string();
        for a in algorithms() {
            assert!(error.contains(a.name), "{error}");
            assert_eq!(algorithm(a.name).expect("listed").name, a.name);
        }
    }
}
