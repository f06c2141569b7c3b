//! The renderer: a mesh, its voxels, and what draws them.

use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::scalar_units::Floats;
use tetrascope_core::{
    Appearance, Error, Frame, ScalarUnits, Settings, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_gpu::{Canvas, Commands, DeviceGrid, Draw, Gpu, Recorded, Target, draw};
use tetrascope_slicing::{Domain, Slicing, SlicingOptions};

use crate::counters::VOXELS;
use crate::device::DeviceVoxelizer;
use crate::entry::{ENTRY, mesh_of};
use crate::interface::{voxels_over, with_border};
use crate::options::{MOST_SIDE, VoxelizerOptions};
use crate::renamed;
use crate::stacks::{Stacks, StacksOptions};
use crate::voxelizer::Voxelizer;

/// The most voxels along the longest axis of a mesh that is drawn: one more lies on each side.
pub const MOST_DRAWN: usize = MOST_SIDE - 2;

/// The textures that voxels are drawn with (section 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Textures {
    /// One of three dimensions, in slices that face the camera ([`Slicing`]).
    #[default]
    Volume,
    /// Three stacks of two dimensions, of which the view takes one ([`Stacks`]).
    Stacks,
}

tetrascope_core::choices! {
    Textures: "volume" = Volume, "stacks" = Stacks;
}

/// Options of [`Voxelization`].
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelizationOptions {
    /// Voxels along the longest axis of the mesh's box, 1 to [`MOST_DRAWN`]; they are cubes. A layer
    /// of empty ones surrounds them, so that all of a voxel on the border is drawn.
    pub voxels: usize,
    /// Where the centers of voxels are instead, for a part of a mesh, or for one that moves: what is
    /// drawn ends at the outermost of them.
    pub lattice: Option<Lattice>,
    /// Where and of which scalars all is that is to be drawn alike, such as the steps of a series;
    /// the voxels' own if there is none. Its scalars are those between which voxels lie.
    pub domain: Option<Domain>,
    /// How voxels are made.
    pub voxelizer: VoxelizerOptions,
    /// The textures that they are drawn with.
    pub textures: Textures,
    /// How they are drawn with [`Textures::Volume`], in `domain`.
    pub slicing: SlicingOptions,
    /// How they are drawn with [`Textures::Stacks`].
    pub stacks: StacksOptions,
}

