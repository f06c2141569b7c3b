//! The results of a sweep: the layout of `sweep.json`.

use serde::{Deserialize, Serialize};
use tetrascope::voxel_hw::machine::{MachineConfig, MachineReport, PARAMETERS, Sensitivity};

/// The version of the layout.
pub const SWEEP_VERSION: u32 = 1;

/// All results, and what they depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// [`SWEEP_VERSION`].
    pub version: u32,
    /// Program and version.
    pub program: String,
    /// The git revision, with "-dirty" where files were changed; `None` outside a checkout.
    pub revision: Option<String>,
    /// When the run began, UTC, as in RFC 3339.
    pub started: String,
    /// The command line.
    pub command: String,
    /// Bits of a voxel's scalar; with several samples 8 bits of coverage come beside it.
    pub bits_per_voxel: u32,
    /// Voxels along the longest axis in the answer and the sensitivities, which have one sample per
    /// voxel and merge by broadcast.
    pub standard_side: usize,
    /// Fragment generators there.
    pub standard_generators: u32,
    /// The meshes that were voxelized.
    pub meshes: Vec<SweptMesh>,
    /// One for each configuration: by mesh, samples, voxels, fragment generators and merge.
    pub rows: Vec<Row>,
    /// One for each mesh.
    pub sensitivity: Vec<MeshSensitivity>,
    /// Every number of the machine.
    pub machine: Vec<Number>,
}

/// A mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptMesh {
    /// Name in rows.
    pub name: String,
    /// How many tetrahedra.
    pub cells: usize,
    /// A remark on it.
    pub note: Option<String>,
}

/// The work of one machine for one volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The mesh's name.
    pub mesh: String,
    /// Voxels along the longest axis.
    pub side: usize,
    /// Voxels along each axis: cubes, no more than the mesh's box needs.
    pub dims: [usize; 3],
    /// Samples along each axis of a voxel.
    pub samples: u32,
    /// Fragment generators.
    pub generators: u32,
    /// "broadcast" or "readback".
    pub merge: String,
    /// At least, where the parts of a cell's voxelization wait for each other, and at most, where
    /// all stages always work.
    pub volumes_per_second: [f64; 2],
    /// The stage, or "merge", that takes the greatest part of the time where all stages always work.
    pub bound: String,
    /// Cycles of each stage, of the merge, and in all.
    pub cycles: Cycles,
    /// Bytes over each connection.
    pub bytes: Bytes,
    /// Voxels that hold something.
    pub texels: u64,
    /// Bytes of the texture.
    pub texture_bytes: u64,
    /// Whether that fits into a texture memory.
    pub texture_fits: bool,
}

/// Cycles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cycles {
    /// The name of each stage and the cycles of its busiest unit.
    pub stages: Vec<(String, u64)>,
    /// Until texture memories are alike, once all cells are done.
    pub merge: u64,
    /// If all stages always work; without the merge.
    pub pipelined: u64,
    /// If the parts of a cell's voxelization wait for each other; without the merge.
    pub lockstep: u64,
}

/// Bytes over each connection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bytes {
    /// Host to geometry engines.
    pub host: u64,
    /// Geometry engines to fragment generators.
    pub triangles: u64,
    /// Fragment generators to image engines.
    pub fragments: u64,
    /// Image engines to fragment generators.
    pub pixels: u64,
    /// Fragment generators to texture memory.
    pub texture: u64,
    /// Over the triangle bus, to make texture memories alike.
    pub merge: u64,
    /// Between texture memories and the host, for the same.
    pub merge_host: u64,
}

impl Bytes {
    /// Bytes that are moved to make texture memories alike.
    pub fn merged(&self) -> u64 {
        self.merge + self.merge_host
    }
}

/// Volumes per second with half and with twice of each number of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshSensitivity {
    /// The mesh's name.
    pub mesh: String,
    /// Voxels along each axis.
    pub dims: [usize; 3],
    /// The strongest first.
    pub weights: Vec<Weight>,
}

/// The weight of one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weight {
    /// The number's name.
    pub name: String,
    /// Its value.
    pub value: u64,
    /// The unit of that.
    pub unit: String,
    /// Volumes per second with half and with twice of it, over those with it.
    pub ratios: [f64; 2],
}

/// A number of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Its name.
    pub name: String,
    /// Its value; for fragment generators, the standard.
    pub value: u64,
    /// The unit of that.
    pub unit: String,
    /// "published", "fitted" or "assumed".
    pub source: String,
    /// An explanation in sentences.
    pub about: String,
}

impl Sweep {
    /// The sweep as JSON.
    pub fn to_json(&self) -> String {
        let mut json = serde_json::to_string_pretty(self).expect("a sweep is plain data");
        json.push('\n');
        json
    }

    /// The sweep in `json`, or the reason in words why it cannot be read.
    ///
    /// # Errors
    /// Another version, and what is not a sweep.
    pub fn from_json(json: &str) -> Result<Sweep, String> {
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let wrong = |error: serde_json::Error| error.to_string();
        let Version { version } = serde_json::from_str(json).map_err(wrong)?;
        if version != SWEEP_VERSION {
            return Err(format!("it has version {version}, not {SWEEP_VERSION}"));
        }
        serde_json::from_str(json).map_err(wrong)
    }

    /// The row of a mesh that the answer is about.
    pub fn standard(&self, mesh: &str) -> Option<&Row> {
        self.rows.iter().find(|row| {
            row.mesh == mesh
                && (row.side, row.samples) == (self.standard_side, 1)
                && (row.generators, row.merge.as_str()) == (self.standard_generators, "broadcast")
        })
    }
}

impl Row {
    /// The numbers of a report; the configuration is still to be named.
    pub(super) fn of(report: &MachineReport) -> Row {
        let (least, most) = report.frames_per_second();
        let stages = report.stages.iter();
        let buses = &report.buses;
        Row {
            volumes_per_second: [least, most],
            bound: report.bound().name.into(),
            cycles: Cycles {
                stages: stages.map(|s| (s.name.into(), s.cycles)).collect(),
                merge: report.merge_cycles,
                pipelined: report.pipelined_cycles,
                lockstep: report.lockstep_cycles,
            },
            bytes: Bytes {
                host: buses.host,
                triangles: buses.triangles,
                fragments: buses.fragments,
                pixels: buses.pixels,
                texture: buses.texture,
                merge: buses.merge,
                merge_host: buses.merge_host,
            },
            texels: report.texels,
            texture_bytes: report.texture_bytes,
            texture_fits: report.texture_fits,
            ..Row::default()
        }
    }
}

impl Weight {
    pub(super) fn of(found: &Sensitivity) -> Weight {
        Weight {
            name: found.name.into(),
            value: found.value,
            unit: found.unit.into(),
            ratios: found.ratios,
        }
    }
}

impl Number {
    pub(super) fn all(config: &MachineConfig) -> Vec<Number> {
        let number = |parameter: &tetrascope::voxel_hw::machine::Parameter| Number {
            name: parameter.name.into(),
            value: parameter.of(config),
            unit: parameter.unit.into(),
            source: parameter.source.name().into(),
            about: parameter.about().into(),
        };
        PARAMETERS.iter().map(number).collect()
    }
}
