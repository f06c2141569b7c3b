//! `voxelize` and `machine`: a mesh to voxels, and what a machine would do for them.

use serde_json::json;
use tetrascope::core::grid::Samples;
use tetrascope::core::{Error, TetMesh, number};
use tetrascope::io::vti::check_path as check_vti_path;
use tetrascope::io::{Compression, write_vti};
use tetrascope::voxel_hw::machine::{
    Load, MachineConfig, Merge, PARAMETERS, Sensitivity, Source, Voxelizing,
};
use tetrascope::voxel_hw::{Cells, Offsets, VoxelVolume, Voxelizer, VoxelizerOptions, voxels_over};

use crate::args::{MachineArgs, VoxelArgs, VoxelizeArgs};
use crate::mesh::{load, named};
use crate::output::{Output, Stop};

/// The array of the share of each voxel that is in the mesh.
const COVERAGE: &str = "coverage";

pub(crate) fn voxelize(args: &VoxelizeArgs, output: &Output) -> Result<(), Stop> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => named(&args.voxels.mesh, ".vti"),
    };
    check_vti_path(&path)?;
    let voxelizer = voxelizer(&args.voxels)?;
    let (mesh, seconds_to_load) = mesh(&args.voxels, output)?;
    let lattice = voxels_over(&mesh.bounds(), args.voxels.dims)?;
    let [nx, ny, nz] = lattice.dims;
    let (volume, seconds) = output.timed(&format!("making {nx}x{ny}x{nz} voxels"), || {
        voxelizer.voxelize(&mesh, &lattice)
    })?;
    say(&volume, output);
    let grid = volume.grid()?;
    let coverage = grid.coverage().map(<[f32]>::to_vec).unwrap_or_default();
    let coverage = Samples::F32(coverage);
    let arrays = [
        (mesh.scalars().name.as_str(), grid.samples()),
        (COVERAGE, &coverage),
    ];
    let compression = match args.compress {
        true => Compression::Zlib,
        false => Compression::None,
    };
    let ((), write) = output.timed(&format!("writing {}", path.display()), || {
        write_vti(&path, &lattice, &arrays, compression)
    })?;
    if !output.json() {
        return output.written(&path);
    }
    let counts = volume.counts();
    output.json_result(&json!({
        "output": path.to_string_lossy(),
        "dims": lattice.dims,
        "origin": lattice.origin.to_array(),
        "spacing": lattice.spacing.to_array(),
        "samples_per_voxel": volume.samples_per_voxel(),
        "cells": counts.cells,
        "writes": counts.writes,
        "overlaps": volume.overlaps(),
        "seconds": {"load": seconds_to_load, "voxelize": seconds, "write": write},
    }))
}

pub(crate) fn machine(args: &MachineArgs, output: &Output) -> Result<(), Stop> {
    let config = config(args)?;
    let voxelizer = voxelizer(&args.voxels)?;
    let (mesh, _) = mesh(&args.voxels, output)?;
    let lattice = voxels_over(&mesh.bounds(), args.voxels.dims)?;
    let [nx, ny, nz] = lattice.dims;
    let what = format!("counting what {nx}x{ny}x{nz} voxels take");
    let ((volume, report), _) =
        output.timed(&what, || voxelizer.simulate(&mesh, &lattice, &config))?;
    say(&volume, output);
    let published = PARAMETERS.iter().filter(|p| p.source == Source::Published);
    output.note(format_args!(
        "  of the machine's {} numbers {} were published; `--sensitivity` lists the others",
        PARAMETERS.len(),
        published.count()
    ));
    let found = match args.sensitivity {
        false => Vec::new(),
        true => {
            let progress = output.progress();
            let done = |share: f64| {
                if let Some(progress) = &progress {
                    progress(share);
                }
            };
            let what = "halving and doubling each assumption";
            let found = || voxelizer.sensitivity(&mesh, &lattice, &config, done);
            output.timed(what, found)?.0
        }
    };
    if !output.json() {
        output.result(report.to_string().trim_end())?;
        return match found.is_empty() {
            true => Ok(()),
            false => output.lines(&table(&found)),
        };
    }
    let sensitivity = found.iter().map(|found| {
        json!({"name": found.name, "value": found.value, "volumes_per_second": found.ratios})
    });
    let machine = PARAMETERS.iter().map(|parameter| {
        json!({
            "name": parameter.name,
            "value": parameter.of(&config),
            "unit": parameter.unit,
            "source": parameter.source.name(),
            "about": parameter.about(),
        })
    });
    let load = |load: &Load| json!({"units": load.units, "min": load.min, "mean": load.mean, "max": load.max});
    let (least, most) = report.frames_per_second();
    let buses = &report.buses;
    output.json_result(&json!({
        "dims": lattice.dims,
        "passes": report.passes,
        "triangles": report.triangles,
        "fragments": report.fragments,
        "pixels_examined": report.examined,
        "pixels": report.pixels,
        "voxels": report.voxels,
        "texels": report.texels,
        "cycles": {
            "host": report.host_cycles,
            "geometry_engines": load(&report.geometry),
            "triangle_bus": report.triangle_bus_cycles,
            "scan_conversion": load(&report.scan_conversion),
            "image_engines": load(&report.image_engines),
            "interpolation": load(&report.interpolation),
            "merge": report.merge_cycles,
            "pipelined": report.pipelined_cycles,
            "lockstep": report.lockstep_cycles,
        },
        "bytes": {
            "host": buses.host,
            "triangles": buses.triangles,
            "fragments": buses.fragments,
            "pixels": buses.pixels,
            "texture": buses.texture,
            "merge": buses.merge,
            "merge_host": buses.merge_host,
        },
        "texture_bytes": report.texture_bytes,
        "texture_fits": report.texture_fits,
        "pixel_bits": report.pixel_bits,
        "pixel_fits": report.pixel_fits,
        "bound": report.bound().name,
        "volumes_per_second": [least, most],
        "machine": machine.collect::<Vec<_>>(),
        "sensitivity": sensitivity.collect::<Vec<_>>(),
    }))
}

