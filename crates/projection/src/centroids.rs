//! The order of centroids on the CPU, as `order.wgsl` and the radix sort of
//! tetrascope-gpu have it on the device.
//!
//! Software adapters run compute passes by the lane and wait between them; there, two
//! rounds over an array are cheaper.

use std::sync::Arc;

use tetrascope_core::glam::Vec3;

use crate::frame::KEY_BITS;
use crate::gpu_data::CameraUniform;
use crate::mesh::Geometry;

/// Bits of a digit: two rounds sort a key, and the counts of one stay in a cache of
/// 32 KiB.
const DIGIT_BITS: u32 = KEY_BITS / 2;

/// The part of the sorter that does not depend on the view.
#[derive(Debug)]
pub(crate) struct Centroids {
    /// Centers of all of the mesh's cells, normalized.
    centers: Arc<[Vec3]>,
    /// The cells that are drawn, by index.
    cells: Arc<[u32]>,
}

impl Centroids {
    pub(crate) fn new(geometry: &Geometry, cells: Arc<[u32]>) -> Centroids {
        let center = |cell: usize| {
            let points = geometry.mesh.cell_points(cell);
            let [p0, p1, p2, p3] = points.map(|p| geometry.normalization.point(p));
            (0.25 * (p0 + p1 + p2 + p3)).as_vec3()
        };
        let all = || (0..geometry.mesh.cell_count()).map(center).collect();
        Centroids {
            centers: geometry.centers.get_or_init(all).clone(),
            cells,
        }
    }

    /// The cells back to front; cells with equal keys keep their order.
    pub(crate) fn sorted(&self, frame: &CameraUniform) -> Vec<u32> {
        let rows = [frame.right, frame.up, frame.forward];
        let key = |center: &Vec3| {
            let [x, y, z] = rows.map(|[a, b, c, d]| Vec3::new(a, b, c).dot(*center) + d);
            let mut near = z;
            if frame.w_per_depth > 0.0 {
                near = 2.0 * frame.anchor_depth * z + (x * x + y * y + z * z);
            }
            let key = (frame.far_key - near) * frame.key_scale;
            key.clamp(0.0, ((1_u32 << KEY_BITS) - 1) as f32) as u32
        };
        let keyed = |cell: &u32| (key(&self.centers[*cell as usize]), *cell);
        let pairs: Vec<(u32, u32)> = self.cells.iter().map(keyed).collect();
        let mut half = vec![(0, 0); pairs.len()];
        by_digit(&pairs, 0, |place, pair| half[place] = pair);
        let mut cells = vec![0; pairs.len()];
        by_digit(&half, DIGIT_BITS, |place, (_, cell)| cells[place] = cell);
        cells
    }
}

/// Gives `put` each pair and its place among all, ordered by the digit of their keys (the
/// first of each) that begins at bit `shift`; equal digits keep their order.
fn by_digit(pairs: &[(u32, u32)], shift: u32, mut put: impl FnMut(usize, (u32, u32))) {
    let digit = |key: u32| ((key >> shift) & ((1 << DIGIT_BITS) - 1)) as usize;
    let mut places = [0_usize; 1 << DIGIT_BITS];
    for (key, _) in pairs {
        places[digit(*key)] += 1;
    }
    let mut before = 0;
    for place in &mut places {
        before += std::mem::replace(place, before);
    }
    for pair in pairs {
        let place = &mut places[digit(pair.0)];
        put(*place, *pair);
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Camera, CameraFit, View};
    use tetrascope_f32::{Domain, ImagePlane};
    use tetrascope_testing as testing;

    use super::*;
    use crate::frame::frame;

    #[test]
    fn cells_come_by_the_distance_of_their_centroids() {
        let Some(gpu) = testing::gpu("cells_come_by_the_distance_of_their_centroids") else {
            return;
        };
        let mesh = testing::data_set("torus", Some(3000));
        let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
        let cells: Arc<[u32]> = (0..mesh.cell_count() as u32)
            .filter(|c| c % 3 != 1)
            .collect();
        let centroids = Centroids::new(&geometry, cells.clone());
        for (name, side) in CameraFit::ALL {
            for orthographic in [false, true] {
                let view = View {
                    camera: Camera::fit(&mesh.bounds(), side, orthographic, 1.0),
                    width: 8,
                    height: 8,
                    background: [0.0; 4],
                };
                let normalization = &geometry.normalization;
                let plane = ImagePlane::new(&view, normalization);
                let sorted = centroids.sorted(&frame(&plane, (8, 8), 0, false));
                let mut all = sorted.clone();
                all.sort_unstable();
                assert_eq!(all, &*cells, "{name}: each once");
                let eye = normalization.point(view.camera.position);
                let forward = view.camera.axes().2;
                let distance = |cell: u32| {
                    let points = mesh
                        .cell_points(cell as usize)
                        .map(|p| normalization.point(p));
                    let center = points.iter().sum::<DVec3>() / 4.0 - eye;
                    match orthographic {
                        true => center.dot(forward),
                        false => center.length(),
                    }
                };
                // A key is a 2^24th of a range of some 8 mesh sizes squared, and f32 adds
                // as much; over twice a distance of at least 1.
                for pair in sorted.windows(2) {
                    let [far, near] = [distance(pair[0]), distance(pair[1])];
                    assert!(far >= near - 4e-6, "{name} {orthographic}: {far} {near}");
                }
            }
        }
    }
}
