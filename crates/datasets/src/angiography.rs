//! Arteries in a head, as computed tomography with a contrast agent shows them: a grid of
//! 16-bit samples like that of Rezk Salama and Kolb (2005, §7), 512 × 512 × 96.
//!
//! Four arteries enter from below and branch until they are thin. Around them is soft
//! tissue with noise, and around that a skull; outside there is air. Tissue lies below a
//! third of the range, bone below a half, arteries above both: the paper's two transfer
//! functions hide the lower third, or the lower half.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Samples;
use tetrascope_core::{CameraFit, Error, Grid};

use crate::random::{Random, mix};
use crate::{Dataset, Look, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "angiography",
    about: "a regular grid: arteries in a head, as computed tomography shows them; mm",
    paper: "Rezk Salama, Kolb 2005, section 7 (size and kinds of tissue; the arteries are grown)",
    default_cells: 2_500_000,
    max_cells: MOST as u64 / 2,
    seeded: true,
    make: Make::Grid(make),
    cells: None,
    look,
};

/// Cells along z for each along x and y, so that the paper's own share of resolution is kept in part:
/// slices are farther apart than pixels.
const FLATNESS: f64 = 0.375;

fn make(cells: u64, seed: u64) -> Result<Grid, Error> {
    let along_x = (cells as f64 / FLATNESS).cbrt();
    let samples = |cells: f64| cells.round().max(1.0) as usize + 1;
    let (x, z) = (samples(along_x), samples(FLATNESS * along_x));
    angiography([x, x, z], seed)
}

/// Arteries over a haze of bone.
fn look() -> Look {
    let bone = [0.9, 0.87, 0.8];
    Look {
        fit: CameraFit::MinusY,
        knots: vec![
            knot(1450.0, bone, 0.0),
            knot(1650.0, bone, 0.004),
            knot(2000.0, bone, 0.0),
            knot(2300.0, [0.8, 0.05, 0.02], 0.05),
            knot(4000.0, [1.0, 0.55, 0.2], 0.25),
        ],
    }
}

/// The greatest sample: 12 bits, as scanners have them.
pub const ANGIOGRAPHY_RANGE: u16 = 4095;

/// The box around the samples, millimeters.
const SIZE: DVec3 = DVec3::new(230.0, 230.0, 120.0);

/// The head: an ellipsoid around the middle, millimeters along each half-axis.
const HEAD: DVec3 = DVec3::new(95.0, 110.0, 85.0);

/// The skull begins at this share of the head's half-axes.
const SKULL: f64 = 0.93;

/// The most samples that are made.
const MOST: usize = 1 << 30;

/// A straight piece of an artery, millimeters.
struct Vessel {
    from: DVec3,
    to: DVec3,
    radius: f64,
    /// The sample in its middle.
    bright: f64,
}

/// The grid with these dims, the same for every size but for its resolution.
///
/// The same arguments give the same samples. [`Error::Invalid`] for less than 2 samples an
/// axis or more than 2³⁰ in all.
pub fn angiography(dims: [usize; 3], seed: u64) -> Result<Grid, Error> {
    let count = dims.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    let Some(count) = count.filter(|n| dims.iter().all(|d| *d >= 2) && *n <= MOST) else {
        return Err(Error::Invalid {
            what: format!("an angiography of {dims:?} samples"),
            help: Some(format!("ask for 2 or more an axis, {MOST} at most in all")),
        });
    };
    let spacing = SIZE / DVec3::from_array(dims.map(|d| (d - 1) as f64));
    let mut samples = Vec::with_capacity(count);
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let place = DVec3::from_array([x, y, z].map(|i| i as f64)) * spacing;
                samples.push(tissue(place, seed ^ mix(samples.len() as u64)));
            }
        }
    }
    for vessel in vessels(seed) {
        draw(&vessel, dims, spacing, &mut samples);
    }
    let samples = Samples::U16(samples);
    Grid::new(dims, DVec3::ZERO, spacing, DMat3::IDENTITY, samples)
}

/// Air, tissue or bone, with noise that follows from `noise`.
fn tissue(place: DVec3, noise: u64) -> u16 {
    let out = ((place - SIZE / 2.0) / HEAD).length();
    let noise = (mix(noise) % 121) as u16;
    match out {
        o if o > 1.0 => noise / 4,
        o if o > SKULL => 1560 + 3 * noise,
        _ => 940 + 2 * noise,
    }
}

