//! A square of pixels: its cells from the BVH, their crossings, its pixels.

use std::ops::Range;

use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Appearance, OpticalModel, TetMesh};

use crate::bound::{CellSteepness, Steepness};
use crate::cell::{Cell, Crossing};
use crate::frame::{PixelGrid, RayFrame};
use crate::geometry::Geometry;
use crate::look::{Look, Stretch};
use crate::ray::{self, Entry, Outcome};

/// Pixels per side. Measured on the Blunt Fin at 512×512.
pub(crate) const SIDE: usize = 16;

/// Rays that one cell is tested against at once.
const LANES: usize = 4;

/// All that tiles of one image share.
pub(crate) struct Scene<'a> {
    pub(crate) mesh: &'a TetMesh,
    pub(crate) geometry: &'a Geometry,
    pub(crate) appearance: &'a Appearance,
    pub(crate) steepness: Steepness<'a>,
    pub(crate) look: Look<'a>,
    pub(crate) frame: RayFrame,
    pub(crate) background: [f64; 4],
}

impl Scene<'_> {
    /// The cell at `index` of the BVH's order, given its vertices.
    pub(crate) fn cell(&self, index: usize, position: impl Fn(u32) -> DVec3) -> Cell {
        let vertices = self.geometry.cells[index];
        let scalars = self.mesh.scalars();
        let scalars = match scalars.association {
            Association::Point => vertices.map(|v| scalars.values[v as usize]),
            Association::Cell => self.mesh.cell_scalars(self.geometry.ids[index] as usize),
        };
        Cell::new(vertices.map(position), scalars, self.frame.perspective)
    }

    /// The part of a crossing that is in `stretch`, with its bound of the error added
    /// to `error`.
    #[inline]
    pub(crate) fn entry(
        &self,
        crossing: Crossing,
        cell: u32,
        steepness: &CellSteepness,
        ray: &Line,
        error: &mut f64,
    ) -> Option<Entry> {
        let mut crossing = crossing;
        let &Line {
            length_per_z,
            stretch: Stretch { near, far, .. },
            ..
        } = ray;
        // Where planes leave nothing of the ray, near is behind far.
        let (begin, end) = (crossing.z_in.max(near), crossing.z_out.min(far));
        if end < begin || (end == begin && !self.shows_layer(&crossing)) {
            return None;
        }
        let blur = steepness.blur(&crossing, length_per_z / self.frame.scale);
        if crossing.z_in < near {
            crossing.scalar_in = crossing.scalar_at(near);
            crossing.z_in = near;
        }
        if crossing.z_out > far {
            crossing.scalar_out = crossing.scalar_at(far);
            crossing.z_out = far;
        }
        let more = steepness.error(&crossing, length_per_z, self.appearance.optical_model);
        self.steepness.accumulate(error, more);
        Some(Entry {
            // −0 becomes 0: entries are sorted by their bits.
            z_in: crossing.z_in + 0.0,
            z_out: crossing.z_out,
            scalar_in: crossing.scalar_in,
            scalar_out: crossing.scalar_out,
            cell,
            blur: blur as f32,
        })
    }
}

impl Scene<'_> {
    /// Whether a crossing without length shows: a layer of the mesh without thickness, across which
    /// the scalar changes. It is what thin layers tend to, whose light and optical depth tend
    /// to none, and their greatest values and surfaces do not.
    fn shows_layer(&self, crossing: &Crossing) -> bool {
        let model = self.appearance.optical_model;
        crossing.is_layer
            && matches!(
                model,
                OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces
            )
    }
}

/// A ray of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// World units in a unit of z.
    pub(crate) length_per_z: f64,
    pub(crate) stretch: Stretch,
    /// World space, of any length.
    pub(crate) direction: DVec3,
}

impl Line {
    /// The ray at `p`.
    pub(crate) fn new(scene: &Scene, p: DVec2) -> Line {
        Line {
            length_per_z: scene.frame.length_per_z(p),
            stretch: scene.look.stretch(&scene.frame, p),
            direction: scene.frame.direction(p),
        }
    }

    /// The part of it before `end`, world units.
    fn before(mut self, end: f64) -> Line {
        let end = end / self.length_per_z;
        if end < self.stretch.far {
            self.stretch.far = end;
            // One division, and the length that it divides by: a square root of three terms.
            self.stretch.blur += 4.0 * f64::EPSILON * end.abs();
        }
        self
    }
}

/// A cell whose outline meets the tile.
struct Candidate {
    cell: Cell,
    id: u32,
    nearest: f64,
    /// Within the tile.
    columns: Range<usize>,
    rows: Range<usize>,
}

/// Memory that one tile leaves to the next.
#[derive(Default)]
pub(crate) struct Workspace {
    stack: Vec<u32>,
    candidates: Vec<Candidate>,
    /// Each pixel's.
    entries: Vec<Vec<Entry>>,
    errors: Vec<f64>,
}

