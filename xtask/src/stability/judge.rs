//! The demands on a case's pictures, and whether they are met.

use std::time::{Duration, Instant};

use tetrascope::core::glam::DVec2;
use tetrascope::core::{Appearance, Error, Frame, OpticalModel, View, VolumeRenderer as _};
use tetrascope::reference::{Reference, ReferenceImage, ReferenceOptions};
use tetrascope::{Algorithm, Context, Promise, Settings};
use tetrascope_testing::exactly;

use super::case::{Case, Expected, Light, Shot};
use crate::limits::{ROUNDING, limit};
use crate::picture::{png, shown};

/// How far the ground truth may be from what is known, in parts of the greatest channel: sums over
/// some 100 cells of values known to 1e-12, or where it says that it is worse, that.
const TRUTH: f64 = 1e-9;

/// How far two pictures of an algorithm may be apart that show the same, in parts of the greatest channel:
/// both round as the limits say.
const ALIKE: f64 = 2.0 * ROUNDING.1;

/// Pixels along a side of a picture that is shown.
const LONGEST_SHOWN: u32 = 64;

/// How far from a pixel's center f32 may move its ray, pixels: 2⁻²⁴ of the distance of some hundred
/// pixels is less. It decides what a ray along an outline sees.
const MOVED: f64 = 1e-4;

/// Surfaces that are nearer to each other, in parts of the volume's diagonal, may be drawn in either order:
/// depths are sums of three products that are rounded to 2⁻²⁴ of it, and a depth buffer rounds once more.
const SURFACES_APART: f64 = 1.0 / (1 << 20) as f64;

/// The outcome of a case with one algorithm and setting.
#[derive(Clone, Debug)]
pub struct Judgment {
    /// The greatest difference from what was expected, in parts of the greatest channel.
    pub greatest: f64,
    /// The error that is allowed; `None` where nothing is promised.
    pub allowed: Option<f64>,
    /// Pixels that differ by more, as a ray beside theirs would.
    pub explained: usize,
    /// The fault, if there is one.
    pub fault: Option<String>,
    /// The first shot, if it is small enough to be shown; a PNG file.
    pub picture: Option<Vec<u8>>,
}

impl Judgment {
    /// Nothing is wrong yet.
    fn of_nothing(allowed: f64) -> Judgment {
        Judgment {
            greatest: 0.0,
            allowed: Some(allowed),
            explained: 0,
            fault: None,
            picture: None,
        }
    }
}

/// A picture as a PNG file, unless it is too long to be looked at.
fn picture(frame: &Frame) -> Option<Vec<u8>> {
    (frame.width.max(frame.height) <= LONGEST_SHOWN).then(|| png(&shown(frame)))
}

/// The outcome of a case with a setting.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It was drawn.
    Drawn(Judgment),
    /// The algorithm says that it does not draw this, and why.
    NotDrawn(String),
}

/// The ground truth of one shot.
pub(super) struct Truth {
    renderer: Reference,
    appearance: Appearance,
    /// Diagonal of the volume.
    diagonal: f64,
    image: ReferenceImage,
    /// The greatest channel anywhere in the picture; 1 of a black one.
    scale: f64,
    /// The pixels that others are measured by: those that are known, or else the picture's.
    pixels: Vec<[f64; 4]>,
    /// The error that each of these may have.
    wrong_by: Vec<f64>,
    /// The time of the picture.
    pub time: Duration,
}

impl Truth {
    /// Draws it, and finds out what is known.
    pub(super) fn of(shot: &Shot, expected: &Expected) -> Result<Truth, Error> {
        let options = ReferenceOptions::default();
        let renderer = Reference::new(&shot.volume, &shot.appearance, &options)?;
        let start = Instant::now();
        let image = renderer.render_exact(&shot.view)?;
        let time = start.elapsed();
        let channels = image.pixels.iter().flatten();
        let scale = channels.fold(0.0, |greatest: f64, channel| greatest.max(channel.abs()));
        let (pixels, wrong_by) = match expected {
            Expected::Light(light) => {
                let known = (0..image.pixels.len()).map(|pixel| known(light, &shot.view, pixel));
                (known.collect(), vec![0.0; image.pixels.len()])
            }
            _ => (image.pixels.clone(), image.error_bound.clone()),
        };
        Ok(Truth {
            renderer,
            appearance: shot.appearance.clone(),
            diagonal: shot.volume.bounds().diagonal(),
            image,
            pixels,
            wrong_by,
            scale: if scale == 0.0 { 1.0 } else { scale },
            time,
        })
    }

