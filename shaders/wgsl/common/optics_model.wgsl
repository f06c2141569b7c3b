// Optics: which model, and what an optical depth means.

// `tetrascope_core::OpticalModel`, in its order.
const EMISSION_ABSORPTION: u32 = 0u;
const EMISSION: u32 = 1u;
const ABSORPTION: u32 = 2u;
const MAXIMUM_INTENSITY: u32 = 3u;
const ISOSURFACES: u32 = 4u;
override MODEL: u32 = EMISSION_ABSORPTION;

// e^(−m), 0 where f32 has no number so small.
fn transmittance(m: f32) -> f32 {
    return exp(-min(m, 100.0));
}

// 1 − e^(−m) without cancellation. The series' next term, m⁶/5040 of m, is under 2⁻²⁴
// at m = 1/4; beyond that 1 − e^(−m) loses two bits.
fn opacity(m: f32) -> f32 {
    if m < 0.25 {
        return m * (1.0 + m * (-1.0 / 2.0 + m * (1.0 / 6.0 + m * (-1.0 / 24.0
            + m * (1.0 / 120.0 + m * (-1.0 / 720.0))))));
    }
    return 1.0 - transmittance(m);
}

// What is blended for light and an optical depth, as `gather` of tetrascope-gpu does.
fn blended(sum: vec4f) -> vec4f {
    switch MODEL {
        case EMISSION_ABSORPTION: {
            return vec4f(sum.xyz, opacity(sum.w));
        }
        case ABSORPTION: {
            return vec4f(sum.w, 0.0, 0.0, 0.0);
        }
        default: {
            return vec4f(sum.xyz, 0.0);
        }
    }
}
