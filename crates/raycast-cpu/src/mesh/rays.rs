//! The rays of a block of pixels, each sheared so that it is the z axis (Woop, Benthin, Wald 2013).

use tetrascope_core::Unit as _;
use tetrascope_core::appearance::CueRamp;
use tetrascope_core::glam::{DVec3, DVec4, Vec3Swizzles as _};
use tetrascope_core::{Appearance, Bounds, View};
use tetrascope_f32::{Normalization, Rays};

use super::packed::Vertex;
use crate::simd::MOST_LANES;

/// The most pixels along a side of a block.
pub(super) const MOST_SIDE: usize = 64;

/// Rays a row, with room behind the last for whole vectors.
pub(super) const STRIDE: usize = MOST_SIDE + MOST_LANES;

/// The main axis of rays, along which their direction is greatest, and its sign: 0 to 5. Vertices
/// are turned so that it is z, and grows along the ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class(pub(super) usize);

impl Class {
    /// How many there are.
    pub(super) const COUNT: usize = 6;

    pub(super) fn of(direction: DVec3) -> Class {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        Class(2 * axis + usize::from(direction[axis] < 0.0))
    }

    /// Cyclic, so that handedness stays, but for the sign.
    fn turned(self, p: DVec3) -> DVec3 {
        let p = match self.0 / 2 {
            0 => p.yzx(),
            1 => p.zxy(),
            _ => p,
        };
        DVec3::new(p.x, p.y, if self.0 % 2 == 1 { -p.z } else { p.z })
    }

    /// The same of a vertex, exactly.
    pub(super) fn vertex(self, [x, y, z, scalar]: Vertex) -> Vertex {
        let [x, y, z] = match self.0 / 2 {
            0 => [y, z, x],
            1 => [z, x, y],
            _ => [x, y, z],
        };
        [x, y, if self.0 % 2 == 1 { -z } else { z }, scalar]
    }
}

/// Facts about rays that all blocks of a frame share.
#[derive(Debug)]
pub(super) struct Camera<'a> {
    rays: Rays,
    normalization: Normalization,
    /// Unit normal and n · p, normalized.
    planes: Vec<DVec4>,
    cue: Option<CueRamp>,
    ends: Option<&'a [f64]>,
    width: usize,
}

/// One value of each ray of a block, row by row.
pub(super) type Rows = Vec<f32>;

/// The rays of one class in a block. Others are NaN, and cross no face.
#[derive(Debug, Default)]
pub(super) struct BlockRays {
    /// Where a ray passes z = 0, and minus how it moves with z.
    pub(super) through: [Rows; 2],
    pub(super) slope: [Rows; 2],
    /// Normalized length per z.
    pub(super) depth: Rows,
    /// z where the ray begins: at the eye or a clip plane; and where it ends.
    pub(super) begin: Rows,
    pub(super) end: Rows,
    /// The depth cue at z is the first and z times the second.
    pub(super) cue: [Rows; 2],
}

impl BlockRays {
    fn arrays(&mut self) -> [&mut Rows; 9] {
        let BlockRays {
            through: [through_x, through_y],
            slope: [slope_x, slope_y],
            depth,
            begin,
            end,
            cue: [cue, cue_slope],
        } = self;
        [
            through_x, through_y, slope_x, slope_y, depth, begin, end, cue, cue_slope,
        ]
    }
}

