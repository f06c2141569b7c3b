//! Slicing's entry.

use tetrascope_core::{Error, OpticalModel, Volume};
use tetrascope_slicing::{
    ABILITIES, Crossing, Filtering, Gradient, Integration, Level, MAX_SLICES_PER_VOXEL,
    MIN_SLICES_PER_VOXEL, NAME, PlaneTest, Shading, SlabEnds, Slicer, Slicing, SlicingOptions,
    StepLength, Storage, Traversal,
};

use super::{Algorithm, Promise, choice};
use crate::{Renderer, Setting, Settings, Values};

pub(super) const ALGORITHM: Algorithm = Algorithm {
    name: NAME,
    title: "slices of regular grids, cut in the vertex stage",
    paper: "C. Rezk Salama, A. Kolb, \"A Vertex Program for Efficient Box-Plane Intersection\", \
            Vision, Modeling and Visualization, 2005",
    draws: "any regular grid in every optical model, with depth cue and clip planes, converging at \
            second order in the distance of slices, isosurfaces exactly; larger than the \
            device's memory, too",
    needs_gpu: true,
    settings: &[
        Setting {
            name: "slices",
            about: "slices on the shortest way between two samples, at least",
            values: Values::Number {
                min: MIN_SLICES_PER_VOXEL,
                max: MAX_SLICES_PER_VOXEL,
            },
            default: "2",
        },
        Setting {
            name: "integration",
            about: "what is computed for a slab: its middle's color, or the integral between its ends",
            values: Values::Choice(&["post-classified", "slabs"]),
            default: "slabs",
        },
        Setting {
            name: "filtering",
            about: "interpolation in f32, or by the texture unit, whose fractions may have 8 bits",
            values: Values::Choice(&["exact", "hardware"]),
            default: "exact",
        },
        Setting {
            name: "step-length",
            about: "a slab's length along the ray, or as planes are apart (published)",
            values: Values::Choice(&["per-ray", "planar"]),
            default: "per-ray",
        },
        Setting {
            name: "slab-ends",
            about: "slabs cut where the volume ends, or whole (published)",
            values: Values::Choice(&["clipped", "whole"]),
            default: "clipped",
        },
        Setting {
            name: "plane-test",
            about: "which edges a plane cuts: as published, or by the sides of their ends",
            values: Values::Choice(&["published", "sides"]),
            default: "sides",
        },
        Setting {
            name: "slicer",
            about: "who cuts boxes: the vertex program, or the CPU for comparison",
            values: Values::Choice(&["vertex-program", "cpu"]),
            default: "vertex-program",
        },
        Setting {
            name: "traversal",
            about: "who finds the boxes that can show, and their order",
            values: Values::Choice(&["cpu", "gpu"]),
            default: "cpu",
        },
        Setting {
            name: "level",
            about: "boxes along an axis that are skipped if empty, as a power of 2",
            values: Values::Choice(&["auto", "0", "1", "2", "3", "4", "5", "6", "7"]),
            default: "auto",
        },
        Setting {
            name: "shading",
            about: "light from the eye, by gradients on the fly",
            values: Values::Choice(&["none", "phong"]),
            default: "none",
        },
        Setting {
            name: "crossing",
            about: "isosurfaces as roots in voxel cells, or between the samples of two slices",
            values: Values::Choice(&["cells", "corrected", "linear"]),
            default: "cells",
        },
        Setting {
            name: "gradient",
            about: "normals by central differences (published) or of the trilinear field; \
                    auto is the field's for isosurfaces and differences for shading",
            values: Values::Choice(&["auto", "central-differences", "trilinear"]),
            default: "auto",
        },
        Setting {
            name: "storage",
            about: "one texture if it fits, or bricks with borders",
            values: Values::Choice(&["auto", "bricks"]),
            default: "auto",
        },
        Setting {
            name: "brick-level",
            about: "bricks along an axis, as a power of 2, where samples are stored in bricks",
            values: Values::Choice(&["auto", "0", "1", "2", "3", "4", "5", "6", "7"]),
            default: "auto",
        },
        Setting {
            name: "budget",
            about: "the most MiB of samples on the device; the rest is streamed",
            values: Values::Integer {
                min: 1,
                max: 1 << 20,
            },
            default: "1024",
        },
    ],
    sweep,
    // What lies between two slices is not seen, so there is no bound.
    promise: |_| Promise::Open,
    supports: |volume, appearance, _| {
        ABILITIES.check(NAME, appearance, &volume.bounds())?;
        match volume {
            Volume::Grid(_) | Volume::Stream(_) => Ok(()),
            _ => Err(Error::Unsupported {
                renderer: NAME,
                what: "meshes".into(),
                reason: "it slices regular grids".into(),
            }),
        }
    },
    build: |context, volume, appearance, settings| {
        let options = options(settings);
        let renderer = Slicing::new(context.gpu()?, volume, appearance, &options)?;
        Ok(Renderer::Gpu(Box::new(renderer)))
    },
};