    /// Cells that its rays crossed.
    pub(super) fn visits(&self) -> u64 {
        self.image.cell_visits
    }

    /// Whether a ray within [`MOVED`] of a pixel's center has this color, or the pixel shows a surface that
    /// is so near behind another that f32 does not tell which is in front.
    fn explains(&self, view: &View, pixel: usize, got: [f64; 4], within: f64) -> bool {
        self.moved_rays_explain(view, pixel, got, within)
            || self.surfaces_explain(view, pixel, got, within)
    }

    fn surfaces_explain(&self, view: &View, pixel: usize, got: [f64; 4], within: f64) -> bool {
        let appearance = &self.appearance;
        if appearance.optical_model != OpticalModel::Isosurfaces {
            return false;
        }
        let (column, row) = place(pixel, view);
        let ray = view.ray(column, row);
        let traced = |renderer: &Reference| renderer.trace(&ray).ok();
        let first = traced(&self.renderer).map_or(f64::INFINITY, |trace| trace.surface_depth);
        let near = SURFACES_APART * self.diagonal;
        appearance.isosurfaces.iter().any(|surface| {
            let mut renderer = self.renderer.clone();
            let alone = Appearance {
                isosurfaces: vec![*surface],
                ..appearance.clone()
            };
            let trace = match renderer.restyle(&alone) {
                Ok(()) => traced(&renderer),
                Err(_) => None,
            };
            trace.is_some_and(|trace| {
                trace.surface_depth - first <= near
                    && greatest_difference(&trace.pixel, &got) <= within
            })
        })
    }

    fn moved_rays_explain(&self, view: &View, pixel: usize, got: [f64; 4], within: f64) -> bool {
        let (column, row) = place(pixel, view);
        let size = DVec2::new(view.width.into(), view.height.into());
        let background = view.premultiplied_background();
        (0..16).any(|i| {
            let angle = f64::from(i) / 16.0 * std::f64::consts::TAU;
            let place =
                DVec2::new(column.into(), row.into()) + 0.5 + MOVED * DVec2::from_angle(angle);
            let at = 2.0 * place / size - 1.0;
            let ray = view.camera.ray(at.x, -at.y, size.x / size.y);
            self.renderer.trace(&ray).is_ok_and(|trace| {
                let behind = 1.0 - trace.pixel[3];
                let want: [f64; 4] =
                    std::array::from_fn(|c| trace.pixel[c] + behind * background[c]);
                greatest_difference(&want, &got) <= within
            })
        })
    }
}

/// Pictures in f64, each with what its channels may be wrong by.
struct Picture {
    pixels: Vec<[f64; 4]>,
    wrong_by: Vec<f64>,
}

/// The ground truth's own case: what it says beside what is known, and its own bounds.
pub(super) fn judge_truth(case: &Case, truths: &[Truth]) -> Judgment {
    let pictures: Vec<Picture> = (case.shots.iter().zip(truths))
        .map(|(shot, truth)| Picture {
            pixels: shot.in_order(&truth.image.pixels),
            wrong_by: shot.in_order(&truth.image.error_bound),
        })
        .collect();
    let scale = truths.iter().fold(0.0, |s: f64, t| s.max(t.scale));
    let mut judgment = Judgment::of_nothing(TRUTH);
    judgment.picture = truths
        .first()
        .and_then(|truth| picture(&truth.image.to_frame()));
    for picture in &pictures {
        let mut numbers = picture.pixels.iter().flatten().chain(&picture.wrong_by);
        if !numbers.all(|number| number.is_finite()) {
            judgment.fault = Some("a pixel or its bound is not finite".into());
        }
    }
    for (pixel, difference, wrong_by) in differences(case, &pictures) {
        let relative = difference / scale;
        judgment.greatest = judgment.greatest.max(relative);
        let may = (TRUTH * scale).max(2.0 * wrong_by);
        // A ray along the outline belongs to both sides: rounding decides.
        if difference.is_nan() || difference > may {
            let first = &case.shots[0];
            let is_on_outline = matches!(case.expected, Expected::Same)
                && pictures
                    .iter()
                    .all(|p| truths[0].explains(&first.view, pixel, p.pixels[pixel], may));
            match is_on_outline {
                true => judgment.explained += 1,
                false => {
                    judgment.fault.get_or_insert(format!(
                        "pixel {:?} is {relative:.1e} from what is known, its bound {:.1e}",
                        place(pixel, &first.view),
                        wrong_by / scale
                    ));
                }
            }
        }
    }
    judgment
}

