//! The lists of what is drawn.

use super::judge::{Share, Total, chunk, in_threads};

/// In what all cells are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Cell,
    Piece,
    Part,
}

impl Unit {
    fn items(self, share: Share) -> u32 {
        match self {
            Unit::Cell => u32::from(share.pieces > 0),
            Unit::Piece => share.pieces.into(),
            Unit::Part => u32::from(share.pieces) * u32::from(share.parts),
        }
    }
}

/// The lists that are uploaded.
pub(super) struct Lists {
    pub(super) cells: Vec<u32>,
    /// As in [`Culled::pieces`]; empty where cells are drawn whole.
    pub(super) pieces: Vec<[u32; 2]>,
    /// As in [`Listed`]; empty where cells are drawn whole.
    pub(super) starts: Vec<u32>,
}

/// Lists cells with these shares, of which each chunk comes to one of `totals`.
pub(super) fn lists(shares: &[Share], totals: &[Total], unit: Unit) -> Lists {
    let in_pieces = unit != Unit::Cell;
    let items = |total: &Total| match unit {
        Unit::Cell => 0,
        Unit::Piece => total.pieces as usize,
        Unit::Part => total.parts as usize,
    };
    let all: usize = totals.iter().map(items).sum();
    let mut made = Lists {
        cells: vec![0; totals.iter().map(|total| total.cells as usize).sum()],
        pieces: vec![[0; 2]; all],
        starts: vec![0; if in_pieces { shares.len() + 1 } else { 0 }],
    };
    let (mut cells, mut pieces) = (&mut made.cells[..], &mut made.pieces[..]);
    let mut starts = &mut made.starts[..];
    let (mut first_cell, mut first_item) = (0_u32, 0_u32);
    let mut tasks = Vec::new();
    for (shares, total) in shares.chunks(chunk(shares.len())).zip(totals) {
        let (own_cells, own_pieces, own_starts);
        (own_cells, cells) = cells.split_at_mut(total.cells as usize);
        (own_pieces, pieces) = pieces.split_at_mut(items(total));
        (own_starts, starts) = starts.split_at_mut(if in_pieces { shares.len() } else { 0 });
        tasks.push((
            shares, first_cell, first_item, own_cells, own_pieces, own_starts,
        ));
        first_cell += shares.len() as u32;
        first_item += items(total) as u32;
    }
    if let [end] = starts {
        *end = all as u32;
    }
    in_threads(
        tasks,
        |(shares, first_cell, first_item, cells, pieces, starts)| {
            let (mut cells, mut pieces) = (cells.iter_mut(), pieces.iter_mut());
            let mut starts = starts.iter_mut();
            let mut item = first_item;
            for (cell, share) in (first_cell..).zip(shares) {
                if let Some(start) = starts.next() {
                    *start = item;
                }
                if share.pieces == 0 {
                    continue;
                }
                if let Some(place) = cells.next() {
                    *place = cell;
                }
                if !in_pieces {
                    continue;
                }
                item += unit.items(*share);
                let parts = match unit {
                    Unit::Part => u32::from(share.parts),
                    _ => 1,
                };
                for piece in 0..u32::from(share.pieces) {
                    for part in 0..parts {
                        if let Some(place) = pieces.next() {
                            *place = [cell, piece | part << 16 | (parts - 1) << 24];
                        }
                    }
                }
            }
        },
    );
    made
}
