// Sides: where a ray crosses the faces of a cell, without planes, gradients or tolerance.
//
// Not in the paper: the walk of raycast_peel/walk.wgsl on the paper's textures. The signed
// number of times that a cell's four faces cover a point of the plane across the ray is 0,
// and two of them or none cover it (common/sides.wgsl): so a ray that crosses a cell comes
// in through one face and goes out through one, flat and inverted cells included, and the
// state of figure 9 needs no face.
// With: ping_pong/rays.wgsl, raycast_peel/shear.wgsl, common/sides.wgsl

struct Corners {
    v0: Corner,
    v1: Corner,
    v2: Corner,
    v3: Corner,
}

fn corners_of(cell: vec2i, shear: Shear) -> Corners {
    let v0 = textureLoad(vertices, cell, 0);
    let v1 = textureLoad(vertices, cell + vec2i(1, 0), 0);
    let v2 = textureLoad(vertices, cell + vec2i(2, 0), 0);
    let s = textureLoad(neighbors, cell + vec2i(2, 0), 0);
    return Corners(
        sheared(0u, v0.xyz, s.x, shear),
        sheared(1u, v1.xyz, s.y, shear),
        sheared(2u, v2.xyz, s.z, shear),
        sheared(3u, vec3f(v0.w, v1.w, v2.w), s.w, shear),
    );
}

// On which side a ray passes the edges of a face through which it goes out, seen in the
// face's order, which is counterclockwise from outside.
fn outward(shear: Shear) -> i32 {
    return select(-1, 1, shear.sign > 0.0);
}

// A face of a cell: 0 to 3, opposite that vertex, or none.
const NONE: u32 = 4u;

// The one face whose edges a ray passes on the side `turn`.
fn face_of(s: Sides, turn: i32) -> u32 {
    let first = s.of_first == vec3<bool>(turn > 0); // 01, 02, 03
    let rest = s.of_rest == vec3<bool>(turn > 0);   // 12, 13, 23
    // Faces 123, 032, 013, 021: `FACES` of tetrascope_core::mesh.
    let is0 = rest.x & rest.z & !rest.y;
    let is1 = first.z & !rest.z & !first.y;
    let is2 = first.x & rest.y & !first.z;
    let is3 = first.y & !rest.x & !first.x;
    return select(select(select(select(NONE, 3u, is3), 2u, is2), 1u, is1), 0u, is0);
}

// λ and scalar where a ray crosses such a face.
fn crossing_of(face: u32, v: Corners, shear: Shear) -> vec2f {
    var a = v.v0;
    var b = v.v3;
    var c = v.v2;
    if face == 0u {
        a = v.v1;
        b = v.v2;
        c = v.v3;
    } else if face == 2u {
        b = v.v1;
        c = v.v3;
    } else if face == 3u {
        b = v.v2;
        c = v.v1;
    }
    let at = crossing_point(a, b, c);
    return vec2f(t_of(at.x, shear), at.y);
}

// The one face that the ray goes out through.
fn leave(cell: vec2i, ray: Ray) -> Leaving {
    let shear = shear_of(ray.anchor, ray.direction);
    let v = corners_of(cell, shear);
    let turn = outward(shear);
    let face = face_of(sides(v.v0.xy, v.v1.xy, v.v2.xy, v.v3.xy), turn);
    if face == NONE {
        return Leaving(vec2f(OUTSIDE), FAR, 0.0);
    }
    var next = textureLoad(neighbors, cell, 0);
    if face >= 2u {
        next = textureLoad(neighbors, cell + vec2i(1, 0), 0);
    }
    let at = crossing_of(face, v, shear);
    return Leaving(select(next.zw, next.xy, face == 0u || face == 2u), at.x, at.y);
}

// The cell's own scalar where the ray of `state` comes in.
fn scalar_where_entered(cell: vec2i, ray: Ray, state: vec4f) -> f32 {
    let shear = shear_of(ray.anchor, ray.direction);
    let v = corners_of(cell, shear);
    let turn = -outward(shear);
    let face = face_of(sides(v.v0.xy, v.v1.xy, v.v2.xy, v.v3.xy), turn);
    return crossing_of(face, v, shear).y;
}

// The scalar with which the next cell begins after one in which the ray went back.
fn scalar_after(before: f32, leaving: Leaving) -> f32 {
    return leaving.scalar;
}

// The scalar at `lambda`, on the way from `state` to `leaving`.
fn scalar_between(cell: vec2i, ray: Ray, state: vec4f, leaving: Leaving, lambda: f32) -> f32 {
    // Equal scalars stay equal, which `mix` does not promise.
    return state.w + (lambda - state.z) / (leaving.lambda - state.z) * (leaving.scalar - state.w);
}
