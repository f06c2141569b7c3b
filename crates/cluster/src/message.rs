//! The bytes in which ranks send each other tiles and pixels. Numbers are little-endian, and tiles without runs are left out.
//!
//! A tile is its number and how many runs follow (u32 each). A run is its pixel (u16, as tiles have at most 32² pixels),
//! its light (three f32) and what the optical model needs beside it: how much light gets through (f64) where it
//! absorbs, and where the run begins and ends (f64, as ends have to meet to the last bit) where order matters.

use tetrascope_core::OpticalModel;
use tetrascope_core::glam::{DVec3, Vec3};
use tetrascope_raycast_cpu::{Run, Tile};

/// The numbers that runs carry beside pixel and light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Parts {
    transmittance: bool,
    near: bool,
    far: bool,
}

impl Parts {
    fn of(model: OpticalModel) -> Parts {
        let (transmittance, near, far) = match model {
            OpticalModel::EmissionAbsorption => (true, true, true),
            // Nothing is seen behind a surface: the nearest run is the pixel.
            OpticalModel::Isosurfaces => (false, true, false),
            OpticalModel::Emission | OpticalModel::MaximumIntensity => (false, false, false),
            // Whatever else there may be needs no more than this.
            OpticalModel::Absorption => (true, false, false),
            _ => (true, true, true),
        };
        Parts {
            transmittance,
            near,
            far,
        }
    }
}

/// Bytes of a run.
pub(crate) fn bytes_per_run(model: OpticalModel) -> usize {
    let parts = Parts::of(model);
    let numbers = [parts.transmittance, parts.near, parts.far];
    14 + 8 * numbers.into_iter().filter(|is_there| *is_there).count()
}

/// Writes a tile, unless it has no runs.
pub(crate) fn put_tile(bytes: &mut Vec<u8>, number: usize, tile: &Tile, model: OpticalModel) {
    let runs = tile.runs();
    if runs.is_empty() {
        return;
    }
    let parts = Parts::of(model);
    bytes.reserve(8 + runs.len() * bytes_per_run(model));
    bytes.extend((number as u32).to_le_bytes());
    bytes.extend((runs.len() as u32).to_le_bytes());
    for run in runs {
        bytes.extend((run.pixel as u16).to_le_bytes());
        for light in run.light.as_vec3().to_array() {
            bytes.extend(light.to_le_bytes());
        }
        for (is_there, number) in [
            (parts.transmittance, run.transmittance),
            (parts.near, run.near),
            (parts.far, run.far),
        ] {
            if is_there {
                bytes.extend(number.to_le_bytes());
            }
        }
    }
}

/// A tile that was sent: its number, and the bytes of its runs.
pub(crate) type SentTile<'a> = (usize, &'a [u8]);

/// The tiles of a message.
pub(crate) fn tiles(mut bytes: &[u8], model: OpticalModel) -> Vec<SentTile<'_>> {
    let mut tiles = Vec::new();
    while !bytes.is_empty() {
        let number = u32::from_le_bytes(take(&mut bytes)) as usize;
        let count = u32::from_le_bytes(take(&mut bytes)) as usize;
        let (runs, rest) = bytes.split_at(count * bytes_per_run(model));
        tiles.push((number, runs));
        bytes = rest;
    }
    tiles
}

/// The runs of a tile that was sent.
pub(crate) fn runs(bytes: &[u8], model: OpticalModel) -> impl Iterator<Item = Run> {
    let parts = Parts::of(model);
    // Nothing gets through a surface.
    let otherwise = match model {
        OpticalModel::Isosurfaces => 0.0,
        _ => 1.0,
    };
    bytes
        .chunks_exact(bytes_per_run(model))
        .map(move |mut run| {
            let pixel = u16::from_le_bytes(take(&mut run));
            let light = [(); 3].map(|()| f32::from_le_bytes(take(&mut run)));
            let mut number = |is_there: bool, otherwise: f64| match is_there {
                true => f64::from_le_bytes(take(&mut run)),
                false => otherwise,
            };
            let transmittance = number(parts.transmittance, otherwise);
            let near = number(parts.near, 0.0);
            Run {
                pixel: pixel.into(),
                near,
                far: number(parts.far, near),
                light: DVec3::from(Vec3::from(light)),
                transmittance,
            }
        })
}

