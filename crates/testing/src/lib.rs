//! The bench that tests and benchmarks share: volumes, looks, views, the truth, the error of
//! a picture, real data, a device, and an application that has drawn on it.
//!
//! Whatever is missing, such as a graphics adapter or a data file, is said on stderr together
//! with the test that is skipped. All that is built here is valid, so nothing returns an error:
//! a mistake in a test panics.

#[cfg(feature = "gpu")]
mod application;
mod data;
#[cfg(feature = "gpu")]
mod device;
mod entries;
mod grids;
mod hard_rays;
mod image_error;
mod long_run;
mod looks;
mod meshes;
mod parts;
mod truth;
mod views;

#[cfg(feature = "gpu")]
pub use application::Application;
pub use data::{
    BLUNT_FIN, angular_sector, blunt_fin, data_path, file, liquid_oxygen_post, mesh_data,
    read_blunt_fin, super_phoenix,
};
#[cfg(feature = "gpu")]
pub use device::gpu;
pub use entries::{check_counts, every_setting_arrives, refusal};
pub use grids::{Place, grid, grid_of};
pub use hard_rays::{HARD_MESHES, HardMesh, Random, hard_ray};
pub use image_error::{ImageError, apart, between, difference, exactly, infinite_if_null, scale};
pub use long_run::cast_many;
pub use looks::{knot, look_of, ramp, surfaces, tilted};
pub use meshes::{
    CUBE, cells, data_set, jumping, kuhn, kuhn_cells, mesh, mismatched, point_scalars, split,
    stacked_plates, tetrahedra_of,
};
pub use parts::quarters;
pub use truth::{is_explained, is_near_explained, truth};
pub use views::{cutting, fitted, inside, outside_and_inside, view};

use std::io::Write as _;

/// Writes a line to stderr itself, which the test runner does not capture.
pub fn say(line: &str) {
    _ = writeln!(std::io::stderr(), "{line}");
}

/// The value that was made, or `None` after saying that `test` is skipped because there is no adapter.
///
/// # Panics
/// If there is no adapter although the environment variable `CI` is set, and for any other
/// error.
pub fn or_skipped<T>(test: &str, made: Result<T, tetrascope_core::Error>) -> Option<T> {
    match made {
        Ok(made) => Some(made),
        Err(error @ tetrascope_core::Error::NoAdapter { .. })
            if std::env::var_os("CI").is_none() =>
        {
            eprintln!("{test}: skipped: {error}");
            None
        }
        Err(error) => panic!("{test}: {error}"),
    }
}
