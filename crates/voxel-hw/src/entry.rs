//! The algorithm's entry: its settings, what it draws, where its error comes from.

use tetrascope_core::entry::Source;
use tetrascope_core::glam::DVec3;
use tetrascope_core::settings::words;
use tetrascope_core::{Entry, Error, OpticalModel, Promise, Setting, Settings, TetMesh, Volume};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_slicing::{
    Integration, MAX_SLICES_PER_VOXEL, MIN_SLICES_PER_VOXEL, Slicing, SlicingOptions,
};

use crate::device::check;
use crate::offsets::{MOST_REGULAR, Offsets};
use crate::options::{Arithmetic, Cells, Columns, FirstVoxel, VoxelSize, VoxelizerOptions};
use crate::renderer::{MOST_DRAWN, Textures, VoxelizationOptions};
use crate::stacks::{self, Stacks, StacksOptions};
use crate::{NAME, renamed};

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "meshes made voxels between two buffers, anti-aliased, which are drawn as textures",
    paper: "C. E. Prakash, S. Manohar, \"Hardware Architecture for Voxelization-based Volume \
            Rendering of Unstructured Grids\", 1995",
    draws: "any mesh in every optical model, as voxels that hold the mean of samples in them and \
            how much of them is in the mesh; each cell by itself, no sorting, no adjacency",
    settings: &[
        Setting::integer("voxels", [1, MOST_DRAWN as i64], "128")
            .about("voxels along the longest axis of the mesh; they are cubes"),
        Setting::integer("samples", [1, MOST_REGULAR as i64], "2").about(
            "samples along each axis of a voxel: their mean is its scalar, and how many are in the \
             mesh its coverage; 1 is aliased",
        ),
        Setting::choice("arithmetic", &words(&Arithmetic::ALL), "fixed-point").about(
            "the numbers in which faces are scan converted: integers as published, in which each \
             voxel center has one owner, or floats, for which no vertex is moved",
        ),
        Setting::choice("cells", &words(&Cells::ALL), "tetrahedra").about(
            "what is voxelized: tetrahedra, or the cells that the mesh was made from, which it \
             has to have kept",
        ),
        Setting::choice("columns", &words(&Columns::ALL), "longest")
            .about("the axis along which columns of voxels run: z as published, or the longest"),
        Setting::choice("first-voxel", &words(&FirstVoxel::ALL), "interpolated").about(
            "the scalar of a column's first voxel: that of the front face as published, or \
             interpolated at its center",
        ),
        Setting::choice("voxel-size", &words(&VoxelSize::ALL), "float")
            .about("bits of a voxel's scalar"),
        Setting::choice("textures", &words(&Textures::ALL), "volume").about(
            "what voxels are drawn with: one texture of three dimensions, or three stacks of two",
        ),
        Setting::number("slices", [MIN_SLICES_PER_VOXEL, MAX_SLICES_PER_VOXEL], "2")
            .about("slices on the shortest way between two voxels, at least; stacks have one"),
        Setting::choice("integration", &words(&Integration::ALL), "slabs").about(
            "what is computed for a slab: its middle's color, or the integral between its ends",
        ),
    ],
    sweep,
    // Voxels do not know what lies between their samples.
    promise: |_| Promise::Open,
    sources: &[
        Source {
            name: "voxels alone",
            with: "voxels=32,slices=8",
            without: None,
        },
        Source {
            name: "slices alone",
            with: "voxels=32",
            without: Some("voxels=32,slices=8"),
        },
        Source {
            name: "aliasing alone",
            with: "voxels=32,samples=1",
            without: Some("voxels=32"),
        },
    ],
    figures: None,
    counters: crate::counters::ALL,
    supports: |volume, appearance, view, settings| {
        let options = VoxelizationOptions::from_settings(settings);
        let mesh = mesh_of(volume)?;
        check(&options.voxelizer)?;
        if options.voxelizer.cells == Cells::AsGiven && mesh.cells().is_none() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "the cells that the mesh was made from".into(),
                reason: "it has not kept them".into(),
            });
        }
        let lattice = options.lattice(mesh)?;
        let texels = Texels::Covered;
        match options.textures {
            Textures::Volume => {
                Slicing::supports_device(&lattice, texels, appearance, view, &options.slicing())
                    .map_err(renamed)
            }
            Textures::Stacks => {
                Stacks::supports(&lattice, texels, appearance, view, &options.stacks)
            }
        }
    },
};

