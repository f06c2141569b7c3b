//! Regular grids.

use tetrascope_core::{Appearance, Error, Frame, Grid, View};

use crate::options::RaycastCpuOptions;

/// A grid in bricks.
#[derive(Debug)]
pub(crate) struct Caster {}

impl Caster {
    pub(crate) fn new(
        _grid: &Grid,
        _appearance: &Appearance,
        _options: &RaycastCpuOptions,
    ) -> Result<Caster, Error> {
        todo!()
    }

    pub(crate) fn restyle(&mut self, _appearance: &Appearance) -> Result<(), Error> {
        todo!()
    }

    /// Draws a valid view; each ray ends where `ends` says, world units, one a pixel.
    pub(crate) fn draw(&self, _view: &View, _ends: Option<&[f64]>) -> Result<Frame, Error> {
        todo!()
    }
}
