//! Where the frames of a series lie: a lattice, and the order of the frames in it.

use std::path::Path;

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::{Error, number};

use super::image::{Frame, Image};
use crate::source::{count, format_error_with_help};

/// Frames whose places along the normal differ by less than this share of the slices' distance are at the
/// same place; positions have up to 16 characters, so that those of equal places differ by 1e-6 mm or so.
const SAME_PLACE: f64 = 1e-2;

/// A slice may lie this share of a sample's distance beside its place in the lattice. A missing slice
/// moves one of those that are there by a third of the distance or more, and this stays far below what a
/// picture shows.
const MOST_DEVIATION: f64 = 0.1;

/// Deviations of less are those of decimal digits.
const SAID_DEVIATION: f64 = 1e-3;

/// How far directions of slices may differ, per component.
const SAME_DIRECTION: f64 = 1e-4;

/// A frame of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slice {
    pub(super) image: usize,
    pub(super) frame: usize,
}

/// Frames that make a volume.
#[derive(Debug)]
pub(super) struct Stack {
    pub(super) lattice: Lattice,
    /// The files say where frames lie.
    pub(super) is_placed: bool,
    /// Every frame: those of the first volume by place, then those of the second.
    pub(super) order: Vec<Slice>,
    /// How many volumes lie at the same places.
    pub(super) repeats: usize,
    /// The scale of all frames, if it is the same.
    pub(super) scale: Option<(f64, f64)>,
    pub(super) is_scaled_alike: bool,
}

impl Stack {
    /// The order of the frames of `images`, which are at least one.
    pub(super) fn new(
        path: &Path,
        images: &[Image],
        notes: &mut Vec<String>,
    ) -> Result<Stack, Error> {
        let refuse =
            |what: String, help: &str| format_error_with_help(path, "the slices", what, help);
        let first = &images[0];
        if let Some(other) = images.iter().find(|image| image.kind != first.kind) {
            let shown = |image: &Image| {
                let kind = &image.kind;
                let name = image.path.file_name().unwrap_or_default().to_string_lossy();
                format!(
                    "{name} has {}×{} pixels of type {:?}",
                    kind.columns, kind.rows, kind.number
                )
            };
            return Err(refuse(
                format!(
                    "images of one series differ: {}, {}",
                    shown(first),
                    shown(other)
                ),
                "move the images of one kind to a folder of their own",
            ));
        }
        let mut slices: Vec<(Slice, &Frame)> = Vec::new();
        for (i, image) in images.iter().enumerate() {
            let frames = image.frames.iter().enumerate();
            slices.extend(frames.map(|(frame, f)| (Slice { image: i, frame }, f)));
        }
        if slices.len() == 1 {
            return Err(refuse(
                "there is one slice, which is a picture; a volume has several".into(),
                "give the folder that holds all slices of the series",
            ));
        }
        let spacing = slices[0].1.spacing;
        if slices.iter().any(|(_, frame)| frame.spacing != spacing) {
            return Err(refuse(
                "the distances of pixels differ from slice to slice".into(),
                "export the series again, resampled to one resolution",
            ));
        }
        if spacing.is_none() {
            notes.push("the files do not say how far apart pixels are: 1 is taken".into());
        } else if first.is_projection {
            notes.push("distances of pixels are those on the detector".into());
        }
        let [down, across] = spacing.unwrap_or([1.0, 1.0]);
        let scale = slices[0].1.scale;
        let is_scaled_alike = slices.iter().all(|(_, frame)| frame.scale == scale);
        if !is_scaled_alike {
            notes.push("stored numbers are scaled, in each slice by its own factors".into());
        }
        let placed = Places::of(&slices);
        let is_placed = placed.is_some();
        let columns = first.kind.columns;
        let rows = first.kind.rows;
        let mut lattice = Lattice {
            dims: [columns, rows, slices.len()],
            origin: DVec3::ZERO,
            spacing: DVec3::new(across, down, 1.0),
            direction: DMat3::IDENTITY,
            interpolation: Interpolation::Linear,
        };
        let repeats = match placed {
            Some(places) => places.order(&refuse, &mut slices, &mut lattice, notes)?,
            None => {
                // Without places, what the files say of the slices' distance counts.
                slices.sort_by(|a, b| compare(a.1, b.1));
                match first.slice_distance {
                    Some(distance) => {
                        lattice.spacing.z = distance;
                        notes.push(format!(
                            "frames do not say where they lie: they are taken to be {distance} apart, in the order of the files' numbers"
                        ));
                    }
                    None => notes.push(
                        "frames do not say where they lie: 1 apart, in the order of the files' numbers".into(),
                    ),
                }
                1
            }
        };
        Ok(Stack {
            lattice,
            is_placed,
            order: slices.into_iter().map(|(slice, _)| slice).collect(),
            repeats,
            scale: scale.filter(|_| is_scaled_alike),
            is_scaled_alike,
        })
    }
}

/// By what frames at the same place are told apart.
fn compare(a: &Frame, b: &Frame) -> std::cmp::Ordering {
    let pairs = a.order.iter().zip(&b.order);
    let mut unequal = pairs.map(|(a, b)| a.total_cmp(b)).filter(|o| o.is_ne());
    unequal.next().unwrap_or(std::cmp::Ordering::Equal)
}

/// Slices that lie in parallel planes.
struct Places {
    axes: [DVec3; 2],
    normal: DVec3,
    are_parallel: bool,
}

