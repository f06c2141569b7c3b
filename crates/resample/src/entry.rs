//! The algorithm's entry: its settings, what it draws, where its error comes from.

use tetrascope_core::entry::Source;
use tetrascope_core::settings::words;
use tetrascope_core::{Entry, Error, OpticalModel, Promise, Setting, Settings, TetMesh, Volume};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_slicing::{
    Integration, MAX_SLICES_PER_VOXEL, MIN_SLICES_PER_VOXEL, Slicing, SlicingOptions,
};

use crate::mesh_slices::{EVALUATIONS, MOST_PLANES, MeshSlices, MeshSlicesOptions, Shading};
use crate::options::{
    MAX_SAMPLES, MIN_SAMPLES, Mode, Passes, ResamplerOptions, ResamplingOptions, WEIGHTS,
};
use crate::placed::check_volume;
use crate::{NAME, renamed};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "meshes resampled into a regular grid, which is drawn in slices",
    paper: "R. Westermann, \"The Rendering of Unstructured Grids Revisited\", Joint Eurographics \
            - IEEE TCVG Symposium on Visualization, 2001",
    draws: "any mesh in every optical model, as the samples of a regular grid; no sorting, no \
            adjacency, nothing found out beforehand: a mesh that changes in every frame costs \
            the same as one that does not",
    settings: &[
        Setting::choice("mode", &words(&Mode::ALL), "grid").about(
            "what is between the mesh and its picture: a grid, or slices of the mesh as the \
             camera sees it",
        ),
        Setting::integer("samples", [MIN_SAMPLES as i64, MAX_SAMPLES as i64], "128")
            .about("samples along the longest axis of the mesh, about as far apart along others"),
        Setting::choice("passes", &words(&Passes::ALL), "direct").about(
            "how the samples in a cell are found: computed, or drawn as published with \
                    textures of weights, in two passes or one",
        ),
        Setting::integer("planes", [1, MOST_PLANES as i64], "256")
            .about("slices through the mesh with mode=slices"),
        Setting::choice("shading", &words(&Shading::ALL), "post")
            .about("what they interpolate: scalars, or the colors of vertices (pre)"),
        Setting::choice("evaluation", &words(&EVALUATIONS), "per-fragment").about(
            "how: between the ends of each fragment's ray in a cell, or by textures of weights as \
             published, along parallel rays only",
        ),
        Setting::integer(
            "weights",
            [*WEIGHTS.start() as i64, *WEIGHTS.end() as i64],
            "256",
        )
        .about("texels along each axis of these textures, an even number"),
        Setting::integer("slabs", [1, MAX_SAMPLES as i64], "40")
            .about("parts of the grid that have lists of the cells in them, where they are drawn"),
        Setting::number("slices", [MIN_SLICES_PER_VOXEL, MAX_SLICES_PER_VOXEL], "2")
            .about("slices on the shortest way between two samples, at least"),
        Setting::choice("integration", &words(&Integration::ALL), "slabs").about(
            "what is computed for a slab: its middle's color, or the integral between its ends",
        ),
    ],
    sweep,
    // A grid does not know what lies between its samples.
    promise: |_| Promise::Open,
    sources: &[
        Source {
            name: "samples alone",
            with: "samples=32,slices=8",
            without: None,
        },
        Source {
            name: "slices alone",
            with: "samples=32",
            without: Some("samples=32,slices=8"),
        },
        Source {
            name: "weights alone",
            with: "samples=32,passes=two,weights=32",
            without: Some("samples=32"),
        },
        Source {
            name: "samples and slices",
            with: "samples=32",
            without: None,
        },
    ],
    figures: None,
    counters: crate::counters::ALL,
    supports: |volume, appearance, view, settings| {
        let options = ResamplingOptions::from_settings(settings);
        options.resampler.validate()?;
        if options.mode == Mode::Slices {
            return MeshSlices::supports(volume, appearance, view, &options.mesh_slices());
        }
        let lattice = options.lattice(mesh_of(volume)?)?;
        let texels = Texels::Covered;
        Slicing::supports_device(&lattice, texels, appearance, view, &options.slicing())
            .map_err(renamed)
    },
};

/// The mesh of `volume`, if it can be resampled.
pub(crate) fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => check_volume(mesh).map(|()| mesh),
        Volume::Clusters(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes in clusters".into(),
            reason: "it needs all cells at once".into(),
        }),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it makes one of a mesh".into(),
        }),
    }
}

/// Few samples with few slices, and with so many that they no longer matter; then more samples, and
/// slices of the mesh. Other models differ in the samples alone.
fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::EmissionAbsorption => &[
            "samples=32",
            "samples=32,slices=8",
            "samples=32,passes=two,weights=32",
            "samples=64",
            "samples=64,passes=one",
            "samples=128",
            "mode=slices,planes=64",
        ],
        _ => &["samples=32", "samples=128"],
    }
}

impl ResamplingOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> ResamplingOptions {
        let (weights, slabs) = (
            settings.integer("weights") as u32,
            settings.integer("slabs") as u32,
        );
        ResamplingOptions {
            mode: settings.choice("mode", &Mode::ALL),
            samples: settings.integer("samples") as usize,
            lattice: None,
            domain: None,
            resampler: ResamplerOptions {
                passes: settings.choice("passes", &Passes::ALL),
                weights,
                slabs,
            },
            mesh_slices: MeshSlicesOptions {
                planes: settings.integer("planes") as u32,
                shading: settings.choice("shading", &Shading::ALL),
                evaluation: settings.choice("evaluation", &EVALUATIONS)(weights),
                slabs,
                domain: None,
            },
            slicing: SlicingOptions {
                slices_per_voxel: settings.number("slices"),
                integration: settings.choice("integration", &Integration::ALL),
                ..SlicingOptions::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::CameraFit;
    use tetrascope_core::glam::DVec3;
    use tetrascope_testing::{
        Place, every_setting_arrives, fitted, grid, kuhn, mesh, ramp, refusal,
    };

    use super::*;

    #[test]
    fn every_setting_arrives_in_the_options() {
        every_setting_arrives(&ENTRY, ResamplingOptions::from_settings);
    }

    #[test]
    fn what_is_not_drawn_is_refused_without_a_device() {
        let cube = || kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true);
        let regular = Volume::Grid(grid(&Place::unit(4), |p| p.x));
        let (mut points, cells) = cube();
        points.iter_mut().for_each(|p| p.z = 0.0);
        let flat = Volume::Mesh(mesh((points, cells), |p| p.x));
        let whole = Volume::Mesh(mesh(cube(), |p| p.x));
        let view = fitted(&whole, CameraFit::PlusIso, false, 8);
        for (volume, what) in [(&regular, "makes one of a mesh"), (&flat, "without volume")] {
            let why = refusal(&ENTRY, "", (volume, &ramp(&whole), &view));
            assert!(why.contains(what), "{why}");
        }
    }
}
