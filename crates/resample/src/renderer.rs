//! The renderer: a mesh, its samples, and slices of them.

use tetrascope_core::{
    Appearance, Error, Frame, ScalarUnits, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::{Canvas, Commands, Draw, Gpu, Recorded, Target, draw};
use tetrascope_slicing::Slicing;

use crate::counters::SAMPLES;
use crate::entry::mesh_of;
use crate::mesh_slices::MeshSlices;
use crate::options::{Mode, ResamplingOptions};
use crate::renamed;
use crate::resampler::Resampler;

/// Draws a mesh by its samples at the points of a regular lattice, which never leave the device.
///
/// Samples are taken when the mesh changes; frames slice them ([`Slicing`]). Or, in
/// [`Mode::Slices`], by slices of the mesh itself.
#[derive(Debug)]
pub struct Resampling {
    options: ResamplingOptions,
    way: Way,
}

#[derive(Debug)]
enum Way {
    Grid(Box<Gridded>),
    Slices(Box<MeshSlices>),
}

/// A mesh, its samples, and what draws those.
#[derive(Debug)]
struct Gridded {
    /// Those of the samples.
    units: ScalarUnits,
    /// In the field's own units.
    appearance: Appearance,
    resampler: Resampler,
    slicing: Slicing,
    cell_count: usize,
}

impl Resampling {
    /// Uploads the mesh in `volume`, takes its samples and compiles what `appearance` needs.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a grid, and what [`ResamplingOptions::lattice`],
    /// [`Resampler::new`] and [`Slicing::from_device`] refuse.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &ResamplingOptions,
    ) -> Result<Resampling, Error> {
        if options.mode == Mode::Slices {
            let slices = MeshSlices::new(gpu, volume, appearance, &options.mesh_slices())?;
            return Ok(Resampling {
                options: options.clone(),
                way: Way::Slices(Box::new(slices)),
            });
        }
        let gridded = Gridded::new(gpu, mesh_of(volume)?, appearance, options)?;
        Ok(Resampling {
            options: options.clone(),
            way: Way::Grid(Box::new(gridded)),
        })
    }

    /// The mesh and its samples, in [`Mode::Grid`]; those of a field that 32-bit floats hold badly are in
    /// other units than the field ([`ScalarUnits`]).
    pub fn resampler(&self) -> Option<&Resampler> {
        match &self.way {
            Way::Grid(gridded) => Some(&gridded.resampler),
            Way::Slices(_) => None,
        }
    }
}

impl VolumeRenderer for Resampling {
    /// Takes samples of another mesh, whatever it has in common with the one before, and submits
    /// the commands; waits for nothing. Buffers and texture are used again unless there are more
    /// cells or other samples.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let gridded = match &mut self.way {
            Way::Slices(slices) => return slices.reload(volume),
            Way::Grid(gridded) => gridded,
        };
        let mesh = mesh_of(volume)?;
        if self.options.units(mesh) != gridded.units {
            let gpu = gridded.slicing.canvas().gpu();
            let new = Gridded::new(gpu, mesh, &gridded.appearance, &self.options)?;
            **gridded = new;
            return Ok(());
        }
        let lattice = self.options.lattice(mesh)?;
        let mesh = &gridded.units.mesh(mesh);
        gridded.resampler.reload_on(mesh, &lattice)?;
        let resampler = &gridded.resampler;
        gridded
            .slicing
            .reload_made(resampler.grid(), |encoder| resampler.encode(encoder))
            .map_err(renamed)?;
        gridded.cell_count = mesh.cell_count();
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        match &mut self.way {
            Way::Grid(gridded) => gridded.restyle(appearance),
            Way::Slices(slices) => slices.restyle(appearance),
        }
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for Resampling {
    fn canvas(&self) -> &Canvas {
        match &self.way {
            Way::Grid(gridded) => gridded.slicing.canvas(),
            Way::Slices(slices) => slices.canvas(),
        }
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        match &self.way {
            Way::Grid(gridded) => gridded.record(commands, view, target),
            Way::Slices(slices) => slices.record(commands, view, target),
        }
    }
}

impl Gridded {
    fn new(
        gpu: &Gpu,
        mesh: &TetMesh,
        appearance: &Appearance,
        options: &ResamplingOptions,
    ) -> Result<Gridded, Error> {
        let lattice = options.lattice(mesh)?;
        let units = options.units(mesh);
        let (options, mesh) = (options.in_units(&units), units.mesh(mesh));
        let resampler = Resampler::new(gpu, &mesh, &lattice, &options.resampler)?;
        resampler.resample()?;
        let look = units.appearance(appearance);
        let slicing = Slicing::from_device(gpu, resampler.grid(), &look, &options.slicing());
        Ok(Gridded {
            units,
            appearance: appearance.clone(),
            slicing: slicing.map_err(renamed)?,
            resampler,
            cell_count: mesh.cell_count(),
        })
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let look = self.units.appearance(appearance);
        self.slicing.restyle(&look).map_err(renamed)?;
        self.appearance = appearance.clone();
        Ok(())
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        let recorded = self.slicing.record(commands, view, target);
        let mut recorded = recorded.map_err(renamed)?;
        let samples: usize = self.resampler.grid().lattice().dims.iter().product();
        let stats = &mut recorded.stats;
        stats.count(SAMPLES, samples as u64);
        stats.bytes_resident += self.resampler.bytes();
        stats.bytes_per_cell = Some(self.resampler.bytes() as f64 / self.cell_count as f64);
        Ok(recorded)
    }
}
