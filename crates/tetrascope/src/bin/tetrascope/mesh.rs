//! The mesh that a command takes apart, and what its result is called.

use std::path::PathBuf;

use tetrascope::core::Error;
use tetrascope::scene::VolumeSource;
use tetrascope::volumes::{self, LoadedFields};

use crate::args::MeshArgs;
use crate::output::Output;
use crate::scene;

/// `NAME` and an ending, for a file in this folder.
pub(crate) fn named(mesh: &MeshArgs, ending: &str) -> PathBuf {
    let mut name = mesh.mesh.file_stem().unwrap_or_default().to_owned();
    name.push(ending);
    name.into()
}

/// Loads the mesh with these fields; prints what was found out. Gives the seconds too.
pub(crate) fn load(
    args: &MeshArgs,
    names: Option<&[String]>,
    output: &Output,
) -> Result<(LoadedFields, f64), Error> {
    let named = tetrascope::cli::request::volume(&args.mesh).map_err(scene::usage)?;
    let source = VolumeSource {
        solution: args.solution.clone(),
        cells: args.cells,
        seed: args.seed,
        ..named
    };
    volumes::check(&source).map_err(scene::usage)?;
    let what = format!("loading {}", scene::name(&source));
    let (loaded, seconds) = output.timed(&what, || volumes::load_fields(&source, names))?;
    let fields = loaded
        .fields
        .iter()
        .map(|field| format!("'{}'", field.name));
    let fields: Vec<String> = fields.collect();
    output.note(format_args!(
        "  {} tetrahedra, {}",
        loaded.mesh.cell_count(),
        fields.join(", ")
    ));
    for note in &loaded.notes {
        output.note(format_args!("  {note}"));
    }
    Ok((loaded, seconds))
}
