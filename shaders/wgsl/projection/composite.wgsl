// Composite: sort a pixel's fragments by their entries and add them, front to back.
//
// A merge sort of runs that are in order already, on the list itself: as long as it
// may be, no fragment is dropped, and one of n takes O(n log n) steps.
// In:   heads, fragments.
// Out:  light and opacity, premultiplied.
// With: projection/fragments.wgsl, common/optics_model.wgsl

// One triangle over the whole image.
@vertex
fn vs_composite(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_composite(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = atomicLoad(&heads[head_of(position)]);
    var sum = vec4f(0.0);
    var number = sorted(first);
    // Bounded like every loop here, so that no list can hang the device.
    for (var n = 0u; n < tile.capacity && number != 0u; n++) {
        let f = fragments[number - 1u];
        sum = vec4f(
            sum.xyz + transmittance(sum.w) * vec3f(f.red, f.green, f.blue),
            sum.w + f.optical_depth,
        );
        number = f.next;
    }
    return vec4f(sum.xyz, opacity(sum.w));
}

fn next_of(number: u32) -> u32 {
    return fragments[number - 1u].next;
}

fn depth_of(number: u32) -> f32 {
    return fragments[number - 1u].depth;
}

// The first of the list that begins with `first`, sorted by depth.
fn sorted(first: u32) -> u32 {
    var list = first;
    // Each round halves the number of runs.
    for (var round = 0u; round < 32u; round++) {
        var rest = list;
        var tail = 0u;
        var merges = 0u;
        list = 0u;
        for (var n = 0u; n < tile.capacity && rest != 0u; n++) {
            merges++;
            var a = rest;
            var b = cut_run(a);
            rest = 0u;
            if b != 0u {
                rest = cut_run(b);
            }
            // Merge the runs a and b behind `tail`; ends when both are empty.
            for (var m = 0u; m < tile.capacity && (a | b) != 0u; m++) {
                var from_a = b == 0u;
                if a != 0u && b != 0u {
                    from_a = depth_of(a) <= depth_of(b);
                }
                let least = select(b, a, from_a);
                let after = next_of(least);
                a = select(a, after, from_a);
                b = select(after, b, from_a);
                if tail == 0u {
                    list = least;
                } else {
                    fragments[tail - 1u].next = least;
                }
                tail = least;
            }
        }
        if merges <= 1u {
            break;
        }
    }
    return list;
}

// Ends the run that begins with `start` and returns what came after it.
fn cut_run(start: u32) -> u32 {
    var last = start;
    for (var n = 0u; n < tile.capacity; n++) {
        let next = next_of(last);
        if next == 0u {
            return 0u;
        }
        if depth_of(next) < depth_of(last) {
            fragments[last - 1u].next = 0u;
            return next;
        }
        last = next;
    }
    return 0u;
}
