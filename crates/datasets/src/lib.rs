//! Meshes and fields that need no file: made on demand, at any size, the same every time.
//!
//! They are those of the papers where the papers say enough to make them again,
//! and what renderers find hard: a hole, slivers, irregular cells. [`all`] lists
//! them, [`find`] looks one up by name; a [`Dataset`] makes its mesh with
//! [`Dataset::mesh`], or its grid with [`Dataset::grid`], tells cells one by one where it can ([`Dataset::cells`]), and says with [`Dataset::look`] how a picture shows it well.
//!
//! ```
//! use tetrascope_datasets::{Options, find};
//!
//! let mesh = find("sphere")?.mesh(&Options::default())?;
//! assert_eq!(mesh.cell_count(), 148_955);
//! # Ok::<(), tetrascope_core::Error>(())
//! ```
//!
//! Reading order: `lattice` cuts boxes into tetrahedra that agree across faces;
//! then one module per data set. `angiography` is a regular grid, and [`wave`] makes a mesh for
//! each step of time.

mod lattice;
mod random;

mod angiography;
mod delaunay;
mod graded;
mod heat_sink;
mod orbital;
mod sphere;
mod staircase;
mod torus;
mod wave;

#[cfg(test)]
mod checks;

pub use angiography::{ANGIOGRAPHY_RANGE, angiography};
pub use wave::{WAVE_STEPS, wave};

use tetrascope_core::clusters::CellSource;
use tetrascope_core::{CameraFit, Error, Grid, Knot, TetMesh, Volume};

/// A named mesh or regular grid with a field.
#[derive(Debug)]
pub struct Dataset {
    /// Name in scenes and on the command line.
    pub name: &'static str,
    /// One line: geometry, then field.
    pub about: &'static str,
    /// The paper that uses it, or why it is here.
    pub paper: &'static str,
    /// How many cells there are unless [`Options::cells`] says otherwise.
    pub default_cells: u64,
    /// More cells than this are refused.
    pub max_cells: u64,
    /// Whether [`Options::seed`] changes anything.
    pub seeded: bool,
    make: Make,
    /// The same cells one by one, where they can be told from their numbers.
    cells: Option<fn(cells: u64) -> Box<dyn CellSource>>,
    look: fn() -> Look,
}

/// Makes so many cells from a seed.
#[derive(Debug)]
enum Make {
    Mesh(fn(cells: u64, seed: u64) -> Result<TetMesh, Error>),
    Grid(fn(cells: u64, seed: u64) -> Result<Grid, Error>),
}

/// How large and how random.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// About how many cells; each data set makes the nearest number that it can,
    /// and at least its coarsest mesh.
    pub cells: Option<u64>,
    /// For data sets with random points; the others are the same for every seed.
    pub seed: Option<u64>,
}

/// The seed where none is given.
const DEFAULT_SEED: u64 = 1;

/// 100 million tetrahedra are 1.6 GB of indices; the mesh's point and cell
/// indices, of 32 bits, would last for more.
const MOST_CELLS: u64 = 100_000_000;

/// Points of so many cells, a fifth or so, are counted in 32 bits.
const MOST_LISTED: u64 = 10_000_000_000;

/// How a picture shows a data set well, at its default size.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The side from which it is seen.
    pub fit: CameraFit,
    /// The transfer function: scalars in the field's units and extinction per world unit, so
    /// neither depends on how many cells there are.
    pub knots: Vec<Knot>,
}

const ALL: &[Dataset] = &[
    sphere::DATASET,
    orbital::DATASET,
    heat_sink::DATASET,
    staircase::DATASET,
    torus::DATASET,
    delaunay::DATASET,
    graded::DATASET,
    angiography::DATASET,
];

/// Every data set.
pub fn all() -> &'static [Dataset] {
    ALL
}

/// The data set called `name`; an unknown name is refused with those that exist.
pub fn find(name: &str) -> Result<&'static Dataset, Error> {
    ALL.iter()
        .find(|dataset| dataset.name == name)
        .ok_or_else(|| Error::Unknown {
            kind: "data set",
            name: name.into(),
            valid: ALL.iter().map(|dataset| dataset.name.into()).collect(),
        })
}

impl Dataset {
    /// Whether it is a regular grid.
    pub fn is_grid(&self) -> bool {
        matches!(self.make, Make::Grid(_))
    }

