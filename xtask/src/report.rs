//! What `compare` found: the numbers as JSON, and one page for people.
//!
//! `report.md` describes every field of the JSON.

use std::collections::BTreeMap;

use base64::Engine as _;
use image::RgbaImage;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;
use tetrascope::Promise;
use tetrascope::core::FrameStats;
use tetrascope_testing::ImageError;

use crate::answer::Answer;
use crate::diagrams::Diagrams;
use crate::figures::Measured;
use crate::metrics::Errors;
use crate::picture::{brightest_of_boxes, mean_of_boxes, png};
use crate::sweep::{self, Section};

/// The version of the JSON's layout, which `report.md` describes: it grows when a field goes or
/// changes its meaning, and not when one is added.
pub const REPORT_VERSION: u32 = 2;

/// Everything that a run found, and everything that its numbers depend on.
#[derive(Debug, Serialize)]
pub struct Report {
    /// [`REPORT_VERSION`].
    pub version: u32,
    /// Program, version and source revision.
    pub program: Program,
    /// What it ran on.
    pub machine: Machine,
    /// Frames drawn of each row, after one that is not counted.
    pub repeat: u32,
    /// What was drawn.
    pub scenes: Vec<SceneReport>,
    /// What was demanded of the errors.
    pub checks: Vec<Check>,
}

/// The program that made a report.
#[derive(Debug, Serialize)]
pub struct Program {
    /// "tetrascope".
    pub name: &'static str,
    /// The crates' version.
    pub version: &'static str,
    /// The git revision, with "-dirty" where files were changed; `None` outside a checkout.
    pub revision: Option<String>,
    /// When the run began, UTC, as in RFC 3339.
    pub started: String,
    /// The command line.
    pub command: String,
    /// "release", or "debug" where assertions were on and times mean little.
    pub build: &'static str,
}

/// What a report was made on.
#[derive(Debug, Serialize)]
pub struct Machine {
    /// The operating system.
    pub os: &'static str,
    /// The processor's architecture.
    pub architecture: &'static str,
    /// The processor's name, where the system tells it.
    pub processor: Option<String>,
    /// Threads that run at a time.
    pub threads: usize,
    /// The graphics adapter: name, kind, backend, driver.
    pub adapter: Option<String>,
    /// Why there is no adapter.
    pub no_adapter: Option<String>,
}

/// A scene, under one or more optical models.
#[derive(Debug, Serialize)]
pub struct SceneReport {
    /// What the user calls it: a data set or a file.
    pub name: String,
    /// How many tetrahedra or voxel cells.
    pub cells: usize,
    /// Whether the mesh is convex, as far as is known.
    pub convex: Option<bool>,
    /// Read or generate, milliseconds.
    pub load_ms: f64,
    /// SHA-256 of each input file, hexadecimal, by name.
    pub sha256: BTreeMap<String, String>,
    /// What reading found and fixed.
    pub notes: Vec<String>,
    /// Under each optical model.
    pub models: Vec<ModelReport>,
}

/// A scene under one optical model.
#[derive(Debug, Serialize)]
pub struct ModelReport {
    /// The optical model's name.
    pub model: &'static str,
    /// The resolved scene as TOML; draws the very same picture.
    pub scene: String,
    /// What was chosen because the scene left it out.
    pub defaults: Vec<String>,
    /// Pixels a row and rows.
    pub size: [u32; 2],
    /// The truth's own error bound, absolute.
    pub truth_bound: Option<f64>,
    /// One an algorithm and setting.
    pub rows: Vec<Row>,
    /// Where the error of some rows comes from.
    pub sources: Vec<ErrorSource>,
}

/// A part of an algorithm's error that two of its settings tell apart.
#[derive(Debug, Serialize)]
pub struct ErrorSource {
    /// What is to blame, in words.
    pub source: &'static str,
    /// The algorithm and setting that has it.
    pub with: String,
    /// What it is compared with, which has not.
    pub against: String,
    /// The difference.
    pub error: ImageError,
}

