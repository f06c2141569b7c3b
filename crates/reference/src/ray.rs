//! One ray: its crossings sorted, checked and integrated.

use tetrascope_core::OpticalModel;
use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::{self, RayIntegral, Segment};

use crate::look::Hit;
use crate::tile::{Line, Scene};

/// The contribution of one cell to a ray, before the eye is considered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) z_in: f64,
    pub(crate) z_out: f64,
    pub(crate) scalar_in: f64,
    pub(crate) scalar_out: f64,
    /// The mesh's index.
    pub(crate) cell: u32,
    /// How far both z may be off together, frame units.
    pub(crate) blur: f32,
}

/// A ray's result.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// Premultiplied linear RGBA.
    pub(crate) pixel: [f64; 4],
    pub(crate) light: [f64; 3],
    pub(crate) optical_depth: f64,
    /// Depth of the isosurface that was met, world units along the ray; infinite without one.
    pub(crate) surface_depth: f64,
    pub(crate) error: f64,
    pub(crate) consistency: Consistency,
}

/// Whether a ray's segments lie end to end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Consistency {
    /// Cells overlap by more than rounding.
    pub overlap: bool,
    /// There is a gap that is wider than rounding, yet so thin that it must come from
    /// positions that were rounded before: less than 2⁻²⁰ of the distance to the
    /// farthest vertex. A wider gap is a hole of the mesh.
    pub crack: bool,
}

/// Gaps below this share of the frame's unit are cracks: positions that went through
/// f32 are off by 2⁻²⁴ each.
const CRACK: f64 = 1.0 / (1 << 20) as f64;

/// Behind this optical depth T is below 2e-28 and no bit of a sum near 1 changes.
const OPAQUE: f64 = 64.0;

/// Sorts the entries of a ray front to back.
///
/// The order is total, so that it depends on nothing but the mesh. A segment
/// without length would come before the one that starts where it is.
pub(crate) fn sort(entries: &mut [Entry]) {
    // Cells come nearest first, which is nearly the order: insertion has little to
    // do. Where it has much, give up.
    let mut budget = 8 * entries.len();
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut place = i;
        while place > 0 && entry.is_before(&entries[place - 1]) {
            entries[place] = entries[place - 1];
            place -= 1;
        }
        entries[place] = entry;
        budget = budget.saturating_sub(i - place);
        if budget == 0 {
            return entries.sort_unstable_by_key(Entry::key);
        }
    }
}

impl Entry {
    #[inline]
    fn is_before(&self, other: &Entry) -> bool {
        self.z_in < other.z_in || (self.z_in == other.z_in && self.key() < other.key())
    }

    /// The key by which entries are sorted. For numbers that are 0 or more, as z is before
    /// the eye, the order of the bits is that of the values.
    fn key(&self) -> (u64, u64, u32) {
        (self.z_in.to_bits(), self.z_out.to_bits(), self.cell)
    }
}

/// Integrates sorted entries; `geometric` bounds the error that wrong crossings make.
pub(crate) fn integrate(scene: &Scene, ray: &Line, entries: &[Entry], geometric: f64) -> Outcome {
    let Scene {
        appearance,
        steepness,
        look,
        background,
        ..
    } = scene;
    let length_per_z = ray.length_per_z;
    let model = appearance.optical_model;
    let mut surface: Option<Hit> = None;
    let mut doubtful = false;
    let mut integral = RayIntegral::new(&appearance.transfer_function, model);
    let mut consistency = Consistency::default();
    let mut loose = 0.0; // z by which ends that nobody shares may be off
    let mut last: Option<Entry> = None;
    let mut opaque = false;
    for entry in entries {
        let segment = Segment {
            front: entry.scalar_in,
            back: entry.scalar_out,
            length: (entry.z_out - entry.z_in) * length_per_z,
        };
        if look.draws_surfaces() {
            if surface.is_none() {
                surface = look.hit(scene.mesh, entry, ray.direction);
                doubtful = doubtful || look.is_doubtful(scene, entry);
            }
        } else if !opaque {
            match look.cue(entry) {
                None => integral.add(&segment),
                Some(cue) => integral.add_cued(&segment, cue),
            }
            opaque = model == OpticalModel::EmissionAbsorption && integral.optical_depth() > OPAQUE;
        }
        let shared = last.is_some_and(|l| l.z_out == entry.z_in && l.scalar_out == entry.scalar_in);
        if !shared {
            let before = last.map_or(0.0, |l| f64::from(l.blur));
            let blur = before + f64::from(entry.blur);
            loose += blur;
            if let Some(last) = last {
                let gap = entry.z_in - last.z_out;
                // What both cover; a cell that rounding displaced can lie inside another.
                let common = last.z_out.min(entry.z_out) - entry.z_in;
                consistency.overlap |= common > blur;
                consistency.crack |= gap > blur && gap < CRACK;
            }
        }
        // Where cells overlap, the farthest end is what the next must meet.
        if last.is_none_or(|l| entry.z_out >= l.z_out) {
            last = Some(*entry);
        }
    }
    loose += last.map_or(0.0, |l| f64::from(l.blur));
    if look.draws_surfaces() {
        let (light, depth) = match surface {
            Some(hit) => (hit.color, f64::INFINITY),
            None => (DVec3::ZERO, 0.0),
        };
        let error = if doubtful {
            look.brightest()
        } else {
            surface.map_or(0.0, |hit| hit.error)
        };
        return Outcome {
            pixel: optics::over(model, light, depth, *background),
            light: light.to_array(),
            optical_depth: depth,
            surface_depth: surface.map_or(f64::INFINITY, |hit| hit.z * length_per_z),
            error,
            consistency,
        };
    }
    let pixel = integral.over(*background);
    let light = integral.light();
    let error = geometric
        + steepness.of_boundary(ray.stretch.blur, length_per_z)
        + steepness.of_boundary(loose, length_per_z)
        + integral.rounding_bound() * steepness.brightest()
        + if opaque {
            1e-27 * steepness.brightest()
        } else {
            0.0
        };
    Outcome {
        pixel,
        light: light.to_array(),
        optical_depth: integral.optical_depth(),
        surface_depth: f64::INFINITY,
        error,
        consistency,
    }
}
