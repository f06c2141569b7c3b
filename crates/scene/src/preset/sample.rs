//! From points to knots and back.
//!
//! Between points colors and opacities are curves; knots are joined by lines, in linear light and in
//! extinction. Curves are sampled finely, and of the samples only those are kept without which the
//! lines would be off by more than can be seen.

use tetrascope_core::colormap::{linear_to_srgb, srgb_to_linear};
use tetrascope_core::glam::DVec3;
use tetrascope_core::transfer_function::MAX_OPACITY;
use tetrascope_core::{Error, Knot, TransferFunction, number};

use super::{ColorPoint, ColorSpace, OpacityPoint, Preset, opacity, wrong};

/// How far a component in sRGB or an opacity may be off: half a level of an 8-bit picture.
const TOLERANCE: f64 = 0.5 / 255.0;

/// The most samples of a stretch between two points.
const FINEST: usize = 128;

/// The least.
const COARSEST: usize = 8;

/// About how many samples all stretches have.
const SAMPLES: usize = 32_768;

/// Rounding, and what [`HAIR`] makes of a steep curve: no step.
const SAME: f64 = 1e-5;

/// A part of a stretch in which nothing changes that could be seen.
const HAIR: f64 = 1e-9;

/// A color in sRGB and an opacity over one unit distance, at a scalar.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    scalar: f64,
    color: [f64; 3],
    opacity: f64,
}

impl Sample {
    fn knot(&self, unit_distance: f64) -> Knot {
        Knot {
            scalar: self.scalar,
            color: DVec3::from_array(self.color.map(srgb_to_linear)),
            extinction: -(-self.opacity.min(MAX_OPACITY)).ln_1p() / unit_distance,
        }
    }

    /// The sample that a renderer shows at `scalar` on the line from one sample to another.
    fn on_line(from: &Sample, to: &Sample, scalar: f64) -> Sample {
        let (from, to) = (from.knot(1.0), to.knot(1.0));
        let s = (scalar * 0.5 - from.scalar * 0.5) / (to.scalar * 0.5 - from.scalar * 0.5);
        Sample {
            scalar,
            color: from.color.lerp(to.color, s).to_array().map(linear_to_srgb),
            opacity: -(-from.extinction * (1.0 - s) - to.extinction * s).exp_m1(),
        }
    }

    /// The greatest difference of a component or of the opacity.
    fn difference(&self, other: &Sample) -> f64 {
        let colors = (0..3).map(|i| (self.color[i] - other.color[i]).abs());
        // Above the greatest opacity nothing can be told apart.
        let [a, b] = [self.opacity, other.opacity].map(|o| o.min(MAX_OPACITY));
        colors.fold((a - b).abs(), f64::max)
    }
}

impl Preset {
    /// The function that renderers draw: off by at most half a level of an 8-bit picture from the
    /// colors and opacities that are meant, in as few knots as that takes.
    ///
    /// Opacities count over `unit_distance`, world units.
    ///
    /// # Errors
    /// Those of [`Preset::validate`], and a distance that is not more than 0.
    pub fn transfer_function(&self, unit_distance: f64) -> Result<TransferFunction, Error> {
        self.validate()?;
        if !(unit_distance > 0.0 && unit_distance.is_finite()) {
            return Err(wrong(
                format!("a unit distance of {}", number::exact(unit_distance)),
                "give the distance over which an opacity counts, world units, more than 0",
            ));
        }
        let places = self.places();
        let count = (SAMPLES / places.len()).clamp(COARSEST, FINEST);
        // Where stretches meet without a step, they are one.
        let mut runs: Vec<Vec<Sample>> = Vec::new();
        for ends in places.windows(2) {
            let samples = self.stretch([ends[0], ends[1]], count);
            let last = runs.last().and_then(|run| run.last());
            match last.is_some_and(|last| last.difference(&samples[0]) < SAME) {
                true => runs
                    .last_mut()
                    .expect("it has a last")
                    .extend(&samples[1..]),
                false => runs.push(samples),
            }
        }
        let mut kept: Vec<Sample> = Vec::new();
        for run in &runs {
            let off =
                |a: &Sample, b: &Sample, x: &Sample| Sample::on_line(a, b, x.scalar).difference(x);
            kept.extend(needed(run, off).into_iter().map(|index| run[index]));
        }
        if kept.is_empty() {
            // One scalar alone: constant everywhere.
            let (color, opacity) = (self.colors[0].color, self.opacities[0].opacity);
            kept.push(Sample {
                scalar: places[0],
                color,
                opacity,
            });
        }
        TransferFunction::new(kept.iter().map(|s| s.knot(unit_distance)).collect())
    }

