//! The model of Prakash and Manohar's machine over meshes, sizes, samples and machines.
//!
//! 1. `plan` says what is simulated.
//! 2. Each mesh, size and number of samples runs through machines of each size once; how texture
//!    memories become alike changes nothing else, and is told from that.
//! 3. `result` is what comes out, as `sweep.json` holds it.
//! 4. `section` is the same for people, with `charts`: a page of its own, and a part of that of
//!    `compare`.

mod charts;
mod plan;
pub mod result;
mod section;

use std::path::PathBuf;

use indicatif::ProgressBar;
use tetrascope::core::{Error, TetMesh};
use tetrascope::voxel_hw::machine::{MachineConfig, Merge};
use tetrascope::voxel_hw::{Offsets, VoxelSize, Voxelizer, VoxelizerOptions, voxels_over};

use crate::machine;
use crate::output::{phase, print, progress, write};
use plan::Plan;
use result::{MeshSensitivity, Number, Row, SWEEP_VERSION, Sweep, SweptMesh, Weight};

pub use section::Section;
pub(crate) use section::add_to;

/// Options of the sweep.
#[derive(clap::Args)]
pub struct Options {
    /// Few voxels and one sample in each
    #[arg(long)]
    pub quick: bool,
    /// A file with a mesh, in place of the built-in meshes; may be given again
    #[arg(long = "mesh", value_name = "FILE")]
    pub meshes: Vec<PathBuf>,
    /// The folder of index.html and sweep.json [default: target/machine]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// The file of the numbers in the folder of the page.
const NUMBERS: &str = "sweep.json";

/// Bits of a voxel: the smallest of the paper's, and what its section 7 reckons with.
const BITS: u32 = 8;

/// Simulates, prints the answer and writes the page.
///
/// # Errors
/// Those of a mesh's file, of too little memory, and of files that cannot be written.
pub fn run(options: &Options) -> Result<(), Error> {
    let sweep = sweep(plan::plan(options)?)?;
    let folder = options.out.clone().unwrap_or_else(folder);
    let page = folder.join("index.html");
    write(&folder.join(NUMBERS), sweep.to_json())?;
    let section = Section::new(sweep);
    write(&page, section.to_html())?;
    for sentence in section.answer() {
        print(&format!("{sentence}\n"))?;
    }
    eprintln!("wrote {}", page.display());
    Ok(())
}

/// The section on the last sweep; `None` where there was none, or where it cannot be read, which
/// is said.
pub fn last() -> Option<Section> {
    let path = folder().join(NUMBERS);
    let json = std::fs::read_to_string(&path).ok()?;
    match Sweep::from_json(&json) {
        Ok(sweep) => Some(Section::new(sweep)),
        Err(reason) => {
            let path = path.display();
            eprintln!("{path} is left out: {reason}; `cargo xtask machine` makes it anew");
            None
        }
    }
}

fn folder() -> PathBuf {
    machine::target().join("machine")
}

fn sweep(plan: Plan) -> Result<Sweep, Error> {
    let about = machine::program();
    let progress = progress(plan.steps());
    let mut meshes = Vec::new();
    let mut rows = Vec::new();
    let mut sensitivity = Vec::new();
    for planned in &plan.meshes {
        let name = &planned.name;
        phase(&progress, &format!("{name}: loading"));
        let mesh = planned.load()?;
        meshes.push(SweptMesh {
            name: name.clone(),
            cells: mesh.cell_count(),
            note: planned.note.clone(),
        });
        for &samples in &plan.samples {
            for &side in &plan.sides {
                let what = format!("{name}: {side} voxels, {samples}³ samples each");
                phase(&progress, &what);
                rows.extend(simulate(name, &mesh, side, samples, &progress)?);
            }
        }
        phase(&progress, &format!("{name}: half and twice of each number"));
        sensitivity.push(sensitivity_of(name, &mesh, plan.standard_side())?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let config = MachineConfig::default();
    Ok(Sweep {
        version: SWEEP_VERSION,
        program: format!("{} {}", about.name, about.version),
        revision: about.revision,
        started: about.started,
        command: about.command,
        bits_per_voxel: BITS,
        standard_side: plan.standard_side(),
        standard_generators: config.fragment_generators,
        meshes,
        rows,
        sensitivity,
        machine: Number::all(&config),
    })
}

fn voxelizer(samples: u32) -> Result<Voxelizer, Error> {
    Voxelizer::new(VoxelizerOptions {
        offsets: Offsets::Regular(samples),
        voxel_size: VoxelSize::Bits8,
        ..VoxelizerOptions::default()
    })
}

/// Machines of each size, with both merges.
fn simulate(
    name: &str,
    mesh: &TetMesh,
    side: usize,
    samples: u32,
    progress: &ProgressBar,
) -> Result<Vec<Row>, Error> {
    let voxelizer = voxelizer(samples)?;
    let lattice = voxels_over(&mesh.bounds(), [side; 3])?;
    let mut rows = Vec::new();
    for fragment_generators in plan::GENERATORS {
        let mut config = MachineConfig {
            fragment_generators,
            ..MachineConfig::default()
        };
        let (_, mut report) = voxelizer.simulate(mesh, &lattice, &config)?;
        for (word, merge) in Merge::ALL {
            config.merge = merge;
            report = report.merged(&config);
            rows.push(Row {
                mesh: name.into(),
                side,
                dims: lattice.dims,
                samples,
                generators: fragment_generators,
                merge: word.into(),
                ..Row::of(&report)
            });
        }
        progress.inc(1);
    }
    Ok(rows)
}

fn sensitivity_of(name: &str, mesh: &TetMesh, side: usize) -> Result<MeshSensitivity, Error> {
    let lattice = voxels_over(&mesh.bounds(), [side; 3])?;
    let found = voxelizer(1)?.sensitivity(mesh, &lattice, &MachineConfig::default(), |_| ())?;
    Ok(MeshSensitivity {
        mesh: name.into(),
        dims: lattice.dims,
        weights: found.iter().map(Weight::of).collect(),
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use plan::{Plan, PlannedMesh, Source};

    /// Two small meshes, two sizes, one and 2³ samples: all of it takes a second.
    pub(crate) fn small() -> Sweep {
        let mesh = |name: &str, dataset, cells| PlannedMesh {
            name: name.into(),
            source: Source::Dataset { dataset, cells },
            note: Some("a <note>".into()),
        };
        let plan = Plan {
            meshes: vec![
                mesh("Staircase", "staircase", None),
                mesh("many & small", "sphere", Some(3000)),
            ],
            sides: vec![8, 16],
            samples: vec![1, 2],
        };
        sweep(plan).expect("voxels")
    }

    #[test]
    fn every_configuration_is_there_once() {
        let sweep = small();
        assert_eq!(sweep.rows.len(), 2 * 2 * 2 * 3 * 2);
        let key = |row: &Row| {
            let place = (row.mesh.clone(), row.side, row.samples);
            (place, row.generators, row.merge.clone())
        };
        let mut keys: Vec<_> = sweep.rows.iter().map(key).collect();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), sweep.rows.len());
        assert_eq!(sweep.sensitivity.len(), 2);
    }

    #[test]
    fn json_reads_back_to_the_same() {
        let sweep = small();
        let json = sweep.to_json();
        assert_eq!(Sweep::from_json(&json), Ok(sweep));
        let newer = json.replacen("\"version\": 1", "\"version\": 2", 1);
        let reason = Sweep::from_json(&newer).expect_err("unknown");
        assert!(reason.contains("version 2"), "{reason}");
        assert!(Sweep::from_json("{}").is_err());
    }

    /// A property of the machine as it is, which is deterministic. That no fragment generator is ever busier
    /// among more follows from nothing, as their pixels are others, but the interleaving is meant
    /// for it.
    #[test]
    fn more_generators_are_never_slower() {
        for rows in small().rows.chunks(6) {
            for merge in 0..2 {
                for pair in [
                    rows[merge].clone(),
                    rows[2 + merge].clone(),
                    rows[4 + merge].clone(),
                ]
                .windows(2)
                {
                    assert!(pair[0].generators < pair[1].generators);
                    for bound in 0..2 {
                        let rates = [&pair[0], &pair[1]].map(|row| row.volumes_per_second[bound]);
                        assert!(rates[0] <= rates[1], "{pair:?}");
                    }
                }
            }
        }
    }

    /// Readback moves every voxel three times, v bytes each; broadcast moves those that hold
    /// something once, with 4 bytes of address. So it is more where 3 · voxels · v ≥ texels · (v + 4).
    #[test]
    fn readback_moves_more_where_few_voxels_are_empty() {
        let mut more = 0;
        for pair in small().rows.chunks(2) {
            let [broadcast, readback] = pair else {
                panic!("rows come in pairs");
            };
            let voxels: usize = broadcast.dims.iter().product();
            let bytes = 1 + u64::from(broadcast.samples > 1);
            let by_readback = 3 * voxels as u64 * bytes;
            let by_broadcast = broadcast.texels * (bytes + 4);
            assert_eq!(readback.bytes.merged(), by_readback);
            assert_eq!(broadcast.bytes.merged(), by_broadcast);
            more += u32::from(by_readback >= by_broadcast);
            assert_eq!(readback.bytes.host, broadcast.bytes.host);
        }
        // 23 of 36 parts of the stairs' box hold something: 3 < 5 · 23/36, but 6 > 6 · 23/36.
        assert!(more > 0 && more < 24, "{more}");
    }
}