/// One algorithm with one setting.
#[derive(Debug, Serialize)]
pub struct Row {
    /// The algorithm's name.
    pub algorithm: &'static str,
    /// What was set, "key=value,…"; empty for the defaults.
    pub setting: String,
    /// Every setting's value.
    pub settings: String,
    /// Whether these are the algorithm's defaults.
    pub is_default: bool,
    /// How near to the truth it is meant to be.
    #[serde(skip)]
    pub promise: Promise,
    /// What came out.
    pub outcome: Outcome,
}

/// What came out of a row.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// A picture.
    Drawn(Box<Drawn>),
    /// Why there is no picture.
    Skipped(String),
}

/// A picture's numbers.
#[derive(Debug, Serialize)]
pub struct Drawn {
    /// Against the truth; `None` for the truth itself.
    pub error: Option<Errors>,
    /// From volume and appearance to a renderer that can draw, milliseconds.
    pub prepare_ms: f64,
    /// The median time a frame, milliseconds.
    pub frame_ms: f64,
    /// The quickest and the slowest frame, milliseconds.
    pub frame_range_ms: [f64; 2],
    /// "gpu" where `frame_ms` is between timestamps on the device, else "wall".
    pub clock: &'static str,
    /// The median wall time a frame, readback included, milliseconds.
    pub wall_ms: f64,
    /// The last frame's own account.
    pub stats: FrameStats,
}

/// Bounds on an error, and whether both were kept.
#[derive(Debug, Serialize)]
pub struct Check {
    /// Scene, model, algorithm and setting.
    pub subject: String,
    /// The RMSE; `None` where there is no truth to compare with.
    pub rmse: Option<f64>,
    /// What it may be at most.
    pub limit: f64,
    /// The greatest error, without that of pixels that may differ by anything.
    pub max: Option<f64>,
    /// What it may be at most.
    pub max_limit: f64,
    /// Whether both are.
    pub passed: bool,
}

impl Check {
    /// Judges RMSE and greatest error.
    pub fn new(subject: String, found: (f64, f64), (limit, max_limit): (f64, f64)) -> Check {
        let (rmse, max) = found;
        Check {
            subject,
            rmse: Some(rmse),
            limit,
            max: Some(max),
            max_limit,
            passed: rmse <= limit && max <= max_limit,
        }
    }

    /// A check that cannot be made, and so fails.
    pub fn without_truth(subject: String) -> Check {
        Check {
            subject,
            rmse: None,
            limit: 0.0,
            max: None,
            max_limit: 0.0,
            passed: false,
        }
    }

    /// What was found and what is allowed, in words.
    pub fn found(&self) -> String {
        match (self.rmse, self.max) {
            (Some(rmse), Some(max)) => format!(
                "RMSE {}, at most {} allowed; greatest error {}, at most {} allowed",
                scientific(rmse),
                scientific(self.limit),
                scientific(max),
                scientific(self.max_limit)
            ),
            _ => "no ground truth to compare with".into(),
        }
    }
}

impl ModelReport {
    /// The truth's numbers, where it was drawn.
    pub fn truth(&self) -> Option<&Drawn> {
        self.rows.iter().find_map(|row| match &row.outcome {
            Outcome::Drawn(drawn) if row.promise == Promise::Truth => Some(&**drawn),
            _ => None,
        })
    }
}

/// The pictures of a page, by scene and model.
#[derive(Default)]
pub struct Pictures {
    cards: BTreeMap<(usize, usize), Vec<Card>>,
    figures: Vec<Measured>,
    machine: Option<Section>,
}

/// A picture for the page.
struct Card {
    title: String,
    caption: String,
    image: Option<RgbaImage>,
    /// A difference picture's end of scale.
    scale_end: Option<String>,
}

/// A picture on the page.
#[derive(Serialize)]
struct ShownCard<'a> {
    title: &'a str,
    caption: &'a str,
    /// A PNG file as a `data:` address.
    image: Option<String>,
    /// A difference picture's scale, "0 to 2e-5".
    scale_end: Option<&'a str>,
}

/// Bytes that all pictures of a page may take, so that it stays below 4 MB.
const PICTURE_BYTES: usize = 2_800_000;

