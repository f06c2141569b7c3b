//! What was found and fixed while a mesh was built.

/// Counts of what a mesh consists of and of what is wrong with it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshReport {
    /// Tetrahedra that are drawn.
    pub tetrahedra: usize,
    /// Input cells whose corners came in the opposite orientation; fixed.
    pub flipped: usize,
    /// Tetrahedra without volume; kept, as they hold the mesh together, and harmless.
    ///
    /// The test is relative to the cell: its determinant is within the rounding
    /// error of its own evaluation in f64 (Shewchuk 1997, bound A), so that its
    /// coordinates cannot tell it from a flat one.
    pub degenerate: usize,
    /// Faces that three or more tetrahedra share; each takes it as boundary.
    pub crowded_faces: usize,
}
