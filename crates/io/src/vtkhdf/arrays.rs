//! Point and cell data.

use std::ops::Range;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use super::{MOST_ARRAYS, Step};
use crate::MeshData;
use crate::fields::MOST_COMPONENTS;
use crate::grid::number::Number;
use crate::hdf5::{Dataset, Group, View};

/// An array of point or cell data.
pub(super) struct FieldArray {
    pub(super) name: String,
    pub(super) dataset: Dataset,
    pub(super) number: Number,
    pub(super) active: bool,
    /// Numbers of a tuple.
    pub(super) components: u64,
    /// Its row of the step's first point or cell.
    start: u64,
    /// All of it, if it lies on a lattice.
    lattice: Option<View>,
}

/// Calls `add` with each dataset of point or cell data that holds numbers, and where the file
/// says that the step begins in it. What is left out, by `add` with a reason, goes to `left_out`.
fn each_array(
    group: &Group,
    association: Association,
    step: Step,
    left_out: &mut Vec<(String, String)>,
    mut add: impl FnMut(FieldArray, Option<u64>) -> Result<Option<String>, Error>,
) -> Result<(), Error> {
    let data = match association {
        Association::Point => "PointData",
        Association::Cell => "CellData",
    };
    let Some(data) = group.group(data)? else {
        return Ok(());
    };
    let (_, names) = data.members()?;
    if names.len() > MOST_ARRAYS {
        return Err(data.error(format!(
            "{} arrays; up to {MOST_ARRAYS} are read",
            names.len()
        )));
    }
    let active = data.text("Scalars")?;
    for name in names {
        let Some(dataset) = data.dataset(&name)? else {
            continue;
        };
        let why = match dataset.number() {
            None => Some("it holds no numbers of 8 to 64 bits".to_owned()),
            Some(number) => {
                let start = match step {
                    Some((steps, step)) => steps.array(association, &name, step)?,
                    None => None,
                };
                let mark = dataset.attribute_text("Attribute");
                let array = FieldArray {
                    active: active.as_ref() == Some(&name) || mark.as_deref() == Some("Scalars"),
                    name: name.clone(),
                    dataset,
                    number,
                    components: 1,
                    start: 0,
                    lattice: None,
                };
                add(array, start)?
            }
        };
        left_out.extend(why.map(|why| (name, why)));
    }
    Ok(())
}

/// The arrays of an unstructured grid whose step begins at point or cell `first`.
pub(super) fn listed_arrays(
    group: &Group,
    association: Association,
    (step, first): (Step, u64),
    data: &mut MeshData,
) -> Result<Vec<FieldArray>, Error> {
    let mut arrays = Vec::new();
    let left_out = &mut data.left_out;
    each_array(group, association, step, left_out, |array, start| {
        let shape = array.dataset.shape().get(1..).unwrap_or_default();
        let components = shape.iter().fold(1, |n: u64, d| n.saturating_mul(*d));
        if !(1..=MOST_COMPONENTS as u64).contains(&components) {
            return Ok(Some(too_many(components)));
        }
        arrays.push(FieldArray {
            components,
            start: start.unwrap_or(first),
            ..array
        });
        Ok(None)
    })?;
    note_left_out(data);
    Ok(arrays)
}

fn too_many(components: u64) -> String {
    format!("it has {components} components; 1 to {MOST_COMPONENTS} are read")
}

/// The arrays of a grid of `points` along each axis.
pub(super) fn lattice_arrays(
    group: &Group,
    association: Association,
    (points, step): ([u64; 3], Step),
    left_out: &mut Vec<(String, String)>,
) -> Result<Vec<FieldArray>, Error> {
    let [i, j, k] = match association {
        Association::Point => points,
        Association::Cell => points.map(|n| n.saturating_sub(1)),
    };
    let mut arrays = Vec::new();
    each_array(group, association, step, left_out, |array, start| {
        let shape = array.dataset.shape();
        // A step is a place of a dimension before the others.
        let (place, tuples) = match (step, shape) {
            (Some((_, step)), [_, tuples @ ..]) => (Some(start.unwrap_or(step as u64)), tuples),
            _ => (None, shape),
        };
        let components = match tuples {
            [z, y, x, rest @ ..] if [z, y, x] == [&k, &j, &i] && rest.len() <= 1 => {
                rest.first().copied().unwrap_or(1)
            }
            _ => {
                return Err(array.dataset.error(format!(
                    "it has {tuples:?} values where {:?} are needed",
                    [k, j, i]
                )));
            }
        };
        if !(1..=MOST_COMPONENTS as u64).contains(&components) {
            return Ok(Some(too_many(components)));
        }
        let view = array.dataset.view(place.as_slice(), 0..k)?;
        arrays.push(FieldArray {
            components,
            lattice: Some(view),
            ..array
        });
        Ok(None)
    })?;
    Ok(arrays)
}

/// Says what was left out and is not in a note yet.
pub(super) fn note_left_out(data: &mut MeshData) {
    for (name, why) in &data.left_out {
        let note = format!("array '{name}' left out: {why}");
        if !data.notes.contains(&note) {
            data.notes.push(note);
        }
    }
}

impl FieldArray {
    pub(super) fn components(&self) -> usize {
        self.components as usize // at most 64
    }

    /// The numbers of the points or cells in `rows`, of a step that begins at `first`.
    pub(super) fn view(&self, rows: &Range<u64>, first: u64) -> Result<View, Error> {
        if let Some(view) = &self.lattice {
            return Ok(view.clone());
        }
        let start = self.start.saturating_add(rows.start - first);
        let end = start.saturating_add(rows.end - rows.start);
        self.dataset.view(&[], start..end)
    }

    /// All numbers of an array on a lattice.
    pub(super) fn lattice(&self) -> Result<&View, Error> {
        let lattice = self.lattice.as_ref();
        lattice.ok_or_else(|| self.dataset.error("it does not lie on a lattice"))
    }
}
