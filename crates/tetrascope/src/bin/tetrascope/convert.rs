//! `convert`: a mesh or a grid to a file that other programs read.

use std::path::{Path, PathBuf};

use serde_json::json;
use tetrascope::core::Error;
use tetrascope::core::grid::{Region, Samples};
use tetrascope::io::{
    Compression, FieldSamples, FileData, GridData, MeshData, vti, vtu, write_vti, write_vtu,
};
use tetrascope::volumes;

use crate::args::ConvertArgs;
use crate::output::{Output, Stop};
use crate::scene::{name, source, usage};

pub(crate) fn run(args: &ConvertArgs, output: &Output) -> Result<(), Stop> {
    // What can be refused before the work.
    if let Some(path) = &args.output {
        check_path(path)?;
    }
    let source = source(Some(&args.volume), &args.options)?;
    volumes::check(&source).map_err(usage)?;
    if source.curved.is_some() {
        let what = "`curved` is for drawing: curved cells are written as they are".into();
        let help = Some("leave it out".into());
        return Err(usage(Error::Invalid { what, help }).into());
    }
    let what = format!("loading {}", name(&source));
    let (data, load) = output.timed(&what, || volumes::read(&source))?;
    let path = match &args.output {
        Some(path) => path.clone(),
        None => own_name(&args.volume, &data)?,
    };
    let compression = match args.compress {
        true => Compression::Zlib,
        false => Compression::None,
    };
    let what = format!("writing {}", path.display());
    let field = source.field.as_deref();
    let (written, write) = output.timed(&what, || match data {
        FileData::Mesh(mesh) => write_mesh(&path, mesh, field, compression),
        FileData::Grid(grid) => write_grid(&path, grid, field, compression),
        FileData::Clusters(_) => Err(in_clusters()),
    })?;
    for note in &written.notes {
        output.note(format_args!("  {note}"));
    }
    if !output.json() {
        return output.written(&path);
    }
    output.json_result(&json!({
        "output": path.to_string_lossy(),
        "fields": written.fields,
        "notes": written.notes,
        "seconds": {"load": load, "write": write},
    }))
}

/// The fields of a file that was written, and notes on the way to it and on what it lacks.
struct Written {
    fields: Vec<String>,
    notes: Vec<String>,
}

fn check_path(path: &Path) -> Result<(), Error> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "vtu" => vtu::check_path(path),
        "vti" => vti::check_path(path),
        other => Err(Error::Unknown {
            kind: "format to write",
            name: other.into(),
            valid: vec!["vtu".into(), "vti".into()],
        }),
    }
}

/// The name of the input with another extension, in this folder; refused if that is the input.
fn own_name(volume: &Path, data: &FileData) -> Result<PathBuf, Error> {
    let mut name = volume.file_stem().unwrap_or_default().to_owned();
    name.push(match data {
        FileData::Mesh(_) => ".vtu",
        FileData::Grid(_) => ".vti",
        FileData::Clusters(_) => return Err(in_clusters()),
    });
    let path = PathBuf::from(name);
    let is_input = |real: &PathBuf| volume.canonicalize().is_ok_and(|volume| volume == *real);
    if path.canonicalize().as_ref().is_ok_and(is_input) {
        return Err(Error::Usage {
            what: format!("{} would be written over itself", path.display()),
            help: Some("give another name with --output".into()),
        });
    }
    check_path(&path)?;
    Ok(path)
}

/// The error of a mesh that need not fit in memory.
fn in_clusters() -> Error {
    Error::Usage {
        what: "a mesh in clusters is drawn, and not converted".into(),
        help: Some("convert the file that it was packed from".into()),
    }
}

/// Refuses a file of the wrong kind.
fn check_kind(path: &Path, wanted: &str, holds: &str) -> Result<(), Error> {
    let extension = path.extension().unwrap_or_default();
    match extension.eq_ignore_ascii_case(wanted) {
        true => Ok(()),
        false => Err(Error::Usage {
            what: format!(
                "{} cannot be written: the input holds {holds}",
                path.display()
            ),
            help: Some(format!("give a name that ends in .{wanted}")),
        }),
    }
}

fn write_mesh(
    path: &Path,
    mut mesh: MeshData,
    field: Option<&str>,
    compression: Compression,
) -> Result<Written, Error> {
    check_kind(path, "vtu", "a mesh")?;
    let mut notes = std::mem::take(&mut mesh.notes);
    if field.is_some() {
        let (chosen, note) = mesh.choose(field)?;
        notes.extend(note);
        mesh = mesh.with_field(chosen)?;
    }
    notes.extend(mesh.lost_in_vtu());
    write_vtu(path, &mesh, compression)?;
    let fields = mesh.fields.iter().map(|field| field.name.clone());
    Ok(Written {
        fields: fields.collect(),
        notes,
    })
}

fn write_grid(
    path: &Path,
    mut grid: GridData,
    field: Option<&str>,
    compression: Compression,
) -> Result<Written, Error> {
    check_kind(path, "vti", "a regular grid")?;
    let mut notes = std::mem::take(&mut grid.notes);
    if field.is_some() {
        let (chosen, note) = grid.choose(field)?;
        notes.extend(note);
        grid.fields = vec![grid.fields.swap_remove(chosen)];
    }
    let Some(lattice) = grid.fields.first().map(|field| field.lattice) else {
        return Err(Error::invalid("a grid without a field"));
    };
    if let Some(space) = grid.space {
        notes.push(format!("that positions are in {space} is not written"));
    }
    let mut arrays: Vec<(String, Samples)> = Vec::new();
    for field in grid.fields {
        let mut name = field.name;
        if field.lattice != lattice {
            notes.push(format!(
                "'{name}' is not written: its samples lie elsewhere than those of '{}'; write it alone with --field",
                arrays[0].0
            ));
            continue;
        }
        if field.offset != 0.0 {
            notes.push(format!("'{name}' is written less {}", field.offset));
        }
        while arrays.iter().any(|(other, _)| *other == name) {
            name += " again";
        }
        let samples = match field.samples {
            FieldSamples::Loaded(samples) => samples,
            FieldSamples::Streamed(stream) => stream.source().read(Region {
                low: [0; 3],
                size: lattice.dims,
            })?,
        };
        arrays.push((name, samples));
    }
    let named: Vec<(&str, &Samples)> = arrays.iter().map(|(n, s)| (n.as_str(), s)).collect();
    write_vti(path, &lattice, &named, compression)?;
    Ok(Written {
        fields: arrays.into_iter().map(|(name, _)| name).collect(),
        notes,
    })
}
