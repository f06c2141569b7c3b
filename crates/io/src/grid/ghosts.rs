//! Points and cells that VTK hides.

use tetrascope_core::grid::Samples;
use tetrascope_core::mesh::Association;

use super::number::Numbers;
use super::{FieldSamples, GridData, GridField};
use crate::source::count;

/// Marks of `vtkGhostType`: a point that is not to be seen.
const HIDDEN_POINT: u8 = 2;
/// A cell that is not to be seen, or that finer ones of another image replace.
const HIDDEN_CELL: u8 = 32 | 8;

/// The arrays that mark what is not to be seen.
#[derive(Default)]
pub(crate) struct Ghosts {
    pub(crate) points: Option<Numbers>,
    pub(crate) cells: Option<Numbers>,
}

impl Ghosts {
    /// Takes the samples of hidden points and cells, and notes how many there are.
    ///
    /// A cell with a hidden point is hidden too. Of fields at points the samples at the
    /// corners of hidden cells go.
    pub(crate) fn hide(&self, data: &mut GridData) {
        let marked = |ghosts: &Option<Numbers>, mark: u8| -> Option<Vec<bool>> {
            let ghosts = ghosts.as_ref()?;
            let is_marked = |i: usize| ghosts.get(i) as u8 & mark != 0;
            let hidden: Vec<bool> = (0..ghosts.len()).map(is_marked).collect();
            hidden.contains(&true).then_some(hidden)
        };
        let points = marked(&self.points, HIDDEN_POINT);
        let cells = marked(&self.cells, HIDDEN_CELL);
        let number = |hidden: &[bool]| hidden.iter().filter(|h| **h).count() as u64;
        for (hidden, thing) in [(&points, "point"), (&cells, "cell")] {
            if let Some(hidden) = hidden {
                let things = count(number(hidden), thing);
                data.notes.push(format!("{things} hidden by vtkGhostType"));
            }
        }
        let dims_of = |association: Association| {
            let field = data.fields.iter().find(|f| f.association == association)?;
            Some(field.lattice.dims)
        };
        let of_points = dims_of(Association::Point);
        let of_cells = dims_of(Association::Cell);
        if let Some(dims) = of_points {
            let mut hidden = points.clone().unwrap_or(vec![false; dims.iter().product()]);
            if let Some(cells) = &cells {
                for (cell, _) in cells.iter().enumerate().filter(|(_, hidden)| **hidden) {
                    corners(cell, dims).for_each(|point| hidden[point] = true);
                }
                let drawn = |cell: &usize| !corners(*cell, dims).any(|point| hidden[point]);
                let left = (0..cells.len()).filter(drawn).count() as u64;
                let beside = cells.len() as u64 - number(cells) - left;
                data.notes.push(format!(
                    "of fields at points, samples at the corners of hidden cells are left out, \
                     and with them {} beside",
                    count(beside, "cell")
                ));
            }
            take(&mut data.fields, Association::Point, &hidden);
        }
        if let Some(dims) = of_cells {
            let mut hidden = cells.unwrap_or(vec![false; dims.iter().product()]);
            if let Some(points) = &points {
                let of_points = dims.map(|d| d + 1);
                for (cell, hidden) in hidden.iter_mut().enumerate() {
                    *hidden |= corners(cell, of_points).any(|point| points[point]);
                }
            }
            take(&mut data.fields, Association::Cell, &hidden);
        }
    }
}

/// The points of a cell, by their number in an image of `dims` points.
fn corners(cell: usize, dims: [usize; 3]) -> impl Iterator<Item = usize> {
    let [nx, ny, _] = dims;
    let [cx, cy] = [nx - 1, ny - 1];
    let (x, y, z) = (cell % cx, cell / cx % cy, cell / (cx * cy));
    let low = x + nx * (y + ny * z);
    [0, 1, nx, nx + 1]
        .into_iter()
        .flat_map(move |in_plane| [low + in_plane, low + in_plane + nx * ny])
}

/// Makes hidden samples NaN, which is transparent.
fn take(fields: &mut [GridField], association: Association, hidden: &[bool]) {
    if !hidden.contains(&true) {
        return;
    }
    for field in fields.iter_mut().filter(|f| f.association == association) {
        if let FieldSamples::Loaded(samples) = &mut field.samples {
            let values = (0..samples.len()).map(|i| match hidden[i] {
                true => f32::NAN,
                false => samples.get(i) as f32,
            });
            *samples = Samples::F32(values.collect());
        }
    }
}
