//! Faces: their extents per scan line, and scan conversion (section 2.2).
//!
//! Pixel (i, j) is the column of voxels (i, j, k) for all k; its center is (i + 1/2, j + 1/2). A
//! face covers the pixels whose centers it contains, those on its lower and left edges included,
//! those on its upper and right edges not: as if every center were moved by (ε, ε²).

use std::ops::Range;

use tetrascope_core::glam::DVec3;

/// A corner of a cell, in voxels or parts of them, with a scalar relative to the field's range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner<N> {
    pub(crate) x: N,
    pub(crate) y: N,
    pub(crate) z: N,
    pub(crate) scalar: N,
}

/// A face at the center of a pixel: what frame- and z-buffer hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fragment<N> {
    /// The first voxel whose center is not in front of the face: the depth, rounded.
    pub(crate) voxel: i32,
    pub(crate) depth: N,
    pub(crate) scalar: N,
}

/// A scan line of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent<S> {
    pub(crate) row: i32,
    pub(crate) columns: Range32,
    /// The face at the first of the columns.
    pub(crate) left: S,
}

/// From the first, included, to the second, excluded.
pub(crate) type Range32 = (i32, i32);

/// The pixels that are voxelized.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Window {
    pub(crate) columns: Range<i32>,
    pub(crate) rows: Range<i32>,
}

/// Numbers in which faces are scan converted and columns are filled.
pub(crate) trait Number: Copy + PartialOrd + std::fmt::Debug {
    /// A face with its slopes.
    type Face;
    /// The face at a pixel.
    type Sample: Copy;

    /// A corner at `place`, in voxels, with a scalar in [0, 1].
    fn corner(place: DVec3, scalar: f64) -> Corner<Self>;

    /// `corner` moved by `offset`, in voxels.
    fn translate(corner: &Corner<Self>, offset: DVec3) -> Corner<Self>;

    /// The sign of a closed cell's volume, of which these are the faces, counterclockwise from
    /// outside, in a system of right hand.
    fn volume_sign(corners: &[Corner<Self>], faces: &[[u8; 3]]) -> i8;

    /// The pixels between which `coordinates` lie, of x or y: the first whose center is not less
    /// than the least, and the first whose center is not less than the greatest.
    fn pixels(coordinates: impl Iterator<Item = Self>) -> Range32;

    /// The sign of the area of a triangle's projection along z: 1 if it is counterclockwise.
    fn winding(triangle: &[Corner<Self>; 3]) -> i8;

    /// The extents of `triangle`, whose winding is not 0, per scan line in `window`, and its
    /// slopes.
    fn form_buffers(
        triangle: &[Corner<Self>; 3],
        window: &Window,
        extents: &mut Vec<Extent<Self::Sample>>,
    ) -> Self::Face;

    /// Goes to the next pixel of a scan line.
    fn step(face: &Self::Face, sample: &mut Self::Sample);

    /// The values for the buffers.
    fn fragment(face: &Self::Face, sample: &Self::Sample) -> Fragment<Self>;

    /// Scalars of voxels `voxels` of a column between `front` and `back`, in units of
    /// 2^−[`VALUE_BITS`] of the field's range. With `at_center` the first voxel's scalar is
    /// interpolated, else it is that of the front face.
    fn fill(
        front: &Fragment<Self>,
        back: &Fragment<Self>,
        voxels: Range32,
        at_center: bool,
        write: impl FnMut(i32, u32),
    );
}

/// Bits of a voxel's scalar: 2^30 is the upper end of the field's range.
pub(crate) const VALUE_BITS: u32 = 30;

/// Gives `put` the face at each pixel of its extents.
pub(crate) fn scan_convert<N: Number>(
    face: &N::Face,
    extents: &[Extent<N::Sample>],
    mut put: impl FnMut(i32, i32, Fragment<N>),
) {
    for extent in extents {
        let mut sample = extent.left;
        for column in extent.columns.0..extent.columns.1 {
            put(column, extent.row, N::fragment(face, &sample));
            N::step(face, &mut sample);
        }
    }
}
