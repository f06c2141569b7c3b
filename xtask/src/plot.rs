//! Frames a second against subdivision as SVG, and what charts share: logarithmic axes, colors and
//! words.

use plotters::coord::ranged1d::{KeyPointHint, Ranged};
use plotters::prelude::*;

use crate::figures::Line;

/// Colors of lines, told apart by every reader (M. Okabe, K. Ito, 2008).
pub const COLORS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#b35a8f", "#8a6d00"];

/// Dash patterns of lines, (dash, gap) in pixels.
const DASHES: [(u32, u32); 5] = [(1, 0), (8, 4), (2, 4), (12, 3), (5, 2)];

/// The color of words.
pub(crate) const INK: RGBColor = RGBColor(0x44, 0x4a, 0x52);

/// The color of lines behind the data; `style.css` has others for dark pages in place of both.
pub(crate) const GRID: RGBColor = RGBColor(0xd9, 0xdc, 0xe0);

/// The font of words.
pub(crate) const FONT: &str = "system-ui, sans-serif";

/// Frames a second, logarithmic, against boxes per axis, as an SVG of `size` pixels.
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
    fn axes_span_whole_decades() {
        assert_eq!(decades([2e-5, 3e-3].into_iter()), (-5.0, -2.0));
        // Two at least, and room for a marker at an end.
        assert_eq!(decades([20.0].into_iter()), (1.0, 3.0));
        assert_eq!(decades([1.0, 500.0].into_iter()), (-1.0, 3.0));
    }

    #[test]
    fn powers_are_short() {
        let words = [-12.0, 0.0, 2.0, 4.0].map(power_of_ten);
        assert_eq!(words, ["10⁻¹²", "1", "100", "10⁴"]);
    }
}