fn known(light: &Light, view: &View, pixel: usize) -> [f64; 4] {
    let (column, row) = place(pixel, view);
    light(&view.ray(column, row))
}

/// For each pixel, its distance from what is known in all, and the sum of its pictures'
/// possible errors.
fn differences(case: &Case, pictures: &[Picture]) -> Vec<(usize, f64, f64)> {
    let first = &pictures[0];
    let mut all = Vec::new();
    for pixel in 0..first.pixels.len() {
        let of_all = || pictures.iter().map(|picture| picture.wrong_by[pixel]);
        match &case.expected {
            Expected::Truth => (),
            Expected::Light(light) => {
                let known = known(light, &case.shots[0].view, pixel);
                let difference = greatest_difference(&known, &first.pixels[pixel]);
                all.push((pixel, difference, first.wrong_by[pixel]));
            }
            Expected::Same => all.extend(pictures[1..].iter().map(|other| {
                let difference = greatest_difference(&first.pixels[pixel], &other.pixels[pixel]);
                (
                    pixel,
                    difference,
                    first.wrong_by[pixel] + other.wrong_by[pixel],
                )
            })),
            Expected::Law(residual, gain) => {
                let of_pixel: Vec<[f64; 4]> = pictures.iter().map(|p| p.pixels[pixel]).collect();
                let difference = greatest_difference(&residual(&of_pixel), &[0.0; 4]);
                all.push((pixel, difference, gain * of_all().fold(0.0, f64::max)));
            }
        }
    }
    all
}

