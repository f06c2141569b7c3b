//! A cell between two buffers (section 2.1): its front faces go into one frame- and z-buffer, its
//! back faces into another, and the voxels between them are filled.

use std::ops::Range;

use tetrascope_core::glam::DVec3;

use crate::face::{Corner, Extent, Fragment, Number, Range32, Window, scan_convert};
use crate::options::FirstVoxel;

/// Which of the two buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Back,
}

/// The events while a cell is voxelized, in order. The model of the hardware listens, too.
pub(crate) trait Events {
    /// A cell with so many corners and triangles arrives, to be voxelized for each offset or not.
    fn cell(&mut self, _corners: usize, _triangles: usize) {}
    /// A triangle is scan converted into a buffer.
    fn face(&mut self, _side: Side) {}
    /// A fragment at pixel (column, row) goes into a buffer.
    fn fragment(&mut self, _side: Side, _pixel: (i32, i32)) {}
    /// All faces of a cell are in the buffers, which are about to be read for these pixels.
    fn faces_end(&mut self, _columns: Range<i32>, _rows: Range<i32>) {}
    /// A pixel on which the cell projects is read from both buffers, and this many voxels
    /// follow.
    fn column(&mut self, _pixel: (i32, i32), _voxels: u32) {}
    /// Voxel (x, y, z) is given a scalar, in units of 2⁻³⁰ of the field's range.
    fn voxel(&mut self, at: [i32; 3], scalar: u32);
    /// A cell is done for one offset.
    fn cell_end(&mut self) {}
}

/// A polyhedron with the triangles of its faces, counterclockwise from outside.
#[derive(Debug)]
pub(crate) struct Cell<N> {
    pub(crate) corners: Vec<Corner<N>>,
    pub(crate) faces: Vec<[u8; 3]>,
    /// Whether the faces are clockwise from outside instead.
    pub(crate) inside_out: bool,
}

/// The two buffers, over the pixels on which a cell may project.
#[derive(Debug)]
pub(crate) struct Buffers<N: Number> {
    front: Vec<Option<Fragment<N>>>,
    back: Vec<Option<Fragment<N>>>,
    extents: Vec<Extent<N::Sample>>,
    moved: Vec<Corner<N>>,
}

impl<N: Number> Default for Buffers<N> {
    fn default() -> Self {
        Buffers {
            front: Vec::new(),
            back: Vec::new(),
            extents: Vec::new(),
            moved: Vec::new(),
        }
    }
}

/// The cell that is filled, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fill {
    /// Voxels along each axis.
    pub(crate) dims: [i32; 3],
    pub(crate) first_voxel: FirstVoxel,
}

impl<N: Number> Buffers<N> {
    /// Gives each voxel of `into` whose center is in `cell`, moved by `offset`, a scalar.
    pub(crate) fn voxelize(
        &mut self,
        cell: &Cell<N>,
        offset: DVec3,
        into: Fill,
        events: &mut impl Events,
    ) {
        let moved = cell.corners.iter().map(|c| N::translate(c, offset));
        self.moved.clear();
        self.moved.extend(moved);
        let [nx, ny, nz] = into.dims;
        let clipped = |(first, end): Range32, n: i32| first.max(0)..end.min(n);
        let window = Window {
            columns: clipped(N::pixels(self.moved.iter().map(|p| p.x)), nx),
            rows: clipped(N::pixels(self.moved.iter().map(|p| p.y)), ny),
        };
        if window.columns.is_empty() || window.rows.is_empty() {
            return;
        }
        let (width, height) = (window.columns.len(), window.rows.len());
        for buffer in [&mut self.front, &mut self.back] {
            buffer.clear();
            buffer.resize(width * height, None);
        }
        let index = |(column, row): (i32, i32)| {
            (column - window.columns.start) as usize + width * (row - window.rows.start) as usize
        };

        for face in &cell.faces {
            let triangle = face.map(|i| self.moved[usize::from(i)]);
            // One looks along +z, and sees front faces clockwise.
            let side = match (N::winding(&triangle), cell.inside_out) {
                (0, _) => continue,
                (-1, false) | (1, true) => Side::Front,
                _ => Side::Back,
            };
            events.face(side);
            let slopes = N::form_buffers(&triangle, &window, &mut self.extents);
            let buffer = match side {
                Side::Front => &mut self.front,
                Side::Back => &mut self.back,
            };
            scan_convert::<N>(&slopes, &self.extents, |column, row, fragment| {
                events.fragment(side, (column, row));
                let held = &mut buffer[index((column, row))];
                if held.is_none_or(|held| is_nearer_the_outside(side, &fragment, &held)) {
                    *held = Some(fragment);
                }
            });
        }
        events.faces_end(window.columns.clone(), window.rows.clone());

        // voxelize_between_two_buffers
        let at_center = into.first_voxel == FirstVoxel::Interpolated;
        for row in window.rows.clone() {
            for column in window.columns.clone() {
                let at = index((column, row));
                let (Some(front), Some(back)) = (&self.front[at], &self.back[at]) else {
                    continue;
                };
                // Floats may swap the faces where they meet. Both ways every column of a mesh is
                // filled without gaps, also where its cells are folded over each other.
                let (front, back) = match back.voxel < front.voxel {
                    true => (back, front),
                    false => (front, back),
                };
                let (first, end) = (front.voxel.max(0), back.voxel.min(nz));
                events.column((column, row), (end - first).max(0) as u32);
                if first < end {
                    N::fill(front, back, (first, end), at_center, |voxel, scalar| {
                        events.voxel([column, row, voxel], scalar);
                    });
                }
            }
        }
        events.cell_end();
    }
}

/// Whether the z-buffer takes `new` in place of `held`. Convex cells have one front and one back
/// face at a pixel; of others the outermost stay, in whatever order they arrive.
fn is_nearer_the_outside<N: Number>(side: Side, new: &Fragment<N>, held: &Fragment<N>) -> bool {
    let key = |f: &Fragment<N>| (f.voxel, f.depth, f.scalar);
    match side {
        Side::Front => key(new) < key(held),
        Side::Back => key(new) > key(held),
    }
}
