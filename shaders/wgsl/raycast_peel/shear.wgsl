// Shear: a ray as the z axis, vertices as it sees them, and where it crosses a face.
//
// Each vertex is sheared once a ray so that the ray becomes the z axis (Woop,
// Benthin, Wald 2013); sides.wgsl decides about the points that are left.
// Needs: TRANSPARENT_SCALAR, from which on a scalar stands for none.
// With: common/sides.wgsl

// One vertex as one ray sees it.
struct Corner {
    id: u32,
    xy: vec2f,     // across the ray, normalized units
    z: f32,        // along the ray's main axis, from the anchor
    scalar: f32,
}

// The ray in the shape that `corner` needs.
struct Shear {
    anchor: vec3f,    // a point of the ray near the middle of the mesh
    slope: vec2f,     // d.x / d.z and d.y / d.z after the axes are permuted
    axis: u32,        // the axis along which |d| is greatest: it becomes z
    depth: f32,       // t per unit of z
}

fn shear_of(anchor: vec3f, direction: vec3f) -> Shear {
    let size = abs(direction);
    var axis = 2u;
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
    } else if size.y >= size.z {
        axis = 1u;
    }
    let d = permute(direction, axis);
    return Shear(anchor, d.xy / d.z, axis, 1.0 / d.z);
}

// Cyclic, so that handedness stays.
fn permute(p: vec3f, axis: u32) -> vec3f {
    if axis == 2u {
        return p;
    }
    return select(p.zxy, p.yzx, axis == 0u);
}

// The inverse of `permute`.
fn unpermute(p: vec3f, axis: u32) -> vec3f {
    if axis == 2u {
        return p;
    }
    return select(p.yzx, p.zxy, axis == 0u);
}

// The only code that shears a vertex: the same vertex has the same bits wherever
// a ray meets it. `fma` may or may not be fused, but as one operation it is
// rounded in one way throughout a shader.
fn sheared(id: u32, position: vec3f, scalar: f32, shear: Shear) -> Corner {
    let p = permute(position - shear.anchor, shear.axis);
    return Corner(id, on_grid(fma(-shear.slope, p.zz, p.xy)), p.z, scalar);
}

// z and scalar where the ray crosses face abc. Convex weights: no sliver can
// push either outside the range of its corners, and no rounding the scalar: a constant
// stays one, on the step of a transfer function too. A corner without a scalar leaves the face
// without one, however small its weight is.
fn crossing_point(a: Corner, b: Corner, c: Corner) -> vec2f {
    let w = weights(a.xy, b.xy, c.xy);
    let sum = w.x + w.y + w.z;
    let zs = w.x * vec2f(a.z, a.scalar) + w.y * vec2f(b.z, b.scalar) + w.z * vec2f(c.z, c.scalar);
    // Where the face is seen edge on, its middle.
    let middle = (vec2f(a.z, a.scalar) + vec2f(b.z, b.scalar) + vec2f(c.z, c.scalar)) / 3.0;
    let at = select(middle, zs / sum, sum > 0.0);
    let least = min(a.scalar, min(b.scalar, c.scalar));
    let greatest = max(a.scalar, max(b.scalar, c.scalar));
    let scalar = clamp(at.y, least, greatest);
    return vec2f(at.x, select(scalar, greatest, greatest >= TRANSPARENT_SCALAR));
}
