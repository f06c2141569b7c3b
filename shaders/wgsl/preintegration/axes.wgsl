// Axes: what a place in a table of integrals stands for.
//
// Röttger, Kraus, Ertl 2000; Weiler, Kraus, Ertl 2002, §5. Set by `preintegration` of
// tetrascope-gpu.
// Needs: `fn table_span() -> vec4f`: the scalars at the ends of the first two axes, 1 over their
// difference, and the length at the end of the third, normalized; it begins with 0.

// 0: there is no table, and segments are integrated exactly. 2: scalars at the segment's
// front and back, for integrals that are linear in its length. 3: its length as well.
override TABLE_AXES: u32 = 0u;
// Samples along each axis, the first and the last at its ends.
override TABLE_SIDE: u32 = 2u;
// Whether every segment is taken for as long as the table says, and entries are of light and
// opacity; then there are two axes (Bernardon et al. 2004, 3.2).
override TABLE_IS_FIXED: bool = false;

// Whether entries are of light and opacity, and not of what grows with the length.
fn has_opacities() -> bool {
    return TABLE_AXES == 3u || TABLE_IS_FIXED;
}