/// The defaults of [`ENTRY`]'s settings.
impl Default for VoxelizationOptions {
    fn default() -> Self {
        VoxelizationOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

impl VoxelizationOptions {
    /// How voxels are made.
    pub(crate) fn voxelizer(&self) -> Result<Voxelizer, Error> {
        let of_domain = self.domain.and_then(|domain| domain.scalar_range);
        Voxelizer::new(VoxelizerOptions {
            scalar_range: self.voxelizer.scalar_range.or(of_domain),
            ..self.voxelizer
        })
    }

    /// The units in which voxels of `mesh` are made: 32-bit floats hold few values of a field that is
    /// nearly constant.
    fn units(&self, mesh: &TetMesh) -> ScalarUnits {
        let of_domain = self.domain.or(self.slicing.domain).map(|d| d.scalar_range);
        let range = self.voxelizer.scalar_range.map(Some).or(of_domain);
        let range = range.unwrap_or_else(|| mesh.scalar_range());
        ScalarUnits::of_range(range, Floats::F32)
    }

    /// The same of a field in other units.
    fn in_units(&self, units: &ScalarUnits) -> VoxelizationOptions {
        let moved = |domain: Domain| domain.in_units(units);
        let mut options = self.clone();
        options.domain = options.domain.map(moved);
        options.slicing.domain = options.slicing.domain.map(moved);
        let range = options.voxelizer.scalar_range;
        options.voxelizer.scalar_range = range.map(|range| units.range(range));
        options
    }

    /// How they are drawn.
    pub(crate) fn slicing(&self) -> SlicingOptions {
        SlicingOptions {
            domain: self.domain.map(Domain::of_floats).or(self.slicing.domain),
            ..self.slicing.clone()
        }
    }

    /// The centers of the voxels of `mesh`.
    ///
    /// # Errors
    /// Numbers out of range, a mesh without volume, and what [`Lattice::validate`] refuses.
    pub fn lattice(&self, mesh: &TetMesh) -> Result<Lattice, Error> {
        if let Some(lattice) = &self.lattice {
            lattice.validate()?;
            return Ok(*lattice);
        }
        if !(1..=MOST_DRAWN).contains(&self.voxels) {
            return Err(Error::Invalid {
                what: format!("{} voxels along the longest axis", self.voxels),
                help: Some(format!("give 1 to {MOST_DRAWN}; 128 is usual")),
            });
        }
        let inner = voxels_over(&mesh.bounds(), [self.voxels; 3])?;
        with_border(&inner, Interpolation::Linear)
    }
}

/// Draws a mesh by its voxels, which never leave the device.
///
/// Voxels are made when the mesh changes; frames draw their texture.
#[derive(Debug)]
pub struct Voxelization {
    options: VoxelizationOptions,
    /// Those of the voxels.
    units: ScalarUnits,
    /// In the field's own units.
    appearance: Appearance,
    voxelizer: DeviceVoxelizer,
    drawing: Drawing,
    cell_count: usize,
}

/// The renderer of the voxels.
#[derive(Debug)]
enum Drawing {
    Volume(Box<Slicing>),
    Stacks(Box<Stacks>),
}

impl Voxelization {
    /// Uploads the mesh in `volume`, makes its voxels and compiles what `appearance` needs.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a grid, and what [`VoxelizationOptions::lattice`],
    /// [`DeviceVoxelizer::new`], [`Slicing::from_device`] and [`Stacks::from_device`] refuse.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &VoxelizationOptions,
    ) -> Result<Voxelization, Error> {
        let mesh = mesh_of(volume)?;
        let lattice = options.lattice(mesh)?;
        let units = options.units(mesh);
        let (inner, mesh) = (options.in_units(&units), units.mesh(mesh));
        let voxelizer = DeviceVoxelizer::new(gpu, &inner.voxelizer()?, &mesh, &lattice)?;
        voxelizer.voxelize()?;
        let (grid, look) = (voxelizer.grid(), units.appearance(appearance));
        let drawing = match options.textures {
            Textures::Volume => {
                let slicing = Slicing::from_device(gpu, grid, &look, &inner.slicing());
                Drawing::Volume(Box::new(slicing.map_err(renamed)?))
            }
            Textures::Stacks => {
                let stacks = Stacks::from_device(gpu, grid, &look, &options.stacks)?;
                Drawing::Stacks(Box::new(stacks))
            }
        };
        Ok(Voxelization {
            options: options.clone(),
            units,
            appearance: appearance.clone(),
            voxelizer,
            drawing,
            cell_count: mesh.cell_count(),
        })
    }

    /// The mesh and its voxels; those of a field that 32-bit floats hold badly are in other units than the
    /// field ([`ScalarUnits`]).
    pub fn voxelizer(&self) -> &DeviceVoxelizer {
        &self.voxelizer
    }
}

impl Drawing {
    fn reload_made(
        &mut self,
        grid: &DeviceGrid,
        made: impl FnOnce(&mut tetrascope_gpu::wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        match self {
            Drawing::Volume(slicing) => slicing.reload_made(grid, made).map_err(renamed),
            Drawing::Stacks(stacks) => stacks.reload_made(grid, made),
        }
    }
}

impl VolumeRenderer for Voxelization {
    /// Makes the voxels of another mesh, whatever it has in common with the one before, and submits
    /// the commands; waits for nothing. Buffers and textures are used again unless there are more
    /// cells or other voxels.
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let mesh = mesh_of(volume)?;
        if self.options.units(mesh) != self.units {
            let gpu = self.canvas().gpu();
            *self = Voxelization::new(gpu, volume, &self.appearance, &self.options)?;
            return Ok(());
        }
        let lattice = self.options.lattice(mesh)?;
        let mesh = &self.units.mesh(mesh);
        self.voxelizer.reload_on(mesh, &lattice)?;
        let voxelizer = &self.voxelizer;
        self.drawing
            .reload_made(voxelizer.grid(), |encoder| voxelizer.encode(encoder))?;
        self.cell_count = mesh.cell_count();
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let look = self.units.appearance(appearance);
        match &mut self.drawing {
            Drawing::Volume(slicing) => slicing.restyle(&look).map_err(renamed)?,
            Drawing::Stacks(stacks) => stacks.restyle(&look)?,
        }
        self.appearance = appearance.clone();
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        draw::render(self, view)
    }
}

impl Draw for Voxelization {
    fn canvas(&self) -> &Canvas {
        match &self.drawing {
            Drawing::Volume(slicing) => slicing.canvas(),
            Drawing::Stacks(stacks) => stacks.canvas(),
        }
    }

    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        let mut recorded = match &self.drawing {
            Drawing::Volume(slicing) => slicing.record(commands, view, target).map_err(renamed)?,
            Drawing::Stacks(stacks) => stacks.record(commands, view, target)?,
        };
        let voxels: usize = self.voxelizer.grid().lattice().dims.iter().product();
        let stats = &mut recorded.stats;
        stats.count(VOXELS, voxels as u64);
        stats.bytes_resident += self.voxelizer.bytes();
        if let Drawing::Stacks(_) = self.drawing {
            stats.bytes_resident += self.voxelizer.grid().bytes();
        }
        stats.bytes_per_cell = Some(self.voxelizer.bytes() as f64 / self.cell_count as f64);
        Ok(recorded)
    }
}