/// The machine: that of the defaults, but for what was asked for.
fn config(args: &MachineArgs) -> Result<MachineConfig, Error> {
    let mut config = MachineConfig {
        fragment_generators: args.generators,
        merge: match args.readback {
            true => Merge::Readback,
            false => Merge::Broadcast,
        },
        voxelizing: match args.in_image_engines {
            true => Voxelizing::ImageEngines,
            false => Voxelizing::FragmentGenerators,
        },
        ..MachineConfig::default()
    };
    for (name, value) in &args.config {
        config.set(name, *value)?;
    }
    Ok(config)
}

/// A line for each assumption.
fn table(found: &[Sensitivity]) -> Vec<String> {
    let head =
        "volumes per second, over those above, with half and twice of what was not published";
    let line = |found: &Sensitivity| {
        let [half, twice] = found.ratios;
        format!(
            "{:<30} {:>6} {:<16} {:<8}   {half:.3}   {twice:.3}",
            found.name,
            found.value,
            found.unit,
            found.source.name()
        )
    };
    [head.to_owned()]
        .into_iter()
        .chain(found.iter().map(line))
        .collect()
}

fn voxelizer(args: &VoxelArgs) -> Result<Voxelizer, Error> {
    Voxelizer::new(VoxelizerOptions {
        arithmetic: args.arithmetic,
        cells: match args.as_given {
            true => Cells::AsGiven,
            false => Cells::Tetrahedra,
        },
        columns: args.columns,
        first_voxel: args.first_voxel,
        offsets: Offsets::Regular(args.samples),
        ..VoxelizerOptions::default()
    })
}

/// The mesh with its field, and the seconds that loading took.
fn mesh(args: &VoxelArgs, output: &Output) -> Result<(TetMesh, f64), Error> {
    let names: Vec<String> = args.field.iter().cloned().collect();
    let (loaded, seconds) = load(&args.mesh, Some(&names), output)?;
    Ok((loaded.mesh, seconds))
}

/// Prints what became of cells and voxels.
fn say(volume: &VoxelVolume, output: &Output) {
    let counts = volume.counts();
    let covered = volume.writes().iter().filter(|writes| **writes > 0).count();
    let percent = number::rounded(100.0 * covered as f64 / volume.writes().len() as f64);
    output.note(format_args!(
        "  {covered} voxels have a sample in the mesh, {percent} %"
    ));
    for (count, what) in [
        (counts.without_value, "without a value were left out"),
        (counts.degenerate, "have no volume"),
        (
            counts.inverted,
            "were left out: they are thinner than fixed point tells; see --arithmetic float",
        ),
    ] {
        if count > 0 {
            output.note(format_args!("  {count} cells {what}"));
        }
    }
    let overlaps = volume.overlaps();
    if overlaps > 0 {
        output.note(format_args!(
            "  {overlaps} voxels were written more often than they have samples, as cells overlap; \
             they hold the mean"
        ));
    }
}
