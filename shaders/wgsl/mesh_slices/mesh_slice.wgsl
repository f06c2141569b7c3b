// Mesh slice: what the cross sections of cells with one plane add to a picture.
//
// Westermann 2001 section 3.2. Post-shaded, the transfer function is applied to the scalar of each
// fragment; pre-shaded (`_pre`), to those of vertices, and colors are interpolated.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color. Planes back to front.
// With: mesh_slices/frame.wgsl and what it needs, common/ends.wgsl, common/sides.wgsl,
//       resample/element.wgsl, common/optics_model.wgsl, common/transfer_function.wgsl

@group(1) @binding(3) var<storage, read> intervals: array<KnotPair>;
@group(2) @binding(0) var<storage, read> elements: array<Element>;
@group(2) @binding(1) var<storage, read> list: array<u32>;
// T1 and T2 of section 2.1: a weight and an alpha.
@group(2) @binding(2) var of_back: texture_2d<f32>;
@group(2) @binding(3) var of_front: texture_2d<f32>;
@group(2) @binding(4) var nearest: sampler;
@group(3) @binding(0) var<storage, read> slice: Step;

override CUED: bool = false;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

struct Varying {
    @builtin(position) position: vec4f,
    // What is seen: a place, and depth and scalar of the front face and of the back face.
    @location(0) @interpolate(linear) place: vec2f,
    @location(1) @interpolate(linear) faces: vec4f,
    @location(2) @interpolate(flat) scale: f32,
    @location(3) @interpolate(flat) range: vec2f, // of the cell's scalars
}

// The same with what is seen of color and extinction on both faces.
struct ShadedVarying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(linear) place: vec2f,
    @location(1) @interpolate(linear) faces: vec4f,
    @location(2) @interpolate(flat) scale: f32,
    @location(3) @interpolate(linear) front: vec4f,
    @location(4) @interpolate(linear) back: vec4f,
}

// A vertex of an element's fan: a corner, or the center.
struct FanVertex {
    cell: u32,
    corner: u32,
    is_center: bool,
}

// Four triangles for each element.
fn fan_vertex(index: u32, instance: u32) -> FanVertex {
    let cell = list[instance];
    let fan = elements[cell].fan;
    let sides = (fan >> 8u) & 15u;
    let triangle = index / 3u;
    let corner = index % 3u;
    let outer = (triangle + select(0u, 1u, corner == 2u)) % max(sides, 1u);
    return FanVertex(cell, (fan >> (2u * outer)) & 3u, corner == 0u || triangle >= sides);
}

@vertex
fn vs_mesh_slice(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) instance: u32,
) -> Varying {
    let v = fan_vertex(index, instance);
    let element = elements[v.cell];
    let vertex = seen(vertex_of(corners_of(v.cell)[v.corner], v.cell));
    let place = select(vertex.xy, element.center, v.is_center);
    let faces = select(vertex.zwzw, vec4f(element.front, element.back), v.is_center);
    return Varying(vec4f(place / frame.extent, 0.0, 1.0), place, faces, element.scale, element.range);
}

@vertex
fn vs_mesh_slice_pre(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) instance: u32,
) -> ShadedVarying {
    let v = fan_vertex(index, instance);
    let element = elements[v.cell];
    let ids = corners_of(v.cell);
    let vertex = seen(vertex_of(ids[v.corner], v.cell));
    let place = select(vertex.xy, element.center, v.is_center);
    let faces = select(vertex.zwzw, vec4f(element.front, element.back), v.is_center);
    var front: vec4f;
    var back: vec4f;
    if v.is_center {
        let shaded = shaded_center(element, ids, v.cell);
        front = shaded.front;
        back = shaded.back;
    } else {
        front = shaded_seen(vertex_of(ids[v.corner], v.cell));
        back = front;
    }
    return ShadedVarying(vec4f(place / frame.extent, 0.0, 1.0), place, faces, element.scale, front, back);
}

// Color and extinction at a vertex, as seen.
fn shaded_seen(vertex: vec4f) -> vec4f {
    let shade = sample_interval(interval(find_interval(vertex.w, true)), vertex.w);
    return shade / (1.0 + vertex.z * frame.inverse_anchor_depth);
}

struct Shaded {
    front: vec4f,
    back: vec4f,
}

// The same on both faces at the center of a fan, between corners as triangles.wgsl has it.
fn shaded_center(element: Element, ids: vec4u, cell: u32) -> Shaded {
    var p: array<vec4f, 4>;
    var shade: array<vec4f, 4>;
    for (var i = 0u; i < 4u; i++) {
        let vertex = vertex_of(ids[i], cell);
        p[i] = seen(vertex);
        shade[i] = shaded_seen(vertex);
    }
    let fan = element.fan;
    let outline = vec4u(fan, fan >> 2u, fan >> 4u, fan >> 6u) & vec4u(3u);
    var one: vec4f;
    var other: vec4f;
    var depth: f32;
    if ((fan >> 8u) & 15u) == 4u {
        let share = share_of(element.center, p[outline.x].xy, p[outline.z].xy);
        one = mix(shade[outline.x], shade[outline.z], share);
        depth = mix(p[outline.x].z, p[outline.z].z, share);
        let along = share_of(element.center, p[outline.y].xy, p[outline.w].xy);
        other = mix(shade[outline.y], shade[outline.w], along);
    } else {
        // Corners' numbers add up to 6.
        let lone = 6u - outline.x - outline.y - outline.z;
        one = shade[lone];
        depth = p[lone].z;
        let a = p[outline.x].xy;
        let part = shares(a - element.center, p[outline.y].xy - a, p[outline.z].xy - a);
        other = shade[outline.x] + part.x * (shade[outline.y] - shade[outline.x])
            + part.y * (shade[outline.z] - shade[outline.x]);
        other = max(other, vec4f(0.0));
    }
    let is_front = abs(depth - element.front.x) <= abs(depth - element.back.x);
    return Shaded(select(other, one, is_front), select(one, other, is_front));
}

