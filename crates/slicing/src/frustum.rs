//! Which boxes can be in the image, and before all clip planes.

use tetrascope_core::glam::{DVec3, DVec4, Vec3, Vec4};

/// The part of the volume that is seen: where every plane has normal · p + w ≥ 0, lattice space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frustum {
    pub(crate) planes: Vec<Vec4>,
    /// By how much a box is enlarged on each side before it is tested, cells: as much as
    /// its polygons are, so that rounding leaves nothing out.
    pub(crate) margin: Vec3,
}

impl Frustum {
    /// The half-spaces of `planes`.
    pub(crate) fn new(planes: impl IntoIterator<Item = DVec4>, margin: DVec3) -> Frustum {
        // Any positive factor will do; this one keeps the numbers near those of lattices.
        let unit = |plane: DVec4| (plane / plane.truncate().length().max(1e-300)).as_vec4();
        Frustum {
            planes: planes.into_iter().map(unit).collect(),
            margin: margin.as_vec3(),
        }
    }

    /// Whether any of a box may be inside: of each plane, its farthest corner is.
    ///
    /// In f32, as `cull.wgsl` computes it.
    pub(crate) fn shows(&self, low: [usize; 3], size: [usize; 3]) -> bool {
        let low = Vec3::from_array(low.map(|x| x as f32));
        let high = low + Vec3::from_array(size.map(|x| x as f32)) + self.margin;
        let low = low - self.margin;
        self.planes.iter().all(|plane| {
            let normal = plane.truncate();
            let corner = Vec3::select(normal.cmpgt(Vec3::ZERO), high, low);
            normal.dot(corner) + plane.w >= 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_outside_of_any_plane_are_not_seen() {
        let planes = [
            DVec4::new(2.0, 0.0, 0.0, -20.0),  // x ≥ 10
            DVec4::new(0.0, -1.0, -1.0, 12.0), // y + z ≤ 12
        ];
        let frustum = Frustum::new(planes, DVec3::splat(0.5));
        assert!(frustum.shows([6, 0, 0], [4, 4, 4]), "the margin reaches it");
        assert!(!frustum.shows([5, 0, 0], [4, 4, 4]));
        assert!(frustum.shows([12, 6, 6], [4, 4, 4]));
        assert!(!frustum.shows([12, 7, 7], [4, 4, 4]));
        assert!(Frustum::default().shows([0; 3], [1; 3]));
    }
}
