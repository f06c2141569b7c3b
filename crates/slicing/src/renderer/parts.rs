//! What lasts between frames, made of a volume and an appearance.

use std::sync::Arc;

use tetrascope_core::appearance::ClipPlane;
use tetrascope_core::glam::Vec4;
use tetrascope_core::grid::{Lattice, SampleType};
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{ANY_SCALAR, deepest};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::BufferUsages;

use super::{Samples, Scene};
use crate::cull::CullData;
use crate::frame::longest_slab;
use crate::options::{SlicingOptions, Traversal};
use crate::slice::{Look, SlicePass};
use crate::voxels::{Scale, Texels, Voxels};

/// What a [`Scene`] is made with.
pub(super) struct Parts<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) options: &'a SlicingOptions,
    pub(super) pass: &'a SlicePass,
}

impl Parts<'_> {
    /// What is drawn of `volume`; `before` is a scene of the same volume, whose samples on
    /// the device may serve again.
    pub(super) fn scene(
        &self,
        appearance: &Appearance,
        volume: Arc<Samples>,
        before: Option<&Scene>,
    ) -> Result<Scene, Error> {
        let (gpu, options) = (self.gpu, self.options);
        let tf = &appearance.transfer_function;
        let table = volume.octree.table(appearance);
        let visibility = volume.octree.visibility(&table);
        let (sample_type, range) = (volume.source.sample_type(), volume.domain.scalar_range);
        let texels = Texels::of(gpu, sample_type, options.filtering);
        let (scale, mut map) = Scale::of(texels, sample_type, appearance, range);
        let floats = sample_type == SampleType::F32;
        let serves = |s: &&Scene| {
            let suits = !floats || s.map.suits_appearance(appearance, range);
            suits && s.voxels.least_level() == 0
        };
        let voxels = match before.filter(serves) {
            Some(before) => {
                if floats {
                    map = before.map;
                }
                before.voxels.clone()
            }
            None => {
                let (source, octree, reach) = (&*volume.source, &volume.octree, volume.reach);
                let voxels = Voxels::new(gpu, source, octree, &visibility, map, reach, options)?;
                Arc::new(voxels)
            }
        };
        let by_gpu = options.traversal == Traversal::Gpu && voxels.is_complete();
        let cull = by_gpu.then(|| CullData::new(gpu, &volume.octree, table, &voxels));
        let knots = knot_pairs(tf, &map, &volume.normalization)?;
        let (lattice, slices) = (&volume.lattice, options.slices_per_voxel);
        let longest = longest_slab(lattice, &volume.normalization, slices);
        let scalars = range.map_or(ANY_SCALAR, |range| map.range(Some(range)));
        let deepest = deepest(&knots, scalars, longest);
        let knots = gpu.upload("the transfer function", &knots, BufferUsages::STORAGE)?;
        let look = Look {
            intervals: &knots,
            appearance,
            deepest,
            gaps: volume.octree.gaps,
            nearest: volume.fills_cells,
        };
        let slice = self.pass.data(gpu, &voxels, &look, options)?;
        Ok(Scene {
            scale,
            appearance: appearance.clone(),
            kept: clip_planes(&appearance.clip_planes, &volume.lattice),
            intervals: knots,
            volume,
            map,
            visibility,
            voxels,
            cull: cull.transpose()?,
            slice,
        })
    }
}

/// What planes keep of the lattice: n · p + d ≥ 0.
fn clip_planes(planes: &[ClipPlane], lattice: &Lattice) -> Vec<Vec4> {
    let of = |plane: &ClipPlane| {
        let normal = plane.normal.normalize();
        let in_lattice = lattice.linear().transpose() * normal;
        let offset = normal.dot(lattice.origin - plane.point);
        // Any positive factor will do; this one keeps the numbers near 1.
        let factor = in_lattice.length().recip();
        (in_lattice * factor).extend(offset * factor).as_vec4()
    };
    planes.iter().map(of).collect()
}
