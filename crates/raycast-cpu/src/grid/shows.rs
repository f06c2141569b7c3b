//! Which scalars leave a trace in an appearance.

use tetrascope_core::grid::coverage::fades;
use tetrascope_core::{Appearance, OpticalModel};

use super::pieces::Pieces;

/// The scalars that show, as inclusive intervals in f32, as samples are.
#[derive(Clone, Debug)]
pub(crate) struct Shows {
    /// Whether nothing does.
    nothing: bool,
    /// Intervals in which nothing shows, by increasing scalar.
    clear: Vec<[f32; 2]>,
    /// Isosurfaces in place of the volume: each is in a cell if `[low, high]` has both ends of
    /// one of these, the floats on both sides of the isovalue.
    values: Option<Vec<[f32; 2]>>,
    fades: bool,
}

impl Shows {
    /// The scalars of a grid that show; `fills_cells` where samples do, so that no surface is anywhere.
    pub(crate) fn new(appearance: &Appearance, pieces: &Pieces, fills_cells: bool) -> Shows {
        let model = appearance.optical_model;
        let values = (model == OpticalModel::Isosurfaces).then(|| {
            let surfaces = appearance.isosurfaces.iter();
            surfaces
                .map(|surface| [below(surface.value), above(surface.value)])
                .collect()
        });
        Shows {
            nothing: model == OpticalModel::Isosurfaces
                && (fills_cells || appearance.isosurfaces.is_empty()),
            clear: pieces.clear_intervals(model == OpticalModel::MaximumIntensity),
            values,
            fades: fades(model),
        }
    }

    /// Whether cells with a corner that has no value must be met: for surfaces, as what
    /// is on both sides of a gap is not connected.
    pub(crate) fn gaps(&self) -> bool {
        self.values.is_some() && !self.nothing
    }

    /// Whether coverage scales what shows.
    pub(crate) fn fades(&self) -> bool {
        self.fades
    }

    /// Whether anything shows among scalars from `low` to `high`; not where `low > high`.
    #[inline]
    pub(crate) fn range(&self, low: f32, high: f32) -> bool {
        if self.nothing || low > high {
            return false;
        }
        match &self.values {
            Some(values) => values.iter().any(|v| low <= v[0] && v[1] <= high),
            None => !self.clear.iter().any(|c| c[0] <= low && high <= c[1]),
        }
    }
}

/// The greatest float that is not above `scalar`.
pub(crate) fn below(scalar: f64) -> f32 {
    let single = scalar as f32;
    match f64::from(single) > scalar {
        true => single.next_down(),
        false => single,
    }
}

/// The least float that is not below `scalar`.
pub(crate) fn above(scalar: f64) -> f32 {
    let single = scalar as f32;
    match f64::from(single) < scalar {
        true => single.next_up(),
        false => single,
    }
}
