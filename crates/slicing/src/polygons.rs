//! Polygons cut on the CPU, each frame: what the vertex program makes unnecessary (§3).

use tetrascope_core::Error;
use tetrascope_core::glam::Vec3;

use crate::box_plane::{SlicedBox, VertexProgram};
use crate::gpu_data::{CameraUniform, Corner};
use crate::options::PlaneTest;

/// Polygons of a frame, back to front.
#[derive(Debug, Default)]
pub(crate) struct Polygons {
    /// Three to six a polygon.
    pub(crate) corners: Vec<Corner>,
    /// Triangles.
    pub(crate) indices: Vec<u32>,
    /// How many indices there are up to the end of each box.
    pub(crate) ends: Vec<u32>,
}

impl Polygons {
    /// The cuts of the slabs' planes with boxes, by their least corners; both as `frame`
    /// has them.
    ///
    /// [`Error::TooLarge`] for more than `limit` bytes of corners or of indices.
    pub(crate) fn cut(
        frame: &CameraUniform,
        test: PlaneTest,
        boxes: impl Iterator<Item = [usize; 3]>,
        limit: u64,
    ) -> Result<Polygons, Error> {
        let vector = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]);
        let program = VertexProgram::new(vector(frame.forward), test);
        let margin = vector(frame.margin);
        let size = vector(frame.box_size) + 2.0 * margin;
        let mut polygons = Polygons::default();
        for (number, low) in (0..).zip(boxes) {
            let low = Vec3::from_array(low.map(|x| x as f32)) - margin;
            let corners = program.corners(&SlicedBox { low, size });
            // The plane of slab k is at first_depth + (k + ½) step.
            let slab =
                |height: f32| (height + frame.forward[3] - frame.first_depth) / frame.step - 0.5;
            let [near, far] = corners.range();
            let first = (slab(near).ceil() as i32).max(0);
            let last = (slab(far).floor() as i32).min(frame.slab_count - 1);
            for slab in (first..=last).rev() {
                let depth = frame.first_depth + (slab as f32 + 0.5) * frame.step;
                let polygon = program.polygon(&corners, depth - frame.forward[3]);
                polygons.add(&polygon, slab, number);
            }
            let bytes = size_of_val(&polygons.corners[..]).max(size_of_val(&polygons.indices[..]));
            if bytes as u64 > limit {
                return Err(Error::TooLarge {
                    what: "polygons cut on the CPU".into(),
                    needed: bytes as u64,
                    limit,
                    unit: "bytes in one buffer",
                });
            }
            polygons.ends.push(polygons.indices.len() as u32);
        }
        Ok(polygons)
    }

    /// The bytes that are sent to the device.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(&self.corners[..]) + size_of_val(&self.indices[..])) as u64
    }

    /// A polygon as a fan, without the duplicates and without corners that are undefined.
    fn add(&mut self, polygon: &[Option<Vec3>], slab: i32, box_index: u32) {
        let base = self.corners.len();
        for place in polygon.iter().flatten() {
            let corner = Corner {
                place: place.to_array(),
                slab,
                box_index,
            };
            if self.corners[base..].last() != Some(&corner) {
                self.corners.push(corner);
            }
        }
        let base = base as u32;
        for end in base + 2..self.corners.len() as u32 {
            self.indices.extend([base, end - 1, end]);
        }
    }
}
