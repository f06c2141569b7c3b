//! The report of a machine's work.

use std::fmt;

/// The work of units of a kind, in cycles, or their content.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// How many units there are.
    pub units: u64,
    /// Work of the least busy one.
    pub min: u64,
    /// In the mean.
    pub mean: f64,
    /// Work of the busiest one.
    pub max: u64,
}

impl Load {
    pub(super) fn of(cycles: &[u64]) -> Load {
        Load {
            units: cycles.len() as u64,
            min: cycles.iter().copied().min().unwrap_or(0),
            mean: cycles.iter().sum::<u64>() as f64 / cycles.len().max(1) as f64,
            max: cycles.iter().copied().max().unwrap_or(0),
        }
    }

    /// The mean's share of the greatest: 1 is an even load.
    pub fn balance(&self) -> f64 {
        if self.max == 0 {
            1.0
        } else {
            self.mean / self.max as f64
        }
    }
}

/// Bytes over each connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buses {
    /// Host to geometry engines: cells, once for each sample of a voxel.
    pub host: u64,
    /// Geometry engines to fragment generators: triangles.
    pub triangles: u64,
    /// Fragment generators to image engines: fragments.
    pub fragments: u64,
    /// Image engines to fragment generators: pixels of both buffers, or voxels.
    pub pixels: u64,
    /// Fragment generators to texture memory, while voxels are made.
    pub texture: u64,
    /// Over the triangle bus, to make texture memories alike.
    pub merge: u64,
    /// Between texture memories and the host, for the same.
    pub merge_host: u64,
}

/// One of the parts of a machine that work at the same time, each on another cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// "host bus", "geometry engines", "triangle bus", "fragment generators" or "image engines".
    pub name: &'static str,
    /// Cycles in which its busiest unit works.
    pub cycles: u64,
}

/// The work of a machine, and how long it took.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineReport {
    /// Cells and offsets that were voxelized.
    pub passes: u64,
    /// Triangles on the triangle bus.
    pub triangles: u64,
    /// Fragments that image engines got.
    pub fragments: u64,
    /// Pixels that image engines looked at.
    pub examined: u64,
    /// Pixels that a cell had touched.
    pub pixels: u64,
    /// Voxels that were written.
    pub voxels: u64,
    /// Texels that hold something.
    pub texels: u64,
    /// The same in each fragment generator's texture memory, before these are made alike.
    pub owned_texels: Load,
    /// Cycles in which the host's bus carries cells.
    pub host_cycles: u64,
    /// Geometry engines.
    pub geometry: Load,
    /// Cycles in which the triangle bus carries triangles.
    pub triangle_bus_cycles: u64,
    /// Fragment generators, for fragments.
    pub scan_conversion: Load,
    /// Image engines, for fragments, for the search, and to send pixels back.
    pub image_engines: Load,
    /// Interpolation and voxels, in fragment generators or image engines.
    pub interpolation: Load,
    /// The stages, in the order in which a cell goes through them. Fragment generators, or image
    /// engines, make voxels in turn with what else they do.
    pub stages: [Stage; 5],
    /// Cycles until texture memories are alike, once all cells are done.
    pub merge_cycles: u64,
    /// Cycles if all stages always work, each without waiting for another: no fewer are needed.
    pub pipelined_cycles: u64,
    /// Cycles if the parts of a cell's voxelization wait for each other: its fragments, then its
    /// pixels, then its voxels, then the next cell; the stages before them run ahead.
    pub lockstep_cycles: u64,
    /// Bytes over each connection.
    pub buses: Buses,
    /// Bytes of a texel.
    pub texel_bytes: u64,
    /// Bytes of the texture, of which each fragment generator has a copy.
    pub texture_bytes: u64,
    /// Whether that fits.
    pub texture_fits: bool,
    /// Bits of a pixel's frame buffer: two depths and scalars, and with voxels in image engines
    /// those of its column.
    pub pixel_bits: u64,
    /// Whether that fits.
    pub pixel_fits: bool,
    /// Cycles per second.
    pub clock: f64,
}

impl MachineReport {
    /// Volumes per second, at least and at most: by `lockstep_cycles` and `pipelined_cycles`.
    pub fn frames_per_second(&self) -> (f64, f64) {
        let rate = |cycles: u64| self.clock / (cycles + self.merge_cycles).max(1) as f64;
        (rate(self.lockstep_cycles), rate(self.pipelined_cycles))
    }

    /// The part of the machine that takes the greatest part of the time where all stages always
    /// work: the longest stage, or "merge", which comes after them.
    pub fn bound(&self) -> Stage {
        let merge = Stage {
            name: "merge",
            cycles: self.merge_cycles,
        };
        // Among equally long ones, take the first: the maximum is the last of its equals.
        let stages = self.stages.into_iter().chain([merge]).rev();
        let longest = stages.max_by_key(|stage| stage.cycles);
        longest.expect("there are stages")
    }
}

impl fmt::Display for MachineReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let load = |f: &mut fmt::Formatter<'_>, name: &str, load: &Load| {
            writeln!(
                f,
                "{name:<20} {:>12} cycles ({} units, min {}, mean {:.0}, balance {:.2})",
                load.max,
                load.units,
                load.min,
                load.mean,
                load.balance()
            )
        };
        writeln!(
            f,
            "{} passes, {} triangles, {} fragments, {} pixels of {} examined, {} voxels, {} texels",
            self.passes,
            self.triangles,
            self.fragments,
            self.pixels,
            self.examined,
            self.voxels,
            self.texels
        )?;
        writeln!(f, "{:<20} {:>12} cycles", "host bus", self.host_cycles)?;
        load(f, "geometry engines", &self.geometry)?;
        writeln!(
            f,
            "{:<20} {:>12} cycles",
            "triangle bus", self.triangle_bus_cycles
        )?;
        load(f, "scan conversion", &self.scan_conversion)?;
        load(f, "image engines", &self.image_engines)?;
        load(f, "interpolation", &self.interpolation)?;
        writeln!(f, "{:<20} {:>12} cycles", "merge", self.merge_cycles)?;
        writeln!(
            f,
            "{:<20} {:>12} to {} cycles, and the merge",
            "in all", self.pipelined_cycles, self.lockstep_cycles
        )?;
        writeln!(f, "{:<20} {:>12}", "bound by", self.bound().name)?;
        let (least, most) = self.frames_per_second();
        writeln!(f, "{:<20} {least:.1} to {most:.1}", "volumes per second")?;
        let Buses {
            host,
            triangles,
            fragments,
            pixels,
            texture,
            merge,
            merge_host,
        } = self.buses;
        writeln!(
            f,
            "bytes: host {host}, triangles {triangles}, fragments {fragments}, pixels {pixels}, \
             texture {texture}, merge {merge}, merge by the host {merge_host}"
        )?;
        let fits = |fits: bool| if fits { "fits" } else { "does not fit" };
        writeln!(
            f,
            "texture of {} bytes {}, pixel of {} bits {}",
            self.texture_bytes,
            fits(self.texture_fits),
            self.pixel_bits,
            fits(self.pixel_fits)
        )
    }
}
