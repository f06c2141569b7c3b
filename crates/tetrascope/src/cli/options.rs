//! The options that choose a volume and its look, and those of every command.

use std::path::PathBuf;

use clap::builder::UnknownArgumentValueParser;
use clap::{ArgAction, Args};
use tetrascope_core::colormap::Colormap;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{ByteOrder, Interpolation, RawNumber};
use tetrascope_core::{CameraFit, ClipPlane, OpticalModel};

use super::values::{
    background, byte_orders, camera, clip_plane, colormaps, count, dims, finite, interpolations,
    length, models, range, raw_numbers, size, spacing, strength, tolerance, vector,
};

/// Options of every command.
#[derive(Args)]
pub struct Global {
    /// Print results as JSON on stdout and an error as one JSON line on stderr
    #[arg(long, global = true, display_order = 100)]
    pub json: bool,
    /// Print warnings and errors only
    #[arg(
        short,
        long,
        global = true,
        display_order = 101,
        conflicts_with = "verbose"
    )]
    pub quiet: bool,
    /// Print more: statistics, then with -vv what the graphics driver logs
    #[arg(short, long, global = true, display_order = 102, action = ArgAction::Count)]
    pub verbose: u8,
}

/// A volume and how it looks. Options override the scene file.
#[derive(Args)]
pub struct SceneArgs {
    /// A file with a mesh or a grid, or a data set's name; for a series, several files, a
    /// quoted pattern such as 'step_*.vtu', or a .pvd or .series file
    #[arg(value_name = "FILE|DATASET", required_unless_present = "scene")]
    pub volume: Vec<PathBuf>,
    /// Which volume, beside its name.
    #[command(flatten)]
    pub options: VolumeArgs,
    /// A scene file, TOML or JSON; paths in it start at its folder
    #[arg(short, long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// The optical model
    #[arg(short, long, value_name = "MODEL", value_parser = models())]
    pub model: Option<OpticalModel>,
    /// Pixels, as 640x480, or 512 for a square
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Fit the volume from a side: fit+x, fit-y, fit+iso …
    #[arg(long, value_name = "FIT", value_parser = camera, allow_hyphen_values = true)]
    pub camera: Option<CameraFit>,
    /// Draw with parallel rays
    #[arg(long)]
    pub orthographic: bool,
    /// The color map, in place of a transfer function
    #[arg(long, value_name = "NAME", value_parser = colormaps())]
    pub colormap: Option<Colormap>,
    /// The color map's range, in the field's units
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// The distance over which the color map's opacity counts, world units
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    pub unit_distance: Option<f64>,
    /// Draw the isosurface of this value, and others if repeated
    #[arg(long, value_name = "VALUE", value_parser = finite, allow_hyphen_values = true)]
    pub isovalue: Vec<f64>,
    /// Options that other programs have.
    #[command(flatten)]
    pub elsewhere: Elsewhere,
    /// How much light the farthest point loses, 0 to 1
    #[arg(long, value_name = "STRENGTH", value_parser = strength, allow_hyphen_values = true)]
    pub depth_cue: Option<f64>,
    /// Cut away what is behind the plane through a point with a normal; may be repeated
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", value_parser = clip_plane, allow_hyphen_values = true)]
    pub clip: Vec<ClipPlane>,
    /// black, white, transparent, #RRGGBB or #RGB (sRGB), or linear R,G,B or R,G,B,A [default: transparent;
    /// black for models that only add light]
    #[arg(long, value_name = "COLOR", value_parser = background, allow_hyphen_values = true)]
    pub background: Option<[f32; 4]>,
}

/// Options that other programs have; each is refused with the one that is meant.
#[derive(Args)]
pub struct Elsewhere {
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest("'--unit-distance LENGTH' is the length over which the color map's opacity counts: half of it is twice as opaque"))]
    opacity: Option<String>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest("a scene file has the transfer function, '--scene FILE'; `tetrascope print-scene` prints one to start from"))]
    transfer_function: Option<String>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest("the picture's size is given as '--size 640x480'"))]
    width: Option<String>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest("the picture's size is given as '--size 640x480'"))]
    height: Option<String>,
    #[arg(long, hide = true, aliases = ["iso", "isosurface", "contour"], value_parser = UnknownArgumentValueParser::suggest("a surface is drawn by '--isovalue VALUE'"))]
    isosurfaces: Option<String>,
}

/// Which volume, beside its name.
#[derive(Args)]
pub struct VolumeArgs {
    /// Which of its meshes and fields.
    #[command(flatten)]
    pub source: SourceArgs,
    /// Facts that a grid's file may leave out.
    #[command(flatten)]
    pub grid: GridArgs,
}

/// Which of a file's or a data set's meshes and fields.
#[derive(Args)]
pub struct SourceArgs {
    /// The Plot3D solution of a Plot3D grid [default: found by name]
    #[arg(long, value_name = "FILE")]
    pub solution: Option<PathBuf>,
    /// The field to draw, as `info` lists it, or cell:NAME, point:NAME [default: the first that varies]
    #[arg(short, long, value_name = "NAME")]
    pub field: Option<String>,
    /// The time step of a file that holds several, by its number from 0 [default: the first]
    #[arg(long, value_name = "N", conflicts_with = "time")]
    pub step: Option<usize>,
    /// The time step at this time, in the file's own unit
    #[arg(long, value_name = "TIME", value_parser = finite, allow_hyphen_values = true)]
    pub time: Option<f64>,
    /// How far curved cells may be off, cut into straight ones: in parts of the mesh's diagonal and of the field's range [default: 1e-3, in little memory]
    #[arg(long, value_name = "TOLERANCE", value_parser = tolerance, allow_hyphen_values = true)]
    pub curved: Option<f64>,
    /// About how many cells a data set should have
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true)]
    pub cells: Option<u64>,
    /// The seed of a random data set
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Facts that a grid's file may leave out, and how its samples are joined.
#[derive(Args)]
pub struct GridArgs {
    /// The scalar between a grid's samples [default: linear; nearest for cell data]
    #[arg(long, value_name = "HOW", value_parser = interpolations())]
    pub interpolation: Option<Interpolation>,
    /// Samples along each axis of a raw file, x fastest
    #[arg(long, value_name = "NXxNYxNZ", value_parser = dims, help_heading = RAW)]
    pub dims: Option<[usize; 3]>,
    /// The type of a raw file's numbers
    #[arg(long = "type", value_name = "TYPE", value_parser = raw_numbers(), help_heading = RAW)]
    pub number: Option<RawNumber>,
    /// The distance of samples along each axis, also in .npy, .npz and .tif, world units [default: 1,1,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = spacing, allow_hyphen_values = true, help_heading = RAW)]
    pub spacing: Option<DVec3>,
    /// Where the first sample lies, also in .npy, .npz and .tif, world space [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, help_heading = RAW)]
    pub origin: Option<DVec3>,
    /// Bytes before the first number [default: 0]
    #[arg(long, value_name = "BYTES", help_heading = RAW)]
    pub offset: Option<u64>,
    /// The order of a number's bytes [default: little]
    #[arg(long, value_name = "ORDER", value_parser = byte_orders(), help_heading = RAW)]
    pub byte_order: Option<ByteOrder>,
}

/// The heading of options that say what is in a file of samples alone.
const RAW: &str = "Raw files";