    /// The points of `function` in sRGB and in opacities over `unit_distance`, as few as show no
    /// difference, and whether a color had to be dimmed to fit.
    pub fn of(function: &TransferFunction, unit_distance: f64) -> (Preset, bool) {
        let knots = function.knots();
        let is_dimmed = knots.iter().any(|k| k.color.max_element() > 1.0);
        let sample = |knot: &Knot| Sample {
            scalar: knot.scalar,
            color: knot.color.min(DVec3::ONE).to_array().map(linear_to_srgb),
            opacity: -(-knot.extinction * unit_distance).exp_m1(),
        };
        let mut runs: Vec<Vec<Sample>> = vec![vec![sample(&knots[0])]];
        let count = (SAMPLES / knots.len()).clamp(COARSEST, FINEST);
        for pair in knots.windows(2) {
            let (from, to) = (sample(&pair[0]), sample(&pair[1]));
            if from.scalar == to.scalar {
                runs.push(vec![to]); // a step
                continue;
            }
            let run = runs.last_mut().expect("one to begin with");
            for i in 1..count {
                let s = i as f64 / count as f64;
                let scalar = from.scalar * (1.0 - s) + to.scalar * s;
                run.push(Sample::on_line(&from, &to, scalar));
            }
            run.push(to);
        }
        let mut preset = Preset {
            name: "transfer function".into(),
            color_space: ColorSpace::Rgb,
            colors: Vec::new(),
            opacities: Vec::new(),
        };
        for run in &runs {
            let place = |a: &Sample, b: &Sample, x: &Sample| {
                (x.scalar * 0.5 - a.scalar * 0.5) / (b.scalar * 0.5 - a.scalar * 0.5)
            };
            let color = |a: &Sample, b: &Sample, x: &Sample| {
                let s = place(a, b, x);
                let off = |i: usize| (a.color[i] * (1.0 - s) + b.color[i] * s - x.color[i]).abs();
                off(0).max(off(1)).max(off(2))
            };
            let opacity = |a: &Sample, b: &Sample, x: &Sample| {
                let s = place(a, b, x);
                (a.opacity * (1.0 - s) + b.opacity * s - x.opacity).abs()
            };
            for index in needed(run, color) {
                let Sample { scalar, color, .. } = run[index];
                preset.colors.push(ColorPoint { scalar, color });
            }
            for index in needed(run, opacity) {
                let Sample {
                    scalar, opacity, ..
                } = run[index];
                preset.opacities.push(OpacityPoint::new(scalar, opacity));
            }
        }
        (preset, is_dimmed)
    }

    /// The scalars at which something begins or ends, each once, by increasing scalar.
    fn places(&self) -> Vec<f64> {
        let steps = self.opacities.windows(2).filter_map(|pair| {
            // A bend, the steepest place, or a step.
            let bends = pair[0].sharpness >= opacity::LINEAR || pair[0].midpoint != 0.5;
            let s = opacity::midpoint(&pair[0]);
            bends.then(|| pair[0].scalar * (1.0 - s) + pair[1].scalar * s)
        });
        let mut places: Vec<f64> = steps.collect();
        places.extend(self.colors.iter().map(|p| p.scalar));
        places.extend(self.opacities.iter().map(|p| p.scalar));
        places.sort_by(f64::total_cmp);
        places.dedup();
        places
    }

