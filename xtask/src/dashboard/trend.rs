//! The times of one benchmark over the runs, with their intervals, as a small SVG.

use std::fmt::Write as _;

use super::history::Estimate;
use super::page::{escaped, milliseconds};

/// One run's estimate.
pub struct Point<'a> {
    /// The revision, or when it was measured.
    pub label: String,
    /// Median and interval.
    pub estimate: &'a Estimate,
}

const WIDTH: f64 = 260.0;
const HEIGHT: f64 = 44.0;
/// Room for marks at the edges, in pixels.
const ROOM: f64 = 6.0;

/// The trend, oldest run left: times are logarithmic, and the axis has a doubling at least, so that
/// noise looks small. `None` without a point.
pub fn svg(points: &[Point<'_>], class: usize) -> Option<String> {
    let ends = points
        .iter()
        .flat_map(|p| [p.estimate.low, p.estimate.high]);
    let ends = ends.map(f64::log2);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if points.is_empty() {
        return None;
    }
    let room = ((1.0 - (high - low)) / 2.0).max(0.0);
    let (low, high) = (low - room, high + room);
    let x = |index: usize| match points.len() {
        1 => WIDTH / 2.0,
        n => ROOM + (WIDTH - 2.0 * ROOM) * index as f64 / (n - 1) as f64,
    };
    let y = |time: f64| HEIGHT - ROOM - (HEIGHT - 2.0 * ROOM) * (time.log2() - low) / (high - low);
    let mut svg = format!(
        "<svg class=\"trend s{class}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
         aria-label=\"{} runs, the last took {}\">",
        points.len(),
        milliseconds(points[points.len() - 1].estimate.median)
    );
    let path: Vec<String> = points
        .iter()
        .enumerate()
        .map(|(i, p)| format!("{:.1} {:.1}", x(i), y(p.estimate.median)))
        .collect();
    _ = write!(svg, "<path class=\"line\" d=\"M{}\"/>", path.join("L"));
    for (i, point) in points.iter().enumerate() {
        let e = point.estimate;
        _ = write!(
            svg,
            "<g><title>{}: {} ({} to {})</title><path class=\"interval\" d=\"M{4:.1} {5:.1}V{6:.1}\"/>\
             <circle cx=\"{4:.1}\" cy=\"{7:.1}\" r=\"2.6\"/></g>",
            escaped(&point.label),
            milliseconds(e.median),
            milliseconds(e.low),
            milliseconds(e.high),
            x(i),
            y(e.low),
            y(e.high),
            y(e.median),
        );
    }
    svg.push_str("</svg>");
    Some(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(median: f64, low: f64, high: f64) -> Estimate {
        Estimate {
            median,
            low,
            high,
            confidence: 0.95,
            measured: String::new(),
        }
    }

    #[test]
    fn points_and_intervals_are_in_their_places() {
        let estimates = [estimate(2e6, 1e6, 4e6), estimate(1e6, 1e6, 1e6)];
        let points = estimates.each_ref().map(|estimate| Point {
            label: "a<b".into(),
            estimate,
        });
        let svg = svg(&points, 1).expect("two points");
        // Two doublings over 32 pixels: from 1 ms at the bottom, 38, to 4 ms at the top, 6.
        assert!(svg.contains("d=\"M6.0 22.0L254.0 38.0\""), "{svg}");
        assert!(svg.contains("d=\"M6.0 38.0V6.0\""), "{svg}");
        assert!(
            svg.contains("a&lt;b: 2.00 ms (1.00 ms to 4.00 ms)"),
            "{svg}"
        );
        assert!(!svg.contains("NaN"));
        assert!(super::svg(&[], 0).is_none());
    }

    #[test]
    fn one_point_is_in_the_middle() {
        let one = estimate(1e6, 1e6, 1e6);
        let point = Point {
            label: String::new(),
            estimate: &one,
        };
        let svg = svg(&[point], 0).expect("a point");
        assert!(svg.contains("cx=\"130.0\" cy=\"22.0\""), "{svg}");
    }
}
