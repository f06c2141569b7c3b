//! One diagram as SVG, both axes logarithmic: error against time or memory, or time against a size.
//!
//! Points of one algorithm are joined in the order of its sweep. The Pareto front is a wide step
//! line behind them. Colors are classes of `style.css`, which has them for light and dark pages.

use std::fmt::Write as _;

use tetrascope::core::number;

use crate::plot::power_of_ten;

/// One setting.
pub struct Point {
    /// Time or memory, above 0.
    pub x: f64,
    /// The number on the vertical axis, such as the error, 0 at least.
    pub error: f64,
    /// The setting in few words.
    pub label: String,
}

/// An algorithm over its sweep.
pub struct Series {
    /// Chooses color and marker.
    pub algorithm: usize,
    /// The algorithm's name.
    pub name: String,
    /// In the order of the sweep.
    pub points: Vec<Point>,
}

/// A diagram.
pub struct Panel<'a> {
    /// A description, for those who do not see it.
    pub title: String,
    /// The horizontal axis's name.
    pub x_name: &'static str,
    /// log₁₀ of the axes' ends.
    pub x: (f64, f64),
    /// log₁₀ of the axes' ends.
    pub y: (f64, f64),
    /// The vertical axis's name.
    pub y_name: &'static str,
    /// Whether less of both is better, so that there is a front.
    pub has_front: bool,
    /// The lines.
    pub series: &'a [Series],
    /// The time of the ground truth.
    pub truth: Option<f64>,
    /// The truth's own error bound: what is below cannot be told from it.
    pub truth_bound: Option<f64>,
}

/// Colors and markers there are, in [`mark`] and as classes `s0` to `s6` in `style.css`.
pub const STYLES: usize = 7;

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 270.0;
/// The frame's sides in pixels: left, top, right, bottom.
const FRAME: Rectangle = Rectangle([44.0, 8.0, 386.0, 230.0]);

/// Height of a label, and the width of one of its characters in pixels: 0.58 em of 11 pixels is more
/// than the mean of fonts without serifs.
const LABEL: (f64, f64) = (12.0, 6.4);

/// Half of a marker's side, in pixels.
const MARK: f64 = 5.0;

/// Left, top, right and bottom in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rectangle([f64; 4]);

impl Rectangle {
    fn around(x: f64, y: f64, reach: f64) -> Rectangle {
        Rectangle([x - reach, y - reach, x + reach, y + reach])
    }

    fn overlaps(&self, other: &Rectangle) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a < g && e < c && b < h && f < d
    }

    fn holds(&self, other: &Rectangle) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a <= e && b <= f && g <= c && h <= d
    }
}

