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
    /// Clusters of a mesh through which rays were cast, once for each band of rows.
    CLUSTERS_DRAWN = "clusters_drawn", "clusters";
    /// Clusters that were read for that, as they were not in memory.
    CLUSTERS_READ = "clusters_read", "clusters";
    /// Clusters that were not read, as the look shows none of their scalars.
    CLUSTERS_HIDDEN = "clusters_hidden", "clusters";
    /// Clusters that were not read, as they are beside the image, behind the eye or cut away.
    CLUSTERS_OUTSIDE = "clusters_outside", "clusters";
    /// Clusters that were not read, as all rays end before them, once for each band of rows.
    CLUSTERS_COVERED = "clusters_covered", "clusters";
    /// Cells of a grid that rays passed over in bricks in which nothing shows.
    CELLS_SKIPPED = "cells_skipped", "cells";
}
