//! The data that `restyle` changes: the transfer function as lanes read it.

use tetrascope_core::{Appearance, OpticalModel};
use tetrascope_f32::knots::knot_pairs;
use tetrascope_f32::look::surfaces;
use tetrascope_f32::{KnotPair, deepest, is_transparent};

use super::packed::Packed;
use crate::options::RaycastCpuOptions;

/// An interval of the transfer function, one array a value in a packet: RGB and extinction at its
/// lower end, and how much more they are at its upper end; then where it is.
pub(super) type Interval = [f32; VALUES];

/// How many values.
pub(super) const VALUES: usize = 13;
/// The scalar of the lower end.
pub(super) const LOW: usize = 8;
/// The scalar of the upper end.
pub(super) const HIGH: usize = 9;
/// 1 / (high − low).
pub(super) const INVERSE_WIDTH: usize = 10;
/// The lower end if the function jumps there, else NaN.
pub(super) const STEP_LOW: usize = 11;
/// The same of the upper end.
pub(super) const STEP_HIGH: usize = 12;

/// An appearance, ready for a mesh.
#[derive(Clone, Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    pub(super) intervals: Vec<Interval>,
    /// Whether the function jumps anywhere.
    pub(super) has_steps: bool,
    /// The values of isosurfaces, mapped, increasing, and which of the appearance each is.
    pub(super) surfaces: Vec<(f32, usize)>,
    /// Whether nothing of the mesh shows.
    pub(super) is_transparent: bool,
    /// The transmittance below which a ray stops.
    pub(super) least_transmittance: f32,
}

impl Style {
    pub(super) fn new(
        mesh: &Packed,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Style {
        let tf = &appearance.transfer_function;
        let pairs = knot_pairs(tf, &mesh.scalar_map, &mesh.places.normalization);
        let deepest = deepest(&pairs, mesh.scalars(), mesh.places.longest_edge);
        let by_value = surfaces(appearance);
        let number = |value: f64| {
            let mut all = appearance.isosurfaces.iter();
            all.position(|s| s.value == value)
        };
        let surfaces = by_value.iter().filter_map(|surface| {
            let value = mesh.scalar_map.scalar(surface.value);
            Some((value, number(surface.value)?))
        });
        let intervals = intervals(&pairs);
        Style {
            has_steps: intervals.iter().any(|i| !i[STEP_LOW].is_nan()),
            intervals,
            surfaces: surfaces.collect(),
            is_transparent: is_transparent(appearance.optical_model, deepest),
            least_transmittance: least_transmittance(appearance, options),
            appearance: appearance.clone(),
        }
    }
}

/// Behind this transmittance nothing shows, or less than `stop_opacity` leaves.
///
/// Light behind is dimmed to less than 2⁻²⁶, a quarter of a last place of the greatest color's f32.
pub(crate) fn least_transmittance(appearance: &Appearance, options: &RaycastCpuOptions) -> f32 {
    if appearance.optical_model != OpticalModel::EmissionAbsorption {
        return 0.0;
    }
    (-options.stop_depth()).exp().max(1.0 / (1 << 26) as f32)
}

/// Pairs of knots as lanes read them.
fn intervals(pairs: &[KnotPair]) -> Vec<Interval> {
    let jumps = |below: Option<&KnotPair>, above: Option<&KnotPair>| match (below, above) {
        (Some(below), Some(above)) if below.at_high != above.at_low => above.low,
        _ => f32::NAN,
    };
    let interval = |(i, pair): (usize, &KnotPair)| {
        let [before, behind] = [i.checked_sub(1), i.checked_add(1)];
        let mut values = [0.0; VALUES];
        values[..4].copy_from_slice(&pair.at_low);
        values[4..8].copy_from_slice(&[0, 1, 2, 3].map(|j| pair.at_high[j] - pair.at_low[j]));
        // Finite, so that it times 0 is 0.
        values[INVERSE_WIDTH] = pair.inverse_width.min(f32::MAX);
        values[LOW] = pair.low;
        values[HIGH] = pair.high;
        values[STEP_LOW] = jumps(before.and_then(|i| pairs.get(i)), Some(pair));
        values[STEP_HIGH] = jumps(Some(pair), behind.and_then(|i| pairs.get(i)));
        values
    };
    pairs.iter().enumerate().map(interval).collect()
}

/// The interval in which `scalar` is; on a knot the upper one if `rising`.
pub(super) fn find(intervals: &[Interval], scalar: f32, rising: bool) -> usize {
    let begins_before = |interval: &Interval| match rising {
        true => interval[LOW] <= scalar,
        false => interval[LOW] < scalar,
    };
    intervals.partition_point(begins_before).saturating_sub(1)
}

/// The values of an interval at a scalar in it: RGB and extinction.
pub(super) fn sample(interval: &Interval, scalar: f32) -> [f32; 4] {
    let share = (scalar - interval[LOW]) * interval[INVERSE_WIDTH];
    [0, 1, 2, 3].map(|i| interval[i] + interval[4 + i] * share)
}
