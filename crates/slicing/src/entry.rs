//! The algorithm's entry: its settings, what it draws, how near to the truth.

use tetrascope_core::grid::Lattice;
use tetrascope_core::settings::words;
use tetrascope_core::{Appearance, Entry, Error, OpticalModel, Promise, Setting, Settings, View};
use tetrascope_f32::Normalization;
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::transfer_function::check_knots;

use crate::cells::between_samples;
use crate::frame::geometry;
use crate::options::{
    Crossing, Filtering, Gradient, Integration, Level, MAX_SLICES_PER_VOXEL, MIN_SLICES_PER_VOXEL,
    PlaneTest, Shading, SlabEnds, Slicer, SlicingOptions, StepLength, Storage, Traversal,
};
use crate::samples::source_of;
use crate::{ABILITIES, NAME, Slicing};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "slices of regular grids, cut in the vertex stage",
    paper: "C. Rezk Salama, A. Kolb, \"A Vertex Program for Efficient Box-Plane Intersection\", \
            Vision, Modeling and Visualization, 2005",
    draws: "any regular grid in every optical model, with depth cue and clip planes, converging at \
            second order in the distance of slices, isosurfaces exactly; larger than the \
            device's memory, too",
    settings: &[
        Setting::number("slices", [MIN_SLICES_PER_VOXEL, MAX_SLICES_PER_VOXEL], "2")
            .about("slices on the shortest way between two samples, at least"),
        Setting::choice("integration", &words(&Integration::ALL), "slabs").about(
            "what is computed for a slab: its middle's color, or the integral between its ends",
        ),
        Setting::choice("filtering", &words(&Filtering::ALL), "exact")
            .about("interpolation in f32, or by the texture unit, whose fractions may have 8 bits"),
        Setting::choice("step-length", &words(&StepLength::ALL), "per-ray")
            .about("a slab's length along the ray, or as planes are apart (published)"),
        Setting::choice("slab-ends", &words(&SlabEnds::ALL), "clipped")
            .about("slabs cut where the volume ends, or whole (published)"),
        Setting::choice("plane-test", &words(&PlaneTest::ALL), "sides")
            .about("which edges a plane cuts: as published, or by the sides of their ends"),
        Setting::choice("slicer", &words(&Slicer::ALL), "rays").about(
            "slabs one behind the other on each ray, or as polygons: cut by the vertex program \
             (published), or by the CPU for comparison",
        ),
        Setting::choice("traversal", &words(&Traversal::ALL), "cpu")
            .about("who finds the boxes that can show, and their order"),
        Setting::choice("level", &words(&Level::ALL), "auto")
            .about("boxes along an axis that are skipped if empty, as a power of 2"),
        Setting::choice("shading", &words(&Shading::ALL), "none")
            .about("light from the eye, by gradients on the fly"),
        Setting::choice("crossing", &words(&Crossing::ALL), "cells")
            .about("isosurfaces as roots in voxel cells, or between the samples of two slices"),
        Setting::choice("gradient", &words(&Gradient::ALL), "auto").about(
            "normals by central differences (published) or of the trilinear field; auto is the \
             field's for isosurfaces and differences for shading",
        ),
        Setting::choice("storage", &words(&Storage::ALL), "auto")
            .about("one texture if it fits, or bricks with borders"),
        Setting::choice("brick-level", &words(&Level::ALL), "auto")
            .about("bricks along an axis, as a power of 2, where samples are stored in bricks"),
        Setting::integer("budget", [1, 1 << 20], "1024")
            .about("the most MiB of samples on the device; the rest is streamed"),
    ],
    sweep,
    // What lies between two slices is not seen, so there is no bound.
    promise: |_| Promise::Open,
    sources: &[],
    figures: Some(
        "Figures 4 (unshaded) and 5 (Phong shading, gradients on the fly) of Rezk Salama and Kolb, \
         2005",
    ),
    counters: crate::counters::ALL,
    supports: |volume, appearance, view, settings| {
        let options = SlicingOptions::from_settings(settings);
        let source = source_of(volume)?;
        let lattice = source.lattice();
        check(&lattice, appearance, &options)?;
        if source.has_coverage() {
            options.check_coverage(appearance.optical_model)?;
            options.check_device_grid(&lattice)?;
        }
        check_view(&between_samples(source).lattice(), view, &options)
    },
};

