//! The features on which the time of a frame depends, in numbers.

use serde::{Deserialize, Serialize};
use tetrascope_core::{Appearance, Volume};
use tetrascope_reference::RayTrace;

/// How much work a picture is, whatever draws it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Features {
    /// Cells of the volume.
    cells: f64,
    /// Pixels of the picture.
    pixels: f64,
    /// Pixels whose rays meet a cell.
    covered: f64,
    /// Pairs of a ray and a cell that it crosses: fragments of cells that are projected, steps
    /// of rays that are cast.
    visits: f64,
    /// How often scalars pass knots of the transfer function along all rays: an exact integral
    /// ends a segment there.
    knots: f64,
}

impl Features {
    /// From the features of rays in a window of `area` pixels.
    pub(crate) fn new(
        volume: &Volume,
        [width, height]: [u32; 2],
        area: f64,
        rays: &[[f64; 3]],
    ) -> Features {
        let each = area / rays.len().max(1) as f64;
        let sum = |i: usize| each * rays.iter().map(|ray| ray[i]).sum::<f64>();
        Features {
            cells: volume.cell_count() as f64,
            pixels: f64::from(width) * f64::from(height),
            covered: sum(0),
            visits: sum(1),
            knots: sum(2),
        }
    }

    /// The features of one ray: whether it meets a cell, how many, and how many knots.
    pub(crate) fn of_ray(trace: &RayTrace, appearance: &Appearance) -> [f64; 3] {
        let knots = appearance.transfer_function.knots();
        let passed = trace.intervals.iter().map(|interval| {
            let (a, b) = (interval.scalar_in, interval.scalar_out);
            let below = |s: f64| knots.partition_point(|knot| knot.scalar < s);
            below(a).abs_diff(below(b)) as f64
        });
        let visits = trace.intervals.len() as f64;
        [visits.min(1.0), visits, passed.sum()]
    }

    /// Terms of a time.
    pub(crate) fn of_time(&self) -> [f64; 6] {
        let Features {
            cells,
            pixels,
            covered,
            visits,
            knots,
        } = *self;
        [1.0, pixels, covered, cells, visits, knots]
    }

    /// Terms of the memory that a volume takes.
    pub(crate) fn of_bytes(&self) -> [f64; 2] {
        [1.0, self.cells]
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_reference::{Reference, ReferenceOptions};

    use super::*;
    use crate::choose::sample::Sample;
    use crate::choose::tests::scene;

    #[test]
    fn what_a_sample_finds_is_near_what_all_rays_do() {
        let (volume, scene) = scene("sphere", 3000, 64);
        let options = ReferenceOptions::default();
        let reference = Reference::new(&volume, &scene.appearance, &options).expect("it draws");
        let sample = Sample::new(&reference, &volume, &scene.appearance, &scene.view);
        let found = sample.expect("it draws").features;
        let all = (0..64).flat_map(|row| (0..64).map(move |column| [column, row]));
        let all: Vec<[u32; 2]> = all.collect();
        let rays = reference
            .render_pixels(&scene.view, &all)
            .expect("it draws");
        let covered = rays
            .cell_visits
            .iter()
            .filter(|visits| **visits > 0)
            .count();
        let visits = rays.cell_visits.iter().sum::<u64>() as f64;
        assert_eq!(
            (found.pixels, found.cells),
            (4096.0, volume.cell_count() as f64)
        );
        // 512 rays in strata: shares of pixels to some 2 %, sums over rays to 5 %.
        assert!(
            (found.covered / covered as f64 - 1.0).abs() < 0.05,
            "{found:?} {covered}"
        );
        assert!((found.visits / visits - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn knots_between_two_ends_are_counted_in_both_directions() {
        let (volume, scene) = scene("sphere", 600, 8);
        let options = ReferenceOptions::default();
        let reference = Reference::new(&volume, &scene.appearance, &options).expect("it draws");
        let mut trace = reference.trace(&scene.view.ray(4, 4)).expect("a ray");
        let knots = scene.appearance.transfer_function.knots();
        let mut interval = trace.intervals[0];
        interval.scalar_in = knots[0].scalar - 1.0;
        interval.scalar_out = knots[knots.len() - 1].scalar + 1.0;
        let back = tetrascope_reference::Interval {
            scalar_in: interval.scalar_out,
            scalar_out: interval.scalar_in,
            ..interval
        };
        trace.intervals = vec![interval, back];
        let [covered, visits, passed] = Features::of_ray(&trace, &scene.appearance);
        assert_eq!(
            (covered, visits, passed),
            (1.0, 2.0, 2.0 * knots.len() as f64)
        );
    }
}
