//! `pack`: a mesh to a file of clusters.

use std::path::PathBuf;

use serde_json::json;
use tetrascope::core::Stop as Never;
use tetrascope::core::clusters::Cut;
use tetrascope::core::number;
use tetrascope::io::tsc;
use tetrascope::volumes;

use crate::args::PackArgs;
use crate::output::{Output, Stop};
use crate::scene::{mesh_source, name, usage};

pub(crate) fn run(args: &PackArgs, output: &Output) -> Result<(), Stop> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => {
            let mut name = args.volume.file_stem().unwrap_or_default().to_owned();
            name.push(".tsc");
            PathBuf::from(name)
        }
    };
    tsc::check_path(&path)?;
    let source = mesh_source(Some(&args.volume), &args.options)?;
    volumes::check(&source).map_err(usage)?;
    let what = format!("loading {}", name(&source));
    let (loaded, load) = output
        .timed(&what, || volumes::load_cells(&source))
        .map_err(|error| match source.dataset {
            // A data set is made as it is asked for.
            Some(_) => usage(error),
            None => error,
        })?;
    for note in &loaded.notes {
        output.note(format_args!("  {note}"));
    }
    let limits = Cut {
        most_cells: args.cluster_cells,
        memory: args.memory,
        stop: Never::new(),
    };
    let what = format!("writing {}", path.display());
    let (packed, write) = output.timed(&what, || tsc::write_tsc(&path, &*loaded.cells, &limits))?;
    let per_cell = packed.bytes as f64 / packed.cells as f64;
    output.note(format_args!(
        "  {} tetrahedra in {}, {per_cell:.1} bytes each",
        packed.cells,
        number::count(packed.clusters, "cluster", "clusters"),
    ));
    if !output.json() {
        return output.written(&path);
    }
    output.json_result(&json!({
        "output": path.to_string_lossy(),
        "tetrahedra": packed.cells,
        "points": packed.points,
        "clusters": packed.clusters,
        "bytes": packed.bytes,
        "notes": loaded.notes,
        "seconds": {"load": load, "write": write},
    }))
}