/// The least side of a picture on the page in pixels: what is smaller shows nothing.
const LEAST_SIDE: u32 = 32;

/// What an algorithm does not draw, and why.
#[derive(Debug, PartialEq, Serialize)]
struct Skipped {
    algorithm: &'static str,
    /// Settings that are not drawn, and all.
    settings: [usize; 2],
    reasons: String,
}

/// One for each algorithm that does not draw all of its settings in `models`.
fn skipped<'a>(models: impl Iterator<Item = &'a ModelReport>) -> Vec<Skipped> {
    let mut found: Vec<(&'static str, [usize; 2], Vec<&str>)> = Vec::new();
    for row in models.flat_map(|model| &model.rows) {
        let known = found.iter().position(|one| one.0 == row.algorithm);
        let index = known.unwrap_or_else(|| {
            found.push((row.algorithm, [0, 0], Vec::new()));
            found.len() - 1
        });
        let (_, settings, reasons) = &mut found[index];
        settings[1] += 1;
        if let Outcome::Skipped(why) = &row.outcome {
            settings[0] += 1;
            if !reasons.contains(&why.as_str()) {
                reasons.push(why);
            }
        }
    }
    let found = found.into_iter().filter(|(_, settings, _)| settings[0] > 0);
    found
        .map(|(algorithm, settings, reasons)| Skipped {
            algorithm,
            settings,
            reasons: reasons.join("; "),
        })
        .collect()
}

/// What the template sees.
#[derive(Serialize)]
struct Page<'a> {
    report: &'a Report,
    /// By scene, then model.
    cards: Vec<Vec<Vec<ShownCard<'a>>>>,
    /// By scene, then model.
    skipped: Vec<Vec<Vec<Skipped>>>,
    answer: Option<Answer>,
    diagrams: Vec<Option<Diagrams>>,
    misses: Vec<[String; 2]>,
    verdict: String,
    figures: &'a [Measured],
    machine: Option<&'a Section>,
    legend_models: [&'static str; 5],
}

impl Pictures {
    /// Adds a frame to scene and model.
    pub fn add(&mut self, place: (usize, usize), title: &str, caption: &str, image: RgbaImage) {
        self.card(place, title, caption, Some(image), None);
    }

    /// Adds a difference picture and the value at the end of its color scale;
    /// `None` for images that are equal.
    pub fn add_difference(
        &mut self,
        place: (usize, usize),
        title: &str,
        caption: &str,
        map: Option<(RgbaImage, f64)>,
    ) {
        let (image, end) = map.unzip();
        self.card(place, title, caption, image, end.map(scientific));
    }

    /// Adds figures of a paper that were measured before.
    pub fn add_figures(&mut self, figures: Option<Measured>) {
        self.figures.extend(figures);
    }

    /// Adds what a sweep of the machine has found before.
    pub fn set_machine(&mut self, section: Option<Section>) {
        self.machine = section;
    }

    fn card(
        &mut self,
        place: (usize, usize),
        title: &str,
        caption: &str,
        image: Option<RgbaImage>,
        scale_end: Option<String>,
    ) {
        self.cards.entry(place).or_default().push(Card {
            title: title.into(),
            caption: caption.into(),
            image,
            scale_end,
        });
    }

    /// All pictures, made smaller where they would take more than [`PICTURE_BYTES`].
    fn shown(&self) -> BTreeMap<(usize, usize), Vec<ShownCard<'_>>> {
        let images = || {
            self.cards
                .values()
                .flatten()
                .filter_map(|c| c.image.as_ref())
        };
        let side = images()
            .map(|image| image.width().max(image.height()))
            .max();
        let mut factor = 1;
        loop {
            let shown: BTreeMap<_, Vec<ShownCard>> = self
                .cards
                .iter()
                .map(|(place, cards)| (*place, cards.iter().map(|c| c.shown(factor)).collect()))
                .collect();
            let cards = shown.values().flatten();
            let bytes: usize = cards.filter_map(|c| Some(c.image.as_ref()?.len())).sum();
            if bytes <= PICTURE_BYTES || side.unwrap_or(0) / (factor + 1) < LEAST_SIDE {
                return shown;
            }
            factor += 1;
        }
    }
}

