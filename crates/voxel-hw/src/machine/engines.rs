//! The engines: what each has to do, and the texture memory of each fragment generator.

use std::collections::BTreeMap;
use std::ops::Range;

use tetrascope_core::Error;
use tetrascope_core::grid::Lattice;

use super::config::{MachineConfig, Voxelizing};
use super::interleave::Interleave;
use super::report::{Buses, Load, MachineReport, Stage};
use crate::cell::{Events, Side};
use crate::options::{VoxelSize, voxel_count};
use crate::space::Space;
use crate::volume::VoxelVolume;
use crate::voxelizer::{AccumulationBuffer, Counts, Target, Voxelizer};

/// A sum of scalars and how many they are.
type Texel = (u64, u32);

/// Cycles of units of a kind: in all, and for the present cell.
#[derive(Debug)]
struct Clocks {
    total: Vec<u64>,
    now: Vec<u64>,
}

impl Clocks {
    fn new(units: u32) -> Clocks {
        Clocks {
            total: vec![0; units as usize],
            now: vec![0; units as usize],
        }
    }

    fn spend(&mut self, unit: usize, cycles: u64) {
        self.total[unit] += cycles;
        self.now[unit] += cycles;
    }

    /// The busiest unit's cycles for the cell that ends.
    fn end_cell(&mut self) -> u64 {
        let most = self.now.iter().copied().max().unwrap_or(0);
        self.now.fill(0);
        most
    }
}

/// A texture memory: the columns of texels over the pixels that cells have touched, by pixel.
type Texture = BTreeMap<usize, Vec<Texel>>;

/// The texels of a texture that hold something, each as voxel (x, y, z).
fn texels(texture: &Texture, [nx, _, _]: [usize; 3]) -> impl Iterator<Item = ([i32; 3], Texel)> {
    texture.iter().flat_map(move |(pixel, column)| {
        let (x, y) = ((pixel % nx) as i32, (pixel / nx) as i32);
        let texels = column.iter().enumerate();
        let held = texels.filter(|(_, (_, writes))| *writes > 0);
        held.map(move |(z, texel)| ([x, y, z as i32], *texel))
    })
}

/// A machine at work.
#[derive(Debug)]
pub(super) struct Engines<'a> {
    config: &'a MachineConfig,
    interleave: Interleave,
    space: Space,
    range: (f64, f64),
    samples: u64,
    texel_bytes: u64,
    counts: Counts,

    geometry: Vec<u64>,
    next_geometry: usize,
    scan_conversion: Clocks,
    merging: Clocks,
    returning: Clocks,
    interpolation: Clocks,
    lockstep: u64,

    /// The content of each fragment generator: texels of its own pixels.
    textures: Vec<Texture>,
    passes: u64,
    triangles: u64,
    fragments: u64,
    examined: u64,
    pixels: u64,
    buses: Buses,
}

