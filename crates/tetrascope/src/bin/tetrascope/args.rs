//! The command line's arguments.

use std::path::PathBuf;

#[cfg(any(feature = "resample", feature = "voxel-hw"))]
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use clap::{Args, Parser, Subcommand};
use tetrascope::cli::Global;
#[cfg(feature = "resample")]
use tetrascope::cli::values::{background, clip_plane, colormaps, finite, numbers, range};
#[cfg(any(feature = "resample", feature = "voxel-hw"))]
use tetrascope::cli::values::{count, dims};
pub(crate) use tetrascope::cli::{SceneArgs, SourceArgs, VolumeArgs};
use tetrascope::core::clusters::Cut;
#[cfg(feature = "resample")]
use tetrascope::core::colormap::Colormap;
#[cfg(feature = "resample")]
use tetrascope::core::glam::DVec3;
#[cfg(feature = "resample")]
use tetrascope::core::{Bounds, ClipPlane};
#[cfg(feature = "resample")]
use tetrascope::resample::{Passes, ResamplerOptions};
#[cfg(feature = "resample")]
use tetrascope::resampling::Dims;
#[cfg(feature = "voxel-hw")]
use tetrascope::voxel_hw::machine::MachineConfig;
#[cfg(feature = "voxel-hw")]
use tetrascope::voxel_hw::{Arithmetic, Columns, FirstVoxel};

use crate::need::NeedArgs;

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  failure at run time
  2  wrong usage: an unknown option, algorithm or setting, or one that does not fit
  3  input that cannot be read or is invalid: a file, a scene, a field
  4  no suitable GPU, or one of its limits exceeded
A signal ends it as it ends any program (a shell says 130 after Ctrl-C, 143 after `kill`).
A file appears whole or not at all, and nothing else is left of it.

Results go to stdout, progress and messages to stderr. NO_COLOR, RUST_LOG and
WGPU_ADAPTER_NAME are honored.

Examples:
  tetrascope render sphere
  tetrascope render finxyz.bin --field density -o fin.png
  tetrascope render head.nii.gz --range 100,400
  tetrascope render head.raw --dims 256x256x93 --type i16 --spacing 1,1,1.5
  tetrascope render mesh.vtu --camera fit+x --colormap inferno --size 800x600
  tetrascope render mesh.vtu --error 1e-3
  tetrascope render mesh.vtu --budget 16ms --memory 2GB
  tetrascope render 'step_*.vtu' -o frame_%04d.png
  tetrascope view mesh.vtu
  tetrascope convert mesh.msh -o mesh.vtu
  tetrascope pack mesh.vtu -o mesh.tsc
  tetrascope resample mesh.vtu --dims 256 --all-fields -o grid.vti
  tetrascope voxelize mesh.vtu --dims 128 --samples 3 -o grid.vti
  tetrascope slice mesh.vtu --plane 0,0,0,1,1,0 -o slice.png
  tetrascope print-scene mesh.vtu > scene.toml
  tetrascope render --scene scene.toml --algorithm projection -o scene.exr";

/// Draws unstructured meshes and regular grids by published algorithms, and says how exactly.
#[derive(Parser)]
#[command(name = "tetrascope", version, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) global: Global,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Draw a mesh, a grid, a data set or a scene and write the picture
    Render(RenderArgs),
    /// Show a mesh, a grid, a data set or a scene in the browser: turn it, edit colors, save pictures
    #[cfg(feature = "view")]
    View(ViewArgs),
    /// Describe a mesh or a grid: cells, fields, bounds, problems
    Info(InfoArgs),
    /// Write a mesh as .vtu or a grid as .vti, which VTK, ParaView and meshio read
    Convert(ConvertArgs),
    /// Cut a mesh into clusters and write them as a .tsc file, for meshes larger than memory
    Pack(PackArgs),
    /// Take samples of a mesh on a regular grid and write them as a .vti file
    #[cfg(feature = "resample")]
    Resample(ResampleArgs),
    /// Draw the section of a mesh by a plane, or write its samples
    #[cfg(feature = "resample")]
    Slice(SliceArgs),
    /// Make voxels of a mesh between two buffers, on the CPU, and write them as a .vti file
    #[cfg(feature = "voxel-hw")]
    Voxelize(VoxelizeArgs),
    /// Voxelize a mesh in a model of the machine that was proposed for it, and say what it took
    #[cfg(feature = "voxel-hw")]
    Machine(MachineArgs),
    /// List the algorithms, each with its paper and its settings
    Algorithms,
    /// List the file formats: what is read and written, time steps, limits
    Formats,
    /// List the graphics adapters
    Adapters,
    /// List the data sets that need no file
    Datasets,
    /// List the color maps
    Colormaps,
    /// Print the complete scene that `render` would draw, as TOML
    PrintScene(SceneArgs),
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The algorithm; `tetrascope algorithms` lists them
    #[arg(short, long, value_name = "NAME", default_value = tetrascope::raycast_cpu::NAME)]
    pub(crate) algorithm: String,
    /// A quality setting of the algorithm; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    #[command(flatten)]
    pub(crate) need: NeedArgs,
    /// Where to write: .png (sRGB), .exr or .npy (linear floats) [default: NAME.png here];
    /// for a series with %d or %04d, the step's number from 0
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) series: SeriesArgs,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[cfg(feature = "view")]
#[derive(Args)]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The algorithm that draws complete pictures; `tetrascope algorithms` lists them
    #[arg(short, long, value_name = "NAME", default_value = tetrascope::raycast_cpu::NAME)]
    pub(crate) algorithm: String,
    /// A quality setting of the algorithm; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// The port of the page's address; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value_t = 0, help_heading = PAGE)]
    pub(crate) port: u16,
    /// The address to listen at: others than this machine's own let other machines in
    #[arg(long, value_name = "ADDRESS", value_parser = crate::view::address, default_value = "127.0.0.1", help_heading = PAGE)]
    pub(crate) host: std::net::IpAddr,
    /// Print the page's address and open no browser
    #[arg(long, help_heading = PAGE)]
    pub(crate) no_open: bool,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

