//! Draws a field that changes with time on a mesh that does not, one PNG file per step.
//!
//!     cargo run --example time_series -- series 6
//!
//! Both arguments may be left out: how the files' names begin, and the number of steps. The
//! pictures show two warm spots in a cold cube that circle each other and cool down. A color means the
//! same number in all of them, as the transfer function and the domain are those of the series
//! and not of a step. Only scalars go to the device between steps; the program prints how long
//! that takes, and how long the drawing.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use tetrascope::core::colormap::Colormap;
use tetrascope::core::glam::DVec3;
use tetrascope::core::mesh::Association;
use tetrascope::core::{
    Appearance, Camera, CameraFit, Error, OpticalModel, Scalars, TetMesh, TransferFunction, View,
    Volume, VolumeRenderer as _, view,
};
use tetrascope::gpu::{Gpu, GpuOptions};
use tetrascope::projection::{CellProjection, Domain, ProjectionOptions};
use tetrascope::{datasets, help, io};

/// No temperature is ever outside of this.
const RANGE: (f64, f64) = (0.0, 1.0);

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            if let Some(help) = help(&error) {
                eprintln!("  help: {help}");
            }
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let prefix = arguments.next().unwrap_or_else(|| "time_series".into());
    let count = arguments.next().unwrap_or_else(|| "6".into());
    let count: usize = count.parse().map_err(|_| Error::Usage {
        what: format!("'{count}' is not a number of steps"),
        help: Some("give a whole number, such as 6".into()),
    })?;

    // Build what stays: geometry, appearance, view, and the domain of the whole series.
    let mesh = datasets::find("sphere")?.mesh(&datasets::Options::default())?;
    let first = Volume::Mesh(step(&mesh, 0.0)?);
    let colors = TransferFunction::from_colormap(Colormap::Plasma, RANGE, 0.7, 33)?;
    let appearance = Appearance::new(colors, OpticalModel::EmissionAbsorption);
    let view = View {
        camera: Camera::frame(first.outline(), CameraFit::PlusIso, false, 1.0),
        width: 400,
        height: 400,
        background: view::BLACK,
    };
    let options = ProjectionOptions {
        domain: Some(Domain {
            bounds: mesh.bounds(),
            scalar_range: Some(RANGE),
        }),
        ..ProjectionOptions::default()
    };
    let gpu = Gpu::new(&GpuOptions::default())?;
    println!("{} cells on {}", mesh.cell_count(), gpu.describe());
    let mut renderer = CellProjection::new(&gpu, &first, &appearance, &options)?;

    for index in 0..count {
        let volume = Volume::Mesh(step(&mesh, index as f64 / count as f64)?);
        let start = Instant::now();
        renderer.reload(&volume)?;
        let reloaded = start.elapsed();
        let frame = renderer.render(&view)?;
        let drawn = start.elapsed() - reloaded;
        let path = format!("{prefix}_{index}.png");
        io::write_image(Path::new(&path), &frame, &[])?;
        println!("{path}: reloaded in {reloaded:.2?}, drawn in {drawn:.2?}");
    }
    Ok(())
}

/// The mesh with its temperatures at `time`, which goes from 0 to 1.
fn step(mesh: &TetMesh, time: f64) -> Result<TetMesh, Error> {
    let bounds = mesh.bounds();
    let (center, half) = (bounds.center(), bounds.size().x / 2.0);
    let (sin, cos) = (TAU / 2.0 * time).sin_cos();
    let spot = 0.5 * DVec3::new(cos, sin, 0.0);
    let strength = 1.0 - 0.5 * time;
    let warmth = |distance: f64| (-distance * distance / 0.1).exp();
    let temperature = |point: &DVec3| {
        let at = (*point - center) / half;
        let warmest = warmth(at.distance(spot)).max(0.7 * warmth(at.distance(-spot)));
        0.1 + 0.9 * strength * warmest
    };
    mesh.with_scalars(Scalars {
        name: "temperature".into(),
        association: Association::Point,
        values: mesh.points().iter().map(temperature).collect(),
    })
}
