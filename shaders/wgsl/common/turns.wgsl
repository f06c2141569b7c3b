// Turns: which faces of a cell a ray crosses, from the sides on which it passes the edges.

// Whether the edges 01, 02, 03, and 12, 13, 23, pass on the positive side. Where the ends
// of one coincide it is said to pass on the other; no face with such an edge is crossed,
// as its other two pass on opposite sides.
struct Sides {
    of_first: vec3<bool>,
    of_rest: vec3<bool>,
}

// Which face the ray enters and which it leaves, of those opposite vertex 0, 1, 2 and 3 of
// a positively oriented cell: those that all three edges turn around it the same way.
struct Turns {
    enters: vec4<bool>,
    leaves: vec4<bool>,
}

fn turns(s: Sides) -> Turns {
    let first = s.of_first;
    let rest = s.of_rest;
    return Turns(
        vec4<bool>(
            rest.x & rest.z & !rest.y,
            first.z & !rest.z & !first.y,
            first.x & rest.y & !first.z,
            first.y & !rest.x & !first.x,
        ),
        vec4<bool>(
            !rest.x & !rest.z & rest.y,
            !first.z & rest.z & first.y,
            !first.x & !rest.y & first.z,
            !first.y & rest.x & first.x,
        ),
    );
}
