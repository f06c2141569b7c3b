//! Appearances.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, ClipPlane, DirectionalLight, Isosurface, Knot, Lighting, OpticalModel,
    TransferFunction, Volume,
};
use tetrascope_datasets::find;

/// A knot with this linear RGB and extinction.
pub fn knot(scalar: f64, color: impl Into<DVec3>, extinction: f64) -> Knot {
    Knot {
        scalar,
        color: color.into(),
        extinction,
    }
}

/// A data set's own transfer function, in emission and absorption.
pub fn look_of(data_set: &str) -> Appearance {
    let knots = find(data_set).expect("a data set").look().knots;
    let function = TransferFunction::new(knots).expect("valid knots");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

/// A ramp over the volume's scalars, dense enough to hide its back.
pub fn ramp(volume: &Volume) -> Appearance {
    let (low, high) = volume.scalar_range().expect("scalars");
    let size = volume.bounds().diagonal();
    let knot =
        |share, color: [f64; 3], depth| knot(low + share * (high - low), color, depth / size);
    let function = TransferFunction::new(vec![
        knot(0.0, [0.1, 0.2, 0.8], 1.0),
        knot(0.4, [0.2, 0.9, 0.4], 3.0),
        knot(1.0, [1.0, 0.3, 0.1], 20.0),
    ]);
    let function = function.expect("valid knots");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

/// Two planes that cut corners of a volume off, along no axis.
pub fn tilted(volume: &Volume) -> Vec<ClipPlane> {
    let bounds = volume.bounds();
    let plane = |share: f64, normal: [f64; 3]| ClipPlane {
        point: bounds.min + DVec3::splat(share) * bounds.size(),
        normal: normal.into(),
    };
    vec![plane(0.37, [1.0, 0.3, 0.6]), plane(0.71, [-0.2, -1.0, 0.1])]
}

/// `appearance` with three surfaces in the volume's range and two lights.
pub fn surfaces(volume: &Volume, appearance: Appearance) -> Appearance {
    let (low, high) = volume.scalar_range().expect("a field");
    let surface = |share: f64, color: [f64; 3]| Isosurface {
        value: low + share * (high - low),
        color: color.into(),
    };
    let light = |toward: [f64; 3], color: [f64; 3]| DirectionalLight {
        toward: toward.into(),
        color: color.into(),
    };
    Appearance {
        optical_model: OpticalModel::Isosurfaces,
        isosurfaces: vec![
            surface(0.717, [1.0, 0.3, 0.1]),
            surface(0.231, [0.2, 0.5, 1.0]),
            surface(0.489, [0.3, 0.9, 0.2]),
        ],
        lighting: Lighting {
            ambient: 0.15,
            lights: vec![
                light([1.0, 2.0, 3.0], [0.7, 0.6, 0.5]),
                light([-2.0, 1.0, -1.0], [0.2, 0.3, 0.6]),
            ],
        },
        ..appearance
    }
}