impl Panel<'_> {
    /// The diagram; `None` where there is no point.
    pub fn to_svg(&self) -> Option<String> {
        let marks: Vec<Mark> = self.marks();
        if marks.is_empty() {
            return None;
        }
        let [left, top, right, bottom] = FRAME.0;
        let mut svg = format!(
            "<svg class=\"diagram\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
            escaped(&self.title)
        );
        self.draw_axes(&mut svg);
        if let Some(bound) = self.truth_bound.filter(|bound| *bound > 0.0) {
            let y = self.place(1.0, bound).1.clamp(top, bottom);
            _ = write!(
                svg,
                "<rect class=\"noise\" x=\"{left}\" y=\"{y:.1}\" width=\"{}\" height=\"{:.1}\"><title>within \
                 the truth's own error bound</title></rect>",
                right - left,
                bottom - y
            );
        }
        if let Some(truth) = self.truth.filter(|x| *x > 0.0) {
            let x = self.place(truth, 1.0).0;
            if (left..=right).contains(&x) {
                _ = write!(
                    svg,
                    "<path class=\"truth\" d=\"M{x:.1} {top}V{bottom}\"><title>the ground truth</title></path>"
                );
            }
        }
        let front: Vec<&Mark> = marks.iter().filter(|mark| mark.is_front).collect();
        if self.has_front {
            _ = write!(svg, "<path class=\"front\" d=\"{}\"/>", steps(&front));
        }
        for series in self.series {
            let path: Vec<String> = self
                .visible(series)
                .map(|point| self.place(point.x, point.error))
                .map(|(x, y)| format!("{x:.1} {y:.1}"))
                .collect();
            let class = series.algorithm % STYLES;
            _ = write!(
                svg,
                "<path class=\"line s{class}\" d=\"M{}\"/>",
                path.join("L")
            );
        }
        for mark in &marks {
            _ = write!(
                svg,
                "<g class=\"mark s{}{}\" transform=\"translate({:.1} {:.1})\"><title>{}</title>{}</g>",
                mark.algorithm % STYLES,
                if mark.is_front { " best" } else { "" },
                mark.x,
                mark.y,
                escaped(&mark.title),
                self::mark(mark.algorithm)
            );
        }
        for label in labels(&marks) {
            let [x, _, _, y] = label.place.0;
            _ = write!(
                svg,
                "<text class=\"label\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>",
                y - 2.5,
                escaped(label.text)
            );
        }
        svg.push_str("</svg>");
        Some(svg)
    }

    fn visible<'s>(&self, series: &'s Series) -> impl Iterator<Item = &'s Point> {
        let points = series.points.iter();
        points.filter(|p| p.x > 0.0 && p.x.is_finite() && p.error.is_finite())
    }

    /// Where a point is in pixels; errors below the axis are on it.
    fn place(&self, x: f64, error: f64) -> (f64, f64) {
        let [left, top, right, bottom] = FRAME.0;
        let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low);
        let height = share(error.log10(), self.y).max(0.0);
        (
            left + share(x.log10(), self.x) * (right - left),
            bottom - height * (bottom - top),
        )
    }

    fn marks(&self) -> Vec<Mark> {
        let floor = self.truth_bound.unwrap_or(0.0);
        let all = || self.series.iter().flat_map(|s| self.visible(s));
        let mut marks = Vec::new();
        for series in self.series {
            for point in self.visible(series) {
                let (x, y) = self.place(point.x, point.error);
                let least = point.error.max(floor);
                // Errors within the truth's own are alike.
                let beats = |other: &Point| {
                    let error = other.error.max(floor);
                    other.x <= point.x && error <= least && (other.x < point.x || error < least)
                };
                let unit = self.x_name.rsplit(' ').next().unwrap_or_default();
                marks.push(Mark {
                    x,
                    y,
                    algorithm: series.algorithm,
                    label: point.label.clone(),
                    title: format!(
                        "{} {}: {} {:.2e}, {:.3} {unit}",
                        series.name, point.label, self.y_name, point.error, point.x
                    ),
                    is_front: self.has_front && !all().any(beats),
                });
            }
        }
        marks
    }

    fn draw_axes(&self, svg: &mut String) {
        let [left, top, right, bottom] = FRAME.0;
        let span = self.y.1 - self.y.0;
        // Every second power where there are many: room for a number is 20 pixels.
        let step = if span > 6.0 { 2 } else { 1 };
        let powers = |(low, high): (f64, f64)| low.ceil() as i32..=high.floor() as i32;
        for power in powers(self.y) {
            let y = self.place(1.0, 10f64.powi(power)).1;
            _ = write!(svg, "<path class=\"grid\" d=\"M{left} {y:.1}H{right}\"/>");
            if power.rem_euclid(step) == 0 {
                _ = write!(
                    svg,
                    "<text class=\"tick end\" x=\"{}\" y=\"{:.1}\">{}</text>",
                    left - 5.0,
                    y + 4.0,
                    power_of_ten(power.into())
                );
            }
        }
        // Steps of 1, 2 and 5 where few powers of ten are in sight.
        let steps: &[f64] = if self.x.1 - self.x.0 < 2.5 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        for power in self.x.0.floor() as i32..=self.x.1.floor() as i32 {
            for step in steps {
                let value = step * 10f64.powi(power);
                let x = self.place(value, 1.0).0;
                if !(left..=right).contains(&x) {
                    continue;
                }
                _ = write!(svg, "<path class=\"grid\" d=\"M{x:.1} {top}V{bottom}\"/>");
                let words = match *step == 1.0 {
                    true => power_of_ten(power.into()),
                    false => number::rounded(value),
                };
                _ = write!(
                    svg,
                    "<text class=\"tick middle\" x=\"{x:.1}\" y=\"{}\">{words}</text>",
                    bottom + 15.0
                );
            }
        }
        _ = write!(
            svg,
            "<text class=\"name middle\" x=\"{}\" y=\"{}\">{}</text>\
             <text class=\"name middle\" transform=\"translate(11 {}) rotate(-90)\">{}</text>",
            (left + right) / 2.0,
            HEIGHT - 8.0,
            escaped(self.x_name),
            (top + bottom) / 2.0,
            escaped(self.y_name)
        );
    }
}