/// Draws all of a case with one setting, and says how wrong that is.
pub(super) fn judge(
    case: &Case,
    truths: &[Truth],
    (algorithm, setting): (&'static Algorithm, &str),
    context: &Context,
) -> Outcome {
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    let promise = (algorithm.promise)(&settings);
    let mut judgment = Judgment::of_nothing(0.0);
    let mut first: Option<Vec<[f64; 4]>> = None;
    for (shot, truth) in case.shots.iter().zip(truths) {
        let drawn = (algorithm.supports)(&shot.volume, &shot.appearance, &shot.view, &settings)
            .and_then(|()| {
                (algorithm.build)(context, &shot.volume, &shot.appearance, &settings)?
                    .render(&shot.view)
            });
        let frame = match drawn {
            Ok(frame) => frame,
            Err(error @ Error::Unsupported { .. }) => return Outcome::NotDrawn(error.to_string()),
            Err(error) => {
                judgment.fault = Some(format!("it fails: {error}"));
                return Outcome::Drawn(judgment);
            }
        };
        judge_shot(&mut judgment, case, shot, truth, &frame, promise);
        if judgment.picture.is_none() {
            judgment.picture = picture(&frame);
        }
        if case.is_invariant {
            let pixels = shot.in_order(&exactly(&frame));
            match &first {
                Some(first) => judge_alike(&mut judgment, shot, truth, (first, &pixels)),
                None => first = Some(pixels),
            }
        }
    }
    Outcome::Drawn(judgment)
}

/// An algorithm's picture beside its first one.
fn judge_alike(
    judgment: &mut Judgment,
    shot: &Shot,
    truth: &Truth,
    (first, other): (&[[f64; 4]], &[[f64; 4]]),
) {
    for (pixel, (a, b)) in first.iter().zip(other).enumerate() {
        let relative = greatest_difference(a, b) / truth.scale;
        // A pixel that a ray beside its own explains is explained in either.
        if relative > ALIKE && !truth.explains(&shot.view, pixel, *b, ALIKE * truth.scale) {
            judgment.fault.get_or_insert(format!(
                "pixel {:?} is {relative:.1e} from its own in the first picture: {a:?}, then {b:?}",
                place(pixel, &shot.view)
            ));
        }
    }
}

/// One picture beside the ground truth's.
///
/// Knowledge from elsewhere bounds the ground truth, and so this one: it needs no look at several
/// pictures.
fn judge_shot(
    judgment: &mut Judgment,
    case: &Case,
    shot: &Shot,
    truth: &Truth,
    frame: &Frame,
    promise: Promise,
) {
    let model = shot.appearance.optical_model;
    let promise = if case.holds_for_all {
        Promise::Exact
    } else {
        promise
    };
    let bound = limit(promise, model, frame.stats.order_proven, None);
    // What the case cannot ask of f32, and what the frame itself says.
    let more = case.allowed.map_or(0.0, |(more, _)| more) + frame.stats.error_bound.unwrap_or(0.0);
    let bound = bound.map(|(_, greatest)| greatest + more);
    judgment.allowed = match (judgment.allowed, bound) {
        (Some(a), Some(b)) => Some(a.max(b)),
        _ => None,
    };
    let pixels = exactly(frame);
    for (pixel, (got, want)) in pixels.iter().zip(&truth.pixels).enumerate() {
        let at = || place(pixel, &shot.view);
        if got.iter().any(|c| !c.is_finite()) {
            judgment
                .fault
                .get_or_insert(format!("pixel {:?} is {got:?}", at()));
            continue;
        }
        if let Some(fault) = impossible(*got, &shot.appearance, &shot.view) {
            judgment
                .fault
                .get_or_insert(format!("pixel {:?} {fault}", at()));
        }
        let difference = greatest_difference(want, got);
        let relative = difference / truth.scale;
        let Some(bound) = bound else {
            judgment.greatest = judgment.greatest.max(relative);
            continue;
        };
        let may = bound * truth.scale + truth.wrong_by[pixel];
        if difference <= may {
            judgment.greatest = judgment.greatest.max(relative);
        } else if truth.explains(&shot.view, pixel, *got, may) {
            judgment.explained += 1;
        } else {
            judgment.greatest = judgment.greatest.max(relative);
            judgment.fault.get_or_insert(format!(
                "pixel {:?} is {relative:.1e} from the truth, {bound:.1e} is allowed: {want:?}, drawn {got:?}",
                at()
            ));
        }
    }
}

/// The reason for which no picture shows such a pixel, whatever is drawn: an opacity outside of
/// [0, 1], or negative light.
fn impossible(pixel: [f64; 4], appearance: &Appearance, view: &View) -> Option<String> {
    // Rounding of sums, as in the limits.
    let slack = ROUNDING.1;
    let has_opacity = appearance.optical_model != OpticalModel::Emission;
    let over_nothing = view.background[3] == 0.0;
    if has_opacity && !(-slack..=1.0 + slack).contains(&pixel[3]) {
        return Some(format!("has an opacity of {}", pixel[3]));
    }
    let least = pixel.into_iter().fold(f64::INFINITY, f64::min);
    (over_nothing && least < -slack).then(|| format!("has a channel of {least}"))
}

fn greatest_difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let apart = |c: usize| tetrascope_testing::apart(a[c], b[c]);
    (0..4).map(apart).fold(0.0, f64::max)
}

fn place(pixel: usize, view: &View) -> (u32, u32) {
    (pixel as u32 % view.width, pixel as u32 / view.width)
}

#[cfg(test)]
mod tests {
    use tetrascope::core::FrameStats;

    use super::*;
    use crate::stability::case::Group;
    use crate::stability::scenes::{Pieces, plain, waves, whole};

    fn case() -> Case {
        let volume = Pieces::cube(2, 0.2, waves).volume();
        let view = whole(&volume);
        Case::new(Group::Stiff, "a cube", Shot::new(volume, plain(), view))
    }

