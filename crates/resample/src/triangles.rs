//! A tetrahedron as it is seen: a fan of triangles between its outline and a vertex inside. The
//! mirror of `triangles.wgsl`, for tests and to count.
//!
//! The signed areas of the four faces, as seen, say everything: times the corners opposite to
//! them they add up to 0 (Radon's theorem), so the corners with positive and those with negative
//! areas have one point in common, which is the vertex inside. One part is in front of the other.
//!
//! | class | areas | seen is | triangles |
//! |---|---|---|---|
//! | 1 | one sign against three | a corner inside of the triangle of the others | 3 |
//! | 2 | two against two | two edges that cross | 4 |
//! | 3 | one against two, and a 0 | a corner on an edge: a face edge on | 2 |
//! | 4 | one against one, and two 0 | a corner in front of another: an edge end on | 1 |
//!
//! Classes 3 and 4 are drawn as class 1, where triangles without area cover nothing.

use tetrascope_core::glam::{Vec2, Vec4, Vec4Swizzles as _};

/// The mirror of `Fan` in `triangles.wgsl`, where each field is explained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fan {
    pub(crate) center: Vec2,
    /// Depth and scalar.
    pub(crate) front: Vec2,
    pub(crate) back: Vec2,
    /// 3 or 4 corners, counterclockwise.
    pub(crate) outline: [usize; 4],
    pub(crate) sides: usize,
    pub(crate) triangles: u32,
}

/// As in `triangles.wgsl`.
const FLAT: f32 = 1.0 / (1 << 22) as f32;

/// The fan of four points (x, y, depth, scalar); `None` for a cell without volume.
pub(crate) fn fan_of(p: [Vec4; 4]) -> Option<Fan> {
    let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let shares: [f32; 4] = std::array::from_fn(|i| {
        let (left, right) = products(faces[i].map(|corner| p[corner]));
        if i % 2 == 0 {
            left - right
        } else {
            right - left
        }
    });
    let above: Vec<usize> = (0..4).filter(|i| shares[*i] > 0.0).collect();
    let below: Vec<usize> = (0..4).filter(|i| shares[*i] < 0.0).collect();
    let (one, other, center, outline, sides) = match (&above[..], &below[..]) {
        ([], _) | (_, []) => return None,
        ([lone], _) | (_, [lone]) => {
            // One corner is inside of the three others' triangle, or on its edge or corner.
            let at = Vec4::from((p[*lone].xy(), Vec2::ZERO));
            let [x, y, z] = faces[*lone];
            let (left, right) = products([p[x], p[y], p[z]]);
            let [second, third] = if left > right { [y, z] } else { [z, y] };
            let other = mean_where_crossed([p[x] - at, p[y] - at, p[z] - at]);
            let outline = [x, second, third, 0];
            (p[*lone].zw(), other, p[*lone].xy(), outline, 3)
        }
        (&[a, b], &[c, d]) => {
            // Two edges cross. The point is taken on the shorter one, and the place on the longer
            // from it.
            let first = p[b].xy() - p[a].xy();
            let second = p[d].xy() - p[c].xy();
            let is_first = first.length_squared() <= second.length_squared();
            let ([on, to], [from, far]) = if is_first {
                ([a, b], [c, d])
            } else {
                ([c, d], [a, b])
            };
            let share = shares[to] / (shares[on] + shares[to]);
            let point = p[on] + share.clamp(0.0, 1.0) * (p[to] - p[on]);
            let edge = p[far].xy() - p[from].xy();
            let along = (point.xy() - p[from].xy()).dot(edge) / edge.length_squared().max(1e-37);
            let other = p[from] + along.clamp(0.0, 1.0) * (p[far] - p[from]);
            let is_left = first.x * second.y > first.y * second.x;
            let [c, d] = if is_left { [c, d] } else { [d, c] };
            (point.zw(), other.zw(), point.xy(), [a, c, b, d], 4)
        }
        _ => unreachable!("two above and two below at most are left"),
    };
    let depths = p.map(|p| p.z);
    let least = depths.into_iter().fold(f32::INFINITY, f32::min);
    let greatest = depths.into_iter().fold(f32::NEG_INFINITY, f32::max);
    if (one.x - other.x).abs() <= FLAT * (greatest - least) {
        return None;
    }
    let (front, back) = if one.x < other.x {
        (one, other)
    } else {
        (other, one)
    };
    let triangles = match sides {
        3 => above.len() + below.len() - 1,
        _ => 4,
    };
    Some(Fan {
        center,
        front,
        back,
        outline,
        sides,
        triangles: triangles as u32,
    })
}

/// Two products whose difference is twice the area as seen, positive if counterclockwise. As they
/// are compared its sign is the same wherever products are rounded to nearest.
fn products([a, b, c]: [Vec4; 3]) -> (f32, f32) {
    let (ab, ac) = (b.xy() - a.xy(), c.xy() - a.xy());
    (ab.x * ac.y, ab.y * ac.x)
}

/// As in `sides.wgsl`.
fn mean_where_crossed([a, b, c]: [Vec4; 3]) -> Vec2 {
    let (ab, ac) = (b - a, c - a);
    let area = ab.x * ac.y - ab.y * ac.x;
    if area.abs() < 1e-37 {
        return a.zw() + (ab.zw() + ac.zw()) / 3.0;
    }
    let x = Vec2::new(-ac.y, ab.y) / area;
    let y = Vec2::new(ac.x, -ab.x) / area;
    let rough = a.x * x + a.y * y;
    let left = a.xy() + rough.x * ab.xy() + rough.y * ac.xy();
    let share = (rough + left.x * x + left.y * y).max(Vec2::ZERO);
    a.zw() + share.x * ab.zw() + share.y * ac.zw()
}

#[cfg(test)]
mod tests;