    /// Makes the mesh or the grid. The same options give the same, to the last bit.
    ///
    /// # Errors
    /// [`Error::Invalid`] for no cells at all, and for more than [`Dataset::max_cells`].
    pub fn volume(&self, options: &Options) -> Result<Volume, Error> {
        let (cells, seed) = self.size(options)?;
        match self.make {
            Make::Mesh(make) => make(cells, seed).map(Volume::Mesh),
            Make::Grid(make) => make(cells, seed).map(Volume::Grid),
        }
    }

    /// Makes the mesh.
    ///
    /// # Errors
    /// As [`Dataset::volume`], and for a grid.
    pub fn mesh(&self, options: &Options) -> Result<TetMesh, Error> {
        let (cells, seed) = self.size(options)?;
        match self.make {
            Make::Mesh(make) => make(cells, seed),
            Make::Grid(_) => Err(Error::Invalid {
                what: format!("the data set '{}' is a regular grid and no mesh", self.name),
                help: Some("draw it with an algorithm for grids".into()),
            }),
        }
    }

    /// Makes the grid.
    ///
    /// # Errors
    /// As [`Dataset::volume`], and for a mesh.
    pub fn grid(&self, options: &Options) -> Result<Grid, Error> {
        let (cells, seed) = self.size(options)?;
        match self.make {
            Make::Grid(make) => make(cells, seed),
            Make::Mesh(_) => Err(Error::Invalid {
                what: format!("the data set '{}' is a mesh and no regular grid", self.name),
                help: Some("take samples of it, or draw it as it is".into()),
            }),
        }
    }

    /// The cells of the mesh without the mesh: no memory grows with how many there are, and so there may be ten
    /// billion. `None` for data sets whose cells cannot be told one by one.
    ///
    /// Cells, points and values are those of [`Dataset::mesh`], to the last bit, but that a mesh turns cells that are
    /// inside out.
    ///
    /// # Errors
    /// [`Error::Invalid`] for no cells at all and for more than that.
    pub fn cells(&self, options: &Options) -> Result<Option<Box<dyn CellSource>>, Error> {
        let Some(make) = self.cells else {
            return Ok(None);
        };
        let cells = self.checked(options, MOST_LISTED)?;
        Ok(Some(make(cells)))
    }

    /// How many cells and which seed, if that many can be made.
    fn size(&self, options: &Options) -> Result<(u64, u64), Error> {
        let cells = self.checked(options, self.max_cells)?;
        Ok((cells, options.seed.unwrap_or(DEFAULT_SEED)))
    }

    /// How many cells, at least 1 and at most `most`.
    fn checked(&self, options: &Options, most: u64) -> Result<u64, Error> {
        let cells = options.cells.unwrap_or(self.default_cells);
        match (1..=most).contains(&cells) {
            true => Ok(cells),
            false => Err(Error::Invalid {
                what: format!("data set '{}' with {cells} cells", self.name),
                help: Some(format!("ask for 1 to {most} cells")),
            }),
        }
    }

    /// How a picture shows the data set well.
    pub fn look(&self) -> Look {
        (self.look)()
    }
}