impl Card {
    /// The picture, `factor` times smaller.
    fn shown(&self, factor: u32) -> ShownCard<'_> {
        let base64 = base64::engine::general_purpose::STANDARD;
        let is_difference = self.scale_end.is_some();
        let address = |image: &RgbaImage| {
            let small = match is_difference {
                _ if factor == 1 => image.clone(),
                true => brightest_of_boxes(image, factor),
                false => mean_of_boxes(image, factor),
            };
            format!("data:image/png;base64,{}", base64.encode(png(&small)))
        };
        ShownCard {
            title: &self.title,
            caption: &self.caption,
            image: self.image.as_ref().map(address),
            scale_end: self.scale_end.as_deref(),
        }
    }
}

impl Report {
    /// Whether every bound was kept, and checked where there is one.
    pub fn passed(&self) -> bool {
        let was_checked = !self.checks.is_empty() || !self.has_bounds();
        was_checked && self.checks.iter().all(|check| check.passed)
    }

    /// Whether some picture has a bound to keep, whatever the scene is like.
    fn has_bounds(&self) -> bool {
        let models = self.scenes.iter().flat_map(|scene| &scene.models);
        models.flat_map(|model| &model.rows).any(|row| {
            let promised = matches!(row.promise, Promise::Exact | Promise::Within(_));
            promised && matches!(row.outcome, Outcome::Drawn(_))
        })
    }

    /// The same in words.
    pub fn verdict(&self) -> String {
        let missed = self.checks.iter().filter(|check| !check.passed).count();
        match (self.checks.len(), missed) {
            (0, _) if self.has_bounds() => "nothing was checked, though there are bounds".into(),
            (0, _) => "no picture here has a bound to keep".into(),
            (all, 0) => format!("all {all} bounds kept"),
            (all, missed) => format!("{missed} of {all} bounds missed"),
        }
    }

    /// The report as JSON.
    pub fn to_json(&self) -> String {
        let mut json = serde_json::to_string_pretty(self).expect("a report is plain data");
        json.push('\n');
        json
    }

    /// The report as one HTML page that needs no other file.
    pub fn to_html(&self, pictures: &Pictures) -> String {
        let mut environment = Environment::new();
        environment.set_auto_escape_callback(|_| AutoEscape::Html);
        environment.add_filter("scientific", scientific);
        environment.add_filter("ms", milliseconds);
        sweep::add_to(&mut environment);
        environment
            .add_template("index.html", include_str!("template.html"))
            .expect("the template is valid");
        let page = environment.get_template("index.html").expect("added above");
        let mut shown = pictures.shown();
        let scenes = self.scenes.iter().enumerate();
        let cards = scenes.map(|(s, scene)| {
            let models = 0..scene.models.len();
            let of = models.map(|m| shown.remove(&(s, m)).unwrap_or_default());
            of.collect()
        });
        let cards = cards.collect();
        let not_drawn = |scene: &SceneReport| {
            let models = scene.models.iter();
            models.map(|model| skipped([model].into_iter())).collect()
        };
        let missed = self.checks.iter().filter(|check| !check.passed);
        let page_data = Page {
            report: self,
            cards,
            skipped: self.scenes.iter().map(not_drawn).collect(),
            answer: Answer::of(self),
            diagrams: self.scenes.iter().map(Diagrams::of).collect(),
            misses: missed.map(|c| [c.subject.clone(), c.found()]).collect(),
            verdict: self.verdict(),
            figures: &pictures.figures,
            machine: pictures.machine.as_ref(),
            legend_models: crate::plot::COLORS,
        };
        page.render(Serde(&page_data))
            .expect("the template fits the report")
    }

