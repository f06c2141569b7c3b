//! Samples of a mesh's fields at the points of a regular lattice, for files and for pictures of
//! sections.

use tetrascope_core::grid::{Lattice, Samples};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Bounds, Error, Scalars, TetMesh, is_value};
use tetrascope_gpu::Gpu;
use tetrascope_resample::{Outside, Resampler, ResamplerOptions};

use crate::volumes::LoadedFields;

/// How many samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dims {
    /// As far apart as the points of the mesh, in the median of its cells; in all no more than
    /// [`MOST_AUTO`].
    Auto,
    /// So many along the longest axis, and about as far apart along the others.
    Longest(usize),
    /// So many along each axis.
    Each([usize; 3]),
}

/// The most samples that [`Dims::Auto`] takes: 128 MiB on the device.
pub const MOST_AUTO: usize = 1 << 24;

impl Dims {
    /// The samples along each axis of `bounds`, at least 2.
    pub fn over(self, bounds: &Bounds, mesh: &TetMesh) -> [usize; 3] {
        match self {
            Dims::Each(dims) => dims,
            Dims::Longest(longest) => Lattice::dims_over(bounds, longest),
            Dims::Auto => {
                let size = bounds.size();
                let longest = |spacing: f64| (size.max_element() / spacing).ceil() as usize + 1;
                let mut dims = Lattice::dims_over(bounds, longest(median_edge(mesh)));
                // Fewer along all axes alike, by a bit more than the third root says as each is
                // rounded.
                while let Some(over) = excess(dims) {
                    let fewer = dims.map(|d| ((d as f64 / over.cbrt()) * 0.999) as usize);
                    dims = fewer.map(|d| d.max(2));
                }
                dims
            }
        }
    }
}

/// How many times too many samples there are.
fn excess(dims: [usize; 3]) -> Option<f64> {
    let count: f64 = dims.iter().map(|d| *d as f64).product();
    let over = count / MOST_AUTO as f64;
    (over > 1.0).then_some(over)
}

/// The side of a cube of six cells of median volume; the mesh's longest side without any.
fn median_edge(mesh: &TetMesh) -> f64 {
    let points = mesh.points();
    let cells = mesh.tetrahedra().iter();
    let volumes = cells.map(|cell| {
        let [a, b, c, d] = cell.map(|corner| points[corner as usize]);
        (b - a).cross(c - a).dot(d - a).abs() / 6.0
    });
    let mut volumes: Vec<f64> = volumes.filter(|volume| *volume > 0.0).collect();
    let middle = volumes.len() / 2;
    match volumes.is_empty() {
        true => mesh.bounds().size().max_element(),
        false => {
            let (_, median, _) = volumes.select_nth_unstable_by(middle, f64::total_cmp);
            (6.0 * *median).cbrt()
        }
    }
}

/// Samples of several fields.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Where.
    pub lattice: Lattice,
    /// Each field's name and samples, 32-bit floats.
    pub fields: Vec<(String, Samples)>,
    /// Which samples are in the mesh.
    pub inside: Vec<bool>,
}

impl Sampled {
    /// Takes the samples of all `loaded` fields; a sample outside of the mesh, or where a field has
    /// no value, is `outside`. Calls `done` with the share of fields that are done.
    ///
    /// # Errors
    /// As [`Resampler::new`].
    pub fn new(
        gpu: &Gpu,
        loaded: &LoadedFields,
        lattice: &Lattice,
        options: &ResamplerOptions,
        outside: f32,
        done: impl Fn(f64),
    ) -> Result<Sampled, Error> {
        let has_gaps = |field: &Scalars| field.values.iter().any(|value| !is_value(*value));
        // What tells inside from outside has a value everywhere.
        let whole = loaded.fields.iter().any(has_gaps).then(|| Scalars {
            name: String::new(),
            association: Association::Point,
            values: vec![0.0; loaded.mesh.points().len()],
        });
        let passes = loaded.fields.len() + usize::from(whole.is_some());
        let mut resampler: Option<Resampler> = None;
        let mut sampled = Sampled {
            lattice: *lattice,
            fields: Vec::with_capacity(loaded.fields.len()),
            inside: Vec::new(),
        };
        for (index, field) in loaded.fields.iter().chain(&whole).enumerate() {
            let mesh = loaded.mesh.with_scalars(field.clone())?;
            let resampler = match &mut resampler {
                Some(resampler) => {
                    resampler.reload(&mesh)?;
                    resampler
                }
                slot => slot.insert(Resampler::new(gpu, &mesh, lattice, options)?),
            };
            resampler.resample()?;
            let grid = resampler.read_back(Outside::Uncovered)?;
            let Some(coverage) = grid.coverage() else {
                unreachable!("it was asked for");
            };
            let covered = coverage.iter().map(|share| *share > 0.0);
            let is_whole = index == loaded.fields.len();
            if is_whole || (index == 0 && whole.is_none()) {
                sampled.inside = covered.clone().collect();
            }
            if let (false, Samples::F32(values)) = (is_whole, grid.samples()) {
                let values = values.iter().zip(covered);
                let values = values.map(|(value, is_in)| if is_in { *value } else { outside });
                let samples = Samples::F32(values.collect());
                sampled.fields.push((field.name.clone(), samples));
            }
            done((index + 1) as f64 / passes as f64);
        }
        Ok(sampled)
    }

    /// How many samples are in the mesh.
    pub fn count_inside(&self) -> usize {
        self.inside.iter().filter(|is_in| **is_in).count()
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_datasets::{Options, find};

    use super::*;

    fn sphere(cells: u64) -> TetMesh {
        let cells = Some(cells);
        let options = Options { cells, seed: None };
        find("sphere")
            .expect("listed")
            .mesh(&options)
            .expect("made")
    }

    // Cubes of five cells: four of a sixth of the cube, one of a third.
    #[test]
    fn automatic_samples_are_as_far_apart_as_points() {
        let mesh = sphere(5 * 8 * 8 * 8);
        assert_eq!(Dims::Auto.over(&mesh.bounds(), &mesh), [9; 3]);
        assert_eq!(Dims::Longest(33).over(&mesh.bounds(), &mesh), [33; 3]);
    }

    #[test]
    fn automatic_samples_stay_below_a_bound() {
        let mesh = sphere(5 * 8 * 8 * 8);
        let mut bounds = mesh.bounds();
        bounds.max *= 1e4;
        bounds.max.x *= 0.1;
        let dims = Dims::Auto.over(&bounds, &mesh);
        let count: usize = dims.iter().product();
        assert!(count <= MOST_AUTO && count > MOST_AUTO / 2, "{dims:?}");
    }
}
