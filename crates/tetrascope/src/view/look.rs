//! Colors and opacities as a person edits them, beside the function that is drawn.

use tetrascope_core::colormap::Colormap;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{Appearance, Error, Isosurface, Knot, TransferFunction};
use tetrascope_scene::{ColorSpace, IsosurfaceSpec, OpacityPoint, Preset};

/// The look that is edited.
///
/// As long as only the range and the unit distance change, the function that is drawn keeps the very
/// knots that a scene has given, moved and scaled; points that are edited make new ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    pub(crate) preset: Preset,
    /// The map of the preset's colors, if it has a name.
    pub(crate) colormap: Option<Colormap>,
    /// The distance over which the preset's opacities count, world units.
    pub(crate) unit_distance: f64,
    /// As written: a surface without a color has the function's.
    pub(crate) surfaces: Vec<IsosurfaceSpec>,
}

impl Look {
    /// The look of an appearance that is complete; `colormap` is the map of its colors, if it is
    /// known, and opacities count over `unit_distance`.
    pub(crate) fn of(
        appearance: &Appearance,
        colormap: Option<Colormap>,
        unit_distance: f64,
    ) -> Look {
        let (mut preset, _) = Preset::of(&appearance.transfer_function, unit_distance);
        if let Some(map) = colormap {
            preset.name = map.name().into();
            preset.colors = Preset::colors_of(map, appearance.transfer_function.range());
        }
        let surfaces = appearance.isosurfaces.iter();
        let function = &appearance.transfer_function;
        let surfaces = surfaces.map(|surface| IsosurfaceSpec {
            value: surface.value,
            // One that has the function's color keeps having it.
            color: Some(surface.color).filter(|color| *color != color_at(function, surface.value)),
        });
        Look {
            preset,
            colormap,
            unit_distance,
            surfaces: surfaces.collect(),
        }
    }

    /// The surfaces, each with a color.
    pub(crate) fn isosurfaces(&self, function: &TransferFunction) -> Vec<Isosurface> {
        let surfaces = self.surfaces.iter();
        let surfaces = surfaces.map(|surface| Isosurface {
            value: surface.value,
            color: surface
                .color
                .unwrap_or_else(|| color_at(function, surface.value)),
        });
        surfaces.collect()
    }

    /// The colors of a map over the range there is.
    pub(crate) fn set_colormap(&mut self, map: Colormap) {
        self.preset.colors = Preset::colors_of(map, self.preset.range());
        self.preset.color_space = ColorSpace::Rgb;
        self.preset.name = map.name().into();
        self.colormap = Some(map);
    }

    /// Other points; `keep_colors` takes only the opacities.
    pub(crate) fn set_points(
        &mut self,
        mut preset: Preset,
        keep_colors: bool,
    ) -> Result<(), Error> {
        if keep_colors {
            preset.colors.clone_from(&self.preset.colors);
            preset.color_space = self.preset.color_space;
            preset.name.clone_from(&self.preset.name);
        }
        preset.validate()?;
        if !keep_colors {
            self.colormap = None;
        }
        self.preset = preset;
        Ok(())
    }
}

/// The color that the function shows at a scalar, white where it shows nothing.
fn color_at(function: &TransferFunction, scalar: f64) -> DVec3 {
    function
        .sample(scalar)
        .map_or(DVec3::ONE, |(color, _)| color)
}

/// The same function over another range.
pub(crate) fn moved(
    function: &TransferFunction,
    (low, high): (f64, f64),
) -> Result<TransferFunction, Error> {
    let (from, to) = function.range();
    let move_to = |scalar: f64| match from < to {
        true => {
            let place = (scalar * 0.5 - from * 0.5) / (to * 0.5 - from * 0.5);
            low * (1.0 - place) + high * place
        }
        false => low,
    };
    let knots = function.knots().iter().map(|knot| Knot {
        scalar: move_to(knot.scalar),
        ..*knot
    });
    TransferFunction::new(knots.collect())
}

/// The same function with extinctions times `factor`.
pub(crate) fn thicker(function: &TransferFunction, factor: f64) -> Result<TransferFunction, Error> {
    let knots = function.knots().iter().map(|knot| Knot {
        extinction: knot.extinction * factor,
        ..*knot
    });
    TransferFunction::new(knots.collect())
}

/// Opacity that rises from 0 to 1 over a range.
pub(crate) fn ramp((low, high): (f64, f64)) -> Vec<OpacityPoint> {
    match low < high {
        true => vec![OpacityPoint::new(low, 0.0), OpacityPoint::new(high, 1.0)],
        false => vec![OpacityPoint::new(low, 0.5)],
    }
}
