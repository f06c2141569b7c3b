//! Image data, and rectilinear grids that are evenly spaced.

use glam::{DMat3, DVec3};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, glam};

use super::Step;
use super::arrays::lattice_arrays;
use super::mesh::{axis, dimensions};
use crate::grid::GridData;
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::hdf5::Group;
use crate::vtu::structured::{even_steps, note_of_steps};
use crate::vtu::{Box3, Image, ImageArray, ImageFields};

/// Reads the image of a group at a time step.
pub(super) fn read(group: &Group, step: Step, notes: Vec<String>) -> Result<GridData, Error> {
    let numbers = |name: &str| {
        let numbers = group.numbers(name)?;
        numbers.ok_or_else(|| group.error(format!("there is no attribute '{name}'")))
    };
    let wrong = |name: &str, count: usize| {
        let what = format!("attribute '{name}' does not hold {count} finite numbers");
        group.error(what)
    };
    let vector = |name: &str| {
        let values: Result<[f64; 3], _> = numbers(name)?.try_into();
        let vector = values.map(DVec3::from_array).ok();
        vector
            .filter(|v| v.is_finite())
            .ok_or_else(|| wrong(name, 3))
    };
    let extent: Result<[f64; 6], _> = numbers("WholeExtent")?.try_into();
    let extent = extent.map_err(|_| wrong("WholeExtent", 6))?;
    let direction = match group.numbers("Direction")? {
        None => DMat3::IDENTITY,
        Some(rows) => {
            let rows: Result<[f64; 9], _> = rows.try_into();
            let rows = rows.map_err(|_| wrong("Direction", 9))?;
            // The file has it row by row.
            DMat3::from_cols_array(&rows).transpose()
        }
    };
    let image = Image {
        extent: extent.map(|end| end as i64), // saturating
        origin: vector("Origin")?,
        spacing: vector("Spacing")?,
        direction,
    };
    fields(group, &image, step, notes)
}

/// Reads a rectilinear grid as an image, if it is evenly spaced.
pub(super) fn of_rectilinear(
    group: &Group,
    step: Step,
    notes: &[String],
) -> Result<Option<GridData>, Error> {
    let points = dimensions(group)?;
    let (mut origin, mut spacing, mut worst) = ([0.0; 3], [0.0; 3], 0.0_f64);
    for (i, &number) in points.iter().enumerate() {
        let (coordinates, epsilon) = axis(group, (i, number), step)?;
        let Some((first, width, off)) = even_steps(&coordinates, epsilon) else {
            return Ok(None);
        };
        (origin[i], spacing[i], worst) = (first, width, worst.max(off));
    }
    let [i, j, k] = points.map(|number| number as i64 - 1); // counted
    let image = Image {
        extent: [0, i, 0, j, 0, k],
        origin: DVec3::from_array(origin),
        spacing: DVec3::from_array(spacing),
        direction: DMat3::IDENTITY,
    };
    let mut grid = fields(group, &image, step, notes.to_vec())?;
    grid.notes.push(note_of_steps(worst));
    Ok(Some(grid))
}

fn fields(group: &Group, image: &Image, step: Step, notes: Vec<String>) -> Result<GridData, Error> {
    let whole = |association| {
        let whole = Box3::of(&image.extent, association);
        whole.ok_or_else(|| group.error(format!("the extent {:?} is empty", image.extent)))
    };
    let points = whole(Association::Point)?.size.map(|size| size as u64);
    let [i, j, k] = points;
    if points.iter().any(|&size| size < 2) {
        return Err(group.error_with_help(
            format!("an image of {i}×{j}×{k} points has no volume"),
            "volume rendering needs at least 2 points along each axis",
        ));
    }
    let mut fields = ImageFields::new(notes);
    let length = group.file.length;
    let mut held = 0_u64;
    for association in [Association::Point, Association::Cell] {
        let mut left_out = Vec::new();
        let arrays = lattice_arrays(group, association, (points, step), &mut left_out)?;
        for (name, why) in left_out {
            let note = format!("array '{name}' left out: {why}");
            fields.notes().push(note);
        }
        if arrays.is_empty() {
            continue;
        }
        let lattice = fields.lattice(image, &whole(association)?, association);
        let Some(lattice) = lattice.map_err(|error| group.error(error.to_string()))? else {
            continue;
        };
        for array in arrays {
            let view = array.lattice()?;
            held = held.saturating_add(view.bytes());
            if held > most_unpacked(length) {
                let what =
                    format!("{held} bytes of samples are packed in {length}, which is refused");
                return Err(group.error_with_help(what, UNPACK));
            }
            let array = ImageArray {
                numbers: view.numbers()?,
                components: array.components(),
                active: array.active,
                kind: array.number,
                name: array.name.clone(),
            };
            fields.add(array, lattice, association);
        }
    }
    let data = fields.finish();
    data.ok_or_else(|| group.error("the image has no field of numbers"))
}