/// All pieces of all arteries.
fn vessels(seed: u64) -> Vec<Vessel> {
    let mut random = Random(seed);
    let mut grown = Vec::new();
    // The carotid and the vertebral arteries: where they enter, and how thick they are.
    let mut ends: Vec<(DVec3, DVec3, f64)> = [
        (-28.0, -12.0, 3.0),
        (28.0, -12.0, 3.0),
        (-10.0, 25.0, 2.2),
        (10.0, 25.0, 2.2),
    ]
    .map(|(x, y, radius)| {
        let entry = SIZE / 2.0 + DVec3::new(x, y, -SIZE.z / 2.0);
        (entry, DVec3::Z, radius)
    })
    .to_vec();
    while let Some((mut place, mut toward, radius)) = ends.pop() {
        let length = 10.0 + 5.0 * radius + 4.0 * random.signed();
        let mut gone = 0.0;
        while gone < length {
            let turn = DVec3::new(random.signed(), random.signed(), random.signed());
            toward = (toward + 0.35 * turn).normalize_or(DVec3::Z);
            let middle = place - SIZE / 2.0;
            if (middle / HEAD).length() > 0.85 {
                // Along the skull, not through it.
                let out = (middle / (HEAD * HEAD)).normalize_or(DVec3::Z);
                let inward = toward - 1.2 * toward.dot(out).max(0.0) * out;
                toward = inward.normalize_or(DVec3::Z);
            }
            let next = place + 2.0 * toward;
            grown.push(Vessel {
                from: place,
                to: next,
                radius,
                // Thin ones hold less of the contrast agent.
                bright: 2300.0 + 1700.0 * (radius / 3.0).min(1.0),
            });
            (place, gone) = (next, gone + 2.0);
        }
        // Murray's law: the cube of a radius is shared by its branches.
        let share = 0.5 + 0.2 * random.signed();
        for share in [share, 1.0 - share] {
            let thin = radius * share.cbrt();
            if thin > 0.45 {
                let aside = DVec3::new(random.signed(), random.signed(), random.signed());
                ends.push((place, (toward + 0.8 * aside).normalize_or(DVec3::Z), thin));
            }
        }
    }
    grown
}

/// Raises the samples in a vessel, and in part those about a sample's distance around it.
fn draw(vessel: &Vessel, dims: [usize; 3], spacing: DVec3, samples: &mut [u16]) {
    let blur = 0.5 * spacing.max_element();
    let reach = DVec3::splat(vessel.radius + blur);
    let low = (vessel.from.min(vessel.to) - reach) / spacing;
    let high = (vessel.from.max(vessel.to) + reach) / spacing;
    // The casts saturate: below 0 is 0.
    let range = |axis: usize| {
        let end = (high[axis].floor() as usize + 1).min(dims[axis]);
        (low[axis].ceil().max(0.0) as usize).min(end)..end
    };
    let along = vessel.to - vessel.from;
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let place = DVec3::from_array([x, y, z].map(|i| i as f64)) * spacing;
                let t = (place - vessel.from).dot(along) / along.length_squared();
                let distance = place.distance(vessel.from + t.clamp(0.0, 1.0) * along);
                let inside = ((vessel.radius + blur - distance) / (2.0 * blur)).clamp(0.0, 1.0);
                let sample = &mut samples[x + dims[0] * (y + dims[1] * z)];
                let mixed = f64::from(*sample) * (1.0 - inside) + vessel.bright * inside;
                *sample = (*sample).max(mixed as u16).min(ANGIOGRAPHY_RANGE);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(grid: &Grid) -> &[u16] {
        match grid.samples() {
            Samples::U16(samples) => samples,
            other => panic!("{:?}", other.sample_type()),
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_arteries() {
        let make = |seed| angiography([64, 60, 24], seed).expect("small");
        let (one, same, other) = (make(1), make(1), make(2));
        assert_eq!(samples(&one), samples(&same));
        assert_ne!(samples(&one), samples(&other));
        assert_eq!(one.bounds().size(), SIZE);
        assert!(angiography([1, 60, 24], 1).is_err());
        assert!(angiography([usize::MAX, 60, 24], 1).is_err());
        assert!(angiography([2048, 2048, 2048], 1).is_err());
    }

    /// Hiding a third leaves bone and arteries, hiding a half a few arteries alone; nothing
    /// lies near either threshold but the arteries' walls.
    #[test]
    fn thresholds_part_tissue_bone_and_arteries() {
        let grid = angiography([128, 128, 48], 1).expect("small");
        let all = samples(&grid);
        let third = ANGIOGRAPHY_RANGE / 3;
        let half = ANGIOGRAPHY_RANGE / 2;
        let share = |from: u16| {
            let over = all.iter().filter(|s| **s >= from).count();
            over as f64 / all.len() as f64
        };
        let (bone_too, arteries) = (share(third), share(half));
        eprintln!("{:.2} % and {:.2} %", 100.0 * bone_too, 100.0 * arteries);
        assert!((0.05..0.2).contains(&bone_too), "{bone_too}");
        assert!((0.001..0.03).contains(&arteries), "{arteries}");
        // Not only just above: samples this coarse blur most of the arteries.
        assert!(share(half + 600) > arteries / 10.0);
    }
}
