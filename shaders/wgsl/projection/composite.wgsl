// Composite: sort a pixel's fragments by their entries and add them, front to back.
//
// A merge sort on the list itself, so that no fragment is dropped however long it is: two
// runs are taken from the list of runs and become one in the list of the next round; the
// last two are added up as they merge. Each pass of the one loop takes one fragment, and
// n fragments need at most n ⌈log₂ n⌉ passes and one to see that nothing is left.
//
// Devices cut long loops short, some in silence (Mesa's llvmpipe after 65 535 passes), so
// this is drawn in turns of at most `PASSES`, with what is left kept in between.
// In:   heads, fragments; states, but for the first turn.
// Out:  light and opacity, premultiplied, right after the last turn; states, but for the last.
// With: projection/fragments.wgsl, common/optics_model.wgsl, common/sums.wgsl

// Passes of a turn, `passes::lists::PASSES`.
const PASSES: u32 = 16384u;

// How far a pixel is; numbers of fragments, 0 for none.
struct State {
    a: u32,     // the first of what is left of each of the two runs that are being merged
    b: u32,
    head: u32,  // the first and the last of what became of them
    tail: u32,
    front: u32, // the first of the next run of this round
    out: u32,   // the first of the last run of the next round
    // What is added up.
    red: f32,
    green: f32,
    blue: f32,
    optical_depth: f32,
    // Of these, what was put aside, and fragments that are added up.
    red_aside: f32,
    green_aside: f32,
    blue_aside: f32,
    depth_aside: f32,
    added: u32,
}

// Of each pixel of the tile; one where there is one turn.
@group(2) @binding(3) var<storage, read_write> states: array<State>;

// One triangle over the whole image.
@vertex
fn vs_composite(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_composite(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let head = head_of(position);
    let own = min(head - FIRST_HEAD, arrayLength(&states) - 1u);
    var s = State(0u, 0u, 0u, 0u, atomicLoad(&heads[head]), 0u, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0u);
    if tile.turn > 0u {
        s = states[own];
    }
    var depth_a = depth_of(s.a);
    var depth_b = depth_of(s.b);
    var done = false;
    for (var n = 0u; n < PASSES; n++) {
        if (s.a | s.b) == 0u {
            if s.front == 0u {
                s.front = s.out;
                s.out = 0u;
            }
            if s.front == 0u {
                done = true;
                break;
            }
            s.a = s.front;
            s.b = run_after(s.a);
            if s.b == 0u && s.out != 0u {
                // One is left over: it begins the next round.
                s.b = s.out;
                s.out = 0u;
            }
            s.front = run_after(s.b);
            depth_a = depth_of(s.a);
            depth_b = depth_of(s.b);
        }
        let from_a = s.b == 0u || (s.a != 0u && depth_a <= depth_b);
        let nearest = select(s.b, s.a, from_a);
        let f = fragments[nearest - 1u];
        if from_a {
            s.a = f.next;
            depth_a = depth_of(s.a);
        } else {
            s.b = f.next;
            depth_b = depth_of(s.b);
        }
        // Of the last two runs, whose fragments come in their order.
        if (s.front | s.out) == 0u {
            let left = transmittance(s.depth_aside + s.optical_depth);
            s.red += left * f.red;
            s.green += left * f.green;
            s.blue += left * f.blue;
            s.optical_depth += f.optical_depth;
            s.added += 1u;
            let is_time = s.added % SUMMED == 0u;
            let sum = sum_of(s);
            s.red_aside = select(s.red_aside, sum.x, is_time);
            s.green_aside = select(s.green_aside, sum.y, is_time);
            s.blue_aside = select(s.blue_aside, sum.z, is_time);
            s.depth_aside = select(s.depth_aside, sum.w, is_time);
            s.red = select(s.red, 0.0, is_time);
            s.green = select(s.green, 0.0, is_time);
            s.blue = select(s.blue, 0.0, is_time);
            s.optical_depth = select(s.optical_depth, 0.0, is_time);
            continue;
        }
        if s.tail == 0u {
            s.head = nearest;
        } else {
            fragments[s.tail - 1u].next = nearest;
        }
        s.tail = nearest;
        if s.a == 0u || s.b == 0u {
            // The rest of the other is in order.
            fragments[nearest - 1u].next = s.a | s.b;
            fragments[s.head - 1u].run = s.out;
            s.out = s.head;
            s.a = 0u;
            s.b = 0u;
            s.head = 0u;
            s.tail = 0u;
        }
    }
    if tile.turn + 1u < tile.turns {
        states[own] = s;
    } else if !done {
        atomicAdd(&heads[1], 1u);
    }
    let sum = sum_of(s);
    return vec4f(sum.xyz, opacity(sum.w));
}

// Light and optical depth.
fn sum_of(s: State) -> vec4f {
    return vec4f(s.red_aside, s.green_aside, s.blue_aside, s.depth_aside)
        + vec4f(s.red, s.green, s.blue, s.optical_depth);
}

// 0 for what is none.
fn depth_of(number: u32) -> f32 {
    return select(0.0, fragments[max(number, 1u) - 1u].depth, number != 0u);
}

fn run_after(number: u32) -> u32 {
    return select(0u, fragments[max(number, 1u) - 1u].run, number != 0u);
}