/// A point as it is drawn.
struct Mark {
    x: f64,
    y: f64,
    algorithm: usize,
    label: String,
    title: String,
    is_front: bool,
}

/// A label that has found its place.
struct Label<'a> {
    place: Rectangle,
    text: &'a str,
}

/// Labels of the front, each beside its mark where it covers neither a mark nor another label; those
/// for which there is no such place are left out.
fn labels(marks: &[Mark]) -> Vec<Label<'_>> {
    let mut placed: Vec<Label> = Vec::new();
    let taken: Vec<Rectangle> = marks
        .iter()
        .map(|mark| Rectangle::around(mark.x, mark.y, MARK))
        .collect();
    for mark in marks.iter().filter(|mark| mark.is_front) {
        let (height, width) = (LABEL.0, LABEL.1 * mark.label.chars().count() as f64);
        let gap = MARK + 2.0;
        let (left, right, middle) = (mark.x - gap - width, mark.x + gap, mark.x - width / 2.0);
        let (above, below, beside) = (mark.y - gap - height, mark.y + gap, mark.y - height / 2.0);
        let corner = MARK;
        let places = [
            (right, beside),
            (left, beside),
            (mark.x + corner, mark.y - corner - height),
            (mark.x + corner, mark.y + corner),
            (mark.x - corner - width, mark.y - corner - height),
            (mark.x - corner - width, mark.y + corner),
            (middle, above),
            (middle, below),
        ];
        let found = places.into_iter().find_map(|(x, y)| {
            let place = Rectangle([x, y, x + width, y + height]);
            let is_free = FRAME.holds(&place)
                && !taken.iter().any(|other| other.overlaps(&place))
                && !placed.iter().any(|other| other.place.overlaps(&place));
            is_free.then_some(place)
        });
        placed.extend(found.map(|place| Label {
            place,
            text: &mark.label,
        }));
    }
    placed
}

/// The front as steps: what is reached with so much time or memory.
fn steps(front: &[&Mark]) -> String {
    let mut front: Vec<_> = front.iter().map(|mark| (mark.x, mark.y)).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut path = String::new();
    for (i, (x, y)) in front.iter().enumerate() {
        match i {
            0 => _ = write!(path, "M{x:.1} {}V{y:.1}", FRAME.0[1]),
            _ => _ = write!(path, "H{x:.1}V{y:.1}"),
        }
    }
    _ = write!(path, "H{}", FRAME.0[2]);
    path
}

/// The shape of an algorithm's marker around the origin.
pub fn mark(algorithm: usize) -> &'static str {
    match algorithm % STYLES {
        0 => "<circle r=\"4.2\"/>",
        1 => "<path d=\"M0-5.2L4.8 3.6H-4.8Z\"/>",
        2 => "<path d=\"M-3.8-3.8H3.8V3.8H-3.8Z\"/>",
        3 => "<path d=\"M0-5.4L5.4 0L0 5.4L-5.4 0Z\"/>",
        4 => "<path d=\"M0 5.2L4.8-3.6H-4.8Z\"/>",
        5 => "<path d=\"M0-5.2L4.9-1.6L3 4.2H-3L-4.9-1.6Z\"/>",
        _ => "<path d=\"M-1.7-5H1.7V-1.7H5V1.7H1.7V5H-1.7V1.7H-5V-1.7H-1.7Z\"/>",
    }
}

