//! The algorithm's entry: its settings, what it draws, how near to the truth.

use tetrascope_core::settings::words;
use tetrascope_core::{
    Appearance, Entry, Error, OpticalModel, Promise, Setting, Settings, TetMesh, Volume,
};

use crate::NAME;
use crate::options::{
    Crossings, Entries, INTEGRATIONS, Integration, Locality, MAX_TILES, Passes, RaycastOptions,
};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "watertight ray casting from cell to cell",
    paper: "F. Bernardon, C. Pagot, J. Comba, C. Silva, \"GPU-based Tiled Ray Casting using Depth \
            Peeling\", Technical Report UUSCI-2004-006, University of Utah, 2004",
    draws: "any mesh in every optical model, in the order of visibility; where cells overlap, in \
            the order in which they are connected",
    settings: &[
        Setting::choice("passes", &words(&Passes::ALL), "single")
            .about("whether one pass takes all steps of a ray, or one step as published"),
        Setting::choice("integration", &words(&INTEGRATIONS), "exact")
            .about("how a ray's segment in a cell is integrated"),
        Setting::integer("table-size", [2, Integration::MOST_2D as i64], "128")
            .about("samples along each axis of a table; at most 256 with three axes"),
        Setting::choice("entries", &words(&Entries::ALL), "lists").about(
            "how rays find boundary faces: by lists for tiles of the image, or by layers \
             peeled before; single passes only",
        ),
        Setting::integer("tiles", [1, MAX_TILES as i64], "4")
            .about("tiles along each side of the image; ping-pong only"),
        Setting::integer("query-interval", [1, 1024], "8")
            .about("passes between two occlusion queries; ping-pong only"),
        Setting::choice("crossings", &words(&Crossings::ALL), "sides").about(
            "how rays cross faces: by sides as single passes do, or by planes with a bias as \
             published; ping-pong only",
        ),
        Setting::number("stop-opacity", [0.5, 1.0], "1")
            .about("the opacity at which a ray stops; 1 is exact, the paper has 0.95"),
        Setting::choice("locality", &words(&Locality::ALL), "morton")
            .about("the order of cells and vertices in memory"),
    ],
    sweep,
    promise,
    sources: &[],
    figures: None,
    counters: crate::counters::ALL,
    supports: |volume, appearance, _, settings| {
        check(volume, appearance, &RaycastOptions::from_settings(settings)).map(drop)
    },
};

/// The mesh of `volume`, if it is drawn like this.
pub(crate) fn check<'a>(
    volume: &'a Volume,
    appearance: &Appearance,
    options: &RaycastOptions,
) -> Result<&'a TetMesh, Error> {
    options.check(appearance, &volume.bounds())?;
    tetrahedra(volume)
}

/// One step per pass is compared in one model: it takes seconds a frame on a software adapter.
fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::EmissionAbsorption => &[
            "",
            "stop-opacity=0.999",
            "stop-opacity=0.95",
            "integration=table-3d,table-size=64",
            "passes=ping-pong",
            "passes=ping-pong,crossings=planes",
        ],
        _ => &[""],
    }
}

/// At a step of the transfer function a table errs by a share of the step, however fine
/// it is, and where ping-pong passes cross planes the rasterizer's guess decides about rays
/// near an outline; the crate's tests hold both to bounds.
fn promise(settings: &Settings) -> Promise {
    let left_out = 1.0 - settings.number("stop-opacity");
    let by_sides = settings.get("passes") == "single" || settings.get("crossings") == "sides";
    match by_sides && settings.get("integration") == "exact" {
        true if left_out == 0.0 => Promise::Exact,
        true => Promise::Within(left_out),
        false => Promise::Open,
    }
}

impl RaycastOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> RaycastOptions {
        let side = settings.integer("table-size") as u32;
        RaycastOptions {
            passes: settings.choice("passes", &Passes::ALL),
            integration: settings.choice("integration", &INTEGRATIONS)(side),
            entries: settings.choice("entries", &Entries::ALL),
            tiles: settings.integer("tiles") as u32,
            query_interval: settings.integer("query-interval") as u32,
            crossings: settings.choice("crossings", &Crossings::ALL),
            stop_opacity: settings.number("stop-opacity") as f32,
            locality: settings.choice("locality", &Locality::ALL),
            integer_sides: false,
            // λ of a plane is a quotient of sums of three products of numbers up to 4: each
            // term rounds by 2⁻²², so steep faces err by less than 2⁻¹⁹ of half an extent.
            peel_bias: 1.0 / (1 << 19) as f32,
            domain: None,
        }
    }
}

/// The mesh of `volume`.
pub(crate) fn tetrahedra(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        Volume::Clusters(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes in clusters".into(),
            reason: "it needs all cells at once".into(),
        }),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it walks from tetrahedron to tetrahedron".into(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{CameraFit, DepthCue, Knot, TransferFunction};
    use tetrascope_testing::{every_setting_arrives, fitted, kuhn, mesh, ramp, refusal, surfaces};

    use super::*;

    #[test]
    fn every_setting_arrives_in_the_options() {
        every_setting_arrives(&ENTRY, RaycastOptions::from_settings);
    }

    #[test]
    fn what_cannot_be_had_together_is_refused_without_a_device() {
        let volume = Volume::Mesh(mesh(kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true), |p| p.x));
        let sorted = ramp(&volume);
        let faded = Appearance {
            depth_cue: Some(DepthCue { strength: 0.5 }),
            ..ramp(&volume)
        };
        let few = surfaces(&volume, ramp(&volume));
        let many = Appearance {
            isosurfaces: vec![few.isosurfaces[0]; 1001],
            ..few.clone()
        };
        let knots = |count: usize| {
            let knot = |i: usize| Knot {
                scalar: i as f64,
                ..sorted.transfer_function.knots()[0]
            };
            let function = TransferFunction::new((0..count).map(knot).collect());
            Appearance::new(function.expect("sorted"), OpticalModel::Emission)
        };
        let view = fitted(&volume, CameraFit::PlusIso, true, 8);
        for (look, settings, what) in [
            (
                &few,
                "passes=ping-pong",
                "isosurfaces with passes=ping-pong",
            ),
            (
                &faded,
                "passes=ping-pong",
                "a depth cue with passes=ping-pong",
            ),
            (&faded, "integration=table-3d", "a depth cue with a table"),
            (&sorted, "integration=table-2d", "two axes"),
            (&many, "", "isosurfaces needs 1001"),
            (&knots(16_384), "passes=ping-pong", "intervals"),
            (&knots(16_385), "", "knots"),
        ] {
            let why = refusal(&ENTRY, settings, (&volume, look, &view));
            assert!(why.contains(what), "{settings}: {why}");
        }
    }
}
