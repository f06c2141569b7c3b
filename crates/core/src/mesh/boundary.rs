//! The shape of a mesh's boundary surface.

use glam::DVec3;

use super::TetMesh;
use super::adjacency::FACES;
use super::orientation::orientation;
use super::sort::sort_by_point;

/// The shape of the boundary surface, in numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BoundaryStatistics {
    /// Triangles.
    pub faces: usize,
    /// Different pairs of places that are a triangle's side.
    pub edges: usize,
    /// Different places of points.
    pub vertices: usize,
    /// Parts that hang together by edges: blocks that do not touch, and hollows.
    pub components: usize,
    /// Vertices − edges + faces: 2 a sphere, 0 a torus, 4 two spheres.
    pub euler_characteristic: i64,
    /// Whether every edge lies between exactly two triangles.
    pub closed: bool,
    /// Whether the mesh is known to be convex, so that every ray enters it once.
    ///
    /// The boundary must be one closed sphere-like surface that turns outward at no
    /// edge by more than the rounding of the coordinates explains (to f32 if all of
    /// them are f32 numbers, else to f64). False when in doubt: with a boundary
    /// triangle without area, and for blocks that only together are convex.
    pub convex: bool,
}

/// A side of a triangle by its places in ascending order, and the triangle.
type EdgeKey = ([u32; 2], u32);

pub(super) fn boundary_statistics(mesh: &TetMesh) -> BoundaryStatistics {
    let triangles: Vec<[u32; 3]> = mesh
        .boundary_faces()
        .iter()
        .map(|&(cell, opposite)| {
            FACES[usize::from(opposite)].map(|corner| mesh.places()[cell as usize][corner])
        })
        .collect();
    let sides = triangles
        .iter()
        .zip(0_u32..)
        .flat_map(|(&[a, b, c], index)| {
            [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], index))
        });
    let sides: Vec<EdgeKey> = sort_by_point(sides, mesh.points().len(), |(edge, _)| edge[0]);

    let surface = Surface::new(mesh, &triangles);
    let mut forest: Vec<u32> = (0..).take(triangles.len()).collect();
    let mut components = triangles.len();
    let (mut edges, mut closed) = (0, true);
    let mut convex = !surface.has_slivers() && mesh.crowded_face_count() == 0;
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        edges += 1;
        closed &= same.len() == 2;
        for pair in same.windows(2) {
            let (a, b) = (root(&mut forest, pair[0].1), root(&mut forest, pair[1].1));
            if a != b {
                forest[b as usize] = a;
                components -= 1;
            }
            convex = convex && !surface.turns_outward(pair[0].1, pair[1].1);
        }
    }
    let mut used = vec![false; mesh.points().len()];
    for &point in triangles.iter().flatten() {
        used[point as usize] = true;
    }
    let vertices = used.iter().filter(|used| **used).count();
    let count = |n: usize| i64::try_from(n).expect("fits: counted in memory");
    let euler_characteristic = count(vertices) - count(edges) + count(triangles.len());
    BoundaryStatistics {
        faces: triangles.len(),
        edges,
        vertices,
        components,
        euler_characteristic,
        closed,
        convex: convex && closed && components == 1 && euler_characteristic == 2,
    }
}

fn root(forest: &mut [u32], mut member: u32) -> u32 {
    while forest[member as usize] != member {
        let parent = forest[member as usize];
        forest[member as usize] = forest[parent as usize];
        member = parent;
    }
    member
}

struct Surface<'a> {
    points: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    /// How far rounding may have moved a point.
    displacement: f64,
}

impl Surface<'_> {
    fn new<'a>(mesh: &'a TetMesh, triangles: &'a [[u32; 3]]) -> Surface<'a> {
        let points = mesh.points();
        let is_f32 = |p: &DVec3| p.as_vec3().as_dvec3() == *p;
        let single = triangles
            .iter()
            .flatten()
            .all(|&p| is_f32(&points[p as usize]));
        let epsilon = if single {
            f64::from(f32::EPSILON)
        } else {
            f64::EPSILON
        };
        // Each of three coordinates is rounded by at most half a unit in its last
        // place, ε/2 of its magnitude.
        let bounds = mesh.bounds();
        let displacement = if bounds.is_empty() {
            0.0
        } else {
            0.5 * epsilon * bounds.min.abs().max(bounds.max.abs()).length()
        };
        Surface {
            points,
            triangles,
            displacement,
        }
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|p| self.points[p as usize])
    }

    /// Whether a triangle is so thin that rounding may have turned it: its double area
    /// changes by up to the displacement times its circumference.
    fn has_slivers(&self) -> bool {
        (0..).take(self.triangles.len()).any(|triangle| {
            let [a, b, c] = self.corners(triangle);
            let circumference = (b - a).length() + (c - b).length() + (a - c).length();
            double_area([a, b, c]) <= self.displacement * circumference
        })
    }

    /// Whether the surface is re-entrant at the edge between two triangles.
    fn turns_outward(&self, triangle: u32, neighbor: u32) -> bool {
        let [a, b, c] = self.corners(triangle);
        let shared = self.triangles[triangle as usize];
        let Some(&far) = self.triangles[neighbor as usize]
            .iter()
            .find(|p| !shared.contains(p))
        else {
            return true; // Two triangles back to back: a surface without inside.
        };
        let d = self.points[far as usize];
        // Six times the volume between them: positive where `d` lies outside.
        let height = orientation([a, b, c, d]).determinant;
        // Moving each corner by the displacement changes that, to first order, by no
        // more than the double areas of the faces opposite the corners.
        let faces = [[a, b, c], [a, b, d], [b, c, d], [c, a, d]];
        let slack = self.displacement * faces.map(double_area).iter().sum::<f64>();
        if height.abs() > slack {
            return height > 0.0;
        }
        // In one plane: flat, or folded back onto itself?
        let [e, f, g] = self.corners(neighbor);
        (b - a).cross(c - a).dot((f - e).cross(g - e)) < 0.0
    }
}

fn double_area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length()
}