    /// The report as a table for a terminal.
    pub fn to_table(&self) -> String {
        let mut rows = vec![
            [
                "scene",
                "model",
                "algorithm",
                "setting",
                "RMSE",
                "max",
                "PSNR dB",
                "prepare ms",
                "frame ms",
                "clock",
                "resident",
            ]
            .map(String::from),
        ];
        let mut breaks = Vec::new();
        for scene in &self.scenes {
            breaks.push(rows.len());
            for model in &scene.models {
                for row in &model.rows {
                    let setting = if row.setting.is_empty() {
                        "–"
                    } else {
                        &row.setting
                    };
                    let name = [
                        scene.name.clone(),
                        model.model.into(),
                        row.algorithm.into(),
                        setting.into(),
                    ];
                    let drawn = match &row.outcome {
                        Outcome::Drawn(drawn) => drawn,
                        Outcome::Skipped(_) => continue,
                    };
                    let [rmse, max, psnr] = match drawn.error.as_ref().map(|e| e.image) {
                        Some(e) => [
                            scientific(e.rmse),
                            scientific(e.max),
                            e.psnr.map_or("∞".into(), |p| format!("{p:.1}")),
                        ],
                        None => [
                            "truth".into(),
                            format!("±{}", scientific(model.truth_bound.unwrap_or(0.0))),
                            "–".into(),
                        ],
                    };
                    let [a, b, c, d] = name;
                    rows.push([
                        a,
                        b,
                        c,
                        d,
                        rmse,
                        max,
                        psnr,
                        milliseconds(drawn.prepare_ms),
                        milliseconds(drawn.frame_ms),
                        drawn.clock.into(),
                        bytes(drawn.stats.bytes_resident),
                    ]);
                }
            }
        }
        let width = |column: usize| {
            rows.iter()
                .map(|r| r[column].chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
        let mut table = String::new();
        for (i, row) in rows.iter().enumerate() {
            if breaks.contains(&i) {
                table.push_str(&"─".repeat(widths.iter().sum::<usize>() + 2 * (widths.len() - 1)));
                table.push('\n');
            }
            let cells = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(column, (cell, &width))| {
                    // Words to the left, numbers to the right.
                    if column < 4 {
                        format!("{cell:<width$}")
                    } else {
                        format!("{cell:>width$}")
                    }
                });
            table.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
            table.push('\n');
        }
        for scene in &self.scenes {
            for model in &scene.models {
                for part in &model.sources {
                    let ErrorSource { source, with, .. } = part;
                    table.push_str(&format!(
                        "{} {}: {source}: RMSE {}, max {}: {with} against {}\n",
                        scene.name,
                        model.model,
                        scientific(part.error.rmse),
                        scientific(part.error.max),
                        part.against
                    ));
                }
            }
        }
        for scene in &self.scenes {
            for one in skipped(scene.models.iter()) {
                let [not_drawn, all] = one.settings;
                let share = match not_drawn == all {
                    true => String::new(),
                    false => format!("{not_drawn} of {all} settings "),
                };
                table.push_str(&format!(
                    "{} {}: {share}skipped: {}\n",
                    scene.name, one.algorithm, one.reasons
                ));
            }
        }
        table
    }
}

/// Three digits: "1.23e-5", "0".
pub fn scientific(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else {
        format!("{x:.2e}")
    }
}

/// Three digits: "0.123", "12.3", "1234".
pub fn milliseconds(ms: f64) -> String {
    match ms {
        ms if ms >= 100.0 => format!("{ms:.0}"),
        ms if ms >= 10.0 => format!("{ms:.1}"),
        ms if ms >= 1.0 => format!("{ms:.2}"),
        ms => format!("{ms:.3}"),
    }
}

/// In the largest binary unit below: "12.3 MiB".
pub fn bytes(bytes: u64) -> String {
    let (mut value, mut unit) = (bytes as f64, "B");
    for larger in ["KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            break;
        }
        (value, unit) = (value / 1024.0, larger);
    }
    if unit == "B" {
        format!("{bytes} B")
    } else {
        format!("{value:.1} {unit}")
    }
}

