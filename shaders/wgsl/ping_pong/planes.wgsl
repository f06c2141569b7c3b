// Planes: where a ray crosses the faces of a cell, as published.
//
// Bernardon et al. 2004, equations 1 and 2.
// With: ping_pong/rays.wgsl

// λ and the sign of r · n for the planes of a cell's faces.
struct Planes {
    lambda: vec4f,
    toward: vec4f, // r · n: positive where the ray leaves
}

fn planes_of(cell: vec2i, ray: Ray) -> Planes {
    let v0 = textureLoad(vertices, cell, 0);
    let v1 = textureLoad(vertices, cell + vec2i(1, 0), 0);
    let v2 = textureLoad(vertices, cell + vec2i(2, 0), 0);
    let n0 = textureLoad(normals, cell, 0);
    let n1 = textureLoad(normals, cell + vec2i(1, 0), 0);
    let n2 = textureLoad(normals, cell + vec2i(2, 0), 0);
    let v3 = vec3f(v0.w, v1.w, v2.w);
    let n3 = vec3f(n0.w, n1.w, n2.w);
    // Equation 1: face i's plane goes through v_(3 − i).
    let numerator = vec4f(
        dot(v3 - ray.anchor, n0.xyz),
        dot(v2.xyz - ray.anchor, n1.xyz),
        dot(v1.xyz - ray.anchor, n2.xyz),
        dot(v0.xyz - ray.anchor, n3),
    );
    let toward = vec4f(
        dot(ray.direction, n0.xyz),
        dot(ray.direction, n1.xyz),
        dot(ray.direction, n2.xyz),
        dot(ray.direction, n3),
    );
    return Planes(numerator / select(toward, vec4f(1.0), toward == vec4f(0.0)), toward);
}

// Equation 2, from the cell's gradient.
fn scalar_at(cell: vec2i, ray: Ray, lambda: f32) -> f32 {
    let gradient = textureLoad(neighbors, cell + vec2i(2, 0), 0);
    return dot(gradient.xyz, ray.anchor + lambda * ray.direction) + gradient.w;
}

// The first plane through which the ray goes out.
fn leave(cell: vec2i, ray: Ray) -> Leaving {
    let planes = planes_of(cell, ray);
    let leaving = select(vec4f(FAR), planes.lambda, planes.toward > vec4f(0.0));
    let first = textureLoad(neighbors, cell, 0);
    let last = textureLoad(neighbors, cell + vec2i(1, 0), 0);
    var next = first.xy;
    var lambda = leaving.x;
    if leaving.y < lambda {
        next = first.zw;
        lambda = leaving.y;
    }
    if leaving.z < lambda {
        next = last.xy;
        lambda = leaving.z;
    }
    if leaving.w < lambda {
        next = last.zw;
        lambda = leaving.w;
    }
    return Leaving(next, lambda, scalar_at(cell, ray, lambda));
}

// The scalar with which the next cell begins after one in which the ray went back.
fn scalar_after(before: f32, leaving: Leaving) -> f32 {
    return before;
}

// The scalar at `lambda`, on the way from `state` to `leaving`.
fn scalar_between(cell: vec2i, ray: Ray, state: vec4f, leaving: Leaving, lambda: f32) -> f32 {
    return scalar_at(cell, ray, lambda);
}

// The cell's own scalar where the ray of `state` comes in.
fn scalar_where_entered(cell: vec2i, ray: Ray, state: vec4f) -> f32 {
    return scalar_at(cell, ray, state.z);
}
