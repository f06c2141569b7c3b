//! Charts of a sweep as SVG.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use tetrascope::core::number;

use super::result::Weight;
use crate::plot::{FONT, GRID, INK, LogAxis, color, decades, power_of_ten};

/// Volumes per second of a machine against voxels.
pub(super) struct RateLine {
    /// Chooses color and width: the first is the widest, and lies below.
    pub(super) machine: usize,
    /// Whether the host merges: then the line is dashed, and has squares for marks.
    pub(super) is_readback: bool,
    /// Voxels along the longest axis, and volumes per second.
    pub(super) points: Vec<(usize, f64)>,
}

/// Widths of the other lines in pixels, by machine, so that lines that coincide are seen.
pub(super) const WIDTHS: [u32; 3] = [6, 4, 2];

/// The width of lines of machines whose host merges.
pub(super) const READBACK_WIDTH: u32 = 2;

/// Lines of one mesh and number of samples, both axes logarithmic; volumes per second from
/// `least_and_most` on.
pub(super) fn rates(lines: &[RateLine], least_and_most: (f64, f64), size: (u32, u32)) -> String {
    let mut sides: Vec<usize> = lines.iter().flat_map(|l| &l.points).map(|p| p.0).collect();
    sides.sort_unstable();
    sides.dedup();
    let x = Marks::at(sides.iter().map(|side| (*side as f64).log2()).collect());
    let y = decades([least_and_most.0, least_and_most.1].into_iter());
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin_top(10)
            .margin_right(14)
            .x_label_area_size(48)
            .y_label_area_size(66)
            .build_cartesian_2d(x, LogAxis(y.0, y.1))
            .expect("memory takes any chart");
        chart
            .configure_mesh()
            .x_desc("voxels along the longest axis")
            .y_desc("volumes per second")
            .axis_desc_style((FONT, 14).into_font().color(&INK))
            .label_style((FONT, 14).into_font().color(&INK))
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(0x9a, 0xa0, 0xa8))
            .x_label_formatter(&|power| format!("{}", power.exp2().round()))
            .y_label_formatter(&|power| power_of_ten(*power))
            .draw()
            .expect("memory takes any chart");
        for line in lines {
            let color = color(line.machine);
            let width = WIDTHS[line.machine % WIDTHS.len()];
            let at = |(side, rate): &(usize, f64)| ((*side as f64).log2(), rate.log10());
            let path: Vec<_> = line.points.iter().map(at).collect();
            let reach = width as i32 / 2 + 2;
            if line.is_readback {
                let marks = path.iter().map(|at| {
                    let square = [(-reach, -reach), (reach, reach)];
                    EmptyElement::at(*at) + Rectangle::new(square, color.stroke_width(2))
                });
                chart.draw_series(marks).expect("memory takes any chart");
                let style = color.stroke_width(READBACK_WIDTH);
                let dashed = DashedLineSeries::new(path, 6, 4, style);
                chart.draw_series(dashed).map(drop)
            } else {
                let marks = path
                    .iter()
                    .map(|at| Circle::new(*at, reach, color.filled()));
                chart.draw_series(marks).expect("memory takes any chart");
                let solid = LineSeries::new(path, color.stroke_width(width));
                chart.draw_series(solid).map(drop)
            }
            .expect("memory takes any chart");
        }
        area.present().expect("memory takes any chart");
    }
    svg
}

/// Height of a bar with the room around it, in pixels.
const BAR: u32 = 26;

/// Room above bars and for the axis below, in pixels.
const TOP: u32 = 6;
const FOOT: u32 = 48;

/// Room for the numbers' names, in pixels.
const NAMES: i32 = 330;

