//! The image in n × n tiles of fixed size (the paper's section 3.3 and figure 5).

/// A part of the image and what was done in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    /// Pixels from the left.
    pub(super) x: u32,
    /// Pixels from the top.
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Among all tiles, row by row.
    pub(super) index: usize,
}

impl Tile {
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// `a_side` × `a_side` tiles, without those that a small image leaves no pixels.
pub(super) fn tiles(a_side: u32, (width, height): (u32, u32)) -> Vec<Tile> {
    // As in `tally.wgsl`. Images have at most 2¹⁶ pixels per side.
    let start = |i: u32, pixels: u32| i * pixels / a_side;
    let mut tiles = Vec::new();
    for row in 0..a_side {
        for column in 0..a_side {
            let (x, y) = (start(column, width), start(row, height));
            tiles.push(Tile {
                x,
                y,
                width: start(column + 1, width) - x,
                height: start(row + 1, height) - y,
                index: (row * a_side + column) as usize,
            });
        }
    }
    tiles.retain(|tile| tile.pixels() > 0);
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_the_tile_that_the_tally_takes_it_for() {
        for a_side in 1..=8 {
            for size in [(1, 1), (5, 3), (64, 64), (100, 37)] {
                let tiles = tiles(a_side, size);
                assert_eq!(
                    tiles.iter().map(Tile::pixels).sum::<u64>(),
                    u64::from(size.0 * size.1)
                );
                for tile in tiles {
                    for (x, y) in [
                        (tile.x, tile.y),
                        (tile.x + tile.width - 1, tile.y + tile.height - 1),
                    ] {
                        let column = ((x + 1) * a_side - 1) / size.0;
                        let row = ((y + 1) * a_side - 1) / size.1;
                        assert_eq!((row * a_side + column) as usize, tile.index);
                    }
                }
            }
        }
    }
}
