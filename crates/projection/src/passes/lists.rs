//! Passes 3 and 4 where each pixel sorts: list fragments (`fill.wgsl`), then add them
//! up (`composite.wgsl`), tile by tile, in as many turns as the longest list may need.

use std::sync::{Mutex, PoisonError};

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::passes::{UNIFORM, WRITE, group, model_constant};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages, TextureFormat};
use tetrascope_gpu::{Gpu, RenderProgram};
use tetrascope_shaders::projection::{COMPOSITE, FILL};

use super::cell::{CellData, CellPass, FrameData, Uploaded, begin};
use crate::gpu_data;
use crate::tiles::Tile;

/// Format of the lists' sum; nothing is blended, so every device draws into f32.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// A pass must have a target; this one stays as it is.
const UNTOUCHED: wgpu::ColorTargetState = wgpu::ColorTargetState {
    format: FORMAT,
    blend: None,
    write_mask: wgpu::ColorWrites::empty(),
};

/// Bytes of a `Fragment` in `fragments.wgsl`.
pub(crate) const FRAGMENT_BYTES: u64 = 28;

/// Bytes of a `State` in `composite.wgsl`.
pub(crate) const STATE_BYTES: u64 = 60;

/// Passes of the loop in one turn, as in `composite.wgsl`: a quarter of what llvmpipe makes
/// before it ends a loop, and some 10 ms of reading one number after the other elsewhere.
const PASSES: u64 = 1 << 14;

/// Numbers in `heads` before those of pixels: how many fragments there are, and how many
/// pixels were not done.
const COUNTS: u64 = 2;

/// The pipelines of the passes and the buffers of the last frame.
#[derive(Debug)]
pub(crate) struct ListPass {
    tile_layout: wgpu::BindGroupLayout,
    groups: Vec<wgpu::BindGroupLayout>,
    composite: wgpu::RenderPipeline,
    kept: Mutex<Option<Lists>>,
}

/// Room for the fragments of one tile.
#[derive(Clone, Debug)]
struct Lists {
    heads: wgpu::Buffer,
    fragments: wgpu::Buffer,
    /// States of the sort, for one pixel alone where no tile needs two turns.
    states: wgpu::Buffer,
}

impl ListPass {
    pub(crate) fn new(gpu: &Gpu, cells: &CellPass) -> Result<ListPass, Error> {
        let label = "projection::lists";
        let types = [UNIFORM, WRITE, WRITE, WRITE];
        let tile_layout = gpu.layout(label, ShaderStages::FRAGMENT, &types)?;
        let [frame, volume] = cells.layouts();
        let groups = vec![frame.clone(), volume.clone(), tile_layout.clone()];
        let composite = gpu.render_pipeline(&RenderProgram {
            label: "projection::composite",
            source: COMPOSITE,
            vertex: "vs_composite",
            fragment: Some("fs_composite"),
            constants: vec![model_constant(OpticalModel::EmissionAbsorption)],
            targets: vec![Some(FORMAT.into())],
            groups: groups.clone(),
            ..Default::default()
        })?;
        Ok(ListPass {
            tile_layout,
            groups,
            composite,
            kept: Mutex::new(None),
        })
    }

    /// The program that lists the fragments of cells.
    pub(crate) fn program(
        &self,
        gpu: &Gpu,
        cells: &CellPass,
        uploaded: Uploaded,
        model: OpticalModel,
    ) -> Result<RenderProgram, Error> {
        Ok(RenderProgram {
            source: FILL,
            fragment: Some("fs_fill"),
            groups: self.groups.clone(),
            targets: vec![Some(UNTOUCHED)],
            ..cells.program(gpu, uploaded, model)?
        })
    }

    /// How many fragments a tile may have, in `bytes` and on this device.
    pub(crate) fn capacity(gpu: &Gpu, bytes: u64) -> u64 {
        let limits = gpu.limits();
        let most = limits
            .max_buffer_size
            .min(limits.max_storage_buffer_binding_size);
        (bytes.min(most) / FRAGMENT_BYTES).min(u64::from(u32::MAX) - 1)
    }

