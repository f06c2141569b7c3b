//! Charts as SVG: the work-precision diagram, error against time, both logarithmic; and
//! frames a second against subdivision.

use plotters::coord::ranged1d::{KeyPointHint, Ranged};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::figures::Line;

/// One algorithm under one optical model, over the sweep of its quality setting.
pub struct Series {
    /// Chooses the marker.
    pub algorithm: usize,
    /// Chooses color and line style.
    pub model: usize,
    /// (milliseconds a frame, RMSE, label); points without error are not drawn.
    pub points: Vec<(f64, f64, String)>,
}

/// Colors of the optical models, told apart by every reader (M. Okabe, K. Ito, 2008).
pub const COLORS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#b35a8f", "#8a6d00"];

/// Dash patterns of the optical models, (dash, gap) in pixels.
const DASHES: [(u32, u32); 5] = [(1, 0), (8, 4), (2, 4), (12, 3), (5, 2)];

/// Names of the algorithms' markers, for the legend.
pub const MARKERS: [&str; 4] = ["●", "▲", "✕", "■"];

/// The color of words.
pub(crate) const INK: RGBColor = RGBColor(0x44, 0x4a, 0x52);

/// The color of lines behind the data; `style.css` has others for dark pages in place of both.
pub(crate) const GRID: RGBColor = RGBColor(0xd9, 0xdc, 0xe0);

/// The font of words.
pub(crate) const FONT: &str = "system-ui, sans-serif";

/// About how large a label is, as shares of the chart's width and height.
const LABEL: (f64, f64) = (0.28, 0.045);

/// An SVG of `size` pixels; `truth_ms` marks how long the ground truth took.
///
/// `None` where no point has both a time and an error above 0.
pub fn error_against_time(
    series: &[Series],
    truth_ms: Option<f64>,
    size: (u32, u32),
) -> Option<String> {
    let drawable = |&(ms, rmse, _): &&(f64, f64, String)| {
        *ms > 0.0 && *rmse > 0.0 && ms.is_finite() && rmse.is_finite()
    };
    let points = || series.iter().flat_map(|s| s.points.iter()).filter(drawable);
    points().next()?;
    let x = decades(points().map(|p| p.0).chain(truth_ms));
    let y = decades(points().map(|p| p.1));

    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin_top(14)
            .margin_right(18)
            .x_label_area_size(50)
            .y_label_area_size(72)
            .build_cartesian_2d(LogAxis(x.0, x.1), LogAxis(y.0, y.1))
            .expect("memory takes any chart");
        chart
            .configure_mesh()
            .x_desc("time a frame, ms")
            .y_desc("RMSE")
            .axis_desc_style((FONT, 16).into_font().color(&INK))
            .label_style((FONT, 15).into_font().color(&INK))
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(0x9a, 0xa0, 0xa8))
            .x_label_formatter(&|power| power_of_ten(*power))
            .y_label_formatter(&|power| power_of_ten(*power))
            .draw()
            .expect("memory takes any chart");

        if let Some(ms) = truth_ms.filter(|ms| *ms > 0.0) {
            let ends = [(ms.log10(), y.0), (ms.log10(), y.1)];
            let line = DashedLineSeries::new(ends, 3, 3, INK.stroke_width(1));
            chart.draw_series(line).expect("memory takes any chart");
            // Beside the line's foot, where no error is that small.
            let style = (FONT, 14).into_font().color(&INK);
            let text = Text::new("truth", (6, -20), style);
            let label = EmptyElement::at((ms.log10(), y.0)) + text;
            chart.draw_series([label]).expect("memory takes any chart");
        }
        let mut labeled: Vec<(f64, f64)> = Vec::new();
        for one in series {
            let color = color(one.model);
            let points: Vec<_> = one.points.iter().filter(drawable).collect();
            let path: Vec<_> = points.iter().map(|p| (p.0.log10(), p.1.log10())).collect();
            let (dash, gap) = DASHES[one.model % DASHES.len()];
            let style = color.stroke_width(2);
            if gap == 0 {
                chart
                    .draw_series(LineSeries::new(path.clone(), style))
                    .map(drop)
            } else {
                let line = DashedLineSeries::new(path.clone(), dash, gap, style);
                chart.draw_series(line).map(drop)
            }
            .expect("memory takes any chart");
            for (at, (_, _, label)) in path.into_iter().zip(points) {
                let mut place = ((at.0 - x.0) / (x.1 - x.0), (at.1 - y.0) / (y.1 - y.0));
                // Beside its point, on the side where there is room.
                let on_left = place.0 > 1.0 - LABEL.0;
                let (side, offset) = match on_left {
                    true => (HPos::Right, -9),
                    false => (HPos::Left, 9),
                };
                if on_left {
                    place.0 -= LABEL.0;
                }
                // A label over another could not be read; the table has them all.
                let is_free = labeled.iter().all(|other| {
                    (place.0 - other.0).abs() > LABEL.0 || (place.1 - other.1).abs() > LABEL.1
                });
                let label = if is_free {
                    label.clone()
                } else {
                    String::new()
                };
                if is_free {
                    labeled.push(place);
                }
                let font = (FONT, 14).into_font().color(&INK);
                let text = Text::new(label, (offset, -5), font.pos(Pos::new(side, VPos::Top)));
                let filled = color.filled();
                match one.algorithm % MARKERS.len() {
                    0 => chart
                        .draw_series([EmptyElement::at(at) + Circle::new((0, 0), 5, filled) + text])
                        .map(drop),
                    1 => chart
                        .draw_series([EmptyElement::at(at)
                            + TriangleMarker::new((0, 0), 6, filled)
                            + text])
                        .map(drop),
                    2 => chart
                        .draw_series([EmptyElement::at(at) + Cross::new((0, 0), 5, style) + text])
                        .map(drop),
                    _ => chart
                        .draw_series([EmptyElement::at(at)
                            + Rectangle::new([(-4, -4), (4, 4)], filled)
                            + text])
                        .map(drop),
                }
                .expect("memory takes any chart");
            }
        }
        area.present().expect("memory takes any chart");
    }
    Some(svg)
}

