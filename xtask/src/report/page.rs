//! The report as one page that needs no other file.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::numbers::{milliseconds, scientific};
use super::pictures::{self, Pictures, ShownPicture};
use super::scaling::{self, ScalingSection};
use super::skipped::{Skipped, skipped};
use super::{ModelReport, Outcome, Report};
use crate::answer::Answer;
use crate::diagrams::Diagrams;
use crate::figures::Measured;
use crate::metrics::{BINS, FIRST_DECADE};
use crate::page::html;
use crate::sweep::{self, Section};

/// The parts of a page besides its report and pictures, measured before.
#[derive(Default)]
pub struct Extras {
    /// Figures of papers.
    pub figures: Vec<Measured>,
    /// The findings of a sweep of the machine.
    pub machine: Option<Section>,
}

/// The data of the template.
#[derive(Serialize)]
struct Page<'a> {
    report: &'a Report,
    /// By scene, then model.
    models: Vec<Vec<ShownModel<'a>>>,
    answer: Option<Answer>,
    diagrams: Vec<Option<Diagrams>>,
    scaling: Option<ScalingSection<'a>>,
    misses: Vec<[String; 2]>,
    verdict: String,
    figures: &'a [Measured],
    machine: Option<&'a Section>,
    legend_models: [&'static str; 5],
    script: &'static str,
}

/// The parts of a scene's model besides its numbers.
#[derive(Serialize)]
struct ShownModel<'a> {
    pictures: Vec<ShownPicture<'a>>,
    /// A histogram for each of `pictures`, as SVG; empty for the truth's.
    histograms: Vec<String>,
    skipped: Vec<Skipped>,
}

impl Report {
    /// The report as one HTML page that needs no other file.
    pub fn to_html(&self, pictures: &Pictures, extras: &Extras) -> String {
        let mut shown = pictures::shown(pictures);
        let scenes = self.scenes.iter().enumerate();
        let models = scenes.map(|(s, scene)| {
            let models = scene.models.iter().enumerate();
            models
                .map(|(m, model)| show(model, (s, m), &mut shown))
                .collect()
        });
        let models = models.collect();
        let missed = self.checks.iter().filter(|check| !check.passed);
        let page_data = Page {
            report: self,
            models,
            answer: Answer::of(self),
            diagrams: self.scenes.iter().map(Diagrams::of).collect(),
            scaling: scaling::section(&self.scaling),
            misses: missed.map(|c| [c.subject.clone(), c.found()]).collect(),
            verdict: self.verdict(),
            figures: &extras.figures,
            machine: extras.machine.as_ref(),
            legend_models: crate::plot::COLORS,
            script: include_str!("viewer.js"),
        };
        html(include_str!("page.html"), &page_data, |environment| {
            environment.add_filter("scientific", scientific);
            environment.add_filter("ms", milliseconds);
            sweep::add_to(environment);
        })
    }
}

fn show<'a>(
    model: &ModelReport,
    place: (usize, usize),
    shown: &mut BTreeMap<(usize, usize), Vec<ShownPicture<'a>>>,
) -> ShownModel<'a> {
    let pictures = shown.remove(&place).unwrap_or_default();
    let histograms = pictures.iter().map(|picture| {
        let row = model.rows.iter().find(|row| picture.is_of(row));
        match row.map(|row| &row.outcome) {
            Some(Outcome::Drawn(drawn)) => drawn.error.as_ref().map(|e| histogram(&e.histogram)),
            _ => None,
        }
        .unwrap_or_default()
    });
    ShownModel {
        histograms: histograms.collect(),
        pictures,
        skipped: skipped([model].into_iter()),
    }
}

/// A histogram of errors as SVG: pixels that are equal on the left, then half decades.
fn histogram(counts: &[u64; BINS]) -> String {
    // Counts go over decades as errors do: the height is a root, so that few pixels show.
    let all: u64 = counts.iter().sum();
    let height = |count: u64| 40.0 * (count as f64 / all.max(1) as f64).powf(0.25);
    let mut svg = String::from(
        "<svg class=\"diagram histogram\" viewBox=\"0 0 200 56\" role=\"img\" aria-label=\"histogram of errors\">\
         <path class=\"grid\" d=\"M0 42.5H200\"/>",
    );
    for (bin, &count) in counts.iter().enumerate() {
        if count == 0 {
            continue;
        }
        let left = if bin == 0 {
            0.0
        } else {
            12.0 + 8.5 * (bin - 1) as f64
        };
        let (top, name) = (42.0 - height(count), name(bin));
        let is_equal = if bin == 0 { " equal" } else { "" };
        _ = write!(
            svg,
            "<rect class=\"bar{is_equal}\" x=\"{left}\" y=\"{top:.1}\" width=\"8\" height=\"{:.1}\"><title>{count} \
             pixels: {name}</title></rect>",
            height(count)
        );
    }
    for (bin, text) in [
        (0, "0"),
        (1, "≤10⁻¹⁰"),
        (9, "10⁻⁶"),
        (15, "10⁻³"),
        (21, "1"),
    ] {
        let left = if bin == 0 {
            0.0
        } else {
            12.0 + 8.5 * (bin - 1) as f64
        };
        _ = write!(
            svg,
            "<text class=\"tick\" x=\"{left}\" y=\"54\">{text}</text>"
        );
    }
    svg + "</svg>"
}

