//! Chosen pixels of a picture, for whoever needs the truth in some places only.

use rayon::prelude::*;
use tetrascope_core::{Error, View};

use crate::Reference;
use crate::tile::Workspace;

/// The truth in chosen pixels, in the order in which they were asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePixels {
    /// Premultiplied linear RGBA.
    pub pixels: Vec<[f64; 4]>,
    /// A bound on the absolute error of each pixel's channels, as in
    /// [`ReferenceImage`](crate::ReferenceImage).
    pub error_bound: Vec<f64>,
    /// Cells that each pixel's ray meets.
    pub cell_visits: Vec<u64>,
}

impl Reference {
    /// Draws the pixels of a view in these columns and rows, row 0 at the top, and no others:
    /// to the last bit those of [`Reference::render_exact`].
    ///
    /// Each pixel searches the BVH by itself, so that a whole picture is faster in one.
    ///
    /// # Errors
    /// As [`Reference::render_exact`], and [`Error::Invalid`] for a pixel outside of the picture.
    pub fn render_pixels(
        &self,
        view: &View,
        pixels: &[[u32; 2]],
    ) -> Result<ReferencePixels, Error> {
        view.validate()?;
        let (width, height) = (view.width, view.height);
        if let Some([column, row]) = pixels.iter().find(|[c, r]| *c >= width || *r >= height) {
            return Err(Error::invalid(format!(
                "column {column}, row {row} of a picture of {width}x{height} pixels"
            )));
        }
        let drawn = self.in_pool(|| {
            self.with_tiles(view, &|_, _| f64::INFINITY, |draw| {
                let drawn = pixels.par_iter();
                let drawn = drawn.map_init(Workspace::default, |workspace, &[column, row]| {
                    self.stop.check()?;
                    Ok(draw(column..column + 1, row..row + 1, workspace).swap_remove(0))
                });
                drawn.collect::<Result<Vec<_>, Error>>()
            })
        })??;
        Ok(ReferencePixels {
            pixels: drawn.iter().map(|(outcome, _)| outcome.pixel).collect(),
            error_bound: drawn.iter().map(|(outcome, _)| outcome.error).collect(),
            cell_visits: drawn.iter().map(|(_, visits)| *visits as u64).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Appearance, OpticalModel, Volume};
    use tetrascope_testing::{Place, data_set, grid, outside_and_inside, ramp, surfaces, tilted};

    use super::*;
    use crate::ReferenceOptions;

    /// Some in every row and column, in no order, one of them twice.
    fn some(view: &View) -> Vec<[u32; 2]> {
        let (width, height) = (view.width, view.height);
        let pixel = |i: u32| [i * 7 % width, (i * 5 + 3) % height];
        let all = (0..4 * width).rev().map(pixel);
        all.chain([[0, 0], [width - 1, height - 1], [0, 0]])
            .collect()
    }

    fn check(volume: &Volume, appearance: &Appearance) {
        let options = ReferenceOptions::default();
        let reference = Reference::new(volume, appearance, &options).expect("it draws");
        for view in outside_and_inside(volume, 37) {
            let image = reference.render_exact(&view).expect("it draws");
            let places = some(&view);
            let pixels = reference.render_pixels(&view, &places).expect("it draws");
            for (i, &[column, row]) in places.iter().enumerate() {
                let of_image = image.pixel(column, row).map(f64::to_bits);
                assert_eq!(
                    pixels.pixels[i].map(f64::to_bits),
                    of_image,
                    "{column}, {row}"
                );
                let bound = image.error_bound[(row * view.width + column) as usize];
                assert_eq!(pixels.error_bound[i].to_bits(), bound.to_bits());
            }
            let all = (0..view.height).flat_map(|row| (0..view.width).map(move |c| [c, row]));
            let all: Vec<[u32; 2]> = all.collect();
            let all = reference.render_pixels(&view, &all).expect("it draws");
            assert_eq!(all.cell_visits.iter().sum::<u64>(), image.cell_visits);
        }
    }

    #[test]
    fn chosen_pixels_are_those_of_the_picture_to_the_last_bit() {
        let mesh = Volume::Mesh(data_set("delaunay", Some(2000)));
        let regular = Volume::Grid(grid(&Place::unit(6), |p| p.dot(DVec3::ONE).sin()));
        for volume in [&mesh, &regular] {
            let look = ramp(volume);
            for model in OpticalModel::VOLUMETRIC {
                check(
                    volume,
                    &Appearance {
                        optical_model: model,
                        ..look.clone()
                    },
                );
            }
            let clip_planes = tilted(volume);
            check(
                volume,
                &Appearance {
                    clip_planes,
                    ..surfaces(volume, look)
                },
            );
        }
    }

    #[test]
    fn a_picture_stops_when_asked_and_the_next_is_whole() {
        let volume = Volume::Mesh(data_set("sphere", Some(600)));
        let options = ReferenceOptions::default();
        let reference = Reference::new(&volume, &ramp(&volume), &options).expect("it draws");
        let stop = tetrascope_core::Stop::new();
        let reference = reference.with_stop(stop.clone());
        let [view, ..] = outside_and_inside(&volume, 32);
        let whole = reference.render_exact(&view).expect("it draws");
        stop.set();
        assert!(matches!(reference.render_exact(&view), Err(Error::Stopped)));
        let pixels = reference.render_pixels(&view, &[[0, 0]]);
        assert!(matches!(pixels, Err(Error::Stopped)));
        stop.clear();
        let again = reference.render_exact(&view).expect("it draws");
        assert_eq!(again.pixels, whole.pixels);
    }

    #[test]
    fn a_pixel_outside_of_the_picture_is_refused() {
        let volume = Volume::Mesh(data_set("sphere", Some(600)));
        let options = ReferenceOptions::default();
        let reference = Reference::new(&volume, &ramp(&volume), &options).expect("it draws");
        let [view, ..] = outside_and_inside(&volume, 16);
        for pixel in [[16, 0], [0, 16], [u32::MAX, 0]] {
            assert!(
                reference.render_pixels(&view, &[[1, 1], pixel]).is_err(),
                "{pixel:?}"
            );
        }
        assert_eq!(
            reference
                .render_pixels(&view, &[])
                .expect("nothing")
                .pixels
                .len(),
            0
        );
    }
}
