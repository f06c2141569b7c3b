//! Ray casting's entry.

use tetrascope_core::{Error, Volume};
use tetrascope_raycast_peel::{ABILITIES, Locality, NAME, RaycastOptions, RaycastPeel};

use super::{Algorithm, choice};
use crate::{Setting, Settings, Values};

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
    sweep: |_| &["", "stop-opacity=0.999", "stop-opacity=0.95"],
    admits: |settings| 1.0 - settings.number("stop-opacity"),
    supports: |volume, appearance, _| {
        ABILITIES.check(NAME, appearance)?;
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
        Ok(Box::new(renderer))
    },
};

fn options(settings: &Settings) -> RaycastOptions {
    RaycastOptions {
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
