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
    return select(-1, 1, shear.depth > 0.0);
}

// The one face that the ray goes out through.
fn leave(cell: vec2i, ray: Ray) -> Leaving {
    let shear = shear_of(ray.anchor, ray.direction);
    let v = corners_of(cell, shear);
    let turn = outward(shear);
    let s = sides(v.v0.xy, v.v1.xy, v.v2.xy, v.v3.xy);
    // Whether edges pass as those of a face that the ray goes out through.
    let first = s.of_first == vec3<bool>(turn > 0); // 01, 02, 03
    let rest = s.of_rest == vec3<bool>(turn > 0);   // 12, 13, 23
    // Faces 123, 032, 013, 021: `FACES` of tetrascope_core::mesh.
    let out0 = rest.x & rest.z & !rest.y;
    let out1 = first.z & !rest.z & !first.y;
    let out2 = first.x & rest.y & !first.z;
    let out3 = first.y & !rest.x & !first.x;
    if !(out0 || out1 || out2 || out3) {
        return Leaving(vec2f(OUTSIDE), FAR, 0.0);
    }
    var next = textureLoad(neighbors, cell, 0);
    if out2 || out3 {
        next = textureLoad(neighbors, cell + vec2i(1, 0), 0);
    }
    var a = v.v0;
    var b = v.v3;
    var c = v.v2;
    if out0 {
        a = v.v1;
        b = v.v2;
        c = v.v3;
    } else if out2 {
        b = v.v1;
        c = v.v3;
    } else if out3 {
        b = v.v2;
        c = v.v1;
    }
    let at = crossing_point(a, b, c, f32(turn));
    return Leaving(select(next.zw, next.xy, out0 || out2), at.x * shear.depth, at.y);
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
