// Sums: of light and optical depth, of a million cells on a ray.
//
// Added one by one, each loses a share of what is summed so far, and most to the same side: 2²⁰ were off by 6e-4
// together. So `SUMMED` at a time are summed by themselves, and then added to what was put aside before. What
// rounding takes could be kept instead (Knuth's two-sum), but compilers may take (a + b) − a for b: on llvmpipe that
// changed no bit of a picture.

// Summed before they are put aside.
const SUMMED: u32 = 1024u;
