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
    z: f32,        // along the ray's main axis, growing along the ray; as exact as the vertex
    scalar: f32,
}

// The ray in the shape that `corner` needs.
struct Shear {
    through: vec2f,   // where the ray passes z = 0
    slope: vec2f,     // how it moves with z
    axis: u32,        // the axis along which |d| is greatest: it becomes z
    sign: f32,        // -1 where z falls along that axis
    depth: f32,       // t per unit of z
    anchor: f32,      // z where t is 0
}

fn z_of(t: f32, shear: Shear) -> f32 {
    return t / shear.depth + shear.anchor;
}

fn t_of(z: f32, shear: Shear) -> f32 {
    return (z - shear.anchor) * shear.depth;
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
    let a = permute(anchor, axis);
    let sign = select(1.0, -1.0, d.z < 0.0);
    let slope = d.xy / abs(d.z);
    let z = sign * a.z;
    return Shear(a.xy - slope * z, slope, axis, sign, 1.0 / abs(d.z), z);
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
    let p = permute(position, shear.axis);
    let z = shear.sign * p.z;
    return Corner(id, on_grid(fma(-shear.slope, vec2f(z), p.xy - shear.through)), z, scalar);
}

// z and scalar where the ray crosses face abc, the scalar between its corners'. A corner without
// a scalar leaves the face without one, however small its share is.
fn crossing_point(a: Corner, b: Corner, c: Corner) -> vec2f {
    let mean = mean_where_crossed(
        vec4f(a.xy, a.z, a.scalar),
        vec4f(b.xy, b.z, b.scalar),
        vec4f(c.xy, c.z, c.scalar),
    );
    let least = min(a.scalar, min(b.scalar, c.scalar));
    let greatest = max(a.scalar, max(b.scalar, c.scalar));
    let scalar = clamp(mean.y, least, greatest);
    return vec2f(mean.x, select(scalar, greatest, greatest >= TRANSPARENT_SCALAR));
}