/// The heading of options for the viewer's page.
#[cfg(feature = "view")]
const PAGE: &str = "Page";

/// Which frames of a series, and what they share.
#[derive(Args)]
pub(crate) struct SeriesArgs {
    /// Leave out frames that are there already, to go on after an interruption
    #[arg(long, help_heading = SERIES)]
    pub(crate) resume: bool,
    /// Draw these steps alone, the last one too; what frames share is still that of all
    #[arg(long, value_name = "FIRST..LAST", value_parser = step_range, help_heading = SERIES)]
    pub(crate) steps: Option<(usize, usize)>,
    /// Choose range, camera and the like for each step, not once for all
    #[arg(long, help_heading = SERIES)]
    pub(crate) each_step: bool,
}

/// The heading of options for series of files.
const SERIES: &str = "Series";

#[derive(Args)]
pub(crate) struct InfoArgs {
    /// A file with a mesh or a grid, or a data set's name
    #[arg(value_name = "FILE|DATASET")]
    pub(crate) volume: PathBuf,
    #[command(flatten)]
    pub(crate) options: VolumeArgs,
}

#[derive(Args)]
pub(crate) struct ConvertArgs {
    /// A file with a mesh or a grid, or a data set's name
    #[arg(value_name = "FILE|DATASET")]
    pub(crate) volume: PathBuf,
    /// Where to write: .vtu for a mesh, .vti for a grid [default: NAME.vtu or NAME.vti here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Compress the file (zlib)
    #[arg(long)]
    pub(crate) compress: bool,
    #[command(flatten)]
    pub(crate) options: VolumeArgs,
}

#[derive(Args)]
pub(crate) struct PackArgs {
    /// A file with a mesh, or a data set's name
    #[arg(value_name = "FILE|DATASET")]
    pub(crate) volume: PathBuf,
    /// Where to write: .tsc [default: NAME.tsc here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// The most tetrahedra of a cluster
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = Cut::default().most_cells)]
    pub(crate) cluster_cells: u32,
    /// Memory for the tetrahedra that are sorted at once, as 2GB or 512MB; a file's mesh takes its own
    #[arg(long, value_name = "SIZE", value_parser = tetrascope::choose::Need::parse_memory, default_value = "1GB", allow_hyphen_values = true)]
    pub(crate) memory: u64,
    #[command(flatten)]
    pub(crate) options: SourceArgs,
}

/// A mesh, and which of its fields.
#[cfg(any(feature = "resample", feature = "voxel-hw"))]
#[derive(Args)]
pub(crate) struct MeshArgs {
    /// A file with a mesh, or a data set's name
    #[arg(value_name = "FILE|DATASET")]
    pub(crate) mesh: PathBuf,
    /// The Plot3D solution of a Plot3D grid [default: found by name]
    #[arg(long, value_name = "FILE")]
    pub(crate) solution: Option<PathBuf>,
    /// About how many cells a data set should have
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true)]
    pub(crate) cells: Option<u64>,
    /// The seed of a random data set
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
}

