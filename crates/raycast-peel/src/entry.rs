//! Where rays meet the boundary: a hierarchy of boxes over the boundary faces.
//!
//! View-independent, so it is built once a mesh. Nodes are in depth-first order
//! and know the place of the next node beyond their subtree: a traversal that
//! wants every face on a ray needs no stack.

use std::time::Duration;

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use tetrascope_core::glam::{Vec3, Vec3A};

use crate::gpu_data::Node;

/// Faces a leaf holds at most. Larger leaves test more faces, smaller ones more
/// boxes; three bits hold the count.
const MAX_LEAF_FACES: u32 = 4;

/// How far boxes reach beyond their faces, normalized units.
///
/// The traversal shears a box as it shears vertices: a difference, a product by a
/// slope of at most 1 and a sum, of numbers below 4 (vertices lie within 1 of the
/// center, anchors within 2). Each of these rounds by at most 2⁻²⁴ · 4, in the box
/// and in the vertex: 6 · 2⁻²² < 2⁻¹⁹.
const PADDING: f32 = 1.0 / (1 << 19) as f32;

/// Boxes over faces, and the order of faces that goes with them.
#[derive(Debug)]
pub(crate) struct Entry {
    /// Depth-first.
    pub(crate) nodes: Vec<Node>,
    /// The face at each place of the leaves.
    pub(crate) face_order: Vec<u32>,
}

impl Entry {
    /// Boxes over `faces`, corners in normalized units.
    pub(crate) fn new(faces: &[[Vec3; 3]]) -> Entry {
        let mut entry = Entry {
            nodes: Vec::new(),
            face_order: Vec::new(),
        };
        if faces.is_empty() {
            return entry;
        }
        let faces: Vec<Face> = faces.iter().map(|&corners| Face(corners)).collect();
        let params = BvhBuildParams {
            max_prims_per_leaf: MAX_LEAF_FACES,
            ..BvhBuildParams::medium_build()
        };
        let bvh = build_bvh2(&faces, params, &mut Duration::default());
        entry.flatten(&bvh);
        entry
    }

    /// Depth-first, with an explicit stack as hierarchies can be deep.
    fn flatten(&mut self, bvh: &Bvh2) {
        // A visited node is on the stack a second time, to learn where its subtree ends.
        enum Step {
            Visit(u32),
            Close(usize),
        }
        let mut stack = vec![Step::Visit(0)];
        while let Some(step) = stack.pop() {
            match step {
                Step::Visit(index) => {
                    let node = &bvh.nodes[index as usize];
                    let place = self.nodes.len();
                    let first = self.face_order.len() as u32;
                    self.nodes.push(Node {
                        low: (Vec3::from(node.aabb.min) - PADDING).to_array(),
                        skip: 0,
                        high: (Vec3::from(node.aabb.max) + PADDING).to_array(),
                        faces: first << 3 | node.prim_count,
                    });
                    stack.push(Step::Close(place));
                    if node.prim_count > 0 {
                        let from = node.first_index as usize;
                        let faces = &bvh.primitive_indices[from..from + node.prim_count as usize];
                        self.face_order.extend_from_slice(faces);
                    } else {
                        stack.push(Step::Visit(node.first_index + 1));
                        stack.push(Step::Visit(node.first_index));
                    }
                }
                Step::Close(place) => self.nodes[place].skip = self.nodes.len() as u32,
            }
        }
    }
}

struct Face([Vec3; 3]);

impl Boundable for Face {
    fn aabb(&self) -> Aabb {
        let [a, b, c] = self.0.map(Vec3A::from);
        Aabb::new(a.min(b).min(c), a.max(b).max(c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_is_in_one_leaf_and_in_all_boxes_above_it() {
        let faces: Vec<[Vec3; 3]> = (0..200)
            .map(|i| {
                let x = i as f32 * 0.01 - 1.0;
                [
                    Vec3::new(x, 0.0, 0.0),
                    Vec3::new(x, 0.1, 0.3),
                    Vec3::new(x + 0.05, 0.0, 0.0),
                ]
            })
            .collect();
        let entry = Entry::new(&faces);
        let mut seen = entry.face_order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..200).collect::<Vec<u32>>());
        // Whatever leaf a face is in, a traversal that follows all boxes around
        // its first corner reaches it.
        for (place, &face) in entry.face_order.iter().enumerate() {
            let corner = faces[face as usize][0];
            let mut at = 0;
            let mut reached = false;
            while at < entry.nodes.len() {
                let node = &entry.nodes[at];
                let inside = Vec3::from(node.low).cmple(corner).all()
                    && Vec3::from(node.high).cmpge(corner).all();
                let (first, count) = (node.faces >> 3, node.faces & 7);
                reached |= inside && (first..first + count).contains(&(place as u32));
                at = if inside { at + 1 } else { node.skip as usize };
            }
            assert!(reached, "face {face}");
        }
    }

    #[test]
    fn an_empty_mesh_has_no_node() {
        assert!(Entry::new(&[]).nodes.is_empty());
    }
}