/// A knot: scalar, linear RGB, extinction per world unit.
fn knot(scalar: f64, color: [f64; 3], extinction: f64) -> Knot {
    Knot {
        scalar,
        color: color.into(),
        extinction,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope_core::TransferFunction;

    #[test]
    fn names_are_unique_and_an_unknown_one_lists_them() {
        for (i, dataset) in all().iter().enumerate() {
            assert!(all()[..i].iter().all(|other| other.name != dataset.name));
            assert_eq!(find(dataset.name).expect("listed").name, dataset.name);
        }
        let message = find("spher").expect_err("misspelt").to_string();
        assert!(
            message.contains("'spher'") && message.contains("sphere"),
            "{message}"
        );
    }

    #[test]
    fn impossible_sizes_are_refused_with_the_bounds() {
        for dataset in all() {
            for cells in [0, dataset.max_cells + 1, u64::MAX] {
                let error = dataset
                    .volume(&Options {
                        cells: Some(cells),
                        seed: None,
                    })
                    .expect_err("no such size");
                assert!(error.to_string().contains(&cells.to_string()), "{error}");
                let help = error.help().expect("a size that works");
                assert!(help.contains(&dataset.max_cells.to_string()), "{help}");
            }
        }
    }

    #[test]
    fn the_same_options_give_the_same_mesh() {
        for dataset in all().iter().filter(|dataset| !dataset.is_grid()) {
            let make = |seed| {
                let cells = Some(dataset.default_cells.min(3000));
                dataset.mesh(&Options { cells, seed }).expect("small")
            };
            let (a, b, other) = (make(None), make(None), make(Some(7)));
            assert_eq!(a.points(), b.points(), "{}", dataset.name);
            assert_eq!(a.tetrahedra(), b.tetrahedra(), "{}", dataset.name);
            assert_eq!(a.scalars(), b.scalars(), "{}", dataset.name);
            let changed = a.points() != other.points();
            assert_eq!(changed, dataset.seeded, "{}", dataset.name);
        }
    }

    #[test]
    fn cells_one_by_one_are_those_of_the_mesh() {
        let mut listed = 0;
        for dataset in all() {
            for cells in [1, 300, 3000] {
                let options = Options {
                    cells: Some(cells),
                    seed: None,
                };
                let Some(cells) = dataset.cells(&options).expect("small") else {
                    continue;
                };
                listed += 1;
                let mesh = dataset.mesh(&options).expect("small");
                assert_eq!(
                    cells.cell_count(),
                    mesh.cell_count() as u64,
                    "{}",
                    dataset.name
                );
                for (number, cell) in (0..).zip(mesh.tetrahedra()) {
                    // A mesh turns those that are inside out.
                    let [mut own, mut other] = [cells.cell(number), *cell];
                    own.sort_unstable();
                    other.sort_unstable();
                    assert_eq!(own, other, "{} {number}", dataset.name);
                }
                for (number, point) in (0..).zip(mesh.points()) {
                    assert_eq!(cells.point(number), *point, "{} {number}", dataset.name);
                }
                for (number, value) in (0..).zip(&mesh.scalars().values) {
                    assert_eq!(cells.value(number), *value, "{} {number}", dataset.name);
                }
                let scalars = mesh.scalars();
                assert_eq!(cells.field(), (&scalars.name[..], scalars.association));
                assert_eq!(cells.bounds(), mesh.bounds(), "{}", dataset.name);
            }
        }
        assert_eq!(listed, 6);
        let options = Options {
            cells: Some(MOST_LISTED + 1),
            seed: None,
        };
        let error = find("sphere").expect("listed").cells(&options).map(drop);
        assert!(error.expect_err("too many").help().is_some());
    }

    // Sizes grow with the request; how near they come is each data set's own matter.
    #[test]
    fn more_cells_asked_are_more_cells_made() {
        for dataset in all() {
            let made: Vec<usize> = [300, 600, 1200, 2400, 4800, 9600]
                .iter()
                .map(|&cells| {
                    let options = Options {
                        cells: Some(cells),
                        seed: None,
                    };
                    dataset.volume(&options).expect("small").cell_count()
                })
                .collect();
            assert!(
                made.windows(2).all(|pair| pair[0] < pair[1]),
                "{}: {made:?}",
                dataset.name
            );
        }
    }

    #[test]
    fn a_grid_is_no_mesh_and_a_mesh_no_grid() {
        for dataset in all() {
            let options = Options {
                cells: Some(300),
                seed: None,
            };
            assert_ne!(
                dataset.mesh(&options).is_ok(),
                dataset.grid(&options).is_ok()
            );
            assert_eq!(dataset.grid(&options).is_ok(), dataset.is_grid());
        }
    }

    // One cell is less than most can do: they make their coarsest mesh.
    #[test]
    fn the_coarsest_mesh_is_valid() {
        for dataset in all().iter().filter(|dataset| !dataset.is_grid()) {
            let options = Options {
                cells: Some(1),
                seed: None,
            };
            let mesh = dataset.mesh(&options).expect("coarse");
            checks::conforms(&mesh);
            checks::positive(&mesh);
        }
    }

    // The knots lie over the data, and something of the field can be seen.
    #[test]
    fn looks_are_valid_and_show_something() {
        for dataset in all() {
            let volume = dataset.volume(&Options::default()).expect("default size");
            let diagonal = volume.bounds().diagonal();
            let (low, high) = volume.scalar_range().expect("a field");
            let function = TransferFunction::new(dataset.look().knots).expect("valid knots");
            let (first, last) = function.range();
            let slack = 0.25 * (high - low).max(1e-12);
            assert!(
                first > low - slack && last < high + slack,
                "{}: knots {first} to {last}, data {low} to {high}",
                dataset.name
            );
            // Thick enough to see and not so thick that everything is a wall.
            let depth = function.max_extinction(low, high) * diagonal;
            assert!((1.0..100.0).contains(&depth), "{}: {depth}", dataset.name);
        }
    }
}
