//! Counters of frames.

tetrascope_core::counters! {
    /// Ray-cell intervals that were integrated.
    CELL_VISITS = "cell_visits", "intervals";
    /// Stretches of rays from where they enter the mesh to where they leave it.
    PATHS = "paths", "stretches";
    /// Rays that cross the boundary an odd number of times, which should never happen.
    UNPAIRED_FACES = "unpaired_faces", "rays";
    /// Rays that came out where they do not cross the mesh, which should never happen.
    LOST_RAYS = "lost_rays", "rays";
    /// Cells of a grid that rays passed over in bricks in which nothing shows.
    CELLS_SKIPPED = "cells_skipped", "cells";
}
