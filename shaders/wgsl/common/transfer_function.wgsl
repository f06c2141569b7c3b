// Transfer function: the intervals between its knots.
//
// The first and the last interval are constant and reach beyond every scalar; a
// step is a boundary at which neighbors disagree. Scalars are in the unit of
// `ScalarMap`, extinction is per normalized length.
// Needs: `fn interval(i: u32) -> KnotPair` and `fn interval_count() -> u32`.

struct KnotPair {
    at_low: vec4f,  // linear RGB and extinction at the lower end, from within
    at_high: vec4f, // and at the upper end
    low: f32,
    high: f32,
    inverse_width: f32,
}

// Both weights come from differences of given numbers, so neither end loses digits.
fn sample_interval(i: KnotPair, scalar: f32) -> vec4f {
    let toward_high = saturate((scalar - i.low) * i.inverse_width);
    let toward_low = saturate((i.high - scalar) * i.inverse_width);
    return i.at_low * toward_low + i.at_high * toward_high;
}

// The interval that one enters at `scalar` on the way up, or on the way down.
fn find_interval(scalar: f32, rising: bool) -> u32 {
    // How many of the boundaries are below, by bisection.
    var first = 0u;
    var last = interval_count() - 1u;
    while first < last {
        let middle = (first + last + 1u) / 2u;
        let boundary = interval(middle).low;
        if boundary < scalar || (rising && boundary == scalar) {
            first = middle;
        } else {
            last = middle - 1u;
        }
    }
    return first;
}

// The interval in which a ray is, kept from segment to segment, as most begin where the one before
// ended.
struct Held {
    index: u32,
    pair: KnotPair,
    // Whether the scalar is constant and on a step: both sides count half, and this is the lower one.
    on_step: bool,
    below: vec4f,
}

// Before the first segment: no scalar is in it.
fn no_interval() -> Held {
    return Held(0u, KnotPair(vec4f(0.0), vec4f(0.0), 1.0, 0.0, 0.0), false, vec4f(0.0));
}

// Goes to the interval that one enters at `scalar`, on the way up or down.
fn enter(held: ptr<function, Held>, scalar: f32, rising: bool, is_constant: bool) {
    (*held).on_step = false;
    // At a knot the direction decides.
    if scalar > (*held).pair.low && scalar < (*held).pair.high {
        return;
    }
    let index = find_interval(scalar, rising);
    (*held).index = index;
    (*held).pair = interval(index);
    if is_constant && index > 0u && scalar == (*held).pair.low {
        (*held).on_step = true;
        (*held).below = sample_interval(interval(index - 1u), scalar);
    }
}