    /// Records both passes for each tile into `gathered`. Returns the buffer that gets
    /// of each tile, u32, the number of fragments and that of pixels that were not done.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameData,
        (cells, data): (&CellPass, &CellData),
        tiles: &[Tile],
        gathered: &wgpu::TextureView,
    ) -> Result<wgpu::Buffer, Error> {
        let lists = self.lists(gpu, tiles)?;
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let counts = gpu.buffer("projection::counts", 4 * COUNTS * tiles.len() as u64, usage)?;
        for (tile, place) in tiles.iter().zip(0_u64..) {
            let turns = turns(tile.deepest);
            let label = "projection::lists";
            let turn_group = |turn: u32| -> Result<wgpu::BindGroup, Error> {
                let uniform = gpu_data::Tile {
                    origin: tile.origin,
                    width: tile.size[0],
                    capacity: (lists.fragments.size() / FRAGMENT_BYTES) as u32,
                    turn,
                    turns,
                };
                let uniform = gpu.upload("projection::tile", &[uniform], BufferUsages::UNIFORM)?;
                let buffers = [&uniform, &lists.heads, &lists.fragments, &lists.states];
                let buffers = buffers.map(|b| b.as_entire_binding());
                gpu.checked(label, 0, || group(gpu, label, &self.tile_layout, &buffers))
            };
            // All between the first and the last turn are alike.
            let first = turn_group(0)?;
            let between = (turns > 2).then(|| turn_group(1)).transpose()?;
            let last = (turns > 1).then(|| turn_group(turns - 1)).transpose()?;
            gpu.checked(label, 0, || {
                let ([x, y], [width, height]) = (tile.origin, tile.size);
                encoder.clear_buffer(&lists.heads, 0, None);
                {
                    let load = wgpu::LoadOp::Load;
                    let mut pass = begin(encoder, "projection::fill", gathered, load);
                    pass.set_bind_group(2, &first, &[]);
                    pass.set_scissor_rect(x, y, width, height);
                    cells.draw(gpu, &mut pass, frame, data)?;
                }
                for turn in 0..turns {
                    let group = match turn {
                        0 => Some(&first),
                        _ if turn + 1 == turns => last.as_ref(),
                        _ => between.as_ref(),
                    };
                    let load = wgpu::LoadOp::Load;
                    let mut pass = begin(encoder, "projection::composite", gathered, load);
                    cells.bind(gpu, &mut pass, frame, data);
                    pass.set_pipeline(&self.composite);
                    pass.set_bind_group(2, group, &[]);
                    pass.set_scissor_rect(x, y, width, height);
                    pass.draw(0..3, 0..1);
                }
                let size = 4 * COUNTS;
                encoder.copy_buffer_to_buffer(&lists.heads, 0, &counts, size * place, size);
                Ok(())
            })??;
        }
        Ok(counts)
    }

    /// Passes that `record` makes for `tiles`.
    pub(crate) fn passes(tiles: &[Tile]) -> u64 {
        tiles.iter().map(|t| 1 + u64::from(turns(t.deepest))).sum()
    }

    /// Buffers that suffice for each of `tiles`, kept for the next frame.
    fn lists(&self, gpu: &Gpu, tiles: &[Tile]) -> Result<Lists, Error> {
        let most = |measure: fn(&Tile) -> u64| tiles.iter().map(measure).max().unwrap_or(0);
        let pixels = |t: &Tile| u64::from(t.size[0]) * u64::from(t.size[1]);
        let heads = 4 * (COUNTS + tiles.iter().map(pixels).max().unwrap_or(0));
        let fragments = FRAGMENT_BYTES * most(|t| t.most).max(1);
        let in_turns = tiles.iter().filter(|t| turns(t.deepest) > 1);
        let states = STATE_BYTES * in_turns.map(pixels).max().unwrap_or(1);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |l: &&Lists| {
            l.heads.size() >= heads && l.fragments.size() >= fragments && l.states.size() >= states
        };
        if let Some(lists) = kept.as_ref().filter(fits) {
            return Ok(lists.clone());
        }
        // What is kept goes first: two may not fit.
        *kept = None;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let lists = Lists {
            heads: gpu.buffer("projection::heads", heads, usage)?,
            fragments: gpu.buffer("projection::fragments", fragments, BufferUsages::STORAGE)?,
            states: gpu.buffer("projection::states", states, BufferUsages::STORAGE)?,
        };
        *kept = Some(lists.clone());
        Ok(lists)
    }
}

/// Turns of `composite.wgsl` that are sure to sort a list of `fragments`: n ⌈log₂ n⌉ passes
/// and one, n where it is 1.
fn turns(fragments: u64) -> u32 {
    let rounds = u64::from(fragments.next_power_of_two().ilog2()).max(1);
    let passes = fragments.saturating_mul(rounds).saturating_add(1);
    u32::try_from(passes.div_ceil(PASSES)).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_take_more_turns() {
        for (fragments, passes) in [(0, 1), (1, 2), (2, 3), (3, 7), (1024, 10_241)] {
            assert!(passes <= PASSES);
            assert_eq!(turns(fragments), 1, "{fragments}");
        }
        // 1639 · 11 + 1 = 18 030 and 100 000 · 17 + 1 passes.
        assert_eq!(turns(1639), 2);
        assert_eq!(turns(100_000), 104);
    }
}
