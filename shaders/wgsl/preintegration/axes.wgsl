// Axes: what a place in a table of integrals stands for.
//
// Röttger, Kraus, Ertl 2000; Weiler, Kraus, Ertl 2002, §5. Set by `preintegration` of
// tetrascope-gpu.

// 0: there is no table, and segments are integrated exactly. 2: scalars at the segment's
// front and back, for integrals that are linear in its length. 3: its length as well.
override TABLE_AXES: u32 = 0u;
// Samples along each axis, the first and the last at its ends.
override TABLE_SIDE: u32 = 2u;
// Scalars at the ends of the first two axes.
override TABLE_LOW: f32 = 0.0;
override TABLE_HIGH: f32 = 1.0;
// The length at the end of the third, normalized; it begins with 0.
override TABLE_LENGTH: f32 = 1.0;
// Whether every segment is taken for as long as that, and entries are of light and
// opacity; then there are two axes (Bernardon et al. 2004, 3.2).
override TABLE_IS_FIXED: bool = false;

// Whether entries are of light and opacity, and not of what grows with the length.
fn has_opacities() -> bool {
    return TABLE_AXES == 3u || TABLE_IS_FIXED;
}
