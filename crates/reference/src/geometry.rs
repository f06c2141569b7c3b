//! The data that depend on the mesh's geometry alone: its cells, and the BVH that finds them.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;
use tetrascope_core::TetMesh;
use tetrascope_core::glam::{DVec3, Vec3A};

use crate::predicate::power_of_two;

/// Cells and their BVH. Immutable once built.
pub(crate) struct Geometry {
    /// `None` without cells.
    bvh: Option<Bvh2>,
    /// The box's center, world space, and the world units in one unit of BVH space.
    pub(crate) center: DVec3,
    pub(crate) scale: f64,
    /// A bound on the distance of vertices from `center`, world units.
    pub(crate) radius: f64,
    /// Where the cells of each of the BVH's boxes begin in `cells`, and their number.
    starts: Vec<u32>,
    /// Vertex indices of each cell, increasing, in the order of the BVH's leaves:
    /// faces list their vertices in one order whichever cell asks.
    pub(crate) cells: Vec<[u32; 4]>,
    /// The mesh's index of each of `cells`.
    pub(crate) ids: Vec<u32>,
}

/// Boxes grow by this much, in units in which the mesh is 2 to 4 long: twice the
/// most that rounding a position to f32 moves it (2⁻²⁴ of at most 2).
const PADDING: f32 = 1.0 / (1 << 22) as f32;

/// And by up to this share of themselves.
const LOOSE: f32 = 1.0 / 256.0;

impl Geometry {
    pub(crate) fn new(mesh: &TetMesh) -> Geometry {
        let bounds = mesh.bounds();
        let center = bounds.center();
        let half = bounds.size() * 0.5;
        let scale = match half.max_element() {
            0.0 => 1.0, // one point, or nothing
            half => power_of_two(half),
        };
        // The builder joins pairs of boxes that are nearest to each other, and finds a single
        // pair at a time among boxes that are all equal: quadratic. They are where one point
        // lies so far from the others that these coincide in f32. Equal boxes are one to it.
        let mut boxes: Vec<(CellBox, u32)> = mesh
            .tetrahedra()
            .par_iter()
            .zip(0_u32..u32::MAX)
            .map(|(cell, id)| {
                let vertices = cell.map(|v| (mesh.points()[v as usize] - center) / scale);
                (CellBox::of(vertices), id)
            })
            .collect();
        boxes.par_sort_unstable_by_key(|(cell_box, id)| (cell_box.bits(), *id));
        let groups: Vec<&[(CellBox, u32)]> = boxes
            .chunk_by(|(a, _), (b, _)| a.bits() == b.bits())
            .collect();
        let bvh = (!groups.is_empty()).then(|| {
            let boxes = groups.iter().zip(0_u64..);
            let boxes: Vec<CellBox> = boxes
                .map(|(group, number)| group[0].0.loosened(number))
                .collect();
            let params = BvhBuildParams::medium_build(); // slower ones split boxes, which is for triangles
            build_bvh2(&boxes, params, &mut Duration::default())
        });
        let (mut starts, mut ids) = (vec![0], Vec::with_capacity(boxes.len()));
        for &group in bvh.iter().flat_map(|bvh| &bvh.primitive_indices) {
            ids.extend(groups[group as usize].iter().map(|&(_, id)| id));
            starts.push(ids.len() as u32);
        }
        let cells = ids
            .iter()
            .map(|&id| {
                let mut cell = mesh.tetrahedra()[id as usize];
                cell.sort_unstable();
                cell
            })
            .collect();
        Geometry {
            bvh,
            center,
            scale,
            // Rounding of `half` and of the length: a few ulp.
            radius: half.length() * (1.0 + 8.0 * f64::EPSILON),
            starts,
            cells,
            ids,
        }
    }

    /// Calls `found` with ranges of `cells` that hold every cell on the inner
    /// side of all `planes`, and others nearby.
    pub(crate) fn visit(
        &self,
        planes: &[Plane; 5],
        stack: &mut Vec<u32>,
        mut found: impl FnMut(std::ops::Range<usize>),
    ) {
        let Some(bvh) = &self.bvh else { return };
        stack.clear();
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &bvh.nodes[index as usize];
            let (min, max) = (node.aabb.min.as_dvec3(), node.aabb.max.as_dvec3());
            if planes.iter().any(|plane| plane.is_outside(min, max)) {
                continue;
            }
            if node.prim_count > 0 {
                let first = node.first_index as usize;
                let end = first + node.prim_count as usize;
                found(self.starts[first] as usize..self.starts[end] as usize);
            } else {
                stack.push(node.first_index + 1);
                stack.push(node.first_index);
            }
        }
    }

    /// A plane of BVH space; `normal` is in world space and points inward, and
    /// `offset` is the value at `through`, world units.
    pub(crate) fn plane(&self, normal: DVec3, through: DVec3, offset: f64) -> Plane {
        let inward = (self.center - through) / self.scale;
        let distance = inward.dot(normal) + offset / self.scale;
        // Rounding of the terms above and of `is_outside`: fewer than 16 operations.
        let margin = 32.0
            * f64::EPSILON
            * normal.abs().max_element()
            * (inward.abs().max_element() + (offset / self.scale).abs() + 4.0);
        Plane {
            normal,
            distance: distance + margin,
        }
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let nodes = self.bvh.as_ref().map_or(0, |bvh| {
            size_of_val(&bvh.nodes[..]) + size_of_val(&bvh.primitive_indices[..])
        });
        let starts = size_of_val(&self.starts[..]);
        nodes + starts + size_of_val(&self.cells[..]) + size_of_val(&self.ids[..])
    }
}

