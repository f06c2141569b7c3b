//! The algorithm's entry: its settings, what it draws, how near to the truth.

use tetrascope_core::entry::Source;
use tetrascope_core::settings::words;
use tetrascope_core::{
    Appearance, Entry, Error, OpticalModel, Promise, Setting, Settings, TetMesh, Volume,
};

use crate::mesh::mesh_of;
use crate::options::{
    CellLayout, ExitSearch, Integration, Order, ProjectionOptions, Sort, SurfaceSearch,
};
use crate::{ABILITIES, NAME};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "view-independent cell projection",
    paper: "M. Weiler, M. Kraus, T. Ertl, \"Hardware-Based View-Independent Cell Projection\", \
            IEEE Symposium on Volume Visualization and Graphics, 2002, pp. 13-22",
    draws: "any mesh in every optical model; with emission and absorption cells are sorted by \
            their faces where that is known to be right, and else fragments in each pixel; \
            order=centroid is faster and not always right",
    settings: &[
        Setting::choice("order", &words(&Order::ALL), "auto").about(
            "the order of cells, where the optical model does not commute; auto is mpvo where \
             that is known to be right, else per-pixel",
        ),
        Setting::choice("sort", &words(&Sort::ALL), "auto").about(
            "where order=centroid sorts; auto is the CPU where the device is a software one",
        ),
        Setting::choice("integration", &words(&Integration::ALL), "exact")
            .about("how a ray's segment in a cell is integrated"),
        Setting::integer("table-size", [2, Integration::MOST_2D as i64], "128")
            .about("samples along each axis of a table; at most 256 with three axes"),
        Setting::choice("surfaces", &words(&SURFACES), "exact").about(
            "how isosurfaces are found in a cell: by the crossing, or by a table as published",
        ),
        Setting::integer("surface-table-size", [2, SurfaceSearch::MOST as i64], "256")
            .about("samples along each axis of a table of isosurfaces"),
        Setting::number("surface-thickness", [0.0, 16.0], "1")
            .about("how far isosurfaces in a table reach on either side, samples"),
        Setting::choice("exit", &words(&ExitSearch::ALL), "per-fragment").about(
            "where a ray's other crossing with a cell is found; at vertices for orthographic \
             cameras alone",
        ),
        Setting::integer("minimum-size", [2, ExitSearch::MOST as i64], "128")
            .about("samples along each axis of the texture of exit=per-vertex-texture"),
        Setting::choice("layout", &words(&CellLayout::ALL), "shared-vertices")
            .about("how cells lie in the device's memory; twelve vertices for exit=per-vertex"),
    ],
    sweep,
    promise,
    sources: &[
        Source {
            name: "table alone",
            with: "order=per-pixel,integration=table-3d,table-size=128",
            without: Some("order=per-pixel"),
        },
        Source {
            name: "order alone",
            with: "order=centroid",
            without: None,
        },
        Source {
            name: "both",
            with: "order=centroid,integration=table-3d,table-size=128",
            without: None,
        },
    ],
    figures: None,
    counters: crate::counters::ALL,
    supports: |volume, appearance, view, settings| {
        let options = ProjectionOptions::from_settings(settings);
        check(volume, appearance, &options)?;
        options.check_view(view)
    },
};

/// The mesh of `volume`, if it is drawn like this.
pub(crate) fn check<'a>(
    volume: &'a Volume,
    appearance: &Appearance,
    options: &ProjectionOptions,
) -> Result<&'a TetMesh, Error> {
    ABILITIES.check(NAME, appearance, &volume.bounds())?;
    options.validate(appearance)?;
    mesh_of(volume)
}

/// Tables are compared in an order that is exact, where their errors are the only ones.
fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::EmissionAbsorption => &[
            "",
            "order=centroid",
            "order=mpvo",
            "order=per-pixel",
            "order=per-pixel,integration=table-3d,table-size=32",
            "order=per-pixel,integration=table-3d,table-size=64",
            "order=per-pixel,integration=table-3d,table-size=128",
            "order=per-pixel,integration=table-3d,table-size=256",
            "order=centroid,integration=table-3d,table-size=128",
        ],
        OpticalModel::Absorption => &[
            "",
            "integration=table-2d,table-size=128",
            "integration=table-3d,table-size=32",
            "integration=table-3d,table-size=128",
        ],
        OpticalModel::Isosurfaces => &[
            "",
            "surfaces=table,surface-table-size=64",
            "surfaces=table,surface-table-size=256",
            "surfaces=table,surface-table-size=1024",
        ],
        OpticalModel::Emission => &[
            "",
            "exit=per-vertex,layout=twelve-floats",
            "exit=per-vertex,layout=twelve-shorts",
            "exit=per-vertex-texture,layout=twelve-floats,minimum-size=64",
            "exit=per-vertex-texture,layout=twelve-floats,minimum-size=256",
            "integration=table-2d,table-size=32",
            "integration=table-2d,table-size=128",
            "integration=table-2d,table-size=512",
        ],
        _ => &[
            "",
            "integration=table-2d,table-size=32",
            "integration=table-2d,table-size=128",
            "integration=table-2d,table-size=512",
        ],
    }
}

