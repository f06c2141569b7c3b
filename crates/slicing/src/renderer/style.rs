//! The parts that `restyle` changes: an appearance, and what a volume needs to be drawn with it.

use std::sync::Arc;
use tetrascope_core::Unit as _;

use tetrascope_core::appearance::ClipPlane;
use tetrascope_core::glam::Vec4;
use tetrascope_core::grid::{Lattice, SampleType};
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{ANY_SCALAR, ScalarMap, deepest, is_transparent};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::device_grid::Texels::Covered;
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages};

use crate::cull::CullData;
use crate::frame::longest_slab;
use crate::octree::Visibility;
use crate::options::{SlicingOptions, Traversal};
use crate::samples::Samples;
use crate::slice::{Look, SliceData, SlicePass};
use crate::table::Tables;
use crate::texels::{Scale, Texels};
use crate::voxels::Voxels;

/// All that `reload` and `restyle` replace, at once or not at all.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    pub(super) volume: Arc<Samples>,
    pub(super) map: ScalarMap,
    pub(super) scale: Scale,
    /// Whether anything can show, for all that the range of all scalars says.
    pub(super) shows: bool,
    /// Which boxes can show; `None` where only the device knows.
    pub(super) visibility: Option<Visibility>,
    pub(super) voxels: Arc<Voxels>,
    /// Where the GPU traverses and all that can show is on it.
    pub(super) cull: Option<CullData>,
    /// Where rays look for the boxes that the CPU knows.
    pub(super) tables: Tables,
    pub(super) intervals: wgpu::Buffer,
    /// Clip planes, normal · p + w ≥ 0 in lattice space.
    pub(super) kept: Vec<Vec4>,
    pub(super) slice: SliceData,
}

/// Inputs of a [`Style`].
pub(super) struct Parts<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) options: &'a SlicingOptions,
    pub(super) pass: &'a SlicePass,
}

impl Parts<'_> {
    /// The style in which `volume` is drawn; `before` is one of the same volume, whose samples on
    /// the device may serve again.
    pub(super) fn style(
        &self,
        appearance: &Appearance,
        volume: Arc<Samples>,
        before: Option<&Style>,
    ) -> Result<Style, Error> {
        let (gpu, options) = (self.gpu, self.options);
        let tf = &appearance.transfer_function;
        let model = appearance.optical_model;
        let range = volume.domain.scalar_range;
        let known = volume.source().map(|(source, octree)| {
            let table = octree.table(appearance);
            let visibility = octree.visibility(&table);
            (source, octree, table, visibility)
        });
        let (scale, map, voxels, table, visibility) = match known {
            None => {
                let grid = volume.device_grid().expect("what is no source is there");
                if grid.texels() == Covered {
                    options.check_coverage(model)?;
                }
                let (scale, map) = Scale::on_device(appearance, range);
                (
                    scale,
                    map,
                    Arc::new(Voxels::on_device(grid, model)),
                    None,
                    None,
                )
            }
            Some((source, octree, table, visibility)) => {
                let sample_type = source.sample_type();
                let texels = Texels::of(gpu, sample_type, options.filtering);
                let (scale, mut map) = Scale::of(texels, sample_type, appearance, range);
                let floats = sample_type == SampleType::F32;
                let serves = |s: &&Style| {
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
                        let (boxes, reach) = (&octree.boxes, volume.reach);
                        let source = &**source;
                        let voxels =
                            Voxels::new(gpu, source, boxes, &visibility, map, reach, options)?;
                        Arc::new(voxels)
                    }
                };
                (scale, map, voxels, Some(table), Some(visibility))
            }
        };
        // What only the device knows only the device traverses.
        let by_gpu = options.traversal == Traversal::Gpu || table.is_none();
        let by_gpu = by_gpu && voxels.is_complete();
        let cull = by_gpu.then(|| CullData::new(gpu, &volume, table, appearance, &voxels));
        let knots = knot_pairs(tf, &map, &volume.normalization)?;
        let (lattice, slices) = (&volume.lattice, options.slices_per_voxel);
        let longest = longest_slab(lattice, &volume.normalization, slices);
        let scalars = range.map_or(ANY_SCALAR, |range| map.range(Some(range)));
        let deepest = deepest(&knots, scalars, longest);
        let interval_count = knots.len();
        let knots = gpu.upload("the transfer function", &knots, BufferUsages::STORAGE)?;
        let look = Look {
            intervals: &knots,
            interval_count,
            appearance,
            deepest,
            gaps: volume.has_gaps(model),
            nearest: volume.fills_cells,
        };
        let slice = self.pass.data(gpu, &voxels, &look, options)?;
        Ok(Style {
            shows: !is_transparent(model, deepest),
            scale,
            appearance: appearance.clone(),
            kept: clip_planes(&appearance.clip_planes, &volume.lattice),
            intervals: knots,
            volume,
            map,
            visibility,
            voxels,
            cull: cull.transpose()?,
            tables: Tables::default(),
            slice,
        })
    }
}

/// Clip planes in the lattice, as the half-spaces n · p + d ≥ 0 that they keep.
fn clip_planes(planes: &[ClipPlane], lattice: &Lattice) -> Vec<Vec4> {
    let of = |plane: &ClipPlane| {
        let normal = plane.normal.unit();
        let in_lattice = lattice.linear().transpose() * normal;
        let offset = normal.dot(lattice.origin - plane.point);
        // Any positive factor will do; this one keeps the numbers near 1.
        let factor = in_lattice.length().recip();
        (in_lattice * factor).extend(offset * factor).as_vec4()
    };
    planes.iter().map(of).collect()
}
