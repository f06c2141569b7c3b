//! Small regular grids.

use tetrascope_core::Grid;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Samples;

/// Where the samples of a grid lie, world space.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Samples along each axis.
    pub dims: [usize; 3],
    /// The first sample.
    pub origin: DVec3,
    /// The distance of samples along each axis.
    pub spacing: DVec3,
    /// The axes, as columns.
    pub direction: DMat3,
}

impl Place {
    /// The cube [0, 1]³ with `cells` cells along each axis.
    pub fn unit(cells: usize) -> Place {
        Place {
            dims: [cells + 1; 3],
            origin: DVec3::ZERO,
            spacing: DVec3::splat(1.0 / cells as f64),
            direction: DMat3::IDENTITY,
        }
    }

    /// A grid of these samples, x fastest.
    pub fn grid(&self, samples: Samples) -> Grid {
        let Place {
            dims,
            origin,
            spacing,
            direction,
        } = *self;
        Grid::new(dims, origin, spacing, direction, samples).expect("a valid grid")
    }
}

/// A grid of floats by a formula of the world position.
pub fn grid(place: &Place, field: impl Fn(DVec3) -> f64) -> Grid {
    grid_of(place, |p| field(p) as f32, Samples::F32)
}

/// A grid of any type of samples by a formula of the world position.
pub fn grid_of<T>(
    place: &Place,
    field: impl Fn(DVec3) -> T,
    samples: impl Fn(Vec<T>) -> Samples,
) -> Grid {
    let [nx, ny, nz] = place.dims;
    let values = (0..nx * ny * nz).map(|i| {
        let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)].map(|i| i as f64);
        field(place.origin + place.direction * (place.spacing * DVec3::new(x, y, z)))
    });
    place.grid(samples(values.collect()))
}