/// "148 955", with thin spaces.
pub(crate) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push('\u{2009}');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn report(name: &str) -> Report {
        let error = ImageError {
            rmse: 1.5e-4,
            max: 1e-3,
            psnr: Some(76.5),
            worst_pixel: [1, 2],
        };
        let drawn = |error| Drawn {
            error,
            prepare_ms: 12.0,
            frame_ms: 3.5,
            frame_range_ms: [3.0, 4.0],
            clock: "gpu",
            wall_ms: 5.0,
            stats: FrameStats::default(),
        };
        let row = |algorithm, setting: &str, outcome| Row {
            algorithm,
            setting: setting.into(),
            settings: "order=centroid".into(),
            is_default: true,
            promise: match algorithm {
                "reference" => Promise::Truth,
                _ => Promise::Exact,
            },
            outcome,
        };
        let rows = vec![
            row("reference", "", Outcome::Drawn(Box::new(drawn(None)))),
            row(
                "projection",
                "order=centroid",
                Outcome::Drawn(Box::new(drawn(Some(Errors::of(error))))),
            ),
            row(
                "projection",
                "order=exact",
                Outcome::Skipped("no <adapter>".into()),
            ),
        ];
        Report {
            version: REPORT_VERSION,
            program: Program {
                name: "tetrascope",
                version: "0.0.0",
                revision: None,
                started: "2026-01-01T00:00:00Z".into(),
                command: "compare".into(),
                build: "release",
            },
            machine: Machine {
                os: "linux",
                architecture: "x86_64",
                processor: None,
                threads: 2,
                adapter: None,
                no_adapter: Some("none found".into()),
            },
            repeat: 3,
            scenes: vec![SceneReport {
                name: name.into(),
                cells: 148_955,
                convex: Some(true),
                load_ms: 1.0,
                sha256: BTreeMap::new(),
                notes: vec!["a note".into()],
                models: vec![ModelReport {
                    model: "emission-absorption",
                    scene: "version = 1".into(),
                    defaults: vec![],
                    size: [4, 4],
                    truth_bound: Some(1e-12),
                    rows,
                    sources: vec![ErrorSource {
                        source: "order alone",
                        with: "projection order=centroid".into(),
                        against: "reference".into(),
                        error,
                    }],
                }],
            }],
            checks: vec![Check::new("sphere".into(), (1.5e-4, 1e-3), (1e-4, 1e-2))],
        }
    }

    #[test]
    fn the_page_holds_numbers_and_reasons_and_escapes_names() {
        let report = report("a<b>.vtu");
        let mut pictures = Pictures::default();
        let gray = RgbaImage::from_pixel(2, 2, image::Rgba([128; 4]));
        pictures.add((0, 0), "truth", "", gray.clone());
        pictures.add_difference((0, 0), "difference", "", Some((gray, 2e-5)));
        let page = report.to_html(&pictures);
        for text in [
            "1.50e-4",
            "76.5",
            "a&lt;b&gt;.vtu",
            "no &lt;adapter&gt;",
            "2.00e-5",
            "data:image/png;base64,iVBORw0KGgo",
            "projection in 1 of 1",
            "none found",
            "order alone",
        ] {
            assert!(page.contains(text), "{text}");
        }
        assert!(!page.contains("a<b>"));
        for outside in ["src=\"http", "href=\"http", "@import", "url("] {
            assert!(!page.contains(outside), "the page needs {outside}");
        }
    }

    pub(crate) fn drawn_with(rmse: f64, frame_ms: f64) -> Outcome {
        let mut report = report("");
        let Outcome::Drawn(mut drawn) = report.scenes[0].models[0].rows.swap_remove(1).outcome
        else {
            panic!("it is drawn");
        };
        drawn.frame_ms = frame_ms;
        drawn.error.as_mut().expect("compared").image.rmse = rmse;
        Outcome::Drawn(drawn)
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
        let image = RgbaImage::from_fn(256, 256, |_, _| image::Rgba([(); 4].map(|()| noise())));
        let mut pictures = Pictures::default();
        for _ in 0..60 {
            pictures.add((0, 0), "noise", "", image.clone());
        }
        let page = report("sphere").to_html(&pictures);
        assert!(page.len() < 4_000_000, "{}", page.len());
        assert_eq!(page.matches("alt=\"noise\"").count(), 60);
        // Alone it stays as it is.
        let mut one = Pictures::default();
        one.add((0, 0), "noise", "", image);
        assert!(report("sphere").to_html(&one).len() > 256 * 256 * 4);
    }

    #[test]
    fn what_is_not_drawn_takes_a_line_for_each_algorithm() {
        let mut report = report("sphere");
        let model = &mut report.scenes[0].models[0];
        for (setting, why) in [("a=1", "no grid"), ("a=2", "no grid"), ("a=3", "too large")] {
            model.rows.push(Row {
                algorithm: "slicing",
                setting: setting.into(),
                settings: setting.into(),
                is_default: false,
                promise: Promise::Open,
                outcome: Outcome::Skipped(why.into()),
            });
        }
        let table = report.to_table();
        let lines: Vec<&str> = table.lines().filter(|l| l.contains("skipped")).collect();
        assert_eq!(
            lines,
            [
                "sphere projection: 1 of 2 settings skipped: no <adapter>",
                "sphere slicing: skipped: no grid; too large"
            ]
        );
        let page = report.to_html(&Pictures::default());
        assert_eq!(page.matches("no grid; too large").count(), 1);
        assert!(!page.contains("a=2"));
    }

    #[test]
    fn the_page_shows_a_sweep_where_there_is_one() {
        let report = report("sphere");
        let mut pictures = Pictures::default();
        assert!(!report.to_html(&pictures).contains("id=\"machine\""));
        let section = Section::new(sweep::tests::small());
        let answer = section.answer()[1].clone();
        pictures.set_machine(Some(section));
        let page = report.to_html(&pictures);
        assert!(page.contains("id=\"machine\"") && page.contains(&answer));
    }

    #[test]
    fn the_table_has_a_line_a_row_and_says_what_was_skipped() {
        let table = report("sphere").to_table();
        let lines: Vec<_> = table.lines().collect();
        assert_eq!(lines.len(), 6, "{table}");
        assert!(
            lines[3].contains("1.50e-4") && lines[3].contains("gpu"),
            "{table}"
        );
        assert!(lines[4].contains("order alone: RMSE 1.50e-4"), "{table}");
        assert!(lines[5].contains("skipped: no <adapter>"), "{table}");
    }

    #[test]
    fn one_missed_bound_fails_the_report() {
        let mut report = report("sphere");
        assert!(!report.passed());
        report.checks[0].passed = true;
        assert!(report.passed());
    }

    #[test]
    fn json_has_the_numbers() {
        let json: serde_json::Value =
            serde_json::from_str(&report("sphere").to_json()).expect("valid JSON");
        assert_eq!(json["version"], REPORT_VERSION);
        let row = &json["scenes"][0]["models"][0]["rows"][1];
        let error = &row["outcome"]["drawn"]["error"];
        assert_eq!(
            (&error["rmse"], &error["worst_pixel"]),
            (&1.5e-4.into(), &[1, 2].into())
        );
        assert_eq!(error["percentiles"]["p99.9"], 9e-4);
    }

    /// Every name in `value`, but for those that are data: settings, counts and files.
    fn names(value: &serde_json::Value, into: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, field) in fields {
                    into.push(name.clone());
                    if !["counts", "sha256"].contains(&name.as_str()) {
                        names(field, into);
                    }
                }
            }
            serde_json::Value::Array(items) => items.iter().for_each(|item| names(item, into)),
            _ => {}
        }
    }

    #[test]
    fn every_field_of_the_json_is_described() {
        let json = serde_json::from_str(&report("sphere").to_json()).expect("valid JSON");
        let mut found = Vec::new();
        names(&json, &mut found);
        assert!(found.len() > 50, "{found:?}");
        let schema = include_str!("../report.md");
        for name in found {
            assert!(schema.contains(&format!("`{name}`")), "{name}");
        }
        assert!(schema.contains(&format!("version {REPORT_VERSION}")));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(bytes(1_572_864), "1.5 MiB");
        assert_eq!(bytes(12), "12 B");
        assert_eq!(thousands(148_955), "148\u{2009}955");
        assert_eq!(milliseconds(123.4), "123");
        assert_eq!(scientific(0.0), "0");
    }
}