    /// Samples of a stretch in which nothing begins or ends, its ends as they are within it.
    fn stretch(&self, [low, high]: [f64; 2], count: usize) -> Vec<Sample> {
        let middle = low * 0.5 + high * 0.5;
        let color_after = self.colors.partition_point(|p| p.scalar <= middle);
        let opacity_after = self.opacities.partition_point(|p| p.scalar <= middle);
        let at = |i: usize| {
            let s = i as f64 / count as f64;
            let scalar = match i {
                _ if i == count => high,
                _ => low * (1.0 - s) + high * s,
            };
            // Within the stretch by a hair: a step at its end has two values there.
            let hair = s.clamp(HAIR, 1.0 - HAIR);
            let inside = low * (1.0 - hair) + high * hair;
            let within = |a: f64, b: f64| {
                let part = (inside * 0.5 - a * 0.5) / (b * 0.5 - a * 0.5);
                part.clamp(0.0, 1.0)
            };
            let color = match (color_after.checked_sub(1), self.colors.get(color_after)) {
                (Some(from), Some(to)) => {
                    let from = &self.colors[from];
                    let s = within(from.scalar, to.scalar);
                    let is_end = |p: &ColorPoint| scalar == p.scalar;
                    match self.color_space {
                        // Exactly the points' colors at the points.
                        ColorSpace::Step => to.color,
                        _ if is_end(from) => from.color,
                        _ if is_end(to) => to.color,
                        space => space.between(from.color, to.color, s),
                    }
                }
                (Some(last), None) => self.colors[last].color,
                (None, _) => self.colors[0].color,
            };
            let opacity = match (
                opacity_after.checked_sub(1),
                self.opacities.get(opacity_after),
            ) {
                (Some(from), Some(to)) => {
                    let from = &self.opacities[from];
                    match scalar {
                        x if x == from.scalar => from.opacity,
                        x if x == to.scalar => to.opacity,
                        _ => opacity::between(from, to, within(from.scalar, to.scalar)),
                    }
                }
                (Some(last), None) => self.opacities[last].opacity,
                (None, _) => self.opacities[0].opacity,
            };
            Sample {
                scalar,
                color,
                opacity,
            }
        };
        if low == high {
            return vec![at(0)];
        }
        (0..=count).map(at).collect()
    }
}

