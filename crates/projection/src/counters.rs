//! Counters of frames.

tetrascope_core::counters! {
    /// Cells sent to the rasterizer.
    CELLS_DRAWN = "cells_drawn", "cells";
    /// Cells left out because they have no volume, or map to nothing.
    CELLS_SKIPPED = "cells_skipped", "cells";
    /// Cells that were sorted; 0 when the optical model commutes.
    CELLS_SORTED = "cells_sorted", "cells";
    /// Faces across which the order of cells was given up because cells hide each other in a
    /// cycle.
    VISIBILITY_CYCLES = "visibility_cycles", "faces";
    /// Fragments that were kept to be sorted in their pixels.
    FRAGMENTS_SORTED = "fragments_sorted", "fragments";
    /// Pixels whose fragments were not all sorted.
    LOST_RAYS = "lost_rays", "pixels";
    /// How many of the resident bytes each view writes anew.
    BYTES_PER_VIEW = "bytes_per_view", "bytes";
}
