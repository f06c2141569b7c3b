//! The cases once more in the other optical models.
//!
//! A hard mesh, view or field is hard in each: extinction that is integrated, a greatest value and a surface
//! come from other code, and fail elsewhere.

use tetrascope::core::{Appearance, DirectionalLight, Isosurface, Lighting, OpticalModel};

use super::case::{Case, Expected, Shot};

/// The models beside emission and absorption, in which the suite is written.
pub const OTHERS: [OpticalModel; 4] = [
    OpticalModel::Emission,
    OpticalModel::Absorption,
    OpticalModel::MaximumIntensity,
    OpticalModel::Isosurfaces,
];

/// Where surfaces lie between a transfer function's first knot and its last, and their colors: on no value
/// that a test field has at many places.
const SURFACES: [(f64, [f64; 3]); 3] = [
    (0.617, [1.0, 0.3, 0.1]),
    (0.331, [0.2, 0.5, 1.0]),
    (0.489, [0.3, 0.9, 0.2]),
];

/// The case in another model; `None` for its own, where its expectation is one of its own model, or where no value fits
/// between two knots.
pub(super) fn under(model: OpticalModel, case: &Case) -> Option<Case> {
    let is_usual = |shot: &Shot| shot.appearance.optical_model == OpticalModel::EmissionAbsorption;
    let expected = match case.expected {
        Expected::Truth => Expected::Truth,
        Expected::Same => Expected::Same,
        Expected::Light(_) | Expected::Law(..) => return None,
    };
    let is_its_own = model == OpticalModel::EmissionAbsorption;
    if is_its_own || !case.shots.iter().all(is_usual) || case.is_of_one_model {
        return None;
    }
    let shots = case.shots.iter().map(|shot| {
        let appearance = match model {
            OpticalModel::Isosurfaces => surfaces(shot)?,
            _ => Appearance {
                optical_model: model,
                ..shot.appearance.clone()
            },
        };
        Some(Shot {
            appearance,
            ..shot.clone()
        })
    });
    Some(Case {
        name: format!("{}, {}", case.name, model.name()),
        shots: shots.collect::<Option<Vec<_>>>()?,
        expected,
        holds_for_all: false,
        ..*case
    })
}

/// Surfaces in place of the shot's volume, lit from where its camera is: turned and mirrored with it,
/// they look the same. `None` where a value does not fit between two knots.
pub fn surfaces(shot: &Shot) -> Option<Appearance> {
    let knots = shot.appearance.transfer_function.knots();
    let (low, high) = (knots.first()?.scalar, knots.last()?.scalar);
    let at = |share: f64| low + share * (high - low);
    let fit = |(share, _): &(f64, _)| low < at(*share) && at(*share) < high;
    if !SURFACES.iter().all(fit) {
        return None;
    }
    let (_, up, forward) = shot.view.camera.axes();
    let light = |toward, color: [f64; 3]| DirectionalLight {
        toward,
        color: color.into(),
    };
    Some(Appearance {
        optical_model: OpticalModel::Isosurfaces,
        isosurfaces: SURFACES
            .map(|(share, color)| Isosurface {
                value: at(share),
                color: color.into(),
            })
            .into(),
        lighting: Lighting {
            ambient: 0.15,
            lights: vec![
                light(up - forward, [0.7, 0.6, 0.5]),
                light(-up - 0.3 * forward, [0.2, 0.3, 0.6]),
            ],
        },
        ..shot.appearance.clone()
    })
}
