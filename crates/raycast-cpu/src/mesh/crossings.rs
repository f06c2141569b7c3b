//! Where the rays of a block cross the boundary of the mesh.

use fearless_simd::prelude::*;
use tetrascope_core::View;
use tetrascope_core::glam::{DVec2, Vec3};
use tetrascope_f32::Rays;
use tetrascope_f32::tiles::pixels;

use rayon::prelude::*;

use super::packed::{Packed, Vertex};
use super::rays::{BlockRays, STRIDE};
use super::sides::{Corner, Shear, Side, mean, shares};
use crate::simd::{MOST_LANES, PerLane, each, store};

/// A boundary face and the pixels that may see it: columns and rows, from one up to before the
/// other.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenFace {
    pub(super) face: u32,
    pub(super) columns: [u16; 2],
    pub(super) rows: [u16; 2],
}

/// The faces that may be seen, by block of pixels, row by row.
#[derive(Debug)]
pub(super) struct Bins {
    pub(super) side: usize,
    pub(super) across: usize,
    begins: Vec<u32>,
    faces: Vec<SeenFace>,
}

impl Bins {
    /// Sorts the boundary of `mesh` into the blocks of `view`, `side` pixels each; `None` if there
    /// are too many pairs to count in 32 bits.
    pub(super) fn new(mesh: &Packed, view: &View, rays: &Rays, side: usize) -> Option<Bins> {
        let size = DVec2::new(view.width.into(), view.height.into());
        let seen = |(face, corners): (usize, &[u32; 4])| {
            let corners = [0, 1, 2].map(|i| {
                let [x, y, z, _] = mesh.vertices[corners[i] as usize];
                Vec3::new(x, y, z)
            });
            let (min, max) = pixels(rays, &corners, size)?;
            let min = min.ceil().max(DVec2::ZERO);
            let max = (max.floor() + 1.0).min(size);
            min.cmplt(max).all().then_some(SeenFace {
                face: face as u32,
                // Sides are at most 2¹⁶: the last pixel's number fits, and so does the end less 1.
                columns: [min.x as u16, (max.x - 1.0) as u16],
                rows: [min.y as u16, (max.y - 1.0) as u16],
            })
        };
        let boundary = mesh.places.boundary.par_iter().enumerate();
        let seen: Vec<SeenFace> = boundary.filter_map(seen).collect();
        let across = (view.width as usize).div_ceil(side);
        let down = (view.height as usize).div_ceil(side);
        let blocks_of = |face: &SeenFace| {
            let [left, right] = face.columns.map(|c| usize::from(c) / side);
            let [top, bottom] = face.rows.map(|r| usize::from(r) / side);
            (top..=bottom).flat_map(move |y| (left..=right).map(move |x| y * across + x))
        };
        let mut begins = vec![0_u32; across * down + 1];
        let mut total = 0_u32;
        for block in seen.iter().flat_map(blocks_of) {
            begins[block + 1] += 1;
            total = total.checked_add(1)?;
        }
        for block in 1..begins.len() {
            begins[block] += begins[block - 1];
        }
        let mut places = begins.clone();
        let none = SeenFace {
            face: 0,
            columns: [0; 2],
            rows: [0; 2],
        };
        let mut faces = vec![none; total as usize];
        for face in &seen {
            for block in blocks_of(face) {
                faces[places[block] as usize] = *face;
                places[block] += 1;
            }
        }
        Some(Bins {
            side,
            across,
            begins,
            faces,
        })
    }

    /// The faces that the rays of a block may cross.
    pub(super) fn of(&self, block: usize) -> &[SeenFace] {
        &self.faces[self.begins[block] as usize..self.begins[block + 1] as usize]
    }
}

/// A crossing that a ray has taken.
pub(super) const TAKEN: u32 = u32::MAX;

/// Where a ray crosses a boundary face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub(super) z: f32,
    /// The face's number, or [`TAKEN`].
    pub(super) face: u32,
    /// On which side its edges pass.
    pub(super) is_positive: bool,
}

/// The crossings of a block's rays.
#[derive(Debug, Default)]
pub(super) struct Crossings {
    found: Vec<(u32, Crossing)>,
    begins: Vec<u32>,
    sorted: Vec<Crossing>,
}

