//! Cell projection's entry.

use tetrascope_core::{Error, OpticalModel, Volume};
use tetrascope_projection::{
    ABILITIES, CellLayout, ExitSearch, Integration, NAME, Order, Projection, ProjectionOptions,
    Sort, SurfaceSearch,
};

use super::{Algorithm, Promise, choice};
use crate::{Renderer, Setting, Settings, Values};

pub(super) const ALGORITHM: Algorithm = Algorithm {
    name: NAME,
    title: "view-independent cell projection",
    paper: "M. Weiler, M. Kraus, T. Ertl, \"Hardware-Based View-Independent Cell Projection\", \
            IEEE Symposium on Volume Visualization and Graphics, 2002, pp. 13-22",
    draws: "any mesh in every optical model; with emission and absorption cells are sorted by \
            their faces where that is known to be right, and else fragments in each pixel; \
            order=centroid is faster and not always right",
    needs_gpu: true,
    settings: &[
        Setting {
            name: "order",
            about: "the order of cells, where the optical model does not commute; auto is mpvo \
                    where that is known to be right, else per-pixel",
            values: Values::Choice(&["auto", "unsorted", "centroid", "mpvo", "per-pixel"]),
            default: "auto",
        },
        Setting {
            name: "sort",
            about: "where order=centroid sorts; auto is the CPU where the device is a software one",
            values: Values::Choice(&["auto", "gpu", "cpu"]),
            default: "auto",
        },
        Setting {
            name: "integration",
            about: "how a ray's segment in a cell is integrated",
            values: Values::Choice(&["exact", "table-2d", "table-3d"]),
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
            name: "surfaces",
            about: "how isosurfaces are found in a cell: by the crossing, or by a table as published",
            values: Values::Choice(&["exact", "table"]),
            default: "exact",
        },
        Setting {
            name: "surface-table-size",
            about: "samples along each axis of a table of isosurfaces",
            values: Values::Integer {
                min: 2,
                max: SurfaceSearch::MOST as i64,
            },
            default: "256",
        },
        Setting {
            name: "surface-thickness",
            about: "how far isosurfaces in a table reach on either side, samples",
            values: Values::Number {
                min: 0.0,
                max: 16.0,
            },
            default: "1",
        },
        Setting {
            name: "exit",
            about: "where a ray's other crossing with a cell is found; at vertices for orthographic \
                    cameras alone",
            values: Values::Choice(&["per-fragment", "per-vertex", "per-vertex-texture"]),
            default: "per-fragment",
        },
        Setting {
            name: "minimum-size",
            about: "samples along each axis of the texture of exit=per-vertex-texture",
            values: Values::Integer {
                min: 2,
                max: ExitSearch::MOST as i64,
            },
            default: "128",
        },
        Setting {
            name: "layout",
            about: "how cells lie in the device's memory; twelve vertices for exit=per-vertex",
            values: Values::Choice(&["shared-vertices", "twelve-floats", "twelve-shorts"]),
            default: "shared-vertices",
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
                reason: "it projects the cells of a tetrahedral mesh".into(),
            }),
        }
    },
    build: |context, volume, appearance, settings| {
        let options = options(settings);
        let renderer = Projection::new(context.gpu()?, volume, appearance, &options)?;
        Ok(Renderer::Gpu(Box::new(renderer)))
    },
};

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

fn options(settings: &Settings) -> ProjectionOptions {
    ProjectionOptions {
        order: choice(settings, "order", &Order::ALL),
        sort: choice(settings, "sort", &Sort::ALL),
        integration: choice(settings, "integration", &Integration::ALL)(
            settings.integer("table-size") as u32,
        ),
        surfaces: match settings.get("surfaces") {
            "exact" => SurfaceSearch::Exact,
            _ => SurfaceSearch::Table {
                n: settings.integer("surface-table-size") as u32,
                thickness: settings.number("surface-thickness") as f32,
            },
        },
        exit_search: choice(settings, "exit", &ExitSearch::ALL),
        cell_layout: choice(settings, "layout", &CellLayout::ALL),
        minimum_side: settings.integer("minimum-size") as u32,
        ..ProjectionOptions::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algorithms::words;

    #[test]
    fn the_settings_are_those_of_the_crate_with_its_defaults() {
        let offered = |name| words::offered(&ALGORITHM, name);
        assert_eq!(offered("order"), words::of(&Order::ALL));
        assert_eq!(offered("sort"), words::of(&Sort::ALL));
        assert_eq!(offered("integration"), words::of(&Integration::ALL));
        assert_eq!(offered("exit"), words::of(&ExitSearch::ALL));
        assert_eq!(offered("layout"), words::of(&CellLayout::ALL));
        let defaults = Settings::defaults(&ALGORITHM);
        assert_eq!(options(&defaults), ProjectionOptions::default());
    }
}