/// At a step of the transfer function a table errs by a share of the step, however fine
/// it is; the crate's tests hold tables to bounds for smooth ones.
fn promise(settings: &Settings) -> Promise {
    let exact = ["integration", "surfaces"].map(|name| settings.get(name) == "exact");
    // A ray through a vertex may miss a cell, and vertices in 16 bits are elsewhere.
    if settings.get("exit") != "per-fragment" {
        return Promise::Open;
    }
    match (exact, settings.get("order")) {
        ([true, true], "auto" | "per-pixel") => Promise::Exact,
        ([true, true], "mpvo") => Promise::ExactIfProven,
        ([true, true], _) => Promise::RoughOrder,
        _ => Promise::Open,
    }
}

/// Made for samples along each axis and a thickness.
type OfTable = fn(u32, f32) -> SurfaceSearch;

/// Ways to find isosurfaces.
const SURFACES: [(&str, OfTable); 2] = [
    ("exact", |_, _| SurfaceSearch::Exact),
    ("table", |n, thickness| SurfaceSearch::Table {
        n,
        thickness,
    }),
];

impl ProjectionOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> ProjectionOptions {
        let samples = |name| settings.integer(name) as u32;
        ProjectionOptions {
            order: settings.choice("order", &Order::ALL),
            sort: settings.choice("sort", &Sort::ALL),
            integration: settings.choice("integration", &Integration::ALL)(samples("table-size")),
            surfaces: settings.choice("surfaces", &SURFACES)(
                samples("surface-table-size"),
                settings.number("surface-thickness") as f32,
            ),
            exit_search: settings.choice("exit", &ExitSearch::ALL),
            minimum_side: samples("minimum-size"),
            cell_layout: settings.choice("layout", &CellLayout::ALL),
            fragment_bytes: 1 << 28,
            domain: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{CameraFit, DepthCue};
    use tetrascope_testing::{every_setting_arrives, fitted, kuhn, mesh, ramp, refusal};

    use super::*;

    #[test]
    fn every_setting_arrives_in_the_options() {
        every_setting_arrives(&ENTRY, ProjectionOptions::from_settings);
    }

    #[test]
    fn what_cannot_be_had_together_is_refused_without_a_device() {
        let volume = Volume::Mesh(mesh(kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true), |p| p.x));
        let (sorted, faded, surfaces) = (ramp(&volume), ramp(&volume), ramp(&volume));
        let faded = Appearance {
            depth_cue: Some(DepthCue { strength: 0.5 }),
            ..faded
        };
        let surfaces = Appearance {
            optical_model: OpticalModel::Isosurfaces,
            ..surfaces
        };
        let [parallel, perspective] =
            [true, false].map(|parallel| fitted(&volume, CameraFit::PlusIso, parallel, 8));
        for (look, view, settings, what) in [
            (&sorted, &perspective, "exit=per-vertex", "perspective"),
            (
                &sorted,
                &parallel,
                "exit=per-vertex,order=per-pixel",
                "per-pixel",
            ),
            (&faded, &parallel, "exit=per-vertex", "a depth cue"),
            (&surfaces, &parallel, "exit=per-vertex", "isosurfaces"),
            (
                &sorted,
                &parallel,
                "layout=twelve-floats",
                "twelve vertices",
            ),
            (&sorted, &parallel, "integration=table-2d", "two axes"),
            (
                &sorted,
                &parallel,
                "integration=table-3d,table-size=512",
                "512 samples",
            ),
            (
                &faded,
                &parallel,
                "integration=table-3d",
                "a depth cue with a table",
            ),
        ] {
            let why = refusal(&ENTRY, settings, (&volume, look, view));
            assert!(why.contains(what), "{settings}: {why}");
        }
    }
}