impl Crossings {
    /// Finds those of the rays in columns and rows, of one class; `vertices` are turned to it.
    #[inline(always)]
    pub(super) fn find<S: Simd>(
        &mut self,
        simd: S,
        boundary: &[[u32; 4]],
        vertices: &[Vertex],
        faces: &[SeenFace],
        rays: &BlockRays,
        [columns, rows]: [[usize; 2]; 2],
    ) {
        let lanes = S::f32s::LEN;
        self.found.clear();
        for seen in faces {
            let ids = boundary[seen.face as usize];
            let corners = each!([0, 1, 2], i => {
                let vertex = vertices[ids[i] as usize];
                each!([0, 1, 2, 3], j => S::f32s::splat(simd, vertex[j]))
            });
            let within = |[first, last]: [u16; 2], [begin, end]: [usize; 2]| {
                let first = usize::from(first).max(begin) - begin;
                first..(usize::from(last) + 1).min(end) - begin
            };
            let across = within(seen.columns, columns);
            for row in within(seen.rows, rows) {
                for column in across.clone().step_by(lanes) {
                    let place = row * STRIDE + column;
                    let places = place..place + lanes;
                    let shear = Shear {
                        through: each!([0, 1], i => {
                            S::f32s::from_slice(simd, &rays.through[i][places.clone()])
                        }),
                        slope: each!([0, 1], i => {
                            S::f32s::from_slice(simd, &rays.slope[i][places.clone()])
                        }),
                    };
                    let [a, b, c] = each!([0, 1, 2], i => shear.corner(corners[i]));
                    let ab = Side::of(&a, &b).untied(simd, &a, &b);
                    let bc = Side::of(&b, &c).untied(simd, &b, &c);
                    let ca = Side::of(&c, &a).untied(simd, &c, &a);
                    let all = ab.is_positive & bc.is_positive & ca.is_positive;
                    let some = ab.is_positive | bc.is_positive | ca.is_positive;
                    // A ray that is not a number is on no side.
                    let is_ray = a.x.simd_eq(a.x);
                    let mut crossed = (all | !some) & is_ray;
                    if !crossed.any_true() {
                        continue;
                    }
                    // No side of a face whose corners the ray sees at one point is positive, either way
                    // round.
                    let differ =
                        |p: &Corner<S>, q: &Corner<S>| !(p.x.simd_eq(q.x) & p.y.simd_eq(q.y));
                    crossed &= differ(&a, &b) | differ(&a, &c);
                    let shares = shares(simd, [&a, &b, &c], [bc.area, ca.area, ab.area]);
                    let z = mean::<S>(shares, [a.z, b.z, c.z]);
                    let mut depths: PerLane<f32> = [0.0; MOST_LANES];
                    store::<S>(z, &mut depths);
                    let positive = all.to_bitmask();
                    let mut left = crossed.to_bitmask();
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        // Whole vectors reach beyond the face's pixels: there it is not crossed
                        // either, or it is found all the same.
                        if column + lane >= across.end {
                            break;
                        }
                        let crossing = Crossing {
                            z: depths[lane],
                            face: seen.face,
                            is_positive: positive >> lane & 1 == 1,
                        };
                        self.found.push(((place + lane) as u32, crossing));
                    }
                }
            }
        }
    }

    /// Sorts them by ray, and along each by (z, face).
    pub(super) fn sort(&mut self, rays: usize) {
        self.begins.clear();
        self.begins.resize(rays + 1, 0);
        for &(ray, _) in &self.found {
            self.begins[ray as usize + 1] += 1;
        }
        for ray in 1..self.begins.len() {
            self.begins[ray] += self.begins[ray - 1];
        }
        let none = Crossing {
            z: 0.0,
            face: TAKEN,
            is_positive: false,
        };
        self.sorted.clear();
        self.sorted.resize(self.found.len(), none);
        // From the last to the first, so that each place ends where its ray's crossings begin.
        for &(ray, crossing) in self.found.iter().rev() {
            let place = &mut self.begins[ray as usize + 1];
            *place -= 1;
            self.sorted[*place as usize] = crossing;
        }
        // Now `begins[ray + 1]` is where the ray begins.
        self.begins.push(self.found.len() as u32);
        for ray in 0..rays {
            let range = self.range(ray);
            let of_ray = &mut self.sorted[range];
            if of_ray.len() > 1 {
                of_ray.sort_unstable_by(|a, b| a.z.total_cmp(&b.z).then(a.face.cmp(&b.face)));
            }
        }
    }

    /// The places of a ray's crossings.
    pub(super) fn range(&self, ray: usize) -> std::ops::Range<usize> {
        self.begins[ray + 1] as usize..self.begins[ray + 2] as usize
    }

    /// All, by ray.
    pub(super) fn sorted(&mut self) -> &mut [Crossing] {
        &mut self.sorted
    }
}
