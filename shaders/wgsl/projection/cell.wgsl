// Cell: integrate along each ray in a cell and blend.
//
// Weiler, Kraus, Ertl 2002, §5.1.
// In:   Varying, cells back to front where that matters.
// Out:  EmissionAbsorption: light and opacity, premultiplied; Emission: light;
//       Absorption: optical depth in red; MaximumIntensity: color.
// With: projection/chord.wgsl and what it needs, projection/transfer.wgsl,
//       projection/segment.wgsl and what it needs

@fragment
fn fs_cell(in: Varying) -> @location(0) vec4f {
    let chord = chord_of(in);
    if chord.length <= 0.0 {
        return vec4f(0.0);
    }
    let sum = segment_within(in, chord);
    switch MODEL {
        case EMISSION_ABSORPTION: {
            return vec4f(sum.xyz, segment_opacity(sum));
        }
        case ABSORPTION: {
            return vec4f(segment_depth(sum), 0.0, 0.0, 0.0);
        }
        default: {
            return vec4f(sum.xyz, 0.0);
        }
    }
}
