//! The camera in the volume's lattice, made in f64 and rounded at the end.

use tetrascope_core::glam::{DAffine3, DVec3, DVec4};
use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, View};
use tetrascope_f32::{ImagePlane, Normalization};

use crate::box_plane::front_corner;
use crate::frustum::Frustum;
use crate::gpu_data;
use crate::octree::Viewer;

/// The near plane, in normalized units, as in cell projection: below f32's resolution of
/// the volume.
const NEAR: f32 = 1.0 / (1 << 22) as f32;

/// The most slabs of a frame; their numbers are exact in f32, and their polygons' index
/// buffer has 48 MiB.
const MAX_SLABS: f64 = (1 << 20) as f64;

/// With more slabs, rays are looked at to do with fewer.
const MANY_SLABS: f64 = (1 << 12) as f64;

/// Whether a frame may have so many slabs that rays are looked at to do with fewer.
fn may_have_many(lattice: &Lattice, slices_per_voxel: f64) -> bool {
    let cells = DVec3::from_array(lattice.cells().map(|c| c as f64));
    let diagonal = (cells * lattice.spacing).length();
    diagonal * slices_per_voxel / lattice.spacing.min_element() > MANY_SLABS
}

/// The greatest length of a ray in a slab, normalized.
pub(crate) fn longest_slab(
    lattice: &Lattice,
    normalization: &Normalization,
    slices_per_voxel: f64,
) -> f32 {
    let spacing = lattice.spacing / normalization.scale;
    let longest = match may_have_many(lattice, slices_per_voxel) {
        // With fewer slabs a ray advances by that share of a cell along each axis at most.
        true => spacing.length(),
        false => spacing.min_element(),
    };
    (longest / slices_per_voxel) as f32
}

/// The geometry of a frame.
#[derive(Clone, Debug)]
pub(crate) struct FrameGeometry {
    /// Everything but what depends on boxes and samples.
    uniform: gpu_data::CameraUniform,
    pub(crate) viewer: Viewer,
    /// The part of space in front of the eye and inside of the image.
    pub(crate) frustum: Frustum,
    /// From normalized to camera space.
    pub(crate) camera: DAffine3,
    /// From the eye to the anchor along the axis, normalized.
    pub(crate) anchor_depth: f64,
    /// How far a box is enlarged on each side, cells.
    margin: DVec3,
    /// The optical axis, normalized units per cell along each axis.
    forward: DVec3,
    step: f64,
    /// Fragments of one cell of the volume, about: slabs that cross it times pixels.
    pub(crate) fragments_per_cell: f64,
}