/// Draws the pixels in `columns` × `rows`, at most [`SIDE`] each, row by row. The ray of a pixel
/// ends `end_of` its column and row, world units.
pub(crate) fn draw(
    scene: &Scene,
    positions: &[DVec3],
    grid: &PixelGrid,
    columns: Range<u32>,
    rows: Range<u32>,
    end_of: &dyn Fn(u32, u32) -> f64,
    workspace: &mut Workspace,
) -> Vec<(Outcome, usize)> {
    let (width, height) = (columns.len(), rows.len());
    find(scene, positions, grid, &columns, &rows, workspace);
    let Workspace {
        candidates,
        entries,
        errors,
        ..
    } = workspace;
    entries.resize_with(width * height, Vec::new);
    entries.iter_mut().for_each(Vec::clear);
    errors.clear();
    errors.resize(width * height, 0.0);

    // Columns beyond the tile's are computed and dropped.
    let xs: [f64; SIDE + LANES] =
        std::array::from_fn(|i| grid.x(f64::from(columns.start) + i as f64));
    let ys: [f64; SIDE] = std::array::from_fn(|i| grid.y(f64::from(rows.start) + i as f64));
    let rays: Vec<Line> = (0..width * height)
        .map(|i| {
            let end = end_of(
                columns.start + (i % width) as u32,
                rows.start + (i / width) as u32,
            );
            Line::new(scene, DVec2::new(xs[i % width], ys[i / width])).before(end)
        })
        .collect();
    for candidate in candidates.iter() {
        let cell = &candidate.cell;
        let steepness = scene.steepness.of_cell(cell);
        for row in candidate.rows.clone() {
            let above = cell.above(ys[row]);
            for start in candidate.columns.clone().step_by(LANES) {
                let lanes: [f64; LANES] = std::array::from_fn(|lane| xs[start + lane]);
                cell.cross(&above, &lanes, |lane, crossing| {
                    let column = start + lane;
                    if column >= width {
                        return;
                    }
                    let pixel = row * width + column;
                    let entry = scene.entry(
                        crossing,
                        candidate.id,
                        &steepness,
                        &rays[pixel],
                        &mut errors[pixel],
                    );
                    entries[pixel].extend(entry);
                });
            }
        }
    }
    let pixels = entries.iter_mut().zip(errors.iter()).zip(&rays);
    pixels
        .map(|((entries, &error), ray)| {
            ray::sort(entries);
            (ray::integrate(scene, ray, entries, error), entries.len())
        })
        .collect()
}

/// Collects the cells whose outlines meet the tile, nearest first.
fn find(
    scene: &Scene,
    positions: &[DVec3],
    grid: &PixelGrid,
    columns: &Range<u32>,
    rows: &Range<u32>,
    workspace: &mut Workspace,
) {
    let edge = |a: u32, offset: f64| f64::from(a) + offset;
    // Rays are at the pixels' centers: this is half a pixel wider.
    let min = DVec2::new(
        grid.x(edge(columns.start, -0.5)),
        grid.y(edge(rows.end, -0.5)),
    );
    let max = DVec2::new(
        grid.x(edge(columns.end, -0.5)),
        grid.y(edge(rows.start, -0.5)),
    );
    let planes = scene.frame.planes(scene.geometry, min, max);
    let Workspace {
        stack, candidates, ..
    } = workspace;
    candidates.clear();
    scene.geometry.visit(&planes, stack, |range| {
        for index in range {
            let cell = scene.cell(index, |vertex| positions[vertex as usize]);
            let (nearest, farthest) = cell.z_range();
            if farthest <= 0.0 {
                continue;
            }
            let (columns, rows) = match cell.outline() {
                None => (0..columns.len(), 0..rows.len()),
                Some(outline) => pixels(grid, outline, columns, rows),
            };
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            candidates.push(Candidate {
                cell,
                id: scene.geometry.ids[index],
                nearest,
                columns,
                rows,
            });
        }
    });
    // A total order, whatever the BVH's: the sums of error bounds follow it.
    candidates.sort_unstable_by(|a, b| {
        let nearest = a.nearest.total_cmp(&b.nearest);
        nearest.then_with(|| a.id.cmp(&b.id))
    });
}

/// The tile's columns and rows, counted from its first, whose centers may be inside an outline.
fn pixels(
    grid: &PixelGrid,
    (min, max): (DVec2, DVec2),
    columns: &Range<u32>,
    rows: &Range<u32>,
) -> (Range<usize>, Range<usize>) {
    // The sheared vertices are off by a few ε of the ray's own position, which is
    // at most half the image's 2¹⁶ pixels: 1e-11 pixels. This is plenty.
    let margin = 1e-3;
    let span = |low: f64, high: f64, pixels: &Range<u32>| {
        // `as` saturates, and the tile's own range is all that is left.
        let first = (low - margin).ceil().max(f64::from(pixels.start)) as u32;
        let end = ((high + margin).floor() + 1.0).min(f64::from(pixels.end));
        let end = end.max(f64::from(first)) as u32;
        (first - pixels.start) as usize..(end - pixels.start) as usize
    };
    (
        span(grid.column(min.x), grid.column(max.x), columns),
        span(grid.row(max.y), grid.row(min.y), rows),
    )
}
