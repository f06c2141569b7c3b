//! Which assumption moves the answer most.

use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh};

use super::config::{MachineConfig, PARAMETERS, Source};
use crate::voxelizer::Voxelizer;

/// The effect of one assumption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// As the field of [`MachineConfig`] is called.
    pub name: &'static str,
    /// The assumption's value.
    pub value: u64,
    /// The unit of that.
    pub unit: &'static str,
    /// [`Source::Fitted`] or [`Source::Assumed`].
    pub source: Source,
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
    /// Halves and doubles by itself each number that was not published, and says what becomes of the volumes per second;
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
        let assumed = PARAMETERS.iter().filter(|p| p.source != Source::Published);
        let runs = 1 + 2 * assumed.clone().count();
        let mut all = Vec::new();
        for (index, parameter) in assumed.enumerate() {
            let mut changed = config.clone();
            let value = parameter.of(config);
            let mut ratios = [1.0; 2];
            for (half, other) in [(value / 2).max(1), value.saturating_mul(2)]
                .into_iter()
                .enumerate()
            {
                parameter.set(&mut changed, other);
                ratios[half] = rate(&changed)? / base;
                done((2 * index + half + 2) as f64 / runs as f64);
            }
            all.push(Sensitivity {
                name: parameter.name,
                value,
                unit: parameter.unit,
                source: parameter.source,
                ratios,
            });
        }
        // Those that do nothing stay in the order of the machine's stages.
        all.sort_by(|a, b| b.strength().total_cmp(&a.strength()));
        Ok(all)
    }
}