/// Text for XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(algorithm: usize, points: &[(f64, f64, &str)]) -> Series {
        Series {
            algorithm,
            name: format!("algorithm {algorithm}"),
            points: points
                .iter()
                .map(|&(x, error, label)| Point {
                    x,
                    error,
                    label: label.into(),
                })
                .collect(),
        }
    }

    fn panel(series: &[Series]) -> Panel<'_> {
        Panel {
            title: "sphere, emission".into(),
            x_name: "time per frame, ms",
            x: (0.0, 3.0),
            y: (-8.0, 0.0),
            y_name: "RMSE",
            has_front: true,
            series,
            truth: Some(300.0),
            truth_bound: Some(1e-7),
        }
    }

    #[test]
    fn lines_marks_and_reasons_are_drawn() {
        let both = [
            series(0, &[(1.0, 1e-3, "centroid"), (20.0, 1e-6, "per-<pixel>")]),
            series(4, &[(100.0, 0.5, "32")]),
        ];
        let svg = panel(&both).to_svg().expect("three points");
        for text in [
            "centroid",
            "per-&lt;pixel&gt;",
            "10⁻⁶",
            "RMSE",
            "the ground truth",
            "own error bound",
            "line s0",
            "mark s4",
            "1.00e-3, 1.000 ms",
        ] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(!svg.contains("per-<"));
    }

    #[test]
    fn few_powers_of_ten_have_steps_between() {
        let one = [series(0, &[(3.0, 1e-2, "a")])];
        let mut panel = panel(&one);
        let ticks = |panel: &Panel| {
            let svg = panel.to_svg().expect("a point");
            let is_there = |text: &&str| svg.contains(&format!(">{text}</text>"));
            ["0.5", "1", "2", "5", "10", "20", "100"]
                .iter()
                .filter(|t| is_there(t))
                .count()
        };
        panel.x = (0.0, 1.05);
        assert_eq!(ticks(&panel), 4);
        panel.x = (0.0, 3.0);
        assert_eq!(ticks(&panel), 3);
    }

    #[test]
    fn lines_follow_the_sweep() {
        let one = [series(
            0,
            &[(100.0, 1e-2, "a"), (1.0, 1e-2, "b"), (10.0, 1e-2, "c")],
        )];
        let svg = panel(&one).to_svg().expect("three points");
        // A decade is 342 / 3 = 114 pixels wide and 222 / 8 = 27.75 high.
        assert!(
            svg.contains("d=\"M272.0 63.5L44.0 63.5L158.0 63.5\""),
            "{svg}"
        );
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let both = [
            series(
                0,
                &[
                    (1.0, 1e-2, "quick"),
                    (5.0, 1e-2, "slower"),
                    (9.0, 1e-4, "good"),
                ],
            ),
            // Below the truth's bound of 1e-7 the smaller error is no gain.
            series(
                1,
                &[
                    (20.0, 5e-8, "exact"),
                    (30.0, 1e-8, "noise"),
                    (8.0, 0.5, "bad"),
                ],
            ),
        ];
        let marks = panel(&both).marks();
        let front = marks.iter().filter(|mark| mark.is_front);
        let names: Vec<&str> = front.map(|mark| mark.label.as_str()).collect();
        assert_eq!(names, ["quick", "good", "exact"]);
    }

    #[test]
    fn no_label_covers_a_mark_or_another_label() {
        // A front of 40 points, 2 to 3 pixels apart: far more than there is room for.
        let crowd: Vec<(f64, f64, String)> = (0..40)
            .map(|i| {
                let t = f64::from(i) / 40.0;
                (
                    10f64.powf(1.0 + t),
                    10f64.powf(-2.0 - 3.0 * t),
                    format!("setting {i}"),
                )
            })
            .collect();
        let points: Vec<_> = crowd.iter().map(|(x, e, l)| (*x, *e, l.as_str())).collect();
        let one = [series(0, &points)];
        let marks = panel(&one).marks();
        let labels = labels(&marks);
        assert!(labels.len() > 2 && labels.len() < 40, "{}", labels.len());
        for (i, label) in labels.iter().enumerate() {
            assert!(FRAME.holds(&label.place), "{:?}", label.place);
            let others = labels[..i].iter().map(|other| other.place);
            let marks = marks.iter().map(|m| Rectangle::around(m.x, m.y, MARK));
            for other in others.chain(marks) {
                assert!(!label.place.overlaps(&other), "{}: {other:?}", label.text);
            }
        }
    }

    #[test]
    fn what_is_exact_is_on_the_axis_and_what_is_broken_is_not_drawn() {
        let one = [series(
            0,
            &[(1.0, 0.0, "exact"), (2.0, f64::INFINITY, "broken")],
        )];
        let panel = panel(&one);
        let marks = panel.marks();
        assert_eq!(marks.len(), 1);
        assert_eq!((marks[0].y, marks[0].label.as_str()), (FRAME.0[3], "exact"));
        let none = [series(0, &[(1.0, f64::INFINITY, "broken")])];
        assert!(self::panel(&none).to_svg().is_none());
    }
}
