// Segment: integrate over a ray's part in a cell whose range of scalars is known.
//
// Weiler, Kraus, Ertl 2002, §5.1. As `integrate` of common/optics.wgsl, but the cell says
// in which intervals its scalars are, so no fragment searches.
// With: common/transfer_function.wgsl, common/optics.wgsl, preintegration/lookup.wgsl,
//       projection/pieces.wgsl

// `segment` of lookup.wgsl for a ray's part in a cell.
fn segment_within(in: Varying, chord: Chord) -> vec4f {
    var sum = vec4f(0.0);
    if CUED {
        sum = integrate_cued(chord.front, chord.back, chord.length, chord.cue);
    } else if PIECES {
        sum = integrate_piece(in, chord.front, chord.back, chord.length);
    } else if TABLE_AXES == 0u {
        sum = integrate_within(in.range.x, in.range.y, chord.front, chord.back, chord.length);
    } else {
        sum = segment(chord.front, chord.back, chord.length);
    }
    return sum;
}

// What a segment adds on which the scalar goes linearly from `front` to `back` within the
// intervals from `first` to `last`: light in xyz, optical depth in w.
fn integrate_within(first: u32, last: u32, front: f32, back: f32, length: f32) -> vec4f {
    let rising = front <= back;
    let whole = abs(back - front);
    let constant = whole == 0.0;
    var sum = vec4f(0.0);
    var on_step = false;
    var before_step = vec4f(0.0);
    for (var n = 0u; n <= last - first; n++) {
        let index = select(last - n, first + n, rising);
        let i = interval(index);
        let from_scalar = clamp(front, i.low, i.high);
        let to_scalar = clamp(back, i.low, i.high);
        var start = sample_interval(i, from_scalar);
        var end = sample_interval(i, to_scalar);
        // Each piece is as long as its share of the scalars; a constant one is whole.
        var share = length * (abs(to_scalar - from_scalar) / max(whole, 1e-36));
        if constant {
            share = select(0.0, length, front == from_scalar);
            // On a step, both sides count half: this one waits for the next.
            start = select(start, 0.5 * (start + before_step), on_step);
            end = start;
            on_step = front == i.high && index < last;
            before_step = start;
            share = select(share, 0.0, on_step);
        }
        // A piece without length adds nothing, in MAXIMUM_INTENSITY neither.
        if share > 0.0 {
            sum = add_piece(sum, start, end, share);
        }
        if hides_all(sum) {
            break;
        }
    }
    return sum;
}