#[cfg(feature = "resample")]
#[derive(Args)]
pub(crate) struct ResampleArgs {
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// The fields, as `info` lists them: A,B … [default: the first that varies]
    #[arg(
        short,
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        conflicts_with = "all_fields"
    )]
    pub(crate) field: Vec<String>,
    /// Take samples of every scalar field
    #[arg(long)]
    pub(crate) all_fields: bool,
    /// Samples along the longest axis, or NXxNYxNZ, or auto: about one for each point of the mesh
    #[arg(short, long, value_name = "N|NXxNYxNZ|auto", value_parser = sample_dims, default_value = "auto")]
    pub(crate) dims: Dims,
    /// The box in which samples are taken, world space [default: the mesh's]
    #[arg(long, value_name = "X0,X1,Y0,Y1,Z0,Z1", value_parser = region, allow_hyphen_values = true)]
    pub(crate) region: Option<Bounds>,
    /// The value of samples outside of the mesh
    #[arg(long, value_name = "VALUE", value_parser = outside, default_value = "nan", allow_hyphen_values = true)]
    pub(crate) outside: f32,
    /// How samples in cells are found: computed, or drawn as published in one or two passes
    #[arg(long, value_name = "HOW", value_parser = passes(), default_value = "direct")]
    pub(crate) passes: Passes,
    /// Texels along each side of the textures of weights, where samples are drawn
    #[arg(long, value_name = "N", default_value_t = ResamplerOptions::default().weights)]
    pub(crate) weights: u32,
    /// Parts of the grid with a list of cells each, where samples are drawn
    #[arg(long, value_name = "N", default_value_t = ResamplerOptions::default().slabs)]
    pub(crate) slabs: u32,
    /// Where to write: .vti [default: NAME.vti here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Compress the file (zlib)
    #[arg(long)]
    pub(crate) compress: bool,
}

#[cfg(feature = "resample")]
#[derive(Args)]
pub(crate) struct SliceArgs {
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// The field, as `info` lists it [default: the first that varies]
    #[arg(short, long, value_name = "NAME")]
    pub(crate) field: Option<String>,
    /// A point of the plane and its normal, from where it is seen [default: the middle, +z]
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", value_parser = clip_plane, allow_hyphen_values = true)]
    pub(crate) plane: Option<ClipPlane>,
    /// Pixels along the longer side
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value = "512")]
    pub(crate) size: u32,
    /// The color map of a picture
    #[arg(long, value_name = "NAME", value_parser = colormaps(), default_value = Colormap::Viridis.name())]
    pub(crate) colormap: Colormap,
    /// The color map's range, in the field's units [default: the section's]
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub(crate) range: Option<[f64; 2]>,
    /// The color of a picture outside of the mesh
    #[arg(long, value_name = "COLOR", value_parser = background, default_value = "transparent", allow_hyphen_values = true)]
    pub(crate) background: [f32; 4],
    /// Where to write: .png or .exr (a picture), .npy or .vti (numbers) [default: NAME-slice.png here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

/// Which voxels of a mesh.
#[cfg(feature = "voxel-hw")]
#[derive(Args)]
pub(crate) struct VoxelArgs {
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// The field, as `info` lists it [default: the first that varies]
    #[arg(short, long, value_name = "NAME")]
    pub(crate) field: Option<String>,
    /// The most voxels along each axis, or NXxNYxNZ; they are cubes
    #[arg(short, long, value_name = "N|NXxNYxNZ", value_parser = voxel_dims, default_value = "128")]
    pub(crate) dims: [usize; 3],
    /// Samples along each axis of a voxel: their mean is its scalar, their share its coverage
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) samples: u32,
    /// The numbers: published fixed point, or 64-bit floats
    #[arg(long, value_name = "HOW", value_parser = choice(&Arithmetic::ALL), default_value = "fixed-point")]
    pub(crate) arithmetic: Arithmetic,
    /// Voxelize the cells of the file as they are, not their tetrahedra
    #[arg(long)]
    pub(crate) as_given: bool,
    /// The axis along which columns of voxels run: z as published, or the longest
    #[arg(long, value_name = "AXIS", value_parser = choice(&Columns::ALL), default_value = "z")]
    pub(crate) columns: Columns,
    /// The first voxel of a column: rounded as published, or interpolated
    #[arg(long, value_name = "HOW", value_parser = choice(&FirstVoxel::ALL), default_value = "interpolated")]
    pub(crate) first_voxel: FirstVoxel,
}

#[cfg(feature = "voxel-hw")]
#[derive(Args)]
pub(crate) struct VoxelizeArgs {
    #[command(flatten)]
    pub(crate) voxels: VoxelArgs,
    /// Where to write: .vti [default: NAME.vti here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Compress the file (zlib)
    #[arg(long)]
    pub(crate) compress: bool,
}