// Where on ab a point of it is.
fn share_of(point: vec2f, a: vec2f, b: vec2f) -> f32 {
    let ab = b - a;
    return saturate(dot(point - a, ab) / max(dot(ab, ab), 1e-37));
}

// What a fragment knows of its ray: depths and scalars of both faces, as seen. Rasterizers round
// vertices, to 2^-8 of a pixel; what that does is taken back.
fn faces_at(position: vec4f, place: vec2f, faces: vec4f) -> vec4f {
    let off = (place_of(position) - place / frame.extent) * frame.size * vec2f(0.5, -0.5);
    return faces + off.x * dpdx(faces) + off.y * dpdy(faces);
}

// In [−1, 1]².
fn place_of(position: vec4f) -> vec2f {
    return (position.xy / frame.size - 0.5) * vec2f(2.0, -2.0);
}

// Weights of what is on the front and the back face, and an alpha.
struct Weights {
    front: f32,
    back: f32,
    alpha: f32,
}

// Between the points where the ray meets the faces; k are their factors.
fn weights_between(faces: vec4f, k: vec2f) -> Weights {
    let depths = faces.xz / k;
    let plane = plane_depth(slice.first);
    let u = plane - depths.x;
    let v = depths.y - plane;
    if u < 0.0 || v <= 0.0 {
        return Weights(0.0, 0.0, 0.0);
    }
    let back = u / (u + v);
    return Weights(1.0 - back, back, 1.0);
}

// As published, along parallel rays.
fn weights_from_textures(faces: vec4f, scale: f32) -> Weights {
    let plane = plane_depth(slice.first);
    let at = 0.5 + 0.5 * vec2f(plane - faces.x, faces.z - plane) * scale;
    let back = textureSampleLevel(of_back, nearest, at, 0.0).xy;
    let front = textureSampleLevel(of_front, nearest, at, 0.0).x;
    return Weights(front, back.x, back.y);
}

fn factors(faces: vec4f) -> vec2f {
    return vec2f(1.0) - faces.xz * frame.inverse_anchor_depth;
}

@fragment
fn fs_mesh_slice(in: Varying) -> @location(0) vec4f {
    let faces = faces_at(in.position, in.place, in.faces);
    return post_shaded(in, faces, weights_between(faces, factors(faces)));
}

@fragment
fn fs_mesh_slice_textured(in: Varying) -> @location(0) vec4f {
    let faces = faces_at(in.position, in.place, in.faces);
    return post_shaded(in, faces, weights_from_textures(faces, in.scale));
}

@fragment
fn fs_mesh_slice_pre(in: ShadedVarying) -> @location(0) vec4f {
    let faces = faces_at(in.position, in.place, in.faces);
    let k = factors(faces);
    return pre_shaded(in, k, weights_between(faces, k));
}

@fragment
fn fs_mesh_slice_pre_textured(in: ShadedVarying) -> @location(0) vec4f {
    let faces = faces_at(in.position, in.place, in.faces);
    return pre_shaded(in, factors(faces), weights_from_textures(faces, in.scale));
}

fn post_shaded(in: Varying, faces: vec4f, weights: Weights) -> vec4f {
    if weights.alpha == 0.0 {
        discard;
    }
    // Beside a narrow cell what was taken back may lead beyond its scalars.
    let scalars = clamp(faces.yw / factors(faces), in.range.xx, in.range.yy);
    let scalar = scalars.x * weights.front + scalars.y * weights.back;
    return added(in.position, sample_interval(interval(find_interval(scalar, true)), scalar));
}

fn pre_shaded(in: ShadedVarying, k: vec2f, weights: Weights) -> vec4f {
    if weights.alpha == 0.0 {
        discard;
    }
    return added(in.position, in.front / k.x * weights.front + in.back / k.y * weights.back);
}

// What a slab adds in which color and extinction are as on its plane.
fn added(position: vec4f, shade: vec4f) -> vec4f {
    let place = place_of(position);
    let plane = plane_depth(slice.first);
    let origin = vec3f(place * frame.extent, 0.0);
    let along = vec3f(place * frame.slope, 1.0);
    let left = clip_ray(origin, along);
    if plane < left.x || plane > left.y || plane >= end_of_ray(vec2i(position.xy)) {
        discard;
    }
    var color = shade.xyz;
    if CUED {
        color *= cue_at(origin + plane * along);
    }
    let depth = shade.w * frame.step * length(along);
    switch MODEL {
        case EMISSION_ABSORPTION: {
            let alpha = opacity(depth);
            return vec4f(alpha * color, alpha);
        }
        case EMISSION: {
            return vec4f(depth * color, 0.0);
        }
        case ABSORPTION: {
            return vec4f(depth, 0.0, 0.0, 0.0);
        }
        default: {
            return vec4f(color, 0.0);
        }
    }
}
