//! Clip planes, depth cue and isosurfaces in f32, as `common/look.wgsl` reads them.

use tetrascope_core::Unit as _;
use tetrascope_core::appearance::Isosurface;
use tetrascope_core::appearance::MAX_CLIP_PLANES;
use tetrascope_core::glam::{DAffine3, DVec3};
use tetrascope_core::{Appearance, Bounds, View};

use crate::normalization::{Normalization, ScalarMap, color};

/// The mirror of the shaders' `Look`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Look {
    planes: [[f32; 4]; MAX_CLIP_PLANES],
    cue: [f32; 4],
    plane_count: u32,
    surface_count: u32,
    light_count: u32,
    ambient: f32,
    table_span: [f32; 4],
    interval_count: u32,
    unused: [u32; 3],
}

impl Look {
    /// The same with what programs need to know of the transfer function's so many intervals and
    /// of the table with these ends (`table_span` in `axes.wgsl`).
    pub fn with_tables(self, interval_count: usize, table_span: [f32; 4]) -> Look {
        Look {
            table_span,
            interval_count: interval_count as u32,
            ..self
        }
    }
}

/// The ends of a table's axes as shaders have them: scalars from `low` to `high`, lengths up to
/// `length`.
pub fn table_span((low, high): (f32, f32), length: f32) -> [f32; 4] {
    [low, high, 1.0 / (high - low).max(1e-30), length.max(1e-30)]
}

/// The isosurfaces of `appearance` in the order in which shaders have them: by value, so
/// that a shader finds the nearest by bisection. Of equal values the first alone is left, as
/// it hides the others.
pub fn surfaces(appearance: &Appearance) -> Vec<Isosurface> {
    let mut surfaces = appearance.isosurfaces.clone();
    surfaces.sort_by(|a, b| a.value.total_cmp(&b.value));
    surfaces.dedup_by(|next, first| next.value == first.value);
    surfaces
}

/// The input of `look.wgsl` in the space of the program: the uniform and the items.
///
/// `space` takes normalized positions there; it moves and turns, but keeps lengths.
/// `bounds` are the volume's, over which a depth cue spans.
pub fn look(
    appearance: &Appearance,
    view: &View,
    bounds: &Bounds,
    normalization: &Normalization,
    map: &ScalarMap,
    space: &DAffine3,
) -> (Look, Vec<[f32; 4]>) {
    let (_, _, forward) = view.camera.axes();
    let single = |v: DVec3, w: f64| v.extend(w).as_vec4().to_array();
    let turned = |v: DVec3| space.transform_vector3(v);
    let mut planes = [[0.0; 4]; MAX_CLIP_PLANES];
    for (slot, plane) in planes.iter_mut().zip(&appearance.clip_planes) {
        let normal = turned(plane.normal.unit());
        let point = space.transform_point3(normalization.point(plane.point));
        *slot = single(normal, -normal.dot(point));
    }
    let cue = appearance.depth_cue.map_or([0.0, 0.0, 0.0, 1.0], |cue| {
        let ramp = cue.ramp(view.camera.position, forward, bounds);
        let slope = ramp.slope * normalization.scale;
        let axis = turned(forward);
        let eye = space.transform_point3(normalization.point(view.camera.position));
        single(slope * axis, ramp.at_eye - slope * axis.dot(eye))
    });
    let surfaces = surfaces(appearance);
    let surface_count = surfaces.len() as u32;
    let surfaces = surfaces.into_iter().map(|surface| {
        let [r, g, b] = color(surface.color).to_array();
        [r, g, b, map.scalar(surface.value)]
    });
    let lights = appearance.lighting.resolved(forward);
    let lit = lights
        .iter()
        .flat_map(|light| [single(turned(light.toward), 0.0), single(light.color, 0.0)]);
    let uniform = Look {
        planes,
        cue,
        plane_count: appearance.clip_planes.len() as u32,
        surface_count,
        light_count: lights.len() as u32,
        ambient: appearance.lighting.ambient as f32,
        table_span: table_span((0.0, 1.0), 1.0),
        interval_count: 0,
        unused: [0; 3],
    };
    (uniform, surfaces.chain(lit).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_has_the_layout_of_its_twin() {
        use tetrascope_shaders::{assert_layout, raycast_peel::MARCH};
        assert_layout!(
            MARCH,
            Look {
                planes,
                cue,
                plane_count,
                surface_count,
                light_count,
                ambient,
                table_span,
                interval_count
            }
        );
    }
}