#[cfg(feature = "voxel-hw")]
#[derive(Args)]
pub(crate) struct MachineArgs {
    #[command(flatten)]
    pub(crate) voxels: VoxelArgs,
    /// Fragment generators; the published machines have 5, 10 and 20
    #[arg(long, value_name = "N", default_value_t = MachineConfig::default().fragment_generators)]
    pub(crate) generators: u32,
    /// Any number of the machine by its name, as the table of results lists them: clock_mhz=100 …
    #[arg(long, value_name = "NAME=N", value_delimiter = ',', value_parser = named_number)]
    pub(crate) config: Vec<(String, u64)>,
    /// Texture memories are made alike by the host, not by broadcast
    #[arg(long)]
    pub(crate) readback: bool,
    /// Image engines make voxels in their frame buffer, not fragment generators
    #[arg(long)]
    pub(crate) in_image_engines: bool,
    /// Halve and double each assumption, and list which moves the answer most
    #[arg(long)]
    pub(crate) sensitivity: bool,
}

/// `3..10`, and each end may be left out.
fn step_range(text: &str) -> Result<(usize, usize), String> {
    let number = |text: &str, otherwise| match text {
        "" => Some(otherwise),
        text => text.parse().ok(),
    };
    let range = text
        .split_once("..")
        .and_then(|(first, last)| Some((number(first, 0)?, number(last, usize::MAX)?)));
    range
        .filter(|(first, last)| first <= last)
        .ok_or_else(|| "give the first and the last step's number, such as 3..10".into())
}

#[cfg(feature = "resample")]
fn passes() -> impl clap::builder::TypedValueParser<Value = Passes> {
    PossibleValuesParser::new(Passes::ALL.map(|(name, _)| name)).map(|name| {
        let found = Passes::ALL.into_iter().find(|(word, _)| *word == name);
        found.expect("one of the possible values").1
    })
}

#[cfg(feature = "voxel-hw")]
fn named_number(text: &str) -> Result<(String, u64), String> {
    let pair = text.split_once('=').map(|(name, n)| (name, n.parse().ok()));
    match pair {
        Some((name, Some(n))) => Ok((name.into(), n)),
        _ => Err("give a name and a whole number, such as clock_mhz=100".into()),
    }
}

#[cfg(feature = "voxel-hw")]
fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [(&'static str, T)],
) -> impl clap::builder::TypedValueParser<Value = T> {
    let words = all.iter().map(|(name, _)| *name);
    PossibleValuesParser::new(words).map(|name| {
        let found = all.iter().find(|(word, _)| *word == name);
        found.expect("one of the possible values").1
    })
}

#[cfg(feature = "voxel-hw")]
fn voxel_dims(text: &str) -> Result<[usize; 3], String> {
    match text.parse() {
        Ok(most) => Ok([most; 3]),
        Err(_) => dims(text)
            .map_err(|_| "give a number, such as 128, or three such numbers, 256x128x64".into()),
    }
}

#[cfg(feature = "resample")]
fn sample_dims(text: &str) -> Result<Dims, String> {
    if text == "auto" {
        return Ok(Dims::Auto);
    }
    match text.parse() {
        Ok(longest) if longest >= 2 => Ok(Dims::Longest(longest)),
        _ => dims(text).map(Dims::Each).map_err(|_| {
            "give 2 or more, such as 256, or three such numbers, 256x128x64, or auto".into()
        }),
    }
}

#[cfg(feature = "resample")]
fn region(text: &str) -> Result<Bounds, String> {
    let numbers = numbers(text).and_then(|n| <[f64; 6]>::try_from(n).ok());
    let [x0, x1, y0, y1, z0, z1] = numbers.ok_or("give six numbers, such as 0,1,-2,2,0,0.5")?;
    let bounds = Bounds {
        min: DVec3::new(x0, y0, z0),
        max: DVec3::new(x1, y1, z1),
    };
    match bounds.min.cmplt(bounds.max).all() {
        true => Ok(bounds),
        false => Err("the first number of each axis is less than its second".into()),
    }
}

#[cfg(feature = "resample")]
fn outside(text: &str) -> Result<f32, String> {
    if text.eq_ignore_ascii_case("nan") {
        return Ok(f32::NAN);
    }
    let number = finite(text).map(|number| number as f32).ok();
    let number = number.filter(|number| number.is_finite());
    number.ok_or_else(|| "give nan, or a number that a 32-bit float holds, such as -1".into())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_options_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn steps_parse_as_documented() {
        assert_eq!(step_range("3..10"), Ok((3, 10)));
        assert_eq!(step_range("3.."), Ok((3, usize::MAX)));
        assert_eq!(step_range("..4"), Ok((0, 4)));
        for wrong in ["", "3", "4..3", "a..b", "-1..2", "1...2"] {
            assert!(step_range(wrong).is_err(), "{wrong}");
        }
    }
}
