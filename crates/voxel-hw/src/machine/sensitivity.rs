//! Which assumption moves the answer most.

use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh};

use super::config::MachineConfig;
use crate::voxelizer::Voxelizer;

/// A number of the machine.
struct Weight {
    /// As the field of [`MachineConfig`] is called.
    name: &'static str,
    of: fn(&mut MachineConfig) -> &mut u32,
}

macro_rules! weights {
    ($($name:ident),+ $(,)?) => {
        &[$(Weight {
            name: stringify!($name),
            of: |config| &mut config.$name,
        }),+]
    };
}

/// Those that [`MachineConfig`] says are assumptions, or made of one.
const ASSUMED: &[Weight] = weights![
    clock_mhz,
    host_bytes_per_cycle,
    corner_bytes,
    geometry_cycles_per_triangle,
    triangle_bus_bytes_per_cycle,
    triangle_bytes,
    setup_cycles,
    fragment_cycles,
    fragment_bytes,
    merge_cycles,
    examine_cycles,
    pixel_bytes,
    link_bytes_per_cycle,
    column_cycles,
    voxel_cycles,
    image_voxel_cycles,
];

/// What one assumption is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// As the field of [`MachineConfig`] is called.
    pub name: &'static str,
    /// What it is.
    pub value: u32,
    /// Volumes per second with half of it (1 at least) and with twice as much, over those with it;
    /// where all stages always work.
    pub ratios: [f64; 2],
}

impl Sensitivity {
    /// By how much it moves the answer: 0 if it does not.
    pub fn strength(&self) -> f64 {
        self.ratios
            .map(|ratio| ratio.ln().abs())
            .into_iter()
            .fold(0.0, f64::max)
    }
}

impl Voxelizer {
    /// Halves and doubles each assumption by itself, and says what becomes of the volumes per second;
    /// the strongest first. Calls `done` with the share of the runs that are done.
    ///
    /// # Errors
    /// As [`Voxelizer::simulate`].
    pub fn sensitivity(
        &self,
        mesh: &TetMesh,
        lattice: &Lattice,
        config: &MachineConfig,
        done: impl Fn(f64),
    ) -> Result<Vec<Sensitivity>, Error> {
        let rate = |config: &MachineConfig| -> Result<f64, Error> {
            let (_, report) = self.simulate(mesh, lattice, config)?;
            Ok(report.frames_per_second().1)
        };
        let base = rate(config)?;
        let runs = 1 + 2 * ASSUMED.len();
        let mut all = Vec::new();
        for (index, weight) in ASSUMED.iter().enumerate() {
            let mut changed = config.clone();
            let value = *(weight.of)(&mut changed);
            let mut ratios = [1.0; 2];
            for (half, other) in [(value / 2).max(1), value.saturating_mul(2)]
                .into_iter()
                .enumerate()
            {
                *(weight.of)(&mut changed) = other;
                ratios[half] = rate(&changed)? / base;
                done((2 * index + half + 2) as f64 / runs as f64);
            }
            all.push(Sensitivity {
                name: weight.name,
                value,
                ratios,
            });
        }
        // Those that do nothing stay in the order of the machine's stages.
        all.sort_by(|a, b| b.strength().total_cmp(&a.strength()));
        Ok(all)
    }
}