impl<'a> Engines<'a> {
    pub(super) fn new(
        voxelizer: &Voxelizer,
        lattice: &Lattice,
        range: (f64, f64),
        config: &'a MachineConfig,
    ) -> Result<Engines<'a>, Error> {
        lattice.validate()?;
        voxel_count(lattice.dims)?;
        let samples = voxelizer.offsets().len() as u64;
        let scalar_bytes = match voxelizer.options().voxel_size {
            VoxelSize::Bits8 => 1,
            VoxelSize::Bits16 => 2,
            VoxelSize::Bits32 | VoxelSize::Float => 4,
        };
        let generators = config.fragment_generators;
        let images = generators * config.image_engines;
        Ok(Engines {
            config,
            interleave: Interleave::new(generators, config.image_engines),
            space: Space::new(lattice, voxelizer.options().columns),
            range,
            samples,
            // A byte of coverage, where it is not all or nothing.
            texel_bytes: scalar_bytes + u64::from(samples > 1),
            counts: Counts::default(),
            geometry: vec![0; config.geometry_engines as usize],
            next_geometry: 0,
            scan_conversion: Clocks::new(generators),
            merging: Clocks::new(images),
            returning: Clocks::new(images),
            interpolation: Clocks::new(match config.voxelizing {
                Voxelizing::FragmentGenerators => generators,
                Voxelizing::ImageEngines => images,
            }),
            lockstep: 0,
            textures: vec![Texture::new(); generators as usize],
            passes: 0,
            triangles: 0,
            fragments: 0,
            examined: 0,
            pixels: 0,
            buses: Buses::default(),
        })
    }

    /// Who fills the column of a pixel.
    fn interpolator(&self, engine: usize) -> usize {
        match self.config.voxelizing {
            Voxelizing::FragmentGenerators => self.interleave.generator(engine),
            Voxelizing::ImageEngines => engine,
        }
    }

    /// Makes the texture memories alike, and reports.
    pub(super) fn finish(
        mut self,
        voxelizer: &Voxelizer,
    ) -> Result<(VoxelVolume, MachineReport), Error> {
        let config = self.config;
        let dims = self.space.dims();
        let owned = self.textures.iter().map(|t| texels(t, dims).count() as u64);
        let owned: Vec<u64> = owned.collect();
        let held = owned.iter().sum();
        if config.voxelizing == Voxelizing::ImageEngines {
            // What was made in frame buffers is moved into texture memory, once.
            let bytes = held * self.texel_bytes;
            self.buses.pixels += bytes;
            self.buses.texture += bytes;
            for ([x, y, _], _) in self.textures.iter().flat_map(|t| texels(t, dims)) {
                let engine = self.interleave.engine((x, y));
                let cycles = self
                    .texel_bytes
                    .div_ceil(config.link_bytes_per_cycle.into());
                self.returning.total[engine] += cycles;
                self.returning.now[engine] += cycles;
            }
            self.lockstep += self.returning.end_cell();
        }

        let bus = u64::from(config.triangle_bus_bytes_per_cycle);
        let host = u64::from(config.host_bytes_per_cycle);
        // Pixels are apart, so texels of different fragment generators never meet.
        let mut merged = AccumulationBuffer::new(self.space, self.range)?;
        *merged.counts() = self.counts;
        for texture in std::mem::take(&mut self.textures) {
            for (at, (sum, writes)) in texels(&texture, dims) {
                merged.add(self.space.index(at), sum, writes);
            }
        }

        let add =
            |a: &[u64], b: &[u64]| -> Vec<u64> { a.iter().zip(b).map(|(a, b)| a + b).collect() };
        let image_engines = add(&self.merging.total, &self.returning.total);
        let host_cycles = self.buses.host.div_ceil(host);
        let bus_cycles = self.buses.triangles.div_ceil(bus);
        // Interpolation takes its turns with what else its engine does.
        let (generators, images) = match config.voxelizing {
            Voxelizing::FragmentGenerators => (
                add(&self.scan_conversion.total, &self.interpolation.total),
                image_engines.clone(),
            ),
            Voxelizing::ImageEngines => (
                self.scan_conversion.total.clone(),
                add(&image_engines, &self.interpolation.total),
            ),
        };
        let geometry = Load::of(&self.geometry);
        let stages = [
            ("host bus", host_cycles),
            ("geometry engines", geometry.max),
            ("triangle bus", bus_cycles),
            ("fragment generators", Load::of(&generators).max),
            ("image engines", Load::of(&images).max),
        ];
        let stages = stages.map(|(name, cycles)| Stage { name, cycles });
        let longest = |stages: &[Stage]| stages.iter().map(|stage| stage.cycles).max();
        let ahead = longest(&stages[..3]).expect("three stages run ahead");
        let pipelined = longest(&stages).expect("five stages");
        let column_bits = match config.voxelizing {
            Voxelizing::FragmentGenerators => 0,
            Voxelizing::ImageEngines => self.space.dims()[2] as u64 * 8 * self.texel_bytes,
        };
        let pixel_bits = 8 * u64::from(config.pixel_bytes) + column_bits;
        let texture_bytes = voxel_count(dims)? as u64 * self.texel_bytes;
        let report = MachineReport {
            passes: self.passes,
            triangles: self.triangles,
            fragments: self.fragments,
            examined: self.examined,
            pixels: self.pixels,
            voxels: self.counts.writes,
            texels: held,
            owned_texels: Load::of(&owned),
            host_cycles,
            geometry,
            triangle_bus_cycles: bus_cycles,
            scan_conversion: Load::of(&self.scan_conversion.total),
            image_engines: Load::of(&image_engines),
            interpolation: Load::of(&self.interpolation.total),
            stages,
            merge_cycles: 0,
            pipelined_cycles: pipelined,
            lockstep_cycles: ahead.max(self.lockstep),
            buses: self.buses,
            texel_bytes: self.texel_bytes,
            texture_bytes,
            texture_fits: texture_bytes <= config.texture_bytes,
            pixel_bits,
            pixel_fits: pixel_bits <= config.pixel_bits.into(),
            clock: f64::from(config.clock_mhz) * 1e6,
        };
        Ok((merged.finish(voxelizer)?, report.merged(config)))
    }
}