/// A half-space of BVH space, inside where normal · p + distance ≥ 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    normal: DVec3,
    distance: f64,
}

impl Plane {
    /// Whether the whole box lies outside.
    fn is_outside(&self, min: DVec3, max: DVec3) -> bool {
        let corner = DVec3::select(self.normal.cmpge(DVec3::ZERO), max, min);
        self.normal.dot(corner) + self.distance < 0.0
    }
}

/// The padded box of a cell in BVH space.
#[derive(Clone, Copy)]
struct CellBox(Aabb);

impl CellBox {
    fn of(vertices: [DVec3; 4]) -> CellBox {
        let vertices = vertices.map(|v| v.as_vec3a());
        let min = vertices.iter().fold(Vec3A::INFINITY, |m, v| m.min(*v));
        let max = vertices.iter().fold(Vec3A::NEG_INFINITY, |m, v| m.max(*v));
        CellBox(Aabb::new(
            min - Vec3A::splat(PADDING),
            max + Vec3A::splat(PADDING),
        ))
    }

    /// Larger by a share of `LOOSE` and of `PADDING` that follows from `number`.
    ///
    /// In a row of boxes that are alike, or of which each is larger than the one before, each has the
    /// same neighbor in common with the next: one pair a pass, too. So no two are quite alike.
    fn loosened(self, number: u64) -> CellBox {
        // The high bits of a product with 2⁶⁴ / the golden ratio, as in Knuth's multiplicative hashing.
        let share = (number.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1 << 24) as f32;
        let CellBox(Aabb { min, max, .. }) = self;
        let by = ((max - min) * LOOSE + Vec3A::splat(PADDING)) * share;
        CellBox(Aabb::new(min - by, max + by))
    }

    /// In which no two boxes that differ are the same.
    fn bits(&self) -> [[u32; 3]; 2] {
        [self.0.min, self.0.max].map(|corner| corner.to_array().map(f32::to_bits))
    }
}

impl obvhs::Boundable for CellBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Scalars;
    use tetrascope_core::mesh::Association;

    use super::*;

    /// Tetrahedra of unit size around the points of a lattice, and one that reaches to `far`.
    fn lattice_and(far: f64) -> TetMesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| 0.9 * p);
        let mut points = Vec::new();
        for i in 0..4096 {
            let at = [i % 16, i / 16 % 16, i / 256].map(f64::from);
            points.extend(corners.map(|corner| DVec3::from_array(at) + corner));
        }
        points[4] = DVec3::splat(far);
        let cells = (0..4096).map(|i| [0, 1, 2, 3].map(|corner| 4 * i + corner));
        mesh(points, cells.collect())
    }

    fn mesh(points: Vec<DVec3>, cells: Vec<[u32; 4]>) -> TetMesh {
        let scalars = Scalars {
            name: "zero".into(),
            association: Association::Point,
            values: vec![0.0; points.len()],
        };
        TetMesh::from_tetrahedra(points, cells, scalars).expect("a mesh")
    }

    #[test]
    fn one_point_far_from_all_others_does_not_make_building_quadratic() {
        for exponent in 2..40 {
            let geometry = Geometry::new(&lattice_and(10_f64.powi(exponent)));
            let bvh = geometry.bvh.as_ref().expect("there are cells");
            // The builder's passes over all boxes, at least 96 as it counts. One per cell
            // would be 4 096.
            assert!(bvh.max_depth < 200, "1e{exponent}: {}", bvh.max_depth);
            let mut ids = geometry.ids.clone();
            ids.sort_unstable();
            assert!(ids.into_iter().eq(0..4096), "1e{exponent}");
            assert_eq!(geometry.starts.last(), Some(&4096));
        }
    }

    /// Tetrahedra in a row along x, each this many times as large as the one before.
    fn row(count: u32, growth: f64) -> TetMesh {
        let (mut points, mut at, mut size) = (Vec::new(), 0.0, 1.0);
        for _ in 0..count {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
            points.extend(corners.map(|corner| corner * size + at * DVec3::X));
            at += size;
            size *= growth;
        }
        let cells = (0..count).map(|i| [0, 1, 2, 3].map(|corner| 4 * i + corner));
        mesh(points, cells.collect())
    }

    #[test]
    fn cells_in_a_row_do_not_make_building_quadratic() {
        for (growth, most) in [(1.0, 200), (1.0001, 200), (1.001, 1000)] {
            let geometry = Geometry::new(&row(4096, growth));
            let bvh = geometry.bvh.as_ref().expect("there are cells");
            // Half of the cells were it a pair a pass.
            assert!(bvh.max_depth < most, "{growth}: {}", bvh.max_depth);
        }
    }
}