/// Frames a second, logarithmic, against boxes an axis, as an SVG of `size` pixels.
pub fn rate_against_boxes(lines: &[Line], size: (u32, u32)) -> String {
    let points = || lines.iter().flat_map(|line| line.points.iter());
    let most = points().map(|p| f64::from(p.0).log2()).fold(1.0, f64::max);
    let y = decades(points().map(|p| p.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin_top(14)
            .margin_right(18)
            .x_label_area_size(50)
            .y_label_area_size(72)
            .build_cartesian_2d(-0.2..most + 0.2, LogAxis(y.0, y.1))
            .expect("memory takes any chart");
        chart
            .configure_mesh()
            .x_desc("boxes an axis")
            .y_desc("frames a second")
            .axis_desc_style((FONT, 16).into_font().color(&INK))
            .label_style((FONT, 15).into_font().color(&INK))
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(0x9a, 0xa0, 0xa8))
            .x_label_formatter(&|power| format!("{}", power.exp2().round()))
            .y_label_formatter(&|power| power_of_ten(*power))
            .draw()
            .expect("memory takes any chart");
        for line in lines {
            let style = color(line.volume).stroke_width(2);
            let path: Vec<_> = line
                .points
                .iter()
                .map(|(boxes, rate)| (f64::from(*boxes).log2(), rate.log10()))
                .collect();
            let marks = path.iter().map(|at| Circle::new(*at, 4, style.filled()));
            chart.draw_series(marks).expect("memory takes any chart");
            match DASHES[line.look % DASHES.len()] {
                (_, 0) => chart.draw_series(LineSeries::new(path, style)).map(drop),
                (dash, gap) => {
                    let dashed = DashedLineSeries::new(path, dash, gap, style);
                    chart.draw_series(dashed).map(drop)
                }
            }
            .expect("memory takes any chart");
        }
        area.present().expect("memory takes any chart");
    }
    svg
}

/// One of [`COLORS`].
pub(crate) fn color(model: usize) -> RGBColor {
    let hex = COLORS[model % COLORS.len()];
    let byte = |at| u8::from_str_radix(&hex[at..at + 2], 16).expect("the table is hexadecimal");
    RGBColor(byte(1), byte(3), byte(5))
}

/// log₁₀ of the range of `values` > 0, widened to whole decades, two at least.
pub(crate) fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logs: Vec<f64> = values.map(f64::log10).collect();
    let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
    let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A tenth of a decade keeps markers off the frame.
    let (low, high) = ((low - 0.1).floor(), (high + 0.1).ceil());
    if high - low < 2.0 {
        (low, low + 2.0)
    } else {
        (low, high)
    }
}

/// A power of ten in few characters: "100", "10⁻³".
pub(crate) fn power_of_ten(power: f64) -> String {
    match power.round() as i32 {
        0 => "1".into(),
        1 => "10".into(),
        2 => "100".into(),
        3 => "1000".into(),
        p => {
            let digits = p.to_string();
            let raised = digits.chars().map(|c| match c {
                '-' => '⁻',
                digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹']
                    [digit as usize - '0' as usize],
            });
            format!("10{}", raised.collect::<String>())
        }
    }
}

/// An axis of log₁₀ with one line a decade.
pub(crate) struct LogAxis(pub(crate) f64, pub(crate) f64);

impl Ranged for LogAxis {
    type FormatOption = plotters::coord::ranged1d::NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let x = (value - self.0) / (self.1 - self.0);
        limit.0 + (x * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        (self.0.ceil() as i32..=self.1.floor() as i32)
            .map(f64::from)
            .collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.0..self.1
    }
}

impl plotters::coord::ranged1d::ValueFormatter<f64> for LogAxis {
    fn format(value: &f64) -> String {
        power_of_ten(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_labels_are_drawn() {
        let series = Series {
            algorithm: 1,
            model: 1,
            points: vec![
                (1.0, 1e-3, "centroid".into()),
                (20.0, 1e-6, "per-pixel".into()),
            ],
        };
        let svg = error_against_time(&[series], Some(300.0), (480, 320)).expect("two points");
        for text in ["centroid", "per-pixel", "10⁻⁶", "RMSE", "truth"] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn no_label_covers_another() {
        let series = Series {
            algorithm: 1,
            model: 1,
            points: vec![
                (1.0, 1.0e-3, "first".into()),
                (1.1, 1.1e-3, "second".into()),
                (900.0, 1e-3, "third".into()),
            ],
        };
        let svg = error_against_time(&[series], None, (480, 320)).expect("three points");
        assert!(svg.contains("first") && svg.contains("third"));
        assert!(!svg.contains("second"));
    }

    #[test]
    fn nothing_to_draw_is_no_chart() {
        let exact = Series {
            algorithm: 0,
            model: 0,
            points: vec![(1.0, 0.0, "exact".into())],
        };
        assert!(error_against_time(&[exact], None, (480, 320)).is_none());
    }
}