/// The mesh of `volume`, if it can be voxelized.
pub(crate) fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) if mesh.bounds().size().cmpgt(DVec3::ZERO).all() => Ok(mesh),
        Volume::Mesh(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes without volume".into(),
            reason: "there is nothing to make voxels of".into(),
        }),
        Volume::Clusters(_) => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes in clusters".into(),
            reason: "it needs all cells at once".into(),
        }),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "regular grids".into(),
            reason: "it makes one of a mesh".into(),
        }),
    }
}

/// Few voxels with few slices and with so many that they no longer matter, and aliased; then more of
/// them, and stacks. Other models differ in the voxels alone.
fn sweep(model: OpticalModel) -> &'static [&'static str] {
    match model {
        OpticalModel::EmissionAbsorption => &[
            "voxels=32",
            "voxels=32,slices=8",
            "voxels=32,samples=1",
            "voxels=64",
            "voxels=64,textures=stacks",
            "voxels=128,samples=1",
        ],
        _ => &["voxels=32", "voxels=64,samples=1"],
    }
}

impl VoxelizationOptions {
    /// The options that `settings` of [`ENTRY`] say.
    pub fn from_settings(settings: &Settings) -> VoxelizationOptions {
        let integration = settings.choice("integration", &Integration::ALL);
        VoxelizationOptions {
            voxels: settings.integer("voxels") as usize,
            lattice: None,
            domain: None,
            voxelizer: VoxelizerOptions {
                arithmetic: settings.choice("arithmetic", &Arithmetic::ALL),
                cells: settings.choice("cells", &Cells::ALL),
                columns: settings.choice("columns", &Columns::ALL),
                first_voxel: settings.choice("first-voxel", &FirstVoxel::ALL),
                offsets: Offsets::Regular(settings.integer("samples") as u32),
                voxel_size: settings.choice("voxel-size", &VoxelSize::ALL),
                scalar_range: None,
            },
            textures: settings.choice("textures", &Textures::ALL),
            slicing: SlicingOptions {
                slices_per_voxel: settings.number("slices"),
                integration,
                ..SlicingOptions::default()
            },
            stacks: StacksOptions {
                integration: match integration {
                    Integration::Slabs => stacks::Integration::Slabs,
                    Integration::PostClassified => stacks::Integration::Slices,
                },
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::CameraFit;
    use tetrascope_testing::{
        Place, every_setting_arrives, fitted, grid, kuhn, mesh, ramp, refusal,
    };

    use super::*;

    #[test]
    fn every_setting_arrives_in_the_options() {
        every_setting_arrives(&ENTRY, VoxelizationOptions::from_settings);
    }

    #[test]
    fn what_is_not_drawn_is_refused_without_a_device() {
        let cube = || kuhn(1, DVec3::ZERO, DVec3::ONE, |_| true);
        let regular = Volume::Grid(grid(&Place::unit(4), |p| p.x));
        let (mut points, cells) = cube();
        points.iter_mut().for_each(|p| p.z = 0.0);
        let flat = Volume::Mesh(mesh((points, cells), |p| p.x));
        let whole = Volume::Mesh(mesh(cube(), |p| p.x));
        let view = fitted(&whole, CameraFit::PlusIso, false, 8);
        for (volume, settings, what) in [
            (&regular, "", "makes one of a mesh"),
            (&flat, "", "without volume"),
            (&whole, "cells=as-given", "has not kept them"),
            (
                &whole,
                "cells=as-given,arithmetic=float",
                "floats are for tetrahedra",
            ),
        ] {
            let why = refusal(&ENTRY, settings, (volume, &ramp(&whole), &view));
            assert!(why.contains(what), "{why}");
        }
    }
}
