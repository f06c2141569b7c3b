//! What depends on the mesh's geometry alone: its cells, and the BVH that finds them.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
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
    /// Vertex indices of each cell, increasing, in the order of the BVH's leaves:
    /// faces list their vertices in one order whichever cell asks.
    pub(crate) cells: Vec<[u32; 4]>,
    /// The mesh's index of each of `cells`.
    pub(crate) ids: Vec<u32>,
}

/// Boxes grow by this much, in units in which the mesh is 2 to 4 long: twice the
/// most that rounding a position to f32 moves it (2⁻²⁴ of at most 2).
const PADDING: f32 = 1.0 / (1 << 22) as f32;

impl Geometry {
    pub(crate) fn new(mesh: &TetMesh) -> Geometry {
        let bounds = mesh.bounds();
        let center = bounds.center();
        let half = bounds.size() * 0.5;
        let scale = match half.max_element() {
            0.0 => 1.0, // one point, or nothing
            half => power_of_two(half),
        };
        let boxes: Vec<CellBox> = mesh
            .tetrahedra()
            .iter()
            .map(|cell| CellBox::of(cell.map(|v| (mesh.points()[v as usize] - center) / scale)))
            .collect();
        let bvh = (!boxes.is_empty()).then(|| {
            let params = BvhBuildParams::medium_build(); // slower ones split boxes, which is for triangles
            build_bvh2(&boxes, params, &mut Duration::default())
        });
        let ids = match &bvh {
            Some(bvh) => bvh.primitive_indices.clone(),
            None => Vec::new(),
        };
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
                found(first..first + node.prim_count as usize);
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
        nodes + size_of_val(&self.cells[..]) + size_of_val(&self.ids[..])
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
}

impl obvhs::Boundable for CellBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}