impl Places {
    /// `None` if a frame does not say where it lies.
    fn of(slices: &[(Slice, &Frame)]) -> Option<Places> {
        if !slices.iter().all(|(_, frame)| frame.position.is_some()) {
            return None;
        }
        let [x, y] = slices[0].1.orientation?;
        let differ = |frame: &Frame| {
            frame.orientation.is_none_or(|[a, b]| {
                (a - x).abs().max_element().max((b - y).abs().max_element()) > SAME_DIRECTION
            })
        };
        Some(Places {
            axes: [x, y],
            normal: x.cross(y),
            are_parallel: !slices.iter().any(|(_, frame)| differ(frame)),
        })
    }

    /// Orders `slices` by place and completes the `lattice`; how many volumes they make.
    fn order(
        &self,
        refuse: &dyn Fn(String, &str) -> Error,
        slices: &mut [(Slice, &Frame)],
        lattice: &mut Lattice,
        notes: &mut Vec<String>,
    ) -> Result<usize, Error> {
        if !self.are_parallel {
            return Err(refuse(
                "slices are not parallel, as those of a localizer".into(),
                "give one file of the series whose slices are, or a folder with it alone",
            ));
        }
        let position = |frame: &Frame| frame.position.unwrap_or(DVec3::ZERO);
        let along = |frame: &Frame| self.normal.dot(position(frame));
        slices.sort_by(|a, b| along(a.1).total_cmp(&along(b.1)));
        let all = slices.len();
        let length = along(slices[all - 1].1) - along(slices[0].1);
        // Groups of frames at the same place: steps below a share of the mean distance do not count.
        let same = SAME_PLACE * length / all as f64;
        let mut starts = vec![0];
        for i in 1..all {
            if along(slices[i].1) - along(slices[i - 1].1) > same {
                starts.push(i);
            }
        }
        let groups = starts.len();
        let repeats = all / groups;
        if groups < 2 {
            return Err(refuse(
                format!("all {all} frames lie at the same place"),
                "a volume needs slices at two places or more",
            ));
        }
        let ends = starts[1..].iter().copied().chain([all]);
        let sizes: Vec<usize> = starts.iter().zip(ends).map(|(s, e)| e - s).collect();
        if let Some(uneven) = sizes.iter().position(|size| *size != sizes[0]) {
            return Err(refuse(
                format!(
                    "{} at the first place, and {} at place {}",
                    count(sizes[0] as u64, "frame"),
                    sizes[uneven],
                    uneven + 1
                ),
                "frames are missing, or two series are mixed: export the series again",
            ));
        }
        let step = length / (groups - 1) as f64;
        let origin = position(slices[0].1);
        self.check_lattice(refuse, slices, &starts, step, lattice.spacing, notes)?;
        for group in starts.iter().map(|start| *start..start + repeats) {
            slices[group].sort_by(|a, b| compare(a.1, b.1));
        }
        // Volume after volume.
        let by_volume: Vec<_> = (0..repeats)
            .flat_map(|k| starts.iter().map(move |start| start + k))
            .map(|i| slices[i])
            .collect();
        slices.copy_from_slice(&by_volume);
        lattice.dims[2] = groups;
        lattice.origin = origin;
        lattice.spacing.z = step;
        lattice.direction = DMat3::from_cols(self.axes[0], self.axes[1], self.normal);
        Ok(repeats)
    }

    /// Refuses slices that lie beside the lattice, which `starts` every `step`, by too much.
    fn check_lattice(
        &self,
        refuse: &dyn Fn(String, &str) -> Error,
        slices: &[(Slice, &Frame)],
        starts: &[usize],
        step: f64,
        spacing: DVec3,
        notes: &mut Vec<String>,
    ) -> Result<(), Error> {
        let position = |i: usize| slices[starts[i]].1.position.unwrap_or(DVec3::ZERO);
        let (mut along, mut beside) = (0.0f64, 0.0f64);
        for i in 0..starts.len() {
            let rest = position(i) - position(0) - self.normal * (step * i as f64);
            along = along.max(self.normal.dot(rest).abs());
            let [x, y] = self.axes.map(|axis| axis.dot(rest).abs());
            beside = beside.max(x / spacing.x).max(y / spacing.y);
        }
        let distance = |i: usize| self.normal.dot(position(i) - position(i - 1));
        if along > MOST_DEVIATION * step {
            let odd = |i: &usize| (distance(*i) - step).abs();
            let widest = (1..starts.len())
                .max_by(|a, b| odd(a).total_cmp(&odd(b)))
                .unwrap_or(1);
            let mut steps: Vec<f64> = (1..starts.len()).map(distance).collect();
            steps.sort_by(f64::total_cmp);
            return Err(refuse(
                format!(
                    "slices {widest} and {} are {} apart, and most others {}",
                    widest + 1,
                    number::rounded(distance(widest)),
                    number::rounded(steps[steps.len() / 2])
                ),
                "a slice is missing or slices are unevenly spaced; export the series again, or resample it",
            ));
        }
        if beside > MOST_DEVIATION {
            return Err(refuse(
                format!(
                    "slices are shifted by up to {beside:.2} pixels, as those of a tilted gantry"
                ),
                "resample the series to right-angled axes, for example with SimpleITK or `dcm2niix`",
            ));
        }
        let deviation = (along / step).max(beside);
        if deviation > SAID_DEVIATION {
            notes.push(format!(
                "slices lie up to {deviation:.3} of a sample's distance beside their places, and are drawn at even distances"
            ));
        }
        Ok(())
    }
}
