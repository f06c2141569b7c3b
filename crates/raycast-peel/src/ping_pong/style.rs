//! The data that `restyle` changes: the transfer function on the device, and the passes that are compiled for
//! the look.

use tetrascope_core::mesh::Association;
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{ANY_SCALAR, deepest, is_transparent};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::passes::{deep, model_constant};
use tetrascope_gpu::preintegration::Table;
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, BufferUsages};

use super::mesh::Mesh;
use super::passes::{Pipelines, StyledPasses};
use crate::integral::{Segments, table};
use crate::options::{Crossings, RaycastOptions};

/// All that `restyle` replaces.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    /// Whether nothing of the mesh shows.
    pub(super) is_transparent: bool,
    pub(super) passes: StyledPasses,
    pub(super) intervals: wgpu::Buffer,
    pub(super) table: Table,
}

impl Style {
    pub(super) fn new(
        gpu: &Gpu,
        passes: &Pipelines,
        mesh: &Mesh,
        appearance: &Appearance,
        options: &RaycastOptions,
        last: Option<&Table>,
    ) -> Result<Style, Error> {
        let intervals = knot_pairs(
            &appearance.transfer_function,
            &mesh.scalar_map,
            &mesh.normalization,
        )?;
        let per_cell = mesh.source.scalars().association == Association::Cell;
        let model = model_constant(appearance.optical_model);
        let segments = Segments {
            mesh: &mesh.source,
            scale: mesh.normalization.scale,
            intervals: &intervals,
            longest: mesh.longest_edge,
            scalars: mesh.scalar_map.range(mesh.domain.scalar_range),
        };
        let table = table(gpu, appearance, &segments, options, last)?;
        // Planes continue a cell's gradient.
        let scalars = match options.crossings {
            Crossings::Planes => ANY_SCALAR,
            Crossings::Sides => segments.scalars,
        };
        let deepest = deepest(&intervals, scalars, mesh.longest_edge);
        let mut constants = vec![
            model,
            deep(deepest),
            ("SCALARS_PER_CELL", f64::from(u8::from(per_cell))),
            ("JUMPS", f64::from(u8::from(!mesh.source.is_continuous()))),
        ];
        constants.extend(table.constants(segments.scalars));
        constants.extend(passes.constants());
        Ok(Style {
            appearance: appearance.clone(),
            is_transparent: is_transparent(appearance.optical_model, deepest),
            passes: passes.styled(gpu, &constants)?,
            table,
            intervals: gpu.upload("ping-pong::intervals", &intervals, BufferUsages::STORAGE)?,
        })
    }
}
