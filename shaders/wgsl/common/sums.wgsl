// Sums: of light and optical depth, of a million cells on a ray.
//
// Added one by one, each loses a share of what is summed so far, and most to the same side: together
// 1e-3. So some are summed by themselves, and then added to what was put aside before: as if there were two
// times their root. What rounding takes could be kept instead (Knuth's two-sum), but compilers may take
// (a + b) − a for b, and Mesa's does.

// Summed before they are put aside.
const SUMMED: u32 = 1024u;
