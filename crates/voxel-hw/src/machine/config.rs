//! The machine's numbers.

use tetrascope_core::Error;

/// Who interpolates between front and back buffer, and writes voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Voxelizing {
    /// The fragment generators, into texture memory (section 5.3, steps 1 to 4).
    #[default]
    FragmentGenerators,
    /// The image engines, "directly into their frame buffer", which is then moved into texture
    /// memory (the end of section 5.3).
    ImageEngines,
}

/// How texture memories become alike (section 5.3, step 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Merge {
    /// Every fragment generator sends the texels that it wrote to all others.
    #[default]
    Broadcast,
    /// The host reads every fragment generator's texels, and sends the whole texture to all.
    Readback,
}

/// A machine.
///
/// "Published" is what Akeley's abstract says of the largest RealityEngine, or the paper of it:
/// 353 processors, which are a command processor, 12 geometry engines, 20 fragment generators and 320
/// image engines; over a million triangles and over 240 million pixels per second. All others are
/// assumptions.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineConfig {
    /// Cycles per microsecond of all engines and buses. Assumption: 50.
    pub clock_mhz: u32,
    /// Bytes per cycle from the host. Assumption: 2, which are 100 MB/s.
    pub host_bytes_per_cycle: u32,
    /// Bytes of a corner: three coordinates and a scalar. Assumption: 16.
    pub corner_bytes: u32,
    /// How many share the cells in turn. Published: 12.
    pub geometry_engines: u32,
    /// A triangle's share of transformation, classification and slopes. 600, so that 12 engines
    /// make the published million triangles per second.
    pub geometry_cycles_per_triangle: u32,
    /// Bytes per cycle of the triangle bus, on which everything reaches all fragment generators.
    /// Assumption: 5, which are 250 MB/s.
    pub triangle_bus_bytes_per_cycle: u32,
    /// Bytes of a triangle with its slopes. Assumption: 240, which with the bus's rate is
    /// the published million triangles per second.
    pub triangle_bytes: u32,
    /// Published: 5, 10 or 20, on one, two or four boards.
    pub fragment_generators: u32,
    /// Cycles of a fragment generator per triangle, also of one that has no pixel of it. Assumption:
    /// 8.
    pub setup_cycles: u32,
    /// Cycles of a fragment generator per fragment: 4, so that 20 make the published 240 million
    /// per second.
    pub fragment_cycles: u32,
    /// For each fragment generator. Published: 16.
    pub image_engines: u32,
    /// Bytes of a fragment: pixel, depth, scalar. Assumption: 12.
    pub fragment_bytes: u32,
    /// Cycles of an image engine per fragment. Assumption: 32; 16 engines then keep up with
    /// twice their fragment generator.
    pub merge_cycles: u32,
    /// Cycles of an image engine to see whether a cell touched a pixel: it looks at its pixels
    /// in the cell's rectangle. Assumption: 2.
    pub examine_cycles: u32,
    /// Bytes of a pixel that goes back: two depths and two scalars. Assumption: 16.
    pub pixel_bytes: u32,
    /// Bytes per cycle from an image engine to its fragment generator. Assumption: 1.
    pub link_bytes_per_cycle: u32,
    /// Cycles to find the increment of a column, a division. Assumption: 16.
    pub column_cycles: u32,
    /// Cycles per voxel: an addition and a write. Assumption: 1 in a fragment generator; with
    /// several samples per voxel it reads as well, and takes twice as long.
    pub voxel_cycles: u32,
    /// The same in an image engine, whose memory is slower. Assumption: 8.
    pub image_voxel_cycles: u32,
    /// Texture memory of each fragment generator, which holds the whole texture. Published (by the
    /// paper, section 7): 4 to 16 MB; here 16.
    pub texture_bytes: u64,
    /// Bits of frame buffer per pixel. Published: 1024 at most.
    pub pixel_bits: u32,
    /// Who writes voxels.
    pub voxelizing: Voxelizing,
    /// How texture memories become alike.
    pub merge: Merge,
}

impl Default for MachineConfig {
    fn default() -> Self {
        MachineConfig {
            clock_mhz: 50,
            host_bytes_per_cycle: 2,
            corner_bytes: 16,
            geometry_engines: 12,
            geometry_cycles_per_triangle: 600,
            triangle_bus_bytes_per_cycle: 5,
            triangle_bytes: 240,
            fragment_generators: 20,
            setup_cycles: 8,
            fragment_cycles: 4,
            image_engines: 16,
            fragment_bytes: 12,
            merge_cycles: 32,
            examine_cycles: 2,
            pixel_bytes: 16,
            link_bytes_per_cycle: 1,
            column_cycles: 16,
            voxel_cycles: 1,
            image_voxel_cycles: 8,
            texture_bytes: 16 << 20,
            pixel_bits: 1024,
            voxelizing: Voxelizing::default(),
            merge: Merge::default(),
        }
    }
}

/// The most engines of a kind: with more the search for an even interleaving takes long.
const MOST_ENGINES: u32 = 1024;

impl MachineConfig {
    /// Refuses a machine that cannot be.
    pub(super) fn check(&self) -> Result<(), Error> {
        let engines = u64::from(self.fragment_generators) * u64::from(self.image_engines);
        for (what, count) in [
            ("geometry engines", self.geometry_engines.into()),
            ("fragment generators", self.fragment_generators.into()),
            ("image engines in all", engines),
        ] {
            if !(1..=u64::from(MOST_ENGINES)).contains(&count) {
                return Err(Error::Usage {
                    what: format!("a machine of {count} {what}"),
                    help: Some(format!("give 1 to {MOST_ENGINES}")),
                });
            }
        }
        for (what, rate) in [
            ("the clock", self.clock_mhz),
            ("the host's bus", self.host_bytes_per_cycle),
            ("the triangle bus", self.triangle_bus_bytes_per_cycle),
            ("an image engine's link", self.link_bytes_per_cycle),
        ] {
            if rate == 0 {
                return Err(Error::Usage {
                    what: format!("a machine in which {what} stands still"),
                    help: Some("give a rate of 1 or more".into()),
                });
            }
        }
        Ok(())
    }
}
