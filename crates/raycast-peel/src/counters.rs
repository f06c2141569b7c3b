//! Counters of frames.

tetrascope_core::counters! {
    /// Ray-cell intervals that were integrated.
    CELL_VISITS = "cell_visits", "intervals";
    /// Stretches of rays from where they enter the mesh to where they leave it.
    PATHS = "paths", "stretches";
    /// Rays that cross the boundary an odd number of times, which should never happen.
    UNPAIRED_FACES = "unpaired_faces", "rays";
    /// Rays that were given up inside the mesh, or came out where they do not cross it.
    LOST_RAYS = "lost_rays", "rays";
    /// Layers of boundary faces that were peeled and not empty.
    LAYERS = "layers", "layers";
    /// Parts of the image that some ray of theirs made worth drawing.
    TILES_DRAWN = "tiles_drawn", "tiles";
    /// Parts of the image that no ray through the volume touches.
    TILES_SKIPPED = "tiles_skipped", "tiles";
    /// The least number of steps' passes among the tiles drawn.
    LEAST_TILE_PASSES = "least_tile_passes", "passes";
    /// The greatest number of steps' passes among the tiles drawn.
    MOST_TILE_PASSES = "most_tile_passes", "passes";
    /// Fragments of the passes through the volume, those of idle rays included.
    FRAGMENTS = "fragments", "fragments";
}