/// The errors in a bin, in words.
fn name(bin: usize) -> String {
    let half_decade = |i: usize| 10f64.powf(f64::from(FIRST_DECADE) + i as f64 / 2.0);
    match bin {
        0 => "no difference".into(),
        1 => format!("below {}", scientific(half_decade(1))),
        bin if bin == BINS - 1 => "1 and more".into(),
        bin => {
            let [from, to] = [bin - 1, bin].map(|i| scientific(half_decade(i)));
            format!("{from} to {to}")
        }
    }
}

#[cfg(test)]
mod tests {
    use image::{Rgba, RgbaImage};

    use super::super::tests::{report, with_settings_that_draw_nothing};
    use super::super::{Difference, Picture};
    use super::*;
    use crate::picture::SignedMap;

    fn picture(algorithm: &str, image: RgbaImage, difference: Option<Difference>) -> Picture {
        Picture {
            algorithm: algorithm.into(),
            setting: if difference.is_some() {
                "order=centroid"
            } else {
                ""
            }
            .into(),
            image,
            difference,
        }
    }

    fn page(report: &Report, pictures: Vec<Picture>) -> String {
        let pictures = Pictures::from([((0, 0), pictures)]);
        report.to_html(&pictures, &Extras::default())
    }

    #[test]
    fn the_page_holds_numbers_and_reasons_and_escapes_names() {
        let gray = RgbaImage::from_pixel(4, 4, Rgba([128; 4]));
        let difference = Difference {
            map: Some(SignedMap {
                image: gray.clone(),
                end: 2e-5,
                beyond: 3,
            }),
            worst_pixel: [1, 2],
        };
        let page = page(
            &report("a<b>.vtu"),
            vec![
                picture("reference", gray.clone(), None),
                picture("projection", gray, Some(difference)),
            ],
        );
        for text in [
            "1.50e-4",
            "76.5",
            "a&lt;b&gt;.vtu",
            "no &lt;adapter&gt;",
            "−2.00e-5",
            "3 pixels beyond",
            "worst pixel, at 1, 2",
            "7 pixels: ",
            "data:image/png;base64,iVBORw0KGgo",
            "projection in 1 of 1",
            "none found",
            "order alone",
            "class=\"viewer\"",
        ] {
            assert!(page.contains(text), "{text}");
        }
        assert!(!page.contains("a<b>"));
        for outside in ["src=\"http", "href=\"http", "@import", "url("] {
            assert!(!page.contains(outside), "the page needs {outside}");
        }
    }

    /// 60 pictures of noise, which no PNG makes smaller: 256² pixels of 4 bytes each are 15.7 MB.
    #[test]
    fn many_pictures_are_made_small_enough() {
        let mut state = 1u32;
        let mut noise = || {
            // Numerical Recipes' generator; its low bits repeat.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let image = RgbaImage::from_fn(256, 256, |_, _| Rgba([(); 4].map(|()| noise())));
        let many = || picture("noise", image.clone(), None);
        let all = page(&report("sphere"), (0..60).map(|_| many()).collect());
        assert!(all.len() < 4_000_000, "{}", all.len());
        assert_eq!(all.matches("alt=\"noise, ").count(), 60);
        // Alone it stays as it is.
        assert!(page(&report("sphere"), vec![many()]).len() > 256 * 256 * 4);
    }

    #[test]
    fn what_is_not_drawn_takes_a_line_for_each_algorithm() {
        let page = page(&with_settings_that_draw_nothing(), Vec::new());
        assert_eq!(page.matches("no grid; too large").count(), 1);
        assert!(!page.contains("a=2"));
    }

    #[test]
    fn the_page_says_of_which_files_and_runs_it_is() {
        let mut report = report("sphere");
        report.resumed = 2;
        let sha256 = &mut report.scenes[0].sha256;
        sha256.insert("a<b>.vtu".into(), "ba7816bf".into());
        let page = page(&report, Vec::new());
        assert!(page.contains("ba7816bf  a&lt;b&gt;.vtu") && page.contains("2 scenes and models"));
    }

    #[test]
    fn the_page_shows_a_sweep_where_there_is_one() {
        let report = report("sphere");
        let of = |extras: Extras| report.to_html(&Pictures::new(), &extras);
        assert!(!of(Extras::default()).contains("id=\"machine\""));
        let section = Section::new(sweep::tests::small());
        let answer = section.answer()[1].clone();
        let page = of(Extras {
            machine: Some(section),
            ..Extras::default()
        });
        assert!(page.contains("id=\"machine\"") && page.contains(&answer));
    }

    #[test]
    fn histograms_show_one_pixel_of_many() {
        let mut counts = [0; BINS];
        (counts[0], counts[9]) = (65_535, 1);
        let svg = histogram(&counts);
        assert_eq!(svg.matches("<rect").count(), 2);
        assert!(svg.contains("1 pixels: 1.00e-6 to 3.16e-6"), "{svg}");
        // The fourth root of 2⁻¹⁶ is 1/16 of 40.
        assert!(svg.contains("height=\"2.5\""), "{svg}");
    }
}
