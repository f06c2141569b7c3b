//! Counters of frames.

tetrascope_core::counters! {
    /// Ray-cell intervals that were integrated.
    CELL_VISITS = "cell_visits", "intervals";
    /// Pixels in which cells overlap or leave gaps beyond rounding.
    INCONSISTENT_PIXELS = "inconsistent_pixels", "pixels";
}
