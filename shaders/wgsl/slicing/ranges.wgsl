// Ranges: the least and greatest scalar of every box of the octree, from the samples on the
// device; so nothing is read back to know what is empty.
//
// In:   the samples, in the field's unit.
// Out:  the ranges of all levels, one level behind the other, boxes x fastest.

struct Ranges {
    cells: vec4u,     // of the volume, along each axis
    box_size: vec4u,  // cells along each axis of a box of this level
    divisions: vec4u, // boxes along each axis, those outside of the volume too
    halved: vec4u,    // 1 along axes on which the level below has twice as many boxes
    first: u32,       // where this level's ranges begin
    first_below: u32,
    reach: u32,       // samples around a box that its range includes
}

// Whether texels have a coverage behind the scalar; what has none has no scalar.
override COVERED: bool = false;
// Whether texels may be NO_VALUE.
override GAPS: bool = false;
const NO_VALUE: f32 = 3.40282346638528859811704183484516925e+38;

@group(0) @binding(0) var<uniform> level: Ranges;
@group(0) @binding(1) var<storage, read_write> ranges: array<vec2f>;
@group(1) @binding(0) var voxels: texture_3d<f32>;

// Without any scalar: least above greatest.
const EMPTY: vec2f = vec2f(NO_VALUE, -NO_VALUE);

const THREADS: u32 = 64u;

var<workgroup> found: array<vec2f, THREADS>;

// Ranges of boxes of the deepest level: a workgroup reads the samples of each.
@compute @workgroup_size(THREADS)
fn cs_leaf(
    @builtin(workgroup_id) place: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let low = place * level.box_size.xyz;
    var range = EMPTY;
    if all(low < level.cells.xyz) {
        let first = max(low, vec3u(level.reach)) - level.reach;
        let last = min(low + level.box_size.xyz + level.reach, level.cells.xyz);
        let size = last - first + 1u;
        // Each invocation takes rows of samples: a division for each sample takes longer than all else.
        let rows = size.y * size.z;
        for (var row = local; row < rows; row += THREADS) {
            let start = first + vec3u(0u, row % size.y, row / size.y);
            for (var x = 0u; x < size.x; x++) {
                let texel = textureLoad(voxels, start + vec3u(x, 0u, 0u), 0).xy;
                range = with_texel(range, texel);
            }
        }
    }
    found[local] = range;
    workgroupBarrier();
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        if local < half {
            found[local] = joined(found[local], found[local + half]);
        }
        workgroupBarrier();
    }
    if local == 0u {
        ranges[level.first + index_of(place, level.divisions.xyz)] = found[0];
    }
}

// Ranges of boxes of another level, from those of the level below.
@compute @workgroup_size(THREADS)
fn cs_gather(@builtin(global_invocation_id) id: vec3u) {
    let divisions = level.divisions.xyz;
    if id.x >= divisions.x * divisions.y * divisions.z {
        return;
    }
    let place = vec3u(
        id.x % divisions.x,
        id.x / divisions.x % divisions.y,
        id.x / (divisions.x * divisions.y),
    );
    let below = divisions << level.halved.xyz;
    var range = EMPTY;
    for (var i = 0u; i < 8u; i++) {
        let child = vec3u(i & 1u, i >> 1u & 1u, i >> 2u);
        if any(child > level.halved.xyz) {
            continue;
        }
        let number = index_of((place << level.halved.xyz) + child, below);
        range = joined(range, ranges[level.first_below + number]);
    }
    ranges[level.first + id.x] = range;
}

fn with_texel(range: vec2f, texel: vec2f) -> vec2f {
    if (COVERED && texel.y <= 0.0) || (GAPS && texel.x >= NO_VALUE) {
        return range;
    }
    return joined(range, texel.xx);
}

fn joined(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(min(a.x, b.x), max(a.y, b.y));
}

fn index_of(place: vec3u, divisions: vec3u) -> u32 {
    return place.x + divisions.x * (place.y + divisions.y * place.z);
}
