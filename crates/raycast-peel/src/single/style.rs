//! The data that `restyle` changes: the transfer function on the device, and the program that is compiled
//! for the look.

use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{KnotPair, deepest, is_transparent};
use tetrascope_gpu::passes::{deep, look_constants, model_constant};
use tetrascope_gpu::pipelines::Constant;
use tetrascope_gpu::preintegration::Table;
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, ComputePipeline, TextureFormat};
use tetrascope_gpu::{ComputeProgram, Gpu};
use tetrascope_shaders::raycast_peel::MARCH;

use super::LABEL;
use super::budget::Budget;
use super::mesh::{Kind, Mesh};
use crate::integral::{Segments, sides_constant, table};
use crate::options::{Entries, RaycastOptions};

/// All that `restyle` replaces.
#[derive(Debug)]
pub(super) struct Style {
    pub(super) appearance: Appearance,
    pub(super) constants: Vec<Constant>,
    pub(super) deepest: f32,
    pub(super) intervals: wgpu::Texture,
    pub(super) interval_count: usize,
    pub(super) table: Table,
}

impl Style {
    pub(super) fn new(
        gpu: &Gpu,
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
        let segments = Segments {
            mesh: &mesh.source,
            scale: mesh.normalization.scale,
            intervals: &intervals,
            longest: mesh.longest_edge,
            scalars: mesh.scalars(),
        };
        let table = table(gpu, appearance, &segments, options, last)?;
        let deepest = deepest(&intervals, segments.scalars, mesh.longest_edge);
        let mut constants = constants(gpu, mesh, appearance, options)?;
        constants.push(deep(deepest));
        constants.extend(table.constants(segments.scalars));
        constants.extend(Budget::new(appearance)?.constants());
        let style = Style {
            appearance: appearance.clone(),
            constants,
            deepest,
            table,
            interval_count: intervals.len(),
            intervals: gpu.upload_texels(
                "of the transfer function",
                TextureFormat::Rgba32Float,
                &texels(&intervals),
            )?,
        };
        style.pipeline(gpu, false, false)?;
        Ok(style)
    }
}

/// The constants of `march.wgsl`, but for its table's.
pub(super) fn constants(
    gpu: &Gpu,
    mesh: &Mesh,
    appearance: &Appearance,
    options: &RaycastOptions,
) -> Result<Vec<Constant>, Error> {
    let kind = Kind::of(&mesh.source);
    let layered = options.entries == Entries::PeeledLayers;
    let [clipped, cued] = look_constants(appearance);
    Ok(vec![
        sides_constant(gpu, options)?,
        clipped,
        cued,
        model_constant(appearance.optical_model),
        ("SCALARS_PER_CELL", f64::from(u8::from(kind == Kind::Cells))),
        ("CORNER_SCALARS", f64::from(u8::from(kind == Kind::Corners))),
        ("LAYERED", f64::from(u8::from(layered))),
    ])
}

impl Style {
    /// Whether nothing of the mesh shows.
    pub(super) fn is_transparent(&self) -> bool {
        is_transparent(self.appearance.optical_model, self.deepest)
    }

    /// Whether this holds for `mesh`, too, with the same map of scalars: programs ask only whether
    /// the bound of depths is at most 1, and [`Style::is_transparent`] whether it is 0.
    pub(super) fn holds_for(&self, mesh: &Mesh) -> Result<bool, Error> {
        let tf = &self.appearance.transfer_function;
        let intervals = knot_pairs(tf, &mesh.scalar_map, &mesh.normalization)?;
        let deepest = deepest(&intervals, mesh.scalars(), mesh.longest_edge);
        Ok((self.deepest > 1.0 || deepest <= 1.0) && (self.deepest > 0.0 || deepest == 0.0))
    }

    /// The pipeline, with `resumes` for rays that go on from dispatch to dispatch, and with
    /// `ends` for rays that end before an application's geometry.
    pub(super) fn pipeline(
        &self,
        gpu: &Gpu,
        resumes: bool,
        ends: bool,
    ) -> Result<ComputePipeline, Error> {
        let mut constants = self.constants.clone();
        if resumes {
            constants.extend([("RESUMES", 1.0), ("TREES", 1.0)]);
        }
        if ends {
            constants.push(("ENDS", 1.0));
        }
        gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source: MARCH,
            entry: Some("cs_cast"),
            constants,
            groups: Vec::new(),
        })
    }
}

/// Three texels an interval.
fn texels(intervals: &[KnotPair]) -> Vec<[f32; 4]> {
    let three = |i: &KnotPair| [i.at_low, i.at_high, [i.low, i.high, i.inverse_width, 0.0]];
    intervals.iter().flat_map(three).collect()
}
