// Crossing: where a column crosses a face, in 32-bit floats.

// How near to a sample a face is that counts as through it, as a share of its extent: 2^-21, as the
// shares of corners err by some 4 of 2^-24 each. See `crossing_at`.
const SNAP: f32 = 4.76837158203125e-7;

// Where a column crosses a face.
struct Crossing {
    base: f32,      // a sample near the face
    height: f32,    // from there along the column
    first: f32,     // the first sample that is not before the face
    scalar: f32,
}

// Where a column crosses a face whose corners are at these places from the column, with heights relative
// to `base`, a sample, and scalars.
//
// The corners are turned so that the longest edge, as the column sees it, is ab. The share of c is
// how far beside that edge the column passes, and what is left of the way along the edge is b's.
// So the point is within some 2^-24 of the edge's length beside the column even for slivers and for
// faces seen edge on, where the share of c means little but is held to what the face has there.
fn crossing_at(base: f32, first: vec4f, second: vec4f, third: vec4f) -> Crossing {
    let e = second.xy - first.xy;
    let f = third.xy - second.xy;
    let g = first.xy - third.xy;
    let lengths = vec3f(dot(e, e), dot(f, f), dot(g, g));
    let is_second = lengths.y > lengths.x && lengths.y >= lengths.z;
    let is_third = lengths.z > lengths.x && lengths.z > lengths.y;
    let a = select(select(first, second, is_second), third, is_third);
    let b = select(select(second, third, is_second), first, is_third);
    let c = select(select(third, first, is_second), second, is_third);
    let ab = b - a;
    let ac = c - a;
    // Not 0: at least one edge of a crossed face has a length. Shares are taken from both ends, so
    // that each is exact where it is small.
    let scale = 1.0 / max(dot(ab.xy, ab.xy), 1e-37);
    let from_a = -dot(a.xy, ab.xy) * scale;
    let from_b = dot(b.xy, ab.xy) * scale;
    let c_from_a = dot(ac.xy, ab.xy) * scale;
    let c_from_b = dot(b.xy - c.xy, ab.xy) * scale;
    // The areas between the column and the edges are of one sign.
    let of_a = abs(b.x * c.y - b.y * c.x);
    let of_b = abs(c.x * a.y - c.y * a.x);
    let of_c = abs(a.x * b.y - a.y * b.x);
    // Neither of the others is negative. c may lie beside the ends of ab, by rounding.
    let at_a = from_a / select(c_from_a, 1e-37, c_from_a == 0.0);
    let at_b = from_b / select(c_from_b, 1e-37, c_from_b == 0.0);
    let least = max(select(0.0, at_a, c_from_a < 0.0), select(0.0, at_b, c_from_b < 0.0));
    let most = min(select(at_a, 1.0, c_from_a < 0.0), select(at_b, 1.0, c_from_b < 0.0));
    let share_c = clamp(min(max(of_c / max(of_a + of_b + of_c, 1e-37), least), most), 0.0, 1.0);
    let share_b = clamp(from_a - share_c * c_from_a, 0.0, 1.0 - share_c);
    let height = a.z + (share_b * ab.z + share_c * ac.z);
    let scalar = a.w + (share_b * ab.w + share_c * ac.w);
    // Where grid and mesh are aligned many faces meet at a sample. Those nearer to it than rounding
    // can tell, of any face as large, are all in front of it.
    let near = round(height);
    let size = max(max(abs(ab.x), abs(ab.y)), max(abs(ab.z), max(abs(ac.z), abs(ac.z - ab.z))));
    let tolerance = SNAP * size;
    let reached = select(ceil(height), near, abs(height - near) <= tolerance);
    return Crossing(
        base,
        height,
        base + reached,
        clamp(scalar, min(a.w, min(b.w, c.w)), max(a.w, max(b.w, c.w))),
    );
}