/// In cells an isosurface is where it is, however far slices are apart.
fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::Isosurfaces => &[
            "",
            "slices=1",
            "crossing=corrected",
            "crossing=linear,slices=1",
            "crossing=linear",
            "crossing=linear,slices=8",
            "gradient=central-differences",
        ],
        _ => &["slices=1", "slices=2", "slices=4", "slices=8"],
    }
}

fn options(settings: &Settings) -> SlicingOptions {
    SlicingOptions {
        slices_per_voxel: settings.number("slices"),
        integration: choice(settings, "integration", &Integration::ALL),
        filtering: choice(settings, "filtering", &Filtering::ALL),
        step_length: choice(settings, "step-length", &StepLength::ALL),
        slab_ends: choice(settings, "slab-ends", &SlabEnds::ALL),
        plane_test: choice(settings, "plane-test", &PlaneTest::ALL),
        slicer: choice(settings, "slicer", &Slicer::ALL),
        traversal: choice(settings, "traversal", &Traversal::ALL),
        level: level(settings, "level"),
        brick_level: level(settings, "brick-level"),
        shading: match settings.get("shading") {
            "phong" => Shading::Phong(Default::default()),
            _ => Shading::None,
        },
        crossing: choice(settings, "crossing", &Crossing::ALL),
        gradient: choice(settings, "gradient", &Gradient::ALL),
        storage: choice(settings, "storage", &Storage::ALL),
        memory_budget: (settings.integer("budget") as u64) << 20,
        domain: None,
    }
}

fn level(settings: &Settings, name: &str) -> Level {
    match settings.get(name) {
        "auto" => Level::Auto,
        level => Level::Fixed(level.parse().expect("the entry lists numbers")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algorithms::words;

    #[test]
    fn the_settings_are_those_of_the_crate_with_its_defaults() {
        let offered = |name| words::offered(&ALGORITHM, name);
        assert_eq!(offered("integration"), words::of(&Integration::ALL));
        assert_eq!(offered("filtering"), words::of(&Filtering::ALL));
        assert_eq!(offered("step-length"), words::of(&StepLength::ALL));
        assert_eq!(offered("slab-ends"), words::of(&SlabEnds::ALL));
        assert_eq!(offered("plane-test"), words::of(&PlaneTest::ALL));
        assert_eq!(offered("crossing"), words::of(&Crossing::ALL));
        assert_eq!(offered("gradient"), words::of(&Gradient::ALL));
        assert_eq!(offered("storage"), words::of(&Storage::ALL));
        assert_eq!(offered("slicer"), words::of(&Slicer::ALL));
        assert_eq!(offered("traversal"), words::of(&Traversal::ALL));
        let defaults = Settings::defaults(&ALGORITHM);
        assert_eq!(options(&defaults), SlicingOptions::default());
        for name in ["level", "brick-level"] {
            for level in offered(name) {
                let pair = format!("{name}={level}");
                let settings = Settings::parse(&ALGORITHM, [pair.as_str()]).expect("listed");
                options(&settings).validate().expect("every level is valid");
            }
        }
    }
}
