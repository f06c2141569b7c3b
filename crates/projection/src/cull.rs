//! Which cells can show, whenever appearance or scalars change, and the list of what is drawn.
//!
//! On the CPU, which knows the least and the greatest scalar of each cell: how many items there are
//! decides what is allocated, so a device would be waited for twice. 187 000 cells take some 2 ms on
//! two cores, and twice that if they are drawn in pieces; passes took 136 ms on llvmpipe, half of that
//! in barriers. Lists that an edit leaves as they were stay on the device.
//!
//! Left out are cells without volume, cells with a scalar that is NaN, and cells whose scalars map
//! to nothing: no extinction, or black where only color counts. Where isosurfaces are drawn, cells
//! that none goes through.

mod judge;
mod lists;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use tetrascope_core::{Error, OpticalModel};
use tetrascope_f32::KnotPair;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, BufferUsages};

use self::judge::{Judge, Total, Verdicts};
use self::lists::{Lists, Unit, lists};
use crate::mesh::{Field, Geometry};

/// Pieces a cell, on average, beyond which cells are drawn whole. On llvmpipe a piece costs
/// as much as a turn of the loop; elsewhere, memory.
const MOST_PIECES: u64 = 2;

/// The mark of a list without pieces, as in `order.wgsl`.
const NO_CELL: u32 = u32::MAX;

/// The cells that are left to draw.
#[derive(Debug)]
pub(crate) struct Culled {
    /// The first and the last interval of each of the mesh's cells, 16 bits each.
    pub(crate) ranges: wgpu::Buffer,
    /// The items that are drawn: cells or, where `in_pieces`, those. It may have room for more.
    pub(crate) drawn: wgpu::Buffer,
    /// A cell and what of it is drawn, by piece; see `pieces.wgsl`.
    pub(crate) pieces: wgpu::Buffer,
    pub(crate) items: u32,
    pub(crate) cells: u32,
    pub(crate) in_pieces: bool,
    /// Whether pieces are in parts, none of an optical depth above 1.
    pub(crate) in_parts: bool,
    /// The verdicts that the buffers were made from: the next list takes over those that stay.
    verdicts: Arc<Verdicts>,
}

/// The facts about the drawn cells that an order made on the CPU needs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Listed {
    /// Their indices.
    pub(crate) cells: Arc<[u32]>,
    /// The first piece of each of the mesh's cells, and the end of the last, where cells are
    /// drawn in pieces.
    starts: Option<Arc<[u32]>>,
    is_made: bool,
}

impl Listed {
    /// The items of `cells`, in their order.
    pub(crate) fn items_of(&self, cells: Vec<u32>) -> Vec<u32> {
        let Some(starts) = &self.starts else {
            return cells;
        };
        let pieces = |cell: u32| starts[cell as usize]..starts[cell as usize + 1];
        cells.into_iter().flat_map(pieces).collect()
    }
}

/// Inputs of culling.
pub(crate) struct Judged<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) field: &'a Field,
    pub(crate) model: OpticalModel,
    pub(crate) intervals: &'a [KnotPair],
    /// Values of isosurfaces, in the unit of the scalars.
    pub(crate) isovalues: &'a [f32],
    /// Whether cells may be drawn in pieces.
    pub(crate) pieces: bool,
}

/// Lists what of `judged` is drawn; also for the CPU if it asks, else that list is empty. What is
/// the same as in `last` is taken from there.
pub(crate) fn cull(
    gpu: &Gpu,
    judged: &Judged,
    is_listed: bool,
    last: Option<(&Culled, &Listed)>,
) -> Result<(Culled, Listed), Error> {
    let extents = &judged.field.extents;
    let (verdicts, totals) = Judge::new(judged).all(extents, &judged.geometry.longest_edges);
    let mut total = Total::default();
    for t in &totals {
        total.cells += t.cells;
        total.pieces += t.pieces;
        total.parts += t.parts;
        total.is_uncounted |= t.is_uncounted;
    }
    let fit = |items: u64| {
        let most = MOST_PIECES * u64::from(total.cells);
        judged.pieces && items <= most && items <= u64::from(u32::MAX / 4)
    };
    let in_parts =
        fit(total.parts) && !total.is_uncounted && judged.model == OpticalModel::EmissionAbsorption;
    let in_pieces = in_parts || fit(total.pieces);
    let unit = match (in_pieces, in_parts) {
        (_, true) => Unit::Part,
        (true, false) => Unit::Piece,
        (false, false) => Unit::Cell,
    };
    let storage = BufferUsages::STORAGE;
    let ranges = match last {
        Some((last, _)) if last.verdicts.ranges == verdicts.ranges => last.ranges.clone(),
        _ => gpu.upload("the cells' intervals", &verdicts.ranges, storage)?,
    };
    let is_same = |last: &(&Culled, &Listed)| {
        (last.0.in_pieces, last.0.in_parts) == (in_pieces, in_parts)
            && last.1.is_made == is_listed
            && last.0.verdicts.shares == verdicts.shares
    };
    if let Some((last, listed)) = last.filter(is_same) {
        let culled = Culled {
            ranges,
            drawn: last.drawn.clone(),
            pieces: last.pieces.clone(),
            verdicts: Arc::new(verdicts),
            ..*last
        };
        return Ok((culled, listed.clone()));
    }
    let Lists {
        cells,
        mut pieces,
        starts,
    } = lists(&verdicts.shares, &totals, unit);
    let items = match in_pieces {
        true => pieces.len(),
        false => cells.len(),
    };
    // Pieces are numbered, and that list is good for any that are not more.
    let numbered = |last: &(&Culled, &Listed)| {
        last.0.in_pieces && (items as u64..=8 * items as u64).contains(&(last.0.drawn.size() / 4))
    };
    let label = "the list of drawn cells";
    let drawn = match (in_pieces, last.filter(numbered)) {
        (true, Some((last, _))) => last.drawn.clone(),
        (true, None) => {
            let numbers: Vec<u32> = (0..items as u32).collect();
            gpu.upload(label, &numbers, storage)?
        }
        (false, _) => gpu.upload(label, &cells, storage)?,
    };
    if pieces.is_empty() {
        pieces.push([NO_CELL, 0]);
    }
    let listed = match is_listed {
        true => Listed {
            cells: cells.into(),
            starts: in_pieces.then(|| starts.into()),
            is_made: true,
        },
        false => Listed::default(),
    };
    let culled = Culled {
        ranges,
        drawn,
        pieces: gpu.upload("the cells' pieces", &pieces, storage)?,
        items: items as u32,
        cells: total.cells,
        in_pieces,
        in_parts,
        verdicts: Arc::new(verdicts),
    };
    Ok((culled, listed))
}

impl Culled {
    /// The same cells, `listed`, drawn whole.
    pub(crate) fn whole(&self, gpu: &Gpu, listed: &[u32]) -> Result<Culled, Error> {
        let storage = BufferUsages::STORAGE;
        Ok(Culled {
            ranges: self.ranges.clone(),
            drawn: gpu.upload("the list of drawn cells", listed, storage)?,
            pieces: gpu.upload("the cells' pieces", &[[NO_CELL, 0]], storage)?,
            items: listed.len() as u32,
            cells: self.cells,
            in_pieces: false,
            in_parts: false,
            verdicts: self.verdicts.clone(),
        })
    }
}