/// Which of `all` are needed, so that what is between two neighbors is off by at most
/// [`TOLERANCE`]: the first, the last, and by D. Douglas and T. Peucker's rule (1973) the worst in
/// between, again and again.
fn needed(all: &[Sample], off: impl Fn(&Sample, &Sample, &Sample) -> f64) -> Vec<usize> {
    let last = all.len() - 1;
    let mut kept = vec![0];
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let worst = (from + 1..to)
            .map(|i| (off(&all[from], &all[to], &all[i]), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match worst {
            Some((difference, i)) if difference > TOLERANCE => {
                open.push((i, to));
                open.push((from, i));
            }
            _ => kept.push(to),
        }
    }
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use tetrascope_core::colormap::Colormap;

    use super::*;

    fn preset(color_space: ColorSpace, opacities: Vec<OpacityPoint>) -> Preset {
        Preset {
            name: "p".into(),
            color_space,
            colors: vec![
                ColorPoint {
                    scalar: 0.0,
                    color: [0.231, 0.298, 0.753],
                },
                ColorPoint {
                    scalar: 10.0,
                    color: [0.706, 0.016, 0.149],
                },
            ],
            opacities,
        }
    }

    /// The sample that is meant at a scalar strictly between points.
    fn meant(preset: &Preset, scalar: f64) -> Sample {
        let between = |xs: &mut dyn Iterator<Item = f64>| xs.filter(|x| *x <= scalar).count();
        let c = between(&mut preset.colors.iter().map(|p| p.scalar));
        let o = between(&mut preset.opacities.iter().map(|p| p.scalar));
        let (a, b) = (&preset.colors[c - 1], &preset.colors[c]);
        let s = (scalar - a.scalar) / (b.scalar - a.scalar);
        let color = preset.color_space.between(a.color, b.color, s);
        let (a, b) = (&preset.opacities[o - 1], &preset.opacities[o]);
        let s = (scalar - a.scalar) / (b.scalar - a.scalar);
        Sample {
            scalar,
            color,
            opacity: opacity::between(a, b, s),
        }
    }

    #[test]
    fn knots_show_what_is_meant_to_half_a_level() {
        let bent = OpacityPoint {
            midpoint: 0.3,
            sharpness: 0.6,
            ..OpacityPoint::new(0.0, 0.1)
        };
        let corner = OpacityPoint {
            midpoint: 0.8,
            ..OpacityPoint::new(4.0, 0.9)
        };
        let ends = [OpacityPoint::new(10.0, 0.0)];
        for space in ColorSpace::ALL {
            let preset = preset(space, [[bent, corner].as_slice(), &ends].concat());
            for unit in [1e-6, 1.0, 3e5] {
                let function = preset.transfer_function(unit).expect("valid");
                assert!(function.knots().len() < 120, "{}", function.knots().len());
                for i in 0..997 {
                    let scalar = 10.0 * (f64::from(i) + 0.5) / 997.0;
                    let (color, extinction) = function.sample(scalar).expect("a number");
                    let shown = Sample {
                        scalar,
                        color: color.to_array().map(linear_to_srgb),
                        opacity: -(-extinction * unit).exp_m1(),
                    };
                    // Between samples, 128 of a stretch, curves leave their chords by as much again.
                    let off = shown.difference(&meant(&preset, scalar));
                    assert!(off < 2.0 * TOLERANCE, "{space:?} at {scalar}: {off}");
                }
            }
        }
    }

    #[test]
    fn steps_stay_steps() {
        let sudden = OpacityPoint {
            midpoint: 0.25,
            sharpness: 1.0,
            ..OpacityPoint::new(0.0, 0.0)
        };
        let two = [OpacityPoint::new(8.0, 0.5), OpacityPoint::new(8.0, 0.25)];
        let points = [[sudden].as_slice(), &two, &[OpacityPoint::new(10.0, 0.25)]].concat();
        let function = preset(ColorSpace::Rgb, points).transfer_function(1.0);
        let function = function.expect("valid");
        let opacity = |x: f64| -(-function.sample(x).expect("a number").1).exp_m1();
        for (scalar, wanted) in [
            (1.999, 0.0),
            (2.001, 0.5),
            (7.999, 0.5),
            (8.001, 0.25),
            (12.0, 0.25),
        ] {
            assert!(
                (opacity(scalar) - wanted).abs() < 1e-9,
                "{scalar}: {}",
                opacity(scalar)
            );
        }
    }

    #[test]
    fn points_of_a_function_make_it_again() {
        let map = Preset {
            name: "v".into(),
            color_space: ColorSpace::Rgb,
            colors: Preset::colors_of(Colormap::Viridis, (-1.0, 1.0)),
            opacities: vec![OpacityPoint::new(-1.0, 0.0), OpacityPoint::new(1.0, 1.0)],
        };
        let function = map.transfer_function(0.5).expect("valid");
        let (points, is_dimmed) = Preset::of(&function, 0.5);
        assert!(
            !is_dimmed && points.colors.len() < 100,
            "{}",
            points.colors.len()
        );
        // A ramp is two points, up to the opacity that counts as opaque.
        assert!(points.opacities.len() <= 3, "{:?}", points.opacities);
        let again = points.transfer_function(0.5).expect("valid");
        for i in 0..=400 {
            let scalar = f64::from(i) / 200.0 - 1.0;
            let [a, b] = [&function, &again].map(|f| f.sample(scalar).expect("a number"));
            let srgb = |color: DVec3| color.to_array().map(linear_to_srgb);
            let (ca, cb) = (srgb(a.0), srgb(b.0));
            // There and back, half a level each.
            assert!(
                (0..3).all(|i| (ca[i] - cb[i]).abs() < 3.0 * TOLERANCE),
                "{scalar}"
            );
            let opacity = |sigma: f64| -(-sigma * 0.5).exp_m1();
            assert!(
                (opacity(a.1) - opacity(b.1)).abs() < 3.0 * TOLERANCE,
                "{scalar}"
            );
        }
    }

    #[test]
    fn one_point_is_a_constant() {
        let one = Preset {
            colors: vec![ColorPoint {
                scalar: 3.0,
                color: [1.0, 0.0, 0.0],
            }],
            ..preset(ColorSpace::Lab, vec![OpacityPoint::new(3.0, 0.5)])
        };
        let function = one.transfer_function(1.0).expect("valid");
        assert_eq!(function.knots().len(), 1);
        assert_eq!(one.scaled_to((0.0, 1.0)).colors[0].scalar, 0.0);
    }

    #[test]
    fn what_is_no_function_is_refused() {
        let opacities = vec![OpacityPoint::new(0.0, 0.5)];
        let good = preset(ColorSpace::Rgb, opacities);
        assert!(good.validate().is_ok());
        let wrong = [
            Preset {
                colors: Vec::new(),
                ..good.clone()
            },
            Preset {
                opacities: vec![OpacityPoint::new(f64::NAN, 0.5)],
                ..good.clone()
            },
            Preset {
                opacities: vec![OpacityPoint::new(0.0, 1.5)],
                ..good.clone()
            },
            Preset {
                colors: good.colors.iter().rev().copied().collect(),
                ..good.clone()
            },
            Preset {
                opacities: vec![OpacityPoint::new(0.0, 0.5); 5000],
                ..good.clone()
            },
        ];
        for preset in wrong {
            assert!(preset.transfer_function(1.0).is_err());
        }
        for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(good.transfer_function(unit).is_err(), "{unit}");
        }
    }
}
