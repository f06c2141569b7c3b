//! Draws a volume among an application's own opaque geometry, in the application's own device.
//!
//!     cargo run --example among_geometry -- picture.png
//!
//! The application clears its color and depth textures and draws a lit ball with a pipeline of
//! its own. Then the volume, a translucent ring around the ball, is recorded into the same
//! encoder: rays end at the depths that are there. The picture shows the ball through the near
//! part of the ring, and the far part of the ring hidden by the ball.

mod application;

use std::path::Path;
use std::process::ExitCode;

use tetrascope::core::colormap::srgb_to_linear;
use tetrascope::core::glam::DVec3;
use tetrascope::core::glam::dcamera::rh::{proj::directx::perspective, view::look_at_mat4};
use tetrascope::core::{
    self, Appearance, Camera, Error, Frame, OpticalModel, TransferFunction, View, Volume, view,
};
use tetrascope::gpu::memory::{Source, read_back};
use tetrascope::gpu::wgpu::{TextureFormat, TextureUsages};
use tetrascope::gpu::{Draw as _, Gpu, Over, SceneDepth, Target};
use tetrascope::projection::{CellProjection, ProjectionOptions};
use tetrascope::{datasets, help, io};

const SIZE: (u32, u32) = (640, 480);
const COLOR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

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
    let path = std::env::args().nth(1);
    let path = path.unwrap_or_else(|| "among_geometry.png".into());
    io::image::check_path(Path::new(&path))?;

    // What an application has: a device, textures and a camera.
    let no_device = |reason| Error::NoAdapter {
        reason,
        help: Some("`tetrascope adapters` lists what there is".into()),
    };
    let (device, queue) = pollster::block_on(application::device()).map_err(no_device)?;
    let [color, depth] = [
        application::texture(&device, COLOR, TextureUsages::COPY_SRC),
        application::texture(&device, DEPTH, TextureUsages::TEXTURE_BINDING),
    ];
    let [color_view, depth_view] = [&color, &depth].map(|t| t.create_view(&Default::default()));
    let (eye, view_angle, near, far) = (DVec3::new(2.6, -3.3, 2.0), 36.0_f64, 0.1, 20.0);
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    let clip_from_world = perspective(view_angle.to_radians(), aspect, near, far)
        * look_at_mat4(eye, DVec3::ZERO, DVec3::Z);

    // What the renderer needs, once.
    let gpu = Gpu::from_device(device.clone(), queue.clone());
    let ring = datasets::find("torus")?;
    let volume = Volume::Mesh(ring.mesh(&datasets::Options::default())?);
    let mut knots = ring.look().knots;
    knots.iter_mut().for_each(|knot| knot.extinction *= 0.25); // the ball is to show through
    let colors = TransferFunction::new(knots)?;
    let appearance = Appearance::new(colors, OpticalModel::EmissionAbsorption);
    let renderer = CellProjection::new(&gpu, &volume, &appearance, &ProjectionOptions::default())?;

    // Every frame: the ball first, then the volume over and among what is there.
    let view = View {
        camera: Camera {
            position: eye,
            focal_point: DVec3::ZERO,
            view_up: DVec3::Z,
            projection: core::Projection::Perspective { view_angle },
        },
        width: SIZE.0,
        height: SIZE.1,
        background: view::TRANSPARENT,
    };
    let target = Target {
        over: Over::WhatIsThere,
        depth: Some(SceneDepth {
            texture: &depth,
            clip_from_world,
        }),
        ..Target::new(&color_view, COLOR)
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    application::draw_ball(
        &device,
        &mut encoder,
        [&color_view, &depth_view],
        clip_from_world,
    );
    let recorded = renderer.encode(&mut encoder, &view, &target)?;
    let copy = read_back(&gpu, &mut encoder, Source::Texture(&color))?;
    queue.submit([encoder.finish()]);

    let texels: Vec<[u8; 4]> = copy.read()?;
    let linear = |c: u8| srgb_to_linear(f64::from(c) / 255.0) as f32;
    let pixels = texels
        .iter()
        .map(|&[r, g, b, _]| [linear(r), linear(g), linear(b), 1.0]);
    let frame = Frame::new(SIZE, pixels.collect(), recorded.statistics()?);
    io::write_image(Path::new(&path), &frame, &[])?;
    println!(
        "{} cells among a ball, on {}",
        volume.cell_count(),
        gpu.describe()
    );
    println!("wrote {path}");
    Ok(())
}
