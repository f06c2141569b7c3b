//! The machine's numbers, each with its source.

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

/// Where a number of the machine comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Akeley's abstract says it of the largest RealityEngine, or the paper says it: 353 processors,
    /// which are a command processor, 12 geometry engines, 20 fragment generators and 320 image
    /// engines; over a million triangles and over 240 million pixels per second.
    Published,
    /// Nobody says it, but a published rate comes out with it and the assumptions.
    Fitted,
    /// Nobody says it.
    Assumed,
}

tetrascope_core::choices! {
    Merge: "broadcast" = Broadcast, "readback" = Readback;
    Source: "published" = Published, "fitted" = Fitted, "assumed" = Assumed;
}

impl Source {
    /// "published", "fitted" or "assumed".
    pub fn name(self) -> &'static str {
        let named = Source::ALL.into_iter().find(|(_, source)| *source == self);
        named.expect("every source has a name").0
    }
}

/// A number of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// As the field of [`MachineConfig`] is called.
    pub name: &'static str,
    /// The unit of its value: "cycles", "bytes per cycle", …
    pub unit: &'static str,
    /// Where it comes from.
    pub source: Source,
    /// The field's documentation, each line after a space.
    about: &'static str,
    value: fn(&MachineConfig) -> u64,
    set: fn(&mut MachineConfig, u64),
}

impl Parameter {
    /// An explanation in sentences.
    pub fn about(&self) -> &'static str {
        self.about.trim_start()
    }

    /// Its value in `config`.
    pub fn of(&self, config: &MachineConfig) -> u64 {
        (self.value)(config)
    }

    /// Sets it in `config`, to the greatest that there is if `value` is above that.
    pub(super) fn set(&self, config: &mut MachineConfig, value: u64) {
        (self.set)(config, value);
    }
}

