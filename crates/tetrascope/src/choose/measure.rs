//! The measurement of one setting on one view.

use std::time::{Duration, Instant};

use tetrascope_core::{Appearance, Error, Frame, View, Volume, VolumeRenderer as _};

use super::candidates::Setup;
use crate::Context;

/// The most frames that are timed.
const MOST_FRAMES: usize = 8;

/// A frame as slow as this is not drawn again: what warms up does not matter beside it.
const SLOW: Duration = Duration::from_secs(4);

/// A picture, and what it took.
pub(crate) struct Drawn {
    pub(crate) frame: Frame,
    /// From the call until the pixels are there, once all is prepared: the least of
    /// several frames, as what else the machine does only adds to it.
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
        seconds: times
            .into_iter()
            .reduce(f64::min)
            .unwrap_or(first.as_secs_f64()),
        prepare,
    })
}
