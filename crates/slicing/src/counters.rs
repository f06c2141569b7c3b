//! Counters of frames.

tetrascope_core::counters! {
    /// Boxes of the grid that were drawn.
    BRICKS_DRAWN = "bricks_drawn", "boxes";
    /// Boxes of the grid left out because they map to nothing, or are outside of the image or
    /// behind clip planes.
    BRICKS_SKIPPED = "bricks_skipped", "boxes";
    /// Vertices sent to the vertex stage.
    VERTICES = "vertices", "vertices";
    /// Fragments of the passes through the volume, as the device counts them: it may count
    /// those beside a polygon that complete a block.
    FRAGMENTS = "fragments", "fragments";
    /// Bytes that say what is drawn where, sent to the device for this frame: boxes or polygons,
    /// and the camera.
    GEOMETRY_BYTES = "geometry_bytes", "bytes";
}