/// A bar for half and one for twice of each number, from 1 to the ratio of volumes per second, on
/// a logarithmic axis. `weights` are one at least, in the order in which they are drawn.
pub(super) fn tornado(weights: &[&Weight], width: u32) -> String {
    let ratios = weights.iter().flat_map(|weight| weight.ratios);
    let reach = ratios.map(|r| r.log2().abs()).fold(1.0, f64::max);
    let count = weights.len();
    // Room for a bar's label beyond its end.
    let ends = reach * 1.25;
    let axis = Marks {
        range: (-ends, ends),
        at: vec![-1.0, 0.0, 1.0],
    };
    let height = TOP + BAR * count as u32 + FOOT;
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin_top(TOP)
            .margin_right(14)
            .margin_left(NAMES)
            .x_label_area_size(FOOT)
            .build_cartesian_2d(axis, 0.0..count as f64)
            .expect("memory takes any chart");
        chart
            .configure_mesh()
            .disable_y_mesh()
            .x_desc("volumes per second, over those without a change")
            .axis_desc_style((FONT, 14).into_font().color(&INK))
            .label_style((FONT, 14).into_font().color(&INK))
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(0x9a, 0xa0, 0xa8))
            .x_label_formatter(&|power| number::rounded(power.exp2()))
            .draw()
            .expect("memory takes any chart");
        for (index, weight) in weights.iter().enumerate() {
            let middle = (count - index) as f64 - 0.5;
            for (which, ratio) in weight.ratios.iter().enumerate() {
                let end = ratio.log2();
                let bar = [(0.0, middle - 0.36), (end, middle + 0.36)];
                let bar = Rectangle::new(bar, color(which).filled());
                chart.draw_series([bar]).expect("memory takes any chart");
                if is_moved(*ratio) {
                    let (side, offset) = match end > 0.0 {
                        true => (HPos::Left, 5),
                        false => (HPos::Right, -5),
                    };
                    let style = (FONT, 13).into_font().color(&INK);
                    let style = style.pos(Pos::new(side, VPos::Center));
                    let text = Text::new(format!("{ratio:.2}"), (offset, 0), style);
                    let label = EmptyElement::at((end, middle)) + text;
                    chart.draw_series([label]).expect("memory takes any chart");
                }
            }
            let style = (FONT, 14).into_font().color(&INK);
            let style = style.pos(Pos::new(HPos::Right, VPos::Center));
            let words = weight.name.replace('_', " ");
            let name = format!("{words}: {} {}", weight.value, weight.unit);
            let at = (NAMES - 8, (TOP + BAR * index as u32 + BAR / 2) as i32);
            let name = Text::new(name, at, style);
            area.draw(&name).expect("memory takes any chart");
        }
        area.present().expect("memory takes any chart");
    }
    svg
}

/// Whether a ratio shows: half a percent is less than a pixel.
pub(super) fn is_moved(ratio: f64) -> bool {
    ratio.ln().abs() > 0.005
}

/// An axis with grid lines at some places alone.
struct Marks {
    range: (f64, f64),
    at: Vec<f64>,
}

impl Marks {
    /// An axis around these places, one at least, with some room beside them.
    fn at(places: Vec<f64>) -> Marks {
        let first = places.first().copied().unwrap_or(0.0);
        let last = places.last().copied().unwrap_or(0.0);
        Marks {
            range: (first - 0.2, last + 0.2),
            at: places,
        }
    }
}

impl Ranged for Marks {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        LogAxis(self.range.0, self.range.1).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.at.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Marks {
    fn format(value: &f64) -> String {
        number::rounded(value.exp2())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_their_axes_are_drawn() {
        let line = |machine, is_readback| RateLine {
            machine,
            is_readback,
            points: vec![(64, 3.0), (128, 0.4)],
        };
        let svg = rates(&[line(0, false), line(2, true)], (0.4, 3.0), (320, 240));
        for text in [
            "64",
            "128",
            "volumes per second",
            "10⁻¹",
            "#0072B2",
            "#009E73",
        ] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        // Circles for the one, squares for the other; and no label at places between.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(!svg.contains(">91<"));
    }

    #[test]
    fn bars_are_named_and_say_their_ratios() {
        let weight = |name: &str, ratios| Weight {
            name: name.into(),
            value: 50,
            unit: "MHz".into(),
            ratios,
        };
        let (clock, other) = (
            weight("clock_mhz", [0.5, 2.0]),
            weight("other", [1.0, 0.75]),
        );
        let svg = tornado(&[&clock, &other], 700);
        for text in ["clock mhz: 50 MHz", "0.50", "2.00", "0.75"] {
            assert!(svg.contains(text), "{text}");
        }
        // Its half moves nothing, and 1 is at the axis alone.
        assert!(!svg.contains("1.00"));
    }
}
