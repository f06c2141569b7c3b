// Faces from shared vertices: what the paper stores for each is computed (§8).
//
// With: projection/faces.wgsl, projection/mesh.wgsl

@group(2) @binding(0) var<storage, read> placed: array<f32>; // x, y, z of each vertex
@group(2) @binding(1) var<storage, read> shaped: array<f32>; // scalar of each vertex or cell

// `tetrascope_core::mesh::FACES`: the corners of each face, by the one opposite.
const FACES = array<vec3u, 4>(
    vec3u(1u, 2u, 3u), vec3u(0u, 3u, 2u), vec3u(0u, 1u, 3u), vec3u(0u, 2u, 1u),
);

fn place(v: u32) -> vec3f {
    return vec3f(placed[3u * v], placed[3u * v + 1u], placed[3u * v + 2u]);
}

fn face_vertex(cell: u32, corner: u32) -> FaceVertex {
    let v = cells[cell];
    let points = array<vec3f, 4>(place(v.x), place(v.y), place(v.z), place(v.w));
    let face = corner / 3u;
    let k = corner % 3u;
    var corners = FACES;
    let own = corners[face][k];
    let next = corners[face][(k + 1u) % 3u];
    let last = corners[face][(k + 2u) % 3u];
    let p = points[own];
    // From the vertex to the others of the cell; the opposite face has those three.
    let a = points[next] - p;
    let b = points[last] - p;
    let c = points[face] - p;
    let opposite = cross(b - a, c - a);
    let normal = opposite / max(length(opposite), 1e-36);
    // Across the edge to the next vertex lies the face with these two and not `last`.
    let side = cross(a, c);
    let longest = max(
        max(length(a), max(length(b), length(c))),
        max(length(b - a), max(length(c - a), length(c - b))),
    );
    var scalar = 0.0;
    var gradient = vec3f(0.0);
    if SCALARS_PER_CELL {
        scalar = shaped[cell];
    } else {
        let s = array<f32, 4>(shaped[v.x], shaped[v.y], shaped[v.z], shaped[v.w]);
        scalar = s[own];
        let volume = dot(a, cross(b, c));
        gradient = (s[next] - scalar) * cross(b, c) + (s[last] - scalar) * cross(c, a)
            + (s[face] - scalar) * cross(a, b);
        gradient /= select(volume, 1.0, volume == 0.0);
    }
    // Outward is away from the vertex that the face lacks.
    return FaceVertex(p, normal, dot(normal, points[next]), side * -sign(dot(side, b)), longest,
        gradient, scalar);
}