/// A pixel that is not only background: its place in the image, its color, and how far its surface is.
pub(crate) type Pixel = (usize, [f32; 4], f32);

/// Bytes of a pixel without its distance.
pub(crate) const BYTES_PER_PIXEL: usize = 20;

/// Writes a pixel; how far its surface is only where `has_depth`.
pub(crate) fn put_pixel(bytes: &mut Vec<u8>, (place, color, depth): Pixel, has_depth: bool) {
    bytes.extend((place as u32).to_le_bytes());
    let numbers = color.into_iter().chain(has_depth.then_some(depth));
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
}

/// The pixels of a message.
pub(crate) fn pixels(bytes: &[u8], has_depth: bool) -> impl Iterator<Item = Pixel> {
    let width = BYTES_PER_PIXEL + if has_depth { 4 } else { 0 };
    bytes.chunks_exact(width).map(move |mut bytes| {
        let place = u32::from_le_bytes(take(&mut bytes)) as usize;
        let color = [(); 4].map(|()| f32::from_le_bytes(take(&mut bytes)));
        let depth = match has_depth {
            true => f32::from_le_bytes(take(&mut bytes)),
            false => f32::INFINITY,
        };
        (place, color, depth)
    })
}

/// Takes bytes off the front of a message, which ranks of this program have written.
fn take<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (first, rest) = bytes.split_first_chunk().expect("a whole message");
    *bytes = rest;
    *first
}

#[cfg(test)]
mod tests {
    use tetrascope_core::{Appearance, CameraFit, Volume};
    use tetrascope_raycast_cpu::RaycastCpuOptions;
    use tetrascope_testing::{data_set, fitted, look_of};

    use super::*;

    #[test]
    fn runs_are_those_that_were_sent_in_every_model() {
        let volume = Volume::Mesh(data_set("sphere", Some(5)));
        let view = fitted(&volume, CameraFit::PlusIso, false, 40);
        for model in OpticalModel::ALL {
            let appearance = Appearance {
                optical_model: model,
                ..look_of("sphere")
            };
            let mut tile = Tile::blank(&appearance, &RaycastCpuOptions::default(), &view, 1);
            let mut bytes = Vec::new();
            put_tile(&mut bytes, 1, &tile, model);
            assert!(bytes.is_empty(), "a tile without runs");
            let last = tile.pixel_count() as u32 - 1;
            let absorbs =
                model == OpticalModel::EmissionAbsorption || model == OpticalModel::Absorption;
            tile.add_runs([0, last].map(|pixel| Run {
                pixel,
                near: 0.1 + f64::from(pixel),
                far: 1000.1,
                light: DVec3::new(0.25, 0.5, 3.0),
                transmittance: match model {
                    OpticalModel::Isosurfaces => 0.0,
                    _ if absorbs => 0.1,
                    _ => 1.0,
                },
            }));
            put_tile(&mut bytes, 7, &tile, model);
            assert_eq!(bytes.len(), 8 + 2 * bytes_per_run(model));
            let found = tiles(&bytes, model);
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].0, 7);
            let mut again = Tile::blank(&appearance, &RaycastCpuOptions::default(), &view, 1);
            again.add_runs(runs(found[0].1, model));
            let both = [&tile, &again].map(|tile| tile.pixels(&view).collect::<Vec<_>>());
            assert_eq!(both[0], both[1], "{}", model.name());
            if Parts::of(model).far {
                assert_eq!(again.runs(), tile.runs());
            }
        }
    }

    #[test]
    fn pixels_are_those_that_were_sent() {
        let sent = [
            (3, [0.1, 0.2, 0.3, 0.4], 2.5),
            (70_000, [1.0; 4], f32::INFINITY),
        ];
        for has_depth in [true, false] {
            let mut bytes = Vec::new();
            sent.iter()
                .for_each(|pixel| put_pixel(&mut bytes, *pixel, has_depth));
            let found: Vec<Pixel> = pixels(&bytes, has_depth).collect();
            assert_eq!(found.len(), 2);
            for (found, sent) in found.iter().zip(&sent) {
                assert_eq!((found.0, found.1), (sent.0, sent.1));
                assert_eq!(found.2 == sent.2, has_depth || sent.2 == f32::INFINITY);
            }
        }
    }
}
