//! The boundary faces that the rays of each tile may meet.
//!
//! A superset, found anew for each view: whether a ray crosses a face is decided in
//! `walk.wgsl`. A hierarchy of boxes that each ray searched by itself was tried
//! first; on llvmpipe (Mesa 22.3.6), whose lanes run in step, it took four fifths of a frame: the
//! Blunt Fin at 512x512 took 9.6 s of CPU with it and takes 2.7 s with these lists, loading
//! included. Layers as Bernardon et al. 2004 peel them are slower, too.

use tetrascope_core::Unit as _;
use tetrascope_core::View;
use tetrascope_core::glam::{DVec2, DVec3, Vec3};

use crate::Rays;

/// Pixels along each side of a tile and of a work group, as in `march.wgsl`.
pub const TILE: u32 = 8;

/// How far a vertex may be, for a ray in f32, from where it is, in normalized units.
///
/// `corner` in `walk.wgsl` takes a difference, a product by a slope of at most 1 and
/// a sum, of numbers below 4 (vertices lie within 1 of the center, anchors within 2);
/// each rounds by at most 2⁻²⁴ · 4. So do the anchor and the direction: 6 · 2⁻²² < 2⁻¹⁹.
const BLUR: f64 = 1.0 / (1 << 19) as f64;

/// Faces by tile, row by row: those of tile i are `lists[lists[i]..lists[i + 1]]`.
///
/// One list with its own index at the front, as a shader has few bindings.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiles {
    /// Where the list of each tile begins, where the last ends, and the lists.
    pub lists: Vec<u32>,
}

/// A rectangle of tiles, both ends included.
#[derive(Clone, Copy)]
struct Rectangle {
    first: [u32; 2],
    last: [u32; 2],
}

impl Tiles {
    /// Sorts `faces`, corners in normalized units, into the tiles of `view`.
    ///
    /// `None` if there are too many pairs of tile and face to count in 32 bits.
    pub fn new(view: &View, rays: &Rays, faces: &[[Vec3; 3]]) -> Option<Tiles> {
        let columns = view.width.div_ceil(TILE);
        let rows = view.height.div_ceil(TILE);
        let rectangles: Vec<Option<Rectangle>> = faces
            .iter()
            .map(|corners| rectangle(rays, corners, [columns, rows]))
            .collect();
        let tiles_of = |r: &Rectangle| {
            let [x0, y0] = r.first;
            let [x1, y1] = r.last;
            (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| (y * columns + x) as usize))
        };
        let count = (columns * rows) as usize;
        let mut lists = vec![0u32; count + 1];
        lists[0] = count as u32 + 1;
        let mut total = lists[0];
        for rectangle in rectangles.iter().flatten() {
            for tile in tiles_of(rectangle) {
                lists[tile + 1] += 1;
                total = total.checked_add(1)?;
            }
        }
        for tile in 0..count {
            lists[tile + 1] += lists[tile];
        }
        let mut places = lists.clone();
        lists.resize(total as usize, 0);
        for (face, rectangle) in (0..).zip(&rectangles) {
            for tile in rectangle.iter().flat_map(tiles_of) {
                lists[places[tile] as usize] = face;
                places[tile] += 1;
            }
        }
        Some(Tiles { lists })
    }
}

/// Entries below one inner entry of a tree.
const BRANCHES: usize = 8;

/// In place of a face in an inner entry, `NO_FACE` of `boundary.wgsl`.
const INNER: u32 = u32::MAX;

/// A face and the depths between which rays may cross it.
#[derive(Clone, Copy)]
struct Deep {
    near: f32,
    far: f32,
    face: u32,
}

