// Faces: each cell as its four faces, with the ray parameters at their vertices.
//
// Weiler, Kraus, Ertl 2002, §4: for rays in one direction the parameter of the crossing
// with a plane is linear over a face, so it is computed at the vertices and interpolated.
// Each vertex knows the plane of the face opposite, which alone it is not in (§4.2), and
// one face beside (§4.3).
// In:   drawn; twelve vertices per cell, face by face, counterclockwise from outside.
// Out:  FaceVarying; back faces are culled.
// With: projection/frame.wgsl, projection/mesh.wgsl, and for `face_vertex` one of
//       projection/faces_shared.wgsl, faces_floats.wgsl and faces_shorts.wgsl

struct FaceVertex {
    position: vec3f, // normalized
    normal: vec3f,   // of the face opposite, of unit length, on either side
    offset: f32,     // normal · x on that face
    adjacent: vec3f, // normal of the face across the edge to the next vertex, outward
    longest: f32,    // edge of the cell, normalized
    gradient: vec3f, // of the scalar
    scalar: f32,
}

struct FaceVarying {
    @builtin(position) position: vec4f,
    // Ray parameters of the faces opposite each of the three vertices, from this face on.
    @location(0) parameters: vec3f,
    @location(1) scalar: f32,
    @location(2) depth: f32, // along the axis, from the anchor
    // The scalar's rise along the ray, and the cell's longest edge.
    @location(3) @interpolate(flat) cell: vec2f,
}

// Parameter, in longest edges, of what the ray does not leave through: what is
// interpolated from it is too long a way from the first 2⁻¹⁶ of an edge on.
const FAR: f32 = 65536.0;

@vertex
fn vs_face(@builtin(vertex_index) index: u32) -> FaceVarying {
    let corner = index % 12u;
    let v = face_vertex(drawn[index / 12u], corner);
    let direction = frame.forward.xyz;
    let p = vec4f(v.position, 1.0);
    let at = vec3f(dot(frame.right, p), dot(frame.up, p), dot(frame.forward, p));
    let far = FAR * v.longest;
    // Equation 3, with its sign right.
    let rise = dot(direction, v.normal);
    let t = (v.offset - dot(v.position, v.normal)) / select(rise, 1.0, rise == 0.0);
    // Its own and the adjacent face's slots; an entering face is never left (§4.3).
    let own = corner % 3u;
    let beside = (own + 2u) % 3u;
    var parameters = vec3f(0.0);
    parameters[own] = select(far, t, t > 0.0 && rise != 0.0);
    parameters[beside] = select(0.0, far, dot(direction, v.adjacent) < 0.0);
    return FaceVarying(
        vec4f(at.xy * frame.clip_per_unit, 0.5, 1.0),
        parameters,
        v.scalar,
        at.z,
        vec2f(dot(v.gradient, direction), v.longest),
    );
}
