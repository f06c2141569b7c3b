//! A mesh's paths of rays, each by itself: what processes that have parts of a mesh send each other.

use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::over;
use tetrascope_core::{Error, OpticalModel, View};

/// The light that a ray gathers between coming into a mesh and leaving it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSegment {
    /// Where it comes in, world units from where the ray starts; where it meets a surface, if it does.
    ///
    /// Where a ray goes from one part of a mesh into another, this is the first one's `far`, to the last bit.
    pub near: f64,
    /// Where it leaves.
    pub far: f64,
    /// How much of the light behind gets through; 1 where the model does not absorb, 0 behind a surface.
    pub transmittance: f64,
    /// Light of the segment alone, linear RGB; the greatest color in the model `MaximumIntensity`.
    pub light: [f32; 3],
}

/// The segments of all rays of a view.
///
/// Parts of a mesh that together are the whole give the whole's picture, whatever their shapes are
/// ([`PathSegments::composite`]): a ray may go through a part many times, and
/// through others in between.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSegments {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Where the segments of each pixel begin in `segments`, row by row, and where the last end.
    pub begins: Vec<u32>,
    /// By pixel, and along each ray.
    pub segments: Vec<PathSegment>,
    model: OpticalModel,
}

impl PathSegments {
    /// Sorts segments, each with its pixel, by pixel; those of one pixel stay in their order.
    pub(crate) fn new(
        view: &View,
        model: OpticalModel,
        found: Vec<(u32, PathSegment)>,
    ) -> PathSegments {
        let pixels = view.width as usize * view.height as usize;
        let mut found = found;
        found.sort_by_key(|(pixel, _)| *pixel);
        let mut begins = vec![0; pixels + 1];
        for (pixel, _) in &found {
            begins[*pixel as usize + 1] += 1;
        }
        for pixel in 0..pixels {
            begins[pixel + 1] += begins[pixel];
        }
        PathSegments {
            width: view.width,
            height: view.height,
            begins,
            segments: found.into_iter().map(|(_, segment)| segment).collect(),
            model,
        }
    }

    /// The segments of a pixel, row by row.
    pub fn of(&self, pixel: usize) -> &[PathSegment] {
        &self.segments[self.begins[pixel] as usize..self.begins[pixel + 1] as usize]
    }

    /// The picture of all parts together: premultiplied linear RGBA before the background of `view`.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless all parts are of one optical model and of the view's size.
    pub fn composite(parts: &[PathSegments], view: &View) -> Result<Vec<[f32; 4]>, Error> {
        view.validate()?;
        let background = view.premultiplied_background();
        let [first, ..] = parts else {
            return Err(Error::invalid("no parts to composite"));
        };
        let fits = |part: &PathSegments| {
            part.model == first.model && (part.width, part.height) == (view.width, view.height)
        };
        if !parts.iter().all(fits) {
            return Err(Error::invalid(
                "parts of several optical models or sizes of image",
            ));
        }
        let mut of_pixel: Vec<&PathSegment> = Vec::new();
        let pixels = 0..view.width as usize * view.height as usize;
        Ok(pixels
            .map(|pixel| {
                of_pixel.clear();
                of_pixel.extend(parts.iter().flat_map(|part| part.of(pixel)));
                of_pixel.sort_by(|a, b| a.near.total_cmp(&b.near).then(a.far.total_cmp(&b.far)));
                let (mut light, mut transmittance) = (DVec3::ZERO, 1.0);
                for segment in &of_pixel {
                    let own = DVec3::from(segment.light.map(f64::from));
                    light = match first.model {
                        OpticalModel::MaximumIntensity => light.max(own),
                        _ => light + transmittance * own,
                    };
                    transmittance *= segment.transmittance;
                }
                // −ln 1 is −0.
                let depth = -f64::ln(transmittance) + 0.0;
                over(first.model, light, depth, background).map(|value| value as f32)
            })
            .collect())
    }
}