impl Tiles {
    /// The same lists as trees of depths, for searches that look at a few of many faces.
    ///
    /// A tree is in preorder, four words an entry: the least and the greatest depth of what is
    /// below it, the place in `lists` behind all that, and a face, or `u32::MAX` in an inner
    /// entry. Faces are by increasing least depth. `None` if there is too much to count in 32 bits.
    pub fn trees(&self, view: &View, rays: &Rays, faces: &[[Vec3; 3]]) -> Option<Tiles> {
        let (x, y) = (f64::from(view.width), f64::from(view.height));
        let corners = [(0.0, 0.0), (x, 0.0), (0.0, y), (x, y)];
        let anchors = corners.map(|(x, y)| rays.anchor + x * rays.anchor_x + y * rays.anchor_y);
        let farthest = anchors.iter().fold(0.0, |f: f64, a| f.max(a.length()));
        // As `BLUR`, where numbers may be larger: t is measured from an anchor.
        let blur = BLUR * (4.0 + farthest);
        let depths: Vec<[f32; 2]> = faces
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| rays.depth(corner.as_dvec3()));
                let near = a.min(b).min(c) - blur;
                let far = a.max(b).max(c) + blur;
                [(near as f32).next_down(), (far as f32).next_up()]
            })
            .collect();
        let count = *self.lists.first()? as usize - 1;
        let mut lists = vec![0; count + 1];
        let mut deep = Vec::new();
        for tile in 0..count {
            lists[tile] = u32::try_from(lists.len()).ok()?;
            let [begin, end] = [0, 1].map(|i| self.lists[tile + i] as usize);
            deep.clear();
            deep.extend(self.lists[begin..end].iter().map(|&face| {
                let [near, far] = depths[face as usize];
                Deep { near, far, face }
            }));
            deep.sort_unstable_by(|a, b| a.near.total_cmp(&b.near).then(a.face.cmp(&b.face)));
            grow(&deep, &mut lists);
        }
        lists[count] = u32::try_from(lists.len()).ok()?;
        Some(Tiles { lists })
    }
}

/// Adds the tree of `faces` to `lists`.
fn grow(faces: &[Deep], lists: &mut Vec<u32>) {
    let mut part = 1;
    while part * BRANCHES < faces.len() {
        part *= BRANCHES;
    }
    for below in faces.chunks(part) {
        let place = lists.len();
        let far = below
            .iter()
            .fold(f32::NEG_INFINITY, |far, d| far.max(d.far));
        let face = if part == 1 { below[0].face } else { INNER };
        lists.extend([below[0].near.to_bits(), far.to_bits(), 0, face]);
        if part > 1 {
            grow(below, lists);
        }
        // A place beyond 32 bits is refused where the tile ends.
        lists[place + 2] = lists.len() as u32;
    }
}

/// The tiles whose rays may meet a face; `None` if it is beside the image.
fn rectangle(rays: &Rays, corners: &[Vec3; 3], [columns, rows]: [u32; 2]) -> Option<Rectangle> {
    let tile = f64::from(TILE);
    let size = DVec2::new(f64::from(columns), f64::from(rows)) * tile;
    let (min, max) = pixels(rays, corners, size)?;
    let clamp = |p: DVec2| {
        let p = (p / tile).floor().max(DVec2::ZERO);
        [(p.x as u32).min(columns - 1), (p.y as u32).min(rows - 1)]
    };
    Some(Rectangle {
        first: clamp(min),
        last: clamp(max),
    })
}

/// The pixels that may see each of `faces`: left, bottom, right and top in clip space,
/// all 0 where there are none.
pub fn rectangles(view: &View, rays: &Rays, faces: &[[Vec3; 3]]) -> Vec<[f32; 4]> {
    let size = DVec2::new(view.width.into(), view.height.into());
    let rectangle = |face| {
        let (min, max) = pixels(rays, face, size)?;
        // Whole pixels, whose centers are at whole numbers here.
        let min = min.ceil().max(DVec2::ZERO);
        let max = (max.floor() + 1.0).min(size);
        let is_seen = min.cmplt(max).all();
        let [min, max] = [min, max].map(|p| 2.0 * p / size - 1.0);
        is_seen.then(|| [min.x, -max.y, max.x, -min.y].map(|x| x as f32))
    };
    faces
        .iter()
        .map(|face| rectangle(face).unwrap_or_default())
        .collect()
}

