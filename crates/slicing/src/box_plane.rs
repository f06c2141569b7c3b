//! Box against plane: the tables of the vertex program, and the program on the CPU.
//!
//! Corners of a box are numbered by bits: bit 0 is set at the far end of x, bit 1 of y,
//! bit 2 of z. *Roles* number them as Figure 3 does: role 0 is the corner nearest to the
//! eye, 7 the one opposite; 1, 2, 3 are neighbors of 0, and 4 lies between 1 and 3,
//! 5 between 2 and 1, 6 between 3 and 2. Three independent paths go from front to back,
//! 0→1→4→7, 0→2→5→7 and 0→3→6→7; the remaining ("dotted") edges are 1→5, 2→6, 3→4.

use tetrascope_core::glam::Vec3;

use crate::PlaneTest;

/// The most corners of a box cut by a plane.
pub const POLYGON: usize = 6;

/// Edges that one corner of the polygon tries.
pub const TRIES: usize = 4;

/// Which corner of the box plays each role, for each front corner: the published
/// program's `nSequence[64]`.
///
/// Roles 1, 2, 3 are role 0's neighbors in the order in which every path's three edges
/// make a right-handed system (§4), beginning with x.
pub fn sequence() -> [[u32; 8]; 8] {
    let mut table = [[0; 8]; 8];
    for (front, row) in table.iter_mut().enumerate() {
        let front = front as u32;
        // An edge points along its axis, or against it where the front corner is at the
        // far end. The first path runs along the axes of roles 1, 3, 2, whose vectors
        // are right-handed if (x, y, z) is and an even number of them is reversed.
        let even = front.count_ones().is_multiple_of(2);
        let (x, y, z) = (1, 2, 4);
        let (a, b, c) = if even { (x, z, y) } else { (x, y, z) };
        *row = [0, a, b, c, a | c, b | a, c | b, 7].map(|bits| front ^ bits);
    }
    table
}

/// The edges that each corner of the polygon tries in turn, as roles: the published
/// program's `v1[24]` and `v2[24]`.
///
/// Corners 0, 2, 4 walk the paths (the last entry is never reached and repeats the one
/// before); corners 1, 3, 5 try a dotted edge and then the path before it.
pub fn edges() -> [[[u32; 2]; TRIES]; POLYGON] {
    let paths = [[0, 1, 4, 7], [0, 2, 5, 7], [0, 3, 6, 7]];
    let dotted = [[1, 5], [2, 6], [3, 4]];
    let mut table = [[[0; 2]; TRIES]; POLYGON];
    for (i, (path, dotted)) in paths.into_iter().zip(dotted).enumerate() {
        let steps = [0, 1, 2].map(|k| [path[k], path[k + 1]]);
        table[2 * i] = [steps[0], steps[1], steps[2], steps[2]];
        table[2 * i + 1] = [dotted, steps[0], steps[1], steps[2]];
    }
    table
}

/// The corner of a box that a plane with this normal, swept along it, touches first.
///
/// With ties, as in views along an axis, any of the first corners will do (§4); this
/// takes the near one.
pub fn front_corner(normal: Vec3) -> u32 {
    u32::from(normal.x < 0.0) | u32::from(normal.y < 0.0) << 1 | u32::from(normal.z < 0.0) << 2
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicedBox {
    /// The least corner.
    pub low: Vec3,
    /// The edge lengths.
    pub size: Vec3,
}

impl SlicedBox {
    /// The corner with these bits.
    pub fn corner(&self, bits: u32) -> Vec3 {
        let pick = |axis: usize| (bits >> axis & 1) as f32;
        self.low + Vec3::new(pick(0), pick(1), pick(2)) * self.size
    }
}

/// The vertex program for planes of one direction, on the CPU.
#[derive(Clone, Debug)]
pub struct VertexProgram {
    normal: Vec3,
    test: PlaneTest,
    /// The edges that each corner of a polygon tries in turn, as corners of the box.
    edges: [[[u32; 2]; TRIES]; POLYGON],
}

/// The corners of a box, by their bits, and normal · x at each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners {
    places: [Vec3; 8],
    heights: [f32; 8],
}

impl Corners {
    /// The least and the greatest normal · x.
    pub fn range(&self) -> [f32; 2] {
        let heights = self.heights.iter().copied();
        [
            heights.clone().fold(f32::INFINITY, f32::min),
            heights.fold(f32::NEG_INFINITY, f32::max),
        ]
    }
}

impl VertexProgram {
    /// For planes normal · x = offset.
    pub fn new(normal: Vec3, test: PlaneTest) -> VertexProgram {
        let roles = sequence()[front_corner(normal) as usize];
        let corners = |edge: [u32; 2]| edge.map(|role| roles[role as usize]);
        VertexProgram {
            normal,
            test,
            edges: edges().map(|tries| tries.map(corners)),
        }
    }

    /// The values that all planes through `cut` share.
    pub fn corners(&self, cut: &SlicedBox) -> Corners {
        let places = [0, 1, 2, 3, 4, 5, 6, 7].map(|bits| cut.corner(bits));
        Corners {
            heights: places.map(|place| place.dot(self.normal)),
            places,
        }
    }

    /// The polygon in which the plane normal · x = `offset` cuts a box, counterclockwise
    /// as seen by an eye that looks along `normal`; duplicates fill up to six corners.
    ///
    /// In f32, as `vs_slice` computes it. `None` in place of a corner is a position that
    /// the program leaves undefined: always where the plane misses the box, and with
    /// [`PlaneTest::Published`] also where rounding hides the edge that is cut. `offset`
    /// and `normal · x` are in the unit of `normal` times the box's.
    pub fn polygon(&self, corners: &Corners, offset: f32) -> [Option<Vec3>; POLYGON] {
        self.edges.map(|tries| {
            tries.iter().find_map(|edge| {
                let [from, to] = edge.map(|bits| corners.places[bits as usize]);
                let [h, k] = edge.map(|bits| corners.heights[bits as usize]);
                let lambda = match self.test {
                    PlaneTest::Published => self.published(to - from, offset - h),
                    PlaneTest::Sides => sides(h, k, offset),
                };
                lambda.map(|lambda| from + lambda * (to - from))
            })
        })
    }

    /// Listing 1, lines 41 to 45: λ, if the edge is cut. `ahead` is how far before the
    /// plane the edge begins.
    fn published(&self, along: Vec3, ahead: f32) -> Option<f32> {
        let slope = along.dot(self.normal);
        let lambda = if slope != 0.0 { ahead / slope } else { -1.0 };
        (0.0..=1.0).contains(&lambda).then_some(lambda)
    }
}

/// λ, if the ends of the edge, at heights `h` and `k`, lie on different sides.
///
/// A path begins on one side and ends on the other, so one of its edges is cut, whatever
/// rounding does to the heights.
fn sides(h: f32, k: f32, offset: f32) -> Option<f32> {
    let before = |height: f32| height < offset;
    (before(h) != before(k)).then(|| ((offset - h) / (k - h)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests;
