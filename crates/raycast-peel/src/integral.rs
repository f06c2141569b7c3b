//! The data with which both ways of stepping integrate: a table of segments' integrals, and how sides are
//! decided.

use tetrascope_core::{Appearance, Error, OpticalModel, TetMesh};
use tetrascope_f32::{KnotPair, mean_chord};
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::{Gpu, Integration, sides};

use crate::NAME;
use crate::options::RaycastOptions;

/// The segments that a table is made for.
pub(crate) struct Segments<'a> {
    pub(crate) mesh: &'a TetMesh,
    /// World units in a normalized unit.
    pub(crate) scale: f64,
    pub(crate) intervals: &'a [KnotPair],
    /// The longest that there can be, normalized.
    pub(crate) longest: f32,
    /// The least and the greatest scalar, mapped.
    pub(crate) scalars: (f32, f32),
}

/// The table that the options ask for: `last` if that is it.
pub(crate) fn table(
    gpu: &Gpu,
    appearance: &Appearance,
    segments: &Segments,
    options: &RaycastOptions,
    last: Option<&Table>,
) -> Result<Table, Error> {
    let model = appearance.optical_model;
    let integration = match model {
        OpticalModel::Isosurfaces => Integration::Exact,
        _ => options.integration,
    };
    let fixed = || preintegration::Fixed {
        length: (mean_chord(segments.mesh) / segments.scale) as f32,
        scalars: segments.scalars,
    };
    let is_fixed = matches!(integration, Integration::TableFixed { .. });
    let source = preintegration::Source {
        integration,
        model,
        intervals: segments.intervals,
        longest: segments.longest,
        fixed: is_fixed.then(fixed),
    };
    match last {
        Some(last) => last.renewed(gpu, NAME, &source),
        None => Table::new(gpu, NAME, &source),
    }
}

/// The constant of `sides.wgsl`.
pub(crate) fn sides_constant(
    gpu: &Gpu,
    options: &RaycastOptions,
) -> Result<(&'static str, f64), Error> {
    match options.integer_sides {
        true => Ok(sides::integer_sides(true)),
        false => sides::constant(gpu),
    }
}
