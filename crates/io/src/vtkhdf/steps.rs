//! The group `Steps`: the times of a file, and where each step's numbers begin.

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use crate::hdf5::{Dataset, Group};

/// More are not read.
const MOST_STEPS: u64 = 1 << 20;

/// See [`Steps::of`].
#[derive(Clone)]
pub(super) struct Steps {
    group: Group,
    pub(super) times: Vec<f64>,
}

impl Steps {
    /// The steps of a group, if it has any.
    pub(super) fn of(group: &Group) -> Result<Option<Steps>, Error> {
        let Some(group) = group.group("Steps")? else {
            return Ok(None);
        };
        let number = group.numbers("NSteps")?.unwrap_or_default();
        let Some(&number) = number.first() else {
            return Err(group.error("there is no attribute 'NSteps'"));
        };
        let Some(values) = group.dataset("Values")? else {
            return Err(group.error("there is no dataset 'Values'"));
        };
        let times = values.all(MOST_STEPS)?;
        if times.len() as f64 != number {
            return Err(group.error(format!("{} times of {number} steps", times.len())));
        }
        Ok(Some(Steps { group, times }))
    }

    /// The number that a dataset holds for a step, if it is there.
    pub(super) fn at(&self, name: &str, step: usize) -> Result<Option<u64>, Error> {
        let dataset = self.group.dataset(name)?;
        dataset.map(|dataset| place(&dataset, step)).transpose()
    }

    /// Where the numbers of an array begin, by its first dimension, if the file says so.
    pub(super) fn array(
        &self,
        association: Association,
        name: &str,
        step: usize,
    ) -> Result<Option<u64>, Error> {
        let group = match association {
            Association::Point => "PointDataOffsets",
            Association::Cell => "CellDataOffsets",
        };
        let Some(group) = self.group.group(group)? else {
            return Ok(None);
        };
        let dataset = group.dataset(name)?;
        dataset.map(|dataset| place(&dataset, step)).transpose()
    }
}

/// The first number of a row.
fn place(dataset: &Dataset, step: usize) -> Result<u64, Error> {
    let step = step as u64;
    let row = dataset.view(&[], step..step.saturating_add(1))?;
    if row.count() != 1 {
        return Err(dataset.error("it needs one number for each step"));
    }
    Ok(row.indices()?[0])
}
