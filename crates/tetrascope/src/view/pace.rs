//! The resolution at which frames come fast enough.

use std::time::Duration;

/// A frame while a hand moves: 20 in a second.
pub const BUDGET: Duration = Duration::from_millis(50);

/// The part of the budget that is aimed at, as frames differ.
const AIM: f64 = 0.8;

/// Pixels of the first frame, of which nothing is known.
const FIRST: f64 = 160.0 * 120.0;

/// Fewer pixels show nothing.
const FEWEST: f64 = 48.0 * 48.0;

/// Finds out how many pixels can be drawn in a budget, from what the last frames took.
///
/// Time is taken to grow with pixels, which it does once there are enough of them; where it does
/// not, each frame comes nearer all the same. What a page takes to get and show a frame counts by
/// itself: drawing and sending overlap.
#[derive(Clone, Debug)]
pub struct Pace {
    budget: f64,
    drawn: f64,
    sent: f64,
}

impl Default for Pace {
    fn default() -> Pace {
        Pace::new(BUDGET)
    }
}

impl Pace {
    /// For frames that take this long.
    pub fn new(budget: Duration) -> Pace {
        Pace {
            budget: budget.as_secs_f64(),
            drawn: FIRST,
            sent: f64::INFINITY,
        }
    }

    /// The size of the next frame, which is shown at `full`: the same shape, or all of it.
    pub fn size(&self, full: [u32; 2]) -> [u32; 2] {
        let [width, height] = full.map(f64::from);
        let pixels = self.drawn.min(self.sent).max(FEWEST);
        let scale = (pixels / (width * height)).sqrt();
        // Nearly all of it is worth the rest.
        if scale > 0.9 {
            return full;
        }
        [width, height].map(|side| (side * scale).round().max(1.0) as u32)
    }

    /// Says what drawing a frame took, until it could be sent.
    pub fn drew(&mut self, size: [u32; 2], took: Duration) {
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        self.drawn = self.next(pixels, took);
    }

    /// Says how long a frame was on its way to the screen.
    pub fn delivered(&mut self, size: [u32; 2], took: Duration) {
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let next = self.next(pixels, took);
        // A link limits only where it is the bottleneck.
        self.sent = match took.as_secs_f64() < AIM * self.budget {
            true if self.sent > 4.0 * pixels => f64::INFINITY,
            true => next.max(self.sent),
            false => next,
        };
    }

    fn next(&self, pixels: f64, took: Duration) -> f64 {
        let share = AIM * self.budget / took.as_secs_f64().max(1e-6);
        // One frame that took long for another reason does not spoil the next.
        (pixels * share.clamp(0.4, 1.6)).clamp(FEWEST, 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws frames on a machine that takes so long: seconds in all, and per pixel.
    fn run(pace: &mut Pace, full: [u32; 2], fixed: f64, per_pixel: f64) -> Vec<f64> {
        let frame = |_| {
            let size = pace.size(full);
            let seconds = fixed + per_pixel * f64::from(size[0]) * f64::from(size[1]);
            pace.drew(size, Duration::from_secs_f64(seconds));
            seconds
        };
        (0..20).map(frame).collect()
    }

    #[test]
    fn frames_keep_the_budget_on_every_machine() {
        let full = [1200, 900];
        for (fixed, per_pixel) in [(0.0, 4e-7), (0.01, 1e-6), (0.002, 1e-5), (0.03, 3e-6)] {
            let mut pace = Pace::default();
            let times = run(&mut pace, full, fixed, per_pixel);
            // The aim is a fixed point of the rule, approached by at least a factor of 1.6 each
            // frame or, with much fixed time f of the aim a, by the part f/a of what is left.
            let last = &times[12..];
            assert!(last.iter().all(|t| *t < 0.05), "{times:?}");
            let is_coarsest = pace.drawn <= FEWEST;
            assert!(is_coarsest || last[7] > 0.03, "{times:?}");
        }
    }

    #[test]
    fn a_fast_machine_draws_all_pixels_and_a_slow_one_the_fewest() {
        let mut pace = Pace::default();
        run(&mut pace, [640, 480], 0.001, 1e-8);
        assert_eq!(pace.size([640, 480]), [640, 480]);
        run(&mut pace, [640, 480], 1.0, 0.0);
        let [width, height] = pace.size([640, 480]);
        assert!(width * height <= 2400 && width > height, "{width}x{height}");
        assert_eq!(pace.size([8, 8]), [8, 8]);
    }

    #[test]
    fn a_slow_link_limits_and_a_fast_one_does_not() {
        let mut pace = Pace::default();
        let full = [1000, 1000];
        run(&mut pace, full, 0.0, 1e-8);
        for _ in 0..20 {
            let size = pace.size(full);
            let pixels = f64::from(size[0]) * f64::from(size[1]);
            pace.delivered(size, Duration::from_secs_f64(0.01 + 1e-6 * pixels));
        }
        let [width, height] = pace.size(full);
        assert!(width * height < 40_000, "{width}x{height}");
        for _ in 0..20 {
            let size = pace.size(full);
            pace.delivered(size, Duration::from_millis(2));
        }
        assert_eq!(pace.size(full), full);
    }
}
