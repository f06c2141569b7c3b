// Box against plane: the published vertex program.
//
// Rezk Salama, Kolb 2005, §4, §5 and Listing 1. Six vertices in, six out: the polygon
// in which a plane cuts a box, counterclockwise, with duplicates where it has fewer.
// In:   boxes, back to front, one an instance; a stack of polygons as vertices.
// With: slicing/frame.wgsl

// The published tables, generated on the CPU (`box_plane.rs`).
struct Tables {
    sequence: array<vec4u, 16>, // which corner plays role r: entry 8 · front + r
    first: array<vec4u, 6>,     // v1: where the edges begin that a vertex tries, roles
    second: array<vec4u, 6>,    // v2: where they end
}

@group(0) @binding(3) var<uniform> tables: Tables;

// Whether an edge is cut as published, 0 ≤ λ ≤ 1, or by its ends' sides. In f32 a plane
// just before a corner may have λ > 1 on one edge and λ < 0 on the next, and published
// finds no edge: 2 % of such paths. Ends lie on one side or the other, and a path begins
// on one and ends on the other, so by sides there always is a cut edge.
override BY_SIDES: bool = true;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) slab: i32,
    @location(1) @interpolate(flat) box_index: u32,
}

@vertex
fn vs_slice(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    let low = vec3f(boxes[instance].low) - frame.margin.xyz;
    let size = frame.box_size.xyz + 2.0 * frame.margin.xyz;
    // The first slab whose plane may cut the box; the stack is drawn from the back.
    let nearest = camera_depth(low + corner(frame.front) * size);
    let first = i32(ceil((nearest - frame.first_depth) / frame.step - 0.5));
    let slab = first + i32(frame.slabs_per_box) - 1 - i32(index / 6u);
    var out: Varying;
    out.slab = slab;
    out.box_index = instance;
    if slab < 0 || slab >= frame.slab_count {
        return out; // all six at one point
    }
    let depth = plane_depth(slab);
    let tries = tables.first[index % 6u];
    let ends = tables.second[index % 6u];
    var position = low;
    for (var e = 0u; e < 4u; e++) {
        let from_corner = low + corner(role(tries[e])) * size;
        let to_corner = low + corner(role(ends[e])) * size;
        let h = camera_depth(from_corner);
        let k = camera_depth(to_corner);
        if BY_SIDES {
            if (h < depth) != (k < depth) {
                let lambda = saturate((depth - h) / (k - h));
                position = from_corner + lambda * (to_corner - from_corner);
                break;
            }
        } else {
            // Listing 1 takes the slope of the edge itself, and λ = −1 without one.
            let slope = dot(frame.forward.xyz, to_corner - from_corner);
            let lambda = select(-1.0, (depth - h) / slope, slope != 0.0);
            if lambda >= 0.0 && lambda <= 1.0 {
                position = from_corner + lambda * (to_corner - from_corner);
                break;
            }
        }
    }
    out.position = clip_position(position);
    return out;
}

// A corner of a polygon that the CPU has cut.
@vertex
fn vs_polygon(
    @location(0) corner: vec3f, // lattice space
    @location(1) slab: i32,
    @location(2) box_index: u32,
) -> Varying {
    return Varying(clip_position(corner), slab, box_index);
}

fn role(r: u32) -> u32 {
    let entry = 8u * frame.front + r;
    return tables.sequence[entry / 4u][entry % 4u];
}

// The corner with these bits of the unit cube.
fn corner(bits: u32) -> vec3f {
    return vec3f(f32(bits & 1u), f32(bits >> 1u & 1u), f32(bits >> 2u & 1u));
}
