//! Ray casting's entry.

use tetrascope_core::{Error, OpticalModel, Volume};
use tetrascope_raycast_peel::{
    ABILITIES, Crossings, Entries, INTEGRATIONS, Integration, Locality, MAX_TILES, NAME, Passes,
    RaycastOptions, RaycastPeel,
};

use super::{Algorithm, Promise, choice};
use crate::{Renderer, Setting, Settings, Values};

pub(super) const ALGORITHM: Algorithm = Algorithm {
    name: NAME,
    title: "watertight ray casting from cell to cell",
    paper: "F. Bernardon, C. Pagot, J. Comba, C. Silva, \"GPU-based Tiled Ray Casting using Depth \
            Peeling\", Technical Report UUSCI-2004-006, University of Utah, 2004",
    draws: "any mesh in every optical model, in the order of visibility; where cells overlap, in \
            the order in which they are connected",
    needs_gpu: true,
    settings: &[
        Setting {
            name: "passes",
            about: "whether one pass takes all steps of a ray, or one step as published",
            values: Values::Choice(&["single", "ping-pong"]),
            default: "single",
        },
        Setting {
            name: "integration",
            about: "how a ray's segment in a cell is integrated",
            values: Values::Choice(&["exact", "table-2d", "table-2d-fixed", "table-3d"]),
            default: "exact",
        },
        Setting {
            name: "table-size",
            about: "samples along each axis of a table; at most 256 with three axes",
            values: Values::Integer {
                min: 2,
                max: Integration::MOST_2D as i64,
            },
            default: "128",
        },
        Setting {
            name: "entries",
            about: "how rays find boundary faces: by lists for tiles of the image, or by layers \
                    peeled before; single passes only",
            values: Values::Choice(&["lists", "layers"]),
            default: "lists",
        },
        Setting {
            name: "tiles",
            about: "tiles along each side of the image; ping-pong only",
            values: Values::Integer {
                min: 1,
                max: MAX_TILES as i64,
            },
            default: "4",
        },
        Setting {
            name: "query-interval",
            about: "passes between two occlusion queries; ping-pong only",
            values: Values::Integer { min: 1, max: 1024 },
            default: "8",
        },
        Setting {
            name: "crossings",
            about: "how rays cross faces: by sides as single passes do, or by planes with a bias \
                    as published; ping-pong only",
            values: Values::Choice(&["sides", "planes"]),
            default: "sides",
        },
        Setting {
            name: "stop-opacity",
            about: "the opacity at which a ray stops; 1 is exact, the paper has 0.95",
            values: Values::Number { min: 0.5, max: 1.0 },
            default: "1",
        },
        Setting {
            name: "locality",
            about: "the order of cells and vertices in memory",
            values: Values::Choice(&["morton", "as-given"]),
            default: "morton",
        },
    ],
    sweep,
    promise,
    supports: |volume, appearance, _| {
        ABILITIES.check(NAME, appearance, &volume.bounds())?;
        match volume {
            Volume::Mesh(_) => Ok(()),
            _ => Err(Error::Unsupported {
                renderer: NAME,
                what: "regular grids".into(),
                reason: "it walks from tetrahedron to tetrahedron".into(),
            }),
        }
    },
    build: |context, volume, appearance, settings| {
        let options = options(settings);
        let renderer = RaycastPeel::new(context.gpu()?, volume, appearance, &options)?;
        Ok(Renderer::Gpu(Box::new(renderer)))
    },
};

/// A step a pass is compared in one model: it takes seconds a frame on a software adapter.
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

fn options(settings: &Settings) -> RaycastOptions {
    let table_size = settings.integer("table-size") as u32;
    RaycastOptions {
        passes: choice(settings, "passes", &Passes::ALL),
        integration: choice(settings, "integration", &INTEGRATIONS)(table_size),
        entries: choice(settings, "entries", &Entries::ALL),
        tiles: settings.integer("tiles") as u32,
        query_interval: settings.integer("query-interval") as u32,
        crossings: choice(settings, "crossings", &Crossings::ALL),
        stop_opacity: settings.number("stop-opacity") as f32,
        locality: choice(settings, "locality", &Locality::ALL),
        ..RaycastOptions::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_crate() {
        let defaults = Settings::defaults(&ALGORITHM);
        assert_eq!(options(&defaults), RaycastOptions::default());
    }
}