impl Target for Engines<'_> {
    fn space(&self) -> &Space {
        &self.space
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }

    fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }
}

impl Events for Engines<'_> {
    fn cell(&mut self, corners: usize, triangles: usize) {
        // The grid is sent again for each offset.
        let corners = corners as u64 * u64::from(self.config.corner_bytes);
        self.buses.host += self.samples * corners;
        let cycles = triangles as u64 * u64::from(self.config.geometry_cycles_per_triangle);
        for _ in 0..self.samples {
            self.geometry[self.next_geometry] += cycles;
            self.next_geometry = (self.next_geometry + 1) % self.geometry.len();
        }
    }

    fn face(&mut self, _: Side) {
        self.counts.faces += 1;
        self.triangles += 1;
        self.buses.triangles += u64::from(self.config.triangle_bytes);
        for generator in 0..self.textures.len() {
            self.scan_conversion
                .spend(generator, self.config.setup_cycles.into());
        }
    }

    fn fragment(&mut self, _: Side, pixel: (i32, i32)) {
        self.counts.fragments += 1;
        let engine = self.interleave.engine(pixel);
        let generator = self.interleave.generator(engine);
        self.scan_conversion
            .spend(generator, self.config.fragment_cycles.into());
        self.buses.fragments += u64::from(self.config.fragment_bytes);
        self.merging.spend(engine, self.config.merge_cycles.into());
        self.fragments += 1;
    }

    fn faces_end(&mut self, columns: Range<i32>, rows: Range<i32>) {
        for pixel in rows.flat_map(|row| columns.clone().map(move |column| (column, row))) {
            let engine = self.interleave.engine(pixel);
            self.returning
                .spend(engine, self.config.examine_cycles.into());
            self.examined += 1;
        }
    }

    fn column(&mut self, pixel: (i32, i32), voxels: u32) {
        self.counts.columns += 1;
        self.counts.writes += u64::from(voxels);
        self.pixels += 1;
        let engine = self.interleave.engine(pixel);
        let config = self.config;
        // With several samples a texel is read before it is written (section 5.4).
        let accesses = 1 + u64::from(self.samples > 1);
        let cycles_per_voxel = match config.voxelizing {
            Voxelizing::FragmentGenerators => {
                let bytes = u64::from(config.pixel_bytes);
                self.buses.pixels += bytes;
                let cycles = bytes.div_ceil(config.link_bytes_per_cycle.into());
                self.returning.spend(engine, cycles);
                self.buses.texture += u64::from(voxels) * accesses * self.texel_bytes;
                config.voxel_cycles
            }
            Voxelizing::ImageEngines => config.image_voxel_cycles,
        };
        let cycles = u64::from(config.column_cycles)
            + u64::from(voxels) * accesses * u64::from(cycles_per_voxel);
        self.interpolation.spend(self.interpolator(engine), cycles);
    }

    fn voxel(&mut self, at: [i32; 3], scalar: u32) {
        let [x, y, z] = at;
        let generator = self.interleave.generator(self.interleave.engine((x, y)));
        let [nx, _, nz] = self.space.dims();
        let column = self.textures[generator]
            .entry(x as usize + nx * y as usize)
            .or_insert_with(|| vec![Texel::default(); nz]);
        let texel = &mut column[z as usize];
        texel.0 += u64::from(scalar);
        texel.1 += 1;
    }

    fn cell_end(&mut self) {
        self.passes += 1;
        // Image engines take fragments while these are made.
        let fragments = self.scan_conversion.end_cell();
        self.lockstep += fragments.max(self.merging.end_cell())
            + self.returning.end_cell()
            + self.interpolation.end_cell();
    }
}
