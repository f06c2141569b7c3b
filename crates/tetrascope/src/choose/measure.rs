//! What one setting takes to draw one view.

use std::time::{Duration, Instant};

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer as _};

use super::candidates::Setup;
use crate::Context;

/// The most frames that are timed.
const MOST_FRAMES: usize = 5;

/// A frame as slow as this is not drawn again: what warms up does not matter beside it.
const SLOW: Duration = Duration::from_secs(4);

/// A picture, and what it took.
pub(crate) struct Drawn {
    pub(crate) frame: Frame,
    /// From the call until the pixels are there, once all is prepared: the median.
    pub(crate) seconds: f64,
    /// For the upload of the volume and all else that lasts.
    pub(crate) prepare: f64,
}

/// Builds a renderer, draws one frame to warm up and others, one at least, until `enough` time has
/// passed.
///
/// # Errors
/// Those of the algorithm.
pub(crate) fn draw(
    context: &Context,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
    setup: &Setup,
    enough: Duration,
) -> Result<Drawn, Error> {
    let start = Instant::now();
    let renderer = (setup.algorithm.build)(context, volume, appearance, &setup.settings)?;
    let prepare = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut frame = renderer.render(view)?;
    let first = start.elapsed();
    let mut times = Vec::new();
    let timed = Instant::now();
    while first < SLOW
        && times.len() < MOST_FRAMES
        && (times.is_empty() || timed.elapsed() < enough)
    {
        let start = Instant::now();
        frame = renderer.render(view)?;
        times.push(start.elapsed().as_secs_f64());
    }
    Ok(Drawn {
        frame,
        seconds: median(times).unwrap_or(first.as_secs_f64()),
        prepare,
    })
}

/// The middle one, of an even number the lesser.
fn median(mut times: Vec<f64>) -> Option<f64> {
    times.sort_by(f64::total_cmp);
    times.get(times.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.0));
        assert_eq!(median(vec![4.0]), Some(4.0));
        assert_eq!(median(vec![]), None);
    }
}
