//! Which engine has which pixel: "the pixel assignments finely interleaved to ensure that even small
//! triangles are partially rasterized by each of the fragment generators" (section 5.1). The pattern
//! itself was not published.

/// Pixel (x, y) belongs to image engine (x + stride · y) mod all, and that to fragment
/// generator (engine mod generators): both are lattices, as even as they can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interleave {
    generators: u32,
    all: u32,
    stride: u32,
}

impl Interleave {
    pub(super) fn new(generators: u32, engines: u32) -> Interleave {
        let all = generators * engines;
        // First the fragment generators', then the image engines'.
        let evenness = |stride: u32| (shortest(generators, stride), shortest(all, stride));
        let stride = (0..all)
            .rev()
            .max_by_key(|stride| evenness(*stride))
            .expect("there are engines");
        Interleave {
            generators,
            all,
            stride,
        }
    }

    /// The image engine of a pixel, counted over the whole machine.
    pub(super) fn engine(&self, (x, y): (i32, i32)) -> usize {
        // Pixels are in a volume of at most 1024 voxels, strides below that.
        ((x as u32 + self.stride * y as u32) % self.all) as usize
    }

    /// The fragment generator that an image engine belongs to.
    pub(super) fn generator(&self, engine: usize) -> usize {
        engine % self.generators as usize
    }
}

/// The square of the least distance of two pixels of one engine, where (x, y) belongs to (x +
/// stride · y) mod n.
fn shortest(n: u32, stride: u32) -> u64 {
    let (n, stride) = (u64::from(n), u64::from(stride));
    let mut least = n * n;
    // A lattice of n pixels per point has two at most √(2/√3 n) apart.
    let mut y = 1;
    while y * y < least {
        let x = stride * y % n;
        let x = x.min(n - x);
        least = least.min(x * x + y * y);
        y += 1;
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    // √5, √10 and √20 are the greatest distances that lattices with integer coordinates have.
    #[test]
    fn neighbors_belong_to_different_generators() {
        for (n, least) in [(5, 5), (10, 10), (20, 20)] {
            let interleave = Interleave::new(n, 16);
            assert_eq!(shortest(n, interleave.stride), least, "{n}");
            // Every engine has the same share of a rectangle that their number divides.
            let side = 16 * n as i32;
            let mut pixels = vec![0; 16 * n as usize];
            for (x, y) in (0..side).flat_map(|x| (0..16).map(move |y| (x, y))) {
                pixels[interleave.engine((x, y))] += 1;
            }
            assert!(pixels.iter().all(|count| *count == 16));
            // Any square of 8 pixels has all generators.
            let mut seen = vec![false; n as usize];
            for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
                seen[interleave.generator(interleave.engine((x, y)))] = true;
            }
            assert!(seen.iter().all(|seen| *seen), "{n}");
        }
        assert_eq!(Interleave::new(1, 1).engine((7, 9)), 0);
    }
}