/// The geometry for `view`, which must be valid; `None` if no part of the volume is in
/// front of the eye.
///
/// [`Error::Invalid`] for more slabs than a frame has at most.
pub(crate) fn geometry(
    view: &View,
    lattice: &Lattice,
    normalization: &Normalization,
    slices_per_voxel: f64,
) -> Result<Option<FrameGeometry>, Error> {
    let plane = ImagePlane::new(view, normalization);
    let ImagePlane {
        anchor_depth,
        extent,
        slope,
        reach,
        is_perspective,
        ..
    } = plane;
    let camera = plane.camera_from_normalized();
    let linear = camera.matrix3 * lattice.linear() * normalization.scale.recip();
    let shift = camera.matrix3 * (normalization.point(lattice.origin) - plane.anchor);
    let inverse = linear.inverse();
    // The ray at (x, y) is origin + x … + y … + depth (along + x … + y …).
    let origin = inverse * -shift;
    let origins = [inverse.x_axis * extent[0], inverse.y_axis * extent[1]];
    let along = inverse.z_axis;
    let alongs = [inverse.x_axis * slope[0], inverse.y_axis * slope[1]];

    let cells = DVec3::from_array(lattice.cells().map(|c| c as f64));
    let axis = DVec3::new(linear.x_axis.z, linear.y_axis.z, linear.z_axis.z);
    // The depths of the nearest and the farthest corner.
    let depths = |low: DVec3, size: DVec3| {
        let (a, b) = (axis * low, axis * (low + size));
        (
            a.min(b).element_sum() + shift.z,
            a.max(b).element_sum() + shift.z,
        )
    };
    let (nearest, farthest) = depths(DVec3::ZERO, cells);
    let first = nearest.max(-anchor_depth);
    if farthest <= first {
        return Ok(None);
    }
    // Rays are longest between planes in the image's corners.
    let longest = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
    let spacing = lattice.spacing.min_element() / normalization.scale;
    let deep = (farthest - first) * slices_per_voxel;
    let mut count = deep * longest / spacing;
    // What rays advance along each axis of the lattice where their depth grows by 1.
    let fastest = along.abs() + alongs[0].abs() + alongs[1].abs();
    if count > MANY_SLABS && may_have_many(lattice, slices_per_voxel) {
        // Samples may be near each other along an axis that no ray follows.
        count = count.min(deep * fastest.max_element());
    }
    let count = count.ceil().max(1.0);
    if count.is_nan() || count > MAX_SLABS {
        return Err(Error::Invalid {
            what: format!(
                "{slices_per_voxel} slices per voxel are {count:.3e} slices, of which {MAX_SLABS} \
                 are drawn at most"
            ),
            help: Some(
                "give fewer slices per voxel, a narrower angle of view, or look along the axis \
                 along which samples are nearest"
                    .into(),
            ),
        });
    }
    let step = (farthest - first) / count;

    // A slab's part in a box is seen where its middle plane cuts the box enlarged by what
    // a ray advances in half a step. The rest is for rounding: the rasterizer's, and that of
    // coordinates, a few 2⁻²⁴ of the volume. Rasterizers move a vertex to a place between
    // pixels, of which Vulkan promises 2⁴ along each axis (`subPixelPrecisionBits` is 4 or
    // more; llvmpipe has 8, SwiftShader 4): by a 16th of a pixel at most, where half of that
    // would be the nearest. Twice that is taken, as a pixel's own size is rounded too.
    let pixel = |i: usize, pixels: u32| {
        let deep = origins[i].abs() + farthest.abs().max(first.abs()) * alongs[i].abs();
        deep * (2.0 / f64::from(pixels))
    };
    let pixels = pixel(0, view.width) + pixel(1, view.height);
    let rounding = pixels / 8.0 + cells.max_element() * 1e-6 + 1e-4;
    let margin = 0.5 * step * fastest + rounding;

    // Camera space from lattice space, and clip space's w.
    let rows = [0, 1, 2].map(|i| linear.row(i).extend(shift[i]));
    let in_front = rows[2] + DVec4::W * anchor_depth;
    let w = if is_perspective { in_front } else { DVec4::W };
    let sides = [0, 1].map(|i| [w * reach[i] - rows[i], w * reach[i] + rows[i]]);
    let seen = sides.into_iter().flatten().chain([in_front]);

    let row = |i: usize| {
        let row = linear.row(i);
        [row.x as f32, row.y as f32, row.z as f32, shift[i] as f32]
    };
    let vector = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
    let pair = |pair: [f64; 2]| pair.map(|x| x as f32);
    let eye_in_lattice = inverse * (DVec3::new(0.0, 0.0, -anchor_depth) - shift);
    // Pixels per normalized unit in the middle of the volume.
    let middle = if is_perspective {
        (0.5 * (first + farthest) + anchor_depth).max(step)
    } else {
        1.0
    };
    let density = f64::from(view.height) / (2.0 * reach[1] * middle);
    let cell_volume = linear.determinant().abs();
    Ok(Some(FrameGeometry {
        uniform: gpu_data::CameraUniform {
            right: row(0),
            up: row(1),
            forward: row(2),
            origin: vector(origin),
            origin_x: vector(origins[0]),
            origin_y: vector(origins[1]),
            along: vector(along),
            along_x: vector(alongs[0]),
            along_y: vector(alongs[1]),
            cells: vector(cells),
            box_size: [0.0; 4],
            margin: vector(margin),
            inverse_spacing: vector(normalization.scale / lattice.spacing),
            slope: pair(slope),
            clip_per_unit: pair(reach.map(f64::recip)),
            size: [view.width as f32, view.height as f32],
            anchor_depth: anchor_depth as f32,
            w_per_depth: f32::from(is_perspective),
            w_constant: f32::from(!is_perspective),
            // Orthographic: anything between 0 and w, as nothing is to be clipped.
            near: if is_perspective { NEAR } else { 0.5 },
            first_depth: first as f32,
            step: step as f32,
            slab_count: count as i32,
            slabs_per_box: 0,
            front: front_corner(axis.as_vec3()),
            scalar_unit: 1.0,
            scalar_base: 0.0,
            raw_unit: 1.0,
            raw_base: 0.0,
            raw_most: f32::MAX,
            slabs_per_run: 0,
            run_count: 0,
            padding: [0; 2],
        },
        viewer: if is_perspective {
            // Rounded as on the device, for the same order there.
            Viewer::Eye(eye_in_lattice.as_vec3().as_dvec3())
        } else {
            Viewer::Direction(along.as_vec3().as_dvec3())
        },
        frustum: Frustum::new(seen, margin),
        camera,
        anchor_depth,
        margin,
        forward: axis,
        step,
        fragments_per_cell: cell_volume / step * density * density,
    }))
}

