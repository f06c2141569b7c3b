// Section: the cross sections of elements with one slice, by two textures of weights.
//
// Westermann 2001 section 2.1 (`vs_section`, `fs_front`, then `fs_back`) and section 4 (`fs_both`).
// Out:  scalar and coverage of the slice's samples, in a target of the grid's width and height.
// With: resample/mesh.wgsl, resample/element.wgsl

@group(1) @binding(0) var<storage, read> elements: array<Element>;
@group(1) @binding(1) var<storage, read> list: array<u32>;
@group(2) @binding(0) var<storage, read> slice: Step;
// T1 and T2: a weight and an alpha.
@group(3) @binding(0) var of_back: texture_2d<f32>;
@group(3) @binding(1) var of_front: texture_2d<f32>;
@group(3) @binding(2) var nearest: sampler;
// What the first pass has drawn, where the second cannot add to it.
@group(3) @binding(3) var first_pass: texture_2d<f32>;

// Rasterizers round vertices, to 2^-8 of a pixel on every GPU, and some round what is interpolated
// with them: then a fragment can tell by how much.
override ROUNDED: f32 = 0.00390625;

// 2^-64, from where on 2^29 floats follow until 1: their first half are depths of cells.
const FIRST_DEPTH: u32 = 0x1f800000u;
const HALF_OF_DEPTHS: u32 = 0x10000000u;

struct Varying {
    @builtin(position) @invariant position: vec4f,
    // How far the slice is behind the front face, and before the back face: u and v. Then the
    // scalars on the front and on the back face.
    @location(0) @interpolate(linear) faces: vec4f,
    // The pixel, before vertices are rounded.
    @location(1) @interpolate(linear) place: vec2f,
    @location(2) @interpolate(flat) cell: u32,
    @location(3) @interpolate(flat) range: vec2f, // of the cell's scalars
}

// The depth is a cell's number: among cells that cover a sample the first one wins, in both
// passes.
struct Fragment {
    @location(0) sample: vec2f, // scalar and coverage
    @builtin(frag_depth) depth: f32,
}

// Four triangles for each element.
@vertex
fn vs_section(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) instance: u32,
) -> Varying {
    let cell = list[instance];
    let element = elements[cell];
    let ids = corners_of(cell);
    let sides = (element.fan >> 8u) & 15u;
    let triangle = index / 3u;
    let corner = index % 3u;
    let is_center = corner == 0u || triangle >= sides;
    let turn = (triangle + select(0u, 1u, corner == 2u)) % max(sides, 1u);
    let outer = (element.fan >> (2u * turn)) & 3u;
    let vertex = vertex_of(ids[select(outer, 0u, is_center)]);
    let at = f32(slice.first) - vertex.sample.z;
    var xy = vertex.sample.xy + vertex.offset.xy;
    var scalars = vec2f(scalars_of(cell, vec4f(vertex.scalar)).x);
    var distances = vec2f(at - vertex.offset.z, vertex.offset.z - at);
    if is_center {
        xy = vertex.sample.xy + element.center;
        scalars = vec2f(element.front.y, element.back.y);
        distances = vec2f(at - element.front.x, element.back.x - at);
    }
    let size = vec2f(work.high);
    let place = xy + 0.5;
    let clip = place / size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    // A grid often ends where the mesh does: larger by two roundings at its edges, the mesh covers
    // them in spite of rounding. Fragments take that back as well.
    let larger = 1.0 + 4.0 * ROUNDED / size;
    let faces = vec4f(distances * element.scale, scalars);
    return Varying(vec4f(clip * larger, 0.0, 1.0), faces, place, cell, element.range);
}

// The first of two passes: what the front faces give.
@fragment
fn fs_front(in: Varying) -> Fragment {
    let at = fragment_of(in);
    let weight = weight_at(of_front, at);
    if weight.y == 0.0 {
        discard;
    }
    return Fragment(vec2f(at.scalars.x * weight.x, 1.0), at.depth);
}

// The second, which is added.
@fragment
fn fs_back(in: Varying) -> Fragment {
    let at = fragment_of(in);
    let weight = weight_at(of_back, at);
    if weight.y == 0.0 {
        discard;
    }
    return Fragment(vec2f(at.scalars.y * weight.x, 0.0), at.depth);
}

// The second where targets of 32-bit floats cannot be added to.
@fragment
fn fs_back_added(in: Varying) -> Fragment {
    let at = fragment_of(in);
    let weight = weight_at(of_back, at);
    if weight.y == 0.0 {
        discard;
    }
    let before = textureLoad(first_pass, vec2u(in.position.xy), 0).xy;
    return Fragment(before + vec2f(at.scalars.y * weight.x, 0.0), at.depth);
}

// Both in one pass: texture combiners.
@fragment
fn fs_both(in: Varying) -> Fragment {
    let at = fragment_of(in);
    let front = weight_at(of_front, at);
    let back = weight_at(of_back, at);
    if front.y == 0.0 {
        discard;
    }
    return Fragment(vec2f(at.scalars.x * front.x + at.scalars.y * back.x, 1.0), at.depth);
}

struct Ends {
    distances: vec2f, // in shares of the cell's thickness
    scalars: vec2f,
    depth: f32,
}

// What is on both faces at the pixel itself. What is outside by no more than rounded vertices explain
// is on the face, behind all cells that the sample is in: so none is left out between two cells.
fn fragment_of(in: Varying) -> Ends {
    let per_x = dpdx(in.faces);
    let per_y = dpdy(in.faces);
    let off = in.position.xy - in.place;
    let faces = in.faces + off.x * per_x + off.y * per_y;
    let most = max(abs(off), vec2f(ROUNDED));
    let explained = most.x * abs(per_x.xy) + most.y * abs(per_y.xy);
    let is_on = (faces.xy < vec2f(0.0)) & (faces.xy >= -explained);
    let number = FIRST_DEPTH + in.cell + select(0u, HALF_OF_DEPTHS, any(is_on));
    return Ends(
        select(faces.xy, vec2f(0.0), is_on),
        // Beside a narrow cell a slope leads beyond its scalars.
        clamp(faces.zw, in.range.xx, in.range.yy),
        bitcast<f32>(number),
    );
}

// The weight and alpha: distances of 0 are in the texture's middle.
fn weight_at(weights: texture_2d<f32>, at: Ends) -> vec2f {
    return textureSampleLevel(weights, nearest, 0.5 + 0.5 * at.distances, 0.0).xy;
}