/// The table of numbers becomes the fields of [`MachineConfig`], their defaults and [`PARAMETERS`].
macro_rules! machine {
    ($($(#[doc = $about:literal])+ $name:ident: $type:ty = $default:expr, $unit:literal, $source:ident;)+) => {
        /// A machine. [`PARAMETERS`] says where its numbers come from.
        #[derive(Clone, Debug, PartialEq)]
        pub struct MachineConfig {
            $($(#[doc = $about])+ pub $name: $type,)+
            /// Who writes voxels.
            pub voxelizing: Voxelizing,
            /// How texture memories become alike.
            pub merge: Merge,
        }

        impl Default for MachineConfig {
            fn default() -> Self {
                MachineConfig {
                    $($name: $default,)+
                    voxelizing: Voxelizing::default(),
                    merge: Merge::default(),
                }
            }
        }

        /// Every number of a machine, in the order in which a cell meets them.
        pub const PARAMETERS: &[Parameter] = &[$(Parameter {
            name: stringify!($name),
            unit: $unit,
            source: Source::$source,
            about: concat!($($about),+),
            value: |config| config.$name.into(),
            set: |config, value| config.$name = value.try_into().unwrap_or(<$type>::MAX),
        }),+];
    };
}

machine! {
    /// The clock of all engines and buses.
    clock_mhz: u32 = 50, "MHz", Assumed;
    /// Bandwidth from the host: 100 MB/s.
    host_bytes_per_cycle: u32 = 2, "bytes per cycle", Assumed;
    /// A corner of a cell: three coordinates and a scalar.
    corner_bytes: u32 = 16, "bytes", Assumed;
    /// How many geometry engines share the cells in turn.
    geometry_engines: u32 = 12, "engines", Published;
    /// A triangle's share of transformation, classification and slopes, such that 12 engines make
    /// the published million triangles per second.
    geometry_cycles_per_triangle: u32 = 600, "cycles", Fitted;
    /// Bandwidth of the triangle bus, on which everything reaches all fragment generators:
    /// 250 MB/s.
    triangle_bus_bytes_per_cycle: u32 = 5, "bytes per cycle", Assumed;
    /// A triangle with its slopes, such that the bus carries the published million triangles per
    /// second.
    triangle_bytes: u32 = 240, "bytes", Fitted;
    /// Fragment generators: 5, 10 or 20, on one, two or four boards.
    fragment_generators: u32 = 20, "engines", Published;
    /// A fragment generator's time for a triangle, also for one that has no pixel of it.
    setup_cycles: u32 = 8, "cycles", Assumed;
    /// A fragment generator's time for a fragment, such that 20 make the published 240 million per
    /// second.
    fragment_cycles: u32 = 4, "cycles", Fitted;
    /// Image engines of each fragment generator.
    image_engines: u32 = 16, "engines", Published;
    /// A fragment: pixel, depth and scalar.
    fragment_bytes: u32 = 12, "bytes", Assumed;
    /// An image engine's time for a fragment; 16 engines then keep up with twice their fragment
    /// generator.
    merge_cycles: u32 = 32, "cycles", Assumed;
    /// An image engine's time to see whether a cell touched a pixel: it looks at its pixels in the
    /// cell's rectangle.
    examine_cycles: u32 = 2, "cycles", Assumed;
    /// A pixel that goes back: two depths and two scalars.
    pixel_bytes: u32 = 16, "bytes", Assumed;
    /// Bandwidth from an image engine to its fragment generator.
    link_bytes_per_cycle: u32 = 1, "bytes per cycle", Assumed;
    /// The time to find the increment of a column, a division.
    column_cycles: u32 = 16, "cycles", Assumed;
    /// A fragment generator's time for a voxel: an addition and a write. With several samples per
    /// voxel it reads as well, and takes twice as long.
    voxel_cycles: u32 = 1, "cycles", Assumed;
    /// The same in an image engine, whose memory is slower.
    image_voxel_cycles: u32 = 8, "cycles", Assumed;
    /// Texture memory of each fragment generator, which holds the whole texture: 4 to 16 MB (the
    /// paper's section 7), here 16.
    texture_bytes: u64 = 16 << 20, "bytes", Published;
    /// Frame buffer of each pixel, at most.
    pixel_bits: u32 = 1024, "bits", Published;
}

/// The most engines of a kind: with more the search for an even interleaving takes long.
const MOST_ENGINES: u32 = 1024;

impl MachineConfig {
    /// Sets the number that is called `name` in [`PARAMETERS`].
    ///
    /// # Errors
    /// A name that is not there, and a value that its field does not hold.
    pub fn set(&mut self, name: &str, value: u64) -> Result<(), Error> {
        let found = PARAMETERS.iter().find(|parameter| parameter.name == name);
        let parameter = found.ok_or_else(|| Error::Unknown {
            kind: "number of a machine",
            name: name.into(),
            valid: PARAMETERS.iter().map(|p| p.name.into()).collect(),
        })?;
        parameter.set(self, value);
        match parameter.of(self) == value {
            true => Ok(()),
            false => Err(Error::Usage {
                what: format!("a {name} of {value}"),
                help: Some(format!("give at most {}", parameter.of(self))),
            }),
        }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_the_fields() {
        let mut config = MachineConfig::default();
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let value = 1 + index as u64;
            assert!(!parameter.unit.is_empty() && !parameter.about().starts_with(' '));
            parameter.set(&mut config, value);
            assert_eq!(parameter.of(&config), value);
        }
        let last = PARAMETERS.len() as u32;
        assert_eq!((config.clock_mhz, config.pixel_bits), (1, last));
        let clock = PARAMETERS[0];
        clock.set(&mut config, u64::MAX);
        assert_eq!(clock.of(&config), u64::from(u32::MAX));
        // All that `Debug` prints, but for the two ways to do something.
        let printed = format!("{config:?}").matches(": ").count();
        assert_eq!(printed, PARAMETERS.len() + 2);
    }

    #[test]
    fn numbers_are_set_by_name() {
        let mut config = MachineConfig::default();
        config.set("texture_bytes", 1 << 40).expect("64 bits");
        assert_eq!(config.texture_bytes, 1 << 40);
        for (name, value, word) in [
            ("texture_byte", 1, "no number of a machine 'texture_byte'"),
            ("clock_mhz", 1 << 40, "a clock_mhz of 1099511627776"),
        ] {
            let error = config.set(name, value).expect_err("refused").to_string();
            assert!(error.contains(word), "{error}");
        }
    }

    /// The published rates come out, to which numbers were fitted.
    #[test]
    fn published_rates_come_out() {
        let MachineConfig {
            clock_mhz,
            geometry_engines,
            geometry_cycles_per_triangle,
            triangle_bus_bytes_per_cycle,
            triangle_bytes,
            fragment_generators,
            fragment_cycles,
            image_engines,
            ..
        } = MachineConfig::default();
        // A command processor, and the engines.
        let image_engines = fragment_generators * image_engines;
        assert_eq!(
            1 + geometry_engines + fragment_generators + image_engines,
            353
        );
        // Millions per second.
        assert_eq!(
            clock_mhz * geometry_engines / geometry_cycles_per_triangle,
            1
        );
        assert_eq!(clock_mhz * triangle_bus_bytes_per_cycle / triangle_bytes, 1);
        assert_eq!(clock_mhz * fragment_generators / fragment_cycles, 250);
    }
}
