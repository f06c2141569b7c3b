// Element: what is kept of a cell from slice to slice.

// Places are relative to the sample nearest to the cell's first corner.
struct Element {
    center: vec2f,   // of its fan of triangles
    scale: f32,      // 1 / the thickness there, the greatest of the cell
    fan: u32,        // outline, 8 bits; its sides, 4 bits; triangles with an area
    front: vec2f,    // depth and scalar at the center, of the face in front
    back: vec2f,     // and of that behind
    range: vec2f,    // the least and the greatest scalar of its corners
}

// What a dispatch or a draw is about: a slab, or a slice.
struct Step {
    first: i32,   // the first slice
    end: i32,     // behind the last one
    slab: u32,
    padding: u32,
}