    /// The judgment of the true picture of [`case`] after this change.
    fn judged(promise: Promise, change: impl Fn(&mut Frame)) -> Judgment {
        let case = case();
        let shot = &case.shots[0];
        let truth = Truth::of(shot, &case.expected).expect("it draws all");
        let pixels = truth
            .pixels
            .iter()
            .map(|pixel| pixel.map(|c| c as f32))
            .collect();
        let size = (shot.view.width, shot.view.height);
        let mut frame = Frame::new(size, pixels, FrameStats::default());
        change(&mut frame);
        let mut judgment = Judgment::of_nothing(0.0);
        judge_shot(&mut judgment, &case, shot, &truth, &frame, promise);
        judgment
    }

    /// A pixel in the middle, where a ray beside it sees the same.
    fn middle(frame: &mut Frame) -> &mut [f32; 4] {
        let place = (frame.height / 2 * frame.width + frame.width / 2) as usize;
        &mut frame.pixels[place]
    }

    #[test]
    fn the_truth_is_well() {
        let judgment = judged(Promise::Exact, |_| ());
        assert_eq!((judgment.fault, judgment.explained), (None, 0));
    }

    #[test]
    fn a_wrong_channel_is_a_fault_where_something_is_promised() {
        for channel in 0..4 {
            let change = |frame: &mut Frame| middle(frame)[channel] -= 1e-2;
            assert!(judged(Promise::Exact, change).fault.is_some());
            assert!(judged(Promise::Within(2e-2), change).fault.is_none());
            let open = judged(Promise::Open, change);
            assert!(open.fault.is_none() && open.allowed.is_none() && open.greatest > 5e-3);
        }
    }

    #[test]
    fn what_cannot_be_is_a_fault_whatever_is_promised() {
        for wrong in [f32::NAN, f32::INFINITY, -0.1] {
            let judgment = judged(Promise::Open, |frame| middle(frame)[1] = wrong);
            assert!(judgment.fault.is_some(), "{wrong}");
        }
        assert!(
            judged(Promise::Open, |frame| middle(frame)[3] = 1.1)
                .fault
                .is_some()
        );
    }

    #[test]
    fn pictures_that_shall_be_alike_are_held_to_each_other() {
        let case = case();
        let truth = Truth::of(&case.shots[0], &case.expected).expect("it draws all");
        let judged = |change: f64| {
            let mut other = truth.pixels.clone();
            other[300][2] += change;
            let mut judgment = Judgment::of_nothing(0.0);
            let pictures = (truth.pixels.as_slice(), other.as_slice());
            judge_alike(&mut judgment, &case.shots[0], &truth, pictures);
            judgment.fault
        };
        assert_eq!(judged(1e-5), None);
        assert!(judged(1e-2).is_some());
    }

    #[test]
    fn a_frame_may_say_how_wrong_it_is() {
        let judgment = judged(Promise::Exact, |frame| {
            middle(frame)[0] -= 1e-2;
            frame.stats.error_bound = Some(2e-2);
        });
        assert_eq!(judgment.fault, None);
    }

    #[test]
    fn the_truth_is_held_to_what_is_known() {
        let shots = || vec![case().shots.remove(0), case().shots.remove(0)];
        let judged = |case: Case| {
            let draw = |shot| Truth::of(shot, &case.expected).expect("it draws all");
            let truths: Vec<Truth> = case.shots.iter().map(draw).collect();
            judge_truth(&case, &truths)
        };
        let same = |shots| judged(Case::same(Group::Laws, "the same", shots));
        assert!(same(shots()).fault.is_none());
        let mut others = shots();
        others[1].mirrored = true;
        assert!(same(others).fault.is_some());
        let law = |residual| judged(Case::law("a law", shots(), residual, 1.0));
        assert!(
            law(|p| std::array::from_fn(|c| p[0][c] - p[1][c]))
                .fault
                .is_none()
        );
        assert!(law(|p| p[0]).fault.is_some());
        let shot = case().shots.remove(0);
        assert!(
            judged(Case::known(Group::Stiff, "black", shot, |_| [0.0; 4]))
                .fault
                .is_some()
        );
    }
}
