// Wide: integers of 64 bits as two words, the lower one first.
//
// Devices have 64-bit integers if they like, and divide them slowly. Two's complement: sums and
// products wrap around, as those of words do.

fn wide_of(a: i32) -> vec2u {
    return vec2u(bitcast<u32>(a), bitcast<u32>(a >> 31u));
}

fn is_negative(a: vec2u) -> bool {
    return bitcast<i32>(a.y) < 0;
}

fn wide_sum(a: vec2u, b: vec2u) -> vec2u {
    let low = a.x + b.x;
    return vec2u(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn wide_difference(a: vec2u, b: vec2u) -> vec2u {
    return vec2u(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn wide_negated(a: vec2u, negated: bool) -> vec2u {
    return select(a, wide_difference(vec2u(0u), a), negated);
}

// For shifts of 1 to 31.
fn wide_shifted(a: vec2u, bits: u32) -> vec2u {
    return vec2u(a.x << bits, (a.y << bits) | (a.x >> (32u - bits)));
}

fn product_of_words(a: u32, b: u32) -> vec2u {
    let al = a & 0xffffu;
    let ah = a >> 16u;
    let bl = b & 0xffffu;
    let bh = b >> 16u;
    let low = al * bl;
    let across = al * bh;
    // Below 2³² − 2¹⁷ + 1 + 2¹⁷ − 2.
    let middle = ah * bl + (low >> 16u) + (across & 0xffffu);
    return vec2u((middle << 16u) | (low & 0xffffu), ah * bh + (across >> 16u) + (middle >> 16u));
}

// a b for a number that is not negative and a word that is not; or modulo 2⁶⁴.
fn wide_times_word(a: vec2u, b: u32) -> vec2u {
    let low = product_of_words(a.x, b);
    return vec2u(low.x, low.y + a.y * b);
}

// The same for any signs.
fn wide_times(a: vec2u, b: i32) -> vec2u {
    let negative = is_negative(a);
    return wide_negated(wide_times_word(wide_negated(a, negative), u32(abs(b))), negative != (b < 0));
}

// Of a number that is not negative, off by 2⁻²³ of itself at most: both words are rounded, and the sum.
fn float_of(a: vec2u) -> f32 {
    return f32(a.y) * 4294967296.0 + f32(a.x);
}

// n = whole d + rest, with 0 ≤ rest < d.
struct Quotient {
    whole: i32,    // modulo 2³²
    rest: vec2u,
}

// For d > 0 and its inverse as a float; exact where |n| / d is below 2³¹.
//
// A float names the quotient but for some 2⁻²¹ of it, as WGSL lets a division err by 2.5 units: what
// is left is below (2¹⁰ + 1) d, and its quotient in turn is off by less than one.
fn quotient(n: vec2u, d: vec2u, inverse: f32) -> Quotient {
    let negative = is_negative(n);
    let size = wide_negated(n, negative);
    let rough = u32(float_of(size) * inverse);
    let left = wide_difference(size, wide_times_word(d, rough));
    let below = is_negative(left);
    // Towards the lower side, so that what remains is between −d and 2 d.
    let more = u32(float_of(wide_negated(left, below)) * inverse) + select(0u, 1u, below);
    let step = wide_negated(wide_times_word(d, more), below);
    let found = settled(rough + select(more, 0u - more, below), wide_difference(left, step), d);
    // Down, of a negative number as well.
    let whole = select(found.whole, ~found.whole, negative);
    let rest = select(found.rest, wide_difference(d, found.rest), negative);
    let is_exact = negative && all(found.rest == vec2u(0u));
    return Quotient(select(whole, whole + 1, is_exact), select(rest, vec2u(0u), is_exact));
}

// The same for a number that is not negative and a quotient below 2²⁰.
fn small_quotient(n: vec2u, d: vec2u, inverse: f32) -> Quotient {
    let rough = u32(float_of(n) * inverse);
    return settled(rough, wide_difference(n, wide_times_word(d, rough)), d);
}

// For a quotient that is at most one away: −d ≤ rest < 2 d.
fn settled(whole: u32, rest: vec2u, d: vec2u) -> Quotient {
    let below = is_negative(rest);
    let less = wide_difference(rest, d);
    let above = !below && !is_negative(less);
    return Quotient(
        bitcast<i32>(whole + select(0u, 1u, above) - select(0u, 1u, below)),
        select(select(rest, less, above), wide_sum(rest, d), below),
    );
}