impl FrameGeometry {
    /// How many slabs there are.
    pub(crate) fn slabs(&self) -> u32 {
        self.uniform.slab_count as u32
    }

    /// Planes that may cut a box of this size, in cells.
    pub(crate) fn slabs_per_box(&self, size: [usize; 3]) -> u32 {
        let size = DVec3::from_array(size.map(|s| s as f64)) + 2.0 * self.margin;
        // One more, as both ends may lie on a plane, and one for rounding.
        ((self.forward.abs() * size).element_sum() / self.step) as u32 + 2
    }

    /// Fragments of a box of this size, about.
    pub(crate) fn fragments_per_box(&self, size: [usize; 3]) -> f64 {
        let size = DVec3::from_array(size.map(|s| s as f64)) + 2.0 * self.margin;
        size.element_product() * self.fragments_per_cell
    }

    /// The uniform for boxes of this size, in cells.
    pub(crate) fn uniform(&self, size: [usize; 3]) -> gpu_data::CameraUniform {
        let [x, y, z] = size.map(|s| s as f32);
        gpu_data::CameraUniform {
            box_size: [x, y, z, 0.0],
            slabs_per_box: self.slabs_per_box(size),
            ..self.uniform
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DMat3;
    use tetrascope_core::grid::Interpolation;
    use tetrascope_core::{Camera, CameraFit};

    use super::*;

    /// With many slabs, one may be longer than the least spacing; none is longer than the bound.
    #[test]
    fn no_slab_is_longer_than_the_bound() {
        let mut longer = 0;
        for (side, spacing) in [
            (100, DVec3::ONE),
            (100, DVec3::new(1.0, 1.0, 0.01)),
            (20, DVec3::new(1.0, 2.0, 3.0)),
        ] {
            let lattice = Lattice {
                dims: [side; 3],
                origin: DVec3::ZERO,
                spacing,
                direction: DMat3::IDENTITY,
                interpolation: Interpolation::Linear,
            };
            let normalization = Normalization::of(&lattice.bounds());
            for slices in [0.5, 2.0, 60.0] {
                let bound = f64::from(longest_slab(&lattice, &normalization, slices));
                let least = spacing.min_element() / normalization.scale / slices;
                for (name, from) in CameraFit::ALL {
                    for orthographic in [false, true] {
                        let view = View {
                            camera: Camera::fit(&lattice.bounds(), from, orthographic, 1.0),
                            width: 8,
                            height: 8,
                            background: [0.0; 4],
                        };
                        let slope = ImagePlane::new(&view, &normalization).slope;
                        let frame = geometry(&view, &lattice, &normalization, slices);
                        let frame = frame.expect("few slabs").expect("seen");
                        let stretch = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                        let longest = frame.step * stretch;
                        assert!(longest <= bound * (1.0 + 1e-6), "{name} {slices} {spacing}");
                        longer += u32::from(longest > least * (1.0 + 1e-6));
                    }
                }
            }
        }
        assert!(longer > 0);
    }
}