impl Slicing {
    /// Whether [`Slicing::from_device`] would draw such a grid, as far as that can be said without
    /// one.
    ///
    /// # Errors
    /// Why not.
    pub fn supports_device(
        lattice: &Lattice,
        texels: Texels,
        appearance: &Appearance,
        view: &View,
        options: &SlicingOptions,
    ) -> Result<(), Error> {
        check(lattice, appearance, options)?;
        if texels == Texels::Covered {
            options.check_coverage(appearance.optical_model)?;
        }
        options.check_device_grid(lattice)?;
        check_view(lattice, view, options)
    }
}

/// Refuses what is not drawn like this, whatever the view.
pub(crate) fn check(
    lattice: &Lattice,
    appearance: &Appearance,
    options: &SlicingOptions,
) -> Result<(), Error> {
    ABILITIES.check(NAME, appearance, &lattice.bounds())?;
    check_knots(&appearance.transfer_function)?;
    options.validate()
}

/// Refuses a view with more slices than are drawn.
fn check_view(lattice: &Lattice, view: &View, options: &SlicingOptions) -> Result<(), Error> {
    view.validate()?;
    let normalization = Normalization::of(&lattice.bounds());
    geometry(view, lattice, &normalization, options.slices_per_voxel).map(drop)
}

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

impl SlicingOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> SlicingOptions {
        SlicingOptions {
            slices_per_voxel: settings.number("slices"),
            integration: settings.choice("integration", &Integration::ALL),
            filtering: settings.choice("filtering", &Filtering::ALL),
            step_length: settings.choice("step-length", &StepLength::ALL),
            slab_ends: settings.choice("slab-ends", &SlabEnds::ALL),
            plane_test: settings.choice("plane-test", &PlaneTest::ALL),
            slicer: settings.choice("slicer", &Slicer::ALL),
            traversal: settings.choice("traversal", &Traversal::ALL),
            level: settings.choice("level", &Level::ALL),
            shading: settings.choice("shading", &Shading::ALL),
            crossing: settings.choice("crossing", &Crossing::ALL),
            gradient: settings.choice("gradient", &Gradient::ALL),
            storage: settings.choice("storage", &Storage::ALL),
            brick_level: settings.choice("brick-level", &Level::ALL),
            memory_budget: (settings.integer("budget") as u64) << 20,
            domain: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{CameraFit, Volume};
    use tetrascope_testing::{
        Place, every_setting_arrives, fitted, grid, kuhn, mesh, ramp, refusal,
    };

    use super::*;

    #[test]
    fn every_setting_arrives_in_the_options() {
        every_setting_arrives(&ENTRY, SlicingOptions::from_settings);
        for (_, level) in Level::ALL {
            let options = SlicingOptions {
                level,
                ..SlicingOptions::default()
            };
            options.validate().expect("every level is valid");
        }
    }

    #[test]
    fn what_is_not_drawn_is_refused_without_a_device() {
        let cube = kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true);
        let mesh = Volume::Mesh(mesh(cube, |p| p.x));
        let flat = Place {
            spacing: DVec3::new(1.0, 1.0, 1e-6),
            ..Place::unit(4)
        };
        let flat = Volume::Grid(grid(&flat, |p| p.x));
        for (volume, settings, what) in [
            (&mesh, "", "meshes"),
            (&flat, "slicer=cpu,traversal=gpu", "polygons cut on the CPU"),
            (&flat, "slices=64", "slices per voxel are"),
        ] {
            let view = fitted(volume, CameraFit::PlusIso, false, 8);
            let why = refusal(&ENTRY, settings, (volume, &ramp(volume), &view));
            assert!(why.contains(what), "{settings}: {why}");
        }
    }
}