impl<'a> Camera<'a> {
    /// `bounds` are what a depth cue spans.
    pub(super) fn new(
        view: &View,
        rays: Rays,
        normalization: Normalization,
        appearance: &Appearance,
        bounds: &Bounds,
        ends: Option<&'a [f64]>,
    ) -> Camera<'a> {
        let planes = appearance.clip_planes.iter().map(|plane| {
            let normal = plane.normal.unit();
            normal.extend(normal.dot(normalization.point(plane.point)))
        });
        let cue = appearance.depth_cue.map(|cue| {
            let ramp = cue.ramp(view.camera.position, rays.forward, bounds);
            CueRamp {
                slope: ramp.slope * normalization.scale,
                ..ramp
            }
        });
        Camera {
            planes: planes.collect(),
            cue,
            ends,
            width: view.width as usize,
            rays,
            normalization,
        }
    }

    pub(super) fn has_cue(&self) -> bool {
        self.cue.is_some()
    }

    /// Anchor and direction, of any length, of the ray of a pixel, normalized.
    fn ray(&self, column: usize, row: usize) -> (DVec3, DVec3) {
        let rays = &self.rays;
        let anchor = rays.anchor + column as f64 * rays.anchor_x + row as f64 * rays.anchor_y;
        match rays.is_point {
            true => (anchor, anchor - rays.eye),
            false => (anchor, rays.eye),
        }
    }

    /// The direction of a pixel's ray, world space, of any length.
    pub(super) fn direction(&self, column: usize, row: usize) -> DVec3 {
        self.ray(column, row).1
    }

    /// How far z of a pixel's ray is from where the ray starts, world units.
    pub(super) fn distance(&self, class: Class, column: usize, row: usize, z: f64) -> f64 {
        let (anchor, direction) = self.ray(column, row);
        let length = direction.length();
        let start = match self.rays.is_point {
            true => -length,
            false => self.rays.eye_depth,
        };
        let t = (z - class.turned(anchor).z) * length / class.turned(direction).z;
        (t - start) * self.normalization.scale
    }

    /// The classes of the rays in columns and rows, as bits.
    ///
    /// Directions of any length are linear in the pixel, and those of a class are a convex cone: what
    /// holds at the corners holds in between.
    pub(super) fn classes(&self, columns: [usize; 2], rows: [usize; 2]) -> u8 {
        let bit = |column, row| 1_u8 << Class::of(self.ray(column, row).1).0;
        let [left, right] = [columns[0], columns[1] - 1];
        let [top, bottom] = [rows[0], rows[1] - 1];
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        let classes = corners.iter().fold(0, |bits, &(c, r)| bits | bit(c, r));
        if classes.count_ones() == 1 {
            return classes;
        }
        let all = (rows[0]..rows[1]).flat_map(|r| (columns[0]..columns[1]).map(move |c| (c, r)));
        all.fold(classes, |bits, (c, r)| bits | bit(c, r))
    }

    /// Sets up the rays of one class in columns and rows.
    pub(super) fn set(
        &self,
        class: Class,
        columns: [usize; 2],
        rows: [usize; 2],
        block: &mut BlockRays,
    ) {
        let count = (rows[1] - rows[0]) * STRIDE;
        for values in block.arrays() {
            values.clear();
            values.resize(count, f32::NAN);
        }
        for row in rows[0]..rows[1] {
            for column in columns[0]..columns[1] {
                let (anchor, direction) = self.ray(column, row);
                if Class::of(direction) != class {
                    continue;
                }
                let place = (row - rows[0]) * STRIDE + column - columns[0];
                let line = self.line(class, anchor, direction, row * self.width + column);
                for (values, value) in block.arrays().into_iter().zip(line) {
                    values[place] = value as f32;
                }
            }
        }
    }

    /// Sets up rays by their anchors and directions, all of one class.
    #[cfg(test)]
    pub(super) fn put(&self, class: Class, rays: &[&[DVec3; 2]], block: &mut BlockRays) {
        for values in block.arrays() {
            values.clear();
            values.resize(MOST_SIDE * STRIDE, f32::NAN);
        }
        for (i, &&[anchor, direction]) in rays.iter().enumerate() {
            let mut line = self.line(class, anchor, direction, 0);
            // All of the line, and not from the eye.
            (line[5], line[6]) = (-100.0, 100.0);
            let place = i / MOST_SIDE * STRIDE + i % MOST_SIDE;
            for (values, value) in block.arrays().into_iter().zip(line) {
                values[place] = value as f32;
            }
        }
    }

    /// The values of [`BlockRays`] for one ray.
    fn line(&self, class: Class, anchor: DVec3, direction: DVec3, pixel: usize) -> [f64; 9] {
        let (a, d) = (class.turned(anchor), class.turned(direction));
        let slope = d.truncate() / d.z;
        let through = a.truncate() - slope * a.z;
        let length = direction.length();
        let depth = length / d.z;
        let z = |t: f64| t / depth + a.z;
        let eye_t = match self.rays.is_point {
            true => -length,
            false => self.rays.eye_depth,
        };
        let unit = direction / length;
        let (mut begin, mut end) = (eye_t, f64::INFINITY);
        for plane in &self.planes {
            let height = plane.truncate().dot(anchor) - plane.w;
            let rise = plane.truncate().dot(unit);
            if rise > 0.0 {
                begin = begin.max(-height / rise);
            } else if rise < 0.0 {
                end = end.min(height / -rise);
            } else if height < 0.0 {
                end = f64::NEG_INFINITY;
            }
        }
        if let Some(ends) = self.ends {
            end = end.min(ends[pixel] / self.normalization.scale + eye_t);
        }
        let [cue, cue_slope] = self.cue.map_or([1.0, 0.0], |ramp| {
            let forward = self.rays.forward;
            let at_anchor = forward.dot(anchor - self.eye());
            let slope = ramp.slope * forward.dot(unit) * depth;
            [ramp.at_eye + ramp.slope * at_anchor - slope * a.z, slope]
        });
        // Normalized space is within 1 of the origin: a hundred is as good as infinite.
        let far = |z: f64| z.clamp(-100.0, 100.0);
        [
            through.x,
            through.y,
            -slope.x,
            -slope.y,
            depth,
            far(z(begin)),
            far(z(end)),
            cue,
            cue_slope,
        ]
    }

    /// A point of the plane in which the eye is.
    fn eye(&self) -> DVec3 {
        match self.rays.is_point {
            true => self.rays.eye,
            false => self.rays.anchor + self.rays.eye_depth * self.rays.forward,
        }
    }
}
