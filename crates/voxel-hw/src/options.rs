//! Options of the voxelizer.

use tetrascope_core::Error;

use crate::offsets::Offsets;

/// The most voxels along an axis, and the widest cell in voxels: the fixed-point bounds in
/// `fixed` are derived from it.
pub const MOST_SIDE: usize = 1024;

/// The most voxels of a volume. The accumulation buffer takes 12 bytes per voxel, so 3.2 GB.
pub const MOST_VOXELS: usize = 1 << 28;

/// The numbers in which faces are scan converted and columns are filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arithmetic {
    /// Integers, in increments (section 2.2.1). Vertices are snapped to 1/256 of a voxel; which
    /// voxels a cell owns is then exact.
    #[default]
    FixedPoint,
    /// f64, evaluated for each pixel and voxel. Vertices stay where they are.
    Float,
}

/// The cells that are voxelized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cells {
    /// The tetrahedra of the mesh (section 2.2.2).
    #[default]
    Tetrahedra,
    /// The cells that the mesh was made from (section 6.2), which it has to keep
    /// ([`TetMesh::keeping_cells`]). Their faces are cut into triangles as those of the
    /// tetrahedra are by default; between the faces the scalar is linear along z.
    ///
    /// [`TetMesh::keeping_cells`]: tetrascope_core::TetMesh::keeping_cells
    AsGiven,
}

/// The axis of the voxels along which columns run: the frame buffers are across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Columns {
    /// The third one, as published.
    #[default]
    Z,
    /// The one with the most voxels: fewer pixels, whose columns are longer.
    Longest,
}

/// The scalar of the first voxel of a column (section 2.2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FirstVoxel {
    /// That of the front face, as published; the column is as if it began at the voxel's center.
    Rounded,
    /// Interpolated between front and back face at the voxel's center.
    #[default]
    Interpolated,
}

/// The type of the stored scalars: "the scalar value is scaled to fit the voxel size (8, 16 or 32
/// bits)" (section 2.2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum VoxelSize {
    /// 0…255 for the field's range.
    Bits8,
    /// 0…65535 for the field's range.
    Bits16,
    /// 0…2³² − 1 for the field's range.
    Bits32,
    /// f32 in the field's own unit.
    #[default]
    Float,
}

tetrascope_core::choices! {
    Arithmetic: "fixed-point" = FixedPoint, "float" = Float;
    Columns: "z" = Z, "longest" = Longest;
    Cells: "tetrahedra" = Tetrahedra, "as-given" = AsGiven;
    FirstVoxel: "rounded" = Rounded, "interpolated" = Interpolated;
    VoxelSize: "8" = Bits8, "16" = Bits16, "32" = Bits32, "float" = Float;
}

/// Options of [`Voxelizer`](crate::Voxelizer).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoxelizerOptions {
    /// The numbers of the inner loops.
    pub arithmetic: Arithmetic,
    /// The cells that are voxelized.
    pub cells: Cells,
    /// The axis along which columns run.
    pub columns: Columns,
    /// The scalar of the first voxel of a column.
    pub first_voxel: FirstVoxel,
    /// Where samples are taken within a voxel (section 3.1).
    pub offsets: Offsets,
    /// The type of the stored scalars.
    pub voxel_size: VoxelSize,
    /// The scalars between which voxels lie, such as those of a series; others become the nearer
    /// one. The mesh's own if there is none.
    pub scalar_range: Option<(f64, f64)>,
}

/// How many voxels `dims` are.
///
/// # Errors
/// No voxels along an axis, more than [`MOST_SIDE`], and more than [`MOST_VOXELS`] in all.
pub(crate) fn voxel_count(dims: [usize; 3]) -> Result<usize, Error> {
    let [x, y, z] = dims;
    if dims.iter().any(|d| !(1..=MOST_SIDE).contains(d)) {
        return Err(Error::Invalid {
            what: format!("a voxel volume of {x} × {y} × {z}"),
            help: Some(format!("give 1 to {MOST_SIDE} voxels along each axis")),
        });
    }
    let count = x * y * z;
    if count > MOST_VOXELS {
        return Err(Error::Invalid {
            what: format!("a voxel volume of {x} × {y} × {z} has {count} voxels"),
            help: Some(format!("give at most {MOST_VOXELS} in all")),
        });
    }
    Ok(count)
}
