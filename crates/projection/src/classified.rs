//! The mesh under a transfer function: that on the device, and which cells it shows.

use std::sync::Arc;

use bytemuck::Zeroable;
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::{ANY_SCALAR, KnotPair, deepest};
use tetrascope_gpu::passes::look_constants;
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration};

use crate::NAME;
use crate::cull::{Culled, Judged, Listed, cull};
use crate::mesh::{Field, Geometry, texels};

/// Intervals a row of the transfer function, three texels each, as in `transfer.wgsl`.
const INTERVALS_PER_ROW: u32 = 256;

/// The transfer function on the device, and what it leaves to draw.
#[derive(Clone, Debug)]
pub(crate) struct Classified {
    pub(crate) intervals: wgpu::Texture,
    /// Constants of shaders for clip planes and depth cue.
    pub(crate) extras: [(&'static str, f64); 2],
    pub(crate) interval_count: usize,
    pub(crate) culled: Arc<Culled>,
    pub(crate) table: Table,
    pub(crate) listed: Listed,
    /// A bound of the optical depth of any segment.
    pub(crate) deepest: f32,
    /// The same where cells are drawn whole.
    deepest_of_cells: f32,
}

/// The appearance to classify cells by, and how [`Classified`] is to list them.
pub(crate) struct Classification<'a> {
    pub(crate) appearance: &'a Appearance,
    pub(crate) integration: Integration,
    /// The last one, of which is kept what does not change.
    pub(crate) last: Option<&'a Classified>,
    /// Whether cells are drawn in pieces, one for each interval of the transfer function
    /// (`pieces.wgsl`), if there are not too many.
    pub(crate) pieces: bool,
    /// Whether the CPU has to know which.
    pub(crate) listed: bool,
    /// Whether scalars come from a cell's gradient, which may lead beyond those of its corners.
    pub(crate) extrapolates: bool,
}

impl Classified {
    pub(crate) fn upload(
        gpu: &Gpu,
        geometry: &Geometry,
        field: &Field,
        asked: &Classification,
    ) -> Result<Classified, Error> {
        let (appearance, map) = (asked.appearance, &field.map);
        let tf = &appearance.transfer_function;
        let mut intervals: Vec<KnotPair> = knot_pairs(tf, map, &geometry.normalization)?;
        let source = preintegration::Source {
            integration: asked.integration,
            model: appearance.optical_model,
            intervals: &intervals,
            longest: geometry.longest,
            fixed: None,
        };
        let table = match asked.last {
            Some(last) => last.table.renewed(gpu, NAME, &source)?,
            None => Table::new(gpu, NAME, &source)?,
        };
        let isovalues = appearance.isosurfaces.iter();
        let isovalues: Vec<f32> = isovalues.map(|s| map.scalar(s.value)).collect();
        let (culled, listed) = cull(
            gpu,
            &Judged {
                geometry,
                field,
                model: appearance.optical_model,
                intervals: &intervals,
                isovalues: &isovalues,
                pieces: asked.pieces,
            },
            asked.listed,
            asked.last.map(|last| (&*last.culled, &last.listed)),
        )?;
        let scalars = match asked.extrapolates {
            true => ANY_SCALAR,
            false => field.range,
        };
        let deepest_of_cells = deepest(&intervals, scalars, geometry.longest);
        let deepest = match culled.in_parts {
            true => 1.0,
            false => deepest_of_cells,
        };
        let interval_count = intervals.len();
        let (width, height) = texels(intervals.len(), INTERVALS_PER_ROW);
        intervals.resize((width * height) as usize, Zeroable::zeroed());
        let texture = gpu.texture(
            "of the transfer function",
            (3 * width, height),
            TextureFormat::Rgba32Float,
            TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        )?;
        gpu.write_texture(&texture, &intervals)?;
        Ok(Classified {
            table,
            intervals: texture,
            extras: look_constants(appearance),
            interval_count,
            culled: Arc::new(culled),
            listed,
            deepest,
            deepest_of_cells,
        })
    }

    /// The same with cells that are drawn whole; the CPU must know which.
    pub(crate) fn whole(&self, gpu: &Gpu) -> Result<Classified, Error> {
        Ok(Classified {
            culled: Arc::new(self.culled.whole(gpu, &self.listed.cells)?),
            deepest: self.deepest_of_cells,
            ..self.clone()
        })
    }
}
