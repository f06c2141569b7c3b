//! Writes a small grid as a `.vti` file: a wave, and how much of each sample's surroundings lies
//! in a ball.
//!
//!     cargo run --example write_grid -- grid.vti
//!
//! `benches/peers/vtk_grid.py` reads it with VTK and compares every number.

use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_io::{Compression, write_vti};

fn main() -> Result<(), Error> {
    let path = std::env::args().nth(1).ok_or_else(|| Error::Usage {
        what: "no file to write".into(),
        help: Some("give its name, such as grid.vti".into()),
    })?;
    let lattice = Lattice {
        dims: [60, 50, 70],
        origin: DVec3::new(-1.0, 0.1, 2.5e3),
        spacing: DVec3::new(0.1, 0.25, 1.0 / 3.0),
        // A quarter turn about z.
        direction: DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z),
        interpolation: Interpolation::Linear,
    };
    let [nx, ny, nz] = lattice.dims;
    let each = || (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / (nx * ny)]);
    let wave = each().map(|[x, y, z]| (x * x) as f32 / 8.0 - (y * z) as f32);
    let coverage = each().map(|[x, y, z]| {
        let [x, y, z] = [x as f32 - 30.0, y as f32 - 25.0, z as f32 - 35.0];
        (21.0 - (x * x + y * y + z * z).sqrt()).clamp(0.0, 1.0)
    });
    let number = each().map(|[x, y, z]| (x + 60 * y + 7 * z) as u16);
    let (wave, coverage) = (
        Samples::F32(wave.collect()),
        Samples::F32(coverage.collect()),
    );
    let number = Samples::U16(number.collect());
    let arrays = [
        ("wave", &wave),
        ("coverage", &coverage),
        ("number", &number),
    ];
    let compression = match std::env::args().nth(2).as_deref() {
        Some("zlib") => Compression::Zlib,
        _ => Compression::None,
    };
    write_vti(Path::new(&path), &lattice, &arrays, compression)
}