/// The least and the greatest pixel, with centers at whole numbers, whose rays may meet a face
/// in an image of `size`; `None` if it is beside the image.
///
/// A ray is a whole line here, behind the eye too: a path through the eye begins there.
pub fn pixels(rays: &Rays, corners: &[Vec3; 3], size: DVec2) -> Option<(DVec2, DVec2)> {
    let seen = corners.map(|corner| rays.pixel(corner.as_dvec3()));
    // How many times larger than at the anchors a length is seen, with its sign.
    let [a, b, c] = seen.map(|(_, magnification)| magnification);
    let finite = seen
        .iter()
        .all(|(pixel, m)| pixel.is_finite() && m.is_finite());
    let one_side = (a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0);
    if !(finite && one_side) {
        return Some((DVec2::ZERO, size)); // it reaches through the eye's plane
    }
    let [p, q, r] = seen.map(|(pixel, _)| pixel);
    let nearest = a.abs().max(b.abs()).max(c.abs());
    let margin = DVec2::splat(0.01 + BLUR * nearest / rays.anchor_x.length());
    let (min, max) = (p.min(q).min(r) - margin, p.max(q).max(r) + margin);
    if max.cmplt(DVec2::ZERO).any() || min.cmpgt(size).any() {
        return None;
    }
    Some((min, max))
}

impl Rays {
    /// Where a point is seen, pixels with centers at whole numbers, and how many
    /// times larger than at the anchors; negative behind the eye.
    fn pixel(&self, point: DVec3) -> (DVec2, f64) {
        let across = |p: DVec3| {
            let pixel = self.anchor_x.length_squared();
            DVec2::new(p.dot(self.anchor_x), p.dot(self.anchor_y)) / pixel
        };
        if !self.is_point {
            return (across(point - self.anchor), 1.0);
        }
        // The anchors' plane is at −eye_depth from the eye.
        let axis = self.anchor_y.cross(self.anchor_x).unit();
        let forward = axis * (self.anchor - self.eye).dot(axis).signum();
        let from_eye = point - self.eye;
        let magnification = -self.eye_depth / from_eye.dot(forward);
        let on_plane = self.eye + from_eye * magnification;
        (across(on_plane - self.anchor), magnification)
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::{Bounds, Camera, CameraFit};

    use super::*;
    use crate::Normalization;

    impl Tiles {
        fn faces(&self) -> &[u32] {
            &self.lists[self.lists[0] as usize..]
        }
    }

    /// Every face is listed in the tile through which its center is seen.
    #[test]
    fn faces_are_where_they_are_seen() {
        let bounds = Bounds {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
        let normalization = Normalization::of(&bounds);
        for orthographic in [false, true] {
            let camera = Camera::fit(&bounds, CameraFit::PlusIso, orthographic, 1.5);
            let view = View {
                camera,
                width: 90,
                height: 60,
                background: [0.0; 4],
            };
            let rays = Rays::new(&view, &normalization);
            for row in [0, 29, 59] {
                for column in [0, 44, 89] {
                    let ray = view.ray(column, row);
                    let center = ray.at(3.0);
                    let near = normalization.point(center).as_vec3();
                    let face = [near, near + 1e-4 * Vec3::X, near + 1e-4 * Vec3::Y];
                    let tiles = Tiles::new(&view, &rays, &[face]).expect("few");
                    let tile = (row / TILE * view.width.div_ceil(TILE) + column / TILE) as usize;
                    let [start, end] = [0, 1].map(|i| tiles.lists[tile + i]);
                    assert!(start < end, "{column} {row}");
                    assert!(tiles.faces().len() <= 4, "{column} {row}: {tiles:?}");
                }
            }
        }
    }

    #[test]
    fn a_face_through_the_eyes_plane_is_everywhere_and_one_beside_the_image_nowhere() {
        let bounds = Bounds {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
        let camera = Camera::fit(&bounds, CameraFit::PlusX, false, 1.0);
        let view = View {
            camera,
            width: 64,
            height: 64,
            background: [0.0; 4],
        };
        let rays = Rays::new(&view, &Normalization::of(&bounds));
        let through = [Vec3::ZERO, Vec3::X * 100.0, Vec3::Y];
        assert_eq!(
            Tiles::new(&view, &rays, &[through])
                .expect("few")
                .faces()
                .len(),
            64
        );
        let beside = [Vec3::Y * 50.0, Vec3::Y * 51.0, Vec3::new(0.0, 50.0, 1.0)];
        assert_eq!(
            Tiles::new(&view, &rays, &[beside])
                .expect("few")
                .faces()
                .len(),
            0
        );
    }
}
